"""Homogeneous polynomials in (a, b) over another ring, in the scaled Bernstein basis a^(n-k) b^k.

Products are convolutions of coefficients; no equal terms are subtracted. Sums must be of equal degree: a formula that
adds unequal ones is not homogeneous and is refused.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from ..errors import TraceError
from .protocol import Ring, Terms

#: Coefficients of a^n, a^(n-1) b, ..., b^n.
Polynomial = tuple[Any, ...]


class HomogeneousRing:
    """Polynomials as tuples of coefficients of the base ring; the empty tuple is zero, of every degree."""

    def __init__(self, base: Ring) -> None:
        self.base = base
        self.is_symbolic = getattr(base, "is_symbolic", False)

    def constant(self, value: Fraction) -> Polynomial:
        return (self.base.constant(value),) if value else ()

    def combine(self, terms: Terms) -> Polynomial:
        live = [(p, w) for p, w in terms if p]
        if not live:
            return ()
        length = len(live[0][0])
        if any(len(p) != length for p, _ in live):
            raise TraceError("the formula adds polynomials of different degrees in (a, b); write 1 as a + b there.")
        return tuple(self.base.combine([(p[k], w) for p, w in live]) for k in range(length))

    def multiply(self, a: Polynomial, b: Polynomial) -> Polynomial:
        if not a or not b:
            return ()
        parts: list[list[tuple[Any, Fraction]]] = [[] for _ in range(len(a) + len(b) - 1)]
        for i, x in enumerate(a):
            for j, y in enumerate(b):
                if not (self.base.is_zero(x) or self.base.is_zero(y)):
                    parts[i + j].append((self.base.multiply(x, y), Fraction(1)))
        return tuple(self.base.combine(p) for p in parts)

    def apply(self, name: str, *arguments: Polynomial) -> Any:
        raise TraceError(f"{name} of a polynomial in (a, b) is not a polynomial.")

    def select(self, mask: Any, a: Polynomial, b: Polynomial) -> Any:
        raise TraceError("a selection between polynomials in (a, b) is not a polynomial.")

    def is_zero(self, a: Polynomial) -> bool:
        return all(self.base.is_zero(c) for c in a)
