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
#: Distances of a match at which this rate is measured, in units of the models' size.
BACKGROUND_DISTANCES = (0.25, 0.1)
#: Largest power of the distance with which the rate grows: the least number of coordinates that agree in a match. Of
#: objects that are alike, as the edges of a prism are, it is less.
MAX_BACKGROUND_POWER = 3.0
#: Up to this excess of the dispersion, which so few motors tell from none hardly, matches are taken as independent.
MIN_EXCESS = 1.0
#: Bounds of the power of the distance with which the dispersion's excess over that of independent matches grows.
DISPERSION_POWERS = (0.5, 3.0)
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
    """Rate and dispersion of accidental matches of the selected objects, measured with random motors."""

    def measured(distance: float, motors: Array) -> tuple[float, float]:
        scene.set_criterion(criterion_within(distance, 0.0, align, length))
        hits = scene.refine(motors, 0)[2]
        rate = float((hits.sum() + 1) / (len(hits) * scene.n_selected + 1))
        return rate, max(float(hits.var()) / (scene.n_selected * rate * (1 - rate)) - 1, 0.0)

    (far, near), motors = BACKGROUND_DISTANCES, random_motors(algebra)
    rate, excess = measured(far, motors)
    if excess <= MIN_EXCESS:
        return BackgroundModel(rate)
    rate_near, excess_near = measured(near, motors[: N_RANDOM_MOTORS // 2])
    if excess_near <= MIN_EXCESS:  # where half of all matches are accidental
        return BackgroundModel(rate)
    power = _power(rate, rate_near, 0.0, MAX_BACKGROUND_POWER)
    return BackgroundModel(rate, power, excess, _power(excess, excess_near, *DISPERSION_POWERS))


def _power(far: float, near: float, lowest: float, highest: float) -> float:
    """Power of the distance with which a value grows between both of `BACKGROUND_DISTANCES`, within bounds."""
    if not near > 0:
        return highest
    ratio = BACKGROUND_DISTANCES[0] / BACKGROUND_DISTANCES[1]
    return min(max(math.log(far / near) / math.log(ratio), lowest), highest)


@dataclass(frozen=True)
class BackgroundModel:
    """Accidental matches under a wrong motor.

    Parallel edges near each other, or the facets of one surface, are matched together or not at all: they are not
    independent evidence. The numbers of hits of random motors show it: their variance is greater than that of a
    binomial distribution, by a factor that is called the dispersion (design effect), and so many matches count as one.

    Attributes
    ----------
    rate : float
        Fraction of the objects with a counterpart within the first of `BACKGROUND_DISTANCES`.
    power : float
        Power of the distance that the fraction is proportional to.
    excess, excess_power : float
        The same of the dispersion's excess over one.
    """

    rate: float
    power: float = MAX_BACKGROUND_POWER
    excess: float = 0.0
    excess_power: float = DISPERSION_POWERS[1]

    @property
    def has_like_objects(self) -> bool:
        """True if objects are so much alike that their matches are not independent."""
        return self.excess > MIN_EXCESS

    def probability(self, distance: Any) -> Any:
        """Probability of an accidental match within a distance, or within each of several."""
        return self.rate * self._relative(distance) ** self.power

    def dispersion(self, distance: Any) -> Any:
        """Number of matches within a distance, or within each of several, that count as one."""
        return 1.0 + self.excess * self._relative(distance) ** self.excess_power

    @staticmethod
    def _relative(distance: Any) -> Any:
        return np.minimum(1.0, np.maximum(distance, MIN_DISTANCE) / BACKGROUND_DISTANCES[0])


def log_nfas(hits: Any, objects: int, probability: Any, motors: int, dispersion: Any = 1.0) -> Array:
    """log10 of the number of false alarms: of the wrong motors that match so many objects by chance (Chernoff's bound).

    Infinite where every motor is expected to match as many. Numbers of hits, probabilities and dispersions broadcast.
    """
    hits = np.asarray(hits, np.float64)
    probability = np.minimum(np.maximum(probability, MIN_PROBABILITY), MAX_PROBABILITY)
    if objects <= 0:
        return np.full(np.broadcast_shapes(hits.shape, probability.shape), math.inf)
    fraction = np.minimum(np.maximum(hits / objects, 0.0), 1.0)
    miss_fraction = np.maximum(1 - fraction, MIN_PROBABILITY)
    excess = fraction * np.log(np.maximum(fraction, MIN_PROBABILITY) / probability)
    excess = excess + (1 - fraction) * np.log(miss_fraction / (1 - probability))
    return np.where(
        fraction > probability, math.log10(max(motors, 1)) - objects * excess / (dispersion * math.log(10)), math.inf
    )


def log_nfa(hits: int, objects: int, probability: float, motors: int, dispersion: float = 1.0) -> float:
    """`log_nfas` of one number of hits."""
    return float(log_nfas(hits, objects, probability, motors, dispersion))


def log_gap_probability(first: int, second: int, objects: int, probability: float, dispersion: float = 1.0) -> float:
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
    dispersion : float
        Number of matches that count as one.
    """
    probability = min(max(probability, MIN_PROBABILITY), MAX_PROBABILITY)
    odds = probability / (1 - probability)
    second = max(second, math.ceil((objects * odds - TAIL_RATIO) / (TAIL_RATIO + odds)))
    ratio = (objects - second) / (second + 1) * odds
    lead = (first - second) / dispersion
    return lead * math.log10(max(ratio, MIN_PROBABILITY)) if 0 < ratio < 1 and lead > 0 else 0.0
