"""The Delta robot as bodies and joints at known poses: as a `Mechanism`, and as the constraint matrix of the thesis."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....dynamics import twist
from ....kinematics import Mechanism, Poses, Revolute, Spherical
from ....kinematics.delta.geometry import BASE, BODIES, CORNER_OF_ROD, Pose, axes, joint_objects
from ....kinematics.delta.robot import DeltaRobot
from ...harness.algebras import cga3d
from ...harness.study import Array

#: Angles of the mechanism's own pose.
HOME = 0.3
#: Bodies are three upper arms, six rods and the platform; fifteen joints take so many freedoms.
ARMS, PLATFORM, ROWS = 3, 9, 51


class JointedRobot(NamedTuple):
    """The robot as bodies and joints.

    Attributes
    ----------
    mechanism : Mechanism
    poses : Poses (n,)
    motors : list of Joint
    point : array (3,)
        The platform's center in the mechanism's own pose.
    twists : Multivector (3,)
        The platform's twists along the axes.
    """

    mechanism: Mechanism
    poses: Poses
    motors: list[Any]
    point: Array
    twists: Any

    def repeated_poses(self, count: int) -> Poses:
        """Repetition of all poses."""
        values = np.tile(self.poses.own, (count, 1, 1))
        return type(self.poses)(self.mechanism, values, *(np.zeros(len(values), t) for t in (float, np.uint8)))

    def jacobian(self, poses: Any, is_inverse: bool, method: str) -> Array:
        """J or J*; NaN where the mechanism says that there is none."""
        inputs_outputs: tuple[Any, Any] = (self.motors, [("platform", self.point)])
        if is_inverse:
            inputs_outputs = (("platform", self.twists), self.motors)
        values, codes = self.mechanism.jacobian(*inputs_outputs, poses=poses, method=method, status=True, threads=1)
        return np.where((np.asarray(codes, int) == 0)[..., None, None], values, np.nan)


def jointed_robot(robot: DeltaRobot, points: Pose, position: Array) -> JointedRobot:
    """The fifteen joints at `HOME`, and the motors of the bodies from there to other points (n), at some position."""
    home = robot.pose(np.full(3, HOME))
    moved = home._replace(**{x: getattr(home, x) + position for x in ("shoulders", "tops", "corners")})
    joints = [(Revolute if a == BASE else Spherical)(a, b, x) for a, b, x in joint_objects(robot, moved).incidences()]
    mechanism = Mechanism(BODIES, BASE, joints)
    motors = [_rotation_motors(home.shoulders[i] + position, axes()[i], points.theta[:, i] - HOME) for i in range(3)]
    for k in range(6):
        ends = (home.tops[k], home.bottoms[k], points.tops[:, k], points.bottoms[:, k])
        motors.append(_rod_motors(*(x + position for x in ends)))
    motors.append(cga3d.translator(points.position - home.position).as_kind("motor").values)
    values, none = np.stack(motors, 1), np.zeros(len(points.theta))
    poses = Poses(mechanism, mechanism.motors_from_world(values), none, none.astype(np.uint8))
    return JointedRobot(mechanism, poses, joints[:3], home.position + position, twist(np.zeros((3, 3)), np.eye(3)))


def _rotation_motors(position: Array, axis: Array, angle: Array) -> Array:
    """Motors (n, 8) of rotations about an axis."""
    about = cga3d.translator(position)
    return np.asarray((about * cga3d.rotor(axis, angle) * ~about).as_kind("motor").values)


def _rod_motors(top: Array, bottom: Array, tops: Array, bottoms: Array) -> Array:
    """Motors (n, 8) that take one rod to others (n, 3), by the smaller rotation."""
    before, after = bottom - top, bottoms - tops
    axis = np.cross(before, after)
    size = np.linalg.norm(axis, axis=-1)
    angle = np.arctan2(size, after @ before)
    axis = np.where((size > 0)[:, None], axis, (1.0, 0.0, 0.0))
    motors = cga3d.translator(tops) * cga3d.rotor(axis, angle) * ~cga3d.translator(top)
    return np.asarray(motors.as_kind("motor").values)


# -- the thesis's constraint matrix -------------------------------------------------------------------------


def constraints(points: Pose, position: Array) -> Array:
    """The 51 rows of the fifteen joints (7.7.3) on the 60 coefficients of ten twists: (n, 51, 60).

    Bodies as in `kinematics.delta.geometry.BODIES` without the base; a twist is w and the velocity v at the origin.
    """
    rows, at = np.zeros((len(points.theta), ROWS, 6 * (PLATFORM + 1))), 0
    for i, axis in enumerate(axes()):
        across = np.linalg.svd(axis[None])[2][1:]
        rows[:, at : at + 2, 6 * i : 6 * i + 3] = across
        rows[:, at + 2 : at + 5, 6 * i : 6 * i + 6] = _velocity(points.shoulders[:, i] + position)
        at += 5
    for k in range(6):
        for a, b, p in (
            (k // 2, ARMS + k, points.tops[:, k]),
            (ARMS + k, PLATFORM, points.corners[:, CORNER_OF_ROD[k]]),
        ):
            block = _velocity(p + position)
            rows[:, at : at + 3, 6 * a : 6 * a + 6] = -block
            rows[:, at : at + 3, 6 * b : 6 * b + 6] = block
            at += 3
    return rows


def _velocity(points: Array) -> Array:
    """Jacobians of the velocities of points (n, 3) by a twist: (n, 3, 6)."""
    rows = np.zeros((len(points), 3, 6))
    rows[:, :, 3:] = np.eye(3)
    rows[:, :, :3] = np.cross(np.eye(3), points[:, None]).swapaxes(-1, -2)
    return rows


def forward_jacobian(points: Pose, position: Array) -> Array:
    """y = -U C_u^+ C_k K x (7.25), the columns split: the upper arms' twists are known (n, 3, 3)."""
    known, unknown = np.split(constraints(points, position), [6 * ARMS], axis=2)
    rates = np.zeros((len(known), 6 * ARMS, ARMS))
    for i, axis in enumerate(axes()):
        rates[:, 6 * i : 6 * i + 3, i] = axis
        rates[:, 6 * i + 3 : 6 * i + 6, i] = np.cross(points.shoulders[:, i] + position, axis)
    twists = -np.linalg.pinv(unknown) @ known @ rates
    return np.asarray(_velocity(points.position + position) @ twists[:, -6:])


def inverse_jacobian(points: Pose, position: Array) -> Array:
    """The same with the platform's twist known (n, 3, 3)."""
    unknown, known = np.split(constraints(points, position), [6 * PLATFORM], axis=2)
    twists = -np.linalg.pinv(unknown) @ known[:, :, 3:]
    speeds = [np.einsum("k,nkj->nj", axis, twists[:, 6 * i : 6 * i + 3]) for i, axis in enumerate(axes())]
    return np.stack(speeds, 1)
