"""Numbers that depend on one parameter, enclosed over pieces of it: y = middle + slope x +- error for -1 <= x <= 1.

A ring like the others: formulas run on it unchanged. What is enclosed is exact: the error holds the curvature over the
piece and the rounding of the enclosure's own arithmetic, so that its width falls with the square of the pieces'.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..codegen.rings import Terms

Array = NDArray[np.float64]
#: Roundings of one operation on enclosures, a few more than it makes.
ROUNDING = 16 * 2.0**-53


class Enclosure(NamedTuple):
    """Middle, slope and error, arrays of one shape; an error that is not finite means that nothing is known."""

    middle: Any
    slope: Any
    error: Any

    @property
    def size(self) -> Any:
        """The largest absolute value."""
        return np.abs(self.middle) + np.abs(self.slope) + self.error

    @property
    def low(self) -> Any:
        """No value is less."""
        return self.middle - (np.abs(self.slope) + self.error) - ROUNDING * self.size

    @property
    def high(self) -> Any:
        """No value is more."""
        return self.middle + (np.abs(self.slope) + self.error) + ROUNDING * self.size


class EnclosureRing:
    """Arithmetic on enclosures. Comparisons give two masks: certainly, certainly not."""

    def constant(self, value: Fraction) -> Enclosure:
        x = value.numerator / value.denominator
        return Enclosure(x, 0.0, 0.0 if value == Fraction(x) else ROUNDING * abs(x))

    def combine(self, terms: Terms) -> Enclosure:
        middle: Any = 0.0
        slope: Any = 0.0
        error: Any = 0.0
        size: Any = 0.0
        for a, weight in terms:
            w = weight.numerator / weight.denominator
            middle, slope, error = middle + w * a.middle, slope + w * a.slope, error + abs(w) * a.error
            size = size + abs(w) * a.size
        return Enclosure(middle, slope, error + len(terms) * ROUNDING * size)

    def multiply(self, a: Enclosure, b: Enclosure) -> Enclosure:
        bent = 0.5 * (a.slope * b.slope)  # of the square of x, between 0 and 1
        middle = a.middle * b.middle + bent
        slope = a.middle * b.slope + a.slope * b.middle
        own, other = np.abs(a.middle) + np.abs(a.slope), np.abs(b.middle) + np.abs(b.slope)
        error = own * b.error + other * a.error + a.error * b.error + np.abs(bent)
        return Enclosure(middle, slope, error + ROUNDING * ((own + a.error) * (other + b.error)))

    def apply(self, name: str, *arguments: Any) -> Any:
        a = arguments[0]
        if name in ("lt", "le"):
            return a.high < arguments[1].low, a.low > arguments[1].high
        if name == "sqrt":
            return _root(a)
        if name == "reciprocal":
            return _reciprocal(a)
        raise NotImplementedError(f"{name} of an enclosure")

    def select(self, mask: tuple[Any, Any], a: Enclosure, b: Enclosure) -> Enclosure:
        surely, never = mask
        low, high = np.minimum(a.low, b.low), np.maximum(a.high, b.high)
        either = Enclosure(0.5 * (low + high), 0.0, 0.5 * (high - low))
        either = either._replace(error=either.error + ROUNDING * either.size)
        return Enclosure(
            *(np.where(surely, x, np.where(never, y, z)) for x, y, z in zip(a, b, either, strict=True)),
        )

    def is_zero(self, a: Enclosure) -> bool:
        return False


def _root(a: Enclosure) -> Enclosure:
    """The chord of the root between both ends; the root is above it, most where it is parallel."""
    low, high = np.sqrt(np.maximum(a.low, 0.0)), np.sqrt(np.maximum(a.high, 0.0))
    total = low + high
    safe = np.where(total > 0, total, 1.0)
    steep = 1.0 / safe
    above = 0.125 * ((high - low) ** 2 / safe)
    # values below zero are rounding, or no values: they count as zero, which is further up the chord
    below = np.where(a.low < 0, -a.low, 0.0) * steep
    middle = steep * (a.middle + low * high) + above
    return _rounded(Enclosure(middle, steep * a.slope, steep * a.error + above + below), high)


def _reciprocal(a: Enclosure) -> Enclosure:
    """The chord of 1/y between both ends; 1/y is below it (for y > 0), most at the geometric mean."""
    low, high = a.low, a.high
    sign = np.where(low > 0, 1.0, -1.0)
    near, far = np.where(low > 0, low, -high), np.where(low > 0, high, -low)
    known = near > 0
    near, far = np.where(known, near, 1.0), np.where(known, far, 1.0)
    steep = 1.0 / near / far
    bent = 0.5 * (1.0 / np.sqrt(near) - 1.0 / np.sqrt(far)) ** 2
    middle = (1.0 / near + 1.0 / far - bent) - steep * (sign * a.middle)
    found = _rounded(Enclosure(sign * middle, -steep * a.slope, steep * a.error + bent), 1.0 / near)
    return found._replace(error=np.where(known, found.error, np.inf))


def _rounded(a: Enclosure, size: Any) -> Enclosure:
    return a._replace(error=a.error + ROUNDING * (a.size + size))


def polynomial(coefficients: Array, begin: Array, end: Array) -> Enclosure:
    """Bernstein polynomials (n + 1, ..., pieces) over pieces of [0, 1].

    Over its piece a polynomial stays within the most that its Bernstein coefficients there are off the chord's.
    """
    n = len(coefficients) - 1
    part = _restricted(coefficients, begin, end)
    middle, slope = 0.5 * (part[0] + part[n]), 0.5 * (part[n] - part[0])
    rounding = (n + 1) * ROUNDING * np.max(np.abs(coefficients), axis=0)
    if n < 2:
        return Enclosure(middle, slope, rounding)
    off = [part[k] - (part[0] + (2 * k / n) * slope) for k in range(1, n)]
    low, high = np.minimum(np.min(off, axis=0), 0.0), np.maximum(np.max(off, axis=0), 0.0)
    return Enclosure(middle + 0.5 * (low + high), slope, 0.5 * (high - low) + rounding)


def _restricted(coefficients: Array, begin: Array, end: Array) -> Array:
    """Bernstein coefficients over [begin, end], by de Casteljau's cuts: at the end, then at the beginning."""
    part = coefficients.copy()
    n = len(part) - 1
    for j in range(1, n + 1):
        part[j:] = part[j - 1 : -1] + end * (part[j:] - part[j - 1 : -1])
    begin = begin / np.where(end > 0, end, 1.0)
    for j in range(1, n + 1):
        part[: n + 1 - j] += begin * (part[1 : n + 2 - j] - part[: n + 1 - j])
    return part


__all__ = ["Enclosure", "EnclosureRing", "polynomial"]
