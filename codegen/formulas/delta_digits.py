"""Twice the digits where a formula needs them: sums of two floating-point numbers as coefficients.

Near a singular pose a discriminant is small, and its rounding errors are not. A formula that runs on this ring gets it
with all its digits from the same text; what is rounded off is kept in a second number (Dekker, Knuth).
The two are not made one again after each step: errors are those of the second, relative to the terms.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from math import factorial
from typing import Any

from ..algebra import Algebra
from ..declare import KernelFunction
from ..kinds import scalar_argument
from ..multivector import Multivector, absolute, select
from ..rings import Ring, Terms
from ..trace import argument_names
from .outcome import as_computed, epsilon

#: A number, and what rounding took from it (None: nothing).
Doubled = tuple[Any, Any]
_ONE = Fraction(1)
#: A product's factors are cut in halves by these: 27 of 53 digits, 12 of 24.
CUT_DOUBLE, CUT_SINGLE = Fraction(2**27 + 1), Fraction(2**12 + 1)
#: Epsilons below this are those of double precision.
_BETWEEN = Fraction(1, 10**10)
#: sin and cos are summed up at an eighth of the angle: the last term of the series; angles up to which, in radians.
TERMS, FURTHEST = 9, Fraction(13, 4)


def _rounded_sum(a: Multivector, b: Multivector) -> Multivector:
    return as_computed(a + b)


def two_sum(a: Multivector, b: Multivector) -> tuple[Multivector, Multivector]:
    """a + b, and what rounding took from it."""
    total = _rounded_sum(a, b)
    part = as_computed(total - a)
    return total, _rounded_sum(as_computed(a - as_computed(total - part)), as_computed(b - part))


def two_product(a: Multivector, b: Multivector) -> tuple[Multivector, Multivector]:
    """a b, and what rounding took from it."""
    total = as_computed(a * b)
    (a1, a2), (b1, b2) = _halves(a), _halves(b)
    rest = as_computed(as_computed(a1 * b1) - total)
    for x, y in ((a1, b2), (a2, b1), (a2, b2)):
        rest = _rounded_sum(rest, as_computed(x * y))
    return total, rest


def two_square(a: Multivector) -> tuple[Multivector, Multivector]:
    """a a, and what rounding took from it."""
    total = as_computed(a * a)
    a1, a2 = _halves(a)
    rest = as_computed(as_computed(a1 * a1) - total)
    rest = _rounded_sum(rest, as_computed(2 * a1 * a2))
    return total, _rounded_sum(rest, as_computed(a2 * a2))


def _halves(a: Multivector) -> tuple[Multivector, Multivector]:
    cut = select(epsilon(a) > _BETWEEN, a.constant(CUT_SINGLE), a.constant(CUT_DOUBLE))
    far = as_computed(cut * a)
    high = as_computed(far - as_computed(far - a))
    return high, as_computed(a - high)


@cache
def _kernel(formula: Callable[..., Any], algebra: Algebra) -> KernelFunction:
    """Steps that text is made of once, and called: straight lines of them are long."""
    count = len(argument_names(formula))
    return KernelFunction(formula, [scalar_argument(algebra)] * count, None, formula.__name__, algebra)


class DoubledRing:
    """Numbers with twice the digits, over a base ring."""

    def __init__(self, base: Ring, algebra: Algebra) -> None:
        self.base, self.algebra = base, algebra
        self.is_symbolic = getattr(base, "is_symbolic", False)

    # -- single numbers, each rounded on its own ---------------------------------------------------------------

    def _sum(self, *terms: tuple[Any, int]) -> Any:
        return self.base.apply("rounded", self.base.combine([(c, Fraction(w)) for c, w in terms]))

    def _product(self, a: Any, b: Any) -> Any:
        return self.base.apply("rounded", self.base.multiply(a, b))

    def _step(self, formula: Callable[..., Any], *values: Any) -> Any:
        """A formula of single numbers: a call in generated code."""
        numbers = [Multivector(self.algebra, self.base, {0: v}) for v in values]
        found = (_kernel(formula, self.algebra) if self.is_symbolic else formula)(*numbers)
        return tuple(x.scalar() for x in found)

    def _twice(self, a: Any) -> Any:
        return self.base.combine([(a, Fraction(2))])

    # -- the ring ----------------------------------------------------------------------------------------------

    def constant(self, value: Fraction) -> Doubled:
        high = Fraction(float(value))
        rest = value - high
        return self.base.constant(high), self.base.constant(Fraction(float(rest))) if rest else None

    def combine(self, terms: Terms) -> Doubled:
        total: Doubled | None = None
        for c, w in terms:
            part = self._scaled(c, w)
            total = part if total is None else self._add(total, part)
        return self.constant(Fraction(0)) if total is None else total

    def _scaled(self, c: Doubled, w: Fraction) -> Doubled:
        if w == 1:
            return c
        if _is_scale(w):
            return tuple(None if x is None else self.base.combine([(x, w)]) for x in c)  # type: ignore[return-value]
        return self.multiply(c, self.constant(w))

    def _add(self, a: Doubled, b: Doubled) -> Doubled:
        total, rest = self._step(two_sum, a[0], b[0])
        for x in (a[1], b[1]):
            rest = rest if x is None else self._sum((rest, 1), (x, 1))
        return total, rest

    def multiply(self, a: Doubled, b: Doubled) -> Doubled:
        for x, y in ((a, b), (b, a)):
            if x[1] is None and _is_power_of_two(x[0]):
                return self._scaled(y, x[0].data)
        is_square = a[0] is b[0] and a[1] is b[1]
        total, rest = self._step(two_square, a[0]) if is_square else self._step(two_product, a[0], b[0])
        pairs = ((self._twice(a[0]), a[1]),) if is_square else ((a[0], b[1]), (a[1], b[0]))
        for x, y in pairs:
            rest = rest if x is None or y is None else self._sum((rest, 1), (self._product(x, y), 1))
        return total, rest

    def apply(self, name: str, *arguments: Any) -> Any:
        if name == "rounded":
            return arguments[0]
        if name in ("sin", "cos"):
            ((x, rest),) = arguments
            if rest is not None and not self.base.is_zero(rest):
                raise NotImplementedError(f"{name} of an angle with twice the digits")
            found = self._step(turned, x, self.base.apply("sin", x), self.base.apply("cos", x))
            return found[2 * (name == "cos") :][:2]
        raise NotImplementedError(f"{name} with twice the digits")

    def select(self, mask: Any, a: Doubled, b: Doubled) -> Doubled:
        zero = self.base.constant(Fraction(0))
        rests = [zero if x[1] is None else x[1] for x in (a, b)]
        return self.base.select(mask, a[0], b[0]), self.base.select(mask, *rests)

    def is_zero(self, a: Doubled) -> bool:
        return self.base.is_zero(a[0]) and (a[1] is None or self.base.is_zero(a[1]))


def _is_scale(w: Fraction) -> bool:
    """Whether it is a power of two, with a sign: products with it are not rounded."""
    return (
        w.numerator in (1, -1)
        and not w.denominator & (w.denominator - 1)
        or (w.denominator == 1 and w.numerator != 0 and not abs(w.numerator) & (abs(w.numerator) - 1))
    )


def _is_power_of_two(x: Any) -> bool:
    """Whether a node of a graph is such a constant."""
    return getattr(x, "op", None) == "const" and _is_scale(x.data)


def doubled(x: Multivector, rest: Multivector | None = None) -> Multivector:
    """x, and what is known of it beyond its digits, on the ring with twice as many."""
    ring = DoubledRing(x.ring, x.algebra)
    rests = {} if rest is None else rest.terms
    return Multivector(x.algebra, ring, {b: (c, rests.get(b)) for b, c in x.terms.items()})


def shortened(x: Multivector, like: Multivector) -> Multivector:
    """x rounded to the digits of another."""
    return like.new(
        {b: like.ring.combine([(part, _ONE) for part in c if part is not None]) for b, c in x.terms.items()}
    )


def turned(x: Multivector, sine_of_x: Multivector, cosine_of_x: Multivector) -> tuple[Multivector, ...]:
    """sin x, what rounding took from it, and the same of cos x, both of which are known to half the digits.

    Series at x/8, then three times the double angle; beyond half a turn with half the digits.
    """
    z = doubled(x / 8)
    w = z * z
    sine = z + z * w * _series(w, 1, 1)
    cosine = 1 - w / 2 + w * w * _series(w, 0, 2)
    for _ in range(3):
        sine, cosine = 2 * (sine * cosine), 1 - 2 * (sine * sine)
    near = absolute(x) <= x.constant(FURTHEST)
    zero = x.constant(0)
    parts = [(sine, 0, sine_of_x), (sine, 1, zero), (cosine, 0, cosine_of_x), (cosine, 1, zero)]
    return tuple(select(near, x.new({0: value.terms[0][i]}), plain) for value, i, plain in parts)


def _series(w: Multivector, first: int, begin: int) -> Multivector:
    """sum (-w)^(n - begin) (-1)^begin/(2n + first)! from n = begin: its first term with all digits."""
    like = Multivector(w.algebra, w.ring.base, {0: w.terms[0][0]})  # type: ignore[attr-defined]
    tail = like.constant(0)
    for n in range(TERMS, begin, -1):
        tail = (tail + Fraction((-1) ** n, factorial(2 * n + first))) * like
    return w.constant(Fraction((-1) ** begin, factorial(2 * begin + first))) + doubled(tail)
