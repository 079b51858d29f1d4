"""Double-double numbers: unevaluated sums of two floating-point numbers, as coefficients.

A formula that runs on this ring has twice the digits from the same text; the rounding error of each step is in the
second number (Dekker, Knuth). The two are not added after each step: errors are those of the second number, relative
to the terms.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any, Protocol

from .protocol import Ring, Terms

#: A number, and its rounding error (None: zero).
Doubled = tuple[Any, Any]


class ErrorFreeSteps(Protocol):
    """Operations on coefficients of a base ring that return their rounding errors, too."""

    def two_sum(self, a: Any, b: Any) -> Doubled:
        """a + b."""

    def two_product(self, a: Any, b: Any) -> Doubled:
        """a b."""

    def two_square(self, a: Any) -> Doubled:
        """a a."""

    def sine_and_cosine(self, x: Any, sine: Any, cosine: Any) -> tuple[Any, Any, Any, Any]:
        """sin x and its rounding error, cos x and its own, given both in single precision of the base ring."""


class DoubledRing:
    """Numbers with twice the digits, over a base ring."""

    def __init__(self, base: Ring, steps: ErrorFreeSteps) -> None:
        self.base = base
        self.steps = steps
        self.is_symbolic = getattr(base, "is_symbolic", False)

    # -- single numbers, each rounded on its own ---------------------------------------------------------------

    def _sum(self, *terms: tuple[Any, int]) -> Any:
        return self.base.apply("rounded", self.base.combine([(c, Fraction(w)) for c, w in terms]))

    def _product(self, a: Any, b: Any) -> Any:
        return self.base.apply("rounded", self.base.multiply(a, b))

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
            part = self._scale(c, w)
            total = part if total is None else self._add(total, part)
        return self.constant(Fraction(0)) if total is None else total

    def _scale(self, c: Doubled, w: Fraction) -> Doubled:
        if w == 1:
            return c
        if _is_scale(w):
            return tuple(None if x is None else self.base.combine([(x, w)]) for x in c)  # type: ignore[return-value]
        return self.multiply(c, self.constant(w))

    def _add(self, a: Doubled, b: Doubled) -> Doubled:
        total, rest = self.steps.two_sum(a[0], b[0])
        for x in (a[1], b[1]):
            rest = rest if x is None else self._sum((rest, 1), (x, 1))
        return total, rest

    def multiply(self, a: Doubled, b: Doubled) -> Doubled:
        for x, y in ((a, b), (b, a)):
            if x[1] is None and _is_power_of_two(x[0]):
                return self._scale(y, x[0].data)
        is_square = a[0] is b[0] and a[1] is b[1]
        total, rest = self.steps.two_square(a[0]) if is_square else self.steps.two_product(a[0], b[0])
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
            parts = self.steps.sine_and_cosine(x, self.base.apply("sin", x), self.base.apply("cos", x))
            return parts[2 * (name == "cos") :][:2]
        raise NotImplementedError(f"{name} with twice the digits")

    def select(self, mask: Any, a: Doubled, b: Doubled) -> Doubled:
        zero = self.base.constant(Fraction(0))
        rests = [zero if x[1] is None else x[1] for x in (a, b)]
        return self.base.select(mask, a[0], b[0]), self.base.select(mask, *rests)

    def is_zero(self, a: Doubled) -> bool:
        return self.base.is_zero(a[0]) and (a[1] is None or self.base.is_zero(a[1]))


def _is_scale(w: Fraction) -> bool:
    """Return whether it is a power of two, with a sign: products with it are not rounded."""
    return (
        w.numerator in (1, -1)
        and not w.denominator & (w.denominator - 1)
        or (w.denominator == 1 and w.numerator != 0 and not abs(w.numerator) & (abs(w.numerator) - 1))
    )


def _is_power_of_two(x: Any) -> bool:
    """Return whether a node of a graph is such a constant."""
    return getattr(x, "op", None) == "const" and _is_scale(x.data)
