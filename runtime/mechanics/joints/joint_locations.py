"""Locations and characteristic lengths of joints, and their least-squares center.

Lengths below the rounding error of the coordinates are treated as zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.geometry.scaling import lengths_of
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate

Array = NDArray[Any]
#: Lengths below this fraction of the distance from the origin are rounding errors: those of squared distances.
RESOLVED = float(np.sqrt(np.finfo(float).eps))
#: Lines or planes with smaller squared angles (relative) are parallel, and meet nowhere near.
PARALLEL = 1e-3


def joint_locations(objects: list[Multivector], count: int, near: Array | None = None) -> Array:
    """Positions (n, 3) of joints: the least-squares intersection of each joint's objects, nearest to a point (3,)."""
    near = np.zeros(3) if near is None else near
    matrices, offsets = np.zeros((count, 3, 3)), np.zeros((count, 3))
    for x in objects:
        points, normal_projectors = _extent(x)
        matrices = matrices + normal_projectors
        offsets = offsets + (normal_projectors @ (points - near)[..., None])[..., 0]
    locations: Array = near + (np.linalg.pinv(matrices, rcond=PARALLEL, hermitian=True) @ offsets[..., None])[..., 0]
    return locations


def least_squares_center(groups: Sequence[list[Multivector]]) -> Array:
    """The point (3,) with the least sum of squared distances to all objects of joints."""
    matrix, offset = np.zeros((3, 3)), np.zeros(3)
    for x in (x for objects in groups for x in objects):
        points, normal_projectors = _extent(x)
        matrix = matrix + normal_projectors.sum(0)
        offset = offset + (normal_projectors @ points[..., None])[..., 0].sum(0)
    center: Array = np.linalg.pinv(matrix, rcond=PARALLEL, hermitian=True) @ offset
    return center


def extent(positions: Array, center: Array) -> float:
    """The largest coordinate difference of positions from a center; 0 where it is a rounding error of them."""
    largest = float(np.abs(positions - center).max(initial=0))
    return largest if largest > RESOLVED * float(np.abs(positions).max(initial=0)) else 0.0


def length_scales(local: Sequence[Multivector], positions: Array, default: float) -> Array:
    """Length scale (n,) of each joint, rounded to a power of two, from its objects seen from its position.

    Joints whose objects have no length of their own (lines, planes) get ``default``, or 1 where that is zero.
    """
    lengths = np.max([lengths_of(x) for x in local], 0)
    resolved = lengths > RESOLVED * np.linalg.norm(positions, axis=-1)
    return np.asarray(2.0 ** np.round(np.log2(np.where(resolved, lengths, default or 1.0))))


def _extent(x: Multivector) -> tuple[Array, Array]:
    """Points (n, 3) on objects, and projectors (n, 3, 3) onto the directions normal to lines and planes."""
    count = len(x.values)
    for kind in ("point", "flat_point", "sphere", "circle", "point_pair", "line", "plane"):
        if kind in x.algebra.kinds and set(x.kind.blades) == set(x.algebra.kind(kind).blades):
            p = x.as_kind(kind, check=False).parameters()
            if hasattr(p, "a"):
                return _finite((p.a + p.b) / 2, np.eye(3))
            if kind not in ("line", "plane"):
                return _finite(getattr(p, "xyz", getattr(p, "center", None)), np.eye(3))
            direction = p.direction if kind == "line" else p.normal
            square = (direction * direction).sum(-1)
            square = np.where(square > 0, square, np.inf)
            projector = direction[..., :, None] * direction[..., None, :] / square[..., None, None]
            if kind == "line":
                return _finite(p.point / square[..., None], np.eye(3) - projector)
            return _finite((p.offset / square)[..., None] * direction, projector)
    if set(x.kind.blades) == set(x.algebra.kind("twist").blades):
        rotation, translation = (v.values for v in evaluate(x.algebra, "mechanics.screw_vectors", x).values)
        square = (rotation * rotation).sum(-1)[..., None]
        square = np.where(square > 0, square, np.inf)
        projector = rotation[..., :, None] * rotation[..., None, :] / square[..., None]
        return _finite(np.cross(rotation, translation) / square, np.eye(3) - projector)
    return np.zeros((count, 3)), np.zeros((count, 3, 3))


def _finite(points: Any, projectors: Array) -> tuple[Array, Array]:
    """Points and projectors, zero for the items that are not finite."""
    points = np.asarray(points, float)
    finite = np.isfinite(points).all(-1)
    return np.where(finite[..., None], points, 0.0), np.where(finite[..., None, None], projectors, 0.0)
