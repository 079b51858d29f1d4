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

PairKey: TypeAlias = tuple[int, int, int, int]
"""A two-term divisor q1 + n/d q2, as (q1, q2, n, d): integers, because hashing a Fraction is slow."""

_Place: TypeAlias = tuple[Number, int, int]
"""Where a two-term divisor stands: coefficient and the two packed monomials."""

_GRAIN = 64
"""Scores are scaled by this before noise of up to half of it is added, so that scores stay integers."""


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
    parts : bool
        Whether divisors may take a part of a coefficient.
    """

    def __init__(self, system: System, width: int, stream: Stream | None = None, parts: bool = True) -> None:
        self.work = 0
        self._system = system
        self._packing = system.packing
        self._polynomials = system.polynomials
        self._width = width
        self._stream = stream
        self._parts = parts
        self._places: dict[PairKey, dict[tuple[int, int], _Place]] = {}
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

    def _rescore(self) -> None:
        """Queue the changed two-term divisors by what they save."""
        for key in self._dirty:
            self._serial.pop(key, None)
            self._grown.pop(key, None)
            if key in self._places:
                saving = self._pair_saving(key)
                if saving > 0:
                    self._queue(key, saving)
        self._dirty = {}

    def _pair_saving(self, key: PairKey) -> int:
        """What extracting a two-term divisor saves."""
        places = self._places[key]
        if len(places) == 1:
            ((_, common), (value, _, _)), = places.items()
            if common == 0 and value in (1, -1):
                return 0  # the commonest case
        columns = _pair_columns(key)
        factor = columns[1][1]
        saving = -_divisor_cost(columns)
        for row in self._rows(key):
            index, common, value = row
            terms = self._polynomials[index]
            _, left, right = places[(index, common)]
            saving += _gain(left, terms[left], value) + _gain(right, terms[right], value * factor) - _row_cost(row)
        return saving

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
        return _gain(monomial, self._polynomials[index][monomial], value * column[1])

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
        columns = _pair_columns(key)
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
                    if value == scale or (self._parts and (value > scale > 0 or value < scale < 0)):
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


