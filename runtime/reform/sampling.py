"""REFORM as in the thesis (5.5): iterative matching whose motors come from random subsets of the matches, so that it
leaves local minima. Subsets are estimated and scored by the driver, all at once.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..multivector import Multivector
from .chance import doubt, meetings_of
from .contest import Contest, distinct
from .estimators import SET_SIZE, inward
from .frames import closeness_within
from .job import Job
from .result import Step
from .search import KEPT, REACH, VERIFIED, Found

Array = NDArray[Any]
#: Objects are matched up to this distance, in units of the models' size; and laid on each other up to this one.
FAR, WIDE = 16.0, 0.15
#: Rounds at most, and without a better motor.
ROUNDS, PATIENCE = 60, 12
#: The best motors of a round that are refined by iterative matching, and how long.
REFINED, STEPS = 4, 5
#: Motors nearer than this, in their coefficients, are in one place.
APART = 0.1
#: Motors that do less than this share of the best one are given up early.
RIVAL = 0.4
#: Random numbers that are drawn at once.
BLOCK = 1 << 20
#: A score is better by more than rounding, and none is better than this share of all objects.
ROUNDING, ALL = 1e-9, 1 - 1e-9


def sampled(
    job: Job, samples: int, sample_size: int | None, iterations: int | None = None, start: Multivector | None = None
) -> Found:
    """The best motors of full REFORM, from where the models are.

    Parameters
    ----------
    job : Job
    samples : int
        Subsets of the matches in each round.
    sample_size : int, optional
        Matches of a subset, drawn without replacement. Default: three.
    iterations : int, optional
        Rounds at most. Default: 60; 12 without a better motor end it.
    start : Multivector, optional
        Moves the query first.

    Returns
    -------
    Found
        In the frames of the models; not compared yet.

    Raises
    ------
    InputError
        If a subset is larger than there are matches.

    Notes
    -----
    Each round: match every object with its nearest; of each of ``samples`` subsets the motor of least |R X - Y R|^2;
    score it by the objects that it lays on others (sum of 1 - square/limit up to 15 % of the models' size: outliers
    count nothing), giving up early on bad ones; refine the best by iterative matching; accept it if it is better. While
    none is, the matches of the next best motors are drawn from in turn.
    """
    size = SET_SIZE if sample_size is None else sample_size
    some = job.random.permutation(len(job.rows))[:VERIFIED]
    kinds, rows = job.kinds[some], job.rows[some]
    job.scene.ask(kinds, rows)
    meetings = meetings_of(job.scene, job.algebra, job.align, job.length)
    contest = Contest(job.scene, meetings, size, job.align, job.length)
    found = Found(tolerance=WIDE / REACH, contest=contest, chance=float(contest.meetings.within(WIDE)))
    motor, waited = inward(start, job.query, job.reference), 0
    _keep(found, *_refined(job, motor[None], found, 0))
    job.found = found  # what an interrupt of the first round returns
    for _ in range(ROUNDS if iterations is None else iterations):
        lots, images, signs = _lots(job, motor, samples, size)
        job.scene.closeness(closeness_within(WIDE, _share(job, found), job.align, job.length))
        motors, scores, _, _ = job.scene.samples(kinds[lots], rows[lots], images, signs, math.inf)
        found.candidates += len(motors)
        best = np.argsort(-scores, kind="stable")[:REFINED]
        best = best[(scores[best] >= 0) & np.isfinite(motors[best]).all(1)]
        before = float(found.scores[0])
        if len(best):
            _keep(found, *_refined(job, motors[best], found, STEPS))
        waited = waited + 1 if found.scores[0] <= before * (1 + ROUNDING) else 0
        motor = _next(found, waited)
        _tell(job, found, size)
        if waited >= PATIENCE or found.scores[0] >= ALL * len(some):
            break
    return found


def _lots(job: Job, motor: Array, samples: int, size: int) -> tuple[Array, Array, Array]:
    """Subsets (samples, size) of the asked objects, without replacement; rows of their counterparts, and signs."""
    job.scene.closeness(closeness_within(FAR, 0.0, job.align, job.length))
    indices, _, signs = job.scene.match(motor)
    members = np.flatnonzero(indices >= 0)
    if len(members) < size:
        raise InputError(
            f"sample_size is {size}, and there are {len(members)} matches.",
            remedy="Choose a smaller one, or add objects",
        )
    step = max(1, BLOCK // len(members))
    blocks = (
        np.argsort(job.random.random((min(step, samples - i), len(members))), axis=1)[:, :size]
        for i in range(0, samples, step)
    )
    lots = members[np.concatenate(list(blocks))]
    return lots, indices[lots], signs[lots]


def _next(found: Found, waited: int) -> Array:
    """The best motor; and as long as there is no better one, in turn the others that are not next to it."""
    apart = distinct(found.motors, APART)
    best: Array = found.motors[apart[waited % len(apart)]]
    return best


def _share(job: Job, found: Found) -> float:
    """Below which share of hits a motor is given up."""
    return RIVAL * float(found.hits[0]) / float(job.scene.asked)


def _refined(job: Job, motors: Array, found: Found, steps: int) -> tuple[Array, Array, Array]:
    job.scene.closeness(closeness_within(WIDE, 0.0, job.align, job.length))
    refined, scores, hits, _ = job.scene.refine(motors, steps)
    return refined, scores, hits


def _keep(found: Found, motors: Array, scores: Array, hits: Array) -> None:
    """The best of all rounds, the best first."""
    every = np.concatenate([found.scores, scores])
    order = np.argsort(-every, kind="stable")[:KEPT]
    found.motors = np.concatenate([found.motors, motors])[order]
    found.hits = np.concatenate([found.hits, hits])[order]
    found.scores = every[order]


def _tell(job: Job, found: Found, size: int) -> None:
    hits = int(found.hits[0])
    found.doubt = doubt(hits - size, job.scene.asked - size, found.chance, max(found.candidates, 1))
    job.history.append(Step("sample", found.tolerance, found.candidates, hits, math.nan))
    job.tell(found)
