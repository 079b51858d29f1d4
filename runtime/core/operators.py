"""The operators of multivectors, and the products by name: each finds a plan and calls it.

Kept apart from what a multivector holds. Operators give up with NotImplemented on what is neither a multivector
nor numbers, so that Python's own error names the types.
"""

from __future__ import annotations

from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.multivector import Multivector as FormulaMultivector
from ..common.validation import invalid
from ..dispatch.multivector_data import MultivectorData
from ..dispatch.plans import PLANS, plan
from . import linear_maps

#: Operand that is no multivector: it stands for scalars.
Number = int | float | NDArray[Any]
#: Some class of multivectors with products.
P = TypeVar("P", bound="Operators")


class Operators(MultivectorData):
    """Multivectors with operators and products; division by multivectors is defined with the inverse."""

    __slots__ = ()

    # -- products; the common ones look their plan up themselves, which saves a call ---------------------------

    def __mul__(self, other: Any) -> Self:
        try:
            known = PLANS["geometric", self._type, other._type]
        except (KeyError, AttributeError):
            return _product("geometric", self, other) if isinstance(other, Operators) else _multiply(self, other)
        return known(self, other)  # type: ignore[no-any-return]

    def __rshift__(self, other: Any) -> Self:
        try:
            known = PLANS["sandwich", self._type, other._type]
        except (KeyError, AttributeError):
            return _product("sandwich", self, other)
        return known(self, other)  # type: ignore[no-any-return]

    def __xor__(self, other: Any) -> Self:
        try:
            known = PLANS["outer", self._type, other._type]
        except (KeyError, AttributeError):
            return _product("outer", self, other)
        return known(self, other)  # type: ignore[no-any-return]

    def __or__(self, other: Any) -> Self:
        try:
            known = PLANS["inner", self._type, other._type]
        except (KeyError, AttributeError):
            return _product("inner", self, other)
        return known(self, other)  # type: ignore[no-any-return]

    def __and__(self, other: Any) -> Self:
        return _product("regressive", self, other)

    def __rmul__(self, other: Any) -> Self:
        return _multiply(self, other)

    def __rxor__(self, other: Any) -> Self:
        return _reflected_product("outer", other, self)

    def __ror__(self, other: Any) -> Self:
        return _reflected_product("inner", other, self)

    def __rand__(self, other: Any) -> Self:
        return _reflected_product("regressive", other, self)

    def outer(self, other: Self | Number) -> Self:
        """Outer product ``a ^ b``."""
        return _named_product("outer", self, other)

    def inner(self, other: Self | Number) -> Self:
        """Inner product ``a | b`` of the thesis: the part of grade ``|r - s|``, zero with scalars."""
        return _named_product("inner", self, other)

    def sandwich(self, other: Self | Number) -> Self:
        """``R >> x``: R x ~R."""
        return _named_product("sandwich", self, other)

    def left_contraction(self, other: Self | Number) -> Self:
        """The part of grade s - r of the product."""
        return _named_product("left_contraction", self, other)

    def right_contraction(self, other: Self | Number) -> Self:
        """The part of grade r - s of the product."""
        return _named_product("right_contraction", self, other)

    def scalar_product(self, other: Self | Number) -> Self:
        """<a b>_0; unlike the inner product it is not zero with scalars."""
        return _named_product("scalar_product", self, other)

    def commutator(self, other: Self | Number) -> Self:
        """(a b - b a)/2."""
        return _named_product("commutator", self, other)

    def anticommutator(self, other: Self | Number) -> Self:
        """(a b + b a)/2."""
        return _named_product("anticommutator", self, other)

    def regressive(self, other: Self | Number) -> Self:
        """``a & b``: (a* ^ b*) I, or J^-1(J a ^ J b) where the metric is degenerate."""
        return _named_product("regressive", self, other)

    def meet(self, other: Self) -> Self:
        """Intersection: ``a & b``, or ``a ^ b`` in PGA and other degenerate metrics."""
        return _named_product("outer" if self._type.algebra.is_degenerate else "regressive", self, other)

    def join(self, other: Self) -> Self:
        """Span of disjoint objects: ``a ^ b``, or ``a & b`` in PGA and other degenerate metrics."""
        return _named_product("regressive" if self._type.algebra.is_degenerate else "outer", self, other)

    # -- linear structure ----------------------------------------------------------------------------------

    def __add__(self, other: Any) -> Self:
        return _sum(self, other, 1)

    def __sub__(self, other: Any) -> Self:
        return _sum(self, other, -1)

    __radd__ = __add__

    def __rsub__(self, other: Any) -> Self:
        return _difference_from(other, self)

    def __truediv__(self, other: Any) -> Self:
        return _multiply(self, other, divide=True)

    def __neg__(self) -> Self:
        return linear_maps.apply_linear_map(self, "negative")

    def __invert__(self) -> Self:
        return linear_maps.apply_linear_map(self, "reverse")

    reverse = __invert__

    def involute(self) -> Self:
        """Grade involution: odd grades change sign."""
        return linear_maps.apply_linear_map(self, "involute")

    def conjugate(self) -> Self:
        """Clifford conjugation: reversion and involution."""
        return linear_maps.apply_linear_map(self, "conjugate")

    def dual(self) -> Self:
        """x I, or the map J where the metric is degenerate."""
        return linear_maps.apply_linear_map(self, "dual")

    def undual(self) -> Self:
        """The y with ``y.dual()`` = x."""
        return linear_maps.apply_linear_map(self, "undual")

    def grade(self, *grades: int) -> Self:
        """The part of these grades.

        Raises
        ------
        GradeError
            If one is no whole number from 0 to the dimension.
        """
        return linear_maps.select_grades(self, grades)


