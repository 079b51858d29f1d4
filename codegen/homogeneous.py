"""Homogeneous polynomials in (a, b) over another ring: how a formula along a curve yields its own coefficients.

Run a formula with alpha = `parameter(...)` and 1 - alpha = the other: its result is the list of coefficients of
a^k b^(n-k), built by convolution, without subtraction of equal terms. For a + b = 1 these are scaled Bernstein
coefficients (the k-th Bernstein coefficient times n choose k). Sums must be of equal degree: a formula that adds
unequal ones is not homogeneous and is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from .algebra import Algebra
from .errors import TraceError
from .multivector import Multivector
from .rings import Ring, Terms

#: Coefficients of b^n, a b^(n-1), ..., a^n.
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
        raise TraceError(f"{name} of a polynomial in (a, b) is no polynomial.")

    def select(self, mask: Any, a: Polynomial, b: Polynomial) -> Any:
        raise TraceError("a selection between polynomials in (a, b) is no polynomial.")

    def is_zero(self, a: Polynomial) -> bool:
        return all(self.base.is_zero(c) for c in a)


def parameters(algebra: Algebra, base: Ring) -> tuple[Multivector, Multivector]:
    """The scalars a and b over the homogeneous ring of ``base``."""
    ring = HomogeneousRing(base)
    zero, one = base.constant(Fraction(0)), base.constant(Fraction(1))
    return Multivector(algebra, ring, {0: (zero, one)}), Multivector(algebra, ring, {0: (one, zero)})


def lift(x: Multivector, ring: Ring) -> Multivector:
    """A multivector that does not depend on (a, b), over the homogeneous ring."""
    return Multivector(x.algebra, ring, {blade: (c,) for blade, c in x.terms.items()})


def coefficients(x: Multivector, degree: int, base: Ring) -> Sequence[Multivector]:
    """Coefficients of b^n .. a^n of a scalar, as scalars over the base ring."""
    polynomial = x.terms.get(0, ()) or tuple(base.constant(Fraction(0)) for _ in range(degree + 1))
    if len(polynomial) != degree + 1:
        raise TraceError(f"the polynomial has degree {len(polynomial) - 1}, not {degree}.")
    return [Multivector(x.algebra, base, {0: c}) for c in polynomial]


def polynomial(coefficients: Sequence[Multivector], ring: Ring) -> Multivector:
    """The scalar polynomial of given coefficients (of b^n .. a^n), over the homogeneous ring."""
    first = coefficients[0]
    return Multivector(first.algebra, ring, {0: tuple(c.scalar() for c in coefficients)})
