"""An arm from its maker's file follows a path under a computed-torque controller, a thousand times a second.

    python examples/dynamics/computed_torque.py --out dynamics
    python examples/dynamics/computed_torque.py --urdf ur5_robot.urdf
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np

from bladesmith import dynamics, kinematics

#: Feedback of errors and of their rates: critically damped, 20 radians a second.
STIFFNESS, DAMPING = 400.0, 40.0
GRAVITY = (0.0, 0.0, -9.81)


def follow(robot: kinematics.Robot, duration: float = 4.0, dt: float = 1e-3) -> dict[str, Any]:
    """Simulate it: arrays of times, states, accelerations that are wanted, errors, torques; and the seconds it took."""
    stepper = dynamics.Simulation(robot.system(), [dynamics.Gravity(GRAVITY)]).stepper(dt)
    model, state = robot.bound(gravity=GRAVITY), stepper.start
    pace = np.linspace(1.0, 2.0, len(stepper.names))  # of a swing of every joint, by half a radian and back
    rows = []
    begin = time.perf_counter()
    for _ in range(round(duration / dt)):
        sine, cosine = np.sin(pace * state.time), np.cos(pace * state.time)
        error, rate = 0.5 * (1 - cosine) - state.q, 0.5 * pace * sine - state.qd
        wanted = 0.5 * pace**2 * cosine + DAMPING * rate + STIFFNESS * error
        torques = model.inverse_dynamics(state.q, state.qd, wanted)
        rows.append((state.time, state.q, state.qd, wanted, error, torques.copy()))  # the array is the next call's too
        state = stepper(state, torques)
    seconds = time.perf_counter() - begin
    columns = dict(zip(("time", "q", "qd", "qdd", "error", "torque"), zip(*rows, strict=True), strict=True))
    return {"names": stepper.names, "seconds": seconds} | {name: np.array(x) for name, x in columns.items()}


def picture(found: dict[str, Any], path: Path) -> None:
    """Coordinates, errors and torques over time."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(3, 1, figsize=(9, 9), sharex=True, layout="constrained")
    for axis, name, words in zip(
        axes, ("q", "error", "torque"), ("coordinates, rad", "errors, rad", "torques, N m"), strict=True
    ):
        axis.plot(found["time"], found[name], label=found["names"])
        axis.set_ylabel(words)
    axes[0].legend(ncols=3)
    axes[-1].set_xlabel("time in s")
    figure.savefig(path, dpi=120)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--urdf", type=Path, default=kinematics.urdf_example("arm"), help="default: the package's arm")
    parser.add_argument("--out", type=Path, default=Path("dynamics"), metavar="FOLDER")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    found = follow(kinematics.load_urdf(options.urdf))
    duration = len(found["time"]) * 1e-3
    print(f"{duration:g} s in {found['seconds']:.3g} s, {duration / found['seconds']:.3g} times real time")
    print(f"the path is kept to {np.abs(found['error']).max():.2g} rad")
    picture(found, options.out / "computed_torque.png")


if __name__ == "__main__":
    main()
