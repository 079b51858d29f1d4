"""Registrations from near by, held against what a search from everywhere finds: a pose that others contradict is not
believed, and those that serve as well are told.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .contest import AS_GOOD, COUNTED, ROOM, SAME, SAME_POSE, STEPS, distinct
from .estimators import inward
from .frames import closeness_within, outward
from .job import Job
from .result import Registration, Step
from .rivals import looked_again
from .search import CHANCE, TOLERANCES, Found, Search

Array = NDArray[Any]
#: Sets of query objects that vote for rivals, at each tolerance and at most.
SETS = 64
#: Why a pose is not believed.
BEATEN = "another motor, far from this one, lays more objects on others: see register(.., start='global')"


def challenged(job: Job, result: Registration) -> Registration:
    """The same pose; ``converged`` only if no other lays clearly more objects on others, equals in ``ambiguous``.

    Parameters
    ----------
    job : Job
        That of the result.
    result : Registration
        From a start near by. One that is not ``converged`` stays as it is.
    """
    if not result.converged:
        return result
    job.some()
    found = _rivals(job)
    job.history.append(Step("challenge", found.tolerance, found.candidates, int(found.hits.max(initial=0)), math.nan))
    if found.doubt > math.log10(CHANCE) and not found.rivalled:
        return result
    motor = inward(result.motor, job.query, job.reference)
    rivals, hits = _held(job, motor, found)
    if len(rivals) and hits[1:].max() * AS_GOOD - 1 > hits[0]:
        return replace(result, converged=False, message=BEATEN)
    equal = rivals[hits[1:] >= AS_GOOD * hits[0] - 1]
    world = outward(job.driver, equal, job.query, job.reference, job.algebra)
    return replace(result, ambiguous=[*result.ambiguous, *(world[i] for i in range(len(equal)))])


def _rivals(job: Job) -> Found:
    search = Search(job.scene, job.driver, job.query, job.reference, SETS, None, job.random, job.align, job.length)
    found = Found()
    for tolerance in TOLERANCES:
        found = search.run(tolerance, found)
        if found.doubt <= math.log10(CHANCE):
            break
    return looked_again(job, search, found)


def _held(job: Job, motor: Array, found: Found) -> tuple[Array, Array]:
    """Rivals (m, 8) that are other motors, and how many objects the first motor and they lay on others."""
    reach = found.reach
    job.scene.closeness(closeness_within(ROOM * reach, 0.0, job.align, job.length))
    others = job.scene.refine(found.motors, STEPS)[0]
    every = np.concatenate([motor[None], others[np.isfinite(others).all(1)]])
    kept = distinct(every, max(SAME * reach, SAME_POSE))
    job.scene.closeness(closeness_within(COUNTED * reach, 0.0, job.align, job.length))
    hits = job.scene.refine(every[kept], 0)[2]
    return every[kept][1:], hits
