"""Equality constraints of MJCF files: points and frames that close loops, joints that follow others."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import suggest
from ..robots.description import Follower, LoopJoint, RobotJoint, displacement, homogeneous, zero_frames
from ..robots.frames import rotation_of_quaternion
from ..robots.xml_text import Element
from .text import MjcfText

Array = NDArray[Any]
WORLD = "world"
#: Constraints that are read, and those of which nothing is known here.
EQUALITIES = ("connect", "weld", "joint")
OTHER_EQUALITIES = ("tendon", "flex", "flexvert", "flexstrain", "distance")


class Equalities:
    """The constraints of a text.

    Parameters
    ----------
    text : MjcfText
    mimic : {"follow", "free", "error"}
    links : collection of str
    joints : dict of str to RobotJoint
        Those that follow others are replaced.
    sites : mapping of str to (str, array (4, 4))
        Link and frame.
    references : mapping of str to float
        Coordinates of joints in the pose that the file draws.
    """

    def __init__(
        self, text: MjcfText, mimic: str, links: Collection[str], joints: dict[str, RobotJoint],
        sites: Mapping[str, tuple[str, Array]], references: Mapping[str, float],
    ) -> None:  # fmt: skip
        self._text, self._mimic, self._links, self._joints = text, mimic, links, joints
        self._sites, self._references = sites, references
        self._drawn, self._held = tuple(joints.values()), dict[str, float]()

    def read(self) -> tuple[LoopJoint, ...]:
        """Joints that close loops; joints that follow others are changed."""
        text, loops = self._text, list[LoopJoint]()
        frames = None
        for section in text.sections["equality"]:
            for element in section:
                if element.tag in OTHER_EQUALITIES or element.tag in text.ignored:
                    warnings.warn(
                        f"{text.path}:{text.line(element)}: <{element.tag}> is not read, and left out.", stacklevel=4
                    )
                    continue
                if element.tag not in EQUALITIES:
                    raise text.unknown(element, EQUALITIES)
                values = text.attributes(element, None, "equality")  # all kinds have one default
                if text.flag(element, values, "active", "true") == "false":
                    continue
                if element.tag == "joint":
                    self._couple(element, values)
                    continue
                frames = frames or self._frames_at_start()
                loop = self._loop(element, values, frames, len(loops) + 1)
                if loop.a == loop.b:
                    raise text.error(element, f"{loop.a!r} is joined to itself by")
                loops.append(loop)
        self._hold_followers()
        return tuple(loops)

    def _frames_at_start(self) -> dict[str, Array]:
        """Frames of all links where joints are at their references: the pose that the file draws."""
        joints = [
            replace(joint, origin=joint.origin @ displacement(joint, self._references[joint.name]))
            if self._references.get(joint.name)
            else joint
            for joint in self._drawn
        ]
        return zero_frames(joints, WORLD)

    def _loop(self, element: Element, values: dict[str, str], frames: dict[str, Array], number: int) -> LoopJoint:
        text = self._text
        name, kind = values.get("name", f"{element.tag}_{number}"), "ball" if element.tag == "connect" else "fixed"
        if kind == "fixed" and not text.vector(element, values, "torquescale", "1", 1)[0]:
            kind = "ball"  # rotations are not held
        z = np.array([0.0, 0.0, 1.0])
        if "site1" in values:
            (a, frame_a), (b, frame_b) = (self._site(element, values.get(k, "")) for k in ("site1", "site2"))
            return LoopJoint(name, kind, a, b, frame_a, frame_b, z)
        a, b = (self._body(element, values.get(k, WORLD if k == "body2" else "")) for k in ("body1", "body2"))
        relative = np.linalg.inv(frames[b]) @ frames[a]
        frame = homogeneous(np.eye(3), text.vector(element, values, "anchor", "0 0 0", 3))
        if element.tag == "connect":
            return LoopJoint(name, kind, a, b, frame, relative @ frame, z)
        pose = text.vector(element, values, "relpose", "0 0 0 0 0 0 0", 7)
        if pose[3:].any():  # of the anchor, which is given in the second body, relative to the first
            return LoopJoint(name, kind, a, b, homogeneous(rotation_of_quaternion(pose[3:]), pose[:3]), frame, z)
        return LoopJoint(name, kind, a, b, np.linalg.inv(relative) @ frame, frame, z)

    def _site(self, element: Element, name: str) -> tuple[str, Array]:
        if name not in self._sites:
            raise self._text.error(element, f"there is no site {name!r}{suggest(name, self._sites)}, as in")
        return self._sites[name]

    def _body(self, element: Element, name: str) -> str:
        if name not in self._links:
            raise self._text.error(element, f"there is no body {name!r}{suggest(name, self._links)}, as in")
        return name

    def _couple(self, element: Element, values: dict[str, str]) -> None:
        """Let a joint follow another: y - y0 = a0 + a1 (x - x0)."""
        text = self._text
        if self._mimic == "error":
            raise text.error(element, "joints that follow others are refused with mimic='error'; one is made by")
        numbers = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
        if values.get("polycoef", "").strip():
            given = text.vector(element, values, "polycoef", "", None)
            if len(given) > 5:
                raise text.error(element, f"polycoef={values['polycoef']!r}, where five numbers at most are read, in")
            numbers[: len(given)] = given
        names = [values.get("joint1", ""), *([values["joint2"]] if "joint2" in values else [])]
        for name in names:
            if name not in self._references:
                raise text.error(
                    element, f"there is no hinge or slide {name!r}{suggest(name, self._references)}, as in"
                )
        if self._mimic == "free":
            return
        if len(names) == 2 and numbers[2:].any():
            raise text.error(
                element, f"polycoef={values['polycoef']!r} is not linear in", "Load the file with mimic='free'"
            )
        joint = self._joints[names[0]]
        if joint.follows is not None or joint.type == "fixed":
            what = "is held" if joint.name in self._held else "follows another"
            raise text.error(element, f"{joint.name!r} {what} already, in", "Load the file with mimic='free'")
        offset = self._references[names[0]] + numbers[0]
        if len(names) == 1:
            self._hold(joint, float(offset))
            return
        offset -= numbers[1] * self._references[names[1]]
        self._joints[joint.name] = replace(joint, follows=Follower(names[1], float(numbers[1]), float(offset)))

    def _hold(self, joint: RobotJoint, value: float) -> None:
        held = joint.origin @ displacement(joint, value)
        self._joints[joint.name] = replace(joint, type="fixed", origin=held, follows=None)
        self._held[joint.name] = value

    def _hold_followers(self) -> None:
        """Hold what follows a joint that is held: at offset + multiplier * value."""
        followers: dict[str, list[RobotJoint]] = {}
        for joint in self._joints.values():
            if joint.follows is not None:
                followers.setdefault(joint.follows.joint, []).append(joint)
        front = [*self._held]
        while front:
            leader = front.pop()
            for joint in followers.get(leader, []):
                assert joint.follows is not None
                self._hold(joint, joint.follows.multiplier * self._held[leader] + joint.follows.offset)
                front.append(joint.name)
