"""Links of a robot as its dynamics have them: joints in a tree, inertias of what is welded added up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ..trees.driver import COORDINATE, FRAME, SAME, TreeDriver, TreeParameters
from ..trees.frame_joints import FRAME_SIZE, SIZES, FrameJoint, freedoms
from ..trees.inertias import link_rows, moved
from ..trees.tree import Tree
from .coordinates import joint_axes
from .description import MOVING, LinkInertia, joints_from_root
from .inertias import possible_inertia, refuse_impossible, warn_of_changes
from .lumps import Lump

if TYPE_CHECKING:
    from .tree import LinkTree

Array = NDArray[Any]


def carried_links(robot: LinkTree, fixed: str, joints: Mapping[str, int]) -> dict[str, int]:
    """Number of the joint that carries each link; links that stay with ``fixed`` are left out.

    Other joints are held: what is beyond them goes with the link that they are on.
    """
    neighbors: dict[str, list[tuple[str, int | None]]] = {name: [] for name in robot.links}
    for joint in robot.joints.values():
        number = joints.get(joint.name)
        neighbors[joint.parent].append((joint.child, number))
        neighbors[joint.child].append((joint.parent, number))
    owners: dict[str, int] = {fixed: -1}
    front = [fixed]
    while front:
        link = front.pop()
        for other, number in neighbors[link]:
            if other not in owners:
                owners[other] = owners[link] if number is None else number
                front.append(other)
    return {name: number for name, number in owners.items() if number >= 0}


def lumped_rows(robot: LinkTree, owners: Mapping[str, int], frames: Mapping[str, Array], positions: Array) -> Array:
    """Rows (n, 10) of `Link` about the joints' positions (n, 3), of all links that each joint carries.

    Parameters
    ----------
    owners : mapping
        Of `carried_links`.
    frames : mapping
        Poses (4, 4) of the links' frames where all coordinates are zero.

    Raises
    ------
    InputError
        If nothing that moves has a mass, or an inertia is one that no body can have.
    """
    rows = np.zeros((len(positions), 10))
    lumps = [robot.lumps[name] for name in owners if name in robot.lumps and robot.lumps[name].inertia is not None]
    parts = [(lump.name, part) for lump, each in zip(lumps, valid_parts(robot, lumps), strict=True) for part in each]
    if parts:
        masses = np.array([x.mass for _, x in parts])
        poses = np.stack([frames[name] @ x.origin for name, x in parts])
        centers, tensors = moved(poses, np.zeros((len(parts), 3)), np.stack([x.tensor for _, x in parts]))
        numbers = np.array([owners[name] for name, _ in parts])
        np.add.at(rows, numbers, link_rows(masses, centers - positions[numbers], tensors))
    if not rows.any():
        raise InputError(
            f"no link of {robot.name!r} that moves has an <inertial>: only its kinematics are known.",
            where=robot.path, remedy="Add them to the file, or give those of a chain: chain.with_inertias(...)",
        )  # fmt: skip
    return rows


def valid_parts(robot: LinkTree, lumps: Sequence[Lump]) -> list[tuple[LinkInertia, ...]]:
    """Inertias of the parts of lumps as torques and accelerations need them: together such as a body can have, or as
    `load_urdf` was told.

    Raises
    ------
    InputError
    """
    found, changes = [], list[str]()
    for lump in lumps:
        assert lump.inertia is not None
        parts = lump.parts
        if robot.impossible == "nearest" and lump.inertia.mass > 0:
            nearest = possible_inertia(lump.inertia, lump.words, robot.size, "nearest", changes)
            parts = parts if nearest is lump.inertia else (nearest,)
        elif robot.impossible != "keep":
            refuse_impossible(lump.inertia, lump.words, robot.size, robot.path)
        found.append(parts)
    warn_of_changes(changes, robot.path, 6)
    return found


def robot_tree(robot: LinkTree) -> Tree:
    """Joints and links of a robot, compiled; joints of several freedoms are one for each, one behind the other.

    Raises
    ------
    InputError
        If joints close loops, or nothing has an inertia.
    """
    if robot.loops:
        raise InputError(
            f"{robot.loops[0].name!r} closes a loop: torques and accelerations are those of trees.", where=robot.path,
            remedy="Take those of robot.mechanism(q).with_inertias(robot.bodies(q)), or of a chain",
        )  # fmt: skip
    moving = [j for j in joints_from_root(robot.joints.values(), robot.root) if j.type != "fixed"]
    if not moving:
        raise InputError(f"no joint of {robot.name!r} moves.", where=robot.path)
    at, sizes = robot.frames_at_zero, [SIZES.get(j.type, (1, 1))[1] for j in moving]
    firsts = np.cumsum([0, *sizes])
    last = {j.name: int(row) - 1 for j, row in zip(moving, firsts[1:], strict=True)}
    owners = carried_links(robot, robot.root, last)
    rows, frames, places, place = list[_Row](), list[FrameJoint](), list[int](), 0
    for joint, row in zip(moving, firsts[:-1].tolist(), strict=True):
        turn, parent = at[joint.child][:3, :3], owners.get(joint.parent, -1)
        position = turn @ joint.position + at[joint.child][:3, 3]
        leader = joint.name if joint.follows is None else joint.follows.joint
        coordinate, speed = robot.coordinate_slices[leader].start, robot.speed_slices[leader].start
        if joint.type in MOVING:
            ratio = 1.0 if joint.follows is None else joint.follows.multiplier
            slides = joint.type == "prismatic"
            numbers = (*(turn @ joint.axis), 0.0 if slides else ratio, ratio * (1.0 if slides else joint.pitch))
            rows.append(_Row(position, numbers, parent, COORDINATE, speed, coordinate))
            places.append(place)
            place += 1
            continue
        rotation = turn @ joint_axes(joint)
        frames.append(FrameJoint(joint.name, joint.type, coordinate, place, row, rotation))
        for i, (axis, turns, advance) in enumerate(freedoms(joint.type)):
            above, kind = (parent, FRAME) if i == 0 else (row + i - 1, SAME)
            rows.append(_Row(position, (*(rotation @ axis), turns, advance), above, kind, speed + i, -1))
            places.append(place)
        place += FRAME_SIZE
    positions, parents = np.stack([r.position for r in rows]), np.array([r.parent for r in rows])
    offsets = positions - np.where(parents[:, None] >= 0, positions[parents], 0.0)
    parameters = TreeParameters(
        np.column_stack([offsets, np.array([r.numbers for r in rows])]), lumped_rows(robot, owners, at, positions),
        parents, np.array([r.kind for r in rows]), np.array(places),
    )  # fmt: skip
    movers, sources = np.array([r.speed for r in rows]), np.array([r.coordinate for r in rows])
    if not frames and np.array_equal(movers, np.arange(len(rows))):
        return Tree(TreeDriver(robot.algebra.name, parameters))
    return Tree(TreeDriver(robot.algebra.name, parameters), movers, tuple(frames), sources if frames else None)


class _Row(NamedTuple):
    """A joint of the tree's driver: its position, axis, rotation and advance, and the numbers that move it."""

    position: Array
    numbers: tuple[float, ...]
    parent: int
    kind: int
    speed: int
    coordinate: int


def refuse_followers(robot: LinkTree, followers: Sequence[str]) -> None:
    """Refuse torques and accelerations of a chain with joints that follow others: their leaders move other links."""
    if followers:
        raise InputError(
            f"{followers[0]!r} follows {robot.followers[followers[0]].joint!r}, which may move other links: torques of "
            "the chain alone are not known.", where=robot.path,
            remedy="Take those of the robot, or load the file with mimic='free'",
        )  # fmt: skip
