"""The Delta robot as bodies and joints, for simulations of its dynamics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import ShapeError
from ..dynamics.bodies import RigidBody
from ..dynamics.given import positive
from ..dynamics.shapes import SLENDER, rod
from ..dynamics.system import System
from . import delta_calls as calls
from .delta_geometry import FOREARMS, PLATFORM, UPPER_ARMS, joint_objects, pose

if TYPE_CHECKING:
    from .delta import DeltaRobot

Array = NDArray[Any]


def system(robot: DeltaRobot, theta: Any, masses: Any = (1.0, 0.3, 2.0), root: str = "far") -> System:
    """The robot at rest at one pose: upper arms and rods uniform and slender, the platform a thin disc.

    Parameters
    ----------
    theta : array (3,)
    masses : (upper arm, rod, platform)
        Of one upper arm, of one of the six rods, of the platform.
    root
        As of `DeltaRobot.forward`.

    Returns
    -------
    System
        Bodies `upper_arm_1` .. `forearm_6` and `platform`, on `base`. The six rods are free to spin about themselves.

    Raises
    ------
    SingularError
        If there is no pose at these angles.
    InputError, ShapeError
        For other than one pose, or masses that are not positive.
    """
    angles = np.asarray(calls.rows(theta, "theta"), np.float64)
    if angles.shape != (3,):
        raise ShapeError(f"theta has shape {angles.shape}; a system is one pose, (3,).")
    weights = positive(masses, "masses")
    if weights.shape != (3,):
        raise ShapeError(f"masses has shape {weights.shape}; they are three: upper arm, rod, platform.")
    found = pose(robot, robot.forward(angles, root, strict=True), angles)
    bodies = {}
    for name, ends in zip(UPPER_ARMS, zip(found.shoulders, found.elbows, strict=True), strict=True):
        bodies[name] = _bar(weights[0], *ends)
    for name, ends in zip(FOREARMS, zip(found.tops, found.bottoms, strict=True), strict=True):
        bodies[name] = _bar(weights[1], *ends)
    bodies[PLATFORM] = RigidBody(weights[2], _disc(weights[2], 2 * robot.effector_radius), found.position)
    return System(bodies, joint_objects(robot, found).joints())


def _bar(mass: float, begin: Array, end: Array) -> RigidBody:
    shape = rod(float(np.linalg.norm(end - begin)), axis=end - begin)
    return RigidBody(mass, shape.inertia(mass), (begin + end) / 2)


def _disc(mass: float, radius: float) -> Array:
    """Inertia of a disc through the corners of the platform, as thin against its radius as a rod is."""
    across = mass * radius**2 * (3 + (2 * SLENDER) ** 2) / 12
    return np.array([across, across, mass * radius**2 / 2])


__all__ = ["system"]
