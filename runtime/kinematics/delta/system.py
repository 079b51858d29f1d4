"""The Delta robot as rigid bodies and joints, for simulations."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import check_shape, positive_array, real_array
from ...mechanics.rigid_body import RigidBody
from ...mechanics.shapes import SLENDER, rod
from ...mechanics.system import System
from .diagnostics import forward_strictly
from .geometry import FOREARMS, PLATFORM, UPPER_ARMS, DeltaGeometry, joint_objects, pose

Array = NDArray[Any]


def system(geometry: DeltaGeometry, theta: Any, masses: Any = (1.0, 0.3, 2.0), root: str = "far") -> System:
    """System at rest at one pose: upper arms and rods uniform and slender, the platform a thin disc.

    Parameters
    ----------
    theta : array (3,)
    masses : (upper arm, rod, platform)
        Masses of one upper arm, one of the six rods, the platform.
    root
        As in `DeltaRobot.forward`.

    Returns
    -------
    System
        Bodies `upper_arm_1` .. `forearm_6` and `platform`, on `base`. The six rods are free to spin about themselves.

    Raises
    ------
    SingularError
        If there is no pose at these angles.
    InputError, ShapeError
        If theta is not one pose, or masses are not positive.
    """
    angles = np.asarray(real_array(theta, "theta", (3,)), np.float64)
    weights = positive_array(masses, "masses")
    check_shape(weights, "masses", (3,), remedy="They are those of upper arm, rod and platform")
    at = pose(geometry, forward_strictly(geometry, angles, root), angles)
    bodies = {}
    for name, ends in zip(UPPER_ARMS, zip(at.shoulders, at.elbows, strict=True), strict=True):
        bodies[name] = _bar(weights[0], *ends)
    for name, ends in zip(FOREARMS, zip(at.tops, at.bottoms, strict=True), strict=True):
        bodies[name] = _bar(weights[1], *ends)
    bodies[PLATFORM] = RigidBody(weights[2], _disc(weights[2], 2 * geometry.effector_radius), at.position)
    return System(bodies, joint_objects(geometry, at).joints())


def _bar(mass: float, begin: Array, end: Array) -> RigidBody:
    shape = rod(float(np.linalg.norm(end - begin)), axis=end - begin)
    return RigidBody(mass, shape.inertia(mass), (begin + end) / 2)


def _disc(mass: float, radius: float) -> Array:
    """Inertia of a disc through the corners of the platform, as thin against its radius as a rod is."""
    across = mass * radius**2 * (3 + (2 * SLENDER) ** 2) / 12
    return np.array([across, across, mass * radius**2 / 2])


__all__ = ["system"]
