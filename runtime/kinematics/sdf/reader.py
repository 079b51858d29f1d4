"""Robots from SDF files: links, joints, inertias; joints that close loops."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import suggest
from ...common.files import as_path
from ...common.validation import as_choice
from ...mechanics.screws import geometry
from ..robots.description import (
    MOVING,
    Description,
    Follower,
    LinkInertia,
    LoopJoint,
    RobotJoint,
    on_base,
    with_leaders,
)
from ..robots.frames import unit_vector
from ..robots.robot import Robot
from ..robots.xml_text import Element, ignored_names
from .text import WORLD, SdfText

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]
MIMIC = ("follow", "free", "error")
#: Types of joints with one axis, with two, and others.
ONE_AXIS = {"revolute": "revolute", "continuous": "continuous", "prismatic": "prismatic", "screw": "screw"}
TWO_AXES = ("universal", "revolute2")
TYPES = (*ONE_AXIS, *TWO_AXES, "ball", "fixed", "gearbox")
_FREE = np.array([-np.inf, np.inf])


def load_sdf(
    path: str | os.PathLike[str],
    algebra: Algebra | None = None,
    *,
    mimic: str = "follow",
    ignore: Iterable[str] = (),
    impossible: str = "error",
    base: str = "fixed",
) -> Robot:
    """A robot from an SDF file of one model.

    The root is "world" where a joint holds a link to it, its frame the model's; else the first link, or that of the
    model's ``canonical_link``. Coordinates are zero where the links have their poses. Joints beyond those of a tree,
    the later ones in the file, close loops. A universal joint ``u`` is two, ``u[0]`` and ``u[1]``, with a link between
    them; a gearbox lets the joint of its child follow that of its parent, and so does ``<mimic>``.

    Parameters
    ----------
    path : str or path
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.
    mimic : {"follow", "free", "error"}
        Joints that follow others: their coordinates are computed, they are independent joints, or they are refused.
    ignore : list of str
        Unknown tags of the model that may be left out, such as "include".
    impossible : {"error", "keep", "nearest"}
    base : {"fixed", "floating"}
        As of `load_urdf`.

    Raises
    ------
    InputError
        With file, line and tag: no such file, not XML, a document type, elements nested too deep, duplicate names,
        missing parents or children, links that are not connected, poses that are relative to each other, axes of
        length zero, numbers that are not finite, unknown types of joints and tags.
    """
    tags, home, choice = ignored_names(ignore), geometry(algebra), as_choice(mimic, "mimic", MIMIC)
    text = SdfText(str(as_path(path, "an SDF is loaded from")), tags)
    return Robot(on_base(_Reader(text, choice).description(), base), home, impossible)


class _Reader:
    """Links and joints of a text."""

    def __init__(self, text: SdfText, mimic: str) -> None:
        self._text, self._mimic = text, mimic
        self._ends: dict[str, tuple[str, str]] = {}
        self._gears: list[Element] = []
        self._elements: dict[str, Element] = {}
        for name, element in text.joints.items():
            kind = element.get("type")
            if kind not in TYPES:
                raise text.error(
                    element, f"{kind!r} is not a type of joint{suggest(kind, TYPES)} in", f"One of: {', '.join(TYPES)}"
                )
            if kind in TWO_AXES:
                self._check_names(name, element)
            ends = tuple(self._link_of(element, text.word(element, tag)) for tag in ("parent", "child"))
            if ends[0] == ends[1]:
                raise text.error(element, "a link is joined to itself by")
            if kind == "gearbox":
                self._gears.append(element)
            else:
                self._ends[name] = (ends[0], ends[1])
        links = [*text.links]
        canonical = text.model.get("canonical_link", links[0])
        if canonical not in links:
            raise text.error(text.model, f"there is no link {canonical!r}{suggest(canonical, links)}, as in")
        self._root = WORLD if any(WORLD in ends for ends in self._ends.values()) else canonical

    def _check_names(self, name: str, element: Element) -> None:
        """Refuse a joint with two axes whose parts have the names of others."""
        text = self._text
        for made, others in ((f"{name}[0]", text.joints), (f"{name}[1]", text.joints), (f"{name}[cross]", text.links)):
            if made in others:
                raise text.error(
                    element, f"{made!r} is the name of another {others[made].tag} and of a part of",
                    "Rename one of them",
                )  # fmt: skip

    def _link_of(self, at: Element, name: str) -> str:
        """The link of a name, which may be that of a frame."""
        text, seen = self._text, set[str]()
        while name not in text.links and name != WORLD:
            frame = text.frames.get(name)
            if frame is None or name in seen:
                raise text.error(at, f"there is no link {name!r}{suggest(name, text.links)}, as in")
            seen.add(name)
            name = frame.get("attached_to", "") or next(iter(text.links))
        return name

    def description(self) -> Description:
        """The robot."""
        text = self._text
        tree, loops = self._split()
        links = [self._root] if self._root == WORLD else []
        joints: dict[str, RobotJoint] = {}
        for name, (above, below) in tree.items():
            for joint in self._joints(name, above, below):
                joints[joint.name] = joint
                self._elements[joint.name] = text.joints[name]
                if joint.child not in text.links:
                    links.append(joint.child)
        links += text.links
        closing = tuple(self._loop(name) for name in loops)
        if self._mimic != "free":
            self._follow(joints)
        joints = with_leaders(joints, lambda j, what, more: text.error(self._elements[j.name], what, more))
        return Description(text.model.get("name", "model"), text.path, tuple(links), joints, self._inertias(), closing)

    def _split(self) -> tuple[dict[str, tuple[str, str]], list[str]]:
        """Joints of a tree from the root, with the links above and below, in the file's order; and the others."""
        at: dict[str, list[str]] = {}
        for name, ends in self._ends.items():
            for end in ends:
                at.setdefault(end, []).append(name)
        found, reached, front = dict[str, tuple[str, str]](), {self._root}, [self._root]
        while front:  # the nearest first, so that loops are short
            link = front.pop(0)
            for name in at.get(link, []):
                parent, child = self._ends[name]
                other = child if parent == link else parent
                if other not in reached:
                    reached.add(other)
                    found[name] = link, other
                    front.append(other)
        missing = [name for name in self._text.links if name not in reached]
        if missing:
            raise self._text.error(
                self._text.links[missing[0]], f"no joints connect it to {self._root!r}:", "Join all links"
            )
        return {n: found[n] for n in self._ends if n in found}, [n for n in self._ends if n not in found]

    # -- joints ----------------------------------------------------------------------------------------------

    def _frame(self, link: str) -> Array:
        return np.eye(4) if link == WORLD else self._text.pose_of(link, self._text.model)

    def _joints(self, name: str, above: str, below: str) -> list[RobotJoint]:
        """The joints of a joint of the tree: two, where it has two axes."""
        text, element = self._text, self._text.joints[name]
        kind, sign = str(element.get("type")), 1.0 if self._ends[name][0] == above else -1.0
        frame, base, end = text.pose_of(name, element), self._frame(above), self._frame(below)
        into = np.linalg.inv(end)
        position = (into @ frame)[:3, 3]
        origin = np.linalg.inv(base) @ end
        if kind in ("ball", "fixed"):
            return [RobotJoint(name, kind, above, below, origin, np.array([1.0, 0, 0]), _FREE, position)]
        axes = [self._axis(element, tag, frame) for tag in ("axis", "axis2")[: 2 if kind in TWO_AXES else 1]]
        if kind not in TWO_AXES:
            (axis, limits, pitch), *_ = axes
            limits = _FREE if kind == "continuous" else limits
            pitch = pitch if kind == "screw" else 0.0
            turned = sign * into[:3, :3] @ axis
            return [RobotJoint(name, ONE_AXIS[kind], above, below, origin, turned, limits, position, pitch)]
        found, parent = [], above
        for i in (0, 1) if sign > 0 else (1, 0):
            axis, limits, _ = axes[i]
            is_last = parent != above
            child = below if is_last else f"{name}[cross]"
            found.append(RobotJoint(
                f"{name}[{i}]", "revolute", parent, child, np.eye(4) if is_last else origin,
                sign * into[:3, :3] @ axis, limits, position,
            ))  # fmt: skip
            parent = child
        return found

    def _axis(self, joint: Element, tag: str, frame: Array) -> tuple[Array, Array, float]:
        """Unit axis (3,) in the model's frame, limits, and the advance of a screw for a radian."""
        text = self._text
        element = text.only(joint, tag)
        if element is None:
            raise text.error(joint, f"there is no <{tag}> in")
        axis, at = text.vector(element, "xyz", "0 0 1")
        if not np.abs(axis).max() > 1e-14:
            raise text.error(at, f"the axis of joint {joint.get('name')!r} has no length in")
        old = text.only(element, "use_parent_model_frame")
        within = at.get("expressed_in", "")
        rotation = frame[:3, :3]
        if within:
            rotation = text.pose_of(within, at)[:3, :3]
        elif text.version < (1, 5) if old is None else (old.text or "").strip() in ("1", "true"):
            rotation = np.eye(3)  # the model's axes, as all were in old versions
        limit = text.only(element, "limit")
        low, high = (text.number(limit, k, x, True) for k, x in (("lower", -np.inf), ("upper", np.inf)))
        low, high = (x if abs(x) < 1e16 else np.sign(x) * np.inf for x in (low, high))  # its default is 1e16
        if not low <= high:
            raise text.error(element, f"the limits are {low:g} and {high:g}: least, then greatest, in")
        return rotation @ unit_vector(axis), np.array([low, high]), self._pitch(joint)

    def _pitch(self, joint: Element) -> float:
        """Advance of a screw joint along its axis for a radian, right-handed."""
        text = self._text
        if text.only(joint, "screw_thread_pitch") is not None:
            return text.number(joint, "screw_thread_pitch", 1.0) / (2 * np.pi)
        turns = text.number(joint, "thread_pitch", -2 * np.pi)  # radians for a metre, the other way
        if turns == 0:
            raise text.error(joint, "thread_pitch is zero in")
        return -1 / turns

    def _loop(self, name: str) -> LoopJoint:
        """A joint that closes a loop."""
        text, element = self._text, self._text.joints[name]
        kind, (a, b) = str(element.get("type")), self._ends[name]
        if kind in TWO_AXES:
            raise text.error(
                element, f"a {kind} joint closes a loop, which is not read, as in",
                "Order the joints so that it is in the tree, or split it in two revolute ones",
            )  # fmt: skip
        frame = text.pose_of(name, element)
        axis, pitch = np.array([0.0, 0, 1]), 0.0
        if kind in ONE_AXIS:
            axis, _, pitch = self._axis(element, "axis", frame)
            axis = frame[:3, :3].T @ axis
        frames = [np.linalg.inv(self._frame(link)) @ frame for link in (a, b)]
        pitch = pitch if kind == "screw" else 0.0
        return LoopJoint(name, ONE_AXIS.get(kind, kind), a, b, frames[0], frames[1], axis, pitch)

    # -- joints that follow others ---------------------------------------------------------------------------

    def _follow(self, joints: dict[str, RobotJoint]) -> None:
        """Let joints follow others: <mimic>, and gearboxes."""
        text = self._text
        for name, element in text.joints.items():
            for i, tag in enumerate(("axis", "axis2")):
                axis = text.only(element, tag)
                mimic = None if axis is None else text.only(axis, "mimic")
                if mimic is None:
                    continue
                own = self._joint_of_axis(name, i)
                leader = self._joint_of_axis(mimic.get("joint", ""), int(mimic.get("axis", "axis") == "axis2"))
                k, reference = text.number(mimic, "multiplier", 1.0), text.number(mimic, "reference", 0.0)
                offset = text.number(mimic, "offset", 0.0) - k * reference
                self._add_follower(joints, own, element, Follower(leader, k, offset))
        for gear in self._gears:
            self._add_gear(joints, gear)

    def _joint_of_axis(self, name: str, i: int) -> str:
        """The joint that is an axis of a joint of the file."""
        element = self._text.joints.get(name)
        return f"{name}[{i}]" if element is not None and element.get("type") in TWO_AXES else name

    def _add_follower(self, joints: dict[str, RobotJoint], name: str, element: Element, follows: Follower) -> None:
        if self._mimic == "error":
            raise self._text.error(element, "joints that follow others are refused with mimic='error'; one is")
        if name not in joints or joints[name].type not in MOVING:
            raise self._text.error(element, "it follows another and closes a loop, or has no coordinate:")
        if joints[name].follows is not None:
            raise self._text.error(element, "it follows two others:", "Load the file with mimic='free'")
        joints[name] = replace(joints[name], follows=follows)

    def _add_gear(self, joints: dict[str, RobotJoint], gear: Element) -> None:
        """theta_2 = -ratio theta_1: angles from the reference body to the parent about the axis, and to the child about
        the second axis."""
        text = self._text
        reference = self._link_of(gear, text.word(gear, "gearbox_reference_body"))
        ratio = text.number(gear, "gearbox_ratio", 1.0)
        found = []
        for tag, axis_tag in (("parent", "axis"), ("child", "axis2")):
            link = self._link_of(gear, text.word(gear, tag))
            own = next(
                (j for j in joints.values() if (j.parent, j.child) == (reference, link) and j.type in MOVING), None
            )
            if own is None:
                raise text.error(
                    gear, f"no joint turns {link!r} on {reference!r}, as is needed by the gearbox",
                    "Load the file with mimic='free', which leaves gearboxes out",
                )  # fmt: skip
            axis, _, _ = self._axis(gear, axis_tag, text.pose_of(text.name(gear), gear))
            along = float((self._frame(link)[:3, :3] @ own.axis) @ axis)
            found.append((own, 1.0 if along > 0 else -1.0))
        (leader, first), (follower, second) = found
        follows = Follower(leader.name, -ratio * first * second)
        self._add_follower(joints, follower.name, self._elements[follower.name], follows)

    # -- inertias --------------------------------------------------------------------------------------------

    def _inertias(self) -> dict[str, LinkInertia]:
        text, found = self._text, dict[str, LinkInertia]()
        for name, link in text.links.items():
            inertial = text.only(link, "inertial")
            if inertial is None:
                continue
            if inertial.get("auto") in ("true", "1"):
                raise text.error(
                    inertial, "inertias of collision shapes are not computed, as asked for by",
                    "Write out mass and inertia",
                )  # fmt: skip
            moments = text.only(inertial, "inertia")
            xx, yy, zz = (text.number(moments, k, 1.0) for k in ("ixx", "iyy", "izz"))
            xy, xz, yz = (text.number(moments, k, 0.0) for k in ("ixy", "ixz", "iyz"))
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            pose = text.only(inertial, "pose")
            frame = text.pose(pose)
            if pose is not None and pose.get("relative_to"):
                into = np.linalg.inv(text.pose_of(name, link))
                frame = into @ text.pose_of(pose.get("relative_to", ""), pose) @ frame
            found[name] = LinkInertia(text.number(inertial, "mass", 1.0), tensor, frame)
        return found
