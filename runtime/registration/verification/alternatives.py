"""Search for alternative poses: motors that match the inliers of the best pose to other parts of the reference.

A search stops once a better motor would have been met at its own tolerance; noise as large as that tolerance hides
most of the equivalent motors. The matches of the best motor tell the noise: within that inlier scale, its inliers are
matched again to all parts of the reference. Where the reference repeats itself, this finds the repeats.
"""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.registration_layout import MOTOR
from ..result import Step
from ..search.global_search import ROUNDING_RESIDUAL, TOLERANCES, GlobalSearch
from ..search.problem import RegistrationProblem
from ..search.state import SearchState
from .ranking import (
    COMPETITOR_INLIER_RATIO,
    ICP_STEPS,
    INLIER_FACTOR,
    MAX_CANDIDATES,
    SEARCH_RADIUS_FACTOR,
    distinct,
    distinct_distance,
    duplicate_distance,
)

Array = NDArray[Any]
#: Rotations of a cube but the identity, in its own frame: axes (23, 3) and angles.
_SIGNS = [v for v in product((-1, 0, 1), repeat=3) if any(v)]
TURNS = [(axis, math.pi / 2) for axis in _SIGNS if np.abs(axis).sum() == 1]
TURNS += [(axis, math.pi) for axis in _SIGNS if np.abs(axis).sum() <= 2 and axis > (0, 0, 0)]
TURNS += [(axis, 2 * math.pi / 3) for axis in _SIGNS if np.abs(axis).sum() == 3]
#: Slides, in distances at which motors contradict each other.
SLIDES = np.array([-2.0, -1.0, 1.0, 2.0])
TURN_AXES, TURN_ANGLES = (np.array(x, np.float64) for x in zip(*TURNS, strict=True))
#: Maximum number of passes; repeated while the best pose changes.
MAX_PASSES = 3
#: Largest number of minimal sets of inliers: an equivalent motor shares two thirds of them.
MAX_SETS = 12
#: Largest number of motors from the sets of one combination of kinds.
MAX_SAMPLES = 1 << 15
#: Largest number of inliers by which these motors are verified.
MAX_INLIERS = 64
#: Invariants are looked up within the inlier scale, and within at most this tolerance.
MAX_TOLERANCE = 0.06


def search_globally(
    problem: RegistrationProblem, samples: int, sample_size: int | None = None, is_recorded: bool = True
) -> SearchState:
    """Candidates of a global search at rising tolerances, with alternatives of the best one.

    Its progress is reported and recorded, unless it checks another search.
    """
    search, state = GlobalSearch(problem, samples, sample_size), SearchState()
    if is_recorded:
        search.report = problem.report
    for tolerance in TOLERANCES:
        state = search.run(tolerance, state)
        if is_recorded:
            hits = int(state.hits[0]) if len(state.hits) else 0
            problem.history.append(Step("search", tolerance, state.candidates, hits, math.nan))
        if state.is_significant:
            break
    return search_alternative_poses(problem, search, state)


def search_alternative_poses(problem: RegistrationProblem, search: GlobalSearch, state: SearchState) -> SearchState:
    """Search for competing poses that explain the same inliers, and rank them with the best one.

    Skipped if the pose is not significant, or if the search was exhaustive at a tolerance larger than the noise.
    """
    if len(state.motors) and math.isnan(state.inlier_scale):
        state.compare()
    for _ in range(MAX_PASSES):
        if not state.is_significant or (state.has_converged and state.inlier_scale <= state.tolerance):
            break
        leader = state.motors[:1]
        alternatives, n_hypotheses = _alternative_poses(problem, search, state)
        state.candidates += n_hypotheses
        problem.history.append(Step("rivals", state.inlier_scale, state.candidates, int(state.hits[0]), math.nan))
        if not len(alternatives):
            break
        state.compare(alternatives)
        if not len(_without_leader(leader, state.motors[:1], state.inlier_scale)):
            break
    return state


