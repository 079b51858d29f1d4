"""Significance of a pose: the rate of accidental matches, and the number of false alarms (a-contrario reasoning:
Desolneux, Moisan and Morel). A pose that as many accidental matches would explain is not significant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Algebra
from ..backends.scene import Scene
from ..model.normalization import criterion_within

Array = NDArray[Any]
#: Number of random motors that measure the rate of accidental matches.
N_RANDOM_MOTORS = 64
#: Distance of a match at which this rate is measured, in units of the models' size.
BACKGROUND_DISTANCE = 0.25
#: Power of the distance with which the rate grows: the least number of coordinates that agree in a match.
BACKGROUND_POWER = 3
#: Standard deviation of the random translations: small, because wrong motors of a search let the models overlap.
BACKGROUND_SHIFT = 0.3
#: Smallest probability; its logarithm is finite.
MIN_PROBABILITY = 1e-300
#: Largest probability.
MAX_PROBABILITY = 1 - 1e-12
#: Ratio of the probabilities of one more hit and of none, in the tail of the numbers of hits of wrong motors.
TAIL_RATIO = 0.5
#: Smallest distance of a match: rounding.
MIN_DISTANCE = 1e-7


@cache
def random_motors(algebra: Algebra) -> Array:
    """Motors (n, 8) that are independent of any model: rotations by all angles, and translations."""
    random = np.random.default_rng(0)
    axes, angles = random.normal(size=(N_RANDOM_MOTORS, 3)), random.uniform(0, math.pi, N_RANDOM_MOTORS)
    translators = algebra.translator(BACKGROUND_SHIFT * random.normal(size=(N_RANDOM_MOTORS, 3)))
    motors = translators * algebra.rotor(axes, angles)
    return np.ascontiguousarray(motors._data, np.float64)


def estimate_background(scene: Scene, algebra: Algebra, align: bool, length: float) -> BackgroundModel:
    """Rate of accidental matches of the selected objects, measured with random motors."""
    scene.set_criterion(criterion_within(BACKGROUND_DISTANCE, 0.0, align, length))
    hits = scene.refine(random_motors(algebra), 0)[2]
    return BackgroundModel(float((hits.sum() + 1) / (len(hits) * scene.n_selected + 1)))


@dataclass(frozen=True)
class BackgroundModel:
    """Rate of accidental matches under a wrong motor.

    Attributes
    ----------
    rate : float
        Fraction of the objects with a counterpart within `BACKGROUND_DISTANCE`.
    """

    rate: float

    def probability(self, distance: Any) -> Any:
        """Probability of an accidental match within a distance, or within each of several."""
        return self.rate * np.minimum(1.0, np.maximum(distance, MIN_DISTANCE) / BACKGROUND_DISTANCE) ** BACKGROUND_POWER


def log_nfas(hits: Any, objects: int, probability: Any, motors: int) -> Array:
    """log10 of the number of false alarms: of the wrong motors that match so many objects by chance (Chernoff's bound).

    Infinite where every motor is expected to match as many. Numbers of hits and probabilities broadcast.
    """
    hits = np.asarray(hits, np.float64)
    probability = np.minimum(np.maximum(probability, MIN_PROBABILITY), MAX_PROBABILITY)
    if objects <= 0:
        return np.full(np.broadcast_shapes(hits.shape, probability.shape), math.inf)
    fraction = np.minimum(np.maximum(hits / objects, 0.0), 1.0)
    miss_fraction = np.maximum(1 - fraction, MIN_PROBABILITY)
    excess = fraction * np.log(np.maximum(fraction, MIN_PROBABILITY) / probability)
    excess = excess + (1 - fraction) * np.log(miss_fraction / (1 - probability))
    return np.where(fraction > probability, math.log10(max(motors, 1)) - objects * excess / math.log(10), math.inf)


def log_nfa(hits: int, objects: int, probability: float, motors: int) -> float:
    """`log_nfas` of one number of hits."""
    return float(log_nfas(hits, objects, probability, motors))


def log_gap_probability(first: int, second: int, objects: int, probability: float) -> float:
    """log10 of the probability that the best of many wrong motors leads the next one by so many matches.

    In the tail of a binomial distribution each further hit is rarer by about the same factor, which is taken at the
    second best; the same holds for the lead of the greatest of many such numbers. Accurate to a factor of about 3.
    Where fewer hits than usual are known of competitors, or none are, the tail begins where it falls by `TAIL_RATIO`.

    Parameters
    ----------
    first, second : int
        Matches of the best motor and of its best competitor, without those of the minimal set.
    objects : int
        Number of objects, without those of the minimal set.
    probability : float
        Fraction of the objects that wrong motors match.
    """
    probability = min(max(probability, MIN_PROBABILITY), MAX_PROBABILITY)
    odds = probability / (1 - probability)
    second = max(second, math.ceil((objects * odds - TAIL_RATIO) / (TAIL_RATIO + odds)))
    ratio = (objects - second) / (second + 1) * odds
    return (first - second) * math.log10(max(ratio, MIN_PROBABILITY)) if 0 < ratio < 1 and first > second else 0.0
