"""Box of the view: given by the user, or around finite objects and the points where lines and planes come nearest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..common.validation import real_array
from ..errors import InputError
from .glyphs import Drawable
from .tessellation import FARTHEST, Array, Box, common_point

#: Margin around finite objects, relative to their size.
MARGIN = 0.06
#: Margin around the points where lines and planes come nearest, relative to their extent.
FLAT_MARGIN = 0.35
#: Shortest side of a view before its margin, relative to the longest.
SHORTEST = 0.216
#: Size, relative to the distance from the origin, below which objects count as one point: the view has sides of 1.
POINT = 1e-12


def extent_box(extent: Any) -> Box:
    """Convert an extent, half a side about the origin or two corners, to a box.

    Raises
    ------
    InputError
        If the extent is not valid, or empty.
    """
    try:
        low, high = (-extent, extent) if np.ndim(extent) == 0 else extent
        box = Box(*(np.array(np.broadcast_to(real_array(x, "extent"), 3), float) for x in (low, high)))
        good = bool((np.abs(box) <= FARTHEST).all() and (box.low < box.high).all())
    except (TypeError, ValueError, InputError):
        good = False
    if not good:
        raise InputError(f"extent is {extent}: give half a side, or (low, high) with low < high.")
    return box


def surrounding_box(points: Array, margin: float = MARGIN, shortest: float = SHORTEST, min_side: float = 0.0) -> Box:
    """Box around points (n, 3): the framing of every picture.

    Parameters
    ----------
    points : array (n, 3)
        One at least.
    margin : float
        On each side, relative to the longest side.
    shortest : float
        Shortest side before the margin, relative to the longest.
    min_side : float
        Smallest length of the longest side, for points that coincide.
    """
    low, high = points.min(0), points.max(0)
    longest = max(float((high - low).max()), min_side)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, shortest * longest / 2) + margin * longest
    return Box(middle - half, middle + half)


def automatic_box(drawables: Sequence[Drawable]) -> Box | None:
    """Box around finite objects, and around the points where lines and planes come nearest."""
    if not drawables:
        return None
    finite = np.concatenate([d.bounding_points() for d in drawables])
    flats = [f for d in drawables if (f := d.flats()) is not None]
    if len(finite):
        center = (finite.min(0) + finite.max(0)) / 2
    elif flats:
        center = common_point(np.concatenate([f[0] for f in flats]), np.concatenate([f[1] for f in flats]))
    else:
        center = np.zeros(3)
    content = np.concatenate([finite, *(d.feet(center) for d in drawables)])
    if not len(content):
        return None
    is_point = not np.ptp(content, axis=0).max() > POINT * np.abs(content).max(initial=0.0)
    shortest = SHORTEST if len(finite) else 1.0  # a cube where there are only lines and planes
    return surrounding_box(content, MARGIN if len(finite) else FLAT_MARGIN, shortest, float(is_point))
