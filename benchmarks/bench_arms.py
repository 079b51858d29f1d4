"""Arms: torques, mass matrices and accelerations beside Pinocchio from Python, their derivatives, and all postures.

Everything is warm, on one thread; times are the least processor time of several runs. The arm is a UR5 of the package
example-robot-data where that is installed, else the one that comes with this package; differences are relative.

    python benchmarks/bench_arms.py
    python benchmarks/bench_arms.py --only batch calls --json arms.json
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: processor time would add up its threads

import numpy as np
from timing import Row, arguments, run_parts, seconds

from bladesmith import kinematics

#: Motions of a batch; of one of derivatives; poses whose postures are counted.
BATCH, DERIVATIVES, POSES = 100_000, 5000, 500
#: Bars in nanoseconds, for a motion.
BARS = {"inverse_dynamics": 150.0, "mass_matrix": 250.0, "forward_dynamics": 400.0}
CALL_BAR = 2e3
#: Arguments of a method, of q, qd and a third.
COUNTS = {"inverse_dynamics": 3, "mass_matrix": 1, "forward_dynamics": 3}


@cache
def file_of_arm() -> Path:
    """A UR5, or the arm that comes with the package."""
    found = find_spec("cmeel")
    if found is not None and found.submodule_search_locations:
        folder = Path(next(iter(found.submodule_search_locations))).parent
        robot = "cmeel.prefix/share/example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"
        if (folder / robot).exists():
            return folder / robot
    return kinematics.urdf_example("arm")


@cache
def arm() -> kinematics.Chain:
    robot = kinematics.load_urdf(file_of_arm())
    last = next(joint for joint in reversed(robot.joints.values()) if joint.name == robot.joint_names[-1])
    return robot.chain(last.child)


def motions(count: int) -> Any:
    return np.random.default_rng(0).uniform(-2, 2, (3, count, 6))


@cache
def peer() -> dict[str, Callable[..., Any]]:
    """Pinocchio's functions of one motion; none where it is not installed."""
    if find_spec("pinocchio") is None:
        return {}
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(file_of_arm()))
    data = model.createData()
    assert [model.names[i] for i in range(1, 7)] == list(arm().names)

    def whole(upper: Any) -> Any:
        return np.triu(upper) + np.triu(upper, 1).T

    return {
        "inverse_dynamics": lambda q, qd, qdd: pin.rnea(model, data, q, qd, qdd),
        "mass_matrix": lambda q: pin.crba(model, data, q),
        "forward_dynamics": lambda q, qd, tau: pin.aba(model, data, q, qd, tau),
        "whole": whole,
        "inverse_dynamics_derivatives": lambda q, qd, qdd: pin.computeRNEADerivatives(model, data, q, qd, qdd),
        "forward_dynamics_derivatives": lambda q, qd, tau: pin.computeABADerivatives(model, data, q, qd, tau),
    }


# -- parts -------------------------------------------------------------------------------------------------


def nanoseconds(solve: Callable[..., Any], given: Sequence[Any], repeats: int = 9) -> float:
    """Time of a call."""
    return 1e9 * seconds(lambda: solve(*given), repeats)


def batch(options: argparse.Namespace) -> Iterator[Row]:
    """Motions by the hundred thousand."""
    given = motions(BATCH)
    for name, count in COUNTS.items():
        solve = partial(getattr(arm(), name), threads=1)
        row: Row = {"what": f"six-axis arm, {name}", "method": f"bladesmith, {BATCH} motions", "bar": BARS[name]}
        row["ns"] = nanoseconds(solve, given[:count]) / BATCH
        if peer():
            expected = np.stack([np.array(peer()[name](*given[:count, i])) for i in range(50)])
            if name == "mass_matrix":
                expected = np.stack([peer()["whole"](m) for m in expected])
            row["error"] = float(np.abs(solve(*given[:count, :50]) - expected).max() / np.abs(expected).max())
        yield row


