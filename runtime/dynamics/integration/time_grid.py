"""What a run is asked for in numbers: duration, step, tolerances, the times of stored states, and whether they fit."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, ShapeError
from . import methods
from .given import finite, number

if TYPE_CHECKING:
    from . import engine

Array = NDArray[Any]
#: Duration, step, rtol and atol of a run; tolerances None: those of the integrator.
Settings = tuple[float, float, float | None, float | None]
#: Numbers that are stored of a body's state: motor, twist, reaction, violation; and for each direction, two twists.
STATE, TANGENT = 8 + 6 + 6 + 1, 2 * 6
#: Bytes that a machine is taken to have if it does not say.
MEMORY = 64 << 30


def settings_of(duration: Any, step: Any, rtol: Any, atol: Any, every_step: bool) -> Settings:
    """The numbers of a run, checked; whether each step is stored.

    Raises
    ------
    InputError, ShapeError
        If one is no positive number, or the step is lost in the rounding of the duration.
    """
    whole = number(duration, "the duration")
    each = methods.STEP if step is None else number(step, "the step")
    if (every_step or step is not None) and each <= np.finfo(float).eps * whole:
        raise InputError(
            f"the step is {each:.3g}, which is rounded away beside the duration, {whole:.6g}.",
            remedy="Take a longer step or a shorter duration",
        )
    share = None if rtol is None else number(rtol, "rtol")
    if share is not None and share >= 1:
        raise InputError(f"rtol is {share:.3g}; it is a share, below 1.")
    return whole, each, share, None if atol is None else number(atol, "atol", zero=True)


def stored_times(settings: Settings, times: Any, bodies: int) -> Array:
    """When states are stored, from 0; without times, every step.

    Raises
    ------
    InputError, ShapeError
        If times do not rise from 0 to the duration (which), or there are more states than memory for them.
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
    found = finite(times, "times")
    if found.ndim != 1:
        raise ShapeError(f"times have shape {found.shape}; a row of times is needed.")
    if not len(found):
        raise InputError("times are empty; one or more are needed.", remedy="Leave times out to store every step")
    before = np.concatenate([[0.0], found[:-1]])
    bad = (found < before) | (found > duration * (1 + 1e-12))
    bad[1:] |= found[1:] == found[:-1]
    if bad.any():
        i = int(np.argmax(bad))
        after = f" after {found[i - 1]:.6g}" if i else ""
        raise InputError(f"times[{i}] is {found[i]:.6g}{after}; times rise from 0 to the duration, {duration:.6g}.")
    return found if found[0] == 0 else np.concatenate([[0.0], found])


def check_room(driver: engine.Driver, stores: int) -> None:
    """Raise `InputError` if the states of a batch do not fit into memory."""
    numbers = STATE + TANGENT * driver.tangents
    _check_room(
        stores * driver.size * driver.bodies * numbers,
        f"{driver.size} simulations store {stores} states each",
        "Store fewer, with times=[..], or run the batch in parts",
    )


def _check_room(numbers: float, what: str, remedy: str) -> None:
    """Numbers of eight bytes against what the machine has."""
    needed, there = 8 * numbers, _memory()
    if needed > there:
        raise InputError(
            f"{what}, which take {needed / 2**30:.3g} GiB; this machine has {there / 2**30:.3g} GiB.", remedy=remedy
        )


def _memory() -> int:
    """Bytes of memory of the machine."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):  # Windows
        return MEMORY


__all__ = ["Settings", "check_room", "settings_of", "stored_times"]
