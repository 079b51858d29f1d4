"""Curves as homogeneous polynomials in (a, b): their coefficients, their values, and their rates.

A formula that runs on `parameters(...)` for a = 1 - t and b = t returns the polynomial of its result. For a + b = 1 the
coefficients are scaled Bernstein coefficients (the k-th Bernstein coefficient times n choose k).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Annotated

from ...algebra.algebra import Algebra
from ...algebra.multivector import Multivector, from_values
from ...errors import TraceError
from ...rings.bernstein import HomogeneousRing
from ...rings.protocol import Ring
from ...trace.outputs import Result, row
from ...trace.rows import BladesOf

Scalars = Sequence[Multivector]
#: Coefficients of trivectors, of bivectors; of quadrivectors, each under the vector that its blade lacks.
Trivectors = Annotated[Sequence[Multivector], BladesOf("circle")]
Bivectors = Annotated[Sequence[Multivector], BladesOf("point_pair")]
Quadrivectors = Annotated[Sequence[Multivector], BladesOf("vector")]


def from_row(numbers: Scalars, kind: str) -> list[Multivector]:
    """Multivectors on a kind's blades from a row of their coefficients."""
    algebra, ring = numbers[0].algebra, numbers[0].ring
    blades = algebra.kind(kind).blades
    rows = (numbers[i : i + len(blades)] for i in range(0, len(numbers), len(blades)))
    return [from_values(algebra, ring, blades, [c.scalar() for c in values]) for values in rows]


def to_row(values: Sequence[Multivector], kind: str, name: str) -> Result:
    """Coefficients of multivectors on a kind's blades as one row of numbers."""
    blades = values[0].algebra.kind(kind).blades
    return row([c.new({0: c.terms[b]} if b in c.terms else {}) for c in values for b in blades], name)


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
