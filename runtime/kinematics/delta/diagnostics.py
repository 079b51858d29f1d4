"""Results of a Delta robot: values, with statuses if requested, or an error that explains why there is no pose."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import SingularError
from ...common.validation import as_bool
from ...dispatch.multivector_data import Statuses, statuses
from ...status import Status
from . import solutions
from .geometry import DeltaGeometry
from .singularity import singularity

Array = NDArray[Any]
#: Values, or values and their statuses.
Answer: TypeAlias = Array | tuple[Array, Statuses]
#: The explanation of an item's status, for its index and status.
Explanation = Callable[[tuple[int, ...], Status], str]


def answer(
    values: Array, codes: Array | None, with_status: bool, strict: bool, what: str, explain: Explanation
) -> Answer:
    """Values, with their statuses if requested.

    Raises
    ------
    SingularError
        With ``strict``: for the first item without a solution.
    """
    assert codes is not None
    if as_bool(strict, "strict") and codes.any():
        index = tuple(int(i) for i in np.argwhere(codes)[0]) if codes.ndim else ()
        code = Status(int(codes[index]))
        item = "it" if not index else f"item {index[0] if len(index) == 1 else index}"
        raise SingularError(f"{what}: {item} is {code.name}{explain(index, code) if code != Status.INVALID else ''}.")
    return (values, statuses(codes, codes.shape)) if as_bool(with_status, "status") else values


def explain_positions(geometry: DeltaGeometry, y: Array, elbows: Array) -> Explanation:
    """Explanation of a status at a position: which arms, and which direction is lost."""

    def explain(index: tuple[int, ...], code: Status) -> str:
        arms = solutions.arm_codes(geometry, y[index], elbows)
        bad = [str(i + 1) for i, arm in enumerate(arms) if arm == code]
        if bad:
            return f", arm{'s' if len(bad) > 1 else ''} {', '.join(bad)}"
        theta, _ = solutions.inverse(geometry, y[index], elbows)
        near = singularity(geometry, theta, y[index])
        arm = int(np.abs(near.sines).argmin()) + 1
        return f": arm {arm} is stretched or folded, and does not move the platform along {_text(near.lost_direction)}"

    return explain


def explain_angles(geometry: DeltaGeometry, theta: Array, root: str) -> Explanation:
    """Explanation of a status at some angles: which direction is free."""

    def explain(index: tuple[int, ...], code: Status) -> str:
        if code == Status.UNREACHABLE:
            return ", the forearms do not meet"
        y, _ = solutions.forward(geometry, theta[index], root)
        near = singularity(geometry, theta[index], y)
        if np.isnan(near.free).any():
            return ", forearms start at one point"
        return f", the forearms do not hold the platform along {_text(near.free)}"

    return explain


def forward_strictly(geometry: DeltaGeometry, theta: Array, root: str) -> Array:
    """Positions of the platform for angles.

    Raises
    ------
    SingularError
        If there is no position: why.
    """
    y, codes = solutions.forward(geometry, theta, root)
    return np.asarray(answer(y, codes, False, True, "forward", explain_angles(geometry, theta, root)))


def _text(direction: Array) -> str:
    return f"({', '.join(f'{x:.3g}' for x in direction)})"


__all__ = ["Explanation", "answer", "explain_angles", "explain_positions", "forward_strictly"]
