"""Exponentials of symbolic multivectors whose square is a number."""

from __future__ import annotations

from typing import Any

import sympy

from ...codegen.errors import GradeError
from ...codegen.rings import expressions
from ...codegen.rings.expressions import Polynomial


def exp(x: Any) -> Any:
    """exp(s + B) = e^s (cosh r + B sinh(r)/r) with r^2 = B B, by cos and sin where that is negative."""
    scalar = x.grade(0)
    rest = x - scalar
    square = rest * rest
    others = [b for b in square.terms if b]
    if others:
        raise GradeError(
            f"the square has a part on {x.algebra.blade_name(others[0])}; exp of symbols is that of a blade.",
            remedy="Multiply the exponentials of commuting blades, or substitute numbers",
        )
    even, odd = even_and_odd(square.terms.get(0, {}))
    result = x.constant(even) + rest * x.constant(odd)
    return result * x.constant(sympy.exp(expressions.to_sympy(scalar.terms[0]))) if scalar.terms else result


def even_and_odd(square: Polynomial) -> tuple[Any, Any]:
    """cosh r and sinh(r)/r of the root r of a square, as real expressions where its sign shows."""
    if not square:
        return sympy.Integer(1), sympy.Integer(1)
    sign = sign_of(square)
    size = sympy.factor(expressions.to_sympy(square) * (sign or 1))
    if size == 0:  # 1 + I^2, which the polynomial does not know
        return sympy.Integer(1), sympy.Integer(1)
    root = half_power(square) if len(square) == 1 else sympy.sqrt(size)
    if sign < 0:
        return sympy.cos(root), sympy.sin(root) / root
    return sympy.cosh(root), sympy.sinh(root) / root


def sign_of(square: Polynomial) -> int:
    """1 or -1 where all terms have that sign for real symbols; 0 where that does not show."""
    signs = set()
    for monomial, weight in square.items():
        is_square = all(e % 2 == 0 or expressions.ATOMS.expressions[atom].is_nonnegative for atom, e in monomial)
        signs.add((1 if weight > 0 else -1) if is_square else 0)
    return signs.pop() if len(signs) == 1 else 0


def half_power(square: Polynomial) -> Any:
    """A root of the size of one term: its exponents by two. Of even functions either sign will do."""
    monomial, weight = next(iter(square.items()))
    atoms = expressions.ATOMS.expressions
    size = sympy.sqrt(expressions.number_to_sympy(weight if weight > 0 else -weight))
    return sympy.Mul(size, *(sympy.Pow(atoms[atom], sympy.Rational(e, 2)) for atom, e in monomial))



