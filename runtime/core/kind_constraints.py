"""Conversion to kinds: tests of their constraints within rounding, and scales at which they hold.

A user's coefficients get a constrained kind only here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Algebra, Kind
from ..codegen.algebra.members import TOLERANCE_ULPS, residuals
from ..codegen.algebra.multivector import from_values
from ..codegen.errors import KindError
from ..codegen.rings.protocol import RationalRing
from ..codegen.trace import result_kinds
from ..dispatch.coefficients import embed
from ..dispatch.multivector_data import M, MultivectorData
from ..dispatch.plans import table_rows
from ..dispatch.product_tables import Table

#: Rows that are checked at a time, so that an interrupt is seen; of more, BLAS makes threads, which wait for others.
ROWS_AT_ONCE = 1 << 14
#: A multivector is not blown up to a kind of more than this many times its coefficients.
MOST_ZEROS = 2


def tolerance(dtype: np.dtype[Any]) -> float:
    """Relative tolerance of checks in one precision."""
    return TOLERANCE_ULPS * float(np.finfo(dtype).eps)


def satisfies_constraints(kind: Kind, data: NDArray[Any]) -> NDArray[np.bool_]:
    """For each row of coefficients, whether the kind's constraints hold; NaN does not."""
    form, least = quadratic_constraints(kind), tolerance(data.dtype)
    rows = data.reshape(-1, kind.size)
    good = np.empty(len(rows), bool)
    for begin in range(0, len(rows), ROWS_AT_ONCE):
        block = slice(begin, begin + ROWS_AT_ONCE)
        x = np.ascontiguousarray(rows[block], np.float64)
        with np.errstate(all="ignore"):
            value = form.at(x)
            size = form.size.at(np.abs(x)) if form.size else np.abs(value)
            # x ~x - 1, for one: noise in its other parts is noise of the 1
            size = size + np.where(form.whole >= 0, size[:, form.whole], 0.0)
            good[block] = ((np.abs(value) <= least * size) & np.isfinite(size)).all(-1)
    return good.reshape(data.shape[:-1])


#: An item that satisfies constraints to this part of the tolerance does so however sums are rounded.
CLEARLY = 0.25


@lru_cache(maxsize=256)
def clear_member(algebra: Algebra, kind: Kind) -> Callable[..., bool]:
    """A function of the coefficients of one item in double precision: whether it is clearly a member.

    For an item that is not, or hardly, `satisfies_constraints` decides.
    """
    form, limit = quadratic_constraints(kind), CLEARLY * tolerance(np.dtype(np.float64))
    names = [f"x{i}" for i in range(kind.size)]
    lines, t = [f"def check({', '.join(names)}):"], form.quadratic
    for c, constant in enumerate(form.constant.tolist()):
        weights = [(names[i], w) for i, w in enumerate(form.linear[:, c].tolist()) if w]
        rows = range(t.starts[c], t.starts[c + 1])
        weights += [(f"{names[t.left[r]]} * {names[t.right[r]]}", float(t.weights[r])) for r in rows]
        lines += [f"    t{j} = {w!r} * {term}" for j, (term, w) in enumerate(weights)]
        terms = [f"t{j}" for j in range(len(weights))]
        lines.append(f"    v{c} = abs({' + '.join([repr(constant), *terms])})")
        lines.append(f"    s{c} = {' + '.join([repr(abs(constant)), *(f'abs({t})' for t in terms)])}")
    tests = [f"v{c} <= {limit!r} * (s{c}{f' + s{w}' if w >= 0 else ''})" for c, w in enumerate(form.whole.tolist())]
    lines.append(f"    return {' and '.join(tests)}")
    space: dict[str, Any] = {}
    exec("\n".join(lines), space)  # numbers and names of this function's own
    return space["check"]  # type: ignore[no-any-return]


