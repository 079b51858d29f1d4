"""The Delta robot as bodies and joints at known poses: as a `Mechanism`, and as the constraint matrix of the thesis."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ...kinematics import Mechanism, Poses
    from ...kinematics.delta import DeltaRobot
    from ...kinematics.delta_geometry import Pose

Array = NDArray[Any]
#: Angles of the mechanism's own pose.
HOME = 0.3
#: Bodies are three upper arms, six rods and the platform; fifteen joints take so many freedoms.
ARMS, PLATFORM, ROWS = 3, 9, 51


class Held(NamedTuple):
    """The robot as bodies and joints.

    Attributes
    ----------
    mechanism : Mechanism
    poses : Poses (n,)
    motors : list of Joint
    point : array (3,)
        The platform's centre in the mechanism's own pose.
    ways : Multivector (3,)
        The platform's twists along the axes.
    """

    mechanism: Mechanism
    poses: Poses
    motors: list[Any]
    point: Array
    ways: Any

    def copied(self, count: int) -> Poses:
        """All poses, so often."""
        values = np.tile(self.poses.own, (count, 1, 1))
        return type(self.poses)(self.mechanism, values, *(np.zeros(len(values), t) for t in (float, np.uint8)))

    def jacobian(self, poses: Any, back: bool, method: str) -> Array:
        """J or J*; NaN where the mechanism says that there is none."""
        given: tuple[Any, Any] = (self.motors, [("platform", self.point)])
        if back:
            given = (("platform", self.ways), self.motors)
        values, codes = self.mechanism.jacobian(*given, poses=poses, method=method, status=True, threads=1)
        found: Array = np.where((np.asarray(codes, int) == 0)[..., None, None], values, np.nan)
        return found


def held(robot: DeltaRobot, points: Pose, place: Array) -> Held:
    """The fifteen joints at `HOME`, and the motors of the bodies from there to other points (n), all at some place."""
    from ... import cga3d as cga
    from ...dynamics import twist
    from ...kinematics import Mechanism, Poses, Revolute, Spherical
    from ...kinematics.delta_geometry import BASE, BODIES, axes, joint_objects

    home = robot.pose(np.full(3, HOME))
    moved = home._replace(**{x: getattr(home, x) + place for x in ("shoulders", "tops", "corners")})
    joints = [(Revolute if a == BASE else Spherical)(a, b, x) for a, b, x in joint_objects(robot, moved).shared()]
    mechanism = Mechanism(BODIES, BASE, joints)
    motors = [_turned(home.shoulders[i] + place, axes()[i], points.theta[:, i] - HOME) for i in range(3)]
    for k in range(6):
        ends = (home.tops[k], home.bottoms[k], points.tops[:, k], points.bottoms[:, k])
        motors.append(_swung(*(x + place for x in ends)))
    motors.append(cga.translator(points.position - home.position).as_kind("motor").values)
    values, none = np.stack(motors, 1), np.zeros(len(points.theta))
    poses = Poses(mechanism, mechanism.motors_from_world(values), none, none.astype(np.uint8))
    return Held(mechanism, poses, joints[:3], home.position + place, twist(np.zeros((3, 3)), np.eye(3)))


def _turned(place: Array, axis: Array, angle: Array) -> Array:
    """Motors (n, 8) of turns about an axis."""
    from ... import cga3d as cga

    about = cga.translator(place)
    found: Array = (about * cga.rotor(axis, angle) * ~about).as_kind("motor").values
    return found


def _swung(top: Array, bottom: Array, tops: Array, bottoms: Array) -> Array:
    """Motors (n, 8) that take one rod to others (n, 3), the short way."""
    from ... import cga3d as cga

    before, after = bottom - top, bottoms - tops
    axis = np.cross(before, after)
    size = np.linalg.norm(axis, axis=-1)
    angle = np.arctan2(size, after @ before)
    axis = np.where((size > 0)[:, None], axis, (1.0, 0.0, 0.0))
    found: Array = (cga.translator(tops) * cga.rotor(axis, angle) * ~cga.translator(top)).as_kind("motor").values
    return found


# -- the thesis's constraint matrix -------------------------------------------------------------------------


def constraints(points: Pose, place: Array) -> Array:
    """The 51 rows of the fifteen joints (7.7.3) on the 60 coefficients of ten twists: (n, 51, 60).

    Bodies as in `kinematics.delta_geometry.BODIES` without the base; a twist is w and the velocity v at the origin.
    """
    from ...kinematics.delta_geometry import CORNER_OF_ROD, axes

    made, at = np.zeros((len(points.theta), ROWS, 6 * (PLATFORM + 1))), 0
    for i, axis in enumerate(axes()):
        across = np.linalg.svd(axis[None])[2][1:]
        made[:, at : at + 2, 6 * i : 6 * i + 3] = across
        made[:, at + 2 : at + 5, 6 * i : 6 * i + 6] = _velocity(points.shoulders[:, i] + place)
        at += 5
    for k in range(6):
        for a, b, p in (
            (k // 2, ARMS + k, points.tops[:, k]),
            (ARMS + k, PLATFORM, points.corners[:, CORNER_OF_ROD[k]]),
        ):
            block = _velocity(p + place)
            made[:, at : at + 3, 6 * a : 6 * a + 6] = -block
            made[:, at : at + 3, 6 * b : 6 * b + 6] = block
            at += 3
    return made


def _velocity(points: Array) -> Array:
    """Of points (n, 3) for a twist: (n, 3, 6)."""
    made = np.zeros((len(points), 3, 6))
    made[:, :, 3:] = np.eye(3)
    made[:, :, :3] = np.cross(np.eye(3), points[:, None]).swapaxes(-1, -2)
    return made


def forward_jacobian(points: Pose, place: Array) -> Array:
    """y = -U C_u^+ C_k K x (7.25), the columns split: the upper arms' twists are known (n, 3, 3)."""
    from ...kinematics.delta_geometry import axes

    known, unknown = np.split(constraints(points, place), [6 * ARMS], axis=2)
    turns = np.zeros((len(known), 6 * ARMS, ARMS))
    for i, axis in enumerate(axes()):
        turns[:, 6 * i : 6 * i + 3, i] = axis
        turns[:, 6 * i + 3 : 6 * i + 6, i] = np.cross(points.shoulders[:, i] + place, axis)
    twists = -np.linalg.pinv(unknown) @ known @ turns
    found: Array = _velocity(points.position + place) @ twists[:, -6:]
    return found


def inverse_jacobian(points: Pose, place: Array) -> Array:
    """The same with the platform's twist known (n, 3, 3)."""
    from ...kinematics.delta_geometry import axes

    unknown, known = np.split(constraints(points, place), [6 * PLATFORM], axis=2)
    twists = -np.linalg.pinv(unknown) @ known[:, :, 3:]
    speeds = [np.einsum("k,nkj->nj", axis, twists[:, 6 * i : 6 * i + 3]) for i, axis in enumerate(axes())]
    return np.stack(speeds, 1)
