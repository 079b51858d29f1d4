"""The operators of multivectors, and the products by name: each finds a plan and calls it.

Kept apart from what a multivector holds. Operators give up with NotImplemented on what is neither a multivector
nor numbers, so that Python's own error names the types.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import linear
from .dispatch import PLANS, plan

if TYPE_CHECKING:
    from .multivector import Multivector
    from .typed import Type

Number = int | float | NDArray[Any]


class Operators:
    """Operators and products of `Multivector`."""

    __slots__ = ()
    _type: Type

    # -- products; the common ones look their plan up themselves, which saves a call ---------------------------

    def __mul__(self, other: Any) -> Multivector:
        try:
            known = PLANS["geometric", self._type, other._type]
        except (KeyError, AttributeError):
            return _product("geometric", self, other) if isinstance(other, Operators) else _scaled(self, other)
        return known(self, other)

    def __rshift__(self, other: Any) -> Multivector:
        try:
            known = PLANS["sandwich", self._type, other._type]
        except (KeyError, AttributeError):
            return _product("sandwich", self, other)
        return known(self, other)

    def __xor__(self, other: Any) -> Multivector:
        try:
            known = PLANS["outer", self._type, other._type]
        except (KeyError, AttributeError):
            return _product("outer", self, other)
        return known(self, other)

    def __or__(self, other: Any) -> Multivector:
        try:
            known = PLANS["inner", self._type, other._type]
        except (KeyError, AttributeError):
            return _product("inner", self, other)
        return known(self, other)

    def __and__(self, other: Any) -> Multivector:
        return _product("regressive", self, other)

    def __rmul__(self, other: Any) -> Multivector:
        return _scaled(self, other)

    def __rxor__(self, other: Any) -> Multivector:
        return _product("outer", other, self)

    def __ror__(self, other: Any) -> Multivector:
        return _product("inner", other, self)

    def __rand__(self, other: Any) -> Multivector:
        return _product("regressive", other, self)

    def outer(self, other: Multivector | Number) -> Multivector:
        """Outer product ``a ^ b``."""
        return _product("outer", self, other)

    def inner(self, other: Multivector | Number) -> Multivector:
        """Inner product ``a | b`` of the thesis: the part of grade |r - s|, zero with scalars."""
        return _product("inner", self, other)

    def sandwich(self, other: Multivector | Number) -> Multivector:
        """``R >> x``: R x ~R."""
        return _product("sandwich", self, other)

    def left_contraction(self, other: Multivector | Number) -> Multivector:
        """The part of grade s - r of the product."""
        return _product("left_contraction", self, other)

    def scalar_product(self, other: Multivector | Number) -> Multivector:
        """<a b>_0; unlike the inner product it is not zero with scalars."""
        return _product("scalar_product", self, other)

    def commutator(self, other: Multivector | Number) -> Multivector:
        """(a b - b a)/2."""
        return _product("commutator", self, other)

    def anticommutator(self, other: Multivector | Number) -> Multivector:
        """(a b + b a)/2."""
        return _product("anticommutator", self, other)

    def regressive(self, other: Multivector | Number) -> Multivector:
        """``a & b``: (a* ^ b*) I, or J^-1(J a ^ J b) where the metric is degenerate."""
        return _product("regressive", self, other)

    def meet(self, other: Multivector) -> Multivector:
        """Intersection: ``a & b``, or ``a ^ b`` in PGA and other degenerate metrics."""
        return _product("outer" if self._type.algebra.is_degenerate else "regressive", self, other)

    def join(self, other: Multivector) -> Multivector:
        """Span of disjoint objects: ``a ^ b``, or ``a & b`` in PGA and other degenerate metrics."""
        return _product("regressive" if self._type.algebra.is_degenerate else "outer", self, other)

    # -- linear structure ----------------------------------------------------------------------------------

    def __add__(self, other: Any) -> Multivector:
        return _sum(self, other, 1)

    def __sub__(self, other: Any) -> Multivector:
        return _sum(self, other, -1)

    __radd__ = __add__

    def __rsub__(self, other: Any) -> Multivector:
        return _sum(other, self, -1)

    def __truediv__(self, other: Any) -> Multivector:
        return self * other.inverse() if isinstance(other, Operators) else _scaled(self, other, divide=True)

    def __rtruediv__(self, other: Any) -> Multivector:
        return _scaled(self.inverse(), other)

    def inverse(self) -> Multivector:
        """See `Multivector.inverse`."""
        raise NotImplementedError

    def __neg__(self) -> Multivector:
        return linear.mapped(self, "negative")

    def __invert__(self) -> Multivector:
        return linear.mapped(self, "reverse")

    reverse = __invert__

    def involute(self) -> Multivector:
        """Grade involution: odd grades change sign."""
        return linear.mapped(self, "involute")

    def conjugate(self) -> Multivector:
        """Clifford conjugation: reversion and involution."""
        return linear.mapped(self, "conjugate")

    def dual(self) -> Multivector:
        """x I, or the map J where the metric is degenerate."""
        return linear.mapped(self, "dual")

    def undual(self) -> Multivector:
        """The y with ``y.dual()`` = x."""
        return linear.mapped(self, "undual")

    def grade(self, *grades: int) -> Multivector:
        """The part of these grades.

        Raises
        ------
        GradeError
            If one is no whole number from 0 to the dimension.
        """
        return linear.selected(self, grades)


def _product(operation: str, a: Any, b: Any) -> Multivector:
    """Any product; numbers are scalars of the other operand's algebra."""
    if not isinstance(b, Operators):
        b = _lifted(a, b)
    elif not isinstance(a, Operators):
        a = _lifted(b, a)
    if a is NotImplemented or b is NotImplemented:
        return NotImplemented  # type: ignore[no-any-return]
    result: Multivector = plan(operation, a, b)(a, b)
    return result


def _sum(a: Any, b: Any, sign: int) -> Multivector:
    if not isinstance(b, Operators):
        b = _lifted(a, b)
    elif not isinstance(a, Operators):
        a = _lifted(b, a)
    if a is NotImplemented or b is NotImplemented:
        return NotImplemented  # type: ignore[no-any-return]
    return linear.added(a, b, sign)


def _scaled(x: Any, factor: Any, divide: bool = False) -> Multivector:
    if not _may_be_numbers(factor):
        return NotImplemented  # type: ignore[no-any-return]
    return linear.scaled(x, factor, divide)


def _lifted(like: Any, value: Any) -> Any:
    """Numbers as scalars; single numbers take the multivector's precision."""
    if not _may_be_numbers(value):
        return NotImplemented
    return like.algebra.scalar(value, dtype=like.dtype if np.ndim(value) == 0 else None)


def _may_be_numbers(value: Any) -> bool:
    return value is not None and not isinstance(value, str | bytes | dict | set)
