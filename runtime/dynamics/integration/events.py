"""Events: conditions on the state that end a simulation, located between stored states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from types import FunctionType, MethodType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.callbacks import check_arity, one_line
from ...common.validation import as_float, as_function, as_text, as_tuple, invalid
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ...mechanics.twists import rotational_mask
from . import runs

Array = NDArray[Any]
#: Relative accuracy of the time of an event, of the interval between stored states.
TIME_RTOL = 1e-14
#: Roundings of the time below which there is no step from one to another.
LEAST_STEP = 32.0
#: Iterations of the root finder.
MAX_ITERATIONS = 100
#: Weights of central differences of order 8, which give the derivatives of an event's function, and their step: of a
#: radian, or of a body's size.
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
PART = 0.03


@dataclass(frozen=True)
class Event:
    """A condition that stops a simulation.

    Parameters
    ----------
    function : callable
        Function of ``(time, motor, twist)``, the pose and the twist in the body's frame: the event is where its value
        crosses zero. It is evaluated in the stored states; two crossings between neighbors are not detected.
    direction : {0, 1, -1}
        Crossings that count: all, rising (1) or falling (-1).
    name : str
        The trajectory's ``message``.
    """

    function: Callable[[float, Multivector, Multivector], Any]
    direction: int = 0
    name: str = "event"

    def __post_init__(self) -> None:
        as_function(self.function, "the event's function")
        check_arity(self.function, (3,), "the event's function", "a function of time, motor and twist")
        if not isinstance(self.direction, int | np.integer) or self.direction not in (-1, 0, 1):
            raise invalid(self.direction, "the event's direction", "-1, 0 or 1")
        as_text(self.name, "the event's name")

    def passes(self, before: float, after: float) -> bool:
        """True if the value crosses zero in the direction of the event."""
        rises = before < 0 <= after and self.direction >= 0
        falls = before > 0 >= after and self.direction <= 0
        return rises or falls


def as_events(value: Any) -> tuple[Event, ...]:
    """Events from one or several events or functions.

    Raises
    ------
    InputError
        If one is neither, and which.
    """
    values = as_tuple(value, "the events", (Event, FunctionType, MethodType, partial))
    needed = "an Event, or a function of time, motor and twist,"
    return tuple(
        event if isinstance(event, Event) else Event(as_function(event, f"events[{i}]", needed))
        for i, event in enumerate(values)
    )


def check_single(simulations: int, bodies: int) -> None:
    """Raise `InputError` for batches and several bodies."""
    if simulations > 1 or bodies > 1:
        raise InputError(
            f"events are for one simulation of one body; here are {simulations} of {bodies}.",
            remedy="Run them one by one, or look for the time in the trajectory",
        )


def stop_at_first_event(run: runs.Run, events: Sequence[Event]) -> Event | None:
    """End a run at the first event, its state stored last, and return the event; None if there is none.

    Raises
    ------
    InputError
        If the function of an event fails, and when. The run stays as it is.
    """
    callbacks = run.driver.assembly.callbacks
    error, callbacks.error = callbacks.error, None  # of the run behind an event, if there is one
    count = int(run.stored[0])
    crossings = [crossing for event in events if (crossing := _crossing(run, event, count)) is not None]
    if not crossings:
        callbacks.error = error
        return None
    time, index, event = min(crossings, key=lambda crossing: crossing[0])
    ending = _run_to(run, index - 1, time)
    if run.driver.tangents:
        _add_event_tangents(run, ending, event, index)
    run.times = run.times.copy()
    run.times[index] = time
    for stored, computed in (
        (run.motors, ending.motors),
        (run.twists, ending.twists),
        (run.reactions, ending.reactions),
        (run.violations, ending.violations),
        (run.tangents, ending.tangents),
    ):
        stored[0, index] = computed[0, 1]
    run.status[0], run.stored[0], run.reached[0] = runs.EVENT, index + 1, time
    return event


def _value(run: runs.Run, event: Event, time: float, motors: Array, twists: Array) -> float:
    """Value of an event's function at one state."""
    motor, twist = run.driver.assembly.to_user(0, motors[0].copy(), twists[0].copy())
    try:
        value = event.function(time, motor, twist)
    except Exception as error:  # a user's function may raise anything
        raise InputError(f"{event.name} failed at time {time:.6g}: {one_line(error).rstrip('.')}.") from error
    return as_float(value, f"{event.name} at time {time:.6g}")


def _crossing(run: runs.Run, event: Event, count: int) -> tuple[float, int, Event] | None:
    """Time, index of the next stored state and event of the first crossing."""
    before = _value(run, event, run.times[0], run.motors[0, 0], run.twists[0, 0])
    for i in range(1, count):
        after = _value(run, event, run.times[i], run.motors[0, i], run.twists[0, i])
        if event.passes(before, after):
            return _root(run, event, i, before, after), i, event
        before = after
    return None


