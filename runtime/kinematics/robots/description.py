"""Robots as data, of whichever format: links in a tree of joints, inertias, and joints that close loops."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import suggest
from ...common.validation import as_choice

Array = NDArray[Any]
#: Types of joints with one coordinate.
MOVING = ("revolute", "continuous", "prismatic", "screw")
#: What becomes of the root of a file.
BASES = ("fixed", "floating")
#: Types of joints whose displacement is a motor.
BY_MOTOR = ("ball", "planar", "floating")
ORIGIN = np.zeros(3)


@dataclass(frozen=True)
class Follower:
    """A coordinate that follows another: ``multiplier`` times that of ``joint``, plus ``offset``."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class RobotJoint:
    """A joint of a robot's tree.

    Attributes
    ----------
    name, parent, child : str
    type : str
        "revolute", "continuous" (revolute without limits), "prismatic", "screw"; "fixed"; "ball", "planar", "floating".
    origin : array (4, 4)
        Pose of the child's frame in the parent's, at coordinate zero.
    axis : array (3,)
        A unit vector in the child's frame; the normal of a planar joint.
    limits : array (2,)
        Least and greatest coordinate; infinite by default.
    position : array (3,)
        A point of the axis, in the child's frame.
    pitch : float
        Advance of a screw joint along its axis, for each radian.
    follows : Follower, optional
        Another joint, which decides the coordinate.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: Array
    axis: Array
    limits: Array
    position: Array = field(default_factory=ORIGIN.copy)
    pitch: float = 0.0
    follows: Follower | None = None


@dataclass(frozen=True, eq=False)
class LinkInertia:
    """Mass, and the tensor (3, 3) about the center of mass along the axes of ``origin`` (4, 4) in the link's frame."""

    mass: float
    tensor: Array
    origin: Array

    @property
    def center(self) -> Array:
        """Center of mass (3,) in the link's frame."""
        return self.origin[:3, 3]

    @property
    def tensor_along_link(self) -> Array:
        """Tensor (3, 3) about the center of mass, along the axes of the link's frame."""
        rotation = self.origin[:3, :3]
        return np.asarray(rotation @ self.tensor @ rotation.T)


@dataclass(frozen=True, eq=False)
class LoopJoint:
    """A joint that closes a loop of the tree.

    Attributes
    ----------
    name, a, b : str
        Of the joint, and of its links.
    type : str
        As of `RobotJoint`.
    frame_a, frame_b : array (4, 4)
        Frame of the joint in each link's: they are one where the loop is closed, at the joint's coordinate zero.
    axis : array (3,)
        In the joint's frame.
    """

    name: str
    type: str
    a: str
    b: str
    frame_a: Array
    frame_b: Array
    axis: Array
    pitch: float = 0.0


@dataclass(frozen=True, eq=False)
class Description:
    """A robot: see `Robot`, which has the same attributes.

    Attributes
    ----------
    name, path : str
    links : tuple of str
    joints : dict of str to RobotJoint
    inertias : dict of str to LinkInertia
    loops : tuple of LoopJoint
    """

    name: str
    path: str
    links: tuple[str, ...]
    joints: dict[str, RobotJoint]
    inertias: dict[str, LinkInertia] = field(default_factory=dict)
    loops: tuple[LoopJoint, ...] = ()


def on_base(description: Description, base: str) -> Description:
    """The robot with its root fixed, or "floating": on a joint "root_joint" before all others, in a root "world"."""
    if as_choice(base, "base", BASES) == "fixed":
        return description
    root = next(name for name in description.links if name not in {j.child for j in description.joints.values()})
    world, name = unused_name("world", description.links), unused_name("root_joint", description.joints)
    infinite = np.array([-np.inf, np.inf])
    joint = RobotJoint(name, "floating", world, root, np.eye(4), np.array([0.0, 0.0, 1.0]), infinite)
    return replace(description, links=(world, *description.links), joints={name: joint} | description.joints)


def unused_name(name: str, used_names: Iterable[str]) -> str:
    """A joint's name, which no link has."""
    while name in used_names:
        name += "_joint"
    return name


def with_leaders(joints: Mapping[str, RobotJoint], error: Any) -> dict[str, RobotJoint]:
    """Joints whose followers follow joints with coordinates of their own: followers of followers are composed.

    Parameters
    ----------
    joints : mapping
    error : callable
        ``error(joint, what, remedy)`` makes an error of a joint.
    """
    resolved: dict[str, RobotJoint] = {}
    for joint in joints.values():
        path: dict[str, RobotJoint] = {}
        while joint.name not in resolved and joint.name not in path:
            path[joint.name] = joint
            if joint.follows is None:
                break
            joint = _leader(joints, joint, error)
        if joint.name in path and joint.follows is not None:
            raise error(joint, "joints follow each other in a circle, as in", "Let one of them move by itself")
        for each in reversed(path.values()):
            resolved[each.name] = each
            if each.follows is not None and (above := resolved[each.follows.joint].follows) is not None:
                k, c = each.follows.multiplier, each.follows.offset
                follows = Follower(above.joint, k * above.multiplier, k * above.offset + c)
                resolved[each.name] = replace(each, follows=follows)
    return {name: resolved[name] for name in joints}


def _leader(joints: Mapping[str, RobotJoint], joint: RobotJoint, error: Any) -> RobotJoint:
    """The joint that another follows."""
    assert joint.follows is not None
    name = joint.follows.joint
    leader = joints.get(name)
    if leader is None:
        raise error(joint, f"there is no joint {name!r} to follow{suggest(name, joints)}, as in", None)
    if leader.type not in MOVING:
        raise error(
            joint, f"{name!r} is {leader.type} and has no coordinate to follow, as in",
            "Name a joint with one coordinate, or load the file with mimic='free'",
        )  # fmt: skip
    return leader


def joints_from_root(joints: Iterable[RobotJoint], root: str) -> list[RobotJoint]:
    """Joints, parents first."""
    below: dict[str, list[RobotJoint]] = {}
    for joint in joints:
        below.setdefault(joint.parent, []).append(joint)
    ordered, front = [], [root]
    while front:
        children = below.get(front.pop(), [])
        ordered += children
        front += [joint.child for joint in children]
    return ordered


def homogeneous(rotation: Any, position: Any) -> Array:
    """Matrix (4, 4) of a rotation (3, 3) and a position (3,)."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, position
    return matrix


def displacement(joint: RobotJoint, x: float) -> Array:
    """Matrix (4, 4) of a joint with one coordinate, in the child's frame at zero."""
    axis, matrix = joint.axis, np.eye(4)
    if joint.type == "prismatic":
        matrix[:3, 3] = x * axis
        return matrix
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    matrix[:3, :3] += np.sin(x) * cross + 2 * np.sin(x / 2) ** 2 * (cross @ cross)
    matrix[:3, 3] = joint.position - matrix[:3, :3] @ joint.position + joint.pitch * x * axis
    return matrix


def zero_frames(joints: Iterable[RobotJoint], root: str) -> dict[str, Array]:
    """Frames (4, 4) of all links in the root's, where coordinates are zero and followers where these put them."""
    frames = {root: np.eye(4)}
    for joint in joints_from_root(joints, root):
        frame = frames[joint.parent] @ joint.origin
        if joint.follows is not None and joint.follows.offset:
            frame = frame @ displacement(joint, joint.follows.offset)
        frames[joint.child] = frame
    return frames
