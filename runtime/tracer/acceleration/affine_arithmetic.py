"""Affine arithmetic in one parameter: y = center + slope x +- radius for -1 <= x <= 1, over pieces of a curve.

A ring like the others: formulas run on it unchanged. The enclosure is rigorous: the radius holds the curvature over the
piece and the rounding of the arithmetic itself, so that its width falls with the square of the pieces' width.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...codegen.rings.protocol import Terms

Array = NDArray[np.float64]
#: Relative rounding error of one operation on affine forms, with a margin.
ROUNDING = 16 * 2.0**-53


class AffineForm(NamedTuple):
    """Center, slope and radius, arrays of one shape; a radius that is not finite stands for an unbounded form."""

    center: Any
    slope: Any
    radius: Any

    @property
    def size(self) -> Any:
        """Upper bound of the absolute value."""
        return np.abs(self.center) + np.abs(self.slope) + self.radius

    @property
    def low(self) -> Any:
        """Lower bound."""
        return self.center - (np.abs(self.slope) + self.radius) - ROUNDING * self.size

    @property
    def high(self) -> Any:
        """Upper bound."""
        return self.center + (np.abs(self.slope) + self.radius) + ROUNDING * self.size


class AffineRing:
    """Arithmetic on affine forms. Comparisons give two masks: certainly true, certainly false."""

    def constant(self, value: Fraction) -> AffineForm:
        x = value.numerator / value.denominator
        return AffineForm(x, 0.0, 0.0 if value == Fraction(x) else ROUNDING * abs(x))

    def combine(self, terms: Terms) -> AffineForm:
        center: Any = 0.0
        slope: Any = 0.0
        radius: Any = 0.0
        size: Any = 0.0
        for a, weight in terms:
            w = weight.numerator / weight.denominator
            center, slope, radius = center + w * a.center, slope + w * a.slope, radius + abs(w) * a.radius
            size = size + abs(w) * a.size
        return AffineForm(center, slope, radius + len(terms) * ROUNDING * size)

    def multiply(self, a: AffineForm, b: AffineForm) -> AffineForm:
        bent = 0.5 * (a.slope * b.slope)  # coefficient of x^2, which lies between 0 and 1
        center = a.center * b.center + bent
        slope = a.center * b.slope + a.slope * b.center
        size_a, size_b = np.abs(a.center) + np.abs(a.slope), np.abs(b.center) + np.abs(b.slope)
        radius = size_a * b.radius + size_b * a.radius + a.radius * b.radius + np.abs(bent)
        return AffineForm(center, slope, radius + ROUNDING * ((size_a + a.radius) * (size_b + b.radius)))

    def apply(self, name: str, *arguments: Any) -> Any:
        a = arguments[0]
        if name in ("lt", "le"):
            return a.high < arguments[1].low, a.low > arguments[1].high
        if name == "sqrt":
            return _sqrt(a)
        if name == "reciprocal":
            return _reciprocal(a)
        raise NotImplementedError(f"{name} of an affine form")

    def select(self, mask: tuple[Any, Any], a: AffineForm, b: AffineForm) -> AffineForm:
        surely, never = mask
        low, high = np.minimum(a.low, b.low), np.maximum(a.high, b.high)
        either = AffineForm(0.5 * (low + high), 0.0, 0.5 * (high - low))
        either = either._replace(radius=either.radius + ROUNDING * either.size)
        return AffineForm(
            *(np.where(surely, x, np.where(never, y, z)) for x, y, z in zip(a, b, either, strict=True)),
        )

    def is_zero(self, a: AffineForm) -> bool:
        return False


def _sqrt(a: AffineForm) -> AffineForm:
    """Chord of the square root between both ends; the root lies above it, farthest where its tangent is parallel."""
    low, high = np.sqrt(np.maximum(a.low, 0.0)), np.sqrt(np.maximum(a.high, 0.0))
    total = low + high
    safe = np.where(total > 0, total, 1.0)
    steep = 1.0 / safe
    above = 0.125 * ((high - low) ** 2 / safe)
    # values below zero are rounding, or not values at all: they count as zero, which is further up the chord
    below = np.where(a.low < 0, -a.low, 0.0) * steep
    center = steep * (a.center + low * high) + above
    return _with_rounding(AffineForm(center, steep * a.slope, steep * a.radius + above + below), high)


def _reciprocal(a: AffineForm) -> AffineForm:
    """Chord of 1/y between both ends; 1/y lies below it (for y > 0), farthest at the geometric mean."""
    low, high = a.low, a.high
    sign = np.where(low > 0, 1.0, -1.0)
    near, far = np.where(low > 0, low, -high), np.where(low > 0, high, -low)
    has_sign = near > 0
    near, far = np.where(has_sign, near, 1.0), np.where(has_sign, far, 1.0)
    steep = 1.0 / near / far
    bent = 0.5 * (1.0 / np.sqrt(near) - 1.0 / np.sqrt(far)) ** 2
    center = (1.0 / near + 1.0 / far - bent) - steep * (sign * a.center)
    result = _with_rounding(AffineForm(sign * center, -steep * a.slope, steep * a.radius + bent), 1.0 / near)
    return result._replace(radius=np.where(has_sign, result.radius, np.inf))


def _with_rounding(a: AffineForm, size: Any) -> AffineForm:
    return a._replace(radius=a.radius + ROUNDING * (a.size + size))


def polynomial(coefficients: Array, begin: Array, end: Array) -> AffineForm:
    """Bernstein polynomials (n + 1, ..., pieces) over pieces of [0, 1].

    Over a piece the polynomial deviates from the chord by no more than its Bernstein coefficients do.
    """
    n = len(coefficients) - 1
    part = _restrict(coefficients, begin, end)
    center, slope = 0.5 * (part[0] + part[n]), 0.5 * (part[n] - part[0])
    rounding = (n + 1) * ROUNDING * np.max(np.abs(coefficients), axis=0)
    if n < 2:
        return AffineForm(center, slope, rounding)
    off = [part[k] - (part[0] + (2 * k / n) * slope) for k in range(1, n)]
    low, high = np.minimum(np.min(off, axis=0), 0.0), np.maximum(np.max(off, axis=0), 0.0)
    return AffineForm(center + 0.5 * (low + high), slope, 0.5 * (high - low) + rounding)


def _restrict(coefficients: Array, begin: Array, end: Array) -> Array:
    """Bernstein coefficients over [begin, end], by de Casteljau subdivision at the end, then at the beginning."""
    part = coefficients.copy()
    n = len(part) - 1
    for j in range(1, n + 1):
        part[j:] = part[j - 1 : -1] + end * (part[j:] - part[j - 1 : -1])
    begin = begin / np.where(end > 0, end, 1.0)
    for j in range(1, n + 1):
        part[: n + 1 - j] += begin * (part[1 : n + 2 - j] - part[: n + 1 - j])
    return part
