"""Where joints are, and how large: places on their objects, the midst of all, and lengths that are not rounding."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..calls import call
from ..lengths import lengths_of
from ..multivector import Multivector

Array = NDArray[Any]
#: Lengths below this share of the distance from the origin are rounding: that of squares of distances.
RESOLVED = float(np.sqrt(np.finfo(float).eps))
#: Squared angles of lines or planes, by share, below which these are parallel and meet nowhere near.
PARALLEL = 1e-3


def places_of(objects: list[Multivector], count: int, near: Array | None = None) -> Array:
    """A place (n, 3) for each joint: on all its objects, as well as can be, and near some place (3,)."""
    near = np.zeros(3) if near is None else near
    held, short = np.zeros((count, 3, 3)), np.zeros((count, 3))
    for x in objects:
        places, across = _extent(x)
        held = held + across
        short = short + (across @ (places - near)[..., None])[..., 0]
    found: Array = near + (np.linalg.pinv(held, rcond=PARALLEL, hermitian=True) @ short[..., None])[..., 0]
    return found


def midst_of(groups: Sequence[list[Multivector]]) -> Array:
    """The place (3,) that is nearest to all objects of joints."""
    held, short = np.zeros((3, 3)), np.zeros(3)
    for x in (x for objects in groups for x in objects):
        places, across = _extent(x)
        held = held + across.sum(0)
        short = short + (across @ places[..., None])[..., 0].sum(0)
    found: Array = np.linalg.pinv(held, rcond=PARALLEL, hermitian=True) @ short
    return found


def spread_of(places: Array, center: Array) -> float:
    """How far places are from a center; 0 for what is rounding of where they are."""
    found = float(np.abs(places - center).max(initial=0))
    return found if found > RESOLVED * float(np.abs(places).max(initial=0)) else 0.0


def units_of(local: Sequence[Multivector], places: Array, spread: float) -> Array:
    """A length (n,), a power of two, for objects seen from their places; some other for those that have none."""
    lengths = np.max([lengths_of(x) for x in local], 0)
    resolved = lengths > RESOLVED * np.linalg.norm(places, axis=-1)
    return np.asarray(2.0 ** np.round(np.log2(np.where(resolved, lengths, spread or 1.0))))


def _extent(x: Multivector) -> tuple[Array, Array]:
    """Places (n, 3) on objects, and projectors (n, 3, 3) across what they extend along: lines, planes."""
    count = len(x.values)
    for kind in ("point", "flat_point", "sphere", "circle", "point_pair", "line", "plane"):
        if kind in x.algebra.kinds and set(x.kind.blades) == set(x.algebra.kind(kind).blades):
            p = x.as_kind(kind, check=False).parameters()
            if hasattr(p, "a"):
                return _usable((p.a + p.b) / 2, np.eye(3))
            if kind not in ("line", "plane"):
                return _usable(getattr(p, "xyz", getattr(p, "center", None)), np.eye(3))
            way = p.direction if kind == "line" else p.normal
            square = (way * way).sum(-1)
            square = np.where(square > 0, square, np.inf)
            along = way[..., :, None] * way[..., None, :] / square[..., None, None]
            if kind == "line":
                return _usable(p.point / square[..., None], np.eye(3) - along)
            return _usable((p.offset / square)[..., None] * way, along)
    if set(x.kind.blades) == set(x.algebra.kind("twist").blades):
        turn, way = (v.values for v in call(x.algebra, "mechanics.screw_vectors", x).values)
        square = (turn * turn).sum(-1)[..., None]
        square = np.where(square > 0, square, np.inf)
        along = turn[..., :, None] * turn[..., None, :] / square[..., None]
        return _usable(np.cross(turn, way) / square, np.eye(3) - along)
    return np.zeros((count, 3)), np.zeros((count, 3, 3))


def _usable(places: Any, across: Array) -> tuple[Array, Array]:
    """Those that are numbers."""
    places = np.asarray(places, float)
    good = np.isfinite(places).all(-1)
    return np.where(good[..., None], places, 0.0), np.where(good[..., None, None], across, 0.0)
