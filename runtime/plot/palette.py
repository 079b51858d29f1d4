"""Palette of all pictures, and the conversion of color arguments to rows of RGBA. No matplotlib at import."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .matplotlib_import import colors

Rgba = NDArray[np.float64]

#: Neutral colors: texts and lines, axes, backgrounds.
INK, GREY, PALE = "#22303c", "#8a97a3", "#e8ecef"
#: Colors of objects.
BLUE, RED, GREEN, AMBER = "#2c6fbb", "#c8402f", "#2f9461", "#dd9a10"
PURPLE, TEAL, ROSE, BROWN = "#7d5ba6", "#2a9d9d", "#d16ba5", "#8c6d4f"
#: Colors of arguments and of classes, in order.
SERIES = (BLUE, RED, GREEN, AMBER, PURPLE, TEAL, ROSE, BROWN)
#: Colors of a parameter from its smallest to its largest value: green to red, as in figure 3.1.
RAMP = (GREEN, AMBER, RED)
#: Colors of the axes of a frame.
AXES = (RED, GREEN, BLUE)


def per_item(color: Any, count: int, default: str) -> Rgba:
    """Convert a color argument to RGBA rows: one for all items, or one for each.

    Parameters
    ----------
    color
        None for the default; a color of matplotlib, as text or a tuple; or an array or list with one entry per item:
        integers are classes, other numbers a parameter from green to red, rows are RGB or RGBA, texts are colors.
    count : int
        Number of items.

    Returns
    -------
    array (1, 4) or (count, 4)

    Raises
    ------
    InputError
        If the color is not valid.
    """
    if color is None:
        color = default
    if not isinstance(color, list) and not (isinstance(color, np.ndarray) and color.ndim):
        return _to_rgba(color)[None]
    values = np.asarray(color) if not isinstance(color, list) or not _has_names(color) else None
    if values is not None and values.ndim == 1 and values.dtype.kind in "biuf":
        _check_count(len(values), count)
        return classes(values) if values.dtype.kind in "biu" else ramp(values)
    items = list(color)
    _check_count(len(items), count)
    return np.array([_to_rgba(item) for item in items]).reshape(-1, 4)


def classes(labels: Any) -> Rgba:
    """Rows for integer labels: the colors of the palette in cyclic order, gray for negative labels."""
    labels = np.asarray(labels, int)
    return np.asarray(_table((*SERIES, GREY))[np.where(labels < 0, len(SERIES), labels % len(SERIES))])


def ramp(values: Any) -> Rgba:
    """Rows for numbers, the smallest green, the largest red; gray where they are not finite."""
    values = np.asarray(values, float)
    finite = np.isfinite(values)
    values = np.where(finite, values, 0.0) / 2  # the difference of any two does not overflow
    low, high = (float(values[finite].min()), float(values[finite].max())) if finite.any() else (0.0, 1.0)
    position = np.where(finite, values - low, 0.0) / ((high - low) or 1.0) * (len(RAMP) - 1)
    rows = np.stack([np.interp(position, np.arange(len(RAMP)), column) for column in _table(RAMP).T], -1)
    rows[~finite] = _to_rgba(GREY)
    return rows


def with_opacity(rows: Rgba, opacity: float) -> Rgba:
    """Multiply the opacity of rows."""
    return np.asarray(rows * np.array([1.0, 1.0, 1.0, opacity]))


def take_rows(rows: Rgba, indices: NDArray[np.intp]) -> Rgba:
    """Rows of selected items."""
    return rows if len(rows) == 1 else rows[indices]


@lru_cache(maxsize=2)
def _table(colors: tuple[str, ...]) -> Rgba:
    return np.array([_to_rgba(color) for color in colors])


def _to_rgba(color: Any) -> Rgba:
    try:
        return np.array(colors().to_rgba(color))
    except (ValueError, TypeError):
        raise InputError(
            f"{color!r} is not a valid color.",
            remedy="Give a name or '#rrggbb', labels or numbers (one per item), or rows of RGB",
        ) from None


def _has_names(color: Sequence[Any]) -> bool:
    return any(not isinstance(c, float | int | np.number) for c in color)


def _check_count(entries: int, count: int) -> None:
    if entries != count:
        raise InputError(f"color has {entries} entries for {count} items.", remedy="Give one color, or one per item")