def calls(options: argparse.Namespace) -> Iterator[Row]:
    """One motion in a call."""
    chain, one = arm(), [np.array(x) for x in motions(1)[:, 0]]
    bound = chain.bound()
    for name, count in COUNTS.items():
        what = f"one motion in a call, {name}"
        for method, solve in (
            ("bladesmith, bound", getattr(bound, name)), ("bladesmith", getattr(chain, name)),
            ("Pinocchio from Python", peer().get(name)),
        ):  # fmt: skip
            if solve is None:
                yield {"what": what, "method": f"{method}: skipped"}
                continue
            row = {"what": what, "method": method, "ns": nanoseconds(solve, one[:count])}
            yield {**row, "bar": CALL_BAR} if method == "bladesmith, bound" else row


def derivatives(options: argparse.Namespace) -> Iterator[Row]:
    """Derivatives by all arguments."""
    given = motions(DERIVATIVES)
    for name in ("inverse_dynamics_derivatives", "forward_dynamics_derivatives"):
        ns = nanoseconds(partial(getattr(arm(), name), threads=1), given) / DERIVATIVES
        yield {"what": name, "method": f"bladesmith, {DERIVATIVES} motions", "ns": ns}
        if peer():
            ns = nanoseconds(peer()[name], [np.array(x) for x in given[:, 0]])
            yield {"what": name, "method": "Pinocchio from Python", "ns": ns}


def length(options: argparse.Namespace) -> Iterator[Row]:
    """Growth with the number of joints."""
    for count in (10, 100, 1000):
        places = np.column_stack([np.arange(count), np.zeros((count, 2))])
        axes = kinematics.revolute_axis(places, np.eye(3)[np.arange(count) % 3])
        chain = kinematics.Chain(axes).with_inertias(
            np.ones(count), places + 0.5, np.tile(0.1 * np.eye(3), (count, 1, 1))
        )
        given = np.random.default_rng(0).uniform(-1, 1, (3, 40, count))
        for name in ("inverse_dynamics", "forward_dynamics"):
            ns = nanoseconds(partial(getattr(chain, name), threads=1), given) / 40
            yield {"what": f"chain of {count} joints", "method": f"{name}, for a joint", "ns": ns / count}


def postures(options: argparse.Namespace) -> Iterator[Row]:
    """All postures of arms: a wrist, parallel axes, and any axes."""
    rng = np.random.default_rng(0)
    p, d = rng.normal(size=(2, 6, 3))
    wrist = p.copy()
    wrist[3:] = wrist[3]
    for name, chain in (
        ("three axes meet", kinematics.Chain(kinematics.revolute_axis(wrist, d))),
        ("three axes are parallel", kinematics.Chain(arm().axes, arm().tool)),
        ("any axes", kinematics.Chain(kinematics.revolute_axis(p, d))),
    ):
        q = rng.uniform(-np.pi, np.pi, (POSES, 6))
        poses = chain.forward(q)
        found = chain.all_solutions(poses)
        apart = np.abs(np.exp(1j * found.q) - np.exp(1j * q)[:, None]).max(-1)
        yield {
            "what": "all postures", "method": f"{name}: {found.method}",
            "ns": nanoseconds(chain.all_solutions, [poses], 3) / POSES,
            "error": float(np.nanmax(found.distance)) / chain.length,
            "lost": int((~(np.nanmin(apart, -1) < 1e-6)).sum()),
        }  # fmt: skip
        ns = nanoseconds(chain.all_solutions, [poses[0]], 3)
        yield {"what": "all postures", "method": f"{name}, one pose", "ns": ns}


PARTS = {"batch": batch, "calls": calls, "derivatives": derivatives, "length": length, "postures": postures}


def main() -> None:
    parser = arguments(__doc__, PARTS)
    run_parts(parser.parse_args(), PARTS)


if __name__ == "__main__":
    main()
