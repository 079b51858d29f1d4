"""Robots from MJCF files: bodies, joints, inertias, equality constraints."""

from __future__ import annotations

import os
import warnings
from collections.abc import Collection, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.files import as_path
from ...common.validation import as_choice
from ...mechanics.screws import geometry
from ..robots.description import Description, RobotJoint, displacement, with_leaders
from ..robots.frames import unit_vector
from ..robots.robot import Robot
from ..robots.xml_text import Element, ignored_names
from .equalities import WORLD, Equalities
from .geoms import frame_of_shape, inertial_of
from .inertias import BodyInertias
from .text import MjcfText

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]
MIMIC = ("follow", "free", "error")
TYPES = {"hinge": "revolute", "slide": "prismatic", "ball": "ball", "free": "floating"}
#: Children of a body that are read, and those that place nothing.
OF_BODY = ("body", "joint", "freejoint", "inertial", "geom", "site", "frame")
BESIDE_BODY = ("camera", "light", "plugin")


def load_mjcf(
    path: str | os.PathLike[str],
    algebra: Algebra | None = None,
    *,
    mimic: str = "follow",
    ignore: Iterable[str] = (),
    impossible: str = "error",
) -> Robot:
    """A robot from an MJCF file, the format of MuJoCo.

    The root is "world"; coordinates are MuJoCo's ``qpos``. A body with several joints has a link before each joint but
    the last, named after body and joint; bodies and joints without names are ``body_1`` and ``body_1_joint``, by their
    numbers in MuJoCo. Names that are made up have underscores behind them, where the file has the name itself. Free and
    ball joints take motors, see `Robot.poses`. ``connect`` and ``weld`` close loops of the mechanism and the system;
    ``joint`` makes a joint follow another.

    Parameters
    ----------
    path : str or path
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`.
    mimic : {"follow", "free", "error"}
        Joints that follow others by ``<equality><joint>``: their coordinates are computed, they are independent joints,
        or they are refused.
    ignore : list of str
        Unknown tags that may be left out.
    impossible : {"error", "keep", "nearest"}
        As of `load_urdf`.

    Raises
    ------
    InputError
        With file, line and tag: no such file, not XML, a document type, elements nested too deep, files included from
        elsewhere, twice, or by themselves; unknown tags, classes, bodies and joints, duplicate names, axes of length
        zero, numbers that are not finite, relations of joints that are not linear.
    """
    tags, home, choice = ignored_names(ignore), geometry(algebra), as_choice(mimic, "mimic", MIMIC)
    reader = _Reader(MjcfText(str(as_path(path, "an MJCF is loaded from")), tags), choice)
    return Robot(reader.description(), home, impossible)


