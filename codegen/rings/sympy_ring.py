"""Kernels as SymPy expressions: what users see in `kernel.expr` and what exact tests compare."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import sympy

from .rings import Terms
from .targets.printer import coefficient_name
from .trace import Kernel


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


def expressions(kernel: Kernel) -> list[Any]:
    """Each output's coefficients, as expressions in symbols like ``m_e12``; unexpanded, as traced."""
    symbols = [sympy.Symbol(coefficient_name(i, j), real=True) for i in kernel.inputs for j in range(i.kind.size)]
    return kernel.evaluate_flat(symbols, SymbolicRing())
