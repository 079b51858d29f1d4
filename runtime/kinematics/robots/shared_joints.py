"""Joints of robots as geometry that two bodies share, in the world."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...core.geometry.euclidean import perpendicular
from ...mechanics.joints.standard import Planar, Prismatic, Revolute, Rigid, Screw, Spherical

if TYPE_CHECKING:
    from ...core.multivector import Algebra
    from ...mechanics.joints.base import Joint

Array = NDArray[Any]


def shared_joint(
    algebra: Algebra, kind: str, a: str, b: str, position: Array, axis: Array, pitch: float = 0.0
) -> Joint:
    """The joint between two bodies, by its position (3,) and axis (3,) in the world, and the pitch of a screw."""
    if kind == "fixed":
        return Rigid(a, b, position, algebra)
    if kind == "ball":
        return Spherical(a, b, algebra.point(position))
    if kind == "planar":
        return Planar(a, b, algebra.plane(axis, float(position @ axis)))
    line = algebra.line(position, axis)
    if kind == "screw":
        return Screw(a, b, line, pitch=pitch)
    if kind == "prismatic":
        across = perpendicular(axis)
        return Prismatic(a, b, line, algebra.direction(across / np.linalg.norm(across)))
    return Revolute(a, b, line, algebra.point(position))
