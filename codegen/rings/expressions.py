"""SymPy expressions as polynomials in their atoms: sums and products expand here, without SymPy.

An atom is what is no sum, product or whole power: a symbol, a function, a root, the inverse of a sum. Coefficients are
fractions, or floats where a user wrote them. The zero polynomial is the only one that is known to be zero: what
vanishes by an identity of functions, such as sin(a)^2 + cos(a)^2 - 1, does not.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import Any, TypeAlias

import sympy

from ..errors import InputError
from .protocol import Terms

#: Atoms by number, with their exponents, which may be negative: ascending, none zero.
Monomial: TypeAlias = tuple[tuple[int, int], ...]
Number: TypeAlias = Fraction | float
Polynomial: TypeAlias = dict[Monomial, Number]

ONE: Monomial = ()
#: Whole powers beyond this stay as they are.
MAX_EXPONENT = 64
#: Products of monomials that are remembered.
MAX_PRODUCTS = 1_000_000
#: Expansions of more terms stay products, as one atom each.
MAX_TERMS = 20_000


class Atoms:
    """The atoms that there are, in the order in which they came."""

    def __init__(self) -> None:
        self.expressions: list[Any] = []
        self.numbers: dict[Any, int] = {}
        self._products: dict[tuple[Monomial, Monomial], Monomial] = {}

    def number(self, expression: Any) -> int:
        """The number of an expression as an atom."""
        known = self.numbers.get(expression)
        if known is None:
            known = self.numbers[expression] = len(self.expressions)
            self.expressions.append(expression)
        return known

    def product(self, a: Monomial, b: Monomial) -> Monomial:
        """The product of two monomials."""
        if not a or not b:
            return a or b
        known = self._products.get((a, b))
        if known is None:
            exponents = dict(a)
            for atom, exponent in b:
                exponents[atom] = exponents.get(atom, 0) + exponent
            if len(self._products) >= MAX_PRODUCTS:
                self._products.clear()
            known = self._products[a, b] = tuple(sorted(item for item in exponents.items() if item[1]))
        return known


ATOMS = Atoms()


def from_sympy(value: Any) -> Polynomial:
    """The polynomial of a number or an expression, expanded."""
    if isinstance(value, int | Fraction | float):
        return {ONE: value if isinstance(value, float) else Fraction(value)} if value != 0 else {}
    if value.is_Rational:
        return {ONE: Fraction(int(value.p), int(value.q))} if value else {}
    if value.is_Float and math.isfinite(float(value)):  # larger ones are atoms
        return {ONE: float(value)} if value else {}
    if value.is_Add:
        return plus((from_sympy(term), Fraction(1)) for term in value.args)
    if value.is_Mul:
        result: Polynomial = {ONE: Fraction(1)}
        for factor in value.args:
            result = times(result, from_sympy(factor))
        return result
    if value.is_Pow and value.exp.is_Integer and abs(int(value.exp)) <= MAX_EXPONENT:
        return power(from_sympy(value.base), int(value.exp))
    return {((ATOMS.number(value), 1),): Fraction(1)}


def to_sympy(polynomial: Polynomial) -> Any:
    """A polynomial as a SymPy sum."""
    atoms = ATOMS.expressions
    terms = []
    for monomial, weight in polynomial.items():
        factors = [sympy.Pow(atoms[atom], exponent) for atom, exponent in monomial]
        terms.append(sympy.Mul(number_to_sympy(weight), *factors))
    return sympy.Add(*terms)


def number_to_sympy(value: Number) -> Any:
    """A coefficient as a SymPy number.

    Raises
    ------
    InputError
        If it is a float beyond the range of numbers.
    """
    if value - value != 0:
        raise _beyond()
    return sympy.Float(value) if isinstance(value, float) else sympy.Rational(value.numerator, value.denominator)


def _beyond() -> InputError:
    return InputError("a coefficient is beyond the range of floats.", remedy="Use fractions, or other units")


def _product(x: Number, y: Number) -> Number:
    try:
        return x * y
    except OverflowError:  # of a fraction that no float holds, and a float
        raise _beyond() from None


def plus(terms: Iterable[tuple[Polynomial, Number]]) -> Polynomial:
    """A linear combination."""
    total: Polynomial = {}
    for polynomial, weight in terms:
        for monomial, value in polynomial.items():
            scaled = value if weight == 1 else _product(value, weight)
            total[monomial] = total[monomial] + scaled if monomial in total else scaled
    return {monomial: value for monomial, value in total.items() if value}


def times(a: Polynomial, b: Polynomial) -> Polynomial:
    """A product, expanded unless it would be larger than `MAX_TERMS`."""
    if len(a) * len(b) > MAX_TERMS:
        a, b = as_atom(a), as_atom(b)
    total: Polynomial = {}
    product = ATOMS.product
    for first, x in a.items():
        for second, y in b.items():
            monomial = product(first, second)
            value = _product(x, y)
            total[monomial] = total[monomial] + value if monomial in total else value
    return {monomial: value for monomial, value in total.items() if value}


def as_atom(polynomial: Polynomial) -> Polynomial:
    """A sum as one atom; a single term as it is."""
    if len(polynomial) <= 1:
        return polynomial
    return {((ATOMS.number(to_sympy(polynomial)), 1),): Fraction(1)}


def power(base: Polynomial, exponent: int) -> Polynomial:
    """A whole power; the inverse of a sum is an atom."""
    if exponent < 0:
        base, exponent = reciprocal(base), -exponent
    result: Polynomial = {ONE: Fraction(1)}
    for _ in range(exponent):
        result = times(result, base)
    return result


def reciprocal(polynomial: Polynomial) -> Polynomial:
    """1 over a polynomial: a monomial's has negative exponents; a sum's is an atom, over its leading coefficient.

    Raises
    ------
    ZeroDivisionError
        If it is zero.
    """
    if not polynomial:
        raise ZeroDivisionError("division by an expression that is zero")
    lead = next(iter(polynomial.values()))
    inverse = 1 / lead
    if len(polynomial) == 1:
        (monomial,) = polynomial
        return {tuple((atom, -exponent) for atom, exponent in monomial): inverse}
    monic = to_sympy({monomial: value * inverse for monomial, value in polynomial.items()})
    if monic == 0:  # 2 - sqrt(2)^2, 1 + I^2
        raise ZeroDivisionError("division by an expression that is zero")
    return {((ATOMS.number(monic), -1),): inverse}


class ExpressionRing:
    """Expressions as `Polynomial`."""

    is_symbolic = True

    def constant(self, value: Fraction) -> Polynomial:
        return {ONE: value} if value else {}

    def combine(self, terms: Terms) -> Polynomial:
        return plus(terms)

    def multiply(self, a: Polynomial, b: Polynomial) -> Polynomial:
        return times(a, b)

    def apply(self, name: str, *arguments: Polynomial) -> Any:
        """A function of expressions; comparisons give SymPy's conditions."""
        if name == "reciprocal":
            return reciprocal(arguments[0])
        if name in ("and", "or", "not"):
            return {"and": sympy.And, "or": sympy.Or, "not": sympy.Not}[name](*arguments)
        values = [to_sympy(a) for a in arguments]
        if name in ("lt", "le"):
            return {"lt": sympy.Lt, "le": sympy.Le}[name](*values)
        if name == "rounded":
            return arguments[0]
        if name == "sqrt":
            values = [sympy.factor(values[0])]
        function = sympy.Abs if name == "abs" else getattr(sympy, name, None) or sympy.Function(name)
        return from_sympy(function(*values))

    def select(self, mask: Any, a: Polynomial, b: Polynomial) -> Polynomial:
        """a where the condition holds, else b."""
        return from_sympy(sympy.Piecewise((to_sympy(a), mask), (to_sympy(b), True)))

    def is_zero(self, a: Polynomial) -> bool:
        return not a
