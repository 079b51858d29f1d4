"""Running first-order error bounds: how far rounding can carry a form from the exact value of its inputs.

Values are pairs (value, bound), the bound in units of the unit roundoff. It decides which forms are admitted, and
the tests hold every target to a multiple of the bound of the formula as written.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from .protocol import STUMPFF, NumericRing, Terms

Bounded = tuple[Any, Any]
#: Errors in units of roundoff, as promised in docs/algebra/elementary.md; an ulp is at most two units.
FUNCTION_ERROR = {
    "abs": 0.0, "rounded": 0.0, "sqrt": 1.0, "reciprocal": 1.0,
    **dict.fromkeys(STUMPFF[:4], 8.0), **dict.fromkeys(STUMPFF[4:], 16.0),
}  # fmt: skip
#: Error of all other functions: 2 ulp.
USUAL_FUNCTION_ERROR = 4.0


def _is_power_of_two(w: Fraction) -> bool:
    n, d = abs(w.numerator), w.denominator
    return n & (n - 1) == 0 and d & (d - 1) == 0


class BoundRing:
    """Arrays of float64 values with bounds."""

    def __init__(self) -> None:
        self.values = NumericRing()

    def constant(self, value: Fraction) -> Bounded:
        v = self.values.constant(value)
        return v, 0.0 if Fraction(float(v)) == value else np.abs(v)

    def combine(self, terms: Terms) -> Bounded:
        total: Any = 0.0
        bound: Any = 0.0
        with np.errstate(all="ignore"):
            for i, ((v, b), w) in enumerate(terms):
                scale = abs(float(w))
                part = v * float(w)
                bound = bound + b * scale
                if not _is_power_of_two(w):
                    bound = bound + np.abs(part)
                total = total + part
                if i:
                    bound = bound + np.abs(total)
        return total, bound

    def multiply(self, a: Bounded, b: Bounded) -> Bounded:
        with np.errstate(all="ignore"):
            value = a[0] * b[0]
            return value, np.abs(a[0]) * b[1] + np.abs(b[0]) * a[1] + np.abs(value)

    def apply(self, name: str, *arguments: Any) -> Any:
        if name in ("and", "or", "not"):
            return self.values.apply(name, *arguments)
        x = [a[0] for a in arguments]
        value = self.values.apply(name, *x)
        if not arguments:
            return value, 0.0
        if name in ("lt", "le"):
            return value
        with np.errstate(all="ignore"):
            bound = sum(np.abs(d) * a[1] for d, a in zip(_partials(name, value, x), arguments, strict=True))
            return value, bound + np.abs(value) * FUNCTION_ERROR.get(name, USUAL_FUNCTION_ERROR)

    def select(self, mask: Any, a: Bounded, b: Bounded) -> Bounded:
        return np.where(mask, a[0], b[0]), np.where(mask, a[1], b[1])

    def is_zero(self, a: Bounded) -> bool:
        return False


def _partials(name: str, value: Any, x: list[Any]) -> list[Any]:
    match name:
        case "sqrt":
            return [0.5 / value]
        case "reciprocal":
            return [value * value]
        case "abs" | "rounded":
            return [1.0]
        case "sin":
            return [np.cos(x[0])]
        case "cos":
            return [np.sin(x[0])]
        case "exp":
            return [value]
        case "log":
            return [1 / x[0]]
        case "atan2":
            square = x[0] * x[0] + x[1] * x[1]
            return [x[1] / square, x[0] / square]
    return [np.maximum(1.0, np.abs(value))]  # Stumpff functions: |c_k'| <= max(1, c_k)
