"""Systems of robots: lumps as bodies, with inertias that bodies can have, for simulations."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...codegen.errors import InputError
from ...common.validation import as_choice
from ...core.multivector import Multivector
from ...mechanics.joints.base import Joint
from ...mechanics.joints.standard import Rigid
from ...mechanics.rigid_body import RigidBody
from ...mechanics.system import System
from .compound_joints import compound_joint
from .coordinates import read_coordinates
from .description import RobotJoint, unused_name
from .inertias import CHOICES, possible_inertia, warn_of_changes
from .mechanisms import joint_of_links, loop_joint

if TYPE_CHECKING:
    from .poses import PosedTree

#: What becomes of the root and of joints that follow others.
BASES = ("fixed", "free")
FOLLOWERS = ("couple", "lock", "free")


def robot_bodies(
    robot: PosedTree, poses: Mapping[str, Multivector], inertia: str | None, base: str, level: int
) -> dict[str, RigidBody]:
    """Bodies of the lumps, by name: see `Robot.bodies`."""
    as_choice(base, "base", BASES)
    default = "nearest" if robot.impossible == "nearest" else "given"
    choice = as_choice(default if inertia is None else inertia, "inertia", CHOICES)
    bodies, changes = {}, list[str]()
    for name, lump in robot.lumps.items():
        if (name == robot.root and base == "fixed") or lump.inertia is None or lump.inertia.mass == 0:
            continue
        try:
            possible = possible_inertia(lump.inertia, lump.words, robot.size, choice, changes)
            frame = robot.algebra.matrix(poses[name]) @ possible.origin
            motor = robot.algebra.motor_from_matrix(frame)
            bodies[name] = RigidBody(possible.mass, possible.tensor, orientation=motor, algebra=robot.algebra)
        except InputError as error:
            raise InputError(error.what, where=robot.path, remedy=error.remedy) from None
    warn_of_changes(changes, robot.path, level)
    return bodies


def robot_system(robot: PosedTree, q: Any, inertia: str | None, base: str, followers: str) -> System:
    """See `Robot.system`."""
    as_choice(followers, "followers", FOLLOWERS)
    poses = robot.pose_at(q)
    bodies = robot_bodies(robot, poses, inertia, base, 5)
    if not bodies:
        raise _bodies_error(robot)
    if q is None:
        _warn_of_limits(robot)
    if base == "free" and robot.root not in bodies:
        raise InputError(
            f"<link name={robot.root!r}> carries others, and has no mass.", where=robot.path,
            remedy="Give it an <inertial> with a mass, or take system(base='fixed')",
        )  # fmt: skip
    own, joints, indices, names = robot.lump_of, list[Joint](), dict[str, int](), list[str]()
    for joint in robot.joints.values():
        if joint.child not in bodies or joint.type == "floating":
            continue
        path = _massless_path(robot, joint, bodies)
        start = own[path[0].parent]
        if len(path) > 1:
            shared = _compound_joint(robot, path, poses, start)
        elif joint.follows is not None and followers == "lock":
            position = robot.algebra.matrix(poses[joint.child])[:3, 3]
            shared = Rigid(start, joint.child, position, robot.algebra)
        else:
            shared = joint_of_links(robot, joint, poses, start, joint.child)
            indices[joint.name] = len(joints)
        joints.append(shared)
        names.append(joint.name)
    for loop in robot.loops:
        ends = own[loop.a], own[loop.b]
        if ends[0] == ends[1]:
            continue
        for end in ends:
            lump = robot.lumps[end]
            if end not in bodies and lump.joint is not None:
                raise _massless_error(robot, lump.joint)
        joints.append(loop_joint(robot, loop, poses, *ends))
        names.append(unused_name(loop.name, names))
    relations = robot.couplings(indices) if followers == "couple" else []
    couplings = [{(indices[name], 0): ratio for name, ratio in row.items()} for row in relations]
    fixed = robot.root if base == "fixed" else unused_name("world", robot.links)
    return System(bodies, joints, fixed, couplings, names, _coordinates(robot, q, names, joints))


def _coordinates(robot: PosedTree, q: Any, names: list[str], joints: list[Joint]) -> list[float]:
    """Coordinates of joints with one freedom at the start; zero of others."""
    values = dict(zip(robot.joint_names, read_coordinates(robot, q).x.tolist(), strict=True))
    for name, follows in robot.followers.items():
        values[name] = follows.multiplier * values[follows.joint] + follows.offset
    return [float(values.get(n, 0.0)) if j.mobility == 1 else 0.0 for n, j in zip(names, joints, strict=True)]


def _bodies_error(robot: PosedTree) -> InputError:
    """Error of a robot without a body that moves."""
    if len(robot.lumps) == 1:
        return InputError(
            "no joint moves: the robot is one body, and its root is fixed.", where=robot.path,
            remedy="Take system(base='free')",
        )  # fmt: skip
    return InputError(
        "no link that moves has a mass: the file is for kinematics.", where=robot.path,
        remedy="Give its links an <inertial> with a mass, or use poses, chains and the mechanism",
    )  # fmt: skip


def _warn_of_limits(robot: PosedTree) -> None:
    """Warn if limits exclude the zero coordinates, from which a system starts by default."""
    low, high = robot.limits.T
    out = [name for name, bad in zip(robot.joint_names, (low > 0) | (high < 0), strict=True) if bad]
    if out:
        more = f" and {len(out) - 3} more" if len(out) > 3 else ""
        warnings.warn(
            f"{robot.path}: the system starts with all coordinates zero, which limits of {', '.join(out[:3])}{more} "
            "exclude: give q.",
            stacklevel=4,
        )


def _massless_path(robot: PosedTree, joint: RobotJoint, bodies: Mapping[str, RigidBody]) -> list[RobotJoint]:
    """Joints from a body to the lump of another, through lumps without mass that carry nothing else."""
    path, own = [joint], robot.lump_of
    ends = {own[name] for loop in robot.loops for name in (loop.a, loop.b)}
    while (name := own[path[0].parent]) not in bodies and name != robot.root:
        lump = robot.lumps[name]
        behind = [j for j in robot.joints.values() if own[j.parent] == name and j.type != "fixed"]
        assert lump.joint is not None
        if len(behind) > 1 or name in ends or lump.joint.type == "floating":
            raise _massless_error(robot, lump.joint)
        path.insert(0, lump.joint)
    return path


def _compound_joint(robot: PosedTree, path: list[RobotJoint], poses: Mapping[str, Multivector], start: str) -> Joint:
    """The joint that joints without mass between them make."""
    matrices = [robot.algebra.matrix(poses[joint.child]) for joint in path]
    positions = np.stack([m[:3, :3] @ j.position + m[:3, 3] for m, j in zip(matrices, path, strict=True)])
    axes = np.stack([m[:3, :3] @ j.axis for m, j in zip(matrices, path, strict=True)])
    kinds = [joint.type for joint in path]
    leaders = {follows.joint for follows in robot.followers.values()}
    coupled = any(joint.follows is not None or joint.name in leaders for joint in path)
    shared = None
    if not coupled:
        shared = compound_joint(robot.algebra, start, path[-1].child, kinds, positions, axes, robot.size)
    if shared is None:
        raise _massless_error(robot, path[0])
    return shared


def _massless_error(robot: PosedTree, joint: RobotJoint) -> InputError:
    return InputError(
        f"<link name={joint.child!r}> moves by <joint name={joint.name!r}>, carries others, and has no mass.",
        where=robot.path,
        remedy="Give it an <inertial> with a mass; joints without one between them are read if they make a ball, "
        "universal, cylindrical or planar joint together (universal ones in cga3d)",
    )
