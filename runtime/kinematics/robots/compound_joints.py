"""Joints one behind the other, with no mass between them, as the one joint that they make together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...mechanics.joints.bilinear import Universal
from ...mechanics.joints.standard import Cylindrical, Planar, Spherical

if TYPE_CHECKING:
    from ...core.multivector import Algebra
    from ...mechanics.joints.base import Joint

Array = NDArray[Any]
#: Axes are parallel, at right angles or concurrent to this: files have digits that are rounded.
TOLERANCE = 1e-9


def compound_joint(
    algebra: Algebra, a: str, b: str, kinds: list[str], positions: Array, axes: Array, size: float
) -> Joint | None:
    """The joint that several make, from the first body to the second; None if it is none with a name.

    Parameters
    ----------
    kinds : list of str
        As of `RobotJoint`.
    positions, axes : array (n, 3)
        In the world.
    size : float
        Length of the robot.
    """
    turns = np.array([kind in ("revolute", "continuous") for kind in kinds])
    if not (turns | np.array([kind == "prismatic" for kind in kinds])).all():
        return None
    about, along = axes[turns], axes[~turns]
    center = _common_point(positions[turns], about, size)
    if len(kinds) == 3 and len(about) == 3 and center is not None and np.linalg.matrix_rank(about, tol=1e-6) == 3:
        return Spherical(a, b, algebra.point(center))
    if len(kinds) == 2 and len(about) == 2 and center is not None and abs(about[0] @ about[1]) < TOLERANCE:
        if algebra.name != "cga3d":  # circles are of conformal geometry
            return None
        circles = [algebra.circle(center, axis, max(size, 1e-3) / 10) for axis in about]
        return Universal(a, b, circles[0], circles[1])
    if len(kinds) == 2 and len(about) == 1 and np.linalg.norm(np.cross(about[0], along[0])) < TOLERANCE:
        return Cylindrical(a, b, algebra.line(positions[turns][0], about[0]))
    if len(kinds) == 3 and len(about):
        normal = about[0]
        is_plane = bool((np.linalg.norm(np.cross(about, normal), axis=-1) < TOLERANCE).all())
        is_plane &= bool((np.abs(along @ normal) < TOLERANCE).all())
        if is_plane and _spans_plane(positions[turns], along, normal, size):
            return Planar(a, b, algebra.plane(normal, float(positions[turns][0] @ normal)))
    return None


def _common_point(positions: Array, axes: Array, size: float) -> Array | None:
    """The point that lines have in common; None without one, or with more than one."""
    if len(axes) < 2:
        return None
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    matrix = across.sum(0)
    if np.linalg.cond(matrix) > 1e9:
        return None
    point = np.linalg.solve(matrix, np.einsum("nij,nj->i", across, positions))
    gaps = np.linalg.norm(np.einsum("nij,nj->ni", across, point - positions), axis=-1)
    return np.asarray(point) if gaps.max() <= TOLERANCE * max(size, np.abs(point).max()) else None


def _spans_plane(positions: Array, along: Array, normal: Array, size: float) -> bool:
    """Whether translations, and rotations about parallel axes, move a body along both directions of a plane."""
    moves = [*along, *(np.cross(normal, (x - positions[0]) / max(size, 1e-300)) for x in positions[1:])]
    return bool(np.linalg.matrix_rank(np.array(moves), tol=1e-6) == 2)
