"""A Delta robot: angles for a position and back, both Jacobians by two methods, singular poses, a motion (thesis 7.7).

python examples/kinematics/delta.py --out kinematics
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bladesmith import Status, kinematics

ROBOT = kinematics.DeltaRobot(base_radius=0.4, effector_radius=0.15, upper_arm=0.6, forearm=1.2)


def circle(t: float) -> np.ndarray:
    """Once around in a second."""
    return np.array([0.35 * np.cos(2 * np.pi * t), 0.35 * np.sin(2 * np.pi * t), 1.2])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("kinematics"), metavar="FOLDER")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)

    y = np.array([0.2, -0.1, 1.2])
    theta = ROBOT.inverse(y)
    print("platform at", y, "with angles", theta.round(6), "and back at", ROBOT.forward(theta).round(12))
    direct, screw = (ROBOT.forward_jacobian(theta, method) for method in ("direct", "screw"))
    print("Jacobian by differentiation and by screws differ by", np.abs(direct - screw).max())
    print("J J* - 1 is", np.abs(direct @ ROBOT.inverse_jacobian(y) - np.eye(3)).max())

    far = np.array([[0.2, -0.1, 1.2], [1.4, 0.0, 1.0]])
    _, status = ROBOT.inverse(far, status=True)
    for place, code, arms in zip(far, status, ROBOT.arm_status(far), strict=True):
        print("platform at", place, Status(int(code)).name, [Status(int(x)).name for x in arms])

    rng = np.random.default_rng(7)
    many = np.column_stack([rng.uniform(-0.4, 0.4, (100_000, 2)), rng.uniform(0.9, 1.4, 100_000)])
    angles, status = ROBOT.inverse(many, status=True)
    print(f"{len(many)} positions in one call, {int((status == Status.OK).sum())} reached")

    motion = ROBOT.trajectory(circle, np.linspace(0.0, 1.0, 201))
    print("around the circle the motors need", np.abs(motion.speed).max(0).round(3), "rad/s at most")
    ROBOT.picture(y=motion.position[::25], path=out / "delta_poses.png")
    motion.plot(out / "delta_curves.png")


if __name__ == "__main__":
    main()
