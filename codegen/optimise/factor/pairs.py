"""Pairs of terms, indexed by the two-term divisor that they share, kept up to date while terms come and go.

The supply of candidates for `divisors`, with the cost and the saving of a divisor.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TypeAlias

from .packed import Number, System, Terms, magnitude, product_cost, ratio

Column: TypeAlias = tuple[int, Number]
"""One term of a divisor: packed monomial, coefficient."""

Row: TypeAlias = tuple[int, int, Number]
"""One place of a divisor: polynomial, packed cofactor, coefficient."""

PairKey: TypeAlias = tuple[int, int, int, int]
"""A two-term divisor q1 + n/d q2, as (q1, q2, n, d): integers, because hashing a Fraction is slow."""

_Place: TypeAlias = tuple[Number, int, int]
"""Where a two-term divisor stands: coefficient and the two packed monomials."""


class PairIndex:
    """All pairs of terms of a system's polynomials, by the divisor that is left without their common factor.

    Parameters
    ----------
    system : System
        Its polynomials are changed through `replace`.
    parts : bool
        Whether a divisor may take a part of a coefficient (1 of 2, of the same sign).
    """

    def __init__(self, system: System, parts: bool) -> None:
        self.work = 0
        self.parts = parts
        self.dirty: dict[PairKey, None] = {}
        self._packing = system.packing
        self._polynomials = system.polynomials
        self._places: dict[PairKey, dict[tuple[int, int], _Place]] = {}
        for index, terms in self._polynomials.items():
            monomials = list(terms)
            for position, monomial in enumerate(monomials):
                for other in monomials[:position]:
                    self._add(index, monomial, other)

    def _keys(self, index: int, left: int, right: int) -> list[tuple[PairKey, int, _Place]]:
        """The two-term divisors of a pair: (key, cofactor, place), whole and with part of a coefficient."""
        self.work += 1
        terms = self._polynomials[index]
        common = left & right
        first, second = self._packing.divide(left, common), self._packing.divide(right, common)
        if first > second:
            first, second, left, right = second, first, right, left
        a, b = terms[left], terms[right]
        if a == b:
            return [((first, second, 1, 1), common, (a, left, right))]
        if a == -b:
            return [((first, second, -1, 1), common, (a, left, right))]
        whole = ratio(b, a)
        keys = [((first, second, whole.numerator, whole.denominator), common, (a, left, right))]
        if self.parts:
            smaller = min(magnitude(a), magnitude(b))
            sign = 1 if whole > 0 else -1
            keys.append(((first, second, sign, 1), common, (smaller if a > 0 else -smaller, left, right)))
        return keys

    def _add(self, index: int, left: int, right: int) -> None:
        for key, common, place in self._keys(index, left, right):
            self._places.setdefault(key, {})[(index, common)] = place
            self.dirty[key] = None

    def _drop(self, index: int, left: int, right: int) -> None:
        for key, common, _ in self._keys(index, left, right):
            places = self._places[key]
            del places[(index, common)]
            if not places:
                del self._places[key]
            self.dirty[key] = None

    def replace(self, index: int, removed: list[int], added: Terms) -> None:
        """Take monomials out of a polynomial and put terms in."""
        terms = self._polynomials[index]
        for monomial in removed:
            for other in terms:
                if other != monomial:
                    self._drop(index, monomial, other)
            del terms[monomial]
        for monomial, value in added.items():
            others = list(terms)
            terms[monomial] = value
            for other in others:
                self._add(index, monomial, other)

    def polynomials_with(self, key: PairKey) -> list[int]:
        """The polynomials in which the divisor stands."""
        return [index for index, _ in self._places[key]]

    def rows(self, key: PairKey) -> list[Row]:
        """The places of a two-term divisor, without those that share a term with an earlier one."""
        places = self._places[key]
        if len(places) == 1:
            return [(index, common, place[0]) for (index, common), place in places.items()]
        used: set[tuple[int, int]] = set()
        rows = []
        for (index, common), (value, left, right) in places.items():
            if (index, left) not in used and (index, right) not in used:
                used.add((index, left))
                used.add((index, right))
                rows.append((index, common, value))
        return rows

    def saving(self, key: PairKey) -> int:
        """Operations saved by extracting a two-term divisor wherever it occurs."""
        places = self._places.get(key)
        if places is None:
            return 0
        if len(places) == 1:
            (((_, common), (value, _, _)),) = places.items()
            if common == 0 and value in (1, -1):
                return 0  # the commonest case
        columns = pair_columns(key)
        factor = columns[1][1]
        total = -divisor_cost(columns)
        for row in self.rows(key):
            index, common, value = row
            terms = self._polynomials[index]
            _, left, right = places[(index, common)]
            total += term_gain(left, terms[left], value) + term_gain(right, terms[right], value * factor)
            total -= row_cost(row)
        return total


def pair_columns(key: PairKey) -> list[Column]:
    """The terms of a two-term divisor."""
    return [(key[0], 1), (key[1], key[2] if key[3] == 1 else Fraction(key[2], key[3]))]


def term_gain(monomial: int, actual: Number, needed: Number) -> int:
    """Cost of a term, less that of its remainder when a divisor takes `needed` of its coefficient."""
    literals = monomial.bit_count()
    if actual == needed:
        return product_cost(literals, actual) + 1
    return product_cost(literals, actual) - product_cost(literals, actual - needed)


def row_cost(row: Row) -> int:
    """A row's new term, cofactor times divisor, with its addition."""
    return product_cost(row[1].bit_count() + 1, row[2]) + 1


def divisor_cost(columns: list[Column]) -> int:
    """Computing a divisor once."""
    return sum(product_cost(monomial.bit_count(), value) for monomial, value in columns) + len(columns) - 1
