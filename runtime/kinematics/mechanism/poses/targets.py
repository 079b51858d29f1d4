"""Targets of poses in batches: displacements of driven joints; items that are not finite are replaced."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....core.multivector import Multivector
from ....dispatch.formulas import evaluate
from ..driver import has_coordinates
from ..structure import Assembly
from .batch import Poses

Array = NDArray[Any]


def forward_fill(values: Array, bad: Array, path: bool) -> Array:
    """Values (..., k) with those of bad items replaced: in a path by the item before, or the first good one."""
    if not bad.any():
        return values
    if not path:
        return np.where(bad[..., None], 0.0, values)
    steps = np.arange(bad.shape[-1])
    before = np.maximum.accumulate(np.where(bad, -1, steps), -1)
    index = np.where(before < 0, np.argmin(bad, -1)[..., None], before)
    filled = np.take_along_axis(values, index[..., None], -2)
    return np.where(np.isfinite(filled), filled, 0.0)


def wanted_coordinates(mechanism: Assembly, joint: int, begin: Poses | None, values: Array, path: bool) -> Array:
    """What a driver takes for coordinates (..., f) of a joint: themselves, in its units, or displacements.

    Displacements are from the previous item of a path or from ``begin``; for joints with three or more degrees of
    freedom they are the screw between the two poses.
    """
    relation = mechanism.loops.relations[joint]
    scaled = values / relation.speeds
    if has_coordinates(mechanism, joint):
        return np.asarray(scaled)
    count = scaled.shape[-1]
    first = np.zeros(count) if begin is None else begin.coordinates(mechanism.joints[joint]) / relation.speeds
    first = np.where(np.isfinite(first), first, 0.0)
    if count > 2:
        return (
            _screw_displacements(mechanism, relation.free, scaled, first, path) if path or begin is not None else scaled
        )
    displacements = scaled - first
    if path:
        displacements[..., 1:, :] = np.diff(displacements, axis=-2)
    return np.asarray(displacements)


def _screw_displacements(mechanism: Assembly, free: Array, motors_now: Array, first: Array, path: bool) -> Array:
    """Coordinates (..., f) of the screws from each pose of a joint to the next."""
    algebra = mechanism.algebra
    kinds = algebra.kind("motor"), algebra.kind("twist")
    rest = np.zeros(8)
    rest[kinds[0].blades.index(0)] = 1

    def motors(coordinates: Array) -> Multivector:
        twists = np.ascontiguousarray(coordinates @ free.T)
        ones = np.broadcast_to(rest, (*twists.shape[:-1], 8)).copy()
        moved: Multivector = evaluate(
            algebra, "joints.move_by_twist", algebra.wrap(kinds[1], twists), algebra.wrap(kinds[0], ones)
        ).value
        return moved

    before = np.broadcast_to(first, motors_now.shape).copy()
    if path:
        before[..., 1:, :] = motors_now[..., :-1, :]
    twists = evaluate(algebra, "joints.twist_between", motors(before), motors(motors_now)).value
    return np.asarray(twists.values @ np.linalg.pinv(free).T)
