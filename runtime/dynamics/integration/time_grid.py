"""Duration, step, tolerances and times of stored states of a run, checked against the memory of the machine."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common import memory
from ...common.parallel import thread_count
from ...common.validation import as_float, finite_array, positive_float
from . import integrators

if TYPE_CHECKING:
    from ..trees.driver import TreeDriver
    from .driver import Driver

Array = NDArray[Any]
#: Largest relative error that can be asked for: error estimates are of leading order.
MAX_RTOL = 0.1
#: Duration, step, rtol and atol of a run; None is the tolerance of the integrator.
Settings = tuple[float, float, float | None, float | None]
#: Times up to which they are looked at one by one.
_FEW = 16
#: Numbers of a stored state of a body: motor, twist, reaction, violation.
STATE = 8 + 6 + 6 + 1
#: Numbers of a stored state of a body in each direction of sensitivities: two twists.
TANGENT = 2 * 6


def settings_of(duration: Any, step: Any, rtol: Any, atol: Any, every_step: bool) -> Settings:
    """Check the settings of a run; ``every_step`` says that each step is stored.

    Raises
    ------
    InputError, ShapeError
        If one is not a positive number, or the step is below the rounding of the duration.
    """
    duration = positive_float(duration, "the duration")
    size = integrators.STEP if step is None else positive_float(step, "the step")
    if (every_step or step is not None) and size <= np.finfo(float).eps * duration:
        raise InputError(
            f"the step is {size:.3g}, which is rounded away beside the duration, {duration:.6g}.",
            remedy="Take a longer step or a shorter duration",
        )
    relative = None if rtol is None else positive_float(rtol, "rtol")
    if relative is not None and relative > MAX_RTOL:
        raise InputError(
            f"rtol is {relative:.3g}; it is a relative error, at most {MAX_RTOL:g}.",
            remedy="Beyond that no error is estimated; take a method of fixed steps where few digits do",
        )
    return duration, size, relative, None if atol is None else as_float(atol, "atol", 0)


def stored_times(settings: Settings, times: Any, bodies: int) -> Array:
    """Times of stored states, from 0; without ``times``, every step.

    Raises
    ------
    InputError, ShapeError
        If times do not rise from 0 to the duration, or the states do not fit into memory.
    """
    duration, step = settings[:2]
    if times is None:
        count = duration / step * (1 - 1e-12)
        _check_room(
            count * bodies * STATE,
            f"a step of {step:.3g} over {duration:.6g} stores {count:.3g} states",
            "Say which to store, with times=[..], or take a longer step",
        )
        return np.concatenate([np.arange(int(np.ceil(count))) * step, [duration]])
    if type(times) is list and 0 < len(times) <= _FEW and all(type(t) is float for t in times):
        few = times  # at a third of what arrays take
    else:
        times = finite_array(times, "times", ("n",))
        if not len(times):
            raise InputError("times are empty; one or more are needed.", remedy="Leave times out to store every step")
        few = times.tolist() if len(times) <= _FEW else []
    if few and few[0] >= 0 and few[-1] <= duration * (1 + 1e-12) and all(a < b for a, b in pairwise(few)):
        return np.array(few if few[0] == 0 else [0.0, *few])
    times = finite_array(times, "times", ("n",))
    before = np.concatenate([[0.0], times[:-1]])
    bad = (times < before) | (times > duration * (1 + 1e-12))
    bad[1:] |= times[1:] == times[:-1]
    if bad.any():
        i = int(np.argmax(bad))
        after = f" after {times[i - 1]:.6g}" if i else ""
        raise InputError(f"times[{i}] is {times[i]:.6g}{after}; times rise from 0 to the duration, {duration:.6g}.")
    return times if times[0] == 0 else np.concatenate([[0.0], times])


def check_room(driver: Driver | TreeDriver, stores: int, threads: int | None) -> None:
    """Raise `InputError` if the states of a batch, or what computing them takes, do not fit into memory."""
    numbers = STATE + TANGENT * driver.tangents
    _check_room(
        stores * driver.size * driver.bodies * numbers,
        f"{driver.size} simulations store {stores} states each",
        "Store fewer, with times=[..], or run the batch in parts",
    )
    single = driver.size == 1 or driver.assembly.callbacks.functions
    count = 1 if single else min(driver.size, thread_count(threads))
    size = driver.workspace_bytes + 8 * driver.memory * driver.size // count
    if size * count > memory.total():
        memory.check_workspace(size, count, f"a simulation of {driver.bodies} bodies with {driver.equations} equations")


def _check_room(numbers: float, what: str, remedy: str) -> None:
    """Numbers of eight bytes against what the machine has."""
    needed, there = 8 * numbers, memory.total()
    if needed > there:
        raise InputError(
            f"{what}, which take {needed / 2**30:.3g} GiB; this machine has {there / 2**30:.3g} GiB.", remedy=remedy
        )


__all__ = ["Settings", "check_room", "settings_of", "stored_times"]
