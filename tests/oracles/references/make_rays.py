"""Writes the reference files of this folder: where rays meet evolved surfaces, certified to 50 digits.

    python -m tests.oracles.references.make_rays [family ...] [--processes 2]

Run by hand, when families change; about 8 minutes of one core for all. It needs python-flint. Seeds are in
`families.py`, the arithmetic in `blades.py` and `exact.py`: no root is missing and none is one too many, whatever
double precision can tell. A file holds, for the surfaces and rays that `families.py` makes again,

    attempts  (surfaces,) which draw of each surface was taken: its first that is real all the way
    counts    (surfaces, rays) uint8, roots of each ray
    roots     (n,) float64, all parameters, ray by ray, rising; pieces of splines follow each other by 1
    condition (n,) uint8, of each root: 10^(c/8) is no less than what a relative change of one in the coefficients of
              controls and ray, in the surface's own frame, would move the parameter by, to first order
    margin    (surfaces, rays) uint8, of rays near tangents: 10^((m - 160)/8) is no more than the extremum of F near the
              tangent point over what a relative change of one in the coefficients makes of it, to first order; where
              that is about 1e-16 nobody knows in double precision whether the ray hits
    digest    of the inputs, so that a machine that makes other ones is found out
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from multiprocessing import Pool
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import exact
from .blades import PAIRS, pieces, rational
from .conditions import derivatives
from .families import (
    FAMILIES,
    MARGIN_ZERO,
    PER_DECADE,
    Controls,
    Family,
    controls,
    input_bytes,
    ray_stream,
    rays,
)
from .tangents import tangent_rays

Array = NDArray[np.float64]
HERE = Path(__file__).resolve().parent


#: Draws of a surface, of which one in two or three is real.
MOST_ATTEMPTS = 256


@dataclass(frozen=True)
class Found:
    """References of one surface: the draw taken, roots of each ray, their conditions, margins, bytes of the inputs."""

    attempt: int
    roots: list[list[float]]
    condition: Array
    margin: Array | None
    data: bytes


def reference(family: Family, number: int) -> Found:
    """The first draw of a surface that is real, and with whose rays nothing is exactly on an edge."""
    for attempt in range(MOST_ATTEMPTS):
        try:
            return _tried(family, number, attempt)
        except (exact.NotRealError, ArithmeticError):  # also of circles without a normal, pairs of one point
            continue
    raise RuntimeError(f"no real surface {number} of {family.name} in {MOST_ATTEMPTS} draws.")


def _tried(family: Family, number: int, attempt: int) -> Found:
    objects = controls(family, number, attempt)
    surface = exact.prepared(family, objects)
    origins, directions = rays(family, number, objects)
    found: list[list[float]] = []
    places: list[tuple[int, int, float]] = []
    for ray, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        start, way = rational(origin), rational(direction)
        of_pieces = [[float(t.mid()) for t in exact.roots(piece, start, way)] for piece in surface]
        places += [(ray, k, t) for k, roots in enumerate(of_pieces) for t in roots]
        found.append([k + t for k, roots in enumerate(of_pieces) for t in roots])
    sums = np.array([[[float(c[p]) for p in PAIRS] for c in piece] for piece in pieces(family, objects)])
    return Found(
        attempt,
        found,
        conditions(family.kind, sums, origins, directions, places),
        margins(family, number, objects, sums) if family.nature in ("tangent", "grazing") else None,
        input_bytes(objects.given(), origins + objects.shift, directions),
    )


def conditions(
    kind: str, sums: Array, origins: Array, directions: Array, places: list[tuple[int, int, float]]
) -> Array:
    """Condition numbers of roots (ray, piece, t)."""
    if not places:
        return np.zeros(0)
    ray, piece, t = (np.array(x) for x in zip(*places, strict=True))
    change, rate, _ = derivatives(kind, sums[piece], origins[ray], directions[ray], t)
    return np.asarray(change / np.abs(rate))


def margins(family: Family, number: int, objects: Controls, sums: Array) -> Array:
    """Of rays near tangents: F at its extremum near the tangent point over what rounding could make of it."""
    (piece,) = exact.prepared(family, objects)
    origins, directions, t = tangent_rays(family, objects, ray_stream(family, number))
    at, ratio = [], []
    for origin, direction, start in zip(origins, directions, t, strict=True):
        place, value = exact.extremum(piece, rational(origin), rational(direction), float(start))
        at.append(place)
        ratio.append(value)
    change, _, curvature = derivatives(
        family.kind, np.repeat(sums, family.rays, axis=0), origins, directions, np.array(at)
    )
    return np.asarray(np.abs(np.array(ratio) * curvature / change))


def write(family: Family, processes: int) -> None:
    start = time.perf_counter()
    with Pool(processes) as pool:
        found = pool.map(partial(reference, family), range(family.surfaces), chunksize=4)
    roots = np.array([t for f in found for row in f.roots for t in row])
    condition = np.concatenate([f.condition for f in found])
    code = np.ceil(PER_DECADE * np.log10(np.maximum(condition, 1.0)))
    counts = np.array([[len(row) for row in f.roots] for f in found], np.uint8)
    more: dict[str, Any] = {}
    if found[0].margin is not None:
        logarithm = np.log10(np.maximum([f.margin for f in found], 1e-20))
        more["margin"] = (np.floor(PER_DECADE * logarithm) + MARGIN_ZERO).clip(0, 255).astype(np.uint8)
    path = HERE / f"{family.name}.npz"
    np.savez_compressed(
        path,
        attempts=np.array([f.attempt for f in found], np.uint8),
        counts=counts,
        roots=roots,
        condition=code.astype(np.uint8),
        digest=np.frombuffer(sha256(b"".join(f.data for f in found)).digest(), np.uint8),
        **more,
    )
    low, middle, high = (10 ** (q / PER_DECADE) for q in (code.min(), np.median(code), code.max()))
    print(
        f"{family.name:20s} {counts.size:7d} rays {len(roots):7d} roots, at most {counts.max()} of one ray, "
        f"{np.mean(counts == 0):.0%} without; condition {low:.1g} .. {middle:.1g} .. {high:.1g}; "
        f"{path.stat().st_size / 1e3:.0f} kB, {time.perf_counter() - start:.0f} s",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("families", nargs="*", choices=[*FAMILIES, []], help="all, if none is named")
    parser.add_argument("--processes", type=int, default=1)
    options = parser.parse_args()
    for name in options.families or FAMILIES:
        write(FAMILIES[name], options.processes)


if __name__ == "__main__":
    main()
