"""Objects: rotors, blends, exponentials, costs, clusters, merging, beside `clifford` in the same process.

One thread and float64 unless said, everything warm, the best of several runs; the package `clifford` runs its compiled
functions one pair at a time, as it must. Whole algorithms (k-means, merging) are timed once, after a small run.

    python benchmarks/bench_objects.py
    python benchmarks/bench_objects.py --skip-clifford --items 10000
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import objects

REPEATS = 7
PEER_ITEMS = 200  # one call of `clifford` takes some ten microseconds
MATRIX = 1000
CLUSTERS = 50
LEAST_ITEMS = 1000
Row = dict[str, Any]


def best(run: Callable[[], Any], items: int, repeats: int = REPEATS) -> float:
    """Nanoseconds per item of the fastest run."""
    run()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times) / items * 1e9


def once(run: Callable[[], Any], small: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of one run, and its result; a small one goes first, so that nothing is loaded or compiled meanwhile."""
    small()
    start = time.perf_counter()
    result = run()
    return time.perf_counter() - start, result


def circles(count: int, seed: int, spread: float = 1.0) -> bs.Multivector:
    """Random circles of radius 1/2 to 2."""
    rng = np.random.default_rng(seed)
    return cga.circle(spread * rng.normal(size=(count, 3)), rng.normal(size=(count, 3)), rng.uniform(0.5, 2, count))


def lines(count: int, seed: int, spread: float = 1.0) -> bs.Multivector:
    """Random lines."""
    rng = np.random.default_rng(seed)
    return cga.line(spread * rng.normal(size=(count, 3)), rng.normal(size=(count, 3)))


def motors(count: int, seed: int) -> bs.Multivector:
    """Random screw motions, of any angle."""
    rng = np.random.default_rng(seed)
    turn = cga.rotor(rng.normal(size=(count, 3)), rng.uniform(0.01, 6.2, count), point=rng.normal(size=(count, 3)))
    return cga.translator(rng.normal(size=(count, 3))) * turn


def clustered(make: Callable[..., bs.Multivector], count: int, centers: int, noise: float, seed: int) -> Any:
    """Objects scattered by small motions about ``centers`` random ones."""
    rng = np.random.default_rng(seed)
    middle = make(centers, seed, 3.0)
    owner = rng.integers(0, centers, count)
    moves = cga.translator(noise * rng.normal(size=(count, 3))) * cga.rotor(
        rng.normal(size=(count, 3)), noise * rng.normal(size=count)
    )
    return moves >> middle[owner]


def elementwise(items: int, peer: Any) -> Iterator[Row]:
    """Functions of one or two objects: ours in a batch, theirs one by one."""
    a, b = circles(items, 1), circles(items, 2)
    m = motors(items, 3)
    twist = m.log()
    rows: list[tuple[str, Callable[[], Any]]] = [
        ("rotor between circles", lambda: objects.rotor_between(a, b)),
        ("average of two circles", lambda: objects.interpolate(a, b, alpha=0.5)),
        ("rotor between lines", lambda: objects.rotor_between(lines_a, lines_b)),
        ("motor exp", lambda: twist.exp()),
        ("motor log", lambda: m.log()),
        ("conformal rotor exp", lambda: general.exp()),
        ("conformal rotor log", lambda: rotors.log()),
    ]
    lines_a, lines_b = lines(items, 4), lines(items, 5)
    rotors = objects.rotor_between(a, b)
    general = rotors.log()
    theirs = peer_calls(peer, a, b, m, lines_a, lines_b) if peer else {}
    for name, run in rows:
        row: Row = {"what": name, "ns": best(run, items)}
        if name in theirs:
            row["clifford_ns"] = best(theirs[name], PEER_ITEMS, 3)
        yield row


