"""Robots beside what people would use instead, in one process: the thesis's formulas in numba, NumPy and `clifford`,
Pinocchio, and NumPy's pseudo-inverse. Peers that are not installed are skipped.

Everything is warm, on one thread; times are the least processor time of several runs. Errors are against 50 digits,
relative, the largest of some poses. Poses of a batch share a thousandth and less of what a call costs.

    python benchmarks/bench_kinematics.py
    python benchmarks/bench_kinematics.py --only delta screws --json kinematics.json
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: processor time would add up its threads

import kinematics_peers as peers
import numpy as np
from timing import Row, arguments, run_parts, seconds

from bladesmith.benchmarks.studies.kinematics import chains, delta, mechanisms
from bladesmith.benchmarks.studies.kinematics.delta_exact import ExactDelta, floats
from bladesmith.kinematics.delta.robot import DeltaRobot

#: Poses of a batch; of one of mechanisms; those whose errors are looked at.
BATCH, MECHANISMS, LOOKED_AT = 100_000, 2000, 20
#: Bars in nanoseconds, for one pose, or for the whole chain of bodies.
BARS = {"inverse": 40.0, "forward": 40.0, "inverse_jacobian": 120.0, "forward_jacobian": 120.0}
ELIMINATION_BAR, GENERAL_BAR, CHAIN_BAR = 5e3, 200e3, 1e9
BODIES, CELLS = 1000, 100


def compared(rows: list[Row]) -> Iterator[Row]:
    """Each beside the first, which is ours."""
    for row in rows:
        yield row if row is rows[0] or "ns" not in row else {**row, "times": row["ns"] / rows[0]["ns"]}


def off(found: Any, exact: Any) -> float:
    """The largest error of a pose, relative to its norm."""
    axes = tuple(range(1, exact.ndim))
    return float((np.linalg.norm(found - exact, axis=axes) / np.linalg.norm(exact, axis=axes)).max())


# -- parts -------------------------------------------------------------------------------------------------


def delta_robot(options: argparse.Namespace) -> Iterator[Row]:
    """Angles, positions and Jacobians, one after the other."""
    rng = np.random.default_rng(1)
    robot, digits = DeltaRobot(*delta.LENGTHS), ExactDelta(DeltaRobot(*delta.LENGTHS))
    theta = rng.uniform(*delta.ANGLES, (BATCH, 3))
    places = robot.forward(theta)
    for work in peers.WORKS:
        given = theta if work.startswith("forward") else places
        ours, exactly, shape = getattr(robot, work), getattr(digits, work), (3, 3) if "jacobian" in work else (3,)
        few = given[:LOOKED_AT]
        exact = np.array([floats(exactly(digits.numbers(x)), shape) for x in few])
        what = f"Delta, {work.replace('_', ' ')}"

        def row(method: str, run: Callable[[], Any], count: int, found: Any, exact: Any = exact) -> Row:
            return {"method": method, "ns": 1e9 * seconds(run) / count, "error": off(found, exact)}

        batch = row("bladesmith", lambda f=ours, x=given: f(x, threads=1), BATCH, ours(few))  # type: ignore[misc]
        rows = [{**batch, "bar": BARS[work]}]
        one = np.array(given[0])
        rows.append(row("bladesmith, pose by pose", lambda f=ours, x=one: f(x), 1, ours(few)))  # type: ignore[misc]
        for name, (package, make, most) in peers.PEERS.items():
            if peers.missing(package) or (package == "clifford" and options.skip_clifford):
                rows.append({"method": f"{name}: skipped"})
                continue
            solve = make(delta.LENGTHS, work)
            found = solve(few) if most is None else np.stack([solve(x) for x in few])
            at = given if most is None else one
            rows.append(row(name, lambda f=solve, x=at: f(x), BATCH if most is None else 1, found))  # type: ignore[misc]
        yield from ({"what": what, **r} for r in compared(rows))


def screws(options: argparse.Namespace) -> Iterator[Row]:
    """Jacobians of the Delta's fifteen joints, all bodies' twists included, at poses that are known."""
    rng = np.random.default_rng(2)
    asked = delta.usual(rng, LOOKED_AT)
    many = asked.jointed_robot.repeated_poses(MECHANISMS // LOOKED_AT)
    for back, name in ((False, "forward"), (True, "inverse")):
        own = asked if not back else replace(asked, at=asked.known_pose[1], is_inverse=True)
        exact, rows = own.exact, []
        for method, bar in (("elimination", ELIMINATION_BAR), ("general", GENERAL_BAR)):
            found = asked.jointed_robot.jacobian(many, back, method)[:LOOKED_AT]
            run = lambda m=method, b=back: asked.jointed_robot.jacobian(many, b, m)  # type: ignore[misc]  # noqa: E731
            ns = 1e9 * seconds(run) / MECHANISMS
            rows.append({"method": f"bladesmith, {method}", "ns": ns, "error": off(found, exact), "bar": bar})
        found = delta.pseudo_inverse(own, None)
        ns = 1e9 * seconds(lambda a=own: delta.pseudo_inverse(a, None), 3) / LOOKED_AT  # type: ignore[misc]
        rows.append({"method": "NumPy's pinv, 51 x 60", "ns": ns, "error": off(found, exact)})
        yield from ({"what": f"Delta, {name} Jacobian by screws", **r} for r in compared(rows))


def arm(options: argparse.Namespace) -> Iterator[Row]:
    """Poses and Jacobians of a six-axis arm."""
    for what in ("pose", "jacobian"):
        few = chains.six(np.random.default_rng(3), LOOKED_AT, quantity=what)
        many, one = replace(few, q=np.tile(few.q, (BATCH // LOOKED_AT, 1))), replace(few, q=few.q[:1])
        chain, rows = few.chain, []
        solve: Callable[[Any], Any] = chain.forward if what == "pose" else partial(chain.jacobian, point=np.zeros(3))
        found = chains.run_batch(few, None, copies=1)
        for name, at, count in (("bladesmith", many.q, BATCH), ("bladesmith, pose by pose", one.q[0], 1)):
            ns = 1e9 * seconds(lambda x=at, f=solve: f(x)) / count  # type: ignore[misc]
            rows.append({"method": name, "ns": ns, "error": float(chains.error(found, few.exact, few).max())})
        for name, package, run, at in (
            ("Pinocchio from Python, pose by pose", "pinocchio", chains.by_pinocchio, few),
            ("NumPy, 4 x 4 matrices", "numpy", lambda a, s: chains.by_matrices(a, s, copies=100), few),
        ):
            if peers.missing(package):
                rows.append({"method": f"{name}: skipped"})
                continue
            count = len(at) * (1 if package == "pinocchio" else 100)
            error = float(chains.error(run(at, None), few.exact, few).max())
            ns = 1e9 * seconds(lambda f=run, a=at: f(a, None)) / count  # type: ignore[misc]
            rows.append({"method": name, "ns": ns, "error": error})
        yield from ({"what": f"six-axis arm, {what}", **r} for r in compared(rows))


def growth(options: argparse.Namespace) -> Iterator[Row]:
    """A long chain from nothing: bodies and joints, constraint matrix, mobility and Jacobian; and a ladder of loops."""
    mechanisms.prepare()
    for what, make, size in (
        (f"chain of {BODIES} bodies", mechanisms.chain, BODIES),
        (f"ladder of {CELLS} parallelograms", mechanisms.ladder, CELLS),
    ):
        grown = make(np.random.default_rng(4), 1, float(size))

        def run(grown: Any = grown) -> Any:
            assembled = grown.mechanism()
            assembled.constraint_matrix()
            joints = [grown.joints[j] for j in grown.driven]
            return assembled.mobility(), assembled.jacobian(joints, [(grown.bodies[-1], grown.point)])

        error = float(mechanisms.error((grown, run()), None, grown)[0])
        bar = {"bar": CHAIN_BAR} if make is mechanisms.chain else {}
        yield {"what": what, "method": "bladesmith", "ns": 1e9 * seconds(run, 3), "error": error, **bar}
    small = mechanisms.chain(np.random.default_rng(4), 1, float(mechanisms.MOST))
    rows = []
    for name, solve in (("bladesmith", mechanisms.by_loops), ("dense singular values", mechanisms.by_singular_values)):
        error = float(mechanisms.error((small, solve(small)), None, small)[0])  # type: ignore[operator]
        rows.append({"method": name, "ns": 1e9 * seconds(lambda f=solve: f(small), 2), "error": error})  # type: ignore[misc]
    yield from ({"what": f"chain of {mechanisms.MOST} bodies, mobility and Jacobian", **r} for r in compared(rows))


def table(options: argparse.Namespace) -> Iterator[Row]:
    """Table 7.1 in numbers, from the study."""
    from bladesmith.benchmarks.harness.runner import run_study

    for line in delta.table(run_study(delta.STUDY)):
        for label, error in line.errors.items():
            if line.lost[label] or not np.isnan(error):
                yield {"what": f"Table 7.1: {line.method}", "method": label, "error": error, "lost": line.lost[label]}
        yield {"what": f"Table 7.1: {line.method}", "method": "time in a batch", "ns": line.batch}
        if not np.isnan(line.single):
            yield {"what": f"Table 7.1: {line.method}", "method": "time of one", "ns": line.single}


PARTS = {"delta": delta_robot, "screws": screws, "arm": arm, "growth": growth, "table": table}


def main() -> None:
    parser = arguments(__doc__, PARTS)
    options = parser.parse_args()
    run_parts(options, PARTS)


if __name__ == "__main__":
    main()
