"""Blades of any algebra as subspaces: blade tests, factorisation, join and meet in every position.

Nothing here uses the metric: vectors are taken from a blade by contractions in coordinates (Fontijne 2008, Dorst,
Fontijne and Mann 2007, ch. 21), ranks are decided by singular values, products are the algebra's own.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import AlgebraMismatchError
from ...codegen.formulas.products.outcome import NOISE
from ...common.deprecation import renamed_keywords
from ...common.validation import as_bool
from ...core.multivector import Algebra, Multivector
from ...dispatch.coefficients import broadcast, embed
from ...dispatch.item_statuses import raise_first
from ...status import Status
from .spanning_vectors import items_of, on_grades, only_grade, outer_of, relative_limit, scale_lengths, shifts, span

Array = NDArray[np.float64]


def is_blade(x: Multivector, tolerance: float | None = None) -> np.bool_ | NDArray[np.bool_]:
    """Test whether items are blades: of one grade, and outer products of vectors, null or not, in any metric.

    Parameters
    ----------
    x : Multivector, shape (...)
    tolerance : float, optional
        How large the singular value after the last one of a blade may be, relative to the largest. Default: 4096
        rounding units. It bounds the change that makes x a blade, in units in which no length exceeds one.

    Returns
    -------
    bool or array (...)
        False for zero, which stands for no subspace, and for what is not finite.
    """
    items = items_of(x, tolerance)
    found: NDArray[np.bool_] = items.status == Status.OK
    return found.reshape(x.shape)[()]


def factorise(x: Multivector, tolerance: float | None = None, strict: bool = False) -> Multivector:
    """Vectors whose outer product is the blade x.

    Parameters
    ----------
    x : Multivector, shape (...)
        Blades of one grade, at least 1; null ones too.
    tolerance : float, optional
        See `is_blade`.
    strict : bool
        Raise `SingularError` for the first item that is not a blade.

    Returns
    -------
    Multivector, shape (grade, ...)
        The first axis runs over the factors: ``a, b, c = factorise(circle)``. They are orthogonal in coordinates (with
        lengths scaled down to one where they are larger); all but the first have unit coefficients there, and the
        first carries the scale. Items that are no blade are `INVALID`, zero is `SINGULAR`.

    Raises
    ------
    GradeError
        If items have different grades, or are scalars, which have no factors.
    """
    items = items_of(x, tolerance)
    answered = items.status == Status.OK
    g = only_grade(items, answered)
    shift = shifts(items.algebra, items)
    data = np.full((g, len(items.status), items.algebra.dimension), np.nan)
    mine = np.flatnonzero(answered)
    if len(mine):
        unit = scale_lengths(items.algebra, g, items.rows(g)[mine], -shift[mine], keeps_size=True)
        factors = span(items.algebra, g, unit)[0]
        blade = outer_of(items.algebra, factors)._data
        vectors = np.moveaxis(factors, -1, 0).copy()
        with np.errstate(over="ignore", invalid="ignore"):
            vectors[0] *= ((unit * blade).sum(-1) / (blade * blade).sum(-1))[:, None]
            back = np.broadcast_to(shift[mine], vectors.shape[:-1])
            data[:, mine] = scale_lengths(items.algebra, 1, vectors, back, keeps_size=True)
        _refuse_overflow(data.swapaxes(0, 1).reshape(len(items.status), -1), items.status)
        data[:, items.status == Status.INVALID] = np.nan
    status = np.broadcast_to(items.status, (g, len(items.status)))
    found = on_grades(items.algebra, (1,), data, status, (g, *x.shape), x.dtype)
    if as_bool(strict, "strict"):
        raise_first(items.status.reshape(x.shape), "factorise")
    return found


factorize = factorise


@renamed_keywords(a="X", b="Y")
def join(X: Multivector, Y: Multivector, tolerance: float | None = None, strict: bool = False) -> Multivector:
    """The smallest object that holds two: the span of blades in any position, also where they overlap.

    Parameters
    ----------
    X, Y : Multivector, shapes broadcasting to (...)
        Blades of one algebra: of any grades, null, equal, nested.
    tolerance : float, optional
        Sine of the angle, in coordinates, below which two directions are one; also that of the blade test. Lengths
        above one are scaled down to one first: far from the origin, distances count relative to that from it.
        Default: 4096 rounding units, 9e-13.
    strict : bool
        Raise `SingularError` for the first item that is not a blade.

    Returns
    -------
    Multivector, shape (...)
        X ^ Y where the two have nothing in common; the larger where it holds the smaller; the pseudoscalar where that
        is all; otherwise coefficients of unit size, the first that is not small positive. Where items of a batch have
        joins of different grades, the result has blades of all of them, and each item is a blade of its own grade;
        where all are flat, only those of flat objects (`normalized` makes lines and planes of them).
        Items that are no blades are `INVALID`; zero is `SINGULAR`.

    Notes
    -----
    Objects of plane-based geometry (degenerate metrics) are built from planes: there, as everywhere in this package,
    the join of two objects is what their vectors have in common, and `meet` what they span.
    """
    return _of_pair(X, Y, tolerance, strict, "join")


@renamed_keywords(a="X", b="Y")
def meet(X: Multivector, Y: Multivector, tolerance: float | None = None, strict: bool = False) -> Multivector:
    """The largest object in two: the intersection with respect to their join.

    Parameters, statuses and grades as for `join`.

    Returns
    -------
    Multivector, shape (...)
        ``X & Y`` where the join is the whole space; the smaller where the larger holds it; the scalar 1 where nothing
        is common; otherwise coefficients of unit size. With the join J it is oriented so that X = A ^ M, Y = M ^ B
        and J = A ^ M ^ B, up to a positive factor, unless ``X & Y`` or a contained object says its own.
    """
    return _of_pair(X, Y, tolerance, strict, "meet")


# -- two blades --------------------------------------------------------------------------------------------


def _of_pair(a: Any, b: Any, tolerance: float | None, strict: bool, name: str) -> Multivector:
    """Join or meet of every pair: pairs of the same grades and the same overlap go together."""
    left, right = items_of(a, tolerance), items_of(b, tolerance)
    algebra = left.algebra
    if right.algebra is not algebra:
        raise AlgebraMismatchError(f"objects of {algebra.name} and of {right.algebra.name} do not mix; convert one.")
    shape = broadcast(a, b)
    dtype = np.result_type(a.dtype, b.dtype)
    limit = relative_limit(dtype, tolerance)
    i, j = (np.broadcast_to(np.arange(x.size).reshape(x.shape), shape).ravel() for x in (a, b))
    spans = (name == "join") != algebra.is_degenerate
    status = np.where(left.status[i] != Status.OK, left.status[i], right.status[j])
    shift = np.maximum(shifts(algebra, left)[i], shifts(algebra, right)[j])
    parts: list[tuple[int, NDArray[np.int64], Array]] = []
    for ga, gb, mine in _groups(left.grades[i], right.grades[j], status == Status.OK):
        pair = _Pair(algebra, ga, gb, left.rows(ga)[i[mine]], right.rows(gb)[j[mine]], shift[mine], limit)
        for r in range(max(0, ga + gb - algebra.dimension), min(ga, gb) + 1):
            items = np.flatnonzero(pair.common == r)
            if len(items):
                parts.append(
                    (ga + gb - r if spans else r, mine[items], pair.span(items, r) if spans else pair.part(items, r))
                )
    usual = min(max(a.grades) + max(b.grades), algebra.dimension)
    grades = tuple(sorted({g for g, _, _ in parts})) or (usual if spans else max(a.grades) + max(b.grades) - usual,)
    sizes = [len(list(algebra.blades_of_grade(g))) for g in grades]
    data = np.zeros((len(status), sum(sizes)))
    data[status != Status.OK] = np.nan
    for g, where, rows in parts:
        start = sum(sizes[: grades.index(g)])
        data[where, start : start + rows.shape[-1]] = rows
    _refuse_overflow(data, status)
    found = _to_smallest_layout(on_grades(algebra, grades, data, status, shape, dtype))
    if as_bool(strict, "strict"):
        raise_first(found._status, name)
    return found


def _refuse_overflow(data: Array, status: NDArray[np.uint8]) -> None:
    """Items (n, k) of results that no double can hold become INVALID, and NaN."""
    lost = (status == Status.OK) & ~np.isfinite(data).all(-1)
    status[lost], data[lost] = Status.INVALID, np.nan


def _to_smallest_layout(x: Multivector) -> Multivector:
    """x on the blades of the smallest kind that has all of its coefficients: lines and planes where all are flat."""
    used = {b for b, column in zip(x._type.blades, np.moveaxis(x._data, -1, 0), strict=True) if column.any()}
    kinds = [k for k in x.algebra.kinds.values() if k.constraints and used <= set(k.blades) <= set(x._type.blades)]
    if not used or not kinds:
        return x
    layout = min(kinds, key=lambda k: k.size).layout
    return Multivector._make(x.algebra.type_of(layout, x.dtype), embed(x, layout), x.shape, x._status)


def _groups(
    first: NDArray[np.int64], second: NDArray[np.int64], answered: NDArray[np.bool_]
) -> Iterator[tuple[int, int, NDArray[np.int64]]]:
    """Pairs of grades, and the items that have them."""
    for ga in np.unique(first[answered]):
        for gb in np.unique(second[answered & (first == ga)]):
            yield int(ga), int(gb), np.flatnonzero(answered & (first == ga) & (second == gb))


class _Pair:
    """Blades A and B of two grades, k of each, and what they have in common.

    With orthonormal columns Qa, Qb in shifted units, the singular values of Qb - Qa Qa^T Qb are the sines of the
    principal angles: zero for common directions, which are Qb times the right singular vectors.
    """

    def __init__(
        self, algebra: Algebra, ga: int, gb: int, a: Array, b: Array, shift: NDArray[np.int32], limit: float
    ) -> None:
        self.algebra, self.ga, self.gb, self.a, self.b, self.shift = algebra, ga, gb, a, b, shift
        qa = span(algebra, ga, scale_lengths(algebra, ga, a, -shift))[0]
        qb = span(algebra, gb, scale_lengths(algebra, gb, b, -shift))[0]
        rest = qb - qa @ (np.swapaxes(qa, -1, -2) @ qb)
        if gb:
            self.u, sines, vt = np.linalg.svd(rest, full_matrices=False)
            self.principal = qb @ np.swapaxes(vt, -1, -2)
        else:
            self.u, sines, self.principal = rest, np.zeros((len(a), 0)), rest
        self.common = np.maximum(gb - (sines > limit).sum(-1), ga + gb - algebra.dimension)

    def _original(self, grade: int, rows: Array) -> Multivector:
        return on_grades(self.algebra, (grade,), rows, None, (len(rows),))

    def span(self, items: NDArray[np.int64], r: int) -> Array:
        """A + B as subspaces, for items with r common directions."""
        total = self.ga + self.gb - r
        if r == self.gb:
            return self.a[items]
        if r == self.ga:
            return self.b[items]
        if r == 0:
            return self._all(self._original(self.ga, self.a[items]) ^ self._original(self.gb, self.b[items]), total)
        if total == self.algebra.dimension:
            return np.full((len(items), 1), float(self.algebra.pseudoscalar_sign))
        return self._join_and_meet(items, r)[0]

    def part(self, items: NDArray[np.int64], r: int) -> Array:
        """A and B as subspaces: what they share."""
        if r == self.gb:
            return self.b[items]
        if r == self.ga:
            return self.a[items]
        if self.ga + self.gb - r == self.algebra.dimension:
            return self._all(self._original(self.ga, self.a[items]) & self._original(self.gb, self.b[items]), r)
        if r == 0:
            return np.ones((len(items), 1))
        return self._join_and_meet(items, r)[1]

    def _all(self, x: Multivector, grade: int) -> Array:
        return embed(x, self.algebra.layout_of(self.algebra.blades_of_grade(grade))).astype(float)

    def _join_and_meet(self, items: NDArray[np.int64], r: int) -> tuple[Array, Array]:
        """Join and meet of unit size: B = M ^ B', J = A ^ B', and J positive.

        The left singular vectors are those parts of B' that A does not hold, so A ^ B' is A ^ them.
        """
        n_rest = self.gb - r
        shift = self.shift[items]
        meet = outer_of(self.algebra, self.principal[items][..., n_rest:])
        rest = outer_of(self.algebra, self.principal[items][..., :n_rest])
        b = scale_lengths(self.algebra, self.gb, self.b[items], -shift)
        a = scale_lengths(self.algebra, self.ga, self.a[items], -shift)
        side = np.sign((self._all(meet ^ rest, self.gb) * b).sum(-1))
        join = self._original(self.ga, a) ^ outer_of(self.algebra, self.u[items][..., :n_rest])
        j = (
            _unit(scale_lengths(self.algebra, self.ga + n_rest, _clean(self._all(join, self.ga + n_rest)), shift))
            * side[:, None]
        )
        m = _unit(scale_lengths(self.algebra, r, _clean(self._all(meet, r)), shift))
        large = np.abs(j) >= np.abs(j).max(-1, keepdims=True) / 2
        flip = np.sign(np.take_along_axis(j, np.argmax(large, -1)[:, None], -1))
        return j * flip, m * flip


def _clean(rows: Array) -> Array:
    """Without what rounding leaves beside the largest coefficient: flat objects stay flat."""
    noise = NOISE * np.finfo(float).eps * np.abs(rows).max(-1, keepdims=True)
    return np.where(np.abs(rows) > noise, rows, 0.0)


def _unit(rows: Array) -> Array:
    size = np.abs(rows).max(-1, keepdims=True)
    scaled = rows / size
    return np.asarray(scaled / np.sqrt((scaled * scaled).sum(-1, keepdims=True)))


__all__ = ["factorise", "factorize", "is_blade", "join", "meet"]
