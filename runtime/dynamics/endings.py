"""How runs end: with all states, by an interrupt, or by what went wrong, told with the states until then."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..codegen.errors import SimulationError
from . import engine
from .progress import Tell, told
from .starts import contradiction

if TYPE_CHECKING:
    from .trajectory import Trajectory


def finish(run: engine.Run, progress: bool | Tell | None, duration: float) -> str:
    """All states, or those until an interrupt: then why."""
    with told(progress, duration) as tell:
        try:
            while run.go_on(len(run.times)):
                tell(float(run.reached.min()))
            tell(float(run.reached.min()))
            error = run.driver.made.called.error
            if error is not None and not isinstance(error, Exception):  # it came while a user's function ran
                run.driver.made.called.error = None
                run.status[run.status == engine.USER_FAILED] = engine.STOPPED
                raise error
        except KeyboardInterrupt:
            run.stop()
            return "interrupted"
    return message_of(run) if error is None else str(error)


_REASONS = {
    engine.NOT_FINITE: ("the state is no longer finite", "Take a smaller step, or integrator='adaptive'"),
    engine.UNDERFLOW: ("steps became too small to go on", "Allow a larger rtol, or look for what is singular there"),
    engine.RANK_CHANGED: ("the rank of the constraints changed: the mechanism is singular there", None),
    engine.USER_FAILED: ("a function failed", None),
    engine.NOT_SOLVED: ("the implicit step was not solved", "Take a smaller step"),
    engine.VIOLATED: ("", "Mend the paths; if they agree, take a smaller step"),  # it says itself which and how much
}


def message_of(run: engine.Run) -> str:
    """What ended a simulation before its time, and when: of several the first that did."""
    if not run.status.any():
        return ""
    ended = np.flatnonzero(np.isin(run.status, list(_REASONS)))
    if not len(ended):
        return ""
    first = int(ended[0])
    return _ended(run, first) + ("" if len(run.status) == 1 else f", simulation {first}")


def _ended(run: engine.Run, item: int) -> str:
    status = int(run.status[item])
    what = contradiction(run, item) if status == engine.VIOLATED else _REASONS[status][0]
    return f"{what}, at time {run.reached[item]:.6g}"


def raise_ending(run: engine.Run, found: Trajectory) -> None:
    """Raise what ended a single simulation before its time."""
    error = run.driver.made.called.error
    run.driver.made.called.error = None
    if error is not None and not isinstance(error, SimulationError):
        told_error = SimulationError(str(error), trajectory=found) if isinstance(error, Exception) else error
        raise told_error from error
    status = int(run.status[0])
    if status in _REASONS:
        raise SimulationError(f"{_ended(run, 0)}.", remedy=_REASONS[status][1], trajectory=found)
