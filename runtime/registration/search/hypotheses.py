"""Hypotheses of minimal sets of query objects: all sets of reference objects with the same invariants, the motor of
each such sample, and the number of objects that it matches.

Random choices depend on the number of a batch only: it gives the same hypotheses on any machine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.registration.registration import KINDS
from .invariant_tables import Candidates, Tables, expand_ranges, sign_choices

Array = NDArray[Any]
#: Kinds, query rows, reference rows and signs, (n, size) each.
Samples = tuple[Array, Array, Array, Array]
#: Bits of a row or of a set's number in a packed integer.
PACKED_BITS = 21
#: Largest number of them in one integer.
MAX_PACKED = 3
#: Largest number of candidates of one set of query objects; of more, a random subset is used.
MAX_PER_SET = 8192


@dataclass(frozen=True)
class SampleBatch:
    """Minimal sets of the same kinds that are evaluated together.

    Attributes
    ----------
    number : int
        Index of its first set in the order at a tolerance.
    kinds : tuple of str
    rows : array (n, size)
        Rows of the query objects.
    """

    number: int
    kinds: tuple[str, ...]
    rows: Array


@dataclass(frozen=True)
class HypothesisBatch:
    """Verified hypotheses of some batches.

    Attributes
    ----------
    motors, scores, hits : arrays (m, 8), (m,), (m,)
        Motors of the samples that were not given up, their scores and numbers of inliers, in the order of the samples.
    count : int
        Number of samples.
    n_inliers, n_tested : int
        Numbers of objects that the motors given up match, and on which they were tested.
    """

    motors: Array
    scores: Array
    hits: Array
    count: int
    n_inliers: int
    n_tested: int

    @staticmethod
    def concatenate(parts: Sequence[HypothesisBatch]) -> HypothesisBatch:
        """Concatenation of several, in their order."""
        arrays = ((p.motors, p.scores, p.hits) for p in parts)
        motors, scores, hits = (np.concatenate(x) for x in zip(*arrays, strict=True))
        count, n_inliers, n_tested = (
            sum(x) for x in zip(*((p.count, p.n_inliers, p.n_tested) for p in parts), strict=True)
        )
        return HypothesisBatch(motors, scores, hits, count, n_inliers, n_tested)


@dataclass(frozen=True)
class TableSelection:
    """Random choice of the reference objects in tables, and the treatment of orientations.

    Attributes
    ----------
    rows_in_tables : mapping of kind to array (n,)
        Rows of these objects.
    align : bool
        True if x and -x are the same object.
    """

    rows_in_tables: Mapping[str, Array]
    align: bool


class HypothesisGenerator:
    """Generator and verifier of hypotheses.

    Parameters
    ----------
    scene, driver
        Compiled stages (see `backends.scene`).
    query, reference : mapping of kind to array (n, k)
        Coefficients of unit objects.
    selection : TableSelection

    Attributes
    ----------
    tables : Tables
        Pairs of reference objects.
    """

    def __init__(
        self, scene: Any, driver: Any, query: Mapping[str, Array], reference: Mapping[str, Array],
        selection: TableSelection,
    ) -> None:  # fmt: skip
        self._scene, self._driver, self._query, self._selection = scene, driver, query, selection
        self.tables = Tables(driver, reference, selection.rows_in_tables)

    def evaluate(self, batches: Sequence[SampleBatch], tolerance: float, residual: float) -> HypothesisBatch:
        """Hypotheses of some batches at a tolerance; the quadratic forms of samples may be ``residual`` for each pair.

        The scene's match criterion decides which samples are given up early.
        """
        parts = [self.samples(batch, tolerance) for batch in batches]
        kinds, query, rows, signs = _concatenate_samples(parts)
        motors, scores, hits, tested = self._scene.samples(kinds, query, rows, signs, residual)
        given_up, valid = scores < 0, scores > 0
        n_inliers, n_tested = int(hits[given_up].sum()), int(tested[given_up].sum())
        return HypothesisBatch(motors[valid], scores[valid], hits[valid], len(scores), n_inliers, n_tested)

    def invariants(self, kinds: tuple[str, ...], rows: Array) -> Array:
        """Invariants (n, 4) of pairs (n, 2) of query objects."""
        a, b = kinds
        invariants: Array = self._driver.invariants((a, b), (self._query[a], self._query[b]), (rows[:, 0], rows[:, 1]))
        return invariants

    def samples(self, batch: SampleBatch, tolerance: float) -> Samples:
        """All samples of the sets of a batch."""
        source, images, orientation = self._images(batch, tolerance)
        choices = sign_choices(batch.kinds) if self._selection.align else np.ones((1, len(batch.kinds)))
        image, choice = np.arange(len(images)).repeat(len(choices)), np.tile(np.arange(len(choices)), len(images))
        signs = choices[choice]
        possible = orientation[image] * signs[:, 0] * signs[:, 1] >= 0
        image, signs = image[possible], signs[possible]
        kinds = np.full((len(image), len(batch.kinds)), [KINDS.index(k) for k in batch.kinds])
        return kinds, batch.rows[source[image]], images[image], signs

    def _images(self, batch: SampleBatch, tolerance: float) -> tuple[Array, Array, Array]:
        """Set indices (c,), rows (c, k) of the reference objects of possible images, relative orientations (c,)."""
        pairs = {}
        for a, b in combinations(range(len(batch.kinds)), 2):
            pair = (batch.kinds[a], batch.kinds[b])
            pairs[a, b] = self.tables[pair].find(self.invariants(pair, batch.rows[:, [a, b]]), tolerance)
        first = self._limit_per_set(pairs[0, 1], batch.number)
        source, images, orientation = first.source, np.stack([first.first, first.second], 1), first.orientation
        for later in range(2, len(batch.kinds)):
            images, image_index = _extend_images(source, images, [pairs[a, later] for a in range(later)])
            source, orientation = source[image_index], orientation[image_index]
        return source, images, orientation

    def _limit_per_set(self, candidates: Candidates, number: int) -> Candidates:
        """A random subset of about `MAX_PER_SET` candidates of each set that has more."""
        count = np.bincount(candidates.source)
        if not (count > MAX_PER_SET).any():
            return candidates
        random = np.random.default_rng(number)
        keep = random.random(len(candidates)) * count[candidates.source] < MAX_PER_SET
        return Candidates(
            *(x[keep] for x in (candidates.source, candidates.first, candidates.second, candidates.orientation))
        )


def _concatenate_samples(parts: Sequence[Samples]) -> Samples:
    if len(parts) == 1:
        return parts[0]
    kinds, query, rows, signs = (np.concatenate(p) for p in zip(*parts, strict=True))
    return kinds, query, rows, signs


def _extend_images(source: Array, images: Array, pairs: list[Candidates]) -> tuple[Array, Array]:
    """Images (c, k) extended by one object that makes a possible pair with each other one; their old indices."""
    keys = pack_integers(pairs[0].source, pairs[0].first)
    order = np.argsort(keys, kind="stable")
    wanted = pack_integers(source, images[:, 0])
    low, high = (np.searchsorted(keys[order], wanted, side=side) for side in ("left", "right"))
    image_index, ranks = expand_ranges(low, high)
    position = order[ranks]
    new_rows = pairs[0].second[position]
    possible = np.ones(len(image_index), bool)
    for k, other in enumerate(pairs[1:], 1):
        allowed = np.unique(pack_integers(other.source, other.first, other.second))
        possible &= np.isin(pack_integers(source[image_index], images[image_index, k], new_rows), allowed)
    image_index, new_rows = image_index[possible], new_rows[possible]
    return np.column_stack([images[image_index], new_rows]), image_index


def pack_integers(*numbers: Array) -> Array:
    """One integer for each tuple of small integers."""
    total = np.zeros(len(numbers[0]), np.int64)
    for x in numbers:
        total = (total << PACKED_BITS) | x
    return total
