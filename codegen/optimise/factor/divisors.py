"""Greedy extraction of common divisors: kernels and co-kernels of algebraic factoring, with signs and scales.

Works on a `System` in place; every state on the way is exact, so it may stop when its work is spent.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm

from .packed import Number, System, Terms, exact, product_cost, ratio
from .pairs import Column, PairIndex, PairKey, Row, divisor_cost, pair_columns, row_cost, term_gain

_GRAIN = 64
"""Scores are multiplied by this before noise of up to half of it is added, so that they stay integers."""


@dataclass(frozen=True, slots=True)
class _Rectangle:
    """A divisor (columns) and its places (rows): rows x columns terms become rows + columns."""

    saving: int
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]


class Extractor:
    """Finds two-term divisors, grows the best ones to rectangles, and extracts the one that saves most.

    A divisor may take a part of a coefficient (1 of 2, of the same sign): products of dual quantities need
    it, u x (t x d) + t x (u x d) has terms that belong to both. No term is ever added and taken away again,
    so the result has no cancellation that the expanded polynomials lack.

    Parameters
    ----------
    system : System
        Changed in place.
    width : int
        How many candidates are grown before one is extracted.
    below : function, optional
        `below(n)` draws from 0 .. n - 1: noise on the candidates' order, which is by saving alone without it.
    parts : bool
        Whether divisors may take a part of a coefficient.
    """

    def __init__(
        self, system: System, width: int, below: Callable[[int], int] | None = None, parts: bool = True
    ) -> None:
        self._system = system
        self._width = width
        self._below = below
        self._pairs = PairIndex(system, parts)
        self._heap: list[tuple[int, PairKey, int]] = []
        self._serial: dict[PairKey, int] = {}  # which entry of the heap is valid
        self._entries = 0
        self._step = 0
        self._changed_at: dict[int, int] = {}
        self._grown: dict[PairKey, tuple[int, _Rectangle]] = {}
        self._rescore()

    @property
    def work(self) -> int:
        """Pairs and terms looked at so far."""
        return self._pairs.work

    def run(self, work_limit: int) -> None:
        """Extract until nothing saves anything, or the work is done."""
        while self.work < work_limit and self._extract_best():
            pass

    def _rescore(self) -> None:
        """Queue the changed two-term divisors by what they save."""
        for key in self._pairs.dirty:
            self._serial.pop(key, None)
            self._grown.pop(key, None)
            saving = self._pairs.saving(key)
            if saving > 0:
                score = saving * _GRAIN
                if self._below is not None:
                    score += saving * self._below(_GRAIN // 2)
                self._entries += 1
                self._serial[key] = self._entries
                heapq.heappush(self._heap, (-score, key, self._entries))
        self._pairs.dirty.clear()

    def _extract_best(self) -> bool:
        """Grow the best candidates and extract the best rectangle; False if there is none."""
        candidates: list[tuple[int, PairKey, int]] = []
        while self._heap and len(candidates) < self._width:
            entry = heapq.heappop(self._heap)
            if self._serial.get(entry[1]) == entry[2]:
                candidates.append(entry)
        if not candidates:
            return False
        best = max((self._grow(key) for _, key, _ in candidates), key=lambda grown: grown.saving)
        for entry in candidates:
            heapq.heappush(self._heap, entry)
        self._step += 1
        self._extract(best)
        self._rescore()
        return True

    # -- rectangles ----------------------------------------------------------------------------------------

    def _term_saving(self, row: Row, column: Column) -> int:
        """Cost of the row's term in this column, less that of its remainder."""
        index, cofactor, value = row
        monomial = self._system.packing.multiply(cofactor, column[0])
        return term_gain(monomial, self._system.polynomials[index][monomial], value * column[1])

    def _grow(self, key: PairKey) -> _Rectangle:
        """The best rectangle found by adding columns to a two-term divisor, dropping rows that lack them."""
        cached = self._grown.get(key)
        if cached is not None:
            since, found = cached
            if all(self._changed_at.get(index, 0) <= since for index in self._pairs.polynomials_with(key)):
                return found
        rows = self._pairs.rows(key)
        columns = pair_columns(key)
        savings = [sum(self._term_saving(row, column) for column in columns) - row_cost(row) for row in rows]
        total = sum(savings) - divisor_cost(columns)
        while True:
            best: tuple[int, Column, list[int], list[int]] | None = None
            base = divisor_cost(columns) + 1
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
        packing = self._system.packing
        used = {(row[0], packing.multiply(row[1], column[0])) for row in rows for column in columns}
        taken = {column[0] for column in columns}
        seen: dict[int, list[tuple[int, Number]]] = {}
        for member, (index, cofactor, value) in enumerate(rows):
            terms = self._system.polynomials[index]
            self._pairs.work += len(terms)
            for monomial, actual in terms.items():
                if monomial & cofactor == cofactor and (index, monomial) not in used:
                    quotient = packing.divide(monomial, cofactor)
                    if quotient not in taken:
                        seen.setdefault(quotient, []).append((member, ratio(actual, value)))
        return [
            ((quotient, scale), self._members(rows, quotient, scale, having))
            for quotient, having in seen.items()
            for scale in dict.fromkeys(value for _, value in having)
        ]

    def _members(self, rows: list[Row], quotient: int, scale: Number, having: list[tuple[int, Number]]) -> list[int]:
        """The rows whose term has the column's coefficient or, where parts may be taken, more of it."""
        members = []
        touched: set[tuple[int, int]] = set()
        for member, value in having:
            if value == scale or (self._pairs.parts and (value > scale > 0 or value < scale < 0)):
                place = (rows[member][0], self._system.packing.multiply(rows[member][1], quotient))
                if place not in touched:
                    touched.add(place)
                    members.append(member)
        return members

    # -- extraction ----------------------------------------------------------------------------------------

    def _extract(self, rectangle: _Rectangle) -> None:
        """Define the divisor (primitive, leading coefficient positive) and put it in its places."""
        columns = sorted(rectangle.columns)
        scale = _content([value for _, value in columns])
        if columns[0][1] < 0:
            scale = -scale
        packing = self._system.packing
        variable = self._system.define({})
        bit = packing.bit(variable)
        rows_of: dict[int, list[Row]] = {}
        for row in rectangle.rows:
            rows_of.setdefault(row[0], []).append(row)
        for index, rows in rows_of.items():
            terms = self._system.polynomials[index]
            rests: Terms = {}
            added: Terms = {}
            for _, cofactor, value in rows:
                for quotient, amount in columns:
                    monomial = packing.multiply(cofactor, quotient)
                    rests[monomial] = exact(terms[monomial] - value * amount)
                added[packing.multiply(cofactor, bit)] = exact(value * scale)
            added.update((monomial, rest) for monomial, rest in rests.items() if rest)
            self._replace(index, list(rests), added)
        self._replace(variable, [], {quotient: ratio(value, scale) for quotient, value in columns})

    def _replace(self, index: int, removed: list[int], added: Terms) -> None:
        self._changed_at[index] = self._step
        self._pairs.replace(index, removed, added)


def _content(values: list[Number]) -> Number:
    """The positive rational of which all values are coprime multiples."""
    fractions = [Fraction(value) for value in values]
    return exact(Fraction(gcd(*(f.numerator for f in fractions)), lcm(*(f.denominator for f in fractions))))
