"""Sets of two or three query objects, and all the sets of reference objects that may be their images, by what no
motion changes. Each such pair of sets is a sample: it makes a motor.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..codegen.programs.reform import KINDS
from .engine import Driver, Scene
from .frames import Local
from .tables import Candidates, Tables, sign_choices

Array = NDArray[Any]
#: Kinds, query rows, reference rows and signs, (n, size) each.
Samples = tuple[Array, Array, Array, Array]
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
#: Bits of a row or of a set's number where several are made one integer; so many of them at most.
CODE_BITS, CODED = 21, 3
#: Candidates of one set of query objects: of a set with more, some are left out.
MOST_OF_SET = 8192


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
    tables : Tables
        Pairs of reference objects.
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
        self._scene, self._driver, self._query, self._align = scene, driver, query, align
        self._samples, self._random = samples, random
        self.tables = Tables(driver, reference.side.rows, random)
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
        wanted = DRAWN * self._samples * (1 if size == 2 else LARGER) / self.tables.share**2
        drawn = self._different(self._random.integers(0, n, (int(min(wanted, MOST_DRAWN)), size)))
        return drawn, self._scene.stiffness(self._of[drawn], self._row[drawn])

    def in_order(self, tolerance: float) -> tuple[Array, Array]:
        """The sets to use, those of which the fewest images are possible first; about how many samples each makes."""
        count = np.zeros(len(self.members), np.int64)
        for kinds, members in self.by_kinds(self.members):
            invariants = self._invariants(kinds[:2], self.members[members, :2])
            count[members] = self.tables[kinds[0], kinds[1]].counts(invariants, tolerance)
        able = np.flatnonzero(count)
        self.able = len(able)
        order = self._some(able[np.argsort(count[able], kind="stable")])
        return self.members[order], count[order]

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
        return int(self._samples * (1 if self.size == 2 else LARGER) / self.tables.share**2)

    def by_kinds(self, sets: Array) -> Iterator[tuple[tuple[str, ...], Array]]:
        """Sets of the same kinds together."""
        if len(self._kinds) == 1:
            yield (self._kinds[0],) * sets.shape[1], np.arange(len(sets))
            return
        code = self._of[sets] @ len(KINDS) ** np.arange(sets.shape[1])
        for value in np.unique(code):
            members = np.flatnonzero(code == value)
            yield tuple(KINDS[k] for k in self._of[sets[members[0]]]), members

    def _invariants(self, kinds: tuple[str, ...], pairs: Array) -> Array:
        rows, (first, second) = self._query.side.rows, pairs.T
        return self._driver.invariants(
            (kinds[0], kinds[1]), (rows[kinds[0]], rows[kinds[1]]), (self._row[first], self._row[second])
        )

    def samples_of(self, kinds: tuple[str, ...], sets: Array, tolerance: float) -> Samples:
        """All samples that sets of query objects of these kinds make."""
        source, images, turned = self._images(kinds, sets, tolerance)
        choices = sign_choices(kinds) if self._align else np.ones((1, len(kinds)))
        image, choice = np.arange(len(images)).repeat(len(choices)), np.tile(np.arange(len(choices)), len(images))
        signs = choices[choice]
        possible = turned[image] * signs[:, 0] * signs[:, 1] >= 0
        image, signs = image[possible], signs[possible]
        members = sets[source[image]]
        return self._of[members], self._row[members], images[image], signs

    def _images(self, kinds: tuple[str, ...], sets: Array, tolerance: float) -> tuple[Array, Array, Array]:
        """Which set, rows (c, k) of reference objects that may be its image, how the second goes with the first."""
        found = {}
        for a, b in combinations(range(len(kinds)), 2):
            pair = (kinds[a], kinds[b])
            found[a, b] = self.tables[pair].find(self._invariants(pair, sets[:, [a, b]]), tolerance)
        first = self._thinned(found[0, 1])
        source, images, turned = first.source, np.stack([first.first, first.second], 1), first.turned
        for later in range(2, len(kinds)):
            images, kept = _joined(source, images, [found[a, later] for a in range(later)])
            source, turned = source[kept], turned[kept]
        return source, images, turned

    def _thinned(self, found: Candidates) -> Candidates:
        """At most `MOST_OF_SET` or so of each set."""
        count = np.bincount(found.source)
        if not (count > MOST_OF_SET).any():
            return found
        keep = self._random.random(len(found)) * count[found.source] < MOST_OF_SET
        return Candidates(*(x[keep] for x in (found.source, found.first, found.second, found.turned)))


def _joined(source: Array, images: Array, pairs: list[Candidates]) -> tuple[Array, Array]:
    """Images (c, k) with one object more: it makes a possible pair with each of them. And which they came from."""
    keys = _code(pairs[0].source, pairs[0].first)
    order = np.argsort(keys, kind="stable")
    asked = _code(source, images[:, 0])
    low, high = (np.searchsorted(keys[order], asked, side=side) for side in ("left", "right"))
    count = high - low
    kept = np.repeat(np.arange(len(images)), count)
    place = order[np.arange(len(kept)) + np.repeat(low - np.cumsum(count) + count, count)]
    added = pairs[0].second[place]
    good = np.ones(len(kept), bool)
    for k, other in enumerate(pairs[1:], 1):
        known = np.unique(_code(other.source, other.first, other.second))
        good &= np.isin(_code(source[kept], images[kept, k], added), known)
    kept, added = kept[good], added[good]
    return np.column_stack([images[kept], added]), kept


def _once(sets: Array) -> Array:
    """Each set once, in order."""
    codes = np.sort(_code(*sets.T))
    new = np.ones(len(codes), bool)
    new[1:] = codes[1:] != codes[:-1]
    shifts = CODE_BITS * np.arange(sets.shape[1] - 1, -1, -1)
    found: Array = codes[new][:, None] >> shifts & (1 << CODE_BITS) - 1
    return found


def _code(*numbers: Array) -> Array:
    """One integer for each tuple of small ones."""
    total = np.zeros(len(numbers[0]), np.int64)
    for x in numbers:
        total = (total << CODE_BITS) | x
    return total
