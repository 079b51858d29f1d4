"""Checker of URDF texts: checked tag by tag and reduced to links and joints.

Visuals, contacts, motors and simulator tags are left out; an unknown tag that could change the motion of the robot is
an error.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterable

from ...codegen.errors import InputError, suggest
from ..robots.xml_text import Element, XmlText

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
#: What may become of joints that follow others.
MIMIC = ("follow", "free", "error")
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
#: Tags whose other attributes do not place anything: they are left out, with a warning.
HARMLESS = ("limit",)
_WORDS = ("link", "joint")
_VECTORS = ("xyz", "rpy")


class Text(XmlText):
    """A robot's text, read and checked.

    Parameters
    ----------
    path, data
        As of `XmlText`.
    mimic : str
        Of `MIMIC`.
    ignore : iterable of str
        Unknown tags and attributes that may be left out.
    strict : bool
        Whether harmless unknown attributes are refused too.

    Attributes
    ----------
    root : Element
        Links and joints with their known tags only.
    """

    def __init__(
        self, path: str, data: bytes, mimic: str, ignore: Iterable[str] = (), strict: bool = False, stacklevel: int = 3
    ) -> None:
        super().__init__(path, data)
        self._mimic, self._strict, self._named = mimic, strict, {*ignore}
        self._ignored, self._beside_joint = {*BESIDES, *self._named}, {*BESIDE_JOINT, *self._named}
        self._unknown_attributes: dict[str, int] = {}
        document = self.document
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
        if self._unknown_attributes:
            found = ", ".join(f"{name} (line {line})" for name, line in self._unknown_attributes.items())
            warnings.warn(
                f"{path}: attributes that are not known are left out: {found}; ignore={[*self._unknown_attributes]} "
                "says that they may be, strict=True refuses them.",
                stacklevel=stacklevel,
            )

    # -- elements --------------------------------------------------------------------------------------------

    def _link(self, element: Element) -> Element:
        copy = self.copy(element, {"name": self.name(element)})
        inertial = self.only(element, "inertial")
        if inertial is not None:
            mass = self.copy(inertial, {})
            for tag in ("origin", "mass", "inertia"):
                part = self.only(inertial, tag)
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
        copy = self.copy(element, {"name": self.name(element), "type": kind})
        for child in element:
            if child.tag not in OF_JOINT and child.tag not in self._beside_joint:
                raise self._unknown(child, OF_JOINT)
        for tag in OF_JOINT:
            part = self.only(element, tag)
            if part is None and tag in ("parent", "child"):
                raise self.error(element, f"there is no <{tag} link=...> in")
            if part is None or (tag == "mimic" and not self._follows(element, kind)):
                continue
            copy.append(self._numbers(part))
        return copy

    def _follows(self, joint: Element, kind: str) -> bool:
        """Whether a <mimic> counts: one of a fixed joint says nothing."""
        if self._mimic == "error":
            raise self.error(
                joint, "joints that follow others (<mimic>) are refused with mimic='error'; one is",
                "Load it with mimic='follow', or 'free' to have it as a joint of its own",
            )  # fmt: skip
        if kind in ("floating", "planar"):
            raise self.error(joint, f"a {kind} joint has no single coordinate that could follow another's; one is")
        return self._mimic == "follow" and kind != "fixed"

    def _numbers(self, element: Element) -> Element:
        needed, more = ATTRIBUTES[element.tag]
        for name in needed:
            if name not in element.attrib:
                raise self.error(element, f"there is no {name!r} in")
        kept = {}
        for name, value in element.attrib.items():
            if name in needed or name in more:
                kept[name] = value
                if name not in _WORDS:
                    self.numbers(element, f"{name}={value!r}", value, 3 if name in _VECTORS else 1)
            elif name not in self._named:
                if self._strict or element.tag not in HARMLESS:
                    raise self.error(
                        element, f"{name}={value!r} is not known{suggest(name, (*needed, *more))} in",
                        f"Remove it, or load the file with ignore=[{name!r}]",
                    )  # fmt: skip
                self._unknown_attributes.setdefault(name, self.line(element))
        return self.copy(element, kept)

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
            raise InputError(
                "there are no links.", where=self.path,
                remedy="A part that other files include is no robot: load the one that includes it, expanded by xacro",
            )  # fmt: skip

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
