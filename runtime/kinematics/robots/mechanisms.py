"""Mechanisms of robots: links as bodies, at a pose, with couplings and the joints that close loops."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...codegen.errors import InputError
from ...core.multivector import Multivector
from ...mechanics.joints.base import Joint
from ...mechanics.joints.displaced import DisplacedJoint
from ..mechanism.mechanism import Mechanism
from .description import LoopJoint, RobotJoint, homogeneous, unused_name
from .shared_joints import shared_joint

if TYPE_CHECKING:
    from .poses import PosedTree

#: Gaps of loops that are rounding errors, in lengths of the robot.
CLOSED = 1e-12


def robot_mechanism(robot: PosedTree, q: Any, root: str | None) -> Mechanism:
    """See `Robot.mechanism`."""
    start = robot.root if root is None else root
    robot.joints_to_root(start)  # checks the name
    parts = robot.parts
    floating = next((j for j in robot.joints.values() if parts[j.child] != parts[robot.root]), None)
    if floating is not None and root is None:
        raise InputError(
            f"{floating.name!r} is floating: nothing holds {floating.child!r} to the rest.", where=robot.path,
            remedy=f"Take the parts, such as mechanism(root={floating.child!r})",
        )  # fmt: skip
    links = [name for name in robot.links if parts[name] == parts[start]]
    mechanism, poses, names = Mechanism(links, start), robot.pose_at(q), {}
    for joint in robot.joints.values():
        if joint.child in links and joint.parent in links and joint.type != "floating":
            names[joint.name] = unused_name(joint.name, links)
            mechanism.add(joint_of_links(robot, joint, poses), names[joint.name])
    for loop in robot.loops:
        if loop.a in links and loop.b in links:
            name = unused_name(loop.name, {*links, *names.values()})
            names[f"loop {name}"] = name
            mechanism.add(loop_joint(robot, loop, poses, loop.a, loop.b), name)
    for row in robot.couplings([name for name in names if name in robot.joints]):
        mechanism.couple({names[name]: ratio for name, ratio in row.items()})
    return mechanism


def joint_of_links(
    robot: PosedTree, joint: RobotJoint, poses: Mapping[str, Multivector], a: str | None = None, b: str | None = None
) -> Joint:
    """The joint as geometry that two bodies share: its links, or the named ones."""
    matrix = robot.algebra.matrix(poses[joint.child])
    position = matrix[:3, :3] @ joint.position + matrix[:3, 3] if joint.position.any() else matrix[:3, 3]
    axis = matrix[:3, :3] @ joint.axis
    return shared_joint(robot.algebra, joint.type, a or joint.parent, b or joint.child, position, axis, joint.pitch)


def loop_joint(robot: PosedTree, loop: LoopJoint, poses: Mapping[str, Multivector], a: str, b: str) -> Joint:
    """A joint that closes a loop, between two bodies, closed or not."""
    at_a, at_b = (
        robot.algebra.matrix(poses[link]) @ frame for link, frame in ((loop.a, loop.frame_a), (loop.b, loop.frame_b))
    )
    joint = shared_joint(robot.algebra, loop.type, a, b, at_a[:3, 3], at_a[:3, :3] @ loop.axis, loop.pitch)
    gap = at_b @ np.linalg.inv(at_a)
    if loop.type == "ball":
        gap = homogeneous(np.eye(3), at_b[:3, 3] - at_a[:3, 3])
    if np.abs(gap - np.eye(4)).max() <= CLOSED * (1 + robot.size):
        return joint
    one = robot.algebra.translator(np.zeros(3)).as_kind("motor")
    return DisplacedJoint(joint, one, robot.algebra.motor_from_matrix(gap).as_kind("motor"))
