"""Minimal sets of two or three query objects that determine a motor, in the order in which they vote."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...codegen.programs.registration.registration import KINDS
from ..backends.executor import SharedScene
from .hypotheses import (
    MAX_PACKED,
    PACKED_BITS,
    HypothesisBatch,
    HypothesisGenerator,
    SampleBatch,
    Samples,
    TableSelection,
    pack_integers,
)
from .invariant_tables import table_rows
from .problem import RegistrationProblem

Array = NDArray[Any]
#: A set of objects determines a motor if its smallest pivot is at least this (formula `registration.motor_form`).
WELL_CONDITIONED = 0.05
#: Without such a set: sets count whose smallest pivot is at least this fraction of the largest one.
RELATIVE_CONDITIONING = 0.25
#: Limit below which no set counts.
MIN_CONDITIONING = 1e-6
#: Default numbers of objects of a set, in the order in which they are tried.
SET_SIZES = (2, 3)
#: Number of sets that are drawn for each one that is used: the best conditioned and least ambiguous ones are.
DRAWN_PER_SET = 4
#: Largest number of sets that are drawn.
MAX_DRAWN = 1 << 17
#: This many times as many sets of more than two objects are used: they are less often correct.
LARGE_SET_FACTOR = 4
#: Fraction of the used sets that are drawn from the ambiguous ones.
COMMON_FRACTION = 0.5
#: Table entries that a batch looks up: some milliseconds.
PAIRS_PER_BATCH = 1 << 16
#: Batches that are evaluated here before others are shared over an executor: its workers build tables first, which
#: takes as long.
LOCAL_BATCHES = 16


class QuerySets:
    """Minimal sets of query objects that determine a motor.

    Parameters
    ----------
    problem : RegistrationProblem
    samples : int
        Largest number of sets that are used at each tolerance.
    sample_size : int, optional
        Objects of a set. Default: two where these determine a motor, else three.

    Attributes
    ----------
    members : array (n, size)
        Indices of the objects of each set, over all kinds that both models have.
    size : int
        Objects of a set.
    table_fraction : float
        Fraction of the reference objects that are in tables.
    n_matchable : int
        Number of sets that have images at the tolerance of the last order.

    Raises
    ------
    InputError
        If the query has no sets of that size, or they determine no motor where sets of another size do.
    """

    def __init__(self, problem: RegistrationProblem, samples: int, sample_size: int | None) -> None:
        query, reference = problem.query.data.rows, problem.reference.data.rows
        self._scene, self._max_sets, self._random = problem.scene, samples, problem.random
        rows_in_tables, self.table_fraction = table_rows(reference, self._random)
        self._selection = TableSelection(rows_in_tables, problem.align)
        self._hypotheses = HypothesisGenerator(problem.scene, problem.driver, query, reference, self._selection)
        self._n_batches = self._sent_until = 0
        self._order = self._edges = np.empty(0, np.int64)
        self._kinds, self._kind_numbers, self._rows = list(query), problem.kinds, problem.rows
        if sample_size is not None and not 2 <= sample_size <= len(self._rows):
            remedy = f"The query has {len(self._rows)} of the kinds that both models have; at least 2 determine a motor"
            raise InputError(f"sample_size is {sample_size}: sets of that size cannot be drawn.", remedy=remedy)
        self.members = self._well_conditioned_sets(SET_SIZES if sample_size is None else (sample_size,))
        if sample_size is not None and not len(self.members):
            self._check_sample_size(sample_size)
        self.size, self.n_matchable = int(self.members.shape[1]), 0

    def _check_sample_size(self, size: int) -> None:
        """Raise if sets of this size determine no motor, and others do."""
        if size not in SET_SIZES[1:] and len(self._well_conditioned_sets(SET_SIZES)):
            raise InputError(
                f"sample_size is {size}: that many of these objects determine no motor.", remedy="Leave it out"
            )

    def _well_conditioned_sets(self, sizes: tuple[int, ...]) -> Array:
        """Sets of query objects that determine a motor, by their indices over all kinds, of the smallest such size."""
        for size in sizes:
            sets, conditioning = self._draw(size)
            if (conditioning >= WELL_CONDITIONED).any():
                break
        return np.asarray(sets[conditioning >= _min_conditioning(conditioning)])

    def sample_from(self, numbers: Array, max_sets: int) -> Array:
        """Sets of some objects that determine a motor, at most ``max_sets``."""
        n = len(numbers)
        if n < self.size:
            return np.empty((0, self.size), np.int64)
        drawn = self._distinct(self._random.integers(0, n, (DRAWN_PER_SET * max_sets, self.size)))
        sets = np.sort(numbers[drawn], axis=1)
        conditioning = self._scene.conditioning(self._kind_numbers[sets], self._rows[sets])
        return np.asarray(sets[conditioning >= _min_conditioning(conditioning)][:max_sets])

    def _distinct(self, drawn: Array) -> Array:
        """Sets in random order, without duplicates and without sets that hold an object twice."""
        drawn.sort(axis=1)
        drawn = drawn[(drawn[:, 1:] > drawn[:, :-1]).all(1)]
        drawn = np.unique(drawn, axis=0) if drawn.shape[1] > MAX_PACKED else _unique_sets(drawn)
        return np.asarray(self._random.permutation(drawn))

    def _draw(self, size: int) -> tuple[Array, Array]:
        """Sets of query objects and their conditioning."""
        n = len(self._rows)
        if n < size:
            return np.empty((0, size), np.int64), np.empty(0)
        wanted = DRAWN_PER_SET * self._max_sets * (1 if size == 2 else LARGE_SET_FACTOR) / self.table_fraction**2
        drawn = self._distinct(self._random.integers(0, n, (int(min(wanted, MAX_DRAWN)), size)))
        return drawn, self._scene.conditioning(self._kind_numbers[drawn], self._rows[drawn])

    def order_by_ambiguity(self, tolerance: float) -> Array:
        """Order the sets that are to be used by their numbers of possible images, and return about these numbers."""
        count = np.zeros(len(self.members), np.int64)
        for kinds, members in self._by_kinds(self.members):
            invariants = self._hypotheses.invariants(kinds[:2], self._rows[self.members[members, :2]])
            count[members] = self._hypotheses.tables[kinds[0], kinds[1]].counts(invariants, tolerance)
        matchable = np.flatnonzero(count)
        self.n_matchable = len(matchable)
        self._order = self._select_used(matchable[np.argsort(count[matchable], kind="stable")])
        expected = count[self._order]
        self._edges = _edges(expected)
        self._sent_until = 0
        return expected

    def _select_used(self, order: Array) -> Array:
        """The sets that are used: the first ones of an order, and a random sample of the later ones.

        Repeated parts of a model are always ambiguous: without them a query of one of many windows has no match.
        """
        max_sets = self._max_used()
        if len(order) <= max_sets:
            return order
        first = max_sets - int(COMMON_FRACTION * max_sets)
        later = first + np.sort(self._random.permutation(len(order) - first)[: max_sets - first])
        return np.concatenate([order[:first], order[later]])

    def _max_used(self) -> int:
        return int(self._max_sets * (1 if self.size == 2 else LARGE_SET_FACTOR) / self.table_fraction**2)

    def _by_kinds(self, sets: Array) -> Iterator[tuple[tuple[str, ...], Array]]:
        """Groups of sets by their kinds: the kinds, and the indices of the sets."""
        if len(self._kinds) == 1:
            yield (self._kinds[0],) * sets.shape[1], np.arange(len(sets))
            return
        kind_codes = self._kind_numbers[sets] @ len(KINDS) ** np.arange(sets.shape[1])
        for value in np.unique(kind_codes):
            members = np.flatnonzero(kind_codes == value)
            yield tuple(KINDS[k] for k in self._kind_numbers[sets[members[0]]]), members

    def evaluate(self, begin: int, end: int, tolerance: float, residual: float) -> tuple[int, HypothesisBatch]:
        """Evaluate the sets of the order from ``begin`` to ``end``, or to the last batch edge before it.

        Returns that end, and the hypotheses. Batches do not depend on where they are evaluated.
        """
        within = self._edges[(self._edges > begin) & (self._edges <= end)]
        bounds = [begin, *within.tolist()] if len(within) else [begin, min(end, len(self._order))]
        self._n_batches += len(bounds) - 1
        if isinstance(self._scene, SharedScene) and self._n_batches > LOCAL_BATCHES and len(bounds) > 2:
            result = self._evaluate_on_workers(self._scene, bounds, tolerance, residual)
        else:
            batches = [batch for part in pairwise(bounds) for batch in self._batches_between(*part)]
            result = self._hypotheses.evaluate(batches, tolerance, residual)
        return bounds[-1], result

    def _evaluate_on_workers(
        self, scene: SharedScene, bounds: list[int], tolerance: float, residual: float
    ) -> HypothesisBatch:
        """Evaluate batches on workers, and send some of the next ones too: workers need not wait for the search."""
        later = self._edges[self._edges > bounds[-1]][: scene.ahead].tolist()
        for part in pairwise([*bounds, *later]):
            if part[0] >= self._sent_until:
                scene.send(self._selection, part[0], list(self._batches_between(*part)), tolerance, residual)
                self._sent_until = part[1]
        return scene.collect(bounds[:-1])

    def _batches_between(self, begin: int, end: int) -> Iterator[SampleBatch]:
        """Batches of a part of the order."""
        return self._batches(begin, self.members[self._order[begin:end]])

    def samples_of(self, sets: Array, tolerance: float) -> Iterator[Samples]:
        """All samples of some sets (n, size) of query objects, one group of kinds at a time."""
        for batch in self._batches(0, sets):
            yield self._hypotheses.samples(batch, tolerance)

    def _batches(self, number: int, sets: Array) -> Iterator[SampleBatch]:
        """Batches of sets of the same kinds."""
        for kinds, members in self._by_kinds(sets):
            yield SampleBatch(number, kinds, self._rows[sets[members]])


def _min_conditioning(conditioning: Array) -> float:
    """Conditioning from which on sets count: of the well conditioned ones, or, without them, of the better ones."""
    if (conditioning >= WELL_CONDITIONED).any():
        return WELL_CONDITIONED
    return max(RELATIVE_CONDITIONING * float(conditioning.max(initial=0)), MIN_CONDITIONING)


def _edges(expected: Array) -> Array:
    """Ends of the batches of sets, by the expected numbers of their samples."""
    total = np.cumsum(expected)
    if not len(total) or total[-1] < PAIRS_PER_BATCH:
        return np.array([len(total)])
    return np.append(np.flatnonzero(np.diff(total // PAIRS_PER_BATCH)) + 1, len(total))


def _unique_sets(sets: Array) -> Array:
    """Sorted sets without duplicates."""
    codes = np.sort(pack_integers(*sets.T))
    new = np.ones(len(codes), bool)
    new[1:] = codes[1:] != codes[:-1]
    shifts = PACKED_BITS * np.arange(sets.shape[1] - 1, -1, -1)
    sets_: Array = codes[new][:, None] >> shifts & (1 << PACKED_BITS) - 1
    return sets_
