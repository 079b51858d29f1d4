"""Rigid bodies beside what people would use instead, in one process: MuJoCo, Pinocchio, scipy's DOP853, heyoka,
classical Runge-Kutta steps in numba, and `clifford`. Peers that are not installed are skipped.

Everything is warm; times are the least processor time of several runs. Errors are of the orientation (radians) and of
the angular velocity (relative) at the end, against elliptic functions or power series with 30 digits. A call of `run`
also checks, assembles and hands back; of 1000 bodies at once each bears a thousandth of that.

    python benchmarks/bench_dynamics.py
    python benchmarks/bench_dynamics.py --only tops --json tops.json
    python benchmarks/bench_dynamics.py --only drift --steps 1000000
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import dynamics_peers as peers
import numpy as np
from dynamics_peers import GRAVITY, Top
from timing import REPEATS, Row, arguments, run_parts, seconds

from bladesmith import cga3d, dynamics
from bladesmith.benchmarks.studies.dynamics import exact_motions
from bladesmith.dynamics.integration.tableaus import FIXED_SCHEMES

#: Free and heavy: no two moments equal.
FREE = Top((1.0, 2.0, 2.5), (1.5, 1.0, 2.0), (1.0, 0.0, 0.0, 0.0), 20.0)
HEAVY = Top((0.2, 0.3, 0.15), (0.3, 0.2, 15.0), (np.cos(0.3), np.sin(0.3), 0.0, 0.0), 5.0, 1.0, 0.5)
#: Bars: nanoseconds, steps per second, and times of peers at the errors for which they are compared.
STEP_BAR, RHS_BAR, RATE_BAR, HEYOKA_BAR, ENGINES_BAR = 47.0, 250.0, 1e7, 3.0, 50.0
ERRORS = (1e-6, 1e-9, 1e-12)
BODIES, STEPS = 1000, 1000
OURS = (("taylor", (1e-4, 1e-6, 1e-9, 1e-12, 1e-15)), ("adaptive", (1e-6, 1e-9, 1e-11, 1e-13)), ("auto", (None,)))


def rotation(quaternion: Any) -> Any:
    """Matrix of (w, x, y, z)."""
    w, x, y, z = np.asarray(quaternion) / np.linalg.norm(quaternion)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def body_of(top: Top, count: int = 1) -> Any:
    """One of ours, or so many."""
    turn = rotation(top.quaternion)
    arm = np.array([0, 0, top.arm])
    mass = top.mass if count == 1 else np.full(count, top.mass)
    return dynamics.RigidBody(mass, top.moments, turn @ arm, turn, turn @ np.cross(top.spin, arm), top.spin)


def simulation_of(top: Top, count: int = 1, **options: Any) -> Any:
    """With weight and pin where it has a tip."""
    if not top.arm:
        return dynamics.Simulation(body_of(top, count), **options)
    loads, pins = [dynamics.Gravity((0, 0, -GRAVITY))], [dynamics.Pin(cga3d.point((0, 0, -top.arm)))]
    return dynamics.Simulation(body_of(top, count), loads, pins, **options)


def truth(top: Top) -> tuple[Any, Any]:
    """Orientation and spin at the end."""
    turn = rotation(top.quaternion)
    if not top.arm:
        change, spin = exact_motions.free_top(np.array(top.moments), np.array(top.spin), top.duration)
        return turn @ change, spin
    given = (np.array([top.mass]), np.array([top.moments]), np.array([[0, 0, top.arm]]), np.array([0, 0, -GRAVITY]))
    turns, spins = exact_motions.turning(*given, turn[None], np.array([top.spin]), top.duration)
    return turns[0], spins[0]


def off(turn: Any, spin: Any, exact: tuple[Any, Any]) -> float:
    """The larger of both errors."""
    angle = 2 * np.arcsin(min(1.0, float(np.linalg.norm(turn - exact[0])) / (2 * np.sqrt(2))))
    return float(max(angle, np.linalg.norm(spin - exact[1]) / np.linalg.norm(exact[1])))


# -- parts -------------------------------------------------------------------------------------------------


def steps(options: argparse.Namespace) -> Iterator[Row]:
    """Steps of one body."""
    count = 100_000
    long = Top(FREE.moments, FREE.spin, FREE.quaternion, count * 1e-3)
    tall = Top(HEAVY.moments, HEAVY.spin, HEAVY.quaternion, count * 1e-3, arm=HEAVY.arm)

    def ours(top: Top, **given: Any) -> float:
        """What a step adds to a call."""
        simulation, times = simulation_of(top, **given), [top.duration]
        call = seconds(lambda: simulation.run(1e-3, times=[1e-3], threads=1))
        return (seconds(lambda: simulation.run(top.duration, step=1e-3, times=times, threads=1), 3) - call) / count

    what = "step of a free body"
    yield {"what": what, "method": "bladesmith rk4", "ns": 1e9 * ours(long, integrator="rk4"), "bar": STEP_BAR}
    for name in (*FIXED_SCHEMES, "cf4", "midpoint", "strang", "blanes-moan", "yoshida6"):
        yield {"what": what, "method": f"bladesmith {name}", "ns": 1e9 * ours(long, integrator=name)}
    if not peers.missing("numba"):
        yield {"what": what, "method": "numba RK4", "ns": 1e9 * seconds(peers.by_numba(long, count), 3) / count}
    if not peers.missing("mujoco"):
        for name in ("Euler", "RK4"):
            ns = 1e9 * seconds(peers.by_mujoco(long, count // 10, name), 3) / (count // 10)
            yield {"what": what, "method": f"MuJoCo {name}", "ns": ns}
    what = "right-hand side of a pinned body"
    for how, way in (("null space", "null-space"), ("multipliers and projection", "projection")):
        ns = 1e9 * ours(tall, integrator="rk4", stabilization=way) / 4
        yield {"what": what, "method": f"bladesmith, {how}, quarter of a step", "ns": ns, "bar": RHS_BAR}
    if not peers.missing("pinocchio"):
        import pinocchio as pin

        model, data = peers.pinocchio_top(HEAVY)
        q, v, none = np.array([0, 0, 0, 1.0]), np.array(HEAVY.spin), np.zeros(3)
        ns = 1e9 * seconds(lambda: pin.aba(model, data, q, v, none))
        yield {"what": what, "method": "Pinocchio ABA, called from Python", "ns": ns}
    if not peers.missing("clifford") and not options.skip_clifford:
        yield {"what": what, "method": "clifford, free body", "ns": 1e9 * seconds(peers.clifford_rates(FREE), 3)}


def batches(options: argparse.Namespace) -> Iterator[Row]:
    """Steps of 1000 bodies: of a body, on the wall, for threads share the work."""
    top = Top(FREE.moments, FREE.spin, FREE.quaternion, STEPS * 1e-3)
    simulation, total = simulation_of(top, BODIES, integrator="rk4"), BODIES * STEPS

    def wall(run: Callable[[], Any]) -> float:
        run()
        found = []
        for _ in range(REPEATS):
            start = time.perf_counter()
            run()
            found.append(time.perf_counter() - start)
        return 1e9 * min(found) / total

    what = f"RK4 steps of {BODIES} bodies"
    for threads in (1, 2):
        ns = wall(lambda n=threads: simulation.run(top.duration, step=1e-3, times=[top.duration], threads=n))  # type: ignore[misc]
        bar = {"bar": 1e9 / RATE_BAR} if threads == 2 else {}
        yield {"what": what, "method": f"bladesmith, {threads} threads", "ns": ns, "rate": 1e9 / ns, **bar}
    if not peers.missing("numba"):
        run = peers.by_numba(top, STEPS)
        ns = wall(lambda: [run() for _ in range(BODIES)])
        yield {"what": what, "method": "numba, 1 thread, body by body", "ns": ns, "rate": 1e9 / ns}
    if not peers.missing("mujoco"):
        run = peers.by_mujoco(top, STEPS)
        ns = BODIES / 10 * wall(lambda: [run() for _ in range(10)])
        yield {"what": what, "method": "MuJoCo, body by body", "ns": ns, "rate": 1e9 / ns}


def tops(options: argparse.Namespace) -> Iterator[Row]:
    """Error against time, of a free and of a heavy top, and who takes how long for the same error."""
    for what, top in ((f"free top to t = {FREE.duration:g}", FREE), (f"heavy top to t = {HEAVY.duration:g}", HEAVY)):
        exact, rows = truth(top), []
        for name, settings in OURS:
            for setting in settings:
                rows += _ours(top, name, setting, exact)
        for name, setting, run in peers.runs(top):
            if run is None:
                yield {"what": what, "method": f"{name}: {setting}, skipped"}
                continue
            end = run()
            error = off(rotation(end[0]), np.array(end[1]), exact)
            each = 1e9 / (peers.MANY if "one of" in name else 1)
            rows.append({"method": name, "setting": setting, "error": error, "ns": each * seconds(run, 2)})
        yield from ({"what": what, **row} for row in rows)
        for error in ERRORS:
            yield from _compared(f"{what}, error {error:g}", [r for r in rows if r["error"] <= error])


def _ours(top: Top, name: str, setting: float | None, exact: tuple[Any, Any]) -> list[Row]:
    """A call, and one of a thousand."""
    found, chosen = [], ""
    for count, many in ((1, ""), (BODIES, f", one of {BODIES}")):
        if count > 1 and chosen in ("blanes-moan", "yoshida6"):
            continue  # minutes
        simulation = simulation_of(top, count, integrator=name)

        def run(simulation: Any = simulation) -> Any:
            return simulation.run(top.duration, times=[top.duration], rtol=setting, threads=1)

        end = run()
        chosen = end.integrator
        turn, spin = (
            x.reshape(-1, 2, *x.shape[-k:])[0, -1] for x, k in ((end.orientation, 2), (end.angular_velocity, 1))
        )
        label = f"bladesmith {name}{f' ({chosen})' if name == 'auto' else ''}{many}"
        ns = 1e9 * seconds(run, 3) / count
        found.append({"method": label, "setting": setting or "", "error": off(turn, spin, exact), "ns": ns})
    return found


def _compared(what: str, rows: list[Row]) -> Iterator[Row]:
    """The fastest of each, beside our fastest of both ways to be called."""
    fastest: dict[str, Row] = {}
    for row in rows:
        kind = row["method"]
        if kind.startswith("bladesmith"):
            kind = f"bladesmith, one of {BODIES}" if "one of" in kind else "bladesmith, a call"
        if kind not in fastest or row["ns"] < fastest[kind]["ns"]:
            fastest[kind] = row
    own = fastest.get(f"bladesmith, one of {BODIES}")
    for kind, row in fastest.items():
        times = {} if own is None else {"times": row["ns"] / own["ns"]}
        if own is not None and kind == "heyoka":
            times["least"] = 1 / HEYOKA_BAR
        if own is not None and kind.startswith("heyoka, one of"):
            times["least"] = 1.0
        if own is not None and kind.startswith(("MuJoCo", "scipy")):
            times["least"] = ENGINES_BAR
        yield {"what": what, **row, "method": f"{kind}: {row['method']}" if kind.startswith("blade") else kind, **times}


def drift(options: argparse.Namespace) -> Iterator[Row]:
    """Energy and momentum over as many steps as are asked for, of every integrator."""
    from bladesmith.benchmarks.harness.runner import run_study
    from bladesmith.benchmarks.studies.dynamics import drift as studied

    for row in run_study(studied.study((float(options.steps),))):
        if not row.sweep:
            yield {"what": row.case, "method": row.method, "error": row.max_error, "ns": row.nanoseconds}


def auto(options: argparse.Namespace) -> Iterator[Row]:
    """What "auto" takes in the studies, and the fastest and the most exact of all others."""
    from bladesmith.benchmarks.harness.runner import run_study
    from bladesmith.benchmarks.registry import load_study
    from bladesmith.benchmarks.studies.dynamics import integrators

    for name in ("tops", "pendulums", "stiffness"):
        study = load_study(name)
        for v in integrators.verdicts(run_study(replace(study, cases=tuple(c for c in study.cases if not c.sweep)))):
            yield {"what": v.case, "method": f"auto: {v.chosen}", "error": v.error, "ns": v.nanoseconds}
            for which, row in (("fastest to 1e-9", v.fastest), ("most exact", v.exactest)):
                if row is not None:
                    label, times = f"{which}: {row.method}", row.nanoseconds / v.nanoseconds
                    found = {"error": row.max_error, "ns": row.nanoseconds, "times": times}
                    yield {"what": v.case, "method": label, "setting": row.setting, **found}


PARTS = {"steps": steps, "batches": batches, "tops": tops, "auto": auto, "drift": drift}


def main() -> None:
    parser = arguments(__doc__, PARTS)
    parser.add_argument("--steps", type=int, default=10_000, help="of long runs, up to 1000000")
    options = parser.parse_args()
    run_parts(options, PARTS)


if __name__ == "__main__":
    main()
