"""The result of a search: candidates refined, the pose of least cost, its covariance and its free motions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import UndeterminedError
from ...codegen.programs.registration.registration import KINDS
from ...core.multivector import Multivector
from ..estimation.gauge_freedom import NEARLY_FREE, canonical_twist_basis, describe_twists, free_motions
from ..estimation.objective import POSITION_WEIGHT
from ..estimation.refinement import RefinedPose, covariance, eigenmodes, normal_matrix
from ..model.normalization import motors_to_world, twists_to_world
from ..result import PerItem, Registration, Step
from ..search.problem import RegistrationProblem
from ..search.state import SearchState
from .ranking import SEARCH_RADIUS_FACTOR, distinct, duplicate_distance

Array = NDArray[Any]
#: Largest distance of a match, over the median distance.
MATCH_RANGE_FACTOR = 4.0
#: Smallest range of matches: rounding.
MIN_MATCH_RANGE = 1e-7
#: Largest range of matches, over the inlier scale of the search.
MAX_RANGE_GROWTH = 4.0
#: Rounds of matching, with a range that follows the distances, and refinement.
REFINEMENT_ROUNDS = 4
#: The same where weights or residuals are found again at each pose, until no coefficient of the motor changes by more
#: than this fraction of the range of matches, or than rounding.
REWEIGHTING_ROUNDS, SETTLED, MIN_CHANGE = 20, 1e-5, 1e-12
#: Lines of segments that fit at their ends are apart by at most this many times the range of matches, and at most the
#: latter, in units of the models' size: the ends of short segments say little of their lines.
LINE_RANGE_FACTOR, MAX_LINE_RANGE = 16.0, 0.5
SEGMENT = KINDS.index("segment")
#: A pose has not converged if refinement leaves a smaller fraction of the matches.
MIN_REMAINING_FRACTION = 0.7
#: Of objects that are alike, so many that more than the latter count as one match, a pose has not converged whose
#: matches are up to more than the former apart, in units of the models' size.
MAX_LIKE_RANGE, MAX_DISPERSION = 0.1, 4.0


def assemble_result(
    problem: RegistrationProblem, state: SearchState, rounds: int, counts: Mapping[str, int]
) -> Registration:
    """Result of a search, after at most ``rounds`` of iterative matching of each candidate.

    ``counts`` are the numbers of objects of the whole query model, by kind.
    """
    if not len(state.motors):
        return _empty_result(problem, counts)
    if math.isnan(state.inlier_scale):
        state.compare()
    motors = _refine(problem, state.motors[: state.n_equivalent], state.inlier_scale, rounds)
    on_subset = problem.scene.n_selected < len(problem.rows)
    problem.verify_on_all()
    if on_subset:
        motors = _refine(problem, motors, state.inlier_scale, rounds)
    best, indices, spread = _refine_pose(problem, motors[0], state.inlier_scale)
    others = motors[distinct(motors, duplicate_distance(state.inlier_scale))[1:]]
    return _result(problem, state, best, indices, spread, others, counts)


def _refine(problem: RegistrationProblem, motors: Array, inlier_scale: float, rounds: int) -> Array:
    """Candidates after iterative matching, in the order of their scores."""
    problem.accept_within(SEARCH_RADIUS_FACTOR * inlier_scale)
    refined, scores, _, _ = problem.scene.refine(motors, rounds)
    best: Array = refined[np.argsort(-scores, kind="stable")]
    return best


def _empty_result(problem: RegistrationProblem, counts: Mapping[str, int]) -> Registration:
    """Result of a search without candidates; raise if the objects leave motions free."""
    matches = {kind: np.full(n, -1) for kind, n in counts.items()}
    no_motions = twists_to_world(problem.driver, np.empty((0, 6)), problem.reference, problem.algebra)
    result = Registration(
        motor=problem.algebra.wrap(problem.algebra.kind("motor"), np.eye(8)[0]), matches=PerItem(matches),
        inliers=PerItem({k: m >= 0 for k, m in matches.items()}), cost=0.0, history=problem.history, converged=False,
        covariance=np.full((6, 6), np.nan), undetermined=no_motions,
        doubt=math.inf, center=problem.reference.center, unit=problem.reference.unit,
        message="no motion was found that matches objects of the query with objects of the reference",
    )  # fmt: skip
    for name, model in (("query", problem.query), ("reference", problem.reference)):
        twists = free_motions(eigenmodes(normal_matrix(model.data)), fraction=NEARLY_FREE)
        free = canonical_twist_basis(twists, problem.algebra)
        if len(free):
            motions = twists_to_world(problem.driver, free, model, problem.algebra)
            free_text = describe_twists(motions)
            what = f"the objects of the kinds that both models have leave free, or nearly free, {free_text}"
            remedy = "Give objects that move with them: points off the line, lines or planes of another direction"
            raise UndeterminedError(what, where=f"the {name}", remedy=remedy, motions=motions, result=result)
    return result


def _refine_pose(problem: RegistrationProblem, motor: Array, inlier_scale: float) -> tuple[RefinedPose, Array, float]:
    """Refined pose of a candidate, its matches, and their largest distance."""
    start = SEARCH_RADIUS_FACTOR * inlier_scale
    limits, before, change = dict.fromkeys((False, True), start), None, math.inf
    for _ in range(REWEIGHTING_ROUNDS if problem.is_reweighted else REFINEMENT_ROUNDS):
        indices, squares = _match(problem, motor, limits)
        is_settled = not problem.is_reweighted or change <= max(SETTLED * max(limits.values()), MIN_CHANGE)
        if before is not None and np.array_equal(indices, before) and is_settled:
            break
        pose = problem.objective(motor, indices).minimize(problem.driver, motor)
        hit, are_segments = indices >= 0, problem.kinds == SEGMENT
        for by_ends in limits:
            of_sort = hit & (are_segments == by_ends)
            spread = MATCH_RANGE_FACTOR * math.sqrt(_median(squares[of_sort])) if of_sort.any() else limits[by_ends]
            limits[by_ends] = min(max(spread, MIN_MATCH_RANGE), MAX_RANGE_GROWTH * inlier_scale)
        change = float(np.abs(pose.motor - motor).max())
        motor, before = pose.motor, indices
    return pose, indices, max(limits[by_ends] for by_ends in set((problem.kinds == SEGMENT).tolist()))


def _match(problem: RegistrationProblem, motor: Array, limits: Mapping[bool, float]) -> tuple[Array, Array]:
    """Counterparts of all query objects and weighted squares of their distances, within limits: of segments by their
    ends, of others by positions and directions.
    """
    problem.accept_within(limits[False])
    indices, squares, _ = problem.scene.match(motor)
    of_segments = np.flatnonzero(problem.kinds == SEGMENT)
    if len(of_segments):
        problem.accept_within(min(LINE_RANGE_FACTOR * limits[True], MAX_LINE_RANGE))
        ends = (side.rows["segment"] for side in problem.sides)
        rows, off = problem.scene.match_segments(problem.rows[of_segments], motor, *ends)
        squares[of_segments] = off = POSITION_WEIGHT * off
        indices[of_segments] = np.where(off <= limits[True] * limits[True], rows, -1)
        problem.accept_within(limits[False])
    return indices, squares


def _median(values: Array) -> float:
    ordered, half = np.sort(values), len(values) // 2
    return float(ordered[half] + ordered[-half - 1]) / 2


def _result(
    problem: RegistrationProblem, state: SearchState, best: RefinedPose, indices: Array, spread: float, others: Array,
    counts: Mapping[str, int],
) -> Registration:  # fmt: skip
    world = motors_to_world(
        problem.driver, np.concatenate([best.motor[None], others]), problem.query, problem.reference, problem.algebra
    )
    matches = {}
    for kind, count in counts.items():
        of_kind = problem.kinds == KINDS.index(kind)
        matches[kind] = indices[of_kind].astype(np.int64) if of_kind.any() else np.full(count, -1)
    covariance_, inflation = covariance(best, problem.driver)
    free = canonical_twist_basis(free_motions(best.rates.modes, covariance_), problem.algebra)
    to_world = np.asarray(twists_to_world(problem.driver, np.eye(6), problem.reference, problem.algebra)._data).T
    undetermined = problem.algebra.wrap(problem.algebra.kind("twist"), free @ to_world.T)
    problem.history.append(Step("polish", spread, state.candidates, int((indices >= 0).sum()), best.cost))
    message = _message(problem, state, best, undetermined, int((indices >= 0).sum()), spread)
    return Registration(
        motor=world[0], matches=PerItem(matches), inliers=PerItem({k: m >= 0 for k, m in matches.items()}),
        cost=best.cost, history=problem.history, converged=not message,
        covariance=inflation * (to_world @ covariance_ @ to_world.T),
        ambiguous=[world[i] for i in range(1, len(others) + 1)], undetermined=undetermined, doubt=state.log_nfa,
        threshold=spread * problem.reference.unit, center=problem.reference.center, unit=problem.reference.unit,
        message=message,
    )  # fmt: skip


def _message(
    problem: RegistrationProblem, state: SearchState, best: RefinedPose, undetermined: Multivector, matched: int,
    spread: float,
) -> str:  # fmt: skip
    """Reason why the result has not converged, or an empty text."""
    if matched and not best.rates.halves.any():
        return "no match counts: their weights are zero, or errors far larger than the covariances say"
    minimum = 0 if state.ranking is None else state.ranking.size  # these match by construction, and confirm nothing
    if state.is_significant:
        if matched < MIN_REMAINING_FRACTION * state.hits[0] or matched <= minimum:
            return "refinement lost inliers: too few matches, or noise comparable to the spacing of the objects"
        assert state.ranking is not None
        if spread > MAX_LIKE_RANGE and state.ranking.background.dispersion(spread) > MAX_DISPERSION:
            return "matches are as far apart as objects that are alike: the noise is comparable to their spacing"
        free = f"the matches leave free, or nearly free, {describe_twists(undetermined)}"
        return free if len(undetermined) else ""
    if problem.scene.n_selected <= minimum:
        return f"nothing confirms the pose: {minimum} objects are needed for one, and there are no more"
    if state.is_ambiguous:
        return "other poses, which contradict this one, have nearly as many inliers"
    return "the pose is not significant: as many matches are expected by chance"
