"""The global start: minimal sets of query objects (pairs or triples) vote, by their invariants, for motors, which are
verified by the number of objects that they match (compare RANSAC and geometric hashing).

Tolerances rise from rounding to a few hundredths of a model's size until a pose is significant.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from ..verification.ranking import distinct, distinct_distance
from ..verification.significance import log_nfa
from .hypotheses import HypothesisBatch
from .problem import RegistrationProblem
from .query_sets import QuerySets
from .state import MATCH_FACTOR, SearchState

#: Tolerances of invariants, in units of the models' size, in the order in which they are tried: exact models first.
TOLERANCES = (1e-6, 1e-3, 1e-2, 3e-2)
#: Largest number of table entries that one call of the driver looks up.
MAX_PAIRS_PER_CALL = 1 << 19
#: Number of hypotheses of the first call.
FIRST_HYPOTHESES = 256
#: Largest number of hypotheses of a call.
MAX_HYPOTHESES_PER_CALL = 1 << 16
#: Largest number of hypotheses at one tolerance.
MAX_HYPOTHESES = 1 << 20
#: Number of minimal sets of the first call.
FIRST_SETS = 16
#: Rounding error of the quadratic form of a sample's motor.
ROUNDING_RESIDUAL = 1e-13
#: Number of candidates that are kept for refinement.
POOL_SIZE = 64
#: Duplicates are searched for among this many times as many candidates.
POOL_FACTOR = 16
#: A motor is given up early if a smaller fraction of the first objects is matched.
MIN_INLIER_FRACTION = 0.1
#: Probability that a better motor, or an equivalent one, has been missed when the search stops.
MISS_PROBABILITY = 1e-4
#: Fraction of the correct sets whose invariants stay within a tolerance that is larger than the noise.
NOISE_PASS_RATE = 0.4


class GlobalSearch:
    """A global search over motors, one tolerance at a time.

    Parameters
    ----------
    problem : RegistrationProblem
    samples, sample_size
        See `QuerySets`.

    Raises
    ------
    InputError
        If the query has no sets of that size, or they determine no motor where sets of another size do.

    Attributes
    ----------
    report : callable
        Function that gets the state at this tolerance after each block of motors.
    """

    def __init__(self, problem: RegistrationProblem, samples: int, sample_size: int | None) -> None:
        self.problem = problem
        self.report: Callable[[SearchState], None] = lambda state: None
        self.sets = QuerySets(problem, samples, sample_size)
        self._ranking = problem.ranking(self.sets.size)

    # -- one tolerance --

    def run(self, tolerance: float, previous: SearchState) -> SearchState:
        """Search at this tolerance; return the better one of the new state and the previous one."""
        max_distance = MATCH_FACTOR * tolerance
        self.problem.accept_within(max_distance, MIN_INLIER_FRACTION)
        state = SearchState(tolerance=tolerance, candidates=previous.candidates, ranking=self._ranking)
        n_inliers = n_tested = 0
        state.accidental_rate = float(self._ranking.background.probability(max_distance))
        residual = max(4 * (tolerance * MATCH_FACTOR) ** 2, ROUNDING_RESIDUAL)
        for sets, batch in self._blocks(tolerance, residual):
            n_inliers, n_tested = n_inliers + batch.n_inliers, n_tested + batch.n_tested
            state.candidates += batch.count
            state.sets += sets
            self._keep(state, batch)
            state.accidental_rate = max(state.accidental_rate, n_inliers / n_tested if n_tested else 0.0)
            state.log_nfa = self._log_nfa(state)
            self.report(state)
            state.has_converged = self._has_converged(state, state.sets)
            if state.has_converged:
                break
        else:  # sets without an image count too, where all the others were used
            used_all = state.sets == self.sets.n_matchable
            state.has_converged = used_all and self._has_converged(state, len(self.sets.members))
        if state.is_significant:
            state.compare()
        if state.log_nfa < previous.log_nfa or not len(previous.scores):
            return state
        previous.candidates = state.candidates
        return previous

    def _keep(self, state: SearchState, batch: HypothesisBatch) -> None:
        scores = np.concatenate([state.scores, batch.scores])
        motors, hits = np.concatenate([state.motors, batch.motors]), np.concatenate([state.hits, batch.hits])
        best = np.argsort(-scores, kind="stable")
        if len(best) > 2 * POOL_SIZE:  # duplicates of one pose would leave no room for its competitors
            best = best[: POOL_FACTOR * POOL_SIZE]
            best = best[distinct(motors[best], distinct_distance(state.tolerance), 2 * POOL_SIZE)]
        state.motors, state.scores, state.hits = motors[best], scores[best], hits[best]

    def _log_nfa(self, state: SearchState) -> float:
        if not len(state.scores):
            return math.inf
        hits, objects = int(state.hits[0]) - self.sets.size, self.problem.scene.n_selected - self.sets.size
        dispersion = float(self._ranking.background.dispersion(MATCH_FACTOR * state.tolerance))
        return log_nfa(hits, objects, state.accidental_rate, max(state.candidates, 1), dispersion)

    def _has_converged(self, state: SearchState, sets: int) -> bool:
        """True if the best motor is significant, and so many sets would have met a better one."""
        if not state.is_significant:
            return False
        success = (state.hits[0] / self.problem.scene.n_selected * self.sets.table_fraction) ** self.sets.size
        success *= 1.0 if state.tolerance <= TOLERANCES[0] else NOISE_PASS_RATE
        return bool(sets * math.log(max(1 - success, 1e-300)) <= math.log(MISS_PROBABILITY))

    def _blocks(self, tolerance: float, residual: float) -> Iterator[tuple[int, HypothesisBatch]]:
        """Yield the numbers of sets and their hypotheses: few sets first, because a few often suffice."""
        expected = self.sets.order_by_ambiguity(tolerance)
        done = total = 0
        fraction = 1.0  # of the expected hypotheses: a table is sorted by one invariant, and four must agree
        while done < len(expected) and total < MAX_HYPOTHESES:
            few = min(min(max(total, FIRST_HYPOTHESES), MAX_HYPOTHESES_PER_CALL) / fraction, MAX_PAIRS_PER_CALL)
            within = np.searchsorted(np.cumsum(expected[done:]), few)
            end = done + min(max(int(within), 1), max(done, FIRST_SETS))
            end, batch = self.sets.evaluate(done, end, tolerance, residual)
            total += batch.count
            yield end - done, batch
            done = end
            fraction = min(1.0, (total + 1) / max(1, expected[:done].sum()))
