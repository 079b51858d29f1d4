"""Jacobians of the Delta robot from the forces of its rods: screws of arms and platform, no derivatives (thesis 7.7.4).

A rod between two ball joints transmits one force, along its line: L ^ Omega of the arm is L ^ Omega of the platform.
Six rods are six equations for the platform's twist, rotation included.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...status import Status
from . import evaluation as calls
from . import solutions
from .geometry import DeltaGeometry

Array = NDArray[Any]
#: Singular values below this many rounding errors of the largest are zero.
NOISE = 64


def forward_jacobian(geometry: DeltaGeometry, theta: Array, root: str) -> tuple[Array, Array]:
    """J and codes: the platform's velocity for unit speeds of each motor."""
    y, codes = solutions.forward(geometry, theta, root, precise=True)
    platform, arms = _powers(geometry, y, theta, codes)
    regular = _is_regular(platform)
    speeds = np.zeros((*arms.shape[:-1], 6, 3))
    speeds[..., range(6), [k // 2 for k in range(6)]] = arms
    twists = np.linalg.solve(np.where(regular[..., None, None], platform, np.eye(6)), speeds)
    jacobian = twists[..., 3:, :] * (geometry.parameters[4])
    return _with_codes(jacobian, np.asarray(codes, np.uint8), regular)


def inverse_jacobian(geometry: DeltaGeometry, y: Array, elbows: Array) -> tuple[Array, Array]:
    """J* and codes: the motors' speeds for unit velocities of the platform, which does not rotate."""
    theta, codes = solutions.inverse(geometry, y, elbows, precise=True)
    platform, arms = _powers(geometry, y, theta, codes)
    forces = platform[..., 3:].reshape(*arms.shape[:-1], 3, 2, 3).sum(-2)
    powers = arms.reshape(*arms.shape[:-1], 3, 2).sum(-1)
    regular = (np.abs(powers) > NOISE * np.finfo(powers.dtype).eps * geometry.parameters[1]).all(-1)
    jacobian = forces / np.where(regular[..., None], powers, 1.0)[..., None] * geometry.parameters[3]
    return _with_codes(jacobian, np.asarray(codes, np.uint8), regular)


def _powers(geometry: DeltaGeometry, y: Array, theta: Array, codes: Array) -> tuple[Array, Array]:
    """Power of each rod's unit force on unit twists of the platform (..., 6, 6) and of its arm (..., 6)."""
    valid = np.asarray(codes == Status.OK)[..., None]
    poses = [np.where(valid, x, x.dtype.type(0)) for x in (y, theta)]
    (platform, arms), _ = calls.evaluate("delta_frame.rod_powers", [*poses, geometry.parameters, geometry.radii])
    return platform.reshape(*platform.shape[:-1], 6, 6), arms


def _is_regular(matrices: Array) -> NDArray[np.bool_]:
    """Mask of the matrices whose six forces hold the platform in all directions."""
    valid = np.asarray(np.isfinite(matrices).all((-2, -1)))
    values = np.linalg.svd(np.where(valid[..., None, None], matrices, np.eye(6))).S
    return np.asarray(valid & (values[..., -1] > NOISE * np.finfo(matrices.dtype).eps * values[..., 0]))


def _with_codes(jacobian: Array, codes: Array, regular: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Jacobians, NaN where there is none, and codes: SINGULAR where the matrices are not regular."""
    codes = np.where((codes == Status.OK) & ~regular, np.uint8(Status.SINGULAR), codes)
    return np.where((codes == Status.OK)[..., None, None], jacobian, np.nan), np.asarray(codes, np.uint8)


__all__ = ["forward_jacobian", "inverse_jacobian"]
