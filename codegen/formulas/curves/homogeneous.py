"""Homogeneous polynomials in (a, b) over another ring: how a formula along a curve yields its own coefficients.

Run a formula with `parameters(...)` for a = 1 - t and b = t: its result is the list of coefficients of a^(n-k) b^k,
first k = 0, built by convolution, without subtraction of equal terms. For a + b = 1 these are scaled Bernstein
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
        raise TraceError(f"{name} of a polynomial in (a, b) is no polynomial.")

    def select(self, mask: Any, a: Polynomial, b: Polynomial) -> Any:
        raise TraceError("a selection between polynomials in (a, b) is no polynomial.")

    def is_zero(self, a: Polynomial) -> bool:
        return all(self.base.is_zero(c) for c in a)


def parameters(algebra: Algebra, base: Ring) -> tuple[Multivector, Multivector]:
    """The scalars a and b over the homogeneous ring of ``base``."""
    ring = HomogeneousRing(base)
    zero, one = base.constant(Fraction(0)), base.constant(Fraction(1))
    return Multivector(algebra, ring, {0: (one, zero)}), Multivector(algebra, ring, {0: (zero, one)})


def lift(x: Multivector, ring: Ring) -> Multivector:
    """A multivector that does not depend on (a, b), over the homogeneous ring."""
    return Multivector(x.algebra, ring, {blade: (c,) for blade, c in x.terms.items()})


def coefficients(x: Multivector, degree: int, base: Ring) -> list[Multivector]:
    """Coefficients of a^n .. b^n, as multivectors over the base ring."""
    for polynomial in x.terms.values():
        if len(polynomial) != degree + 1:
            raise TraceError(f"the polynomial has degree {len(polynomial) - 1}, not {degree}.")
    return [Multivector(x.algebra, base, {b: p[k] for b, p in x.terms.items()}) for k in range(degree + 1)]


def polynomial(coefficients: Sequence[Multivector], ring: Ring) -> Multivector:
    """The polynomial of given coefficients (of a^n .. b^n), over the homogeneous ring."""
    first, zero = coefficients[0], coefficients[0].ring.constant(Fraction(0))
    blades = dict.fromkeys(b for c in coefficients for b in c.terms)
    return Multivector(first.algebra, ring, {b: tuple(c.terms.get(b, zero) for c in coefficients) for b in blades})


def value(coefficients: Sequence[Multivector], a: Multivector, b: Multivector) -> Multivector:
    """sum c_k a^(n-k) b^k on numbers: all terms as they are, so that the error is relative to their absolute sum."""
    total, power = coefficients[0], b
    for place, c in enumerate(coefficients[1:], 1):
        total = a * total + power * c
        power = power * b if place < len(coefficients) - 1 else power
    return total


def rate(coefficients: Sequence[Multivector]) -> list[Multivector]:
    """Coefficients of the derivative by b along a + b = 1."""
    n = len(coefficients) - 1
    return [(k + 1) * coefficients[k + 1] - (n - k) * coefficients[k] for k in range(n)]


def monomials(degree: int, a: Multivector, b: Multivector) -> list[Multivector]:
    """a^n, a^(n-1) b, ..., b^n as numbers: what coefficients are weighted with."""
    first, last = [a.constant(1)], [b.constant(1)]
    for _ in range(degree):
        first.append(a if len(first) == 1 else first[-1] * a)
        last.append(b if len(last) == 1 else last[-1] * b)
    return [first[degree], *(first[degree - k] * last[k] for k in range(1, degree)), *last[degree:] * (degree > 0)]


def monomial_rates(degree: int, a: Multivector, b: Multivector) -> list[Multivector]:
    """Their derivatives by b along a + b = 1."""
    lower = monomials(degree - 1, a, b)
    rates = [k * lower[k - 1] - (degree - k) * lower[k] for k in range(1, degree)]
    return [-degree * lower[0], *rates, degree * lower[-1]]
