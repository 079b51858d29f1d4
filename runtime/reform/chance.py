"""What chance alone can do: how often wrong motors lay objects on others, and how many would do as well as the best
(a-contrario reasoning: Desolneux, Moisan and Morel). No answer is believed that chance explains.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebras import Algebra
from .engine import Scene
from .frames import closeness_within

Array = NDArray[Any]
#: Random motors by which it is measured how often objects meet by chance, and at which distance (in units of the
#: models' size); how many numbers must agree when two objects meet, at least. Shifts are small: wrong motors of a
#: search lay models over each other.
RANDOM_MOTORS, CHANCE_REACH, CHANCE_POWER, SHIFT = 64, 0.25, 3, 0.3
#: Smallest and largest probability that is reckoned with.
LEAST_CHANCE, MOST_CHANCE = 1e-300, 1 - 1e-12
#: Distances are known no better than this: rounding.
ROUNDING_REACH = 1e-7


@cache
def random_motors(algebra: Algebra) -> Array:
    """Motors (n, 8) that have nothing to do with any model: rotations of all angles, and shifts."""
    random = np.random.default_rng(0)
    axes, angles = random.normal(size=(RANDOM_MOTORS, 3)), random.uniform(0, math.pi, RANDOM_MOTORS)
    motors = algebra.translator(SHIFT * random.normal(size=(RANDOM_MOTORS, 3))) * algebra.rotor(axes, angles)
    return np.ascontiguousarray(motors._data, np.float64)


def meetings_of(scene: Scene, algebra: Algebra, align: bool, length: float) -> Meetings:
    """How often the objects that are asked meet under random motors."""
    scene.closeness(closeness_within(CHANCE_REACH, 0.0, align, length))
    hits = scene.refine(random_motors(algebra), 0)[2]
    return Meetings(float((hits.sum() + 1) / (len(hits) * scene.asked + 1)))


@dataclass(frozen=True)
class Meetings:
    """How often objects meet under a wrong motor.

    Attributes
    ----------
    rate : float
        The share of them with a counterpart within `CHANCE_REACH`.
    """

    rate: float

    def within(self, reach: Any) -> Any:
        """The probability of a counterpart within a reach, or within each of many."""
        return self.rate * np.minimum(1.0, np.maximum(reach, ROUNDING_REACH) / CHANCE_REACH) ** CHANCE_POWER


def doubts(hits: Any, objects: int, chance: Any, motors: int) -> Array:
    """log10 of how many of so many wrong motors lay so many objects on others by chance, at most (Chernoff's bound).

    Infinite where as many as that are expected of any motor. Numbers of hits and probabilities broadcast.
    """
    hits, chance = np.asarray(hits, np.float64), np.minimum(np.maximum(chance, LEAST_CHANCE), MOST_CHANCE)
    if objects <= 0:
        return np.full(np.broadcast_shapes(hits.shape, chance.shape), math.inf)
    share = np.minimum(np.maximum(hits / objects, 0.0), 1.0)
    missed = np.maximum(1 - share, LEAST_CHANCE)
    excess = share * np.log(np.maximum(share, LEAST_CHANCE) / chance) + (1 - share) * np.log(missed / (1 - chance))
    return np.where(share > chance, math.log10(max(motors, 1)) - objects * excess / math.log(10), math.inf)


def doubt(hits: int, objects: int, chance: float, motors: int) -> float:
    """`doubts` of one number of hits."""
    return float(doubts(hits, objects, chance, motors))


def lead(first: int, second: int, objects: int, chance: float) -> float:
    """log10 of the probability that the best of many wrong motors is so far ahead of the next one, both by chance.

    Beyond what is usual, one hit more is rarer by about the same factor each time: that of a binomial distribution
    at the second best. So is a lead of the greatest of many such numbers. An estimate, to a factor of 3 or so.

    Parameters
    ----------
    first, second : int
        Objects that the best motor and its best rival lay on others, without those that they were made from.
    objects : int
        Objects in all, without those.
    chance : float
        The share that wrong motors lay on others.
    """
    chance = min(max(chance, LEAST_CHANCE), MOST_CHANCE)
    rarer = (objects - second) / (second + 1) * chance / (1 - chance)
    return (first - second) * math.log10(max(rarer, LEAST_CHANCE)) if 0 < rarer < 1 and first > second else 0.0
