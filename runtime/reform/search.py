"""The global start: pairs (or triples) of query objects vote, by what no motion changes, for motors, which are then
verified by how many objects they lay on each other (cf. RANSAC, and geometric hashing).

Tolerances rise from rounding to a few hundredths of a model's size until an answer is more than chance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .chance import doubt, meetings_of
from .contest import APART, LEVEL, SAME_POSE, Contest, distinct
from .engine import Driver, Scene
from .frames import Local, closeness_within
from .sets import Sets
from .sides import Closeness
from .trials import Tried

Array = NDArray[Any]
#: Differences of invariants that are tried in turn, in units of the models' size: exact models, then noisy ones.
TOLERANCES = (1e-6, 1e-3, 1e-2, 3e-2)
#: Objects that a verified motor lays on each other may be off by this many tolerances.
REACH = 3.0
#: Pairs of a table that one call looks at.
MOST_LOOKED_AT = 1 << 19
#: Candidates of one call of the driver, at first and at most, of one tolerance; sets of the first call.
FIRST_BLOCK, BLOCK, MOST_CANDIDATES, FIRST_SETS = 256, 1 << 16, 1 << 20, 16
#: What rounding leaves of the form of a sample's motor.
ROUNDING = 1e-13
#: Candidates that are kept for refinement; of so many times as many it is found which are one.
KEPT, MOST_COMPARED = 64, 16
#: A motor is given up if a smaller share of the first objects has a counterpart.
LEAST = 0.1
#: An answer is no chance if fewer than this many of that quality are expected among all motors that were tried.
CHANCE = 1e-4
#: Probability that a right motor, or one that serves as well, has been missed when the search stops; share of the right
#: sets whose invariants noise leaves within a tolerance.
MISSED, WITHIN = 1e-4, 0.4
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
    rivalled : bool
        Chance does not explain the best, but others that contradict it are nearly as good.
    usual : float
        The share of objects that candidates which do not serve lay on others; NaN before they were compared.
    enough : bool
        Whether no better motor was missed, as far as noise is less than the tolerance.
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
    rivalled: bool = False
    usual: float = math.nan
    enough: bool = False

    def compare(self, challengers: Array | None = None) -> None:
        """Refine candidates and hold them against each other, and against others (m, 8) that may be as good."""
        assert self.contest is not None
        motors, usual = self.motors, None
        if challengers is not None:
            motors, usual = np.concatenate([motors[:1], challengers, motors[1:]]), self.usual
        standing = self.contest.run(motors, self.tolerance, max(self.candidates, 1), usual)
        self.usual = standing.chance
        self.motors, self.scores, self.hits = standing.motors, standing.scores, standing.hits
        self.equal, self.reach = standing.equal, standing.reach
        self.rivalled = standing.doubt <= math.log10(CHANCE) and not standing.stands_out
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

    Raises
    ------
    InputError
        If the query has no sets of that size, or they place no motor where those of another size do.

    Attributes
    ----------
    tell : callable
        Is told what there is at this tolerance, after each block of motors.
    """

    def __init__(
        self, scene: Scene, driver: Driver, query: Local, reference: Local, samples: int, sample_size: int | None,
        random: np.random.Generator, align: bool = True, length: float = 1.0,
    ) -> None:  # fmt: skip
        self.scene, self.query, self.align, self.length = scene, query, align, length
        self.tell: Callable[[Found], None] = lambda found: None
        self.sets = Sets(scene, driver, query, reference, samples, sample_size, random, align)
        algebra = next(iter(query.objects.values())).algebra
        self._meetings = meetings_of(scene, algebra, align, length)
        self._contest = Contest(scene, self._meetings, self.sets.size, align, length)

    # -- one tolerance --

    def run(self, tolerance: float, found: Found) -> Found:
        """Search at this tolerance; better than what was found before, or the same."""
        self.scene.closeness(closeness(tolerance, LEAST, self.align, self.length))
        here = Found(tolerance=tolerance, candidates=found.candidates, contest=self._contest)
        met = looked = 0
        here.chance = float(self._meetings.within(REACH * tolerance))
        residual = max(4 * (tolerance * REACH) ** 2, ROUNDING)
        for sets, tried in self._blocks(tolerance, residual):
            met, looked = met + tried.met, looked + tried.looked
            here.candidates += tried.count
            here.sets += sets
            self._keep(here, tried)
            here.chance = max(here.chance, met / looked if looked else 0.0)
            here.doubt = self._doubt(here)
            self.tell(here)
            here.enough = self._is_enough(here, here.sets)
            if here.enough:
                break
        else:  # sets without an image count too, where all the others were used
            here.enough = here.sets == self.sets.able and self._is_enough(here, len(self.sets.members))
        if here.doubt <= math.log10(CHANCE):
            here.compare()
        return here if here.doubt < found.doubt or not len(found.scores) else _counted(found, here)

    def _keep(self, here: Found, tried: Tried) -> None:
        scores = np.concatenate([here.scores, tried.scores])
        motors, hits = np.concatenate([here.motors, tried.motors]), np.concatenate([here.hits, tried.hits])
        best = np.argsort(-scores, kind="stable")
        if len(best) > 2 * KEPT:  # one pose many times would leave no room for what it is held against
            best = best[: MOST_COMPARED * KEPT]
            best = best[distinct(motors[best], max(APART * here.tolerance, SAME_POSE), 2 * KEPT)]
        here.motors, here.scores, here.hits = motors[best], scores[best], hits[best]

    def _doubt(self, here: Found) -> float:
        if not len(here.scores):
            return math.inf
        size = self.sets.size
        return doubt(int(here.hits[0]) - size, self.scene.asked - size, here.chance, max(here.candidates, 1))

    def _is_enough(self, here: Found, sets: int) -> bool:
        """Whether the best is no chance, and a better one would have been met among so many sets."""
        if here.doubt > math.log10(CHANCE):
            return False
        right = (here.hits[0] / self.scene.asked * self.sets.share) ** self.sets.size
        right *= 1.0 if here.tolerance <= TOLERANCES[0] else WITHIN
        return bool(sets * math.log(max(1 - right, 1e-300)) <= math.log(MISSED))

    def _blocks(self, tolerance: float, residual: float) -> Iterator[tuple[int, Tried]]:
        """What some sets gave, and how many they were: few at first, for they may do."""
        expected = self.sets.in_order(tolerance)
        done = total = 0
        share = 1.0  # of what is expected: a table is sorted by one invariant, and four must agree
        while done < len(expected) and total < MOST_CANDIDATES:
            few = min(min(max(total, FIRST_BLOCK), BLOCK) / share, MOST_LOOKED_AT)
            within = np.searchsorted(np.cumsum(expected[done:]), few)
            end = done + min(max(int(within), 1), max(done, FIRST_SETS))
            end, tried = self.sets.tried(done, end, tolerance, residual)
            total += tried.count
            yield end - done, tried
            done = end
            share = min(1.0, (total + 1) / max(1, expected[:done].sum()))


def _counted(found: Found, here: Found) -> Found:
    found.candidates = here.candidates
    return found
