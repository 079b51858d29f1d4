"""SymPy expressions as coefficients: for `kernel.expr`, and for exact tests."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import sympy

from .protocol import Terms


class SymbolicRing:
    """SymPy expressions."""

    is_symbolic = True

    def constant(self, value: Fraction) -> Any:
        return sympy.Rational(value.numerator, value.denominator)

    def combine(self, terms: Terms) -> Any:
        return sympy.Add(*(c * self.constant(w) for c, w in terms))

    def multiply(self, a: Any, b: Any) -> Any:
        return a * b

    def apply(self, name: str, *arguments: Any) -> Any:
        match name:
            case "reciprocal":
                return 1 / arguments[0]
            case "lt":
                return sympy.Lt(*arguments)
            case "le":
                return sympy.Le(*arguments)
            case "and" | "or" | "not":
                return {"and": sympy.And, "or": sympy.Or, "not": sympy.Not}[name](*arguments)
            case "abs":
                return sympy.Abs(*arguments)
            case "rounded":
                return arguments[0]
            case "sqrt" | "sin" | "cos" | "exp" | "log" | "atan2":
                return getattr(sympy, name)(*arguments)
        if not arguments:
            return sympy.nan if name == "nan" else sympy.Symbol(name, positive=True)
        return sympy.Function(name)(*arguments)

    def select(self, mask: Any, a: Any, b: Any) -> Any:
        return sympy.Piecewise((a, mask), (b, True))

    def is_zero(self, a: Any) -> bool:
        return bool(a == 0)