def _product(operation: str, a: P, b: Any) -> P:
    """Any product; numbers are scalars of the multivector's algebra."""
    if is_expression(b):
        return getattr(_as_symbolic(a), SYMBOLIC.get(operation, operation))(b)  # type: ignore[no-any-return]
    right: Any = b if isinstance(b, Operators) else _as_scalar(a, b)
    if right is NotImplemented:
        return NotImplemented  # type: ignore[no-any-return]
    return plan(operation, a, right)(a, right)  # type: ignore[no-any-return]


def _named_product(operation: str, a: P, b: Any) -> P:
    """The same of a method, which has no other operand to turn to."""
    product = _product(operation, a, b)
    if product is NotImplemented:
        remedy = "In a formula take the operators, a * b, a ^ b" if isinstance(b, FormulaMultivector) else None
        raise invalid(b, "the other operand", "a multivector or a number", remedy=remedy)
    return product


def _reflected_product(operation: str, a: Any, b: P) -> P:
    """A product of numbers with a multivector."""
    left = _as_scalar(b, a)
    if left is NotImplemented:
        return NotImplemented  # type: ignore[no-any-return]
    return plan(operation, left, b)(left, b)  # type: ignore[no-any-return]


def _sum(a: P, b: Any, sign: int) -> P:
    """a + sign b."""
    if is_expression(b):
        return _as_symbolic(a) + sign * b  # type: ignore[no-any-return]
    right: Any = b if isinstance(b, Operators) else _as_scalar(a, b)
    if right is NotImplemented:
        return NotImplemented  # type: ignore[no-any-return]
    return linear_maps.add(a, right, sign)  # type: ignore[no-any-return]


def _difference_from(a: Any, b: P) -> P:
    """Numbers minus a multivector."""
    if is_expression(a):
        return a - _as_symbolic(b)  # type: ignore[no-any-return]
    left = _as_scalar(b, a)
    if left is NotImplemented:
        return NotImplemented  # type: ignore[no-any-return]
    return linear_maps.add(left, b, -1)  # type: ignore[no-any-return]


def _multiply(x: P, factor: Any, divide: bool = False) -> P:
    if is_expression(factor):
        return _as_symbolic(x) / factor if divide else _as_symbolic(x) * factor  # type: ignore[no-any-return]
    if not _may_be_numbers(factor):
        return NotImplemented  # type: ignore[no-any-return]
    return linear_maps.scale(x, factor, divide)


#: Methods of symbolic multivectors whose names are not those of the products.
SYMBOLIC = {"geometric": "__mul__", "regressive": "__and__"}


def is_expression(value: Any) -> bool:
    """Test whether a value is made of SymPy's symbols; SymPy is not imported for it."""
    return not isinstance(value, int | float | np.ndarray) and hasattr(value, "free_symbols")


def _as_symbolic(x: Any) -> Any:
    """A numeric multivector as a symbolic one."""
    from .symbolic.multivector import from_expressions

    return from_expressions(x.algebra, {0: 0})._lift(x)


def _as_scalar(like: Any, value: Any) -> Any:
    """Numbers as scalars; single numbers take the multivector's precision."""
    if type(value) is float:
        return like.algebra.scalar(value, dtype=like.dtype)
    if not _may_be_numbers(value):
        return NotImplemented
    if is_expression(value):
        return _as_symbolic(like).constant(value)
    several = isinstance(value, list | tuple) or np.ndim(value) > 0  # of ragged lists NumPy cannot say it
    return like.algebra.scalar(value, dtype=None if several else like.dtype)


def _may_be_numbers(value: Any) -> bool:
    """Not multivectors of formulas, which take numeric ones on their left."""
    return value is not None and not isinstance(value, str | bytes | dict | set | FormulaMultivector)
