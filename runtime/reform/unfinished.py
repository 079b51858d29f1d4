"""The result of a registration that an interrupt ends: the best motor until then, told as what it is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from .finish import finish
from .job import Job
from .result import Registration
from .search import REACH

#: What `Registration.message` is.
INTERRUPTED = "interrupted"
#: Rounds of iterative matching of the best motor: who interrupts does not want to wait.
ROUNDS = 2


def unfinished(job: Job, counts: Mapping[str, int]) -> Registration:
    """The best so far, with ``converged`` False and the message "interrupted".

    Parameters
    ----------
    job : Job
    counts : mapping of kind to int
        Objects of the whole query model.

    Notes
    -----
    The best motor is laid over the reference and polished as any other, without an executor and without being held
    against others: nothing is claimed of it.
    """
    job.alone()
    found = job.found
    best = replace(found, motors=found.motors[:1], scores=found.scores[:1], hits=found.hits[:1], equal=1)
    if math.isnan(best.reach):  # no candidates were compared yet
        best.reach = REACH * best.tolerance
    result = finish(job, best, ROUNDS, counts)
    return replace(result, converged=False, message=INTERRUPTED)
