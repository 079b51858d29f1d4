"""Terms of products of blades: which grades each product keeps."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any

from .blades import BladeBasis, grade, outer_sign

#: The terms of a product of two blades: bit masks with weights.
TermTable = Callable[[int, int], Iterable[tuple[int, Fraction]]]
#: For grades (a, b) and the grade c of one term of the geometric product, or arrays of them: does the product keep it?
Filter = Callable[[Any, Any, Any], Any]


def keep_outer(a: int, b: int, c: int) -> bool:
    """Outer product: the grades add."""
    return c == a + b


def keep_inner(a: int, b: int, c: int) -> bool:
    """Inner product of the thesis (1.2.2): the grades' difference, zero with scalars."""
    return (c == abs(a - b)) & (a > 0) & (b > 0)


def keep_left(a: int, b: int, c: int) -> bool:
    """Left contraction."""
    return c == b - a


def keep_right(a: int, b: int, c: int) -> bool:
    """Right contraction."""
    return c == a - b


def keep_scalar(a: int, b: int, c: int) -> bool:
    """Scalar product <A B>_0."""
    return c == 0


def product_terms(basis: BladeBasis, keep: Filter | None) -> TermTable:
    """Terms of the geometric product, or those of them that ``keep`` selects by grades."""
    if keep is None:
        return basis.product
    if keep is keep_outer:
        return lambda a, b: () if a & b else ((a | b, Fraction(outer_sign(a, b))),)
    return lambda a, b: [(c, w) for c, w in basis.product(a, b) if keep(grade(a), grade(b), grade(c))]
