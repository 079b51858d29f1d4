"""Pairs of objects by what no motion changes: of each pair of a query those pairs of a reference that may be its image.

Pairs of two kinds are in one table, sorted by the number that differs most among them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.reform import DIRECTED
from .engine import Driver

Array = NDArray[Any]
#: Pairs of a reference that are kept, over all kinds; of larger models some objects are left out of the tables.
MOST_PAIRS = 500_000
#: Up to so many objects the pairs of their numbers are remembered.
REMEMBERED = 64
#: The cosine of the angle between two directions is the second invariant; it has a sign.
COSINE = 1
#: Kinds whose invariants have a twist (formula `registration.line_twist`), which has a sign.
TWISTED = frozenset((("line", "line"), ("point_pair", "line"), ("line", "circle")))


@dataclass(frozen=True)
class Candidates:
    """Pairs of reference objects that may be the images of pairs of query objects.

    Attributes
    ----------
    source : array (n,)
        Number of the query pair.
    first, second : arrays (n,)
        Rows of the reference objects.
    turned : array (n,)
        +1 or -1: how the first's orientation goes with the second's; 0 where either may be.
    """

    source: Array
    first: Array
    second: Array
    turned: Array

    def __len__(self) -> int:
        return len(self.source)


@dataclass(frozen=True)
class Table:
    """Pairs of reference objects of two kinds, sorted by the invariant ``column``; ``keys`` are its sizes, and
    ``numbers`` (4, n) all invariants."""

    kinds: tuple[str, str]
    first: Array
    second: Array
    numbers: Array
    column: int
    keys: Array

    def counts(self, invariants: Array, tolerance: float) -> Array:
        """At most so many pairs are found for each."""
        low, high = self._span(invariants, tolerance)
        return np.asarray(high - low)

    def find(self, invariants: Array, tolerance: float) -> Candidates:
        """All pairs whose invariants are within the tolerance of given ones, (n, 4); of one kind in both orders."""
        if self.kinds[0] != self.kinds[1]:
            return self._find(invariants, tolerance)
        found = self._find(np.concatenate([invariants, invariants[:, [0, 1, 3, 2]]]), tolerance)
        turned = found.source >= len(invariants)
        first, second = np.where(turned, found.second, found.first), np.where(turned, found.first, found.second)
        return Candidates(found.source - len(invariants) * turned, first, second, found.turned)

    def _find(self, invariants: Array, tolerance: float) -> Candidates:
        low, high = self._span(invariants, tolerance)
        count = high - low
        source = np.repeat(np.arange(len(invariants)), count)
        place = np.arange(len(source)) + np.repeat(low - np.cumsum(count) + count, count)
        unsure = np.abs(invariants[:, COSINE]) <= tolerance  # at right angles the sign of a cosine, and with it that of
        for i in self._compared(invariants):  # a twist, is not known
            a, b = self.numbers[i][place], invariants[source, i]
            near = np.abs(a - b) <= tolerance
            if i == COSINE:
                near |= np.abs(a + b) <= tolerance
            elif self._signed:
                near |= (np.abs(a + b) <= tolerance) & unsure[source]
            source, place = source[near], place[near]
        turned = np.sign(self.numbers[COSINE][place]) * np.sign(invariants[source, COSINE])
        turned[unsure[source]] = 0
        return Candidates(source, self.first[place], self.second[place], turned)

    def _compared(self, invariants: Array) -> list[int]:
        """Numbers that pairs of these kinds have, that which they are sorted by last: it tells no more apart."""
        found = np.flatnonzero(self._present | invariants.any(0)).tolist()
        return [*(i for i in found if i != self.column), self.column]

    @cached_property
    def _present(self) -> Array:
        """Which of its numbers are not zero for all pairs."""
        return np.array([own.any() for own in self.numbers])

    @property
    def _signed(self) -> bool:
        """Whether there is a number with a sign, that of the cosine times that of a twist: between lines, or axes of
        rounds and lines."""
        return self.kinds in TWISTED

    def _span(self, invariants: Array, tolerance: float) -> tuple[Array, Array]:
        asked = _keys(invariants, self.column)
        return self.keys.searchsorted(asked - tolerance), self.keys.searchsorted(asked + tolerance, side="right")


def _keys(invariants: Array, column: int) -> Array:
    """What tables are sorted by: sizes, which hold for every sign."""
    return np.abs(invariants[:, column])


class Tables:
    """All tables of a reference.

    Parameters
    ----------
    driver : Driver
    rows : mapping of kind to array (n, k)
        Reference objects.
    kept : mapping of kind to array (n,)
        Rows of those that take part (see `kept_rows`).
    """

    def __init__(self, driver: Driver, rows: Mapping[str, Array], kept: Mapping[str, Array]) -> None:
        self._tables = {pair: _table(driver, pair, rows, kept) for pair in combinations_with_replacement(rows, 2)}

    def __getitem__(self, kinds: tuple[str, str]) -> Table:
        return self._tables[kinds]


def kept_rows(rows: Mapping[str, Array], random: np.random.Generator) -> tuple[dict[str, Array], float]:
    """Rows of the objects of a reference that are in its tables, by kind; and which share of them that is."""
    total = sum(map(len, rows.values()))
    share = min(1.0, (2 * MOST_PAIRS) ** 0.5 / max(total, 1))
    return {k: _some(len(x), share, random) for k, x in rows.items()}, share


def _some(n: int, share: float, random: np.random.Generator) -> Array:
    count = n if share == 1 else max(min(n, 2), int(n * share))
    return np.sort(random.choice(n, count, replace=False)) if count < n else np.arange(n)


def _table(driver: Driver, kinds: tuple[str, str], rows: Mapping[str, Array], kept: Mapping[str, Array]) -> Table:
    a, b = (kept[k] for k in kinds)
    if kinds[0] == kinds[1]:
        i, j = _pairs(len(a))
    else:
        i, j = (x.ravel() for x in np.indices((len(a), len(b))))
    first, second = a[i].astype(np.int32), b[j].astype(np.int32)
    invariants = driver.invariants(kinds, (rows[kinds[0]], rows[kinds[1]]), (first, second))
    column = _most_different(invariants) if len(first) else 0
    keys = _keys(invariants, column)
    order = keys.argsort(kind="stable")
    numbers = invariants.take(order, 0).T
    return Table(kinds, first[order], second[order], numbers, column, keys[order])


def _most_different(invariants: Array) -> int:
    """The column whose sizes spread most."""
    sizes = np.abs(invariants)
    sizes -= sizes.sum(0) / len(sizes)
    return int((sizes * sizes).sum(0).argmax())


def _pairs(n: int) -> tuple[Array, Array]:
    """All pairs i < j of n."""
    return _few_pairs(n) if n <= REMEMBERED else np.triu_indices(n, 1)


@cache
def _few_pairs(n: int) -> tuple[Array, Array]:
    return np.triu_indices(n, 1)


@cache
def sign_choices(kinds: tuple[str, ...]) -> Array:
    """All ways (c, k) to turn objects of these kinds round; points and spheres have one."""
    choices = np.array([[1.0] * len(kinds)])
    for place, kind in enumerate(kinds):
        if kind in DIRECTED:
            other = choices.copy()
            other[:, place] = -1
            choices = np.concatenate([choices, other])
    return choices
