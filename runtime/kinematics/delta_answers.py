"""What a Delta robot answers: values, with statuses if asked for, or an error that says what is wrong with a pose."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..codegen.errors import SingularError
from ..status import Status
from ..text import statuses

if TYPE_CHECKING:
    from .delta import DeltaRobot

Array = NDArray[Any]
#: The words for an item's place and status.
Why = Callable[[tuple[int, ...], Status], str]
ELBOWS = ("outer", "inner")


def answer(values: Array, codes: Array | None, with_status: bool, strict: bool, what: str, why: Why) -> Any:
    """Values, with their statuses if asked for.

    Raises
    ------
    SingularError
        With ``strict``: for the first without an answer.
    """
    assert codes is not None
    if truth(strict, "strict") and codes.any():
        place = tuple(int(i) for i in np.argwhere(codes)[0]) if codes.ndim else ()
        code = Status(int(codes[place]))
        item = "it" if not place else f"item {place[0] if len(place) == 1 else place}"
        raise SingularError(f"{what}: {item} is {code.name}{why(place, code) if code != Status.INVALID else ''}.")
    return (values, statuses(codes, codes.shape)) if truth(with_status, "status") else values


def why_at(robot: DeltaRobot, places: Array, sides: Array) -> Why:
    """Says what is wrong at a position: which arms, and which direction is lost."""

    def why(place: tuple[int, ...], code: Status) -> str:
        words = [ELBOWS[int(side < 0)] for side in sides]
        bad = [str(i + 1) for i, arm in enumerate(robot.arm_status(places[place], words)) if arm == code]
        if bad:
            return f", arm{'s' if len(bad) > 1 else ''} {', '.join(bad)}"
        near = robot.singularity_at(places[place], words)
        arm = int(np.abs(near.sines).argmin()) + 1
        return f": arm {arm} is stretched or folded, and does not move the platform along {_written(near.lost)}"

    return why


def why(robot: DeltaRobot, angles: Array, root: str) -> Why:
    """Says what is wrong at some angles: which direction is left free."""

    def why(place: tuple[int, ...], code: Status) -> str:
        if code == Status.UNREACHABLE:
            return ", the forearms do not meet"
        near = robot.singularity(angles[place], root)
        if np.isnan(near.free).any():
            return ", forearms start at one point"
        return f", the forearms do not hold the platform along {_written(near.free)}"

    return why


def _written(direction: Array) -> str:
    return f"({', '.join(f'{x:.3g}' for x in direction)})"


__all__ = ["ELBOWS", "Why", "answer", "why", "why_at"]
