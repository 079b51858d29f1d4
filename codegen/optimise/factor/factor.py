"""Polynomials in, cheap straight-line code out: algebraic factoring with sharing between all outputs.

The stages: pack the polynomials (`packed`), extract common divisors (`pairs`, `divisors`) under a search
(`search`), share common products (`products`), and build expressions (here). Standard library only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from .packed import Monomial, Number, Poly, System, magnitude
from .products import Node, Products, common_products
from .search import search

__all__ = ["Atom", "Constant", "Expr", "Monomial", "Poly", "Product", "Sum", "factor"]


@dataclass(frozen=True, slots=True)
class Atom:
    """An input, or anything opaque that was computed before."""

    index: int


@dataclass(frozen=True, slots=True)
class Constant:
    """A number."""

    value: Fraction


@dataclass(frozen=True, slots=True)
class Sum:
    """Sum of terms with rational coefficients; one term makes a scaled or negated expression."""

    terms: tuple[tuple[Expr, Fraction], ...]


@dataclass(frozen=True, slots=True)
class Product:
    """Product of two or more factors."""

    factors: tuple[Expr, ...]


Expr: TypeAlias = Atom | Constant | Sum | Product

_PAIRS_TO_WORK = 60
"""Default budget per pair of terms: a first pass takes 6 to 16, a round of the search 2 to 10."""

_LEAST_BUDGET = 10_000
"""Least default budget: about 0.02 seconds."""

_MOST_BUDGET = 1_500_000
"""Largest default budget: about 3 seconds."""


def factor(polynomials: Sequence[Poly], atom_count: int, budget: int | None = None, seed: int = 0) -> list[Expr]:
    """Expressions that compute the polynomials with few operations, exactly.

    Parameters
    ----------
    polynomials : sequence of Poly
        One per output. Repeated, negated and scaled outputs are shared.
    atom_count : int
        Atoms are numbered 0 .. atom_count - 1.
    budget : int, optional
        Work in pairs of terms and terms looked at, about half a million per second; never time, so that every
        machine finds the same. By default it grows with the problem. More of it may find cheaper forms.
    seed : int
        Another seed looks elsewhere: several short searches may be tried once, and the best seed kept.

    Returns
    -------
    list of Expr
        One per polynomial; equal subexpressions are one object.

    Raises
    ------
    ValueError
        If a monomial is malformed or names an atom out of range.
    """
    for polynomial in polynomials:
        _check(polynomial, atom_count)
    system = System.load(polynomials, atom_count)
    if budget is None:
        budget = min(max(_PAIRS_TO_WORK * system.pair_count(), _LEAST_BUDGET), _MOST_BUDGET)
    found = search(system, atom_count, budget, seed)
    return _Builder(found, atom_count).outputs(len(polynomials))


def multiply(left: Poly, right: Poly) -> Poly:
    """Product of two polynomials."""
    result: Poly = {}
    for first, a in left.items():
        for second, b in right.items():
            exponents = dict(first)
            for atom, exponent in second:
                exponents[atom] = exponents.get(atom, 0) + exponent
            key = tuple(sorted(exponents.items()))
            result[key] = result.get(key, Fraction(0)) + a * b
    return {monomial: value for monomial, value in result.items() if value}


def _check(polynomial: Poly, atom_count: int) -> None:
    for monomial in polynomial:
        atoms = [atom for atom, _ in monomial]
        ascending = all(left < right for left, right in zip(atoms, atoms[1:], strict=False))
        if not ascending or any(exponent <= 0 for _, exponent in monomial):
            raise ValueError(f"{monomial!r} is not a monomial: sorted (atom, positive exponent) pairs.")
        if atoms and (atoms[0] < 0 or atoms[-1] >= atom_count):
            raise ValueError(f"{monomial!r} names an atom outside 0 .. {atom_count - 1}.")


class _Builder:
    """Hash-consed expressions of a system."""

    def __init__(self, system: System, atom_count: int) -> None:
        self._system = system
        self._atom_count = atom_count
        self._products: Products = common_products(system)
        self._made: dict[object, Expr] = {}
        self._literals: dict[int, Expr] = {}

    def outputs(self, count: int) -> list[Expr]:
        return [self._polynomial(-1 - index) for index in range(count)]

    def _intern(self, key: object, node: Expr) -> Expr:
        return self._made.setdefault(key, node)

    def _sum(self, terms: list[tuple[Expr, Fraction]]) -> Expr:
        if not terms:
            return self._constant(Fraction(0))
        if len(terms) == 1 and terms[0][1] == 1:
            return terms[0][0]
        return self._intern(("+", *((id(node), value) for node, value in terms)), Sum(tuple(terms)))

    def _product(self, factors: list[Expr]) -> Expr:
        if len(factors) == 1:
            return factors[0]
        return self._intern(("*", *map(id, factors)), Product(tuple(factors)))

    def _constant(self, value: Fraction) -> Expr:
        return self._intern(("constant", value), Constant(value))

    def _polynomial(self, index: int) -> Expr:
        """The sum that an output or a definition is."""
        terms = []
        for monomial, value in self._system.polynomials[index].items():
            terms.append(self._term(self._system.packing.literals(monomial), value))
        positive_first = sorted(terms, key=lambda term: term[1] < 0)
        return self._sum(positive_first)

    def _term(self, literals: list[int], value: Number) -> tuple[Expr, Fraction]:
        """A term as (expression, coefficient); a scaled product that several terms use is one node."""
        sign = Fraction(1 if value > 0 else -1)
        size = magnitude(value)
        if not literals:
            return self._constant(Fraction(size)), sign
        if size != 1:
            literals.insert(0, -1 - self._products.coefficients.index(size))
        if len(literals) == 1:
            return self._literal(literals[0]), sign
        node: Node = tuple(literals)
        rest = self._products.rests[node]
        if rest[0] >= 0:
            return self._product([self._literal(literal) for literal in rest]), sign
        product = self._product([self._literal(literal) for literal in rest[1:]])
        if self._products.uses[node] > 1:
            return self._sum([(product, Fraction(size))]), sign
        return product, sign * size

    def _literal(self, literal: int) -> Expr:
        """An atom, a definition, or a shared pair."""
        if literal in self._literals:
            return self._literals[literal]
        if literal < self._atom_count:
            made = self._intern(("atom", literal), Atom(literal))
        elif literal < self._products.first_shared:
            made = self._polynomial(literal)
        else:
            pair = self._products.shared[literal - self._products.first_shared]
            if pair[0] < 0:
                size = Fraction(self._products.coefficients[-1 - pair[0]])
                made = self._sum([(self._literal(pair[1]), size)])
            else:
                made = self._product([self._literal(pair[0]), self._literal(pair[1])])
        self._literals[literal] = made
        return made
