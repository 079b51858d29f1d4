"""Candidates of a search against each other: how near their matches are, which are one motor, which serve as well as
the best, and whether the best stands out from those that contradict it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .chance import ROUNDING_REACH, Meetings, doubts, lead
from .engine import Scene
from .frames import closeness_within

Array = NDArray[Any]
#: Distances beyond this, in units of the models' size, are no agreement.
WIDEST = 0.15
#: Candidates of which it is looked at how near their matches are, at first and where one is challenged; rounds of
#: refinement and of that; of iterative matching in each; a smaller gain of `Nearness.doubt` ends them.
TRIED, CHALLENGED, ROUNDS, STEPS, GAIN = 4, 8, 3, 10, 0.5
#: A candidate with less doubt than this is the one to begin with.
BEYOND_DOUBT = -20.0
#: Matches are looked for up to so many times as far as those that say most: refinement needs some room. And when
#: candidates are compared.
ROOM, COUNTED = 2.0, 1.5
#: A reach is known from few matches no better than by a factor: of their numbers, four of a line, so many deviations.
NUMBERS, DEVIATIONS = 4, 3.0
#: Candidates with a smaller share of the best one's hits are not refined: they say what is usual.
RIVAL = 0.4
#: A motor serves as well as the best if it lays this share of as many objects on others, up to one: of a symmetric
#: model some objects are missing for each of its poses, not as many for all.
AS_GOOD = 0.85
#: Two motors are one if their coefficients are nearer than so many reaches, or than this; and up to so many they do
#: not contradict each other.
SAME, SAME_POSE, APART = 2.0, 1e-3, 4.0
#: Motors that are held against each other at once: bits of a number.
AT_ONCE = 64
#: Candidates that take part; where more than this serve as well as each other (a cube has 24), nothing is known.
CONTENDERS, MOST_EQUAL = 64, 24
#: The best motor's lead over its rivals is believed if chance gives such a one with a smaller probability; and that
#: of the last motor that serves as well.
LEVEL, LAST_LEVEL = 0.01, 0.2


@dataclass(frozen=True)
class Standing:
    """How a contest ends.

    Attributes
    ----------
    motors, scores, hits : arrays (m, 8), (m,), (m,)
        Refined and told apart: the best, those that serve as well, the others, each from the best on.
    equal : int
        How many serve: the best and its equivalents.
    reach : float
        Distance up to which the best one's matches say most.
    doubt : float
        log10 of how many motors as good as the best are expected by chance.
    lead : float
        log10 of the probability of its lead over those that do not serve, where `LEVEL` is the limit.
    chance : float
        The share of objects that wrong motors lay on others, that the lead was reckoned with.
    """

    motors: Array
    scores: Array
    hits: Array
    equal: int
    reach: float
    doubt: float
    lead: float
    chance: float

    @property
    def stands_out(self) -> bool:
        """Whether what contradicts the best is clearly worse."""
        return self.lead <= math.log10(LEVEL)


@dataclass(frozen=True)
class Nearness:
    """How near the matches of a motor are that say most against chance."""

    doubt: float
    hits: int
    reach: float


@dataclass(frozen=True)
class Contest:
    """What candidates are judged by.

    Parameters
    ----------
    scene : Scene
    meetings : Meetings
    size : int
        Objects that a candidate was made from: they agree by construction.
    align, length
        As of `Job`.
    """

    scene: Scene
    meetings: Meetings
    size: int
    align: bool = True
    length: float = 1.0

    def within(self, reach: float) -> None:
        """Objects up to here from each other may be one, from now on."""
        self.scene.closeness(closeness_within(reach, 0.0, self.align, self.length))

    def nearness(self, motor: Array, tried: int) -> Nearness:
        """The distance up to which the matches of a motor are least by chance.

        Parameters
        ----------
        motor : array (8,)
        tried : int
            Motors among which it was found.
        """
        self.within(WIDEST)
        indices, squares, _ = self.scene.match(motor)
        distances = np.sqrt(np.sort(squares[indices >= 0]))[self.size :]
        if not len(distances):
            return Nearness(math.inf, self.size, WIDEST)
        found = doubts(
            np.arange(1, len(distances) + 1), self.scene.asked - self.size, self.meetings.within(distances), tried
        )
        best = int(np.argmin(found))
        return Nearness(float(found[best]), best + 1 + self.size, max(float(distances[best]), ROUNDING_REACH))

    def at_most(self, reach: float, hits: int) -> float:
        """How large the reach of so many matches may be: few of them tell it badly."""
        numbers = NUMBERS * max(hits - self.size, 1)
        return reach * max(1.0, math.exp(DEVIATIONS / math.sqrt(numbers)) / COUNTED)

    def run(self, motors: Array, tolerance: float, tried: int, chance: float | None = None) -> Standing:
        """Refine candidates (m, 8), the best first, and compare them.

        Parameters
        ----------
        motors : array (m, 8)
        tolerance : float
            At which they were found.
        tried : int
            Motors among which they were found.
        chance : float, optional
            The share of objects that wrong motors lay on others, where the best of others is challenged by motors
            that are made to be as good. Default: what those candidates do that do not serve.
        """
        motors = motors[distinct(motors, max(APART * tolerance, SAME_POSE), CONTENDERS)]
        near: list[Nearness] = []
        for motor in motors[: TRIED if chance is None else CHALLENGED]:
            near.append(self.nearness(motor, tried))
            if near[-1].doubt < BEYOND_DOUBT:
                break
        first = min(range(len(near)), key=lambda i: near[i].doubt)
        best = near[first]
        rivals, usual = self._rivals(np.roll(motors[: first + 1], 1, 0), motors[first + 1 :], best)
        for _ in range(ROUNDS):
            self.within(ROOM * self.at_most(best.reach, best.hits))
            refined, scores, _, _ = self.scene.refine(rivals, STEPS)
            refined = refined[np.argsort(-scores, kind="stable")]
            now = self.nearness(refined[0], tried)
            if now.doubt > best.doubt:
                break
            settled = best.doubt - now.doubt < GAIN
            best, rivals = now, refined
            if settled:
                break
        return self._standing(rivals, usual, best, chance)

    def _rivals(self, ahead: Array, others: Array, best: Nearness) -> tuple[Array, Array]:
        """Candidates worth refining, the leader first, and the numbers of hits of the rest."""
        motors = np.concatenate([ahead, others])
        self.within(ROOM * self.at_most(best.reach, best.hits))
        _, _, hits, _ = self.scene.refine(motors, 0)
        strong = hits >= max(RIVAL * best.hits, self.size + 1)
        strong[0] = True
        return motors[strong], hits[~strong]

    def _standing(self, motors: Array, usual: Array, best: Nearness, chance: float | None) -> Standing:
        self.within(COUNTED * self.at_most(best.reach, best.hits))
        motors, scores, hits, _ = self.scene.refine(motors, 0)
        order = np.argsort(-scores, kind="stable")
        order = order[distinct(motors[order], max(SAME * best.reach, SAME_POSE))]
        equal = hits[order] >= AS_GOOD * hits[order[0]] - 1
        order, count = np.concatenate([order[equal], order[~equal]]), int(equal.sum())
        motors, scores, hits = motors[order], scores[order], hits[order]
        apart = distinct(motors, max(APART * best.reach, SAME_POSE))
        serving, others = apart[apart < count], apart[apart >= count]
        rest = np.maximum(np.concatenate([hits[others], usual]) - self.size, 0)
        objects = self.scene.asked - self.size
        if chance is None:
            chance = float(self.meetings.within(best.reach))
            chance = max(chance, float(rest.mean()) / objects) if objects > 0 and len(rest) else chance
        next_best = int(rest.max(initial=0))
        first, last = (lead(int(h) - self.size, next_best, objects, chance) for h in (hits[0], hits[serving].min()))
        ahead = max(first, last * math.log(LEVEL) / math.log(LAST_LEVEL)) if len(serving) <= MOST_EQUAL else 0.0
        return Standing(motors, scores, hits, count, best.reach, best.doubt, ahead, chance)


def distinct(motors: Array, tolerance: float, most: int | None = None) -> Array:
    """Numbers of motors (n, 8) that are none of those before them, whatever their signs; the first so many."""
    if len(motors) <= 1:
        return np.arange(len(motors))
    kept: list[int] = []
    for begin in range(0, len(motors), AT_ONCE):
        block = motors[begin : begin + AT_ONCE]
        far = _apart(motors[kept], block, tolerance).all(0) if kept else np.ones(len(block), bool)
        masks = np.zeros((len(block) + 1, AT_ONCE), bool)  # as bits of whole numbers, for a loop without arrays
        masks[0, : len(block)], masks[1:, : len(block)] = far, _apart(block, block, tolerance)
        left, *apart = np.packbits(masks, axis=1, bitorder="little").view("<u8")[:, 0].tolist()
        while left and len(kept) != most:
            lowest = left & -left
            first = lowest.bit_length() - 1
            kept.append(begin + first)
            left &= apart[first] & ~lowest
    return np.array(kept, np.int64)


def _apart(a: Array, b: Array, tolerance: float) -> Array:
    """Which motors (n, 8) and (m, 8) are not the same, whatever their signs: (n, m)."""
    found: Array = (a * a).sum(1)[:, None] + (b * b).sum(1) - 2 * np.abs(a @ b.T) > tolerance * tolerance
    return found