def peer_calls(peer: Any, a: Any, b: Any, m: Any, la: Any, lb: Any) -> dict[str, Callable[[], Any]]:
    """The same on `PEER_ITEMS` items in `clifford`."""
    from clifford.g3c import layout
    from clifford.tools.g3c.rotor_parameterisation import ga_exp, ga_log

    few = [[x.to_clifford(layout) for x in batch[:PEER_ITEMS]] for batch in (a, b, m, la, lb)]
    biv = [ga_log(x) for x in few[2]]
    return {
        "rotor between circles": lambda: [
            peer.rotor_between_objects(x, y) for x, y in zip(few[0], few[1], strict=True)
        ],
        "rotor between lines": lambda: [peer.rotor_between_objects(x, y) for x, y in zip(few[3], few[4], strict=True)],
        "average of two circles": lambda: [peer.average_objects([x, y]) for x, y in zip(few[0], few[1], strict=True)],
        "motor exp": lambda: [ga_exp(x) for x in biv],
        "motor log": lambda: [ga_log(x) for x in few[2]],
    }


def matrices(peer: Any) -> Iterator[Row]:
    """Costs of all pairs, on one and two threads."""
    a, b = lines(MATRIX, 6), lines(MATRIX, 7)
    c, d = circles(MATRIX, 8), circles(MATRIX, 9)
    for name, x, y in (("lines", a, b), ("circles", c, d)):
        for threads in (1, 2):
            taken = best(lambda x=x, y=y, threads=threads: objects.cost_matrix(x, y, threads=threads), 1)  # type: ignore[misc]
            row: Row = {"what": f"cost matrix {MATRIX} x {MATRIX} {name}, {threads} threads", "ms": taken / 1e6}
            row["ns"] = taken / MATRIX**2
            if peer is not None and threads == 1:
                from clifford.g3c import layout
                from clifford.tools.g3c.cost_functions import object_set_cost_matrix

                few = [[o.to_clifford(layout) for o in batch[:30]] for batch in (x, y)]
                kind = "line" if name == "lines" else "generic"
                row["clifford_ns"] = best(
                    lambda few=few, kind=kind: object_set_cost_matrix(*few, object_type=kind), 900, 3
                )  # type: ignore[misc]
            yield row


def algorithms(items: int) -> Iterator[Row]:
    """k-means of circles, and merging of lines at growing size."""

    def cluster(x: bs.Multivector) -> Any:
        return objects.kmeans(x, CLUSTERS, seed=0, threads=2)

    def merge(x: bs.Multivector) -> Any:
        return objects.merge_similar(x, 1e-3, threads=1)

    scenes = {"clustered": clustered(circles, items, CLUSTERS, 0.05, 10), "random": circles(items, 11, 3.0)}
    for name, scene in scenes.items():
        taken, found = once(lambda x=scene: cluster(x), lambda x=scene: cluster(x[:LEAST_ITEMS]))  # type: ignore[misc]
        what = f"k-means of {items} {name} circles, 2 threads"
        yield {"what": what, "s": taken, "iterations": found.iterations, "converged": found.converged}
    for count in (items // 10, items // 5, items // 2, items):
        near = clustered(lines, count, max(1, count // 10), 1e-3, 12)
        taken, found = once(lambda x=near: merge(x), lambda x=near: merge(x[:LEAST_ITEMS]))  # type: ignore[misc]
        per_item = taken / count * 1e6
        yield {"what": f"merging of {count} lines", "s": taken, "us per line": per_item, "left": len(found.objects)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--items", type=int, default=100_000)
    parser.add_argument("--skip-clifford", action="store_true", help="do not import and compile clifford.tools (20 s)")
    parser.add_argument("--json", help="write the rows to this file")
    options = parser.parse_args()
    if options.items < LEAST_ITEMS:
        parser.error(f"--items is {options.items}; at least {LEAST_ITEMS} are needed.")
    peer = None
    if not options.skip_clifford:
        import clifford.tools.g3c as peer
    rows = []
    for row in (
        r for part in (elementwise(options.items, peer), matrices(peer), algorithms(options.items)) for r in part
    ):
        rows.append(row)
        ratio = f"  {row['clifford_ns'] / row['ns']:.0f} times faster than clifford" if "clifford_ns" in row else ""
        figures = "  ".join(f"{k} {v:.4g}" for k, v in row.items() if k != "what")
        print(f"{row['what']:48s} {figures}{ratio}", flush=True)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(rows, file, indent=1)


if __name__ == "__main__":
    main()
