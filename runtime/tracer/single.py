"""Where single precision serves, and what is done where it does not: the work in double, rounded at the end.

Products of lengths beyond some 1e19 are no single numbers, and those below 1e-19 vanish: roots would be lost. On
evolved surfaces, whose polynomials are of high degree, single precision finds fewer roots, and not sooner.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.surface_kinds import surface_kind
from ..status import Status
from .hits import Hits
from .rows import SceneRows

Array = NDArray[Any]
#: Sizes of surfaces, and coordinates, whose products of three are single numbers that keep their digits.
LEAST, MOST = 1e-11, 1e12


def serves_kinds(kinds: Iterable[str]) -> bool:
    """Whether single precision is for these kinds of surface at all: not for those with roots to be isolated."""
    return not any(surface_kind(kind).methods for kind in kinds)


def serves_surfaces(rows: SceneRows) -> bool:
    """Whether sizes and places of all surfaces are such that single precision keeps their digits."""
    for part in rows.values():
        low, high = part.boxes[:, :3], part.boxes[:, 3:]
        side = (high - low).max(axis=1)
        bounded = np.isfinite(side)
        sides, farthest = side[bounded], np.maximum(np.abs(low), np.abs(high))[bounded]
        if sides.min(initial=MOST) < LEAST or farthest.max(initial=0.0) > MOST:
            return False
        flat = part.constants[~bounded]
        if np.abs(flat).max(initial=0.0) > MOST:
            return False
    return True


def serves_rays(origins: Array) -> bool:
    """Whether rays of single precision start where it keeps their digits; those that start nowhere do not count."""
    sizes = np.abs(origins)
    if np.fmax.reduce(sizes, axis=None, initial=0.0) <= MOST:
        return True
    return not bool(((sizes > MOST) & np.isfinite(sizes)).any())


def rounded(arrays: Mapping[str, Array]) -> dict[str, Array]:
    """Floating arrays in single precision; infinite where they are larger than it goes."""
    with np.errstate(over="ignore"):
        return {name: x.astype(np.float32) if x.dtype == np.float64 else x for name, x in arrays.items()}


def rounded_hits(hits: Hits) -> Hits:
    """First hits in single precision. A point that is none there is no hit, and has the status INVALID."""
    found = rounded({"t": hits.t, "point": hits.point, "normal": hits.normal, "alpha": hits.alpha})
    lost = hits.hit & ~(np.isfinite(found["t"]) & np.isfinite(found["point"]).all(axis=-1))
    for array in found.values():
        array[lost] = np.nan
    surface, status = np.where(lost, -1, hits.surface), np.where(lost, int(Status.INVALID), hits.status)
    return Hits(found["t"], surface.astype(hits.surface.dtype), status.astype(hits.status.dtype), lambda: found)


def rounded_points(found: Mapping[str, Array]) -> dict[str, Array]:
    """All points of lines in single precision; a line with a point that is none there has none, and is INVALID."""
    single = rounded(found)
    there = np.arange(single["t"].shape[-1]) < single["count"][..., None]
    good = np.isfinite(single["t"]) & np.isfinite(single["point"]).all(axis=-1)
    lost = (there & ~good).any(axis=-1)
    for name in ("alpha", "t", "point", "normal"):
        single[name][lost] = np.nan
    single["row"][lost], single["count"][lost], single["status"][lost] = -1, 0, int(Status.INVALID)
    return single
