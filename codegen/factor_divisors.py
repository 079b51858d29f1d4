"""Greedy extraction of common divisors: the kernels and co-kernels of algebraic factoring, with signs and scales.

Works on a `System` in place; every state on the way is exact, so it may stop when its work is spent.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm
from typing import TypeAlias

from .factor_packed import Number, System, Terms, exact, product_cost, ratio

Column: TypeAlias = tuple[int, Number]
"""One term of a divisor: packed monomial, coefficient."""

Row: TypeAlias = tuple[int, int, Number]
"""One place of a divisor: polynomial, packed cofactor, coefficient."""

PairKey: TypeAlias = tuple[int, int, Number]
"""A two-term divisor q1 + r q2, as (q1, q2, r)."""

_GRAIN = 64
"""Scores are scaled by this before noise of up to half of it is added, so that scores stay integers."""


class Stream:
    """A small stream of pseudo-random integers, the same on every machine and Python (Lehmer's generator)."""

    def __init__(self, seed: int) -> None:
        self._state = seed * 2 + 1

    def below(self, bound: int) -> int:
        """A number in 0 .. bound - 1."""
        self._state = self._state * 48271 % 2147483647
        return (self._state >> 8) % bound


@dataclass(frozen=True, slots=True)
class _Rectangle:
    """A divisor (columns) and its places (rows): rows x columns terms become rows + columns."""

    saving: int
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]


