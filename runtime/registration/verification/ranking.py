"""Ranking of candidate poses: inlier scale, duplicate removal, the set of equivalent poses, and a significance test of
the best pose against incompatible ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..backends.scene import Scene
from ..model.normalization import criterion_within
from .significance import MIN_DISTANCE, BackgroundModel, log_gap_probability, log_nfas

Array = NDArray[Any]
#: Largest distance of a match, in units of the models' size.
MAX_INLIER_SCALE = 0.15
#: Candidates whose inlier scale is estimated before one is chosen to begin with.
SCALE_CANDIDATES = 4
#: The same, where alternatives of the best candidate are ranked.
SCALE_ALTERNATIVES = 8
#: Largest number of rounds of refinement and estimation of the inlier scale.
MAX_ROUNDS = 3
#: Iterations of iterative matching in each round.
ICP_STEPS = 10
#: A smaller gain of the log10 of the number of false alarms ends the rounds.
MIN_LOG_NFA_GAIN = 0.5
#: A candidate below this log10 of the number of false alarms is chosen to begin with; no other one is tried.
CLEAR_LOG_NFA = -20.0
#: Matches are searched for up to this many inlier scales, so that refinement can move.
SEARCH_RADIUS_FACTOR = 2.0
#: Matches within this many inlier scales count when candidates are compared.
INLIER_FACTOR = 1.5
#: Degrees of freedom that each match contributes to the inlier scale: four of a line.
DEGREES_OF_FREEDOM = 4
#: Standard deviations of the upper confidence bound of the inlier scale.
SCALE_DEVIATIONS = 3.0
#: Candidates with a smaller fraction of the best one's inliers are not refined: they measure the background rate.
COMPETITOR_INLIER_RATIO = 0.4
#: A pose is equivalent to the best one if it has this fraction of its inliers, less one: of a symmetric model each of
#: its poses misses some objects, and not equally many.
EQUIVALENT_INLIER_RATIO = 0.85
#: Motors whose coefficients differ by less than this many inlier scales are duplicates.
DUPLICATE_FACTOR = 2.0
#: Motors whose coefficients differ by less than this are duplicates at any inlier scale.
MIN_DUPLICATE_DISTANCE = 1e-3
#: Motors whose coefficients differ by at most this many inlier scales do not contradict each other.
DISTINCT_FACTOR = 4.0
#: Motors that are compared at once: bits of an integer.
BLOCK = 64
#: Largest number of candidates.
MAX_CANDIDATES = 64
#: With more equivalent poses than this (a cube has 24) no pose is significant.
MAX_EQUIVALENT = 24
#: The best motor is significantly ahead if the probability of its lead by chance is smaller.
GAP_LEVEL = 0.01
#: The same for the last equivalent motor.
LAST_GAP_LEVEL = 0.2


@dataclass(frozen=True)
class RankingResult:
    """Result of a ranking.

    Attributes
    ----------
    motors, scores, hits : arrays (m, 8), (m,), (m,)
        Refined and without duplicates: the best, its equivalents, the others; each group in the order of scores.
    n_equivalent : int
        Size of the first two groups.
    inlier_scale : float
        Distance up to which the matches of the best motor are most significant.
    log_nfa : float
        log10 of the expected number of motors that are as good as the best one by chance.
    log_gap_probability : float
        log10 of the probability that the lead over the other group is accidental; the limit is that of `GAP_LEVEL`.
    background_rate : float
        Fraction of the objects that a wrong motor matches, from which that probability was computed.
    """

    motors: Array
    scores: Array
    hits: Array
    n_equivalent: int
    inlier_scale: float
    log_nfa: float
    log_gap_probability: float
    background_rate: float

    @property
    def is_unambiguous(self) -> bool:
        """True if all motors that contradict the best one are significantly worse."""
        return self.log_gap_probability <= math.log10(GAP_LEVEL)


@dataclass(frozen=True)
class InlierScale:
    """Distance up to which the matches of a motor are most significant, their number, and their significance."""

    log_nfa: float
    hits: int
    distance: float


@dataclass(frozen=True)
class CandidateRanking:
    """Comparison of candidate poses of one problem.

    Parameters
    ----------
    scene : Scene
    background : BackgroundModel
    size : int
        Objects of the minimal set that a candidate was made from: they match by construction.
    align, length
        See `RegistrationProblem`.
    """

    scene: Scene
    background: BackgroundModel
    size: int
    align: bool = True
    length: float = 1.0

    def accept_within(self, distance: float) -> None:
        """Match objects up to this distance in subsequent calls."""
        self.scene.set_criterion(criterion_within(distance, 0.0, self.align, self.length))

    def inlier_scale_of(self, motor: Array, n_hypotheses: int) -> InlierScale:
        """Inlier scale of a motor (8,) that was found among so many hypotheses."""
        self.accept_within(MAX_INLIER_SCALE)
        indices, squares, _ = self.scene.match(motor)
        distances = np.sqrt(np.sort(squares[indices >= 0]))[self.size :]
        if not len(distances):
            return InlierScale(math.inf, self.size, MAX_INLIER_SCALE)
        count, objects = np.arange(1, len(distances) + 1), self.scene.n_selected - self.size
        rates, dispersions = self.background.probability(distances), self.background.dispersion(distances)
        values = log_nfas(count, objects, rates, n_hypotheses, dispersions)
        best = int(np.argmin(values))
        return InlierScale(float(values[best]), best + 1 + self.size, max(float(distances[best]), MIN_DISTANCE))

    def scale_upper_bound(self, distance: float, hits: int) -> float:
        """Upper confidence bound of an inlier scale that was estimated from so many matches."""
        samples = DEGREES_OF_FREEDOM * max(hits - self.size, 1)
        return distance * max(1.0, math.exp(SCALE_DEVIATIONS / math.sqrt(samples)) / INLIER_FACTOR)

    def rank(
        self, motors: Array, tolerance: float, n_hypotheses: int, background_rate: float | None = None
    ) -> RankingResult:
        """Refine candidates and compare them.

        Parameters
        ----------
        motors : array (m, 8)
            Candidates, the best first.
        tolerance : float
            Tolerance of the search that found them.
        n_hypotheses : int
            Number of motors that the search tried.
        background_rate : float, optional
            Fraction of the objects that a wrong motor matches; it is given for alternatives of the best candidate,
            which are constructed to match. Default: that of the candidates that are not equivalent to the best.
        """
        motors = motors[distinct(motors, distinct_distance(tolerance), MAX_CANDIDATES)]
        scales: list[InlierScale] = []
        for motor in motors[: SCALE_CANDIDATES if background_rate is None else SCALE_ALTERNATIVES]:
            scales.append(self.inlier_scale_of(motor, n_hypotheses))
            if scales[-1].log_nfa < CLEAR_LOG_NFA:
                break
        first = min(range(len(scales)), key=lambda i: scales[i].log_nfa)
        best = scales[first]
        competitors, rest_hits = self._competitors(np.roll(motors[: first + 1], 1, 0), motors[first + 1 :], best)
        for _ in range(MAX_ROUNDS):
            self.accept_within(SEARCH_RADIUS_FACTOR * self.scale_upper_bound(best.distance, best.hits))
            refined, scores, _, _ = self.scene.refine(competitors, ICP_STEPS)
            refined = refined[np.argsort(-scores, kind="stable")]
            refined_scale = self.inlier_scale_of(refined[0], n_hypotheses)
            if refined_scale.log_nfa > best.log_nfa:
                break
            converged = best.log_nfa - refined_scale.log_nfa < MIN_LOG_NFA_GAIN
            best, competitors = refined_scale, refined
            if converged:
                break
        return self._result(competitors, rest_hits, best, background_rate)

    def _competitors(self, leading: Array, others: Array, best: InlierScale) -> tuple[Array, Array]:
        """Candidates that are worth refining, the leader first, and the numbers of inliers of the rest."""
        motors = np.concatenate([leading, others])
        self.accept_within(SEARCH_RADIUS_FACTOR * self.scale_upper_bound(best.distance, best.hits))
        _, _, hits, _ = self.scene.refine(motors, 0)
        strong = hits >= max(COMPETITOR_INLIER_RATIO * best.hits, self.size + 1)
        strong[0] = True
        return motors[strong], hits[~strong]

    def _result(self, motors: Array, rest_hits: Array, best: InlierScale, rate: float | None) -> RankingResult:
        self.accept_within(INLIER_FACTOR * self.scale_upper_bound(best.distance, best.hits))
        motors, scores, hits, _ = self.scene.refine(motors, 0)
        order = np.argsort(-scores, kind="stable")
        order = order[distinct(motors[order], duplicate_distance(best.distance))]
        equal = hits[order] >= EQUIVALENT_INLIER_RATIO * hits[order[0]] - 1
        order, n_equivalent = np.concatenate([order[equal], order[~equal]]), int(equal.sum())
        motors, scores, hits = motors[order], scores[order], hits[order]
        representatives = distinct(motors, distinct_distance(best.distance))
        equivalent = representatives[representatives < n_equivalent]
        others = representatives[representatives >= n_equivalent]
        rest_hits = np.maximum(np.concatenate([hits[others], rest_hits]) - self.size, 0)
        rate = self._background_rate(rest_hits, best.distance) if rate is None else rate
        dispersion = float(self.background.dispersion(best.distance))
        log_gap = self._log_gap(hits[0], hits[equivalent].min(), rest_hits, rate, dispersion)
        log_gap = log_gap if len(equivalent) <= MAX_EQUIVALENT else 0.0
        return RankingResult(motors, scores, hits, n_equivalent, best.distance, best.log_nfa, log_gap, rate)

    def _background_rate(self, rest_hits: Array, distance: float) -> float:
        """Fraction of the objects that a wrong motor matches: predicted, or measured where that is more."""
        rate, objects = float(self.background.probability(distance)), self.scene.n_selected - self.size
        return max(rate, float(rest_hits.mean()) / objects) if objects > 0 and len(rest_hits) else rate

    def _log_gap(self, best: int, last: int, rest_hits: Array, rate: float, dispersion: float) -> float:
        """log10 of the probability of the lead of the best motor, or of the last equivalent one where that is more."""
        objects, next_best = self.scene.n_selected - self.size, int(rest_hits.max(initial=0))
        leads = (int(h) - self.size for h in (best, last))
        gaps = (log_gap_probability(lead, next_best, objects, rate, dispersion) for lead in leads)
        best_gap, last_gap = gaps
        return max(best_gap, last_gap * math.log(GAP_LEVEL) / math.log(LAST_GAP_LEVEL))


def duplicate_distance(inlier_scale: float) -> float:
    """Difference of coefficients below which two motors are one pose."""
    return max(DUPLICATE_FACTOR * inlier_scale, MIN_DUPLICATE_DISTANCE)


def distinct_distance(inlier_scale: float) -> float:
    """Difference of coefficients up to which two motors do not contradict each other."""
    return max(DISTINCT_FACTOR * inlier_scale, MIN_DUPLICATE_DISTANCE)


def distinct(motors: Array, tolerance: float, max_count: int | None = None) -> Array:
    """Indices of the motors (n, 8) that differ from all earlier ones whose indices are given, up to sign."""
    if len(motors) <= 1:
        return np.arange(len(motors))
    indices: list[int] = []
    for begin in range(0, len(motors), BLOCK):
        block = motors[begin : begin + BLOCK]
        is_new = _differ(motors[indices], block, tolerance).all(0) if indices else np.ones(len(block), bool)
        masks = np.zeros((len(block) + 1, BLOCK), bool)  # as bits of integers, for a loop without arrays
        masks[0, : len(block)], masks[1:, : len(block)] = is_new, _differ(block, block, tolerance)
        remaining, *differ = np.packbits(masks, axis=1, bitorder="little").view("<u8")[:, 0].tolist()
        while remaining and len(indices) != max_count:
            lowest = remaining & -remaining
            first = lowest.bit_length() - 1
            indices.append(begin + first)
            remaining &= differ[first] & ~lowest
    return np.array(indices, np.int64)


def _differ(a: Array, b: Array, tolerance: float) -> Array:
    """Pairs of motors (n, 8) and (m, 8) that differ, up to sign, by more than a tolerance: bool (n, m)."""
    squares: Array = (a * a).sum(1)[:, None] + (b * b).sum(1) - 2 * np.abs(a @ b.T)
    return squares > tolerance * tolerance
