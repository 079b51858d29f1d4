"""Jacobians of the Delta robot from the forces of its rods: screws of arms and platform, no derivatives (thesis 7.7.4).

A rod between two ball joints transmits one force, along its line: L ^ Omega of the arm is L ^ Omega of the platform.
Six rods are six equations for the platform's twist, turning included.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..status import Status
from . import delta_calls as calls

if TYPE_CHECKING:
    from .delta import DeltaRobot

Array = NDArray[Any]
#: Singular values below this many rounding errors of the largest are zero.
NOISE = 64


def forward_jacobian(robot: DeltaRobot, theta: Array, root: str) -> tuple[Array, Array]:
    """J and codes: the platform's velocity for unit speeds of each motor."""
    y, codes = robot.forward(theta, root, precise=True, status=True)
    platform, arms = _powers(robot, y, theta, codes)
    regular = _regular(platform)
    speeds = np.zeros((*arms.shape[:-1], 6, 3))
    speeds[..., range(6), [k // 2 for k in range(6)]] = arms
    twists = np.linalg.solve(np.where(regular[..., None, None], platform, np.eye(6)), speeds)
    jacobian = twists[..., 3:, :] * (robot._row[4])
    return _finished(jacobian, np.asarray(codes, np.uint8), regular)


def inverse_jacobian(robot: DeltaRobot, y: Array, elbow: Any) -> tuple[Array, Array]:
    """J* and codes: the motors' speeds for unit velocities of the platform, which does not turn."""
    theta, codes = robot.inverse(y, elbow, precise=True, status=True)
    platform, arms = _powers(robot, y, theta, codes)
    pulled = platform[..., 3:].reshape(*arms.shape[:-1], 3, 2, 3).sum(-2)
    moved = arms.reshape(*arms.shape[:-1], 3, 2).sum(-1)
    regular = (np.abs(moved) > NOISE * np.finfo(moved.dtype).eps * robot._row[1]).all(-1)
    jacobian = pulled / np.where(regular[..., None], moved, 1.0)[..., None] * robot._row[3]
    return _finished(jacobian, np.asarray(codes, np.uint8), regular)


def _powers(robot: DeltaRobot, y: Array, theta: Array, codes: Any) -> tuple[Array, Array]:
    """Power of each rod's unit force on unit twists of the platform (..., 6, 6) and of its arm (..., 6)."""
    known = np.asarray(codes == Status.OK)[..., None]
    poses = [np.where(known, x, x.dtype.type(0)) for x in (y, theta)]
    (platform, arms), _ = calls.evaluate("delta_frame.rod_powers", [*poses, robot._row, robot._plates])
    return platform.reshape(*platform.shape[:-1], 6, 6), arms


def _regular(matrices: Array) -> NDArray[np.bool_]:
    """Whether six forces hold the platform in all ways."""
    known = np.asarray(np.isfinite(matrices).all((-2, -1)))
    values = np.linalg.svd(np.where(known[..., None, None], matrices, np.eye(6))).S
    return np.asarray(known & (values[..., -1] > NOISE * np.finfo(matrices.dtype).eps * values[..., 0]))


def _finished(jacobian: Array, codes: Array, regular: NDArray[np.bool_]) -> tuple[Array, Array]:
    codes = np.where((codes == Status.OK) & ~regular, np.uint8(Status.SINGULAR), codes)
    return np.where((codes == Status.OK)[..., None, None], jacobian, np.nan), np.asarray(codes, np.uint8)


__all__ = ["forward_jacobian", "inverse_jacobian"]
