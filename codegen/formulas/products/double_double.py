"""Error-free transformations (Dekker, Knuth), and multivectors with double-double coefficients made from them.

Near a singular pose a discriminant is small, and its rounding errors are not: formulas run there with twice the digits.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from math import factorial
from typing import Any, TypeVar

from ...algebra.algebra import Algebra, scalar_argument
from ...algebra.multivector import Multivector, absolute, select
from ...ir.graph import Graph
from ...rings.double_double import Doubled, DoubledRing
from ...rings.protocol import Ring
from ...trace.calls import call_in_graph
from ...trace.kernel import Kernel, argument_names
from ...trace.trace import trace
from .outcome import as_computed, epsilon

Formula = TypeVar("Formula", bound=Callable[..., Any])
_ONE = Fraction(1)
#: Splits a double in halves of 26 and 27 of its 53 digits (Veltkamp).
SPLITTER_DOUBLE = Fraction(2**27 + 1)
#: Splits a single-precision number in halves of 12 of its 24 digits.
SPLITTER_SINGLE = Fraction(2**12 + 1)
#: Separates the values of epsilon of double precision (below) and of single precision.
_DOUBLE_BELOW = Fraction(1, 10**10)
#: Last term of the series of sin and cos, which are summed at an eighth of the angle.
TERMS = 9
#: Largest angle, in radians, that the series are for.
MAX_ANGLE = Fraction(13, 4)


def _rounded_sum(a: Multivector, b: Multivector) -> Multivector:
    return as_computed(a + b)


def two_sum(a: Multivector, b: Multivector) -> tuple[Multivector, Multivector]:
    """a + b, and its rounding error."""
    total = _rounded_sum(a, b)
    part = as_computed(total - a)
    return total, _rounded_sum(as_computed(a - as_computed(total - part)), as_computed(b - part))


def exact_product(*factors: int) -> Callable[[Formula], Formula]:
    """A mark of formulas: their results are the product of these arguments, and its rounding error.

    C prints the instruction that gives it, where a processor has one.
    """

    def mark(formula: Formula) -> Formula:
        formula.exact_factors = factors  # type: ignore[attr-defined]
        return formula

    return mark


@exact_product(0, 1)
def two_product(a: Multivector, b: Multivector) -> tuple[Multivector, Multivector]:
    """a b, and its rounding error."""
    total = as_computed(a * b)
    (a1, a2), (b1, b2) = _halves(a), _halves(b)
    rest = as_computed(as_computed(a1 * b1) - total)
    for x, y in ((a1, b2), (a2, b1), (a2, b2)):
        rest = _rounded_sum(rest, as_computed(x * y))
    return total, rest


@exact_product(0, 0)
def two_square(a: Multivector) -> tuple[Multivector, Multivector]:
    """a a, and its rounding error."""
    total = as_computed(a * a)
    a1, a2 = _halves(a)
    rest = as_computed(as_computed(a1 * a1) - total)
    rest = _rounded_sum(rest, as_computed(2 * a1 * a2))
    return total, _rounded_sum(rest, as_computed(a2 * a2))


def _halves(a: Multivector) -> tuple[Multivector, Multivector]:
    cut = select(epsilon(a) > _DOUBLE_BELOW, a.constant(SPLITTER_SINGLE), a.constant(SPLITTER_DOUBLE))
    far = as_computed(cut * a)
    high = as_computed(far - as_computed(far - a))
    return high, as_computed(a - high)


def turned(x: Multivector, sine_of_x: Multivector, cosine_of_x: Multivector) -> tuple[Multivector, ...]:
    """sin x and its rounding error, then cos x and its own, both given to half the digits.

    Series at x/8, then three times the double angle; beyond half a turn with half the digits.
    """
    z = to_double_double(x / 8)
    w = z * z
    sine = z + z * w * _series(w, 1, 1)
    cosine = 1 - w / 2 + w * w * _series(w, 0, 2)
    for _ in range(3):
        sine, cosine = 2 * (sine * cosine), 1 - 2 * (sine * sine)
    near = absolute(x) <= x.constant(MAX_ANGLE)
    zero = x.constant(0)
    parts = [(sine, 0, sine_of_x), (sine, 1, zero), (cosine, 0, cosine_of_x), (cosine, 1, zero)]
    return tuple(select(near, x.new({0: value.terms[0][i]}), plain) for value, i, plain in parts)


def _series(w: Multivector, first: int, begin: int) -> Multivector:
    """sum (-w)^(n - begin) (-1)^begin/(2n + first)! from n = begin: its first term with all digits."""
    like = Multivector(w.algebra, w.ring.base, {0: w.terms[0][0]})  # type: ignore[attr-defined]
    tail = like.constant(0)
    for n in range(TERMS, begin, -1):
        tail = (tail + Fraction((-1) ** n, factorial(2 * n + first))) * like
    return w.constant(Fraction((-1) ** begin, factorial(2 * begin + first))) + to_double_double(tail)


@cache
def _step_kernel(formula: Callable[..., Any], algebra: Algebra) -> Kernel:
    """A step as a kernel of its own, which generated text calls: its straight-line code is long."""
    return trace(formula, [scalar_argument(algebra)] * len(argument_names(formula)), algebra=algebra)


class Steps:
    """The formulas of this module as operations on coefficients: calls in a graph, direct evaluation elsewhere."""

    def __init__(self, base: Ring, algebra: Algebra) -> None:
        self.base = base
        self.algebra = algebra

    def two_sum(self, a: Any, b: Any) -> Doubled:
        total, rest = self._evaluate(two_sum, a, b)
        return total, rest

    def two_product(self, a: Any, b: Any) -> Doubled:
        total, rest = self._evaluate(two_product, a, b)
        return total, rest

    def two_square(self, a: Any) -> Doubled:
        total, rest = self._evaluate(two_square, a)
        return total, rest

    def sine_and_cosine(self, x: Any, sine: Any, cosine: Any) -> tuple[Any, Any, Any, Any]:
        parts = self._evaluate(turned, x, sine, cosine)
        return parts[0], parts[1], parts[2], parts[3]

    def _evaluate(self, formula: Callable[..., Any], *values: Any) -> list[Any]:
        numbers = [Multivector(self.algebra, self.base, {0: v}) for v in values]
        if isinstance(self.base, Graph):
            results = call_in_graph(_step_kernel(formula, self.algebra), self.base, numbers)
        else:
            results = formula(*numbers)
        return [x.scalar() for x in results]


def to_double_double(x: Multivector, rest: Multivector | None = None) -> Multivector:
    """x on the ring of double-double numbers; ``rest`` is its low part, where it is known."""
    ring = DoubledRing(x.ring, Steps(x.ring, x.algebra))
    rests = {} if rest is None else rest.terms
    return Multivector(x.algebra, ring, {b: (c, rests.get(b)) for b, c in x.terms.items()})


def to_single(x: Multivector, like: Multivector) -> Multivector:
    """x rounded to the digits of another multivector."""
    return like.new(
        {b: like.ring.combine([(part, _ONE) for part in c if part is not None]) for b, c in x.terms.items()}
    )