@dataclass(frozen=True, eq=False)
class QuadraticConstraints:
    """The constraints of a kind as quadratic forms in its coefficients, one column for each part of a residual.

    Attributes
    ----------
    constant, linear, quadratic
        Value: constant + x linear + quadratic(x, x).
    whole : array
        For parts other than the scalar one, the column of the scalar part of the same residual; else -1.
    size : Form
        The same with absolute weights: the sum of the terms' absolute values.
    """

    constant: NDArray[np.float64]
    linear: NDArray[np.float64]
    quadratic: Table
    whole: NDArray[np.int64]
    size: QuadraticConstraints | None

    def at(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values for rows of coefficients."""
        value = np.empty((len(x), len(self.constant)))
        if len(x):
            table_rows(self.quadratic, 0)(value, x, x, len(x))
        value += self.constant
        value += x @ self.linear
        return value


def quadratic_constraints(kind: Kind) -> QuadraticConstraints:
    """The constraints of a kind as polynomials of its coefficients."""
    return _form(kind.algebra, kind)


@lru_cache(maxsize=256)
def _form(
    algebra: Algebra, kind: Kind
) -> QuadraticConstraints:  # kinds of algebras of one name are equal: the algebra is a key
    """By exact evaluation at 0, the basis blades and their sums: what is quadratic is known from those.

    Raises
    ------
    KindError
        If a constraint is no quadratic polynomial.
    """
    k = kind.size

    def at(weights: Mapping[int, int]) -> list[dict[int, Fraction]]:
        values = [Fraction(weights.get(i, 0)) for i in range(k)]
        return [dict(r.terms) for r in residuals(kind, from_values(algebra, RationalRing(), kind.blades, values))]

    zero = at({})
    single, double = [at({i: 1}) for i in range(k)], [at({i: 2}) for i in range(k)]
    pairs = {(i, j): at({i: 1, j: 1}) for i in range(k) for j in range(i)}
    mixed = at({i: i + 1 for i in range(k)})
    columns: list[tuple[int, int]] = []
    constant, linear, terms = [], [], []
    for c in range(len(kind.constraints)):
        found = {b for r in (zero, *single, *double, *pairs.values(), mixed) for b in r[c]}
        for blade in algebra.order(found):
            at_zero = zero[c].get(blade, Fraction(0))
            one = [single[i][c].get(blade, Fraction(0)) - at_zero for i in range(k)]
            two = [double[i][c].get(blade, Fraction(0)) - at_zero for i in range(k)]
            square = [(b - 2 * a) / 2 for a, b in zip(one, two, strict=True)]
            slope = [a - q for a, q in zip(one, square, strict=True)]
            own = {(i, i): q for i, q in enumerate(square)}
            for (i, j), r in pairs.items():
                own[i, j] = r[c].get(blade, Fraction(0)) - at_zero - one[i] - one[j]
            total = at_zero + sum((i + 1) * a for i, a in enumerate(slope))
            total += sum((i + 1) * (j + 1) * q for (i, j), q in own.items())
            if total != mixed[c].get(blade, Fraction(0)):
                raise KindError(f"kind {kind.name}: {kind.constraints[c]} is not a quadratic constraint.")
            terms += [(len(columns), i, j, float(q)) for (i, j), q in own.items() if q]
            constant.append(float(at_zero))
            linear.append([float(a) for a in slope])
            columns.append((c, blade))
    whole = np.array([columns.index((c, 0)) if blade and (c, 0) in columns else -1 for c, blade in columns], np.int64)
    weights = np.array(constant), np.array(linear).reshape(-1, k).T
    size = QuadraticConstraints(
        np.abs(weights[0]), np.abs(weights[1]), _table(terms, k, len(columns), absolute=True), whole, None
    )
    return QuadraticConstraints(*weights, _table(terms, k, len(columns)), whole, size)


def _table(terms: list[tuple[int, int, int, float]], k: int, columns: int, absolute: bool = False) -> Table:
    """Quadratic terms (column, i, j, weight) as a product of x with itself."""
    rows = sorted(terms)
    starts = np.searchsorted([r[0] for r in rows], np.arange(columns + 1)).astype(np.int32)
    left, right = (np.array([r[n] for r in rows], np.int32) for n in (1, 2))
    weights = np.array([abs(r[3]) if absolute else r[3] for r in rows], np.float64)
    return Table(tuple(range(columns)), (k, k), starts, left, right, weights)


def convert_to_kind(x: M, kind: Kind, check: bool = True) -> M:
    """x as a multivector of ``kind``, its constraints checked item by item.

    Raises
    ------
    KindError
        If a coefficient that ``kind`` does not have is not zero, or a constraint does not hold: with the item.
    """
    if kind == x.kind:
        return x
    algebra = x.algebra
    data = embed(x, kind)
    if check:
        _check_lost(x, kind)
        if kind.constraints and not result_kinds.belongs(x.kind, kind):
            undecided = ~np.isnan(data).all(-1)  # items without an answer stay what they are
            bad = undecided & ~satisfies_constraints(kind, data)
            if bad.any():
                raise KindError(
                    f"{_item(bad)} is not a {kind.name} of {algebra.name}: {', '.join(kind.constraints)} must vanish.",
                    remedy="Use .normalized(), or a constructor that returns this kind",
                )
    return x._make(algebra.type_of(kind, x.dtype), data, x._lead, x._status)


def _check_lost(x: MultivectorData, kind: Kind) -> None:
    kept = set(kind.blades)
    lost = [i for i, blade in enumerate(x._type.blades) if blade not in kept]
    if not lost:
        return
    with np.errstate(all="ignore"):
        size = np.abs(x._data).max(-1, keepdims=True)
        large = np.abs(x._data[..., lost]) > tolerance(x.dtype) * size
    if large.any():
        column = lost[int(np.argwhere(large)[0][-1])]
        raise KindError(
            f"{_item(large.any(-1))} has a coefficient of {x.algebra.blade_name(x._type.blades[column])}, "
            f"which a {kind.name} of {x.algebra.name} does not have.",
            remedy="Select blades with .grade(...) first, if that is meant",
        )


def _item(bad: NDArray[np.bool_]) -> str:
    """Name of the first bad item."""
    if bad.ndim == 0:
        return "the multivector"
    place = tuple(int(i) for i in np.argwhere(bad)[0])
    return f"item {place[0] if len(place) == 1 else place}"


def linear_scale(kind: Kind) -> tuple[float, ...] | None:
    """Weights w with w . x = 1 for members: what a linear constraint of the kind says, or None.

    A point of CGA, for one, has -(x | ni) = 1.
    """
    return _linear_scale(kind.algebra, kind)


@lru_cache(maxsize=256)
def _linear_scale(algebra: Algebra, kind: Kind) -> tuple[float, ...] | None:
    ring = RationalRing()
    units = [[Fraction(int(i == j)) for j in range(kind.size)] for i in range(kind.size)]
    values = [[Fraction(0)] * kind.size, *units, [Fraction(i + 2) for i in range(kind.size)]]
    constraint_values = [residuals(kind, from_values(algebra, ring, kind.blades, v)) for v in values]
    for rows in zip(*constraint_values, strict=True):
        if any(set(row.terms) - {0} for row in rows):
            continue
        offset, *parts, mixed = (row.terms.get(0, Fraction(0)) for row in rows)
        weights = [part - offset for part in parts]
        is_linear = sum((w * v for w, v in zip(weights, values[-1], strict=True)), offset) == mixed
        if offset and any(weights) and is_linear:
            return tuple(float(-w / offset) for w in weights)
    return None


def candidate_kinds(x: MultivectorData) -> Sequence[Kind]:
    """Constrained kinds that x may be scaled to: those on its blades, then larger ones that hold them."""
    return x._type.memoize("kinds", lambda: _kinds_on(x))


def _kinds_on(x: MultivectorData) -> Sequence[Kind]:
    own = set(x._type.blades)
    if own == {0}:
        return ()
    fitting = [k for k in x.algebra.kinds.values() if k.constraints and own <= set(k.blades)]
    return sorted((k for k in fitting if k.size <= MOST_ZEROS * len(own)), key=lambda k: k.size)
