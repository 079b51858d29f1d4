"""The global start: pairs (or triples) of query objects vote, by what no motion changes, for motors, which are then
verified by how many objects they lay on each other (cf. RANSAC, and geometric hashing).

Tolerances rise from rounding to a few hundredths of a model's size until an answer is more than chance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.reform import KINDS
from .chance import CHANCE_REACH, Meetings, doubt, random_motors
from .contest import LEVEL, SAME, SAME_POSE, Contest, distinct
from .engine import Closeness, Driver, Scene
from .frames import Local, closeness_within
from .tables import Candidates, Tables, sign_choices

Array = NDArray[Any]
#: Kinds, query rows, reference rows and signs, (n, size) each.
Samples = tuple[Array, Array, Array, Array]
#: Differences of invariants that are tried in turn, in units of the models' size: exact models, then noisy ones.
TOLERANCES = (1e-6, 1e-3, 1e-2, 3e-2)
#: Objects that a verified motor lays on each other may be off by this many tolerances.
REACH = 3.0
#: A set of objects places a motor if its least pivot is no smaller (formula `registration.motor_form`).
STIFF = 0.05
#: Sets that are drawn for each that is used: the stiffest and rarest are taken.
DRAWN, MOST_DRAWN = 4, 1 << 17
#: Candidates of one call of the driver, at first and at most, of one tolerance; sets of the first call.
FIRST_BLOCK, BLOCK, MOST_CANDIDATES, FIRST_SETS = 256, 1 << 16, 1 << 20, 4
#: Bits of a row or of a set's number where several are made one integer.
CODE_BITS = 21
#: What rounding leaves of the form of a sample's motor.
ROUNDING = 1e-13
#: Candidates of one set of query objects: of a set with more, some are left out.
MOST_OF_SET = 8192
#: Candidates that are kept for refinement; of so many times as many it is found which are one.
KEPT, MOST_COMPARED = 64, 16
#: A motor is given up if a smaller share of the first objects has a counterpart.
LEAST = 0.1
#: An answer is no chance if fewer than this many of that quality are expected among all motors that were tried.
CHANCE = 1e-4
#: Share of the sets that may have missed a right motor, when the search stops.
MISSED = 1e-4
#: Objects that verify a motor while searching.
VERIFIED = 512


@dataclass
class Found:
    """What a search has found so far.

    Attributes
    ----------
    motors, scores, hits : arrays (m, 8), (m,), (m,)
        The best candidates, the best first, in the frames of the models.
    tolerance : float
        At which they were found.
    candidates : int
        Motors that were tried, at all tolerances.
    chance : float
        Probability that a wrong motor lays an object on another one, at this tolerance.
    doubt : float
        log10 of how many motors as good as the best one are expected by chance among those tried; or, where that is
        more, of the chance of its lead over its rivals, on such a scale that `CHANCE` is the limit of both.
    sets : int
        Sets of query objects that were used at this tolerance.
    reach : float
        Distance up to which the best one's matches say most; NaN before candidates were compared.
    equal : int
        As many of the motors, the first ones, serve as well as each other.
    contest : Contest
        What compares them.
    """

    motors: Array = field(default_factory=lambda: np.empty((0, 8)))
    scores: Array = field(default_factory=lambda: np.empty(0))
    hits: Array = field(default_factory=lambda: np.empty(0, np.int32))
    tolerance: float = math.nan
    candidates: int = 0
    chance: float = 1.0
    doubt: float = math.inf
    sets: int = 0
    reach: float = math.nan
    equal: int = 1
    contest: Contest | None = None

    def compare(self) -> None:
        """Refine candidates and hold them against each other."""
        assert self.contest is not None
        standing = self.contest.run(self.motors, self.tolerance, max(self.candidates, 1))
        self.motors, self.scores, self.hits = standing.motors, standing.scores, standing.hits
        self.equal, self.reach = standing.equal, standing.reach
        self.doubt = max(standing.doubt, standing.lead - math.log10(LEVEL) + math.log10(CHANCE))


def closeness(tolerance: float, least: float = LEAST, align: bool = True, length: float = 1.0) -> Closeness:
    """When a motor lays one object on another, at a tolerance."""
    return closeness_within(REACH * tolerance, least, align, length)


class Search:
    """A global search over motors, one tolerance at a time.

    Parameters
    ----------
    scene : Scene
    driver : Driver
    query, reference : Local
    samples : int
        Sets of query objects at each tolerance, at most.
    sample_size : int, optional
        Objects of a set; default: two where that places a motor, else three.
    random : numpy Generator
    align : bool
        x and -x are one.
    """

    def __init__(
        self, scene: Scene, driver: Driver, query: Local, reference: Local, samples: int, sample_size: int | None,
        random: np.random.Generator, align: bool = True, length: float = 1.0,
    ) -> None:  # fmt: skip
        self.scene, self.driver, self.query, self.reference = scene, driver, query, reference
        self.samples, self.random, self.align, self.length = samples, random, align, length
        self.tables = Tables(driver, reference.side.rows, random)
        self._kinds = [k for k in KINDS if k in query.objects and k in reference.objects]
        self._of = np.repeat([KINDS.index(k) for k in self._kinds], [query.objects[k].shape[0] for k in self._kinds])
        self._row = np.concatenate([np.arange(query.objects[k].shape[0]) for k in self._kinds])
        sizes = (2, 3) if sample_size is None else (sample_size,)
        self._sets = next((s for s in map(self._stiff_sets, sizes) if len(s)), np.empty((0, sizes[-1]), np.int64))
        self._meetings = self._random_meetings()
        self._contest = Contest(scene, self._meetings, self._sets.shape[1], align, length)

    # -- sets of query objects --

    def _stiff_sets(self, size: int) -> Array:
        """Sets of query objects, by their numbers over all kinds, that place a motor."""
        n = len(self._row)
        if n < size:
            return np.empty((0, size), np.int64)
        wanted = DRAWN * self.samples * (1 if size == 2 else DRAWN) / self.tables.share**2
        drawn = self.random.integers(0, n, (int(min(wanted, MOST_DRAWN)), size))
        drawn.sort(axis=1)
        drawn = drawn[(np.diff(drawn, axis=1) > 0).all(1)]
        drawn = drawn[np.unique(drawn, axis=0, return_index=True)[1]]
        drawn = self.random.permutation(drawn)
        stiff = self.scene.stiffness(self._of[drawn], self._row[drawn])
        return np.asarray(drawn[stiff >= STIFF])

    def _random_meetings(self) -> Meetings:
        """How often objects meet under random motors."""
        algebra = next(iter(self.query.objects.values())).algebra
        self.scene.closeness(closeness_within(CHANCE_REACH, 0.0, self.align, self.length))
        hits = self.scene.refine(random_motors(algebra), 0)[2]
        return Meetings(float((hits.sum() + 1) / (len(hits) * self.scene.asked + 1)))

    # -- one tolerance --

    def run(self, tolerance: float, found: Found) -> Found:
        """Search at this tolerance; better than what was found before, or the same."""
        self.scene.closeness(closeness(tolerance, LEAST, self.align, self.length))
        here = Found(tolerance=tolerance, candidates=found.candidates, contest=self._contest)
        met = looked = 0
        here.chance = float(self._meetings.within(REACH * tolerance))
        residual = max(4 * (tolerance * REACH) ** 2, ROUNDING)
        for sets, (kinds, query, rows, signs) in self._blocks(tolerance):
            motors, scores, hits, tested = self.scene.samples(kinds, query, rows, signs, residual)
            wrong = scores < 0
            met, looked = met + int(hits[wrong].sum()), looked + int(tested[wrong].sum())
            here.candidates += len(scores)
            here.sets += sets
            self._keep(here, motors, scores, hits)
            here.chance = max(here.chance, met / looked if looked else 0.0)
            here.doubt = self._doubt(here)
            if self._is_enough(here):
                break
        if here.doubt <= math.log10(CHANCE):
            here.compare()
        return here if here.doubt < found.doubt or not len(found.scores) else _counted(found, here)

    def _keep(self, here: Found, motors: Array, scores: Array, hits: Array) -> None:
        good = np.flatnonzero(scores > 0)
        scores = np.concatenate([here.scores, scores[good]])
        motors, hits = np.concatenate([here.motors, motors[good]]), np.concatenate([here.hits, hits[good]])
        best = np.argsort(-scores, kind="stable")
        if len(best) > 2 * KEPT:  # the same one again would leave no room for what it is held against
            best = best[: MOST_COMPARED * KEPT]
            best = best[distinct(motors[best], max(SAME * here.tolerance, SAME_POSE))[: 2 * KEPT]]
        here.motors, here.scores, here.hits = motors[best], scores[best], hits[best]

    def _doubt(self, here: Found) -> float:
        if not len(here.scores):
            return math.inf
        size = self._sets.shape[1]
        return doubt(int(here.hits[0]) - size, self.scene.asked - size, here.chance, max(here.candidates, 1))

    def _is_enough(self, here: Found) -> bool:
        """Whether the best is no chance, and a better one would have been met among so many sets."""
        if here.doubt > math.log10(CHANCE):
            return False
        right = (here.hits[0] / self.scene.asked * self.tables.share) ** self._sets.shape[1]
        return bool(here.sets * math.log(max(1 - right, 1e-300)) <= math.log(MISSED))

    def _blocks(self, tolerance: float) -> Iterator[tuple[int, Samples]]:
        """Samples for the driver, and how many sets they come from: few at first, for they may do."""
        chosen, expected = self._in_order(tolerance)
        done = total = 0
        while done < len(chosen) and total < MOST_CANDIDATES:
            within = np.searchsorted(np.cumsum(expected[done:]), min(max(total, FIRST_BLOCK), BLOCK))
            end = done + min(max(int(within), 1), max(done, FIRST_SETS))
            parts = [
                self._samples_of(kinds, chosen[done:end][m], tolerance) for kinds, m in self._by_kinds(chosen[done:end])
            ]
            kinds, query, rows, signs = (np.concatenate(p) for p in zip(*parts, strict=True))
            total += len(kinds)
            yield min(end, len(chosen)) - done, (kinds, query, rows, signs)
            done = end

    def _in_order(self, tolerance: float) -> tuple[Array, Array]:
        """The sets of which the fewest images are possible, first; and about how many samples each makes."""
        count = np.zeros(len(self._sets), np.int64)
        for kinds, members in self._by_kinds(self._sets):
            invariants = self._invariants(kinds[:2], self._sets[members, :2])
            count[members] = self.tables[kinds[0], kinds[1]].counts(invariants, tolerance)
        able = np.flatnonzero(count)
        order = able[np.argsort(count[able], kind="stable")][: int(self.samples / self.tables.share**2)]
        return self._sets[order], count[order]

    def _by_kinds(self, sets: Array) -> Iterator[tuple[tuple[str, ...], Array]]:
        """Sets of the same kinds together."""
        code = self._of[sets] @ len(KINDS) ** np.arange(sets.shape[1])
        for value in np.unique(code):
            members = np.flatnonzero(code == value)
            yield tuple(KINDS[k] for k in self._of[sets[members[0]]]), members

    def _invariants(self, kinds: tuple[str, ...], pairs: Array) -> Array:
        rows, (first, second) = self.query.side.rows, pairs.T
        return self.driver.invariants(
            (kinds[0], kinds[1]), (rows[kinds[0]], rows[kinds[1]]), (self._row[first], self._row[second])
        )

    def _samples_of(self, kinds: tuple[str, ...], sets: Array, tolerance: float) -> Samples:
        """All samples that sets of query objects of these kinds make."""
        source, images, turned = self._images(kinds, sets, tolerance)
        choices = sign_choices(kinds) if self.align else np.ones((1, len(kinds)))
        image, choice = (x.ravel() for x in np.indices((len(images), len(choices))))
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
        keep = self.random.random(len(found)) * count[found.source] < MOST_OF_SET
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


def _code(*numbers: Array) -> Array:
    """One integer for each tuple of small ones."""
    total = np.zeros(len(numbers[0]), np.int64)
    for x in numbers:
        total = (total << CODE_BITS) | x
    return total


def _counted(found: Found, here: Found) -> Found:
    found.candidates = here.candidates
    return found
