"""Robots from MJCF files: bodies, joints, inertias, equality constraints."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.files import as_path
from ...common.validation import as_choice
from ...mechanics.screws import geometry
from ..robots.description import Description, LinkInertia, RobotJoint, displacement, with_leaders
from ..robots.frames import unit
from ..robots.lumps import compose_inertias
from ..robots.robot import Robot
from ..robots.xml_text import Element, as_tags
from .equalities import WORLD, Equalities
from .geoms import UNKNOWN, geom_inertia, has_mass, inertial_of, placed
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
    numbers in MuJoCo. Free and ball joints take motors, see `Robot.poses`. ``connect`` and ``weld`` close loops of the
    mechanism and the system; ``joint`` makes a joint follow another.

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
    tags = as_tags(ignore)
    home, choice = geometry(algebra), as_choice(mimic, "mimic", MIMIC)
    reader = _Reader(MjcfText(str(as_path(path, "an MJCF is loaded from")), tags), choice)
    return Robot(reader.description(), home, impossible)


class _Reader:
    """Links and joints of a text, in MuJoCo's order."""

    def __init__(self, text: MjcfText, mimic: str) -> None:
        self._text, self._mimic = text, mimic
        self._links: dict[str, Element | None] = {WORLD: None}
        self._joints: dict[str, RobotJoint] = {}
        self._elements: dict[str, Element] = {}
        self._inertias: dict[str, LinkInertia] = {}
        self._sites: dict[str, tuple[str, Array]] = {}
        self._unknown: list[str] = []
        self._armatures: list[str] = []
        self._given = {name for each in text.document.iter() if (name := each.get("name"))}
        self._references: dict[str, float] = {}

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
            name = self._read_joints(element, parent, frame, f"body_{bodies}", childclass)
            front += reversed(self._read_body(element, name, element.get("childclass", childclass)))
        if not bodies:
            raise InputError("there are no bodies.", where=text.path, remedy="An MJCF has them in its <worldbody>")
        if self._unknown:
            shown = ", ".join(self._unknown[:5]) + (" ..." if len(self._unknown) > 5 else "")
            warnings.warn(
                f"{text.path}: the inertia of meshes and shells is not computed: {shown} are without; give them an "
                "<inertial>.",
                stacklevel=3,
            )
        if self._armatures:
            shown = ", ".join(self._armatures[:5]) + (" ..." if len(self._armatures) > 5 else "")
            warnings.warn(
                f"{text.path}: the inertia of rotors (armature) is not read: {shown} are without it.", stacklevel=3
            )
        self._scale_masses()
        own = self._links, self._joints, self._sites, self._references
        loops = Equalities(text, self._mimic, *own).read()
        joints = with_leaders(self._joints, lambda j, what, more: text.error(self._elements[j.name], what, more))
        return Description(text.model, text.path, tuple(self._links), joints, self._inertias, loops)

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
                self._sites[child.get("name", "")] = name, frame @ placed(text, child, text.attributes(child, own))[0]
            elif child.tag not in (*OF_BODY, *BESIDE_BODY) and child.tag not in text.ignored:
                raise text.unknown(child, OF_BODY)
        if name != WORLD:
            self._read_inertia(body, name, inertial, geoms)
        return found

    def _read_inertia(
        self,
        body: Element,
        name: str,
        inertial: LinkInertia | None,
        geoms: list[tuple[Element, dict[str, str], Array]],
    ) -> None:
        text = self._text
        choice = text.settings.get("inertiafromgeom", "auto")
        if choice == "true" or (choice == "auto" and inertial is None):
            low, high = np.array(text.settings.get("inertiagrouprange", "0 5").split(), float)
            parts = []
            for element, values, frame in geoms:
                if not low <= float(text.vector(element, values, "group", "0", 1)[0]) <= high:
                    continue
                if values.get("type", "sphere") in UNKNOWN or "mesh" in values or values.get("shellinertia") == "true":
                    if not has_mass(text, element, values):
                        continue
                    self._unknown.append(repr(name))
                    return
                part = geom_inertia(text, element, values, frame)
                if part is not None:
                    parts.append(part)
            inertial = compose_inertias([part for part in parts if part.mass]) if parts else inertial
        bounds = [float(text.settings.get(bound, "0")) for bound in ("boundmass", "boundinertia")]
        if inertial is None and max(bounds) > 0:
            inertial = LinkInertia(0.0, np.zeros((3, 3)), np.eye(4))
        if inertial is not None:
            if not np.isfinite(inertial.tensor).all():
                raise text.error(body, "the inertia overflows: masses or sizes are too large in")
            self._inertias[name] = self._bounded(inertial)

    def _bounded(self, inertia: LinkInertia) -> LinkInertia:
        """An inertia within the bounds of the compiler."""
        settings = self._text.settings
        mass, least = (float(settings.get(name, "0")) for name in ("boundmass", "boundinertia"))
        moments, axes = np.linalg.eigh(inertia.tensor)
        bounded = np.maximum(moments, least)
        if settings.get("balanceinertia") == "true" and 2 * bounded.max() > bounded.sum():
            bounded = np.full(3, bounded.mean())
        tensor = inertia.tensor if np.array_equal(bounded, moments) else (axes * bounded) @ axes.T
        return LinkInertia(max(inertia.mass, mass), tensor, inertia.origin)

    def _scale_masses(self) -> None:
        total = float(self._text.settings.get("settotalmass", "-1"))
        own = sum(inertia.mass for inertia in self._inertias.values())
        if total > 0 and own > 0:
            self._inertias = {
                name: LinkInertia(x.mass * total / own, x.tensor * (total / own), x.origin)
                for name, x in self._inertias.items()
            }

    # -- joints ----------------------------------------------------------------------------------------------

    def _read_joints(self, body: Element, parent: str, frame: Array, default: str, childclass: str | None) -> str:
        """Read the joints between a body and its parent; the body's name."""
        text = self._text
        name = self._new_name(body, body.get("name") or self._unused(default), self._links, "body")
        childclass = body.get("childclass", childclass)
        origin = frame @ text.frame(body, dict(body.attrib))
        joints = [
            (child, inner, own)
            for child, inner, own in text.children(body, childclass)
            if child.tag in ("joint", "freejoint")
        ]
        if not joints:
            weld, axis = self._unused(f"{name}_weld"), np.array([1.0, 0, 0])
            self._add(body, RobotJoint(weld, "fixed", parent, name, origin, axis, _FREE))
        above = parent
        for i, (element, inner, own) in enumerate(joints):
            label = f"{name}_joint" + (f"_{i + 1}" if len(joints) > 1 else "")
            joint = self._read_joint(element, inner, own, element.get("name") or self._unused(label))
            if joint.type == "floating" and (parent != WORLD or len(joints) > 1):
                raise text.error(element, "a free joint is alone in its body, and that is in the world; one is")
            link = name
            if i < len(joints) - 1:
                link = self._new_name(element, self._unused(f"{name}/{joint.name}"), self._links, "link")
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
        values = {"type": "free"} if is_free else text.attributes(element, childclass)
        kind = TYPES[text.choice(element, "type", values.get("type", "hinge"), TYPES)]
        align = text.flag(element, dict(element.attrib), "align", "auto") if kind == "floating" else "false"
        if align == "true" or (align == "auto" and text.settings.get("alignfree") == "true"):
            raise text.error(
                element, "the body's frame is moved to its inertia's by align or alignfree, as for", "Set align='false'"
            )
        if kind != "floating" and text.vector(element, values, "armature", "0", 1)[0] != 0:
            self._armatures.append(repr(name))
        axis = frame[:3, :3] @ unit(text.vector(element, values, "axis", "0 0 1", 3))
        position = frame[:3, :3] @ text.vector(element, values, "pos", "0 0 0", 3) + frame[:3, 3]
        if kind in ("revolute", "prismatic") and not axis.any():
            raise text.error(element, "the axis has no length in")
        angle = text.angle if kind == "revolute" else 1.0
        limits = _FREE
        if kind in ("revolute", "prismatic") and self._is_limited(element, values):
            limits = angle * text.vector(element, values, "range", "0 0", 2)
            if not limits[0] < limits[1]:
                raise text.error(element, f"range={values.get('range', '')!r}: least, then greatest, in")
        joint = RobotJoint(
            name, kind, "", "", np.eye(4), axis, limits,
            np.zeros(3) if kind == "floating" else position,
        )  # fmt: skip
        if kind in ("revolute", "prismatic"):
            reference = float(angle * text.vector(element, values, "ref", "0", 1)[0])
            self._references[name] = reference
            if reference:
                joint = replace(joint, origin=displacement(joint, -reference))
        return joint

    def _is_limited(self, element: Element, values: dict[str, str]) -> bool:
        limited = self._text.flag(element, values, "limited", "auto")
        if limited == "auto":
            return "range" in values and self._text.settings.get("autolimits", "true") == "true"
        return limited == "true"

    def _add(self, element: Element, joint: RobotJoint) -> None:
        self._new_name(element, joint.name, self._joints, "joint")
        self._joints[joint.name] = joint
        self._elements[joint.name] = element

    def _unused(self, name: str) -> str:
        """A name for what has none in the file, that nothing else has."""
        while name in self._given or name in self._joints or name in self._links:
            name += "_"
        return name

    def _new_name(self, element: Element, name: str, taken: Iterable[str], what: str) -> str:
        if not name.strip():
            raise self._text.error(element, f"the name of a {what} is empty in")
        if name in taken:
            raise self._text.error(element, f"the name {name!r} is taken already:")
        return name


_FREE = np.array([-np.inf, np.inf])
