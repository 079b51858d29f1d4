"""Why a Delta robot has no pose: which arms, and which direction is lost or free."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dispatch.item_statuses import Explanation, raise_first
from ...status import Status
from . import solutions
from .geometry import DeltaGeometry
from .singularity import singularity

Array = NDArray[Any]


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
    raise_first(codes, "forward", explain=explain_angles(geometry, theta, root))
    return y


def _text(direction: Array) -> str:
    return f"({', '.join(f'{x:.3g}' for x in direction)})"


__all__ = ["explain_angles", "explain_positions", "forward_strictly"]
