"""Termination of runs: with all states, by an interrupt, or by an error, reported with the states until then."""

from __future__ import annotations

import numpy as np

from ...codegen.errors import SimulationError
from ...common.progress import Report
from . import runs
from .initial_conditions import contradiction


def finish(run: runs.Run, report: Report) -> str:
    """Run the integration to its end; return an empty string, or the reason for early termination."""
    try:
        while run.advance(len(run.times)):
            report(run.time_reached)
        report(run.time_reached)
        error = run.driver.assembly.callbacks.error
        if error is not None and not isinstance(error, Exception):  # an interrupt while a user's function ran
            run.driver.assembly.callbacks.error = None
            run.status[run.status == runs.USER_FAILED] = runs.STOPPED
            raise error
    except KeyboardInterrupt:
        run.stop()
        raise
    return message_of(run) if error is None else str(error)


_REASONS = {
    runs.NOT_FINITE: ("the state is no longer finite", "Take a smaller step, or integrator='adaptive'"),
    runs.UNDERFLOW: ("steps became too small to go on", "Allow a larger rtol, or look for what is singular there"),
    runs.RANK_CHANGED: ("the rank of the constraints changed: the mechanism is singular there", None),
    runs.USER_FAILED: ("a function failed", None),
    runs.NOT_SOLVED: ("the implicit step was not solved", "Take a smaller step"),
    runs.STALLED: (
        "the steps have become so small that the run would not end, and the bodies hardly move",
        "Give atol, the error in radians that is allowed, or a larger rtol; integrator='implicit' where springs or "
        "dampers are stiff; or integrator='rk4' with a step. Functions with jumps cause this too",
    ),
    runs.MEETING: (
        "the ends of a spring meet, where its direction jumps and the motion has no series",
        "Use integrator='adaptive'",
    ),
    runs.VIOLATED: (
        "",
        "Check that the prescribed paths are compatible; if they are, take a smaller step",
    ),  # see `contradiction`
}


def message_of(run: runs.Run) -> str:
    """Reason and time of early termination; of several simulations, those of the first one."""
    if run.driver.size == 1 and run.status.item(0) == runs.OK or not run.status.any():
        return ""
    failed = np.flatnonzero(np.isin(run.status, list(_REASONS)))
    if not len(failed):
        return ""
    first = int(failed[0])
    return _reason(run, first) + ("" if len(run.status) == 1 else f", simulation {first}")


def _reason(run: runs.Run, item: int) -> str:
    """Reason and time of early termination of one simulation."""
    status = int(run.status[item])
    what = _REASONS[status][0]
    if status == runs.VIOLATED:
        is_tree = not run.driver.assembly.driver_constraints
        what = "a loop of joints does not close any more" if is_tree else contradiction(run, item)
    return f"{what}, at time {run.reached[item]:.6g}"


def raise_ending(run: runs.Run, trajectory: object) -> None:
    """Raise the error that ended a simulation early, the first of a batch."""
    error = run.driver.assembly.callbacks.error
    run.driver.assembly.callbacks.error = None
    if error is not None and not isinstance(error, SimulationError):
        failure = SimulationError(str(error), trajectory=trajectory) if isinstance(error, Exception) else error
        raise failure from error
    failed = np.flatnonzero(np.isin(run.status, list(_REASONS)))
    if len(failed):
        remedy = _REASONS[int(run.status[failed[0]])][1]
        raise SimulationError(f"{message_of(run)}.", remedy=remedy, trajectory=trajectory)
