"""From the candidates of a search to the result: refined, told apart, polished, and how well it is known."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebras import Algebra
from ..codegen.programs.reform import KINDS
from .frames import Local, outward, scaled
from .job import Job
from .polish import Polished, covariance, polish
from .result import PerItem, Registration, Step
from .search import CHANCE, KEPT, REACH, Found, closeness

Array = NDArray[Any]
#: A candidate is as good as the best if it lays so many of as many objects on others.
AS_GOOD = 0.97
#: Two motors are one if their coefficients differ by less than so many tolerances.
SAME = 6.0
#: Matches are at most this many times as far apart as the middle one, and never less than what rounding leaves.
SPREAD, LEAST_SPREAD = 4.0, 1e-7
#: Rounds of matching, with a threshold that follows the distances, and descent.
ROUNDS_OF_POLISH = 4
#: That threshold is at most so many times that of the search.
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
    job.scene.closeness(closeness(found.tolerance, 0.0, job.align, job.length))
    motors = _refined(job, _distinct(found.motors, SAME * found.tolerance), rounds)
    motors = _distinct(motors, SAME * found.tolerance)
    partly = job.scene.asked < len(job.rows)
    job.everything()
    if partly:
        motors = _refined(job, motors, rounds)
    best, indices, spread = _polished(job, motors[0], found.tolerance)
    others = _distinct(motors, SAME * max(found.tolerance, spread))[1:]
    return _result(job, found, best, indices, spread, others, counts)


def _refined(job: Job, motors: Array, rounds: int) -> Array:
    """Candidates after iterative matching: the best one, and those as good."""
    motors, scores, hits, _ = job.scene.refine(motors, rounds)
    order = np.argsort(-scores, kind="stable")
    motors, scores, hits = motors[order], scores[order], hits[order]
    good: Array = motors[(hits >= AS_GOOD * hits[0]) & (scores >= AS_GOOD * scores[0])]
    return good


def _nothing(job: Job, counts: Mapping[str, int]) -> Registration:
    """No motor lays anything on anything."""
    matches = {kind: np.full(n, -1) for kind, n in counts.items()}
    return Registration(
        motor=job.algebra.translator((0, 0, 0)), matches=PerItem(matches),
        inliers=PerItem({k: m >= 0 for k, m in matches.items()}), cost=0.0, history=job.history, converged=False,
        covariance=np.full((6, 6), np.nan), doubt=math.inf, center=job.reference.center, unit=job.reference.unit,
        message="no motion was found that lays objects of the query on objects of the reference",
    )  # fmt: skip


def _polished(job: Job, motor: Array, tolerance: float) -> tuple[Polished, Array, float]:
    """The descent from a candidate, its matches, and how far apart they may be."""
    reach = REACH * tolerance
    for _ in range(ROUNDS_OF_POLISH):
        job.scene.closeness(closeness(reach / REACH, 0.0, job.align, job.length))
        indices, squares, _ = job.scene.match(motor)
        hit = indices >= 0
        found = polish(job.scene, job.driver, motor, job.by_kind(indices))
        motor = found.motor
        spread = SPREAD * math.sqrt(float(np.median(squares[hit]))) if hit.any() else reach
        reach = min(max(spread, LEAST_SPREAD), MOST_GROWTH * REACH * tolerance)
    return found, indices, reach


def _distinct(motors: Array, tolerance: float) -> Array:
    """Each motor once, the first of those within the tolerance of each other, whatever their signs."""
    kept: list[Array] = []
    while len(motors) and len(kept) < KEPT:
        first = motors[0]
        kept.append(first)
        apart = np.minimum(np.abs(motors - first).max(1), np.abs(motors + first).max(1))
        motors = motors[apart > tolerance]
    return np.array(kept).reshape(-1, motors.shape[1])


def _result(
    job: Job, found: Found, best: Polished, indices: Array, spread: float, others: Array, counts: Mapping[str, int]
) -> Registration:
    world = outward(np.concatenate([best.motor[None], others]), job.query, job.reference, job.algebra)
    matches = {}
    for kind, count in counts.items():
        own = job.kinds == KINDS.index(kind)
        matches[kind] = indices[own].astype(np.int64) if own.any() else np.full(count, -1)
    change = _world_twists(job.reference, job.algebra)
    job.history.append(Step("polish", spread, found.candidates, int((indices >= 0).sum()), best.cost))
    return Registration(
        motor=world[0], matches=PerItem(matches), inliers=PerItem({k: m >= 0 for k, m in matches.items()}),
        cost=best.cost, history=job.history,
        converged=found.doubt <= math.log10(CHANCE) and not len(best.free),
        covariance=change @ covariance(best) @ change.T, ambiguous=[world[i] for i in range(1, len(others) + 1)],
        doubt=found.doubt, threshold=spread * job.reference.unit, center=job.reference.center, unit=job.reference.unit,
    )  # fmt: skip


def _world_twists(reference: Local, algebra: Algebra) -> Array:
    """The matrix (6, 6) that takes twists of the reference's frame to the world."""
    twists = algebra.wrap(algebra.kind("twist"), np.eye(6))
    moved = algebra.translator(reference.center) >> scaled(twists, reference.unit)
    return np.asarray(moved._data).T
