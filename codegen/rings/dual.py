"""Dual numbers: values with a tangent over any other ring, so that a formula yields its own derivative."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from ..errors import TraceError
from .protocol import Ring, Terms

#: A value and its tangent; the tangent None is zero.
Dual = tuple[Any, Any]
_HALF = Fraction(1, 2)


class DualRing:
    """Values with tangents over a base ring."""

    def __init__(self, base: Ring) -> None:
        self.base = base
        self.is_symbolic = getattr(base, "is_symbolic", False)

    def constant(self, value: Fraction) -> Dual:
        return self.base.constant(value), None

    def combine(self, terms: Terms) -> Dual:
        values = self.base.combine([(c[0], w) for c, w in terms])
        tangents = [(c[1], w) for c, w in terms if c[1] is not None]
        return values, self.base.combine(tangents) if tangents else None

    def multiply(self, a: Dual, b: Dual) -> Dual:
        parts = []
        if a[1] is not None:
            parts.append((self.base.multiply(a[1], b[0]), Fraction(1)))
        if b[1] is not None:
            parts.append((self.base.multiply(a[0], b[1]), Fraction(1)))
        return self.base.multiply(a[0], b[0]), self.base.combine(parts) if parts else None

    def apply(self, name: str, *arguments: Any) -> Any:
        base = self.base
        if name in ("and", "or", "not"):
            return base.apply(name, *arguments)
        if name in ("lt", "le"):
            return base.apply(name, arguments[0][0], arguments[1][0])
        value = base.apply(name, *(a[0] for a in arguments))
        if not arguments:  # where there is no value there is no derivative
            return value, value if name == "nan" else None
        parts = [
            (base.multiply(factor(), a[1]), Fraction(1))
            for factor, a in zip(self._factors(name, value, [a[0] for a in arguments]), arguments, strict=True)
            if a[1] is not None
        ]
        return value, base.combine(parts) if parts else None

    def _factors(self, name: str, value: Any, x: Sequence[Any]) -> Sequence[Callable[[], Any]]:
        """Partial derivatives of a function, as thunks: made only for arguments that vary."""
        base = self.base
        one = base.constant(Fraction(1))

        def scale(a: Any, w: Fraction) -> Any:
            return base.combine([(a, w)])

        def stumpff(k: int, w: Any) -> Any:
            return base.apply(f"stumpff{k}", w)

        if name.startswith("stumpff"):  # c_k' = (k c_{k+2} - c_{k+1})/2
            k = int(name[-1])
            if k > 3:
                raise TraceError(f"the derivative of {name} needs Stumpff functions beyond the fifth.")
            higher: list[tuple[Any, Fraction]] = [(stumpff(k + 1, x[0]), -_HALF)]
            if k:
                higher.append((stumpff(k + 2, x[0]), _HALF * k))
            return [lambda: base.combine(higher)]
        rules: dict[str, list[Callable[[], Any]]] = {
            "sqrt": [lambda: scale(base.apply("reciprocal", value), _HALF)],
            "reciprocal": [lambda: scale(base.multiply(value, value), Fraction(-1))],
            "abs": [
                lambda: base.select(base.apply("lt", x[0], base.constant(Fraction(0))), scale(one, Fraction(-1)), one)
            ],
            "sin": [lambda: base.apply("cos", x[0])],
            "cos": [lambda: scale(base.apply("sin", x[0]), Fraction(-1))],
            "exp": [lambda: value],
            "rounded": [lambda: one],
            "log": [lambda: base.apply("reciprocal", x[0])],
            "atan2": [lambda: self._atan2_partial(x[1], x), lambda: scale(self._atan2_partial(x[0], x), Fraction(-1))],
        }
        return rules[name]

    def _atan2_partial(self, numerator: Any, x: Sequence[Any]) -> Any:
        """numerator/(x0^2 + x1^2), the partial derivatives of atan2 but for the sign."""
        square = self.base.combine([(self.base.multiply(a, a), Fraction(1)) for a in x])
        return self.base.multiply(numerator, self.base.apply("reciprocal", square))

    def select(self, mask: Any, a: Dual, b: Dual) -> Dual:
        value = self.base.select(mask, a[0], b[0])
        if a[1] is None and b[1] is None:
            return value, None
        zero = self.base.constant(Fraction(0))
        return value, self.base.select(mask, zero if a[1] is None else a[1], zero if b[1] is None else b[1])

    def is_zero(self, a: Dual) -> bool:
        return self.base.is_zero(a[0]) and (a[1] is None or self.base.is_zero(a[1]))
