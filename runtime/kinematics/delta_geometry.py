"""The whole Delta robot at a pose: its points, and the geometry that its bodies share (thesis 7.7.1, 7.7.3)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..loading import stock_algebra
from ..multivector import Multivector
from . import delta_calls as calls
from .joints import Joint, Revolute, Spherical

if TYPE_CHECKING:
    from .delta import DeltaRobot

Array = NDArray[Any]
#: Bodies, as mechanisms name them.
BASE, PLATFORM = "base", "platform"
UPPER_ARMS = tuple(f"upper_arm_{i}" for i in (1, 2, 3))
FOREARMS = tuple(f"forearm_{i}" for i in range(1, 7))
BODIES = (BASE, *UPPER_ARMS, *FOREARMS, PLATFORM)
#: The corner of the platform at which each rod ends: P_10, P_11 or P_12. Neighbouring arms share theirs.
CORNER_OF_ROD = (0, 1, 1, 2, 2, 0)
#: A rod that ends at each corner.
_ROD_AT_CORNER = (0, 1, 3)
#: The thesis's numbers of the upper ball joints.
TOPS = (2, 3, 5, 6, 8, 9)


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


def pose(robot: DeltaRobot, y: Array, theta: Array) -> Pose:
    """The points for positions and the angles that belong to them."""
    found, _ = calls.evaluate("delta_frame.points", [y, theta, robot._row, robot._plates])
    missing = np.asarray(~(np.isfinite(y).all(-1) & np.isfinite(theta).all(-1)))
    shoulders, elbows, wrists, tops, bottoms = (
        np.where(missing[..., None, None], np.nan, x.reshape(*x.shape[:-1], -1, 3)) for x in found
    )
    return Pose(y, theta, shoulders, elbows, wrists, tops, bottoms, bottoms[..., _ROD_AT_CORNER, :])


class JointObjects(NamedTuple):
    """What the bodies share.

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

    def shared(self) -> list[tuple[str, str, Multivector]]:
        """The fifteen joints: two bodies and their object (...), in the order of 7.7.3 (circles, tops, corners)."""
        hinges = [(BASE, arm, self.circles[..., i]) for i, arm in enumerate(UPPER_ARMS)]
        upper = [(UPPER_ARMS[k // 2], rod, self.tops[..., k]) for k, rod in enumerate(FOREARMS)]
        lower = [(rod, PLATFORM, self.corners[..., CORNER_OF_ROD[k]]) for k, rod in enumerate(FOREARMS)]
        return [*hinges, *upper, *lower]

    def joints(self) -> list[Joint]:
        """The same as joints of a mechanism, for one pose."""
        return [(Revolute if a == BASE else Spherical)(a, b, x) for a, b, x in self.shared()]


def joint_objects(robot: DeltaRobot, found: Pose) -> JointObjects:
    """Circles and points of a pose."""
    cga = stock_algebra("cga3d")
    circles = cga.circle(found.shoulders, axes(), robot.upper_arm)
    return JointObjects(circles, cga.point(found.tops), cga.point(found.corners))


def motor_twists(robot: DeltaRobot) -> Multivector:
    """Unit twists (3,) of the upper arms, a I3 + (B x a) n: the dual lines of P_1, P_4, P_7, normalised (7.7.4)."""
    from ..dynamics.screws import wrench

    turn = axes()
    shoulders = robot.base_radius * np.stack([-turn[:, 1], turn[:, 0], turn[:, 2]], -1)  # s = e3 x a
    return wrench(turn, shoulders)  # the same screw as a force along the axis


def axes() -> Array:
    """The motors' axes s_i x e3, (3, 3)."""
    half = np.sqrt(0.75)
    return np.array([(0, -1, 0), (half, 0.5, 0), (-half, 0.5, 0)])


__all__ = [
    "BASE",
    "BODIES",
    "FOREARMS",
    "PLATFORM",
    "UPPER_ARMS",
    "JointObjects",
    "Pose",
    "joint_objects",
    "motor_twists",
    "pose",
]
