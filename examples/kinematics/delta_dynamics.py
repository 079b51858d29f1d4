"""A Delta robot falls: eleven bodies and fifteen joints, simulated as they are (thesis 7.7 on chapter 6's equations).

    python examples/kinematics/delta_dynamics.py --out kinematics

First its motors are without power; then they hold it against gravity, by the torques that the Jacobian gives.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bladesmith import dynamics, kinematics
from bladesmith.kinematics.delta.geometry import axes

ROBOT = kinematics.DeltaRobot(base_radius=0.4, effector_radius=0.15, upper_arm=0.6, forearm=1.2)
DOWN = (0.0, 0.0, 9.81)  # e3 points from the base to the workspace
MASSES = (1.0, 0.3, 2.0)  # of an upper arm, a rod, the platform


def holding(theta: np.ndarray) -> np.ndarray:
    """Torques of the motors that hold the robot at rest: against the power of gravity for a unit speed of each."""
    arm, rod, platform = MASSES
    jacobian = ROBOT.forward_jacobian(theta)
    elbow = ROBOT.upper_arm * np.cos(theta)  # how fast each elbow goes down for a unit speed of its motor
    centres = arm * elbow / 2 + 2 * rod * elbow / 2
    down = jacobian[2] * (platform + 6 * rod / 2)
    return -9.81 * (centres + down)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("kinematics"), metavar="FOLDER")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)

    theta = np.array([0.2, 0.4, 0.3])
    system = ROBOT.system(theta, MASSES)
    fall = dynamics.Simulation(system, [dynamics.Gravity(DOWN)]).run(0.4, times=np.linspace(0, 0.4, 41))
    begin, end = fall["platform"].position[[0, -1]]
    print(f"falling: the platform from {begin.round(3)} to {end.round(3)}")
    print(f"  energy varies by {np.ptp(fall.energy):.2g}, the joints are {fall.violation.max():.2g} off at most")

    torques = holding(theta)
    motors = [
        dynamics.WorldWrench(dynamics.couple(torque * axis), f"upper_arm_{i + 1}")
        for i, (torque, axis) in enumerate(zip(torques, axes(), strict=True))
    ]
    held = dynamics.Simulation(system, [dynamics.Gravity(DOWN), *motors]).run(0.4, times=np.linspace(0, 0.4, 5))
    moved = np.abs(held["platform"].position - held["platform"].position[0]).max()
    print(f"held by {torques.round(3)} N m: the platform moves by {moved:.2g}")

    ROBOT.picture(y=fall["platform"].position[::8], path=out / "delta_falling.png")


if __name__ == "__main__":
    main()