class Extractor:
    """Finds two-term divisors, grows the best ones to rectangles, and extracts the one that saves most.

    A divisor may take a part of a coefficient (1 of 2, of the same sign): products of dual quantities need it,
    u x (t x d) + t x (u x d) has terms that belong to both. No term is ever added and taken away again, so the
    result has no cancellation that the expanded polynomials lack.

    Parameters
    ----------
    system : System
        Changed in place.
    width : int
        How many candidates are grown before one is extracted.
    stream : Stream, optional
        Noise on the candidates' order; without it the order is by saving alone.
    """

    def __init__(self, system: System, width: int, stream: Stream | None = None) -> None:
        self.work = 0
        self._system = system
        self._packing = system.packing
        self._polynomials = system.polynomials
        self._width = width
        self._stream = stream
        self._places: dict[PairKey, dict[tuple[int, int], Number]] = {}
        self._dirty: dict[PairKey, None] = {}
        self._heap: list[tuple[int, PairKey, int]] = []
        self._serial: dict[PairKey, int] = {}
        self._ticks = 0
        self._step = 0
        self._changed_at: dict[int, int] = {}
        self._grown: dict[PairKey, tuple[int, _Rectangle]] = {}
        for index, terms in self._polynomials.items():
            monomials = list(terms)
            for position, monomial in enumerate(monomials):
                for other in monomials[:position]:
                    self._add_pair(index, monomial, other)
        self._rescore()

    def run(self, work_limit: int) -> None:
        """Extract until nothing saves anything, or the work is done."""
        while self.work < work_limit and self._extract_best():
            pass

    # -- pairs of terms ------------------------------------------------------------------------------------

    def _pair_keys(self, index: int, left: int, right: int) -> list[tuple[PairKey, int, Number]]:
        """The two-term divisors of a pair: (key, cofactor, coefficient), whole and with part of a coefficient."""
        self.work += 1
        terms = self._polynomials[index]
        common = left & right
        first, second = self._packing.divide(left, common), self._packing.divide(right, common)
        a, b = terms[left], terms[right]
        if first > second:
            first, second, a, b = second, first, b, a
        if a == b:
            return [((first, second, 1), common, a)]
        if a == -b:
            return [((first, second, -1), common, a)]
        smaller = min(abs(a), abs(b))
        return [
            ((first, second, ratio(b, a)), common, a),
            ((first, second, 1 if (a > 0) == (b > 0) else -1), common, smaller if a > 0 else -smaller),
        ]

    def _add_pair(self, index: int, left: int, right: int) -> None:
        for key, common, value in self._pair_keys(index, left, right):
            self._places.setdefault(key, {})[(index, common)] = value
            self._dirty[key] = None

    def _drop_pair(self, index: int, left: int, right: int) -> None:
        for key, common, _ in self._pair_keys(index, left, right):
            places = self._places[key]
            del places[(index, common)]
            if not places:
                del self._places[key]
            self._dirty[key] = None

    def _rows(self, key: PairKey) -> list[Row]:
        """The places of a two-term divisor, without those that share a term with an earlier one."""
        multiply = self._packing.multiply
        used: set[tuple[int, int]] = set()
        rows = []
        for (index, common), value in self._places[key].items():
            left, right = (index, multiply(common, key[0])), (index, multiply(common, key[1]))
            if left not in used and right not in used:
                used.add(left)
                used.add(right)
                rows.append((index, common, value))
        return rows

    def _rescore(self) -> None:
        """Queue the changed two-term divisors by what they save."""
        for key in self._dirty:
            self._serial.pop(key, None)
            self._grown.pop(key, None)
            places = self._places.get(key)
            if places is None:
                continue
            if len(places) == 1:
                ((_, common), value), = places.items()
                if common == 0 and value in (1, -1):
                    continue  # the commonest case: nothing to save
            columns: list[Column] = [(key[0], 1), (key[1], key[2])]
            saving = sum(self._row_saving(row, columns) for row in self._rows(key)) - _divisor_cost(columns)
            if saving > 0:
                self._queue(key, saving)
        self._dirty = {}

    def _queue(self, key: PairKey, saving: int) -> None:
        score = saving * _GRAIN
        if self._stream is not None:
            score += saving * self._stream.below(_GRAIN // 2)
        self._ticks += 1
        self._serial[key] = self._ticks
        heapq.heappush(self._heap, (-score, key, self._ticks))

    # -- savings -------------------------------------------------------------------------------------------

    def _term_saving(self, row: Row, column: Column) -> int:
        """What the row's term in this column cost, less what remains of it."""
        index, cofactor, value = row
        monomial = self._packing.multiply(cofactor, column[0])
        actual = self._polynomials[index][monomial]
        rest = actual - value * column[1]
        literals = monomial.bit_count()
        if rest == 0:
            return product_cost(literals, actual) + 1
        return product_cost(literals, actual) - product_cost(literals, rest)

    def _row_saving(self, row: Row, columns: list[Column]) -> int:
        """What a row saves: its terms, less the new term with the divisor as one more literal."""
        return sum(self._term_saving(row, column) for column in columns) - _row_cost(row)

    # -- rectangles ----------------------------------------------------------------------------------------

    def _grow(self, key: PairKey) -> _Rectangle:
        """The best rectangle found by adding columns to a two-term divisor and dropping rows that lack them."""
        cached = self._grown.get(key)
        if cached is not None and all(self._changed_at.get(index, 0) <= cached[0] for index, _ in self._places[key]):
            return cached[1]
        rows = self._rows(key)
        columns: list[Column] = [(key[0], 1), (key[1], key[2])]
        savings = [self._row_saving(row, columns) for row in rows]
        total = sum(savings) - _divisor_cost(columns)
        while True:
            best: tuple[int, Column, list[int], list[int]] | None = None
            base = _divisor_cost(columns) + 1
            for column, members in self._further_columns(rows, columns):
                gains = [savings[member] + self._term_saving(rows[member], column) for member in members]
                saving = sum(gains) - base - product_cost(column[0].bit_count(), column[1])
                if saving > (total if best is None else best[0]):
                    best = (saving, column, members, gains)
            if best is None:
                break
            total, column, members, savings = best
            rows = [rows[member] for member in members]
            columns.append(column)
        found = _Rectangle(total, tuple(columns), tuple(rows))
        self._grown[key] = (self._step, found)
        return found

    def _further_columns(self, rows: list[Row], columns: list[Column]) -> list[tuple[Column, list[int]]]:
        """Terms that could join the divisor, each with the rows that have it (whole or in part)."""
        packing = self._packing
        used = {(row[0], packing.multiply(row[1], column[0])) for row in rows for column in columns}
        taken = {column[0] for column in columns}
        seen: dict[int, list[tuple[int, Number]]] = {}
        for member, (index, cofactor, value) in enumerate(rows):
            terms = self._polynomials[index]
            self.work += len(terms)
            for monomial, actual in terms.items():
                if monomial & cofactor == cofactor and (index, monomial) not in used:
                    quotient = packing.divide(monomial, cofactor)
                    if quotient not in taken:
                        seen.setdefault(quotient, []).append((member, ratio(actual, value)))
        found = []
        for quotient, having in seen.items():
            for scale in dict.fromkeys(value for _, value in having):
                members = []
                touched: set[tuple[int, int]] = set()
                for member, value in having:
                    if value == scale or value > scale > 0 or value < scale < 0:
                        place = (rows[member][0], packing.multiply(rows[member][1], quotient))
                        if place not in touched:
                            touched.add(place)
                            members.append(member)
                found.append(((quotient, scale), members))
        return found

    # -- extraction ----------------------------------------------------------------------------------------

    def _extract_best(self) -> bool:
        """Grow the best candidates and extract the best rectangle; False if there is none."""
        candidates = []
        while self._heap and len(candidates) < self._width:
            entry = heapq.heappop(self._heap)
            if self._serial.get(entry[1]) == entry[2]:
                candidates.append(entry)
        if not candidates:
            return False
        best: _Rectangle | None = None
        for entry in candidates:
            grown = self._grow(entry[1])
            if best is None or grown.saving > best.saving:
                best = grown
            heapq.heappush(self._heap, entry)
        assert best is not None
        self._step += 1
        self._extract(best)
        self._rescore()
        return True

    def _extract(self, rectangle: _Rectangle) -> None:
        """Define the divisor (primitive, leading coefficient positive) and put it in its places."""
        columns = sorted(rectangle.columns)
        scale = _content([value for _, value in columns])
        if columns[0][1] < 0:
            scale = -scale
        packing = self._packing
        variable = self._system.define({})
        bit = packing.bit(variable)
        rows_of: dict[int, list[Row]] = {}
        for row in rectangle.rows:
            rows_of.setdefault(row[0], []).append(row)
        for index, rows in rows_of.items():
            terms = self._polynomials[index]
            rests: Terms = {}
            added: Terms = {}
            for _, cofactor, value in rows:
                for quotient, factor in columns:
                    monomial = packing.multiply(cofactor, quotient)
                    rests[monomial] = exact(terms[monomial] - value * factor)
                added[packing.multiply(cofactor, bit)] = exact(value * scale)
            added.update((monomial, rest) for monomial, rest in rests.items() if rest)
            self._replace(index, list(rests), added)
        self._replace(variable, [], {quotient: ratio(value, scale) for quotient, value in columns})

    def _replace(self, index: int, removed: list[int], added: Terms) -> None:
        terms = self._polynomials[index]
        self._changed_at[index] = self._step
        for monomial in removed:
            for other in terms:
                if other != monomial:
                    self._drop_pair(index, monomial, other)
            del terms[monomial]
        for monomial, value in added.items():
            others = list(terms)
            terms[monomial] = value
            for other in others:
                self._add_pair(index, monomial, other)


def _row_cost(row: Row) -> int:
    """A row's new term, cofactor times divisor, with its addition."""
    return product_cost(row[1].bit_count() + 1, row[2]) + 1


def _divisor_cost(columns: list[Column]) -> int:
    """Computing the divisor once."""
    return sum(product_cost(monomial.bit_count(), value) for monomial, value in columns) + len(columns) - 1


def _content(values: list[Number]) -> Number:
    """The positive rational whose multiples all values are, coprime."""
    fractions = [Fraction(value) for value in values]
    return exact(Fraction(gcd(*(f.numerator for f in fractions)), lcm(*(f.denominator for f in fractions))))
