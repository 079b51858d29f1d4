"""The colours of all pictures: one palette, and the ways of giving a colour to each item. No matplotlib at import."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .backend import colors

Rgba = NDArray[np.float64]

INK, GREY, PALE = "#22303c", "#8a97a3", "#e8ecef"
BLUE, RED, GREEN, AMBER = "#2c6fbb", "#c8402f", "#2f9461", "#dd9a10"
PURPLE, TEAL, ROSE, BROWN = "#7d5ba6", "#2a9d9d", "#d16ba5", "#8c6d4f"
#: Colours of things and of classes, in order.
SERIES = (BLUE, RED, GREEN, AMBER, PURPLE, TEAL, ROSE, BROWN)
#: A parameter from its smallest to its largest value: green to red, as in figure 3.1.
RAMP = (GREEN, AMBER, RED)
#: The axes of a frame.
AXES = (RED, GREEN, BLUE)


def per_item(color: Any, count: int, default: str) -> Rgba:
    """RGBA rows: one for all items, or one for each.

    Parameters
    ----------
    color
        None for the default; a colour of matplotlib, as text or a tuple; or an array or list with one entry per item:
        integers are classes, other numbers a parameter from green to red, rows are RGB or RGBA, texts are colours.
    count : int
        Number of items.

    Returns
    -------
    array (1, 4) or (count, 4)

    Raises
    ------
    InputError
        If it is none of those.
    """
    if color is None:
        color = default
    if not isinstance(color, list) and not (isinstance(color, np.ndarray) and color.ndim):
        return _converted(color)[None]
    values = np.asarray(color) if not isinstance(color, list) or not _has_names(color) else None
    if values is not None and values.ndim == 1 and values.dtype.kind in "biuf":
        _check_count(len(values), count)
        return classes(values) if values.dtype.kind in "biu" else ramp(values)
    items = list(color)
    _check_count(len(items), count)
    return np.array([_converted(item) for item in items]).reshape(-1, 4)


def classes(labels: Any) -> Rgba:
    """Rows for integer labels: the palette's colours in turn, grey for negative ones."""
    table = np.array([_converted(c) for c in (*SERIES, GREY)])
    labels = np.asarray(labels, int)
    return np.asarray(table[np.where(labels < 0, len(SERIES), labels % len(SERIES))])


def ramp(values: Any) -> Rgba:
    """Rows for numbers, the smallest green, the largest red; grey where they are not finite."""
    values = np.asarray(values, float)
    known = np.isfinite(values)
    values = np.where(known, values, 0.0) / 2  # the difference of any two is a number
    low, high = (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 1.0)
    place = np.where(known, values - low, 0.0) / ((high - low) or 1.0) * (len(RAMP) - 1)
    table = np.array([_converted(c) for c in RAMP])
    rows = np.stack([np.interp(place, np.arange(len(RAMP)), column) for column in table.T], -1)
    rows[~known] = _converted(GREY)
    return rows


def faded(rows: Rgba, opacity: float) -> Rgba:
    """The same colours, less opaque."""
    return np.asarray(rows * np.array([1.0, 1.0, 1.0, opacity]))


def chosen(rows: Rgba, places: NDArray[np.intp]) -> Rgba:
    """Rows of some items."""
    return rows if len(rows) == 1 else rows[places]


def _converted(color: Any) -> Rgba:
    try:
        return np.array(colors().to_rgba(color))
    except (ValueError, TypeError):
        raise InputError(
            f"{color!r} is no colour.",
            remedy="Give a name or '#rrggbb', labels or numbers (one per item), or rows of RGB",
        ) from None


def _has_names(color: Sequence[Any]) -> bool:
    return any(not isinstance(c, float | int | np.number) for c in color)


def _check_count(given: int, count: int) -> None:
    if given != count:
        raise InputError(f"color has {given} entries for {count} items.", remedy="Give one colour, or one per item")
