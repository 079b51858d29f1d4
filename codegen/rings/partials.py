"""Partial derivatives of the functions that formulas may apply: one table, of forward and of reverse derivatives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from ..errors import TraceError
from .protocol import STUMPFF, Ring

_HALF = Fraction(1, 2)


def partials(ring: Ring, name: str, value: Any, x: Sequence[Any]) -> Sequence[Callable[[], Any]]:
    """Partial derivatives of a function, as thunks: made only for arguments that vary.

    Parameters
    ----------
    ring : Ring
    name : str
        One of `FUNCTIONS` that has arguments.
    value, x
        The function's value, and its arguments.
    """
    if name.startswith("stumpff"):
        return [lambda: _stumpff(ring, int(name[-1]), x[0])]
    one = ring.constant(Fraction(1))

    def scale(a: Any, w: Fraction) -> Any:
        return ring.combine([(a, w)])

    rules: dict[str, list[Callable[[], Any]]] = {
        "sqrt": [lambda: scale(ring.apply("reciprocal", value), _HALF)],
        "reciprocal": [lambda: scale(ring.multiply(value, value), Fraction(-1))],
        "abs": [lambda: ring.select(ring.apply("lt", x[0], ring.constant(Fraction(0))), scale(one, Fraction(-1)), one)],
        "sin": [lambda: ring.apply("cos", x[0])],
        "cos": [lambda: scale(ring.apply("sin", x[0]), Fraction(-1))],
        "exp": [lambda: value],
        "rounded": [lambda: one],
        "log": [lambda: ring.apply("reciprocal", x[0])],
        "atan2": [lambda: _atan2(ring, x[1], x), lambda: scale(_atan2(ring, x[0], x), Fraction(-1))],
    }
    return rules[name]


def _stumpff(ring: Ring, k: int, w: Any) -> Any:
    """c_k' = (k c_{k+2} - c_{k+1})/2."""
    if k + 2 >= len(STUMPFF):
        raise TraceError(f"the derivative of stumpff{k} needs Stumpff functions beyond {STUMPFF[-1]}.")
    terms = [(ring.apply(STUMPFF[k + 1], w), -_HALF)]
    if k:
        terms.append((ring.apply(STUMPFF[k + 2], w), _HALF * k))
    return ring.combine(terms)


def _atan2(ring: Ring, numerator: Any, x: Sequence[Any]) -> Any:
    """numerator/(x0^2 + x1^2), the partial derivatives of atan2 but for the sign."""
    square = ring.combine([(ring.multiply(a, a), Fraction(1)) for a in x])
    return ring.multiply(numerator, ring.apply("reciprocal", square))
