"""Sets of two or three query objects that place a motor, in the order in which they vote; see `trials` for how."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..codegen.programs.reform import KINDS
from .distributed import SharedScene
from .engine import Driver, Scene
from .frames import Local
from .tables import kept_rows
from .trials import CODE_BITS, CODED, Chosen, Lot, Samples, Trials, Tried, code

Array = NDArray[Any]
#: A set of objects places a motor if its least pivot is no smaller (formula `registration.motor_form`). Where there is
#: none, those count that come near to the stiffest, down to a limit.
STIFF, NEARLY, LEAST_STIFF = 0.05, 0.25, 1e-6
#: Objects of a set, unless asked otherwise: few where they do.
SIZES = (2, 3)
#: Sets that are drawn for each that is used: the stiffest and rarest are taken. Of sets of more than two objects,
#: which are right less often, so many times as many are used.
DRAWN, MOST_DRAWN, LARGER = 4, 1 << 17, 4
#: Share of the sets that are used however many images are possible.
COMMON = 0.5
#: Pairs of a table that a lot looks at, some milliseconds; lots that are tried here before others are shared over an
#: executor: its workers make tables of their own first, which takes as long.
LOT, ALONE = 1 << 16, 16


class Sets:
    """Sets of query objects that place a motor.

    Parameters
    ----------
    scene : Scene
    driver : Driver
    query, reference : Local
    samples : int
        Sets that are used at each tolerance, at most.
    sample_size : int, optional
        Objects of a set; default: two where that places a motor, else three.
    random : numpy Generator
    align : bool
        x and -x are one.

    Attributes
    ----------
    members : array (n, size)
        Numbers of the objects of each set, over all kinds that both models have.
    size : int
    share : float
        Of the reference objects, that which is in tables.
    able : int
        How many of the sets have images at the tolerance of the last order.

    Raises
    ------
    InputError
        If the query has no sets of that size, or they place no motor where those of another size do.
    """

    def __init__(
        self, scene: Scene, driver: Driver, query: Local, reference: Local, samples: int, sample_size: int | None,
        random: np.random.Generator, align: bool,
    ) -> None:  # fmt: skip
        self._scene, self._samples, self._random = scene, samples, random
        kept, self.share = kept_rows(reference.side.rows, random)
        self._chosen = Chosen(kept, align)
        self._trials = Trials(scene, driver, query.side.rows, reference.side.rows, self._chosen)
        self._done = self._sent = 0
        self._order = self._edges = np.empty(0, np.int64)
        self._kinds = [k for k in KINDS if k in query.objects and k in reference.objects]
        self._of = np.repeat([KINDS.index(k) for k in self._kinds], [query.objects[k].shape[0] for k in self._kinds])
        self._row = np.concatenate([np.arange(query.objects[k].shape[0]) for k in self._kinds])
        if sample_size is not None and not 2 <= sample_size <= len(self._row):
            remedy = f"The query has {len(self._row)} of the kinds that both models have; at least 2 place a motor"
            raise InputError(f"sample_size is {sample_size}: sets of so many objects cannot be drawn.", remedy=remedy)
        self.members = self._stiff_sets(SIZES if sample_size is None else (sample_size,))
        if sample_size is not None and not len(self.members):
            self._check_sample_size(sample_size)
        self.size, self.able = int(self.members.shape[1]), 0

    def _check_sample_size(self, size: int) -> None:
        """Where sets of this size place no motor, and others do, it is the size that is wrong."""
        if size not in SIZES[1:] and len(self._stiff_sets(SIZES)):
            raise InputError(f"sample_size is {size}: so many of these objects place no motor.", remedy="Leave it out")

    def _stiff_sets(self, sizes: tuple[int, ...]) -> Array:
        """Sets of query objects, by their numbers over all kinds, that place a motor: small ones where they do."""
        drawn = []
        for size in sizes:
            sets, stiff = self._draw(size)
            if (stiff >= STIFF).any():
                return np.asarray(sets[stiff >= STIFF])
            drawn.append((sets, stiff))
        sets, stiff = drawn[-1]
        return np.asarray(sets[stiff >= max(NEARLY * stiff.max(initial=0), LEAST_STIFF)])

    def among(self, numbers: Array, most: int) -> Array:
        """Sets of these objects that place a motor, at most so many."""
        n = len(numbers)
        if n < self.size:
            return np.empty((0, self.size), np.int64)
        drawn = self._different(self._random.integers(0, n, (DRAWN * most, self.size)))
        sets = np.sort(numbers[drawn], axis=1)
        stiff = self._scene.stiffness(self._of[sets], self._row[sets])
        least = STIFF if (stiff >= STIFF).any() else max(NEARLY * stiff.max(initial=0), LEAST_STIFF)
        return np.asarray(sets[stiff >= least][:most])

    def _different(self, drawn: Array) -> Array:
        """Sets without those that hold an object twice, each once, shuffled."""
        drawn.sort(axis=1)
        drawn = drawn[(drawn[:, 1:] > drawn[:, :-1]).all(1)]
        drawn = np.unique(drawn, axis=0) if drawn.shape[1] > CODED else _once(drawn)
        return np.asarray(self._random.permutation(drawn))

    def _draw(self, size: int) -> tuple[Array, Array]:
        """Sets of query objects and how stiff they are."""
        n = len(self._row)
        if n < size:
            return np.empty((0, size), np.int64), np.empty(0)
        wanted = DRAWN * self._samples * (1 if size == 2 else LARGER) / self.share**2
        drawn = self._different(self._random.integers(0, n, (int(min(wanted, MOST_DRAWN)), size)))
        return drawn, self._scene.stiffness(self._of[drawn], self._row[drawn])

    def in_order(self, tolerance: float) -> Array:
        """About how many samples each of the sets makes that are to be used, in that order: first those of which the
        fewest images are possible."""
        count = np.zeros(len(self.members), np.int64)
        for kinds, members in self._by_kinds(self.members):
            invariants = self._trials.invariants(kinds[:2], self._row[self.members[members, :2]])
            count[members] = self._trials.tables[kinds[0], kinds[1]].counts(invariants, tolerance)
        able = np.flatnonzero(count)
        self.able = len(able)
        self._order = self._some(able[np.argsort(count[able], kind="stable")])
        expected = count[self._order]
        self._edges = _edges(expected)
        self._sent = 0
        return expected

    def _some(self, order: Array) -> Array:
        """As many as are used: the first ones, and others of all that come later.

        What a model has several times is never rare: without those a query of one of many windows is not found.
        """
        most = self._most()
        if len(order) <= most:
            return order
        first = most - int(COMMON * most)
        later = first + np.sort(self._random.permutation(len(order) - first)[: most - first])
        return np.concatenate([order[:first], order[later]])

    def _most(self) -> int:
        return int(self._samples * (1 if self.size == 2 else LARGER) / self.share**2)

    def _by_kinds(self, sets: Array) -> Iterator[tuple[tuple[str, ...], Array]]:
        """Sets of the same kinds together."""
        if len(self._kinds) == 1:
            yield (self._kinds[0],) * sets.shape[1], np.arange(len(sets))
            return
        code = self._of[sets] @ len(KINDS) ** np.arange(sets.shape[1])
        for value in np.unique(code):
            members = np.flatnonzero(code == value)
            yield tuple(KINDS[k] for k in self._of[sets[members[0]]]), members

    def tried(self, begin: int, end: int, tolerance: float, residual: float) -> tuple[int, Tried]:
        """What the sets of that order from ``begin`` on give, and where they end: at ``end`` or a lot's edge before it.

        See `Trials.tried`. Lots do not depend on who tries them.
        """
        within = self._edges[(self._edges > begin) & (self._edges <= end)]
        bounds = [begin, *within.tolist()] if len(within) else [begin, min(end, len(self._order))]
        self._done += len(bounds) - 1
        if isinstance(self._scene, SharedScene) and self._done > ALONE and len(bounds) > 2:
            tried = self._shared(self._scene, bounds, tolerance, residual)
        else:
            lots = [lot for part in pairwise(bounds) for lot in self._part(*part)]
            tried = self._trials.tried(lots, tolerance, residual)
        return bounds[-1], tried

    def _shared(self, scene: SharedScene, bounds: list[int], tolerance: float, residual: float) -> Tried:
        """The same by workers, who are sent some of the lots that come next, too: they do not wait for an answer."""
        later = self._edges[self._edges > bounds[-1]][: scene.ahead].tolist()
        for part in pairwise([*bounds, *later]):
            if part[0] >= self._sent:
                scene.send(self._chosen, part[0], list(self._part(*part)), tolerance, residual)
                self._sent = part[1]
        return scene.collected(bounds[:-1])

    def _part(self, begin: int, end: int) -> Iterator[Lot]:
        """Some sets of the order."""
        return self._lots(begin, self.members[self._order[begin:end]])

    def samples_of(self, sets: Array, tolerance: float) -> Iterator[Samples]:
        """All samples that some sets (n, size) of query objects make, those of the same kinds together."""
        for lot in self._lots(0, sets):
            yield self._trials.samples(lot, tolerance)

    def _lots(self, number: int, sets: Array) -> Iterator[Lot]:
        """Sets, those of the same kinds together."""
        for kinds, members in self._by_kinds(sets):
            yield Lot(number, kinds, self._row[sets[members]])


def _edges(expected: Array) -> Array:
    """Where the lots of sets end that are expected to make so many samples."""
    total = np.cumsum(expected)
    if not len(total) or total[-1] < LOT:
        return np.array([len(total)])
    return np.append(np.flatnonzero(np.diff(total // LOT)) + 1, len(total))


def _once(sets: Array) -> Array:
    """Each set once, in order."""
    codes = np.sort(code(*sets.T))
    new = np.ones(len(codes), bool)
    new[1:] = codes[1:] != codes[:-1]
    shifts = CODE_BITS * np.arange(sets.shape[1] - 1, -1, -1)
    found: Array = codes[new][:, None] >> shifts & (1 << CODE_BITS) - 1
    return found
