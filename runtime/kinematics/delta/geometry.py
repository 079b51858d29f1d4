"""Geometry of a Delta robot: its lengths, its points at a pose, and the objects that its bodies share.

Thesis 7.7.1 and 7.7.3.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.validation import positive_float
from ...core.multivector import Multivector
from ...core.registry import stock_algebra
from ...mechanics.joints.base import Joint
from ...mechanics.joints.standard import Revolute, Spherical
from ...mechanics.screws import wrench
from . import evaluation as calls

Array = NDArray[Any]
#: Exponent of the unit of length at most: its inverse is a number, too.
LARGEST_EXPONENT = 1000
#: Names of the bodies of a Delta robot as a mechanism.
BASE = "base"
PLATFORM = "platform"
UPPER_ARMS = tuple(f"upper_arm_{i}" for i in (1, 2, 3))
FOREARMS = tuple(f"forearm_{i}" for i in range(1, 7))
BODIES = (BASE, *UPPER_ARMS, *FOREARMS, PLATFORM)
#: Corner of the platform at which each rod ends: P_10, P_11 or P_12. Neighboring arms share theirs.
CORNER_OF_ROD = (0, 1, 1, 2, 2, 0)
#: Index of a rod that ends at each corner.
_ROD_AT_CORNER = (0, 1, 3)
#: Numbers of the upper ball joints in the thesis.
TOPS = (2, 3, 5, 6, 8, 9)


class DeltaGeometry:
    """Lengths of a Delta robot; see `DeltaRobot`.

    Attributes
    ----------
    base_radius, effector_radius, upper_arm, forearm : float
    parameters : array (6,)
        Radius difference, upper arm and forearm in the unit of length, 1/unit, unit, rounding error of the difference.
    radii : array (2,)
        Radii of base and platform, in the unit of length.
    """

    def __init__(self, base_radius: float, effector_radius: float, upper_arm: float, forearm: float) -> None:
        self.base_radius = positive_float(base_radius, "base_radius")
        self.effector_radius = positive_float(effector_radius, "effector_radius")
        self.upper_arm = positive_float(upper_arm, "upper_arm")
        self.forearm = positive_float(forearm, "forearm")
        gap = abs(self.base_radius - self.effector_radius)
        if gap > self.upper_arm + self.forearm:
            raise InputError(
                f"upper_arm and forearm are {self.upper_arm + self.forearm:.6g} long together; base and platform "
                f"are {gap:.6g} apart everywhere.",
                remedy="Make the arms longer, or the radii more alike",
            )
        exponent = min(max(math.frexp(self.forearm)[1], -LARGEST_EXPONENT), LARGEST_EXPONENT)
        unit = math.ldexp(1.0, exponent)  # a power of two: nothing is rounded
        lengths = (self.base_radius - self.effector_radius, self.upper_arm, self.forearm)
        rest = Fraction(self.base_radius) - Fraction(self.effector_radius) - Fraction(lengths[0])
        self.parameters = np.array([*(x / unit for x in lengths), 1 / unit, unit, float(rest) / unit])
        self._bound = calls.BoundPlans()
        self.radii = np.array([self.base_radius / unit, self.effector_radius / unit])

    def __repr__(self) -> str:
        lengths = ("base_radius", "effector_radius", "upper_arm", "forearm")
        return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name):.6g}' for name in lengths)})"


class Pose(NamedTuple):
    """Points of the robot; NaN where there is no pose.

    Attributes
    ----------
    position, theta : array (..., 3)
    shoulders, elbows, wrists : array (..., 3, 3)
        B_i, W_i and X_i of each arm.
    tops, bottoms : array (..., 6, 3)
        Upper and lower ends of the rods; 1 and 2 are of the first arm.
    corners : array (..., 3, 3)
        P_10, P_11, P_12: where the lower ends of neighbouring arms' rods meet.
    """

    position: Array
    theta: Array
    shoulders: Array
    elbows: Array
    wrists: Array
    tops: Array
    bottoms: Array
    corners: Array


def pose(geometry: DeltaGeometry, y: Array, theta: Array) -> Pose:
    """Points of the robot for positions of the platform and the angles that belong to them."""
    points, _ = calls.evaluate("delta_frame.points", [y, theta, geometry.parameters, geometry.radii])
    missing = np.asarray(~(np.isfinite(y).all(-1) & np.isfinite(theta).all(-1)))
    shoulders, elbows, wrists, tops, bottoms = (
        np.where(missing[..., None, None], np.nan, x.reshape(*x.shape[:-1], x.shape[-1] // 3, 3)) for x in points
    )
    return Pose(y, theta, shoulders, elbows, wrists, tops, bottoms, bottoms[..., _ROD_AT_CORNER, :])


class JointObjects(NamedTuple):
    """Objects that the bodies share.

    Attributes
    ----------
    circles : Multivector (..., 3)
        P_1, P_4, P_7: about the motors' axes s_i x e3, with the upper arm as radius.
    tops : Multivector (..., 6)
        Points P_2, P_3, P_5, P_6, P_8, P_9: upper arm to forearm.
    corners : Multivector (..., 3)
        Points P_10, P_11, P_12: forearm to platform.
    """

    circles: Multivector
    tops: Multivector
    corners: Multivector

    def incidences(self) -> list[tuple[str, str, Multivector]]:
        """Two bodies and their object (...) of each of the 15 joints, in the order of 7.7.3: circles, tops, corners."""
        hinges = [(BASE, arm, self.circles[..., i]) for i, arm in enumerate(UPPER_ARMS)]
        upper = [(UPPER_ARMS[k // 2], rod, self.tops[..., k]) for k, rod in enumerate(FOREARMS)]
        lower = [(rod, PLATFORM, self.corners[..., CORNER_OF_ROD[k]]) for k, rod in enumerate(FOREARMS)]
        return [*hinges, *upper, *lower]

    def joints(self) -> list[Joint]:
        """Joints of a mechanism, for one pose."""
        return [(Revolute if a == BASE else Spherical)(a, b, x) for a, b, x in self.incidences()]


def joint_objects(geometry: DeltaGeometry, at: Pose) -> JointObjects:
    """Circles and points that the bodies share at poses."""
    cga = stock_algebra("cga3d")
    circles = cga.circle(at.shoulders, axes(), geometry.upper_arm)
    return JointObjects(circles, cga.point(at.tops), cga.point(at.corners))


def motor_twists(geometry: DeltaGeometry) -> Multivector:
    """Unit twists (3,) of the upper arms, a I3 + (B x a) n: the dual lines of P_1, P_4, P_7, normalized (7.7.4)."""
    directions = axes()
    shoulders = geometry.base_radius * np.stack([-directions[:, 1], directions[:, 0], directions[:, 2]], -1)  # e3 x a
    return wrench(directions, shoulders)  # the same screw as a force along the axis


def axes() -> Array:
    """Directions (3, 3) of the motors' axes, s_i x e3."""
    half = np.sqrt(0.75)
    return np.array([(0, -1, 0), (half, 0.5, 0), (-half, 0.5, 0)])


__all__ = [
    "BASE",
    "BODIES",
    "FOREARMS",
    "PLATFORM",
    "UPPER_ARMS",
    "DeltaGeometry",
    "JointObjects",
    "Pose",
    "joint_objects",
    "motor_twists",
    "pose",
]
