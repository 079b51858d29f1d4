"""Robots written as MJCF, whole or not at all."""

from __future__ import annotations

import os
import warnings
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.files import output_path, write_file
from ...common.validation import as_instance
from ...mechanics.arguments import MATRIX_TOLERANCE
from ..robots.description import MOVING, LoopJoint, RobotJoint
from ..robots.frames import quaternion_of_rotation
from ..robots.inertias import possible_inertia, refuse_impossible, warn_of_changes

if TYPE_CHECKING:
    from ..robots.robot import Robot

Array = NDArray[Any]
Element = ElementTree.Element
WORLD = "world"
TYPES = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide", "ball": "ball"}
#: What MuJoCo takes for the mass and the moments of what moves, at least.
LEAST_MASS, LEAST_MOMENT = 1e-9, 1e-12
#: Freedoms of joints that have more than one in an MJCF, and what a body there has at most.
FREEDOMS = {"ball": 3, "screw": 2}
MOST_FREEDOMS = 6


def save_mjcf(robot: Robot, path: str | os.PathLike[str]) -> None:
    """Write a robot as an MJCF file for MuJoCo: whole, or not at all.

    Links are bodies, the root one without a joint (the world, if it is called so). A link without mass between two
    joints is left out, and both are in the body behind it. Inertias are those of the lumps of
    welded links, on the link that carries the lump. A planar joint becomes two slides and a hinge, a screw a hinge and
    a slide that follows it; joints that follow others become ``<equality><joint>``, loops ``connect`` and ``weld``.
    Angles are radians; coordinates are those of the robot.

    Parameters
    ----------
    robot : Robot
    path : str or path
        ``.xml`` or ``.mjcf``.

    Raises
    ------
    InputError
        If it cannot be written, or there is no way to say it: a joint that floats below another link, a loop that is
        closed by a sliding joint, an inertia that no body can have.
    """
    from ..robots.robot import Robot as RobotClass

    as_instance(robot, "the robot", RobotClass, "a Robot, as load_urdf makes it")
    file = output_path(path, "a robot", "robots", (".xml", ".mjcf"))
    write_file(file, mjcf_text(robot))


def mjcf_text(robot: Robot) -> str:
    """A robot as the text of an MJCF file."""
    root = Element("mujoco", {"model": robot.name})
    compiler = _add(root, "compiler", angle="radian", autolimits="true", inertiafromgeom="false")
    world = _add(root, "worldbody")
    bodies = {robot.root: world if robot.root == WORLD else _add(world, "body", name=robot.root)}
    equality = Element("equality")
    if robot.root != WORLD and WORLD in robot.links:
        raise InputError("a link is called 'world' and is not the root.", where=robot.path)
    light, kept, changes = list[str](), list[str](), list[str]()
    crossings = _crossings(robot)
    before: dict[str, tuple[str, Array, list[tuple[Array, RobotJoint]]]] = {}
    for joint in robot.joints_in_order:
        # joints that end at a crossing go to the body behind it: where they are then, in its frame
        parent, frame, joints = before.get(joint.parent, (joint.parent, np.eye(4), []))
        joints = [(at @ joint.origin, each) for at, each in joints] + [(np.eye(4), joint)]
        if joint.child in crossings:
            before[joint.child] = parent, frame @ joint.origin, joints
            continue
        bodies[joint.child] = body = _body(bodies[parent], joint.child, frame @ joint.origin)
        for at, each in joints:
            _write_joint(robot, body, equality, each, np.linalg.inv(at))
    for name, lump in robot.lumps.items():
        inertia = lump.inertia
        if inertia is not None and inertia.mass != 0 and bodies[name] is not world:
            if robot.impossible != "keep":
                if robot.impossible != "nearest":
                    refuse_impossible(inertia, lump.words, robot.size, robot.path)
                choice = "nearest" if robot.impossible == "nearest" else "given"
                inertia = possible_inertia(inertia, lump.words, robot.size, choice, changes)
            moments, axes = np.linalg.eigh((inertia.tensor + inertia.tensor.T) / 2)
            most = float(np.maximum(moments, 0.0)[:2].sum())
            if moments[2] - most > MATRIX_TOLERANCE * np.abs(moments).max():
                kept.append(name)
            else:
                moments[2] = min(moments[2], most)  # MuJoCo refuses what rounding has added
            axes = axes * np.array([1.0, 1.0, np.sign(np.linalg.det(axes))])
            rotation = inertia.origin[:3, :3] @ axes
            element = Element("inertial", {
                "pos": _text(inertia.center), "quat": _text(quaternion_of_rotation(rotation)),
                "mass": _text([inertia.mass]), "diaginertia": _text(np.maximum(moments, 0.0)),
            })  # fmt: skip
            bodies[name].insert(0, element)
            if lump.joint is not None and (inertia.mass < LEAST_MASS or moments.min() < LEAST_MOMENT):
                light.append(name)
        elif lump.joint is not None and name not in crossings:
            light.append(name)
            least = {"mass": _text([LEAST_MASS]), "diaginertia": _text(np.full(3, LEAST_MOMENT))}
            bodies[name].insert(0, Element("inertial", {"pos": "0 0 0", **least}))
    warn_of_changes(changes, robot.path, 4)
    if light:
        compiler.set("boundmass", _text([LEAST_MASS]))
        compiler.set("boundinertia", _text([LEAST_MOMENT]))
        warnings.warn(
            f"{robot.path}: bodies that move have {LEAST_MASS:g} kg and {LEAST_MOMENT:g} kg m^2 at least, as MuJoCo "
            f"needs them: {', '.join(light[:5])}{' ...' if len(light) > 5 else ''}.",
            stacklevel=3,
        )
    if kept:
        shown = ", ".join(kept[:5]) + (" ..." if len(kept) > 5 else "")
        warnings.warn(
            f"{robot.path}: MuJoCo will refuse the file: a moment of inertia exceeds the sum of the others, "
            f"and is kept, in {shown}; impossible='nearest' mends them.",
            stacklevel=3,
        )
    for name, follows in robot.followers.items():
        _couple(equality, name, follows.joint, follows.offset, follows.multiplier)
    for loop in robot.loops:
        _write_loop(robot, bodies, equality, loop)
    if len(equality):
        root.append(equality)
    ElementTree.indent(root)
    return ElementTree.tostring(root, "unicode") + "\n"


