"""Tables of pairs of reference objects by their invariants: the possible images of each pair of query objects.

Pairs of two kinds are in one table, sorted by the invariant that varies most.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.registration.registration import DIRECTED, matched_as
from ..backends.driver import Driver

Array = NDArray[Any]
#: Largest number of pairs of a reference, over all kinds; of larger models some objects are left out of the tables.
MAX_PAIRS = 500_000
#: Index pairs of up to this many objects are cached.
MAX_CACHED = 64
#: Keys from which on they are put into classes before they are sorted, and the number of the last class.
MANY_KEYS, MAX_CLASS = 1024, (1 << 16) - 1
#: Of keys that are nearer to each other the classes cannot be told.
TINY_SPAN = 1e-290
#: Index of the cosine of the angle between two directions among the invariants; it has a sign.
COSINE = 1
#: Kinds whose invariants have a twist (formula `registration.line_twist`), which has a sign.
TWISTED = frozenset((("line", "line"), ("point_pair", "line"), ("line", "circle")))


@dataclass(frozen=True)
class Candidates:
    """Pairs of reference objects that may be the images of pairs of query objects.

    Attributes
    ----------
    source : array (n,)
        Index of the query pair.
    first, second : arrays (n,)
        Rows of the reference objects.
    orientation : array (n,)
        Relative orientation of the two objects, +1 or -1; 0 where both are possible.
    """

    source: Array
    first: Array
    second: Array
    orientation: Array

    def __len__(self) -> int:
        return len(self.source)


@dataclass(frozen=True)
class Table:
    """Pairs of reference objects of two kinds, sorted by the size of an invariant.

    Attributes
    ----------
    first, second : arrays of int64
        Rows of the objects of both kinds.
    begins : array
        Number of the first pair of each object of the first kind, before they were sorted.
    order : array (n,)
        These numbers in the order of the table.
    numbers : array (4, n)
        Invariants.
    column, keys : int, array (n,)
        The invariant that they are sorted by, and its sizes.
    """

    kinds: tuple[str, str]
    first: Array
    second: Array
    begins: Array
    order: Array
    numbers: Array
    column: int
    keys: Array

    def counts(self, invariants: Array, tolerance: float) -> Array:
        """Upper bounds of the numbers of candidates of each pair."""
        low, high = self._key_range(invariants, tolerance)
        return np.asarray(high - low)

    def find(self, invariants: Array, tolerance: float) -> Candidates:
        """All pairs whose invariants agree with given ones (n, 4) within a tolerance; of one kind in both orders."""
        if self.kinds[0] != self.kinds[1]:
            return self._find(invariants, tolerance)
        candidates = self._find(np.concatenate([invariants, invariants[:, [0, 1, 3, 2]]]), tolerance)
        swapped = candidates.source >= len(invariants)
        first, second = (
            np.where(swapped, candidates.second, candidates.first),
            np.where(swapped, candidates.first, candidates.second),
        )
        return Candidates(candidates.source - len(invariants) * swapped, first, second, candidates.orientation)

    def _find(self, invariants: Array, tolerance: float) -> Candidates:
        low, high = self._key_range(invariants, tolerance)
        source, position = expand_ranges(low, high)
        unsure = np.abs(invariants[:, COSINE]) <= tolerance  # at right angles the sign of a cosine, and with it that of
        for i in self._compared_columns(invariants):  # a twist, is not known
            a, b = self.numbers[i][position], invariants[source, i]
            near = np.abs(a - b) <= tolerance
            if i == COSINE:
                near |= np.abs(a + b) <= tolerance
            elif self._has_sign:
                near |= (np.abs(a + b) <= tolerance) & unsure[source]
            source, position = source[near], position[near]
        orientation = np.sign(self.numbers[COSINE][position]) * np.sign(invariants[source, COSINE])
        orientation[unsure[source]] = 0
        return Candidates(source, *self._rows(self.order[position]), orientation)

    def _rows(self, pairs: Array) -> tuple[Array, Array]:
        """Rows of both objects of some pairs."""
        first = self.begins.searchsorted(pairs, side="right") - 1
        second = pairs - self.begins[first]
        return self.first[first], self.second[second + first + 1 if self.kinds[0] == self.kinds[1] else second]

    def _compared_columns(self, invariants: Array) -> list[int]:
        """Columns of the invariants that are not all zero, the sorted one last: it excludes fewest pairs."""
        columns = np.flatnonzero(self._present | invariants.any(0)).tolist()
        return [*(i for i in columns if i != self.column), self.column]

    @cached_property
    def _present(self) -> Array:
        """Mask of the invariants that are not zero for all pairs."""
        return np.array([own.any() for own in self.numbers])

    @property
    def _has_sign(self) -> bool:
        """True if an invariant has the sign of the cosine times that of a twist: between lines, or lines and axes."""
        return (matched_as(self.kinds[0]), matched_as(self.kinds[1])) in TWISTED

    def _key_range(self, invariants: Array, tolerance: float) -> tuple[Array, Array]:
        keys_ = _sort_keys(invariants, self.column)
        return self.keys.searchsorted(keys_ - tolerance), self.keys.searchsorted(keys_ + tolerance, side="right")


def _sort_keys(invariants: Array, column: int) -> Array:
    """Sort keys of tables: absolute values, which are the same for every orientation."""
    return np.abs(invariants[:, column])


class Tables:
    """All tables of a reference.

    Parameters
    ----------
    driver : Driver
    rows : mapping of kind to array (n, k)
        Reference objects.
    rows_in_tables : mapping of kind to array (n,)
        Rows of the objects in tables (see `table_rows`).
    """

    def __init__(self, driver: Driver, rows: Mapping[str, Array], rows_in_tables: Mapping[str, Array]) -> None:
        self._tables = {
            pair: _table(driver, pair, rows, rows_in_tables) for pair in combinations_with_replacement(rows, 2)
        }

    def __getitem__(self, kinds: tuple[str, str]) -> Table:
        return self._tables[kinds]


def table_rows(rows: Mapping[str, Array], random: np.random.Generator) -> tuple[dict[str, Array], float]:
    """Rows of the reference objects that are in tables, by kind, and their fraction of all objects."""
    total = sum(map(len, rows.values()))
    fraction = min(1.0, (2 * MAX_PAIRS) ** 0.5 / max(total, 1))
    return {k: _random_rows(len(x), fraction, random) for k, x in rows.items()}, fraction


def _random_rows(n: int, fraction: float, random: np.random.Generator) -> Array:
    count = n if fraction == 1 else max(min(n, 2), int(n * fraction))
    return np.sort(random.choice(n, count, replace=False)) if count < n else np.arange(n)


def _table(
    driver: Driver, kinds: tuple[str, str], rows: Mapping[str, Array], rows_in_tables: Mapping[str, Array]
) -> Table:
    a, b = (rows_in_tables[k] for k in kinds)
    numbers, begins = driver.invariants_of_all(kinds, (rows[kinds[0]], rows[kinds[1]]), (a, b))
    room = np.empty(numbers.shape[1])  # for all that is as large: fresh memory costs more than what is computed
    column = _most_different(numbers, room) if len(room) else 0
    order = stable_order(np.abs(numbers[column], out=room))
    for own in numbers:
        own[:] = own.take(order, out=room, mode="clip")
    return Table(kinds, a, b, begins, order, numbers, column, np.abs(numbers[column], out=room))


def _most_different(numbers: Array, room: Array) -> int:
    """Row of the largest variance of absolute values."""
    variances = []
    for own in numbers:
        np.abs(own, out=room)
        room -= room.sum() / len(room)
        variances.append(np.multiply(room, room, out=room).sum())
    return int(np.argmax(variances))


def stable_order(keys: Array) -> Array:
    """The stable order of keys (n,), as `numpy.argsort` gives it.

    Many keys are first put into classes of nearly equal ones, by NumPy's radix sort of 16-bit integers: what is left is
    nearly in order, which its sort of numbers is fast on.
    """
    low, high = (float(keys.min()), float(keys.max())) if len(keys) >= MANY_KEYS else (0.0, 0.0)
    if not TINY_SPAN < high - low < math.inf:  # of few keys, of one, of such that are not finite
        return np.argsort(keys, kind="stable")
    by_class = ((keys - low) * (MAX_CLASS / (high - low))).astype(np.uint16).argsort(kind="stable")
    return by_class.take(keys.take(by_class).argsort(kind="stable"))


def pair_indices(kinds: tuple[str, str], n: int, m: int) -> tuple[Array, Array]:
    """Indices of all pairs of n objects of one kind and m of another; of one kind those with i < j."""
    if kinds[0] == kinds[1]:
        return _few_pairs(n) if n <= MAX_CACHED else _pairs_in_order(n)
    i, j = np.indices((n, m))
    return i.ravel(), j.ravel()


def _pairs_in_order(n: int) -> tuple[Array, Array]:
    low = np.arange(1, n + 1)
    return expand_ranges(low, np.full(n, n))


def expand_ranges(low: Array, high: Array) -> tuple[Array, Array]:
    """Numbers of all ranges (n,), one after the other: the index of each one's range, and the number."""
    count = high - low
    source = np.repeat(np.arange(len(count)), count)
    return source, np.arange(len(source)) + np.repeat(low - np.cumsum(count) + count, count)


@cache
def _few_pairs(n: int) -> tuple[Array, Array]:
    return _pairs_in_order(n)


@cache
def sign_choices(kinds: tuple[str, ...]) -> Array:
    """All combinations (c, k) of orientations of objects of these kinds; points and spheres have one orientation."""
    choices = np.array([[1.0] * len(kinds)])
    for place, kind in enumerate(kinds):
        if kind in DIRECTED:
            other = choices.copy()
            other[:, place] = -1
            choices = np.concatenate([choices, other])
    return choices
