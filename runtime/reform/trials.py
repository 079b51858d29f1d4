"""Sets of query objects tried: all the sets of reference objects that may be their images, by what no motion changes,
the motor of each such sample, and how many objects it lays on others.

Nothing here is random but what a lot's number decides: a lot gives the same on any machine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.reform import KINDS
from .tables import Candidates, Tables, sign_choices

Array = NDArray[Any]
#: Kinds, query rows, reference rows and signs, (n, size) each.
Samples = tuple[Array, Array, Array, Array]
#: Bits of a row or of a set's number where several are made one integer; so many of them at most.
CODE_BITS, CODED = 21, 3
#: Candidates of one set of query objects: of a set with more, some are left out.
MOST_OF_SET = 8192


@dataclass(frozen=True)
class Lot:
    """Sets of the same kinds that are tried together.

    Attributes
    ----------
    number : int
        Where its sets begin among those that are tried at a tolerance.
    kinds : tuple of str
    rows : array (n, size)
        Of query objects.
    """

    number: int
    kinds: tuple[str, ...]
    rows: Array


@dataclass(frozen=True)
class Tried:
    """What some lots gave.

    Attributes
    ----------
    motors, scores, hits : arrays (m, 8), (m,), (m,)
        Of the samples that were not given up, in their order.
    count : int
        Samples in all.
    met, looked : int
        Objects that the others laid on others, and that they were tried on.
    """

    motors: Array
    scores: Array
    hits: Array
    count: int
    met: int
    looked: int

    @staticmethod
    def joined(parts: Sequence[Tried]) -> Tried:
        """Of several, in their order."""
        arrays = ((p.motors, p.scores, p.hits) for p in parts)
        motors, scores, hits = (np.concatenate(x) for x in zip(*arrays, strict=True))
        count, met, looked = (sum(x) for x in zip(*((p.count, p.met, p.looked) for p in parts), strict=True))
        return Tried(motors, scores, hits, count, met, looked)


@dataclass(frozen=True)
class Chosen:
    """What a search has chosen by chance, and how it is to vote.

    Attributes
    ----------
    kept : mapping of kind to array (n,)
        Rows of the reference objects that are in tables.
    align : bool
        x and -x are one.
    """

    kept: Mapping[str, Array]
    align: bool


class Trials:
    """What tries sets.

    Parameters
    ----------
    scene, driver
        What computes (see `engine`).
    query, reference : mapping of kind to array (n, k)
        Coefficients of unit objects.
    chosen : Chosen

    Attributes
    ----------
    tables : Tables
        Pairs of reference objects.
    """

    def __init__(
        self, scene: Any, driver: Any, query: Mapping[str, Array], reference: Mapping[str, Array], chosen: Chosen
    ) -> None:
        self._scene, self._driver, self._query, self._chosen = scene, driver, query, chosen
        self.tables = Tables(driver, reference, chosen.kept)

    def tried(self, lots: Sequence[Lot], tolerance: float, residual: float) -> Tried:
        """The samples of some lots at a tolerance; their forms may be ``residual`` for each pair.

        Which samples are given up early depends on the scene's closeness.
        """
        parts = [self.samples(lot, tolerance) for lot in lots]
        kinds, query, rows, signs = _joined_samples(parts)
        motors, scores, hits, tested = self._scene.samples(kinds, query, rows, signs, residual)
        wrong, good = scores < 0, scores > 0
        met, looked = int(hits[wrong].sum()), int(tested[wrong].sum())
        return Tried(motors[good], scores[good], hits[good], len(scores), met, looked)

    def invariants(self, kinds: tuple[str, ...], rows: Array) -> Array:
        """Of pairs (n, 2) of query objects."""
        a, b = kinds
        found: Array = self._driver.invariants((a, b), (self._query[a], self._query[b]), (rows[:, 0], rows[:, 1]))
        return found

    def samples(self, lot: Lot, tolerance: float) -> Samples:
        """All samples that sets make."""
        source, images, turned = self._images(lot, tolerance)
        choices = sign_choices(lot.kinds) if self._chosen.align else np.ones((1, len(lot.kinds)))
        image, choice = np.arange(len(images)).repeat(len(choices)), np.tile(np.arange(len(choices)), len(images))
        signs = choices[choice]
        possible = turned[image] * signs[:, 0] * signs[:, 1] >= 0
        image, signs = image[possible], signs[possible]
        kinds = np.full((len(image), len(lot.kinds)), [KINDS.index(k) for k in lot.kinds])
        return kinds, lot.rows[source[image]], images[image], signs

    def _images(self, lot: Lot, tolerance: float) -> tuple[Array, Array, Array]:
        """Which set, rows (c, k) of reference objects that may be its image, how the second goes with the first."""
        found = {}
        for a, b in combinations(range(len(lot.kinds)), 2):
            pair = (lot.kinds[a], lot.kinds[b])
            found[a, b] = self.tables[pair].find(self.invariants(pair, lot.rows[:, [a, b]]), tolerance)
        first = self._thinned(found[0, 1], lot.number)
        source, images, turned = first.source, np.stack([first.first, first.second], 1), first.turned
        for later in range(2, len(lot.kinds)):
            images, kept = _joined(source, images, [found[a, later] for a in range(later)])
            source, turned = source[kept], turned[kept]
        return source, images, turned

    def _thinned(self, found: Candidates, number: int) -> Candidates:
        """At most `MOST_OF_SET` or so of each set."""
        count = np.bincount(found.source)
        if not (count > MOST_OF_SET).any():
            return found
        random = np.random.default_rng(number)
        keep = random.random(len(found)) * count[found.source] < MOST_OF_SET
        return Candidates(*(x[keep] for x in (found.source, found.first, found.second, found.turned)))


def _joined_samples(parts: Sequence[Samples]) -> Samples:
    if len(parts) == 1:
        return parts[0]
    kinds, query, rows, signs = (np.concatenate(p) for p in zip(*parts, strict=True))
    return kinds, query, rows, signs


def _joined(source: Array, images: Array, pairs: list[Candidates]) -> tuple[Array, Array]:
    """Images (c, k) with one object more: it makes a possible pair with each of them. And which they came from."""
    keys = code(pairs[0].source, pairs[0].first)
    order = np.argsort(keys, kind="stable")
    asked = code(source, images[:, 0])
    low, high = (np.searchsorted(keys[order], asked, side=side) for side in ("left", "right"))
    count = high - low
    kept = np.repeat(np.arange(len(images)), count)
    place = order[np.arange(len(kept)) + np.repeat(low - np.cumsum(count) + count, count)]
    added = pairs[0].second[place]
    good = np.ones(len(kept), bool)
    for k, other in enumerate(pairs[1:], 1):
        known = np.unique(code(other.source, other.first, other.second))
        good &= np.isin(code(source[kept], images[kept, k], added), known)
    kept, added = kept[good], added[good]
    return np.column_stack([images[kept], added]), kept


def code(*numbers: Array) -> Array:
    """One integer for each tuple of small ones."""
    total = np.zeros(len(numbers[0]), np.int64)
    for x in numbers:
        total = (total << CODE_BITS) | x
    return total
