"""`iterate`: iterative closest objects, alternating matching and estimation (thesis 5.4)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.interrupts import keep_partial
from ...codegen.programs.registration.registration import KINDS, matched_as
from ...common.progress import ProgressOption, open_progress
from ...common.validation import as_bool, as_choice, as_int, positive_float
from ...core.multivector import Multivector
from ..estimation.estimate_rotor import METHODS, EstimationOptions, estimate_with_trimming
from ..estimation.estimators import SET_SIZE, ModelPair, Pairs, motor_to_frames
from ..estimation.objective import LOSSES, check_uncertainties
from ..model.arguments import as_length, as_motor, model_pair
from ..model.normalization import motors_to_world
from ..result import Registration, Step
from ..search.global_search import TOLERANCES
from ..search.interrupted import interrupted_result
from ..search.problem import RegistrationProblem
from ..search.state import SearchState
from ..verification.assemble_result import assemble_result
from ..verification.cross_check import cross_check_with_global_search
from .matching import ASSIGNMENTS, COSTS, MatchingRule, match_kinds

Array = NDArray[Any]
#: Default of the largest number of rounds.
ROUNDS = 50
#: Rounds of the final refinement.
FINAL_ROUNDS = 10


def iterate(
    query: Any, reference: Any, start: Multivector | ArrayLike | None = None, *, estimate: str = "direct",
    assignment: str = "one_sided", cost: str = "distance", iterations: int = ROUNDS, threshold: float | None = None,
    robust: bool = True, align: bool = True, length: float = 1.0, loss: str = "linear", threads: int | None = None,
    progress: ProgressOption = False,
) -> Registration:  # fmt: skip
    """Register a query that is near its reference: match, estimate the motor, move, until the matches stay the same.

    Parameters
    ----------
    query, reference : Model, Multivector (n,), list of Multivector, or mapping
        See `match`.
    start : Multivector or array (4, 4), optional
        Motor of cga3d or pga3d, or matrix, that moves the query before the first match. Default: the identity.
    estimate : "direct", "optimize" or "linear"
        See `estimate_rotor`.
    assignment, cost, align
        See `match`.
    iterations : int
        Largest number of rounds.
    threshold : float, optional
        Largest distance of an inlier, in the models' unit of length, as in `match`; or the median distance of the
        matches, while that is larger.
    robust : bool
        Trim matches whose distance is more than 4 times the median, if there is no threshold.
    length : float
        Length that a rotation by one radian is equivalent to, in units of the models' size.
    loss : str
        Loss of the final refinement; see `register`.
    threads : int, optional
        Number of threads. Default: the package's (`bladesmith.set_threads`). The result does not depend on it.
    progress : bool or callable
        True: a bar on standard error. A callable gets a `bladesmith.Progress` after each round, whose ``detail`` is a
        `Step`.

    Returns
    -------
    Registration
        The pose at which the matches stay the same, refined as in `register`: matches by distance, least positive cost.
        Each step "match" of ``history`` contains the largest distance of an inlier, in the models' size, the round, the
        number of inliers, and the cost of all matches. ``converged`` means that the pose is significant, and that a
        quick global search finds no clearly better one: models with many parallel lines or planes agree in part at
        many poses (5.4).

    Raises
    ------
    InputError
        If a model is empty, they have no kind in common, or an argument is invalid.
    Interrupted
        On an interrupt; its ``partial`` is the result at the motor so far.

    Notes
    -----
    Thesis 5.4, an iterative closest point algorithm for objects of any grade. It ends when a matching repeats.
    """
    query_model, reference_model = model_pair(query, reference)
    models = ModelPair(query_model, reference_model, as_length(length), threads)
    max_distance = None if threshold is None else positive_float(threshold, "threshold") / models.reference.unit
    method, cost_name = as_choice(estimate, "estimate", METHODS), as_choice(cost, "cost", COSTS)
    options = EstimationOptions(
        method, "thesis" if cost_name == "thesis" else "positive", None, as_bool(robust, "robust"), max_distance
    )
    rule = MatchingRule(
        as_choice(assignment, "assignment", ASSIGNMENTS), cost_name, as_bool(align, "align"), math.inf, threads
    )
    loss_name = as_choice(loss, "loss", LOSSES)
    check_uncertainties(query_model, reference_model)
    start_motor = None if start is None else as_motor(start, "start")
    rounds = as_int(iterations, "iterations")
    motor, history = motor_to_frames(start_motor, models.query, models.reference), list[Step]()

    def problem_at(motor: Array) -> RegistrationProblem:
        problem = RegistrationProblem(
            query_model, reference_model, threads=threads, align=rule.align, length=float(length), loss=loss_name
        )
        problem.history.extend(history)
        problem.best = _state_at(motor, models, problem)
        return problem

    with (
        open_progress(progress, "iterate", "rounds", rounds) as report,
        keep_partial(lambda: interrupted_result(problem_at(motor), query_model.counts)),
    ):
        for moved, step in _match_and_estimate(models, options, rule, motor, rounds):
            motor = moved
            history.append(step)
            report(len(history), step)
        problem = problem_at(motor)
        result = assemble_result(problem, problem.best, FINAL_ROUNDS, query_model.counts)
        return cross_check_with_global_search(problem, result)


def _state_at(motor: Array, models: ModelPair, problem: RegistrationProblem) -> SearchState:
    """State of a search whose only candidate is a motor between the models' frames."""
    world = motors_to_world(models.driver, motor[None], models.query, models.reference, models.algebra)[0]
    motor_in_frames = motor_to_frames(world, problem.query, problem.reference)
    return SearchState(
        motors=motor_in_frames[None], scores=np.zeros(1), hits=np.zeros(1, np.int32), tolerance=TOLERANCES[-1],
        candidates=len(problem.history), ranking=problem.ranking(SET_SIZE),
    )  # fmt: skip


def _match_and_estimate(
    models: ModelPair, options: EstimationOptions, rule: MatchingRule, motor: Array, rounds: int
) -> Iterator[tuple[Array, Step]]:
    """Motors (8,), each with its step, until the matches stay the same or repeat."""
    seen_states: set[bytes] = set()
    for number in range(1, rounds + 1):
        pairs, cost = _match_pairs(models, rule, motor)
        state = b"".join(a.tobytes() for a in (pairs.kinds, pairs.query, pairs.reference))
        if not len(pairs) or state in seen_states:
            break
        seen_states.add(state)
        moved, inliers, _ = estimate_with_trimming(models, pairs, options, motor)
        if not np.isfinite(moved).all():
            break
        motor = moved
        largest = math.sqrt(float(models.squares(pairs.take(inliers), motor[None]).max(initial=0)))
        yield motor, Step("match", largest, number, int(inliers.sum()), cost)


def _match_pairs(models: ModelPair, rule: MatchingRule, motor: Array) -> tuple[Pairs, float]:
    """Nearest objects of the query moved by a motor, and the cost of all matches."""
    here = models.motors(motor)
    moved = {k: (here >> x).as_kind(matched_as(k), check=False) for k, x in models.query.objects.items()}
    parts: list[tuple[Array, ...]] = []
    total = 0.0
    for kind, (indices, costs, signs) in match_kinds(moved, models.reference.objects, rule).items():
        rows = np.flatnonzero(indices >= 0)
        total += float(costs[rows].sum())
        parts.append((np.full(len(rows), KINDS.index(kind)), rows, indices[rows], signs[rows]))
    kinds, query, reference, signs = (np.concatenate(p) for p in zip(*parts, strict=True))
    return Pairs(kinds.astype(np.int32), query.astype(np.int32), reference.astype(np.int32), signs), total
