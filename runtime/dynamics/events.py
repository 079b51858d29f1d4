"""Events: conditions on the state that end a simulation, found between stored states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from types import FunctionType, MethodType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, SimulationError
from ..multivector import Multivector
from . import engine
from .functions import reason, takes
from .given import finite, several, shown

if TYPE_CHECKING:
    from .trajectory import Trajectory

Array = NDArray[Any]
#: The time of an event is told to this share of the interval between stored states.
PRECISION = 1e-14
MOST_ROUNDS = 100


@dataclass(frozen=True)
class Event:
    """A condition that stops a simulation.

    Parameters
    ----------
    function : callable
        Of ``(time, motor, twist)``, the pose and the twist in the body's frame: the event comes where its value passes
        zero. It is looked at in the stored states; two passes between neighbours are not seen.
    direction : {0, 1, -1}
        Only where the value rises (1) or falls (-1).
    name : str
        What the trajectory's ``message`` tells.
    """

    function: Callable[[float, Multivector, Multivector], Any]
    direction: int = 0
    name: str = "event"

    def __post_init__(self) -> None:
        if isinstance(self.function, type) or not callable(self.function):
            raise InputError(f"the event's function is {shown(self.function)}; a function is needed.")
        takes(self.function, (3,), "the event's function", "a function of time, motor and twist")
        if not isinstance(self.direction, int | np.integer) or self.direction not in (-1, 0, 1):
            raise InputError(f"the event's direction is {shown(self.direction)}; it is -1, 0 or 1.")
        if not isinstance(self.name, str):
            raise InputError(f"the event's name is {shown(self.name)}; a text is needed.")

    def passes(self, before: float, after: float) -> bool:
        """Whether two values lie on both sides."""
        rises = before < 0 <= after and self.direction >= 0
        falls = before > 0 >= after and self.direction <= 0
        return rises or falls


def given_events(value: Any) -> tuple[Event, ...]:
    """Events as a user gives them: one or several, also as bare functions.

    Raises
    ------
    InputError
        If one is neither: which.
    """
    found = several(value, (Event, FunctionType, MethodType, partial), "the events")
    events = []
    for i, event in enumerate(found):
        if not isinstance(event, Event) and (isinstance(event, type) or not callable(event)):
            raise InputError(
                f"events[{i}] is {shown(event)}; an Event, or a function of time, motor and twist, is needed."
            )
        events.append(event if isinstance(event, Event) else Event(event))
    return tuple(events)


def first_event(found: Trajectory, events: Sequence[Event]) -> Trajectory:
    """The trajectory up to the first event, its state stored last.

    Raises
    ------
    SimulationError
        If the function of an event fails: when; its ``trajectory`` is the whole of it.
    """
    run = found._run
    try:
        return _first(found, run, events)
    except InputError as error:
        raise SimulationError(error.what, remedy=error.remedy, trajectory=found) from error.__cause__


def check_single(simulations: int, bodies: int) -> None:
    """Raise `InputError` where there is more than one state to look at."""
    if simulations > 1 or bodies > 1:
        raise InputError(
            f"events are for one simulation of one body; here are {simulations} of {bodies}.",
            remedy="Run them one by one, or look for the time in the trajectory",
        )


def _first(found: Trajectory, run: engine.Run, events: Sequence[Event]) -> Trajectory:
    count = int(run.stored[0])
    hits = [hit for event in events if (hit := _crossing(run, event, count)) is not None]
    if not hits:
        return found
    time, place, event = min(hits, key=lambda hit: hit[0])
    at = _run_to(run, place - 1, time)
    run.times = run.times.copy()
    run.times[place] = time
    for each, there in (
        (run.motors, at.motors),
        (run.twists, at.twists),
        (run.reactions, at.reactions),
        (run.violations, at.violations),
    ):
        each[0, place] = there[0, 1]
    run.status[0], run.stored[0], run.reached[0] = engine.EVENT, place + 1, time
    again = type(found)(found._simulation, run)
    again.message = event.name
    return again


def _value(run: engine.Run, event: Event, time: float, motors: Array, twists: Array) -> float:
    motor, twist = run.driver.made.to_user(0, motors[0].copy(), twists[0].copy())
    try:
        value = event.function(time, motor, twist)
    except Exception as error:  # a user's function may raise anything
        raise InputError(f"{event.name} failed at time {time:.6g}: {reason(error).rstrip('.')}.") from error
    found = finite(value, f"{event.name} at time {time:.6g}")
    if found.ndim:
        raise InputError(f"{event.name} has shape {found.shape} at time {time:.6g}; one number is needed.")
    return float(found)


def _crossing(run: engine.Run, event: Event, count: int) -> tuple[float, int, Event] | None:
    """Time, store and state where a value first passes zero."""
    before = _value(run, event, run.times[0], run.motors[0, 0], run.twists[0, 0])
    for i in range(1, count):
        after = _value(run, event, run.times[i], run.motors[0, i], run.twists[0, i])
        if event.passes(before, after):
            return _root(run, event, i, before, after), i, event
        before = after
    return None


def _root(run: engine.Run, event: Event, i: int, before: float, after: float) -> float:
    """The state where the value is zero between two stores, by the Illinois rule."""
    low, high = float(run.times[i - 1]), float(run.times[i])
    values = [before, after]
    least = PRECISION * (high - low) + 4 * np.finfo(float).eps * abs(high)
    side = 0
    for _ in range(MOST_ROUNDS):
        if high - low <= least or values[1] == 0:
            break
        time = high - values[1] * (high - low) / (values[1] - values[0])
        time = min(max(time, low + least / 2), high - least / 2)
        at = _run_to(run, i - 1, time)
        value = _value(run, event, time, at.motors[0, 1], at.twists[0, 1])
        if (value > 0) == (values[1] > 0) or value == 0:
            high, values[1] = time, value
            values[0] = values[0] / 2 if side == 1 else values[0]
            side = 1
        else:
            low, values[0] = time, value
            values[1] = values[1] / 2 if side == -1 else values[1]
            side = -1
    return high


def _run_to(run: engine.Run, place: int, time: float) -> engine.Run:
    """A run anew from a stored state to a time, which is its second store."""
    begin = float(run.times[place])
    again = engine.Run(run.driver, np.array([begin, time]), run.motors[0, place], run.twists[0, place])
    again.to(2)
    run.driver.raise_error()
    if again.stored[0] < 2:
        raise InputError(f"the state between the stores at {begin:.6g} and after cannot be computed.")
    return again
