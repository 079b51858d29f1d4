"""Checker of URDF texts: XML without document types, checked tag by tag and reduced to links and joints.

Nothing is fetched, and nothing is expanded: a text that declares entities is refused. Visuals, contacts, motors and
simulator tags are left out; an unknown tag that could change the motion of the robot is an error.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from math import isfinite
from xml.etree import ElementTree
from xml.parsers import expat

from ...codegen.errors import InputError, suggest
from ...common.files import as_path

Element = ElementTree.Element
#: Length of a robot's text at most.
MOST_BYTES = 64 << 20
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
#: Tags of a robot that are unrelated to links and joints.
BESIDES = (
    "material", "transmission", "gazebo", "sensor", "ros2_control", "plugin", "link_state", "joint_state", "camera",
    "disable_collisions", "frame", "mujoco", "drake:diffuse_map", "capsule", "usd",
)  # fmt: skip
#: Tags of a joint that are read.
OF_JOINT = ("parent", "child", "origin", "axis", "limit", "mimic")
#: Tags of a joint that are unrelated to its motion.
BESIDE_JOINT = ("dynamics", "safety_controller", "calibration", "hardwareInterface", "gazebo", "sensor", "property")
#: Required and optional attributes by tag.
ATTRIBUTES = {
    "parent": (("link",), ()),
    "child": (("link",), ()),
    "origin": ((), ("xyz", "rpy")),
    "axis": (("xyz",), ()),
    "limit": ((), ("lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk")),
    "mimic": (("joint",), ("multiplier", "offset")),
    "mass": (("value",), ()),
    "inertia": (("ixx", "iyy", "izz"), ("ixy", "ixz", "iyz")),
}
_WORDS = ("link", "joint")
_VECTORS = ("xyz", "rpy")


class Text:
    """A robot's text, read and checked.

    Attributes
    ----------
    path : str
        For messages.
    root : Element
        Links and joints with their known tags only.
    """

    def __init__(self, path: str, data: bytes, mimic: str, ignore: Iterable[str] = ()) -> None:
        self.path = path
        self._mimic, self._ignored = mimic, {*BESIDES, *ignore}
        self._beside_joint = {*BESIDE_JOINT, *ignore}
        self._lines: dict[Element, int] = {}
        document = self._parse(data)
        if document.tag != "robot":
            raise self.error(document, "this is not a URDF: its root", "A URDF has <robot> around everything")
        self.root = Element("robot", {"name": document.get("name", "robot")})
        for child in document:
            if child.tag == "link":
                self.root.append(self._link(child))
            elif child.tag == "joint":
                self.root.append(self._joint(child))
            elif child.tag not in self._ignored:
                raise self._unknown(child, ("link", "joint"))
        self._unique("link")
        self._unique("joint")
        self._ends()

    def error(self, at: Element, what: str, remedy: str | None = None) -> InputError:
        """An error in an element: file, line and tag."""
        name = f" name={at.get('name')!r}" if at.get("name") is not None else ""
        return InputError(f"{what} <{at.tag}{name}>", where=f"{self.path}:{self._lines.get(at, 1)}", remedy=remedy)

    def line(self, at: Element) -> int:
        """Line of an element."""
        return self._lines.get(at, 1)

    # -- XML -------------------------------------------------------------------------------------------------

    def _parse(self, data: bytes) -> Element:
        parser, builder = expat.ParserCreate(), ElementTree.TreeBuilder()

        def doctype(*_: object) -> None:
            raise InputError(
                "a document type is declared; entities are neither expanded nor fetched.",
                where=f"{self.path}:{parser.CurrentLineNumber}",
                remedy="Remove the <!DOCTYPE>, and write out what it defines",
            )

        def start(tag: str, attributes: dict[str, str]) -> None:
            self._lines[builder.start(tag, attributes)] = parser.CurrentLineNumber

        parser.StartDoctypeDeclHandler = doctype
        parser.StartElementHandler = start
        parser.EndElementHandler = builder.end
        try:
            parser.Parse(data, True)
        except expat.ExpatError as error:
            raise InputError(
                f"this is not XML: {expat.ErrorString(error.code)}.", where=f"{self.path}:{error.lineno}"
            ) from None
        return builder.close()

    # -- elements --------------------------------------------------------------------------------------------

    def _link(self, element: Element) -> Element:
        copy = self._copy(element, {"name": self._name(element)})
        inertial = self._only(element, "inertial")
        if inertial is not None:
            mass = self._copy(inertial, {})
            for tag in ("origin", "mass", "inertia"):
                part = self._only(inertial, tag)
                if part is not None:
                    mass.append(self._numbers(part))
                elif tag != "origin":
                    raise self.error(inertial, f"there is no <{tag}> in")
            copy.append(mass)
        return copy

    def _joint(self, element: Element) -> Element:
        kind = element.get("type")
        if kind not in JOINT_TYPES:
            raise self.error(
                element,
                f"{kind!r} is not a type of joint{suggest(kind, JOINT_TYPES)} in",
                f"One of: {', '.join(JOINT_TYPES)}",
            )
        copy = self._copy(element, {"name": self._name(element), "type": kind})
        for child in element:
            if child.tag not in OF_JOINT and child.tag not in self._beside_joint:
                raise self._unknown(child, OF_JOINT)
        for tag in OF_JOINT:
            part = self._only(element, tag)
            if part is None and tag in ("parent", "child"):
                raise self.error(element, f"there is no <{tag} link=...> in")
            if tag == "mimic" and part is not None and self._mimic == "error":
                raise self.error(
                    element, "joints that follow others (<mimic>) are not computed; one is",
                    "Load it with mimic='free' to have it as a joint of its own",
                )  # fmt: skip
            if part is not None and tag != "mimic":
                copy.append(self._numbers(part))
        return copy

    def _copy(self, element: Element, attributes: dict[str, str]) -> Element:
        copy = Element(element.tag, attributes)
        self._lines[copy] = self.line(element)
        return copy

    def _name(self, element: Element) -> str:
        name = element.get("name", "")
        if not name.strip():
            raise self.error(element, "there is no name in")
        return name

    def _only(self, element: Element, tag: str) -> Element | None:
        found = element.findall(tag)
        if len(found) > 1:
            raise self.error(found[1], f"there is a second <{tag}> in {_tag_text(element)}:")
        return found[0] if found else None

    def _numbers(self, element: Element) -> Element:
        needed, more = ATTRIBUTES[element.tag]
        for name in needed:
            if name not in element.attrib:
                raise self.error(element, f"there is no {name!r} in")
        for name, value in element.attrib.items():
            if name not in needed and name not in more:
                raise self.error(element, f"{name}={value!r} is not known{suggest(name, (*needed, *more))} in")
            if name not in _WORDS:
                self._check(element, name, value, 3 if name in _VECTORS else 1)
        return self._copy(element, dict(element.attrib))

    def _check(self, element: Element, name: str, value: str, count: int) -> None:
        try:
            found = [float(x) for x in value.split()]
        except ValueError:
            found = []
        if len(found) != count or not all(isfinite(x) for x in found):
            needed = "a finite number is" if count == 1 else f"{count} finite numbers are"
            raise self.error(element, f"{name}={value!r}, where {needed} needed, in")

    def _unknown(self, element: Element, known_tags: tuple[str, ...]) -> InputError:
        if element.tag.startswith("xacro:"):
            return self.error(
                element, "this is a xacro, not yet a URDF:", "Expand it first: xacro file.xacro > file.urdf"
            )
        return self.error(
            element, f"a tag is not known{suggest(element.tag, known_tags)}, and may change how the robot moves:",
            f"Remove it, or load the file with ignore=[{element.tag!r}]",
        )  # fmt: skip

    # -- as a whole ------------------------------------------------------------------------------------------

    def _unique(self, tag: str) -> None:
        elements = self.root.findall(tag)
        counts = Counter(x.get("name") for x in elements)
        seen: set[str | None] = set()
        for x in elements:
            if counts[x.get("name")] > 1 and x.get("name") in seen:
                raise self.error(x, "a name is taken already:")
            seen.add(x.get("name"))
        if tag == "link" and not elements:
            raise InputError("there are no links.", where=self.path)

    def _ends(self) -> None:
        """Check that the joints connect all links in one tree."""
        links = dict.fromkeys(str(x.get("name")) for x in self.root.findall("link"))
        above: dict[str, tuple[str, Element]] = {}
        for joint in self.root.findall("joint"):
            ends = [str(joint.find(tag).get("link")) for tag in ("parent", "child")]  # type: ignore[union-attr]
            for name in ends:
                if name not in links:
                    raise self.error(joint, f"there is no link {name!r}{suggest(name, links)}, as in")
            if ends[0] == ends[1]:
                raise self.error(joint, "a link is joined to itself by")
            if ends[1] in above:
                raise self.error(
                    joint, f"the link {ends[1]!r} has two parents: a loop cannot be a URDF, as in",
                    "Load it without the joint, and add that to the mechanism",
                )  # fmt: skip
            above[ends[1]] = ends[0], joint
        roots = [name for name in links if name not in above]
        if len(roots) > 1:
            raise InputError(
                f"the links {roots[0]!r} and {roots[1]!r} are not connected.", where=self.path,
                remedy="Join all links into one tree",
            )  # fmt: skip
        reached = {*roots}
        for name in links:
            path: dict[str, None] = {}
            while name not in reached:
                if name in path:
                    raise self.error(above[name][1], f"the link {name!r} is its own ancestor by")
                path[name] = None
                name = above[name][0]
            reached.update(path)


def _tag_text(element: Element) -> str:
    return f"<{element.tag} name={element.get('name')!r}>" if element.get("name") else f"<{element.tag}>"


def bytes_of(path: str | os.PathLike[str]) -> bytes:
    """The file's content.

    Raises
    ------
    InputError
        If there is no such file, or it is too long.
    """
    file = as_path(path, "a URDF is loaded from")
    try:
        if file.stat().st_size > MOST_BYTES:
            raise InputError(f"the file has more than {MOST_BYTES >> 20} MiB.", where=str(path))
        return file.read_bytes()
    except OSError as error:
        raise InputError(f"the file cannot be read: {error.strerror}.", where=str(path)) from None