def _alternative_poses(problem: RegistrationProblem, search: GlobalSearch, state: SearchState) -> tuple[Array, int]:
    """Refined motors (m, 8) that match the inliers elsewhere, the best first; and the number of motors tried."""
    assert state.ranking is not None
    leader, scale = state.motors[:1], state.ranking.scale_upper_bound(state.inlier_scale, int(state.hits[0]))
    inliers = _inlier_indices(problem, leader[0], scale)
    motors, n_hypotheses = _hypotheses_from_inliers(problem, search, inliers, scale)
    n_kept = MAX_CANDIDATES
    if state.ranking.background.has_like_objects:
        displaced = _displaced(problem, leader[0], scale)
        n_kept += len(displaced)
        motors, n_hypotheses = np.concatenate([motors[:MAX_CANDIDATES], displaced]), n_hypotheses + len(displaced)
    problem.verify_on_subset()
    motors = _without_leader(leader, motors, scale, n_kept)
    if not len(motors):
        return motors, n_hypotheses
    problem.accept_within(SEARCH_RADIUS_FACTOR * scale)
    refined, scores, _, _ = problem.scene.refine(motors, ICP_STEPS)
    return _without_leader(leader, refined[np.argsort(-scores, kind="stable")], scale), n_hypotheses


def _displaced(problem: RegistrationProblem, leader: Array, inlier_scale: float) -> Array:
    """Motors (m, 8) that turn the query further about the middle of the reference's objects, as a box may be turned
    that has their principal axes (of positions, and of directions), or that slide it along these.

    Models that are nearly symmetric, or nearly periodic, match nearly as well there, and no invariants need agree.
    """
    algebra, elements = problem.algebra, np.concatenate(list(problem.reference.data.elements.values()))
    middle = elements[:, :3].mean(0)
    vectors = (elements[:, :3] - middle, elements[:, 3:6])
    frames = np.linalg.eigh(np.stack([v.T @ v for v in vectors]))[1]
    turns = algebra.rotor((frames[:, None] @ TURN_AXES[:, :, None])[..., 0], TURN_ANGLES)
    to_middle = algebra.translator(middle)
    step = 2 * distinct_distance(inlier_scale)  # a motor has the halves of its translation
    slides = algebra.translator(step * SLIDES[:, None, None] * frames[:, None].swapaxes(-1, -2))
    start = algebra.wrap(algebra.kind("motor"), leader)
    moved = (to_middle * turns * ~to_middle * start, slides * start)
    return np.concatenate([np.asarray(x._data, np.float64).reshape(-1, MOTOR) for x in moved])


def _without_leader(leader: Array, motors: Array, inlier_scale: float, max_count: int | None = None) -> Array:
    """Motors without duplicates, and without those of the leader (1, 8)."""
    motors = np.concatenate([leader, motors])
    return motors[distinct(motors, duplicate_distance(inlier_scale), max_count)[1:]]


def _inlier_indices(problem: RegistrationProblem, motor: Array, inlier_scale: float) -> Array:
    """Indices of the inliers of a motor; a random subset of them where they are many."""
    problem.verify_on_all()
    problem.accept_within(INLIER_FACTOR * inlier_scale)
    indices = np.flatnonzero(problem.scene.match(motor)[0] >= 0)
    if len(indices) <= MAX_INLIERS:
        return indices
    return np.sort(problem.random.choice(indices, MAX_INLIERS, replace=False))


def _hypotheses_from_inliers(
    problem: RegistrationProblem, search: GlobalSearch, indices: Array, inlier_scale: float
) -> tuple[Array, int]:
    """Motors (m, 8) that match a good fraction of some objects, the best first; and the number of motors tried."""
    sets = search.sets.sample_from(indices, MAX_SETS)
    problem.scene.select_objects(problem.kinds[indices], problem.rows[indices])
    problem.accept_within(SEARCH_RADIUS_FACTOR * inlier_scale, COMPETITOR_INLIER_RATIO)
    min_hits = max(COMPETITOR_INLIER_RATIO * len(indices), search.sets.size + 1)
    residual = max(4 * inlier_scale * inlier_scale, ROUNDING_RESIDUAL)
    motors, scores, n_hypotheses = [np.empty((0, MOTOR))], [np.empty(0)], 0
    for samples in search.sets.samples_of(sets, min(inlier_scale, MAX_TOLERANCE)):
        hypotheses, score, hits, _ = problem.scene.samples(*(x[:MAX_SAMPLES] for x in samples), residual)
        accepted = (score > 0) & (hits >= min_hits)
        motors.append(hypotheses[accepted])
        scores.append(score[accepted])
        n_hypotheses += len(score)
    return np.concatenate(motors)[np.argsort(-np.concatenate(scores), kind="stable")], n_hypotheses
