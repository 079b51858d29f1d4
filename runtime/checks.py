"""Numbers that claim to be of a kind: whether its constraints hold within rounding, and scaling so that they do.

This is the only way by which a user's coefficients get a constrained kind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import proofs
from .codegen.errors import KindError
from .codegen.kinds import Kind
from .codegen.multivector import from_values
from .codegen.rings import RationalRing, Terms
from .rows import embedded

if TYPE_CHECKING:
    from .multivector import Multivector

#: A constraint holds if its value is at most this many rounding units of the sum of its terms' absolute values:
#: room for what a long chain of operations leaves (1e-12 in double, 5e-4 in single precision).
TOLERANCE_ULPS = 4096

#: A multivector is not blown up to a kind of more than this many times its coefficients.
MOST_ZEROS = 2


@dataclass(frozen=True)
class Sized:
    """A value, and the sum of the absolute values of the terms that made it."""

    value: Any
    size: Any


class SizedRing:
    """Arrays with the size of their terms: enough for constraints, which are polynomials."""

    def constant(self, value: Fraction) -> Sized:
        return Sized(float(value), abs(float(value)))

    def combine(self, terms: Terms) -> Sized:
        value: Any = 0.0
        size: Any = 0.0
        with np.errstate(all="ignore"):
            for part, weight in terms:
                value = value + part.value * float(weight)
                size = size + part.size * abs(float(weight))
        return Sized(value, size)

    def multiply(self, a: Sized, b: Sized) -> Sized:
        with np.errstate(all="ignore"):
            return Sized(a.value * b.value, a.size * b.size)

    def apply(self, name: str, *arguments: Any) -> Any:
        raise KindError(f"a kind's constraints are polynomials; {name} is none.")

    def select(self, mask: Any, a: Any, b: Any) -> Any:
        raise KindError("a kind's constraints are polynomials; a selection is none.")

    def is_zero(self, a: Sized) -> bool:
        return False


def tolerance(dtype: np.dtype[Any]) -> float:
    """Relative tolerance of checks in one precision."""
    return TOLERANCE_ULPS * float(np.finfo(dtype).eps)


def holds(kind: Kind, data: NDArray[Any]) -> NDArray[np.bool_]:
    """For each row of coefficients, whether the kind's constraints hold; NaN does not."""
    limit = tolerance(data.dtype)
    columns = [Sized(c, np.abs(c)) for c in (data[..., j].astype(np.float64) for j in range(kind.size))]
    x = from_values(kind.algebra, SizedRing(), kind.blades, columns)
    good = np.ones(data.shape[:-1], bool)
    for residual in kind.residuals(x):
        whole = residual.terms.get(0)  # x ~x - 1, for one: noise in its other parts is noise of the 1
        for part in residual.terms.values():
            size = part.size if whole is None or part is whole else part.size + whole.size
            good = good & (np.abs(part.value) <= limit * size)
    return good


def converted(x: Multivector, kind: Kind, check: bool = True) -> Multivector:
    """x as a multivector of ``kind``, its constraints checked item by item.

    Raises
    ------
    KindError
        If a coefficient that ``kind`` does not have is not zero, or a constraint does not hold: with the item.
    """
    if kind == x.kind:
        return x
    algebra = x.algebra
    data = embedded(x, kind)
    if check:
        _check_lost(x, kind)
        if kind.constraints and not proofs.belongs(x.kind, kind):
            undecided = ~np.isnan(data).all(-1)  # items without an answer stay what they are
            bad = undecided & ~holds(kind, data)
            if bad.any():
                raise KindError(
                    f"{_item(bad)} is not a {kind.name} of {algebra.name}: {', '.join(kind.constraints)} must vanish.",
                    remedy="Use .normalized(), or a constructor that returns this kind",
                )
    return x._make(algebra.type_of(kind, x.dtype), data, x._lead, x._status)


def _check_lost(x: Multivector, kind: Kind) -> None:
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


@lru_cache(maxsize=256)
def linear_scale(kind: Kind) -> tuple[float, ...] | None:
    """Weights w with w . x = 1 for members: what a linear constraint of the kind says, or None.

    A point of CGA, for one, has -(x | ni) = 1.
    """
    ring = RationalRing()
    units = [[Fraction(int(i == j)) for j in range(kind.size)] for i in range(kind.size)]
    values = [[Fraction(0)] * kind.size, *units, [Fraction(i + 2) for i in range(kind.size)]]
    residuals = [kind.residuals(from_values(kind.algebra, ring, kind.blades, v)) for v in values]
    for rows in zip(*residuals, strict=True):
        if any(set(row.terms) - {0} for row in rows):
            continue
        offset, *parts, mixed = (row.terms.get(0, Fraction(0)) for row in rows)
        weights = [part - offset for part in parts]
        is_linear = sum((w * v for w, v in zip(weights, values[-1], strict=True)), offset) == mixed
        if offset and any(weights) and is_linear:
            return tuple(float(-w / offset) for w in weights)
    return None


def kinds_on(x: Multivector) -> Sequence[Kind]:
    """Constrained kinds that x may be scaled to: those on its blades, then larger ones that hold them."""
    found: Sequence[Kind] = x._type.remembered("kinds", lambda: _kinds_on(x))
    return found


def _kinds_on(x: Multivector) -> Sequence[Kind]:
    own = set(x._type.blades)
    if own == {0}:
        return ()
    fitting = [k for k in x.algebra.kinds.values() if k.constraints and own <= set(k.blades)]
    return sorted((k for k in fitting if k.size <= MOST_ZEROS * len(own)), key=lambda k: k.size)
