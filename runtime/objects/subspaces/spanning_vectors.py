"""Blades item by item: their grades and statuses, orthonormal vectors that span them, units of length.

Vectors are taken from a blade by contractions in coordinates, which no metric enters; ranks are decided by singular
values. What joins, meets and factorisations make of it is in `subspaces`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import GradeError
from ...codegen.formulas.objects.subspaces import contractions, length_powers
from ...common.validation import as_float, as_instance
from ...core import kind_constraints
from ...core.multivector import Algebra, Multivector
from ...dispatch.coefficients import embed
from ...status import Status

Array = NDArray[np.float64]
Codes = NDArray[np.uint8]
#: Below the exponent of any coefficient after any change of units.
LEAST = -(1 << 20)


@dataclass(frozen=True)
class Items:
    """Items of a batch, flat: the grade of each, and its status."""

    algebra: Algebra
    source: Multivector
    grades: NDArray[np.int64]
    status: Codes

    def rows(self, g: int) -> Array:
        """Coefficients of one grade, on all its blades."""
        layout = self.algebra.layout_of(self.algebra.blades_of_grade(g))
        return embed(self.source, layout).astype(float).reshape(-1, layout.size)


def items_of(x: Any, tolerance: float | None) -> Items:
    """Grades and statuses: SINGULAR for zero, INVALID for what is not finite or no blade."""
    as_instance(x, "an operand", Multivector, "a multivector", remedy="Make one with an algebra")
    limit = relative_limit(x.dtype, tolerance)
    flat = x.reshape(-1)
    with np.errstate(all="ignore"):
        sizes = np.stack([np.abs(flat.grade(g)._data.astype(float)).max(-1) for g in flat.grades], -1)
        total = sizes.max(-1)
        present = sizes > limit * total[:, None]
    grades = np.array(flat.grades)[np.argmax(sizes, -1)] if len(flat) else np.zeros(0, np.int64)
    status = np.where(total == 0, np.uint8(Status.SINGULAR), np.uint8(Status.OK))
    status[~np.isfinite(total) | (present.sum(-1) > 1)] = Status.INVALID
    items = Items(x.algebra, flat, grades, status)
    shift = shifts(x.algebra, items)
    for g in flat.grades:
        mine = np.flatnonzero((status == Status.OK) & (grades == g))
        if len(mine) and 1 < g < x.algebra.dimension - 1:  # vectors and their complements always are
            defect = span(x.algebra, g, scale_lengths(x.algebra, g, items.rows(g)[mine], -shift[mine]))[1]
            status[mine[~(defect <= limit)]] = Status.INVALID
    return items


def relative_limit(dtype: np.dtype[Any], tolerance: float | None) -> float:
    if tolerance is None:
        return kind_constraints.tolerance(dtype)
    return as_float(tolerance, "tolerance", 0.0, below=1.0)


def only_grade(items: Items, answered: NDArray[np.bool_]) -> int:
    """The grade of all items."""
    found = items.grades[answered]
    g = int(found[0]) if len(found) else max(items.source.grades)
    other = np.flatnonzero(answered & (items.grades != g))
    if len(other):
        where = f"item {other[0]} has grade {items.grades[other[0]]}, the first one {g}"
        raise GradeError(f"{where}; factors are those of one grade.", remedy="Select items of one grade")
    if g == 0:
        raise GradeError("a scalar has no factors; they are those of grades from 1.")
    return g


def span(algebra: Algebra, g: int, rows: Array) -> tuple[Array, Array]:
    """Orthonormal columns (k, n, g) that span each blade, and the singular value after them, relative."""
    n = algebra.dimension
    if g == 0:
        return np.zeros((len(rows), n, 0)), np.zeros(len(rows))
    place, weight = _table(algebra, g)
    size = np.abs(rows).max(-1, initial=0.0, keepdims=True)
    matrix = (rows / np.where(size > 0, size, 1.0))[:, place] * weight
    _, sigma, vt = np.linalg.svd(matrix, full_matrices=False)
    rest = sigma[:, g] if sigma.shape[-1] > g else np.zeros(len(rows))
    with np.errstate(all="ignore"):
        defect = rest / sigma[:, 0]
    return np.ascontiguousarray(np.swapaxes(vt[:, :g], -1, -2)), defect


@lru_cache(maxsize=64)
def _table(algebra: Algebra, g: int) -> tuple[NDArray[np.int64], Array]:
    """Indices of the contractions' coefficients in those of the blade, and their signs."""
    entries = contractions(algebra, g)
    shape = (max(e.row for e in entries) + 1, algebra.dimension)
    place, weight = np.zeros(shape, np.int64), np.zeros(shape)
    for e in entries:
        place[e.row, e.column], weight[e.row, e.column] = e.coefficient, float(e.weight)
    return place, weight


