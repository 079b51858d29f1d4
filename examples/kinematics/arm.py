"""A six-axis arm from a URDF file: forward and inverse kinematics, Jacobian, singular poses, a straight way.

    python examples/kinematics/arm.py --out kinematics

Needs the extra `urdf`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bladesmith import kinematics
from bladesmith.kinematics.io.reader import load_mechanism

HERE = Path(__file__).resolve().parent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("kinematics"), metavar="FOLDER")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)

    robot = kinematics.load_urdf(kinematics.urdf_example("arm"))
    chain = robot.chain("flange")
    print(chain, "with a reach of", round(chain.reach, 4), "m")

    q = np.radians([20.0, -70.0, 90.0, -110.0, -90.0, 0.0])
    pose = chain.forward(q)
    found = chain.inverse(pose, start=q + 0.3)
    print(f"found {np.degrees(found.q).round(3)} degrees in {found.steps} steps, off by {found.distance:.2g} m")
    print("twist of the flange for unit speeds:", chain.velocity(q, np.ones(6)))

    straight = chain.singularity(np.radians([20.0, -70.0, 0.0, -110.0, -90.0, 0.0]))
    print(f"arm stretched out: rank {straight.rank}, lost {straight.lost_twist}")

    rng = np.random.default_rng(7)
    poses = chain.forward(rng.uniform(-3, 3, (1000, 6)))
    solved = chain.inverse(poses, threads=None)
    print(f"inverse kinematics of 1000 random poses: {int(np.isin(solved.status, (0, 3)).sum())} found")

    setup = load_mechanism(HERE / "arm.toml")
    motion = setup.motion()
    print("along the line the joints need", np.abs(motion.speeds).max(0).round(3), "rad/s at most")
    motion.save(out / "arm_line.csv")
    setup.picture(out / "arm_line.png", setup.motion_with_poses())


if __name__ == "__main__":
    main()
