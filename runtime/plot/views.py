"""The box that a picture shows: given, or around everything finite and where lines and planes come nearest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import InputError
from . import checks
from .outlines import Drawable
from .shapes import Box, common_point

#: Room around what is finite, and around where lines and planes pass each other, over its size.
MARGIN, FLAT_MARGIN = 0.06, 0.35
#: The shortest side of a view, over its longest.
FLATTEST = 0.3
#: What is smaller than this, over its distance from the origin, is one point: its view has sides of about 1.
POINT = 1e-12


def given_box(extent: Any) -> Box:
    """A half side about the origin, or two corners.

    Raises
    ------
    InputError
        If it is neither, or empty.
    """
    try:
        low, high = (-extent, extent) if np.ndim(extent) == 0 else extent
        box = Box(*(np.array(np.broadcast_to(checks.numbers(x, "extent"), 3)) for x in (low, high)))
        good = bool((np.abs(box) <= checks.FARTHEST).all() and (box.low < box.high).all())
    except (TypeError, ValueError, InputError):
        good = False
    if not good:
        raise InputError(f"extent is {extent}: give half a side, or (low, high) with low < high.")
    return box


def automatic_box(drawables: Sequence[Drawable]) -> Box | None:
    """The box around everything finite, and around where what is infinite comes nearest."""
    if not drawables:
        return None
    finite = np.concatenate([d.reach() for d in drawables])
    flats = [f for d in drawables if (f := d.flats()) is not None]
    if len(finite):
        center = (finite.min(0) + finite.max(0)) / 2
    elif flats:
        center = common_point(np.concatenate([f[0] for f in flats]), np.concatenate([f[1] for f in flats]))
    else:
        center = np.zeros(3)
    held = np.concatenate([finite, *(d.feet(center) for d in drawables)])
    if not len(held):
        return None
    low, high = held.min(0), held.max(0)
    longest = float((high - low).max())
    if not longest > POINT * np.abs(held).max(initial=0.0):
        longest = 1.0
    room = longest * (MARGIN if len(finite) else FLAT_MARGIN)
    half = np.maximum((high - low) / 2 + room, FLATTEST * (longest / 2 + room))
    if not len(finite) and flats:
        half = np.full(3, half.max())
    middle = (low + high) / 2
    return Box(middle - half, middle + half)