def outer_of(algebra: Algebra, factors: Array) -> Multivector:
    """The outer product of the columns (k, n, r)."""
    vectors = [on_grades(algebra, (1,), v, None, v.shape[:-1]) for v in np.moveaxis(factors, -1, 0)]
    one = algebra.scalar(np.ones(len(factors)))
    return reduce(lambda x, y: x ^ y, vectors) if vectors else one


def on_grades(
    algebra: Algebra, grades: tuple[int, ...], data: Any, status: Any, shape: tuple[int, ...], dtype: Any = float
) -> Multivector:
    """Coefficients on all blades of some grades."""
    kind = algebra.layout_of(b for g in grades for b in algebra.blades_of_grade(g))
    code = None if status is None or not status.any() else np.array(status, np.uint8).reshape(shape)
    rows = np.ascontiguousarray(data, np.dtype(dtype)).reshape(*shape, kind.size)
    return Multivector._make(algebra.type_of(kind, rows.dtype), rows, shape, code)


# -- units of length ---------------------------------------------------------------------------------------


def shifts(algebra: Algebra, items: Items) -> NDArray[np.int32]:
    """Powers of two that lengths are to be divided by, so that none is far above one: an exact change of units.

    Of small ones nothing is known: they may be rounding errors of zero.
    """
    shift = np.zeros(len(items.status), np.int32)
    for g in items.source.grades:
        mine = np.flatnonzero((items.status == Status.OK) & (items.grades == g))
        blades = tuple(int(b) for b in algebra.blades_of_grade(g))
        powers = np.array(length_powers(algebra, blades))
        if not len(mine) or not powers.any():
            continue
        rows = np.abs(items.rows(g)[mine])
        low, level, high = (rows[:, powers == p].max(-1, initial=0.0) for p in (-1, 0, 1))
        with np.errstate(all="ignore"):
            ratio = np.where(low > 0, np.sqrt(high / low), np.where(level > 0, high / level, 1.0))
            shift[mine] = np.maximum(np.frexp(np.where(np.isfinite(ratio), ratio, 1.0))[1] - 1, 0)
    return shift


def scale_lengths(algebra: Algebra, g: int, rows: Array, shift: NDArray[np.int32], keeps_size: bool = False) -> Array:
    """Coefficients after lengths were multiplied by 2^shift: up to a power of two, so that the largest is about one,
    or, with ``keeps_size``, as they are, which may overflow.
    """
    powers = np.array(length_powers(algebra, tuple(int(b) for b in algebra.blades_of_grade(g))), np.int32)
    if not powers.any() or not shift.any():
        return rows
    exponents = shift[..., None] * powers
    if not keeps_size:
        exponents = exponents - np.where(rows != 0, np.frexp(rows)[1] + exponents, LEAST).max(-1, keepdims=True)
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(np.ldexp(rows, exponents))


__all__ = [
    "Items",
    "items_of",
    "on_grades",
    "only_grade",
    "outer_of",
    "relative_limit",
    "scale_lengths",
    "shifts",
    "span",
]
