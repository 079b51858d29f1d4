"""The result of an interrupted registration: its best motor so far."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from ..result import Registration
from ..verification.assemble_result import assemble_result
from .problem import RegistrationProblem
from .state import MATCH_FACTOR

#: Value of `Registration.message` after an interrupt.
INTERRUPTED = "interrupted"
#: Rounds of iterative matching of the best motor: few, so that an interrupt ends soon.
ICP_ROUNDS = 2


def interrupted_result(problem: RegistrationProblem, counts: Mapping[str, int]) -> Registration:
    """Result of the best motor so far, with ``converged`` False and the message "interrupted".

    The best motor is refined as any other, without an executor and without a comparison with alternatives: its
    significance is not known. ``counts`` are the numbers of objects of the whole query model, by kind.
    """
    problem.disable_executor()
    state = problem.best
    best = replace(state, motors=state.motors[:1], scores=state.scores[:1], hits=state.hits[:1], n_equivalent=1)
    if math.isnan(best.inlier_scale):  # no candidates were compared yet
        best.inlier_scale = MATCH_FACTOR * best.tolerance
    result = assemble_result(problem, best, ICP_ROUNDS, counts)
    return replace(result, converged=False, message=INTERRUPTED)
