"""From the candidates of a search to the result: refined, told apart, polished, and how well it is known."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import UndeterminedError
from ..codegen.programs.reform import KINDS
from ..multivector import Multivector
from .contest import ROOM, SAME, SAME_POSE, distinct
from .frames import closeness_within, outward, outward_twists
from .freedom import NEARLY_FREE, free_motions, in_words, told
from .job import Job
from .polish import Polished, covariance, modes_of, polish, stiffness
from .result import PerItem, Registration, Step
from .search import CHANCE, Found

Array = NDArray[Any]
#: Matches are at most this many times as far apart as the middle one, and never less than what rounding leaves.
SPREAD, LEAST_SPREAD = 4.0, 1e-7
#: Rounds of matching, with a threshold that follows the distances, and descent.
ROUNDS_OF_POLISH = 4
#: A pose is doubtful if the descent leaves less than this share of the matches.
LEFT = 0.7
#: That threshold is at most so many times the reach of the search.
MOST_GROWTH = 4.0


def finish(job: Job, found: Found, rounds: int, counts: Mapping[str, int]) -> Registration:
    """The result of a search.

    Parameters
    ----------
    job : Job
    found : Found
    rounds : int
        Of iterative matching of each candidate, at most.
    counts : mapping of kind to int
        Objects of the whole query model.
    """
    if not len(found.motors):
        return _nothing(job, counts)
    if math.isnan(found.reach):
        found.compare()
    motors = _refined(job, found.motors[: found.equal], found.reach, rounds)
    partly = job.scene.asked < len(job.rows)
    job.everything()
    if partly:
        motors = _refined(job, motors, found.reach, rounds)
    best, indices, spread = _polished(job, motors[0], found.reach)
    others = motors[distinct(motors, max(SAME * found.reach, SAME_POSE))[1:]]
    return _result(job, found, best, indices, spread, others, counts)


def _refined(job: Job, motors: Array, reach: float, rounds: int) -> Array:
    """Candidates after iterative matching, in their order unless another becomes better."""
    job.scene.closeness(closeness_within(ROOM * reach, 0.0, job.align, job.length))
    refined, scores, _, _ = job.scene.refine(motors, rounds)
    best: Array = refined[np.argsort(-scores, kind="stable")]
    return best


def _nothing(job: Job, counts: Mapping[str, int]) -> Registration:
    """No motor lays anything on anything."""
    matches = {kind: np.full(n, -1) for kind, n in counts.items()}
    nothing = outward_twists(job.driver, np.empty((0, 6)), job.reference, job.algebra)
    result = Registration(
        motor=job.algebra.wrap(job.algebra.kind("motor"), np.eye(8)[0]), matches=PerItem(matches),
        inliers=PerItem({k: m >= 0 for k, m in matches.items()}), cost=0.0, history=job.history, converged=False,
        covariance=np.full((6, 6), np.nan), undetermined=nothing,
        doubt=math.inf, center=job.reference.center, unit=job.reference.unit,
        message="no motion was found that lays objects of the query on objects of the reference",
    )  # fmt: skip
    for name, model in (("query", job.query), ("reference", job.reference)):
        free = told(free_motions(modes_of(stiffness(model.side)), least=NEARLY_FREE), job.algebra)
        if len(free):
            motions = outward_twists(job.driver, free, model, job.algebra)
            what = f"the objects of the kinds that both models have leave free, or nearly free, {in_words(motions)}"
            remedy = "Give objects that move with them: points off the line, lines or planes of another direction"
            raise UndeterminedError(what, where=f"the {name}", remedy=remedy, motions=motions, result=result)
    return result


def _polished(job: Job, motor: Array, reach: float) -> tuple[Polished, Array, float]:
    """The descent from a candidate, its matches, and how far apart they may be."""
    limit, before = ROOM * reach, None
    for _ in range(ROUNDS_OF_POLISH):
        job.scene.closeness(closeness_within(limit, 0.0, job.align, job.length))
        indices, squares, _ = job.scene.match(motor)
        if before is not None and np.array_equal(indices, before):
            break
        found = polish(job.scene, job.driver, motor, job.by_kind(indices))
        hit = indices >= 0
        spread = SPREAD * math.sqrt(_median(squares[hit])) if hit.any() else limit
        motor, before = found.motor, indices
        limit = min(max(spread, LEAST_SPREAD), MOST_GROWTH * reach)
    return found, indices, limit


def _median(values: Array) -> float:
    ordered, half = np.sort(values), len(values) // 2
    return float(ordered[half] + ordered[-half - 1]) / 2


def _result(
    job: Job, found: Found, best: Polished, indices: Array, spread: float, others: Array, counts: Mapping[str, int]
) -> Registration:
    world = outward(job.driver, np.concatenate([best.motor[None], others]), job.query, job.reference, job.algebra)
    matches = {}
    for kind, count in counts.items():
        own = job.kinds == KINDS.index(kind)
        matches[kind] = indices[own].astype(np.int64) if own.any() else np.full(count, -1)
    inside, wider = covariance(best)
    free = told(free_motions(best.rates.modes, inside), job.algebra)
    change = np.asarray(outward_twists(job.driver, np.eye(6), job.reference, job.algebra)._data).T
    undetermined = job.algebra.wrap(job.algebra.kind("twist"), free @ change.T)
    job.history.append(Step("polish", spread, found.candidates, int((indices >= 0).sum()), best.cost))
    message = _message(job, found, undetermined, int((indices >= 0).sum()))
    return Registration(
        motor=world[0], matches=PerItem(matches), inliers=PerItem({k: m >= 0 for k, m in matches.items()}),
        cost=best.cost, history=job.history, converged=not message, covariance=wider * (change @ inside @ change.T),
        ambiguous=[world[i] for i in range(1, len(others) + 1)], undetermined=undetermined, doubt=found.doubt,
        threshold=spread * job.reference.unit, center=job.reference.center, unit=job.reference.unit, message=message,
    )  # fmt: skip


def _message(job: Job, found: Found, undetermined: Multivector, matched: int) -> str:
    """Why the result is not to be relied on; empty if it is."""
    if found.doubt <= math.log10(CHANCE):
        if matched < LEFT * found.hits[0]:
            return "the descent lost matches: they are few, or noise is as large as what tells objects apart"
        free = f"the matches leave free, or nearly free, {in_words(undetermined)}"
        return free if len(undetermined) else ""
    if found.contest is not None and job.scene.asked <= found.contest.size:
        return f"nothing confirms the pose: {found.contest.size} objects are needed for one, and there are no more"
    if found.rivalled:
        return "other motors, which contradict this one, lay nearly as many objects on others"
    return "chance would lay as many objects on others: there are too few, or they are too far off"
