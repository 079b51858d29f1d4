"""Cross-check of a registration from a nearby start against a global search: a pose that a better one contradicts has
not converged; equivalent ones are reported.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..estimation.estimators import motor_to_frames
from ..model.normalization import motors_to_world
from ..result import Registration, Step
from ..search.problem import RegistrationProblem
from ..search.state import SearchState
from .alternatives import search_globally
from .ranking import (
    EQUIVALENT_INLIER_RATIO,
    ICP_STEPS,
    INLIER_FACTOR,
    SEARCH_RADIUS_FACTOR,
    distinct,
    duplicate_distance,
)

Array = NDArray[Any]
#: Largest number of minimal sets of query objects that vote at each tolerance.
MAX_SETS = 64
#: Message of a pose that a better one contradicts.
WORSE_THAN_GLOBAL = "a global search found another pose with more inliers: see register(.., start='global')"


def cross_check_with_global_search(problem: RegistrationProblem, result: Registration) -> Registration:
    """Clear ``converged`` of a problem's result if another motor has clearly more inliers; add equivalent motors to
    ``ambiguous``. A result that has not converged is returned as it is.
    """
    if not result.converged:
        return result
    problem.verify_on_subset()
    state = search_globally(problem, MAX_SETS, is_recorded=False)
    hits = int(state.hits.max(initial=0))
    problem.history.append(Step("challenge", state.tolerance, state.candidates, hits, math.nan))
    if not state.is_significant and not state.is_ambiguous:
        return result
    motor = motor_to_frames(result.motor, problem.query, problem.reference)
    alternatives, inliers = _compare_with(problem, motor, state)
    if len(alternatives) and inliers[1:].max() * EQUIVALENT_INLIER_RATIO - 1 > inliers[0]:
        return replace(result, converged=False, message=WORSE_THAN_GLOBAL)
    equivalent = alternatives[inliers[1:] >= EQUIVALENT_INLIER_RATIO * inliers[0] - 1]
    world = motors_to_world(problem.driver, equivalent, problem.query, problem.reference, problem.algebra)
    return replace(result, ambiguous=[*result.ambiguous, *(world[i] for i in range(len(equivalent)))])


def _compare_with(problem: RegistrationProblem, motor: Array, state: SearchState) -> tuple[Array, Array]:
    """Alternatives (m, 8) of a motor among the candidates, and the numbers of inliers of the motor and of these."""
    problem.accept_within(SEARCH_RADIUS_FACTOR * state.inlier_scale)
    refined = problem.scene.refine(state.motors, ICP_STEPS)[0]
    motors = np.concatenate([motor[None], refined[np.isfinite(refined).all(1)]])
    motors = motors[distinct(motors, duplicate_distance(state.inlier_scale))]
    problem.accept_within(INLIER_FACTOR * state.inlier_scale)
    return motors[1:], problem.scene.refine(motors, 0)[2]
