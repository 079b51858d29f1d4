"""Two models as the drivers of all backends read them: rows of numbers, a grid of the reference's positions, and when
two objects may be one. NumPy alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
#: Numbers of an element: position, direction, radius.
ELEMENT = 7
#: Share of objects that a grid may leave to its outermost cells, at either end; cells along an axis at most.
OUTER, MOST_SIDE = 0.05, 128
TINY = np.finfo(np.float64).tiny ** 0.25


@dataclass(frozen=True)
class Side:
    """One model as the driver reads it.

    Attributes
    ----------
    rows : mapping of kind to array (n, k)
        Coefficients of unit objects.
    elements : mapping of kind to array (n, 7)
        Positions, directions and radii (formula `registration.element`).
    """

    rows: Mapping[str, Array]
    elements: Mapping[str, Array]


@dataclass(frozen=True)
class Grid:
    """Elements in the cells of a grid of their positions, about one to a cell.

    Attributes
    ----------
    corner : array (3,)
        Where the first cell begins.
    scale : float
        Cells per length.
    sides : (int, int, int)
        Cells along each axis; what lies beyond belongs to the outermost ones.
    starts : int32 array (cells + 1,)
    order : int32 array (n,)
        Rows, cell by cell.
    elements : array (n, 7)
        In that order.
    """

    corner: Array
    scale: float
    sides: tuple[int, int, int]
    starts: Array
    order: Array
    elements: Array


def grid_of(elements: Array) -> Grid:
    """The grid of some elements (n, 7); those that are not finite are left out."""
    rows = np.flatnonzero(np.isfinite(elements).all(-1)).astype(np.int32)
    places = elements[rows, :3]
    n = len(rows)
    sorted_ = np.sort(places, axis=0) if n else np.zeros((1, 3))
    low, high = (sorted_[round(q * (len(sorted_) - 1))] for q in (OUTER, 1 - OUTER))
    size = float(np.prod(np.maximum(high - low, 1e-3 * max(float((high - low).max()), TINY)))) ** (1 / 3)
    scale = max(1.0, n ** (1 / 3)) / size
    sides = np.minimum(np.maximum(np.ceil((high - low) * scale), 1), MOST_SIDE).astype(np.int64)
    cells = np.clip(np.floor((places - low) * scale), 0, sides - 1).astype(np.int64)
    number = (cells[:, 0] * sides[1] + cells[:, 1]) * sides[2] + cells[:, 2]
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.arange(int(sides.prod()) + 1)).astype(np.int32)
    shape = (int(sides[0]), int(sides[1]), int(sides[2]))
    return Grid(low, scale, shape, starts, rows[order], elements[rows[order]])


@dataclass(frozen=True)
class Closeness:
    """When two objects may be one.

    Attributes
    ----------
    weights : (float, float, float)
        Of squared differences of positions, directions and radii.
    limit : float
        The sum of them up to which they may be one.
    least : float
        A motor is given up early if a smaller share of objects has a counterpart.
    align : bool
        x and -x are one object.
    """

    weights: tuple[float, float, float]
    limit: float
    least: float = 0.0
    align: bool = True
