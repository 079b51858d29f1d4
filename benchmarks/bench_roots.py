"""Roots of rays on evolved surfaces: lost, false, largest error and time of each method, by family of references.

Truth are the certified roots of tests/oracles/references, of 50 digits and from the surfaces' own definition, so that
all rounding counts. Times are processor time on one thread.

    python benchmarks/bench_roots.py
    python benchmarks/bench_roots.py circles_random pairs_cubic --surfaces 50
"""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bladesmith import cga3d, tracer
from bladesmith.curves import KochanekBartels

CHECKOUT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(CHECKOUT))
from tests.oracles.references.families import FAMILIES, Controls, Family, controls, rays  # noqa: E402

Array = NDArray[Any]
SAMPLES = (16, 64, 256, 1024)
REACH = 0.01  # a true root is found when a reported one is as near as that
REPEATS = 3
COPIES = 20  # of each surface's rays in a timed call, so that the time is the loop's


def surface_of(family: Family, objects: Controls) -> Any:
    """The surface, from parameters wherever a curve takes them."""
    made = tracer.EvolvedCircles if family.kind == "circles" else tracer.EvolvedPointPairs
    given = objects.given()
    if family.curve == "bezier":
        return made(given)
    if family.kind == "pairs":
        return made(KochanekBartels(cga3d.point_pair(*(np.array(x) for x in zip(*given, strict=True))), *objects.shape))
    return made(KochanekBartels(given, *objects.shape))


def matched(want: Array, got: Array) -> tuple[int, int, float]:
    """Lost, false and largest error: each true root takes the nearest found one within reach."""
    rest, error, lost = [float(x) for x in got], 0.0, 0
    for root in want:
        nearest = min(rest, key=lambda x: abs(x - root), default=np.inf)
        if abs(nearest - root) <= REACH:
            rest.remove(nearest)
            error = max(error, abs(nearest - root))
        else:
            lost += 1
    return lost, len(rest), error


class Work:
    """Surfaces of a family with their rays and true roots."""

    def __init__(self, family: Family, most: int) -> None:
        with np.load(CHECKOUT / "tests" / "oracles" / "references" / f"{family.name}.npz") as file:
            attempts, counts, roots = file["attempts"], file["counts"], file["roots"]
        self.wanted = np.split(roots, np.cumsum(counts.ravel())[:-1])[: most * family.rays]
        self.items: list[tuple[Any, Array, Array]] = []
        for number, attempt in enumerate(attempts[:most]):
            objects = controls(family, number, int(attempt))
            origins, directions = rays(family, number, objects)
            self.items.append((surface_of(family, objects), origins + objects.shift, directions))


def best(run: Callable[[], Any]) -> float:
    """Seconds of processor time of the fastest of several runs."""
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return min(times)


def report(work: Work, method: str, samples: int, dtype: Any) -> None:
    """One line of the table; every tenth surface is timed."""
    found: list[Array] = []
    times = []
    for number, (surface, origins, directions) in enumerate(work.items):
        o, d = (x.astype(dtype) for x in (origins, directions))
        ask = partial(surface.intersect, method=method, samples=samples, threads=1)
        hits = ask(o, d)
        found += [np.asarray(row[:count], float) for row, count in zip(hits.alpha, hits.count, strict=True)]
        if number % 10 == 0:
            times.append(best(partial(ask, *(np.tile(x, (COPIES, 1)) for x in (o, d)))) / (COPIES * len(o)))
    results = [matched(w, g) for w, g in zip(work.wanted, found, strict=True)]
    lost, false = (sum(r[k] for r in results) for k in (0, 1))
    error = max(r[2] for r in results)
    name = f"  {method}{f' {samples}' if method == 'sampled' else ''}, {np.dtype(dtype).name}"
    total = sum(map(len, work.wanted))
    print(f"{name:28s} {total:7d} {lost:6d} {false:6d} {error:10.1e} {np.mean(times) * 1e9:10.0f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    names = ", ".join(FAMILIES)
    parser.add_argument("families", nargs="*", metavar="family", help=f"of {names}; all, if none is named")
    parser.add_argument("--surfaces", type=int, default=50, help="of each family, at most")
    options = parser.parse_args()
    unknown = set(options.families) - set(FAMILIES)
    if unknown:
        parser.error(f"there is no family {sorted(unknown)[0]!r}; there are: {names}.")
    logging.getLogger("bladesmith").setLevel(logging.ERROR)
    print(f"{'':28s} {'roots':>7s} {'lost':>6s} {'false':>6s} {'max error':>10s} {'ns per ray':>10s}")
    for name in options.families or FAMILIES:
        work = Work(FAMILIES[name], options.surfaces)
        print(f"{name}, {len(work.wanted)} rays")
        runs = [("isolate", 0), ("companion", 0), *(("sampled", n) for n in SAMPLES)]
        for method, samples in runs:
            report(work, method, samples or 64, np.float64)
        report(work, "isolate", 64, np.float32)


if __name__ == "__main__":
    main()
