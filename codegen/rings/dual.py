"""Dual numbers: values with a tangent over any other ring, so that a formula yields its own derivative."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from .partials import partials
from .protocol import Ring, Terms

#: A value and its tangent; the tangent None is zero.
Dual = tuple[Any, Any]


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
            for factor, a in zip(partials(base, name, value, [a[0] for a in arguments]), arguments, strict=True)
            if a[1] is not None
        ]
        return value, base.combine(parts) if parts else None

    def select(self, mask: Any, a: Dual, b: Dual) -> Dual:
        value = self.base.select(mask, a[0], b[0])
        if a[1] is None and b[1] is None:
            return value, None
        zero = self.base.constant(Fraction(0))
        return value, self.base.select(mask, zero if a[1] is None else a[1], zero if b[1] is None else b[1])

    def is_zero(self, a: Dual) -> bool:
        return self.base.is_zero(a[0]) and (a[1] is None or self.base.is_zero(a[1]))