def _crossings(robot: Robot) -> set[str]:
    """Links without mass between two joints that move: in an MJCF both are in the body behind.

    No rotation follows a ball in a body, and a body has six freedoms at most.
    """
    runs: dict[str, tuple[int, bool]] = {}  # freedoms of the joints that end at a crossing; whether one is a ball
    ends = {name for loop in robot.loops for name in (loop.a, loop.b)}
    found = set[str]()
    for name, lump in robot.lumps.items():  # parents first
        behind = [joint for joint in robot.joints.values() if joint.parent == name]
        if (
            name not in ends and len(lump.links) == 1 and lump.joint is not None and len(behind) == 1
            and lump.joint.type in (*MOVING, "ball") and behind[0].type in (*MOVING, "ball")
            and (lump.inertia is None or lump.inertia.mass == 0)
        ):  # fmt: skip
            freedoms, has_ball = runs.get(lump.joint.parent, (0, False))
            freedoms, has_ball = freedoms + FREEDOMS.get(lump.joint.type, 1), has_ball or lump.joint.type == "ball"
            is_turning = behind[0].type != "prismatic"
            if freedoms + FREEDOMS.get(behind[0].type, 1) > MOST_FREEDOMS or (has_ball and is_turning):
                continue
            runs[name] = freedoms, has_ball
            found.add(name)
    return found


def _write_joint(robot: Robot, body: Element, equality: Element, joint: RobotJoint, into: Array) -> None:
    """Write a joint, given in a frame, by the matrix (4, 4) from there into the body's."""
    name = joint.name
    direction, position = into[:3, :3] @ joint.axis, into[:3, :3] @ joint.position + into[:3, 3]
    if joint.type == "fixed":
        return
    if joint.type == "floating":
        if joint.parent != WORLD or robot.root != WORLD:
            raise InputError(
                f"{name!r} floats relative to {joint.parent!r}; in an MJCF bodies float in the world alone.",
                where=robot.path,
            )
        _add(body, "freejoint", name=name)
        return
    if joint.type == "planar":
        across = np.linalg.svd(joint.axis[None])[2][1:]
        for end, axis, kind in (("_x", across[0], "slide"), ("_y", across[1], "slide"), ("", joint.axis, "hinge")):
            _add(body, "joint", name=name + end, type=kind, axis=_text(axis))
        return
    if joint.type == "screw":
        _add(body, "joint", name=f"{name}_advance", type="slide", axis=_text(direction))
        _couple(equality, f"{name}_advance", name, 0.0, joint.pitch)
    values = {"name": name, "type": TYPES.get(joint.type, "hinge"), "pos": _text(position)}
    if joint.type != "ball":
        values["axis"] = _text(direction)
        if np.isfinite(joint.limits).any():
            low, high = np.nan_to_num(joint.limits, posinf=1e10, neginf=-1e10)
            values["range"] = _text([low, high if high > low else low + abs(low) * 1e-9 + 1e-9])
    _add(body, "joint", **values)


def _couple(equality: Element, follower: str, leader: str, offset: float, multiplier: float) -> None:
    _add(equality, "joint", joint1=follower, joint2=leader, polycoef=_text([offset, multiplier, 0.0, 0.0, 0.0]))


def _write_loop(robot: Robot, bodies: dict[str, Element], equality: Element, loop: LoopJoint) -> None:
    frames = {"fixed": [np.zeros(3)], "ball": [np.zeros(3)], "revolute": [loop.axis, -loop.axis]}
    if loop.type not in frames:
        raise InputError(
            f"{loop.name!r} closes a loop by a {loop.type} joint, which an MJCF has not.", where=robot.path
        )
    for i, shift in enumerate(frames[loop.type]):  # two points of an axis
        sites = []
        for name, end, frame in ((loop.a, "a", loop.frame_a), (loop.b, "b", loop.frame_b)):
            site = f"{loop.name}_{end}" + (f"{i + 1}" if len(frames[loop.type]) > 1 else "")
            place = frame[:3, :3] @ shift * max(robot.size, 1e-3) * 0.1 + frame[:3, 3]
            values = {"pos": _text(place), "quat": _text(quaternion_of_rotation(frame[:3, :3]))}
            _add(bodies[name], "site", name=site, **values)
            sites.append(site)
        tag = "weld" if loop.type == "fixed" else "connect"
        name = loop.name + (f"_{i + 1}" if len(frames[loop.type]) > 1 else "")
        _add(equality, tag, name=name, site1=sites[0], site2=sites[1])


def _body(parent: Element, name: str, frame: Array) -> Element:
    return _add(
        parent, "body", name=name, pos=_text(frame[:3, 3]), quat=_text(quaternion_of_rotation(frame[:3, :3]))
    )  # fmt: skip


def _add(parent: Element, tag: str, **values: str) -> Element:
    return ElementTree.SubElement(parent, tag, values)


def _text(numbers: Any) -> str:
    """Numbers that are read as the same ones."""
    return " ".join(repr(float(x)) for x in numbers)