def _root(run: runs.Run, event: Event, i: int, before: float, after: float) -> float:
    """Time of the zero between stored states i - 1 and i, by the Illinois rule."""
    low, high = float(run.times[i - 1]), float(run.times[i])
    values = [before, after]
    tolerance = TIME_RTOL * (high - low) + 4 * np.finfo(float).eps * abs(high)
    side = 0
    for _ in range(MAX_ITERATIONS):
        if high - low <= tolerance or values[1] == 0:
            break
        time = high - values[1] * (high - low) / (values[1] - values[0])
        time = min(max(time, low + tolerance / 2), high - tolerance / 2)
        state = _run_to(run, i - 1, time)
        value = _value(run, event, time, state.motors[0, 1], state.twists[0, 1])
        if (value > 0) == (values[1] > 0) or value == 0:
            high, values[1] = time, value
            values[0] = values[0] / 2 if side == 1 else values[0]
            side = 1
        else:
            low, values[0] = time, value
            values[1] = values[1] / 2 if side == -1 else values[1]
            side = -1
    return high


def _run_to(run: runs.Run, index: int, time: float) -> runs.Run:
    """New run from a stored state to a time; it stores two states."""
    begin = float(run.times[index])
    if not time - begin > LEAST_STEP * np.finfo(float).eps * max(abs(begin), abs(time)):
        return _stored_twice(run, index, time)
    part = runs.Run(
        run.driver, np.array([begin, time]), run.motors[0, index], run.twists[0, index],
        tangents=run.tangents[0, index] if run.driver.tangents else None,
    )  # fmt: skip
    part.run_until(2)
    run.driver.raise_error()
    if part.stored[0] < 2:
        raise InputError(f"the states between those stored at {begin:.6g} and after cannot be computed.")
    return part


def _stored_twice(run: runs.Run, index: int, time: float) -> runs.Run:
    """A stored state at a time so near to its own that there is no step between."""
    same = runs.Run.blank(run.driver, np.array([run.times[index], time]))
    for copied, stored in (
        (same.motors, run.motors), (same.twists, run.twists), (same.reactions, run.reactions),
        (same.violations, run.violations), (same.tangents, run.tangents),
    ):  # fmt: skip
        copied[0] = stored[0, index]
    return same


def _add_event_tangents(run: runs.Run, ending: runs.Run, event: Event, index: int) -> None:
    """Tangents of the state at an event, whose time changes with the parameters: dx + x' dt, where dg + g' dt = 0."""
    time, motors, twists = float(ending.times[1]), ending.motors[0, 1], ending.twists[0, 1]
    rates = run.driver.evaluate(time, motors, twists)["accelerations"]
    interval = float(run.times[index] - run.times[index - 1])

    def along(delta: Array, change: Array, ahead: float) -> float:
        """Derivative of the event's function where the state moves along a tangent, and the time."""
        step = PART * min(interval / ahead if ahead else np.inf, _way(run, twists, interval, delta, change))
        if not np.isfinite(step):
            return 0.0
        algebra = run.driver.assembly.algebra

        def value(e: float) -> float:
            twist = algebra.wrap(algebra.kind("twist"), e * delta)
            moved = evaluate(algebra, "mechanics.move_by_twist", algebra.wrap(algebra.kind("motor"), motors), twist)
            return _value(run, event, time + e * ahead, moved.value.values, twists + e * change)

        return sum(w * (value(k * step) - value(-k * step)) for k, w in enumerate(WEIGHTS, 1)) / step

    still = np.zeros_like(twists)
    pace = along(still, still, 1.0) + along(twists, rates, 0.0)
    for q, (delta, change) in enumerate(ending.tangents[0, 1]):
        later = -along(delta, change, 0.0) / pace
        run.event_tangents[q] = later
        ending.tangents[0, 1, q] += later * np.stack([twists, rates])


def _way(run: runs.Run, twists: Array, interval: float, delta: Array, change: Array) -> float:
    """How far one may go along a tangent until a body of one simulation is turned by a radian, moved by its own size,
    or its rates change by what they are, or by such a motion in an interval; infinite: the tangent is none."""
    body, turns = run.driver.assembly.bodies[0], rotational_mask(run.driver.assembly.algebra)
    size = float(np.sqrt(np.max(body.moments) / np.max(body.mass)))
    unit = np.where(turns, 1.0, size)
    rate = max(float(np.abs(twists / unit).max()), 1 / interval)
    fastest = max(float(np.abs(delta / unit).max()), float(np.abs(change / unit).max()) / rate)
    return 1 / fastest if fastest > 0 else np.inf
