"""Coordinates of a robot: where those of each joint are in arrays, and arrays by the names of joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, ShapeError, suggest
from ...common.validation import broadcast_shapes, real_array
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ...mechanics.arguments import multivector_of
from ..trees.frame_joints import FrameJoint
from .description import BY_MOTOR, RobotJoint
from .frames import rotation_to
from .tree import LinkTree

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Coordinates of a robot.

    Attributes
    ----------
    x : array (..., n)
        In the order of `Robot.joint_names`.
    motors : dict of str to Multivector (...)
        Displacements at joints that are balls, planar or floating, by name; the identity where there is none.
    shape : tuple
        Of the batch.
    """

    x: Array
    motors: dict[str, Multivector]
    shape: tuple[int, ...]


def read_coordinates(robot: LinkTree, q: Any) -> Coordinates:
    """Coordinates by name, or in the order of the joints; zero where there are none.

    Raises
    ------
    InputError, ShapeError
        If a name is not that of a joint with coordinates of its own, or numbers are missing.
    """
    names = robot.joint_names
    if q is None:
        return Coordinates(np.zeros(len(names)), {}, ())
    if not isinstance(q, Mapping):
        x = np.asarray(real_array(q, "q"), np.float64)
        if x.ndim and x.shape[-1] == robot.nq != len(names):
            return _split_coordinates(robot, x)
        if x.ndim < 1 or x.shape[-1] != len(names):
            given = x.shape[-1] if x.ndim else 1
            rest = f"; there is none for {', '.join(names[given:])}" if x.ndim and given < len(names) else ""
            raise ShapeError(
                f"q has shape {x.shape}; it ends in {len(names)}, a number for each of {', '.join(names)}{rest}."
            )
        return Coordinates(x, {}, x.shape[:-1])
    values, motors = dict[str, Array](), dict[str, Multivector]()
    free = [joint.name for joint in robot.joints.values() if joint.type in BY_MOTOR]
    for name, value in q.items():
        if name in free:
            motors[name] = multivector_of(value, robot.algebra, f"q[{name!r}]").as_kind("motor")
        elif name in names:
            values[name] = np.asarray(real_array(value, f"q[{name!r}]"), np.float64)
        elif name in robot.followers:
            raise InputError(
                f"{name!r} follows {robot.followers[name].joint!r}: it has no coordinate of its own.",
                remedy="Give that one, or load the file with mimic='free'",
            )
        else:
            raise InputError(f"{name!r} is not a moving joint of {robot.name!r}{suggest(name, (*names, *free))}.")
    shapes = {name: value.shape for name, value in values.items()} | {n: m.shape for n, m in motors.items()}
    shape = broadcast_shapes({f"q[{name!r}]": each for name, each in shapes.items()})
    x = np.zeros((*shape, len(names)))
    for i, name in enumerate(names):
        if name in values:
            x[..., i] = values[name]
    return Coordinates(x, motors, shape)


def joint_axes(joint: RobotJoint) -> Array:
    """Axes (3, 3) of the coordinates of a joint of several freedoms, as columns in the child's frame."""
    return rotation_to(joint.axis) if joint.type == "planar" else np.eye(3)


def _split_coordinates(robot: LinkTree, x: Array) -> Coordinates:
    """Coordinates (..., nq) of all joints: numbers of those with one each, and motors of the others."""
    algebra, motors, slices = robot.algebra, dict[str, Multivector](), robot.coordinate_slices
    for name, part in slices.items():
        joint = robot.joints[name]
        if joint.type in BY_MOTOR:
            frame = FrameJoint(name, joint.type, part.start, 0, 0, joint_axes(joint)).frame(x)
            rotor = algebra.wrap(algebra.kind("rotor"), np.ascontiguousarray(frame[..., 3:]))
            motors[name] = (algebra.translator(np.ascontiguousarray(frame[..., :3])) * rotor).as_kind("motor")
    return Coordinates(x[..., [slices[name].start for name in robot.joint_names]], motors, x.shape[:-1])


def joined_coordinates(robot: LinkTree, q: Any) -> Array:
    """Coordinates (..., nq) of all joints, of those by name: see `read_coordinates`."""
    given = read_coordinates(robot, q)
    found = np.broadcast_to(robot.neutral, (*given.shape, robot.nq)).copy()
    for i, name in enumerate(robot.joint_names):
        found[..., robot.coordinate_slices[name]] = given.x[..., i : i + 1]
    for name, motor in given.motors.items():
        rotor = evaluate(robot.algebra, "motions.motor_parts", motor).values[0]
        joint = robot.joints[name]
        position = robot.algebra.matrix(motor)[..., :3, 3]
        frame = FrameJoint(name, joint.type, 0, 0, 0, joint_axes(joint))
        part = frame.coordinates(position, np.asarray(rotor.as_kind("rotor", check=False).values))
        found[..., robot.coordinate_slices[name]] = part
    return found


def joined_speeds(robot: LinkTree, values: Mapping[str, Any], what: str) -> Array:
    """Speeds, accelerations or forces (..., nv) by the names of joints, zero where there are none.

    Raises
    ------
    InputError, ShapeError
    """
    slices, parts = robot.speed_slices, dict[str, Array]()
    for name, value in values.items():
        title = f"{what}[{name!r}]"
        if name not in slices:
            raise InputError(f"{title}: there is no such joint with coordinates{suggest(name, slices)}.")
        size = slices[name].stop - slices[name].start
        if robot.joints[name].type in BY_MOTOR:
            parts[name] = np.asarray(real_array(value, title, (..., size)), np.float64)
        else:
            parts[name] = np.asarray(real_array(value, title), np.float64)[..., None]
    shape = broadcast_shapes({f"{what}[{name!r}]": part.shape[:-1] for name, part in parts.items()})
    found = np.zeros((*shape, robot.nv))
    for name, part in parts.items():
        found[..., slices[name]] = part
    return found
