"""A second look before a pose is believed: what else the objects could be that it explains.

A search stops when a better motor would have been met, at a tolerance of its own; but noise as large as that tolerance
hides most of the motors that serve as well. How large noise is, the matches of the best motor tell: that near, the
objects which it explains are looked for in all other places. Where the reference repeats itself, they are found there.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .contest import CONTENDERS, COUNTED, RIVAL, ROOM, SAME, SAME_POSE, STEPS, distinct
from .frames import closeness_within
from .job import Job
from .result import Step
from .search import CHANCE, ROUNDING, Found, Search
from .stages import MOTOR

Array = NDArray[Any]
#: Looks, as long as another motor becomes the best.
LOOKS = 3
#: Sets of the explained objects that are looked up, at most: two thirds of them are common with a motor that serves as
#: well. Motors that they make of one kind of set; explained objects that say how good these are.
SETS, MOST, EXPLAINED = 12, 1 << 15, 64
#: Invariants are looked up within the reach of the matches, and no further than this.
WIDEST = 0.06


def looked_again(job: Job, search: Search, found: Found) -> Found:
    """What was found, held against all that the objects which it explains could be instead.

    Nothing is done for a pose that is not to be believed anyway, and for one that was searched thoroughly at a
    tolerance above noise.
    """
    if len(found.motors) and math.isnan(found.reach):
        found.compare()
    for _ in range(LOOKS):
        if found.doubt > math.log10(CHANCE) or (found.enough and found.reach <= found.tolerance):
            break
        leader = found.motors[:1]
        others, tried = _others(job, search, found)
        found.candidates += tried
        job.history.append(Step("rivals", found.reach, found.candidates, int(found.hits[0]), math.nan))
        if not len(others):
            break
        found.compare(others)
        if len(distinct(np.concatenate([leader, found.motors[:1]]), max(SAME * found.reach, SAME_POSE))) == 1:
            break
    return found


def _others(job: Job, search: Search, found: Found) -> tuple[Array, int]:
    """Motors (m, 8), refined, that lay the explained objects on others, the best first; and how many were tried."""
    assert found.contest is not None
    leader, reach = found.motors[:1], found.contest.at_most(found.reach, int(found.hits[0]))
    motors, tried = _tried(job, search, _explained(job, leader[0], reach), reach)
    job.some()
    motors = _but(leader, motors, reach, CONTENDERS)
    if not len(motors):
        return motors, tried
    job.scene.closeness(closeness_within(ROOM * reach, 0.0, job.align, job.length))
    refined, scores, _, _ = job.scene.refine(motors, STEPS)
    return _but(leader, refined[np.argsort(-scores, kind="stable")], reach), tried


def _but(leader: Array, motors: Array, reach: float, most: int | None = None) -> Array:
    """Motors that are not the leader (1, 8), each once."""
    every = np.concatenate([leader, motors])
    return every[distinct(every, max(SAME * reach, SAME_POSE), most)[1:]]


def _explained(job: Job, motor: Array, reach: float) -> Array:
    """Numbers of the objects that a motor lays on others; some of them, where they are many."""
    job.everything()
    job.scene.closeness(closeness_within(COUNTED * reach, 0.0, job.align, job.length))
    numbers = np.flatnonzero(job.scene.match(motor)[0] >= 0)
    return numbers if len(numbers) <= EXPLAINED else np.sort(job.random.choice(numbers, EXPLAINED, replace=False))


def _tried(job: Job, search: Search, numbers: Array, reach: float) -> tuple[Array, int]:
    """Motors (m, 8) that lay a good share of some objects on others, the best first; and how many were tried."""
    sets = search.sets.among(numbers, SETS)
    job.scene.ask(job.kinds[numbers], job.rows[numbers])
    job.scene.closeness(closeness_within(ROOM * reach, RIVAL, job.align, job.length))
    least, residual = max(RIVAL * len(numbers), search.sets.size + 1), max(4 * reach * reach, ROUNDING)
    motors, scores, tried = [np.empty((0, MOTOR))], [np.empty(0)], 0
    for samples in search.sets.samples_of(sets, min(reach, WIDEST)):
        made, score, hits, _ = job.scene.samples(*(x[:MOST] for x in samples), residual)
        good = (score > 0) & (hits >= least)
        motors.append(made[good])
        scores.append(score[good])
        tried += len(score)
    return np.concatenate(motors)[np.argsort(-np.concatenate(scores), kind="stable")], tried