class _Reader:
    """Links and joints of a text, in MuJoCo's order."""

    def __init__(self, text: MjcfText, mimic: str) -> None:
        self._text, self._mimic = text, mimic
        self._links: dict[str, Element | None] = {WORLD: None}
        self._joints: dict[str, RobotJoint] = {}
        self._elements: dict[str, Element] = {}
        self._inertias = BodyInertias(text)
        self._sites: dict[str, tuple[str, Array]] = {}
        self._rotors: list[str] = []
        self._references: dict[str, float] = {}
        elements = [element for section in text.sections["worldbody"] for element in section.iter()]
        self._link_names = {x.get("name", "") for x in elements if x.tag == "body"}
        self._joint_names = {x.get("name", "") for x in elements if x.tag in ("joint", "freejoint")}

    def description(self) -> Description:
        """The robot."""
        text, bodies = self._text, 0
        front: list[tuple[Element, str, Array, str | None]] = []
        for section in text.sections["worldbody"]:
            front += self._read_body(section, WORLD, None)
        front.reverse()
        while front:
            element, parent, frame, childclass = front.pop()
            bodies += 1
            name = self._read_joints(element, parent, frame, bodies, childclass)
            front += reversed(self._read_body(element, name, element.get("childclass", childclass)))
        if not bodies:
            raise InputError("there are no bodies.", where=text.path, remedy="An MJCF has them in its <worldbody>")
        self._inertias.finish(3)
        self._warn_of_rotors(4)
        own = self._links, self._joints, self._sites, self._references
        loops = Equalities(text, self._mimic, *own).read()
        joints = with_leaders(self._joints, lambda j, what, more: text.error(self._elements[j.name], what, more))
        return Description(text.model, text.path, tuple(self._links), joints, self._inertias.of, loops)

    # -- bodies ----------------------------------------------------------------------------------------------

    def _read_body(
        self, body: Element, name: str, childclass: str | None
    ) -> list[tuple[Element, str, Array, str | None]]:
        """Read a body's inertia and sites; its bodies, with their parent, the frame that they are in, and their class.
        """
        text, found, geoms, inertial = self._text, [], [], None
        for child, frame, own in text.children(body, childclass):
            if child.tag == "body":
                found.append((child, name, frame, own))
            elif child.tag == "inertial":
                inertial = inertial_of(text, child, frame)
            elif child.tag == "geom":
                geoms.append((child, text.attributes(child, own), frame))
            elif child.tag == "site":
                values = text.attributes(child, own)
                at, _ = frame_of_shape(text, child, values, values.get("type", "sphere"))
                self._sites[child.get("name", "")] = name, frame @ at
            elif child.tag not in (*OF_BODY, *BESIDE_BODY) and child.tag not in text.ignored:
                raise text.unknown(child, OF_BODY)
        if name != WORLD:
            self._inertias.read(body, name, inertial, geoms)
        return found

    # -- joints ----------------------------------------------------------------------------------------------

    def _read_joints(self, body: Element, parent: str, frame: Array, number: int, childclass: str | None) -> str:
        """Read the joints between a body of a number and its parent; the body's name."""
        text = self._text
        name = self._link_name(body, f"body_{number}")
        childclass = body.get("childclass", childclass)
        origin = frame @ text.frame(body, dict(body.attrib))
        joints = [
            (child, inner, own)
            for child, inner, own in text.children(body, childclass)
            if child.tag in ("joint", "freejoint")
        ]
        if not joints:
            weld = self._unused(f"{name}_weld", self._joints, self._joint_names)
            self._add(body, RobotJoint(weld, "fixed", parent, name, origin, np.array([1.0, 0, 0]), _FREE))
        above = parent
        for i, (element, inner, own) in enumerate(joints):
            label = f"{name}_joint" + (f"_{i + 1}" if len(joints) > 1 else "")
            label = self._unused(label, self._joints, self._joint_names)
            joint = self._read_joint(element, inner, own, element.get("name", label))
            if joint.type == "floating" and (parent != WORLD or len(joints) > 1):
                raise text.error(element, "a free joint is alone in its body, and that is in the world; one is")
            link = name
            if i < len(joints) - 1:
                link = self._unused(f"{name}/{joint.name}", self._links, self._link_names)
                self._links[link] = None
            base = origin if i == 0 else np.eye(4)
            self._add(element, replace(joint, parent=above, child=link, origin=base @ joint.origin))
            above = link
        self._links[name] = body
        return name

    def _read_joint(self, element: Element, frame: Array, childclass: str | None, name: str) -> RobotJoint:
        """A joint, its origin that of its coordinate zero in the frame of its reference pose."""
        text = self._text
        is_free = element.tag == "freejoint"
        values = {**element.attrib, "type": "free"} if is_free else text.attributes(element, childclass)
        kind = TYPES[text.choice(element, "type", values.get("type", "hinge"), TYPES)]
        if kind == "floating":
            align = text.flag(element, values, "align", "auto")
            if align == "true" or (align == "auto" and text.settings.get("alignfree") == "true"):
                raise text.error(
                    element, "the body's frame is moved to its inertia's by align or alignfree, as for",
                    "Make it a <freejoint align='false'>",
                )  # fmt: skip
        if text.vector(element, values, "armature", "0", 1)[0]:
            self._rotors.append(repr(name))
        axis = text.vector(element, values, "axis", "0 0 1", 3)
        position = frame[:3, :3] @ text.vector(element, values, "pos", "0 0 0", 3) + frame[:3, 3]
        if kind in ("revolute", "prismatic") and not np.abs(axis).max() > 1e-14:
            raise text.error(element, "the axis has no length in")
        unit = text.angle if kind == "revolute" else 1.0
        limits = _FREE
        if kind in ("revolute", "prismatic") and self._is_limited(element, values):
            limits = unit * text.vector(element, values, "range", "0 0", 2)
            if not limits[0] < limits[1]:
                raise text.error(element, f"range={values.get('range', '')!r}: least, then greatest, in")
        joint = RobotJoint(
            name, kind, "", "", np.eye(4), frame[:3, :3] @ unit_vector(axis), limits,
            np.zeros(3) if kind == "floating" else position,
        )  # fmt: skip
        if kind in ("revolute", "prismatic"):
            reference = float(unit * text.vector(element, values, "ref", "0", 1)[0])
            self._references[name] = reference
            if reference:
                joint = replace(joint, origin=displacement(joint, -reference))
        return joint

    def _is_limited(self, element: Element, values: dict[str, str]) -> bool:
        limited = self._text.flag(element, values, "limited", "auto")
        if limited == "auto":
            return "range" in values and self._text.settings.get("autolimits", "true") == "true"
        return limited == "true"

    def _warn_of_rotors(self, stacklevel: int) -> None:
        if self._rotors:
            shown = ", ".join(self._rotors[:5]) + (" ..." if len(self._rotors) > 5 else "")
            warnings.warn(
                f"{self._text.path}: armature is not read, and left out of the mass matrix, for joints: {shown}.",
                stacklevel=stacklevel,
            )

    # -- names -----------------------------------------------------------------------------------------------

    def _add(self, element: Element, joint: RobotJoint) -> None:
        if not joint.name.strip():
            raise self._text.error(element, "the name of a joint is empty in")
        if joint.name in self._joints:
            raise self._text.error(element, f"the name {joint.name!r} is taken already:")
        self._joints[joint.name] = joint
        self._elements[joint.name] = element

    def _link_name(self, body: Element, default: str) -> str:
        name = body.get("name")
        if name is None:
            return self._unused(default, self._links, self._link_names)
        if not name.strip():
            raise self._text.error(body, "the name of a body is empty in")
        if name in self._links:
            raise self._text.error(body, f"the name {name!r} is taken already:")
        return name

    @staticmethod
    def _unused(name: str, taken: Collection[str], of_file: Collection[str]) -> str:
        """A name that is made up, with underscores behind it, where another has it or will have it."""
        while name in taken or name in of_file:
            name += "_"
        return name


_FREE = np.array([-np.inf, np.inf])
