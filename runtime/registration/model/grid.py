"""Grids of positions, in which a driver looks up the objects near a position."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
#: Fraction of the objects beyond the regular cells, at either end of an axis: they belong to the outermost cells.
OUTER_FRACTION = 0.05
#: Largest number of cells along an axis.
MAX_SIDE = 128
#: Smallest sides of a grid: relative to the longest one, and absolute.
MIN_SIDE_RATIO, TINY = 1e-3, float(np.finfo(np.float64).tiny) ** 0.25


@dataclass(frozen=True)
class Grid:
    """Elements in the cells of a grid of their positions, about one to a cell.

    Attributes
    ----------
    corner : (float, float, float)
        Corner of the first cell.
    scale : float
        Cells per length.
    sides : (int, int, int)
        Cells along each axis; positions beyond them belong to the outermost ones.
    starts : int32 array (cells + 1,)
        Index of the first object of each cell in ``order``.
    order : int32 array (n,)
        Rows of objects, cell by cell.
    elements : array (n, 7)
        Elements in this order.
    """

    corner: tuple[float, float, float]
    scale: float
    sides: tuple[int, int, int]
    starts: Array
    order: Array
    elements: Array


def grid_of(elements: Array) -> Grid:
    """Grid of elements (n, 7), without elements that are not finite."""
    rows = np.arange(len(elements), dtype=np.int32)
    good = np.isfinite(elements)
    if not good.all():
        rows = rows[good.all(-1)]
        elements = elements[rows]
    n, places = len(rows), elements[:, :3]
    sorted_ = np.sort(places, axis=0) if n else np.zeros((1, 3))
    low, high = (sorted_[round(q * (len(sorted_) - 1))].tolist() for q in (OUTER_FRACTION, 1 - OUTER_FRACTION))
    # three numbers: faster one by one
    spans = [b - a for a, b in zip(low, high, strict=True)]
    x, y, z = (max(span, MIN_SIDE_RATIO * max(*spans, TINY)) for span in spans)
    scale = max(1.0, n ** (1 / 3)) / (x * y * z) ** (1 / 3)
    width, depth, height = (min(max(math.ceil(span * scale), 1), MAX_SIDE) for span in spans)
    cells = np.minimum(np.maximum((places - low) * scale, 0), (width - 1, depth - 1, height - 1)).astype(np.int64)
    number = cells @ np.array((depth * height, height, 1))
    order = np.argsort(number, kind="stable")
    starts = np.zeros(width * depth * height + 1, np.int32)
    np.cumsum(np.bincount(number, minlength=len(starts) - 1), out=starts[1:])
    return Grid((low[0], low[1], low[2]), scale, (width, depth, height), starts, rows[order], elements[order])
