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
        self._held: dict[str, float] = {}

    def read(self) -> tuple[LoopJoint, ...]:
        """Joints that close loops; joints that follow others are changed."""
        text, loops = self._text, list[LoopJoint]()
        couplings: list[tuple[Element, dict[str, str]]] = []
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
                values = text.attributes(element, None, "equality")
                if text.flag(element, values, "active", "true") == "false":
                    continue
                if element.tag == "joint":
                    couplings.append((element, values))
                    continue
                frames = frames or self._frames_at_start()
                loop = self._loop(element, values, frames, len(loops) + 1)
                if loop.a == loop.b:
                    raise text.error(element, f"{loop.a!r} is joined to itself by")
                loops.append(loop)
        self._couple_all(couplings)
        return tuple(loops)

    def _frames_at_start(self) -> dict[str, Array]:
        """Frames of all links where joints are at their references: the pose that the file draws."""
        joints = [
            replace(joint, origin=joint.origin @ displacement(joint, self._references[joint.name]))
            if self._references.get(joint.name)
            else joint
            for joint in self._joints.values()
        ]
        return zero_frames(joints, WORLD)

    def _loop(self, element: Element, values: dict[str, str], frames: dict[str, Array], number: int) -> LoopJoint:
        text = self._text
        name, is_point = values.get("name", f"{element.tag}_{number}"), element.tag == "connect"
        if not is_point and text.vector(element, values, "torquescale", "1", 1)[0] == 0:  # it holds no rotation
            is_point = True
        kind = "ball" if is_point else "fixed"
        z = np.array([0.0, 0.0, 1.0])
        if "site1" in values:
            (a, frame_a), (b, frame_b) = (self._site(element, values.get(k, "")) for k in ("site1", "site2"))
            return LoopJoint(name, kind, a, b, frame_a, frame_b, z)
        a, b = (self._body(element, values.get(k, WORLD if k == "body2" else "")) for k in ("body1", "body2"))
        relative = np.linalg.inv(frames[b]) @ frames[a]
        anchor = text.vector(element, values, "anchor", "0 0 0", 3)
        at = homogeneous(np.eye(3), anchor)
        if element.tag == "connect":
            return LoopJoint(name, kind, a, b, at, relative @ at, z)
        pose = text.vector(element, values, "relpose", "0 0 0 0 0 0 0", 7)
        if pose[3:].any():  # of the second body relative to the first
            relative = np.linalg.inv(homogeneous(rotation_of_quaternion(pose[3:]), pose[:3]))
        if is_point:  # the anchor is in the second body
            return LoopJoint(name, kind, a, b, np.linalg.inv(relative) @ at, at, z)
        return LoopJoint(name, kind, a, b, np.eye(4), relative, z)

    def _site(self, element: Element, name: str) -> tuple[str, Array]:
        if name not in self._sites:
            raise self._text.error(element, f"there is no site {name!r}{suggest(name, self._sites)}, as in")
        return self._sites[name]

    def _body(self, element: Element, name: str) -> str:
        if name not in self._links:
            raise self._text.error(element, f"there is no body {name!r}{suggest(name, self._links)}, as in")
        return name

    def _couple_all(self, couplings: list[tuple[Element, dict[str, str]]]) -> None:
        """Let joints follow others: those first that are held, and those that follow joints that are."""
        front, rest = couplings, list[tuple[Element, dict[str, str]]]()
        while front:
            rest = []
            for element, values in front:
                if values.get("joint2") in self._held or "joint2" not in values:
                    self._couple(element, values)
                else:
                    rest.append((element, values))
            if len(rest) == len(front):
                break
            front = rest
        for element, values in rest:
            self._couple(element, values)

    def _couple(self, element: Element, values: dict[str, str]) -> None:
        """Let a joint follow another: y - y0 = a0 + a1 (x - x0)."""
        text = self._text
        if self._mimic == "error":
            raise text.error(element, "joints that follow others are refused with mimic='error'; one is made by")
        numbers = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
        if "polycoef" in values:
            given = text.vector(element, values, "polycoef", "", None)
            if len(given) > len(numbers):
                raise text.error(element, f"polycoef={values['polycoef']!r} has more than five numbers in")
            numbers[: len(given)] = given
        names = [values.get("joint1", ""), *([values["joint2"]] if "joint2" in values else [])]
        for name in names:
            if name not in self._references:
                raise text.error(
                    element, f"there is no hinge or slide {name!r}{suggest(name, self._references)}, as in"
                )
        if self._mimic == "free":
            return
        is_held = len(names) == 1 or names[1] in self._held
        if not is_held and numbers[2:].any():
            raise text.error(
                element, f"polycoef={values['polycoef']!r} is not linear in", "Load the file with mimic='free'"
            )
        joint = self._joints[names[0]]
        if joint.follows is not None or joint.type == "fixed":
            raise text.error(element, f"{joint.name!r} follows another already, in", "Load the file with mimic='free'")
        if is_held:
            by = self._held[names[1]] - self._references[names[1]] if len(names) == 2 else 0.0
            value = float(self._references[names[0]] + np.polynomial.polynomial.polyval(by, numbers))
            self._held[names[0]] = value
            self._joints[joint.name] = replace(joint, type="fixed", origin=joint.origin @ displacement(joint, value))
            return
        offset = self._references[names[0]] + numbers[0] - numbers[1] * self._references[names[1]]
        self._joints[joint.name] = replace(joint, follows=Follower(names[1], float(numbers[1]), float(offset)))
