"""Texts of SDF: the model, its frames, and poses relative to them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, suggest
from ..robots.description import homogeneous
from ..robots.frames import rotation_of_quaternion, rotation_of_rpy
from ..robots.xml_text import Element, XmlText, bytes_of

Array = NDArray[Any]
#: Children of a model that are read, and those that place no links.
OF_MODEL = ("link", "joint", "frame", "pose")
BESIDE_MODEL = ("static", "self_collide", "allow_auto_disable", "plugin", "enable_wind", "gripper")
WORLD, MODEL = "world", "__model__"


class SdfText(XmlText):
    """A text of one model.

    Attributes
    ----------
    model : Element
    links, joints, frames : dict of str to Element
    """

    def __init__(self, path: str, ignore: Iterable[str] = ()) -> None:
        super().__init__(path, bytes_of(path, "an SDF"))
        self.ignored = {*ignore}
        document = self.document
        if document.tag != "sdf":
            raise self.error(document, "this is not an SDF: its root", "An SDF has <sdf> around everything")
        models = [*document.iter("model")]
        if not models:
            raise InputError("there is no <model>.", where=path, remedy="An SDF of a robot has one")
        if len(models) > 1:
            raise self.error(models[1], "there is a second model:", "Keep one model in the file, without others in it")
        self.model = models[0]
        version = document.get("version", "1.7")
        self.version = tuple(int(x[:9]) if x.isdecimal() else 0 for x in version.split("."))
        self.links, self.joints, self.frames = (self._by_name(tag) for tag in ("link", "joint", "frame"))
        for name in self.joints:
            if name in self.links:
                raise self.error(self.joints[name], "a link has the same name as")
        for child in self.model:
            if child.tag not in (*OF_MODEL, *BESIDE_MODEL) and child.tag not in self.ignored:
                raise self.error(
                    child, f"a tag is not known{suggest(child.tag, OF_MODEL)}, and may change how the robot moves:",
                    f"Remove it, or load the file with ignore=[{child.tag!r}]",
                )  # fmt: skip
        if not self.links:
            raise InputError("there are no links.", where=path, remedy="An SDF's <model> has them")
        self._poses: dict[str, Array] = {MODEL: np.eye(4), WORLD: np.eye(4)}
        for name, element in self.links.items():
            self.pose_of(name, element)

    def _by_name(self, tag: str) -> dict[str, Element]:
        found: dict[str, Element] = {}
        for element in self.model.findall(tag):
            name = self.name(element)
            if name in found or name in (WORLD, MODEL):
                raise self.error(element, "a name is taken already:")
            found[name] = element
        return found

    # -- poses -----------------------------------------------------------------------------------------------

    def pose_of(self, name: str, at: Element) -> Array:
        """Pose (4, 4) of a link, joint or frame in the model's frame, where all coordinates are zero.

        Raises
        ------
        InputError
            If there is none, or poses are relative to each other in a circle.
        """
        path: dict[str, Array] = {}
        while name not in self._poses:
            element = self.links.get(name, self.joints.get(name, self.frames.get(name)))
            if element is None:
                known = (*self.links, *self.joints, *self.frames, MODEL)
                raise self.error(at, f"there is no frame {name!r}{suggest(name, known)}, as in")
            if name in path:
                raise self.error(element, "poses are relative to each other in a circle, as in")
            pose = self.only(element, "pose")
            own = "" if pose is None else pose.get("relative_to", pose.get("frame", ""))
            default = MODEL
            if element.tag == "joint":
                default = self.word(element, "child")
            elif element.tag == "frame":
                default = element.get("attached_to", "") or MODEL
            path[name] = self.pose(pose)
            name, at = own or default, element
        frame = self._poses[name]
        for each, own_pose in reversed(path.items()):
            frame = frame @ own_pose
            self._poses[each] = frame
        return frame

    def pose(self, element: Element | None) -> Array:
        """Matrix (4, 4) of a <pose>; the identity without one."""
        text = "" if element is None else (element.text or "").strip()
        if element is None or not text:
            return np.eye(4)
        if element.get("rotation_format", "euler_rpy") == "quat_xyzw":
            x = np.array(self.numbers(element, f"{text!r}", text, 7))
            if not np.abs(x[3:]).max() > 1e-14:
                raise self.error(element, "a quaternion is zero in")
            return homogeneous(rotation_of_quaternion(x[[6, 3, 4, 5]]), x[:3])
        x = np.array(self.numbers(element, f"{text!r}", text, 6))
        unit = np.pi / 180 if element.get("degrees", "false") in ("true", "1") else 1.0
        return homogeneous(rotation_of_rpy(unit * x[3:]), x[:3])

    # -- words and numbers -----------------------------------------------------------------------------------

    def word(self, element: Element, tag: str) -> str:
        """Text of a child, which there is."""
        child = self.only(element, tag)
        text = "" if child is None else (child.text or "").strip()
        if not text:
            raise self.error(element, f"there is no <{tag}> in")
        return text

    def number(self, element: Element | None, tag: str, default: float, infinite: bool = False) -> float:
        """Number of a child, which may be infinite."""
        child = None if element is None else self.only(element, tag)
        if child is None:
            return default
        text = (child.text or "").strip()
        if infinite and text in ("inf", "-inf", "+inf"):
            return float(text)
        return self.numbers(child, f"{text!r}", text, 1)[0]

    def vector(self, element: Element, tag: str, default: str) -> tuple[Array, Element]:
        """Three numbers of a child, and the child."""
        child = self.only(element, tag)
        text = default if child is None else (child.text or "").strip()
        at = element if child is None else child
        return np.array(self.numbers(at, f"{text!r}", text, 3)), at
