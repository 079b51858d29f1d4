"""Criteria for work in single precision; elsewhere work is done in double precision and rounded at the end.

Products of lengths above about 1e19 overflow float32, and those below 1e-19 vanish: roots would be lost. On evolved
surfaces, whose polynomials are of high degree, single precision finds fewer roots, and is not faster.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.tracer.surface_kinds import surface_kind
from ...status import Status
from .hits import Hits
from .surface_tables import SurfaceTables

Array = NDArray[Any]
#: Smallest size of a surface: products of three such lengths keep their digits in float32.
MIN_SIZE = 1e-11
#: Largest coordinate: products of three such lengths are float32 numbers.
MAX_COORDINATE = 1e12


def single_suffices_for_kinds(kinds: Iterable[str]) -> bool:
    """Test whether these kinds of surface allow single precision: none may need root isolation."""
    return not any(surface_kind(kind).methods for kind in kinds)


def single_suffices_for_surfaces(rows: SurfaceTables) -> bool:
    """Test whether single precision keeps the digits of sizes and positions of all surfaces."""
    for part in rows.values():
        low, high = part.boxes[:, :3], part.boxes[:, 3:]
        side = (high - low).max(axis=1)
        bounded = np.isfinite(side)
        sides, farthest = side[bounded], np.maximum(np.abs(low), np.abs(high))[bounded]
        if sides.min(initial=MAX_COORDINATE) < MIN_SIZE or farthest.max(initial=0.0) > MAX_COORDINATE:
            return False
        flat = part.constants[~bounded]
        if np.abs(flat).max(initial=0.0) > MAX_COORDINATE:
            return False
    return True


def single_suffices_for_rays(origins: Array) -> bool:
    """Test whether single precision keeps the digits of rays' origins; origins that are not finite do not count."""
    sizes = np.abs(origins)
    if np.fmax.reduce(sizes, axis=None, initial=0.0) <= MAX_COORDINATE:
        return True
    return not bool(((sizes > MAX_COORDINATE) & np.isfinite(sizes)).any())


def to_single(arrays: Mapping[str, Array]) -> dict[str, Array]:
    """Round floating arrays to single precision; infinite where they overflow."""
    with np.errstate(over="ignore"):
        return {name: x.astype(np.float32) if x.dtype == np.float64 else x for name, x in arrays.items()}


def hits_to_single(hits: Hits) -> Hits:
    """Round first hits to single precision. A hit whose point overflows is no hit, and has the status INVALID."""
    arrays = to_single({"t": hits.t, "point": hits.point, "normal": hits.normal, "alpha": hits.alpha})
    lost = hits.hit & ~(np.isfinite(arrays["t"]) & np.isfinite(arrays["point"]).all(axis=-1))
    for array in arrays.values():
        array[lost] = np.nan
    surface, status = np.where(lost, -1, hits.surface), np.where(lost, int(Status.INVALID), hits.status)
    return Hits(arrays["t"], surface.astype(hits.surface.dtype), status.astype(hits.status.dtype), lambda: arrays)


def points_to_single(arrays: Mapping[str, Array]) -> dict[str, Array]:
    """Round all points of lines to single precision; a line with a point that overflows has none, and is INVALID."""
    single = to_single(arrays)
    there = np.arange(single["t"].shape[-1]) < single["count"][..., None]
    good = np.isfinite(single["t"]) & np.isfinite(single["point"]).all(axis=-1)
    lost = (there & ~good).any(axis=-1)
    for name in ("alpha", "t", "point", "normal"):
        single[name][lost] = np.nan
    single["row"][lost], single["count"][lost], single["status"][lost] = -1, 0, int(Status.INVALID)
    return single
