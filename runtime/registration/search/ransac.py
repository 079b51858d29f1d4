"""REFORM as in the thesis (5.5): iterative matching whose motors come from random subsets of the matches, so that it
leaves local minima. Subsets are estimated and scored by the driver, all at once.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...core.multivector import Multivector
from ..estimation.estimators import SET_SIZE, motor_to_frames
from ..result import Step
from ..verification.ranking import distinct
from ..verification.significance import log_nfa
from .global_search import POOL_SIZE
from .problem import N_VERIFIED, RegistrationProblem
from .state import MATCH_FACTOR, SearchState

Array = NDArray[Any]
#: Largest distance of the matches from which samples are drawn, in units of the models' size.
MATCH_RANGE = 16.0
#: Largest distance of an inlier.
INLIER_RANGE = 0.15
#: Largest number of rounds.
MAX_ROUNDS = 60
#: Rounds without a better motor that end the search.
MAX_ROUNDS_WITHOUT_GAIN = 12
#: The best motors of a round that are refined by iterative matching.
N_REFINED = 4
#: Iterations of that refinement.
ICP_STEPS = 5
#: Motors whose coefficients differ by less than this are one local minimum.
DISTINCT_DISTANCE = 0.1
#: Motors with less than this fraction of the best one's inliers are given up early.
EARLY_EXIT_RATIO = 0.4
#: Random numbers that are drawn at once.
BLOCK = 1 << 20
#: A better score is larger by more than this, relative to it.
SCORE_ROUNDING = 1e-9
#: A score of more than this fraction of the number of objects cannot be improved.
MAX_SCORE_RATIO = 1 - 1e-9


def ransac_search(
    problem: RegistrationProblem, samples: int, sample_size: int | None, iterations: int | None = None,
    start: Multivector | None = None,
) -> SearchState:  # fmt: skip
    """Candidates of full REFORM, from the present pose of the models, in their frames; not ranked yet.

    Parameters
    ----------
    samples : int
        Subsets of the matches in each round.
    sample_size : int, optional
        Matches of a subset, drawn without replacement. Default: three.
    iterations : int, optional
        Largest number of rounds. Default: 60; 12 without a better motor end it.
    start : Multivector, optional
        Motor that moves the query first.

    Raises
    ------
    InputError
        If a subset is larger than the number of matches.

    Notes
    -----
    Each round: match every object with its nearest; estimate the motor of least |R X - Y R|^2 of each of ``samples``
    subsets; score it by the objects that it matches (sum of 1 - square/limit up to 15 % of the models' size: outliers
    count nothing), giving up early on bad ones; refine the best by iterative matching; accept it if it is better. While
    none is, samples are drawn from the matches of the next best motors in turn.
    """
    size = SET_SIZE if sample_size is None else sample_size
    verified = problem.random.permutation(len(problem.rows))[:N_VERIFIED]
    kinds, rows = problem.kinds[verified], problem.rows[verified]
    problem.scene.select_objects(kinds, rows)
    ranking = problem.ranking(size)
    rate = float(ranking.background.probability(INLIER_RANGE))
    state = SearchState(tolerance=INLIER_RANGE / MATCH_FACTOR, ranking=ranking, accidental_rate=rate)
    motor, n_waited = motor_to_frames(start, problem.query, problem.reference), 0
    _merge(state, *_refine(problem, motor[None], 0))
    problem.best = state  # what an interrupt of the first round returns
    for _ in range(MAX_ROUNDS if iterations is None else iterations):
        samples_, images, signs = _draw_minimal_samples(problem, motor, samples, size)
        problem.accept_within(INLIER_RANGE, _early_exit_fraction(problem, state))
        motors, scores, _, _ = problem.scene.samples(kinds[samples_], rows[samples_], images, signs, math.inf)
        state.candidates += len(motors)
        best = np.argsort(-scores, kind="stable")[:N_REFINED]
        best = best[(scores[best] >= 0) & np.isfinite(motors[best]).all(1)]
        previous_best = float(state.scores[0])
        if len(best):
            _merge(state, *_refine(problem, motors[best], ICP_STEPS))
        n_waited = n_waited + 1 if state.scores[0] <= previous_best * (1 + SCORE_ROUNDING) else 0
        motor = _next_motor(state, n_waited)
        _report(problem, state, size)
        if n_waited >= MAX_ROUNDS_WITHOUT_GAIN or state.scores[0] >= MAX_SCORE_RATIO * len(verified):
            break
    return state


def _draw_minimal_samples(
    problem: RegistrationProblem, motor: Array, samples: int, size: int
) -> tuple[Array, Array, Array]:
    """Subsets (samples, size) of the matches, without replacement; rows of their counterparts, and signs."""
    problem.accept_within(MATCH_RANGE)
    indices, _, signs = problem.scene.match(motor)
    members = np.flatnonzero(indices >= 0)
    if len(members) < size:
        raise InputError(
            f"sample_size is {size}, and there are {len(members)} matches.",
            remedy="Choose a smaller one, or add objects",
        )
    step = max(1, BLOCK // len(members))
    blocks = (
        np.argsort(problem.random.random((min(step, samples - i), len(members))), axis=1)[:, :size]
        for i in range(0, samples, step)
    )
    samples_ = members[np.concatenate(list(blocks))]
    return samples_, indices[samples_], signs[samples_]


def _next_motor(state: SearchState, n_waited: int) -> Array:
    """The best motor; after rounds without a better one, the next best local minima in turn."""
    representatives = distinct(state.motors, DISTINCT_DISTANCE)
    best: Array = state.motors[representatives[n_waited % len(representatives)]]
    return best


def _early_exit_fraction(problem: RegistrationProblem, state: SearchState) -> float:
    """Fraction of inliers below which a motor is given up."""
    return EARLY_EXIT_RATIO * float(state.hits[0]) / float(problem.scene.n_selected)


def _refine(problem: RegistrationProblem, motors: Array, steps: int) -> tuple[Array, Array, Array]:
    problem.accept_within(INLIER_RANGE)
    refined, scores, hits, _ = problem.scene.refine(motors, steps)
    return refined, scores, hits


def _merge(state: SearchState, motors: Array, scores: Array, hits: Array) -> None:
    """Keep the best candidates of all rounds, the best first."""
    all_scores = np.concatenate([state.scores, scores])
    order = np.argsort(-all_scores, kind="stable")[:POOL_SIZE]
    state.motors = np.concatenate([state.motors, motors])[order]
    state.hits = np.concatenate([state.hits, hits])[order]
    state.scores = all_scores[order]


def _report(problem: RegistrationProblem, state: SearchState, size: int) -> None:
    hits = int(state.hits[0])
    objects = problem.scene.n_selected - size
    assert state.ranking is not None
    dispersion = float(state.ranking.background.dispersion(INLIER_RANGE))
    state.log_nfa = log_nfa(hits - size, objects, state.accidental_rate, max(state.candidates, 1), dispersion)
    problem.history.append(Step("sample", state.tolerance, state.candidates, hits, math.nan))
    problem.report(state)
