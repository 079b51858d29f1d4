"""Texts of MJCF: includes, defaults by class, settings of the compiler, numbers and orientations.

Files are included from the folder of the first one only, each once: nothing grows, and nothing else is read.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, suggest
from ..robots.description import homogeneous
from ..robots.frames import rotation_about, rotation_of_quaternion, rotation_to, unit_vector
from ..robots.xml_text import MOST_BYTES, Element, XmlText, bytes_of

Array = NDArray[Any]
#: A quaternion whose length is so far from 1 was not rounded.
NOT_UNIT = 1e-2
#: Included files at most.
MOST_FILES = 256
#: Tags of a model that do not place bodies or join them.
BESIDES = (
    "option", "size", "visual", "statistic", "asset", "contact", "deformable", "tendon", "actuator", "sensor",
    "keyframe", "custom", "extension",
)  # fmt: skip
SECTIONS = ("compiler", "default", "worldbody", "equality")
#: Attributes of the compiler that matter.
COMPILER = (
    "angle", "eulerseq", "autolimits", "inertiafromgeom", "boundmass", "boundinertia", "settotalmass", "coordinate",
    "inertiagrouprange", "balanceinertia", "alignfree",
)  # fmt: skip
ORIENTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")


class MjcfText(XmlText):
    """A model's text with what it includes.

    Attributes
    ----------
    sections : dict of str to list of Element
        Children of the sections that are read.
    model : str
    settings : dict of str to str
        Of the compiler.
    """

    def __init__(self, path: str, ignore: Iterable[str] = ()) -> None:
        self._folder, self._files, self._bytes = Path(path).resolve().parent, [Path(path).resolve()], 0
        self.ignored, self._is_warned = {*ignore}, False
        data = bytes_of(path, "an MJCF")
        super().__init__(path, data)
        self._bytes = len(data)
        if self.document.tag != "mujoco":
            raise self.error(self.document, "this is not an MJCF: its root", "An MJCF has <mujoco> around everything")
        self.model = self.document.get("model", "MuJoCo Model")
        self._include(self.document)
        self.sections: dict[str, list[Element]] = {name: [] for name in SECTIONS}
        self.settings: dict[str, str] = {}
        for section in self.document:
            if section.tag in self.sections:
                self.sections[section.tag].append(section)
            elif section.tag not in BESIDES and section.tag not in self.ignored:
                raise self.unknown(section, SECTIONS)
        for element in self.sections["compiler"]:
            self.settings.update({k: v for k, v in element.attrib.items() if k in COMPILER})
        self._check_settings()
        self._defaults: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        for element in self.sections["default"]:
            self._read_defaults(element, "main", {}, True)

    def unknown(self, element: Element, known: Iterable[str]) -> InputError:
        """Error of a tag that is not read."""
        return self.error(
            element, f"a tag is not known{suggest(element.tag, known)}, and may change how the robot moves:",
            f"Remove it, or load the file with ignore=[{element.tag!r}]",
        )  # fmt: skip

    # -- includes --------------------------------------------------------------------------------------------

    def _include(self, root: Element) -> None:
        """Replace all <include> below an element by the children of the files' roots."""
        front = [root]
        while front:
            element = front.pop()
            children = list(element)
            if any(child.tag == "include" for child in children):
                for child in children:
                    element.remove(child)
                for child in children:
                    element.extend(self._included(child) if child.tag == "include" else [child])
                front.append(element)  # what was included may include
            else:
                front += children

    def _included(self, element: Element) -> list[Element]:
        name = element.get("file", "")
        file = (self._folder / name).resolve()
        if not name or not file.is_relative_to(self._folder):
            raise self.error(
                element, f"file={name!r} is not in the model's folder, as in",
                f"Files are included from {self._folder} and its folders only",
            )  # fmt: skip
        if file in self._files:
            raise self.error(element, f"{name!r} is included a second time, or by itself, as in", "Include it once")
        self._files.append(file)
        if len(self._files) > MOST_FILES:
            raise self.error(element, f"more than {MOST_FILES} files are included, as in")
        data = bytes_of(file, "an MJCF")
        self._bytes += len(data)
        if self._bytes > MOST_BYTES:
            raise self.error(element, f"included files have more than {MOST_BYTES >> 20} MiB together, with")
        root = self.parse(str(file), data)
        if root.tag not in ("mujoco", "mujocoinclude"):
            raise self.error(root, "this is not an MJCF: its root")
        return list(root)

    # -- settings and defaults -------------------------------------------------------------------------------

    def _check_settings(self) -> None:
        if not self.sections["compiler"]:
            return
        at, settings = self.sections["compiler"][-1], self.settings
        for name, choices in (
            ("angle", ("degree", "radian")), ("autolimits", ("true", "false")),
            ("inertiafromgeom", ("true", "false", "auto")), ("coordinate", ("local",)),
            ("balanceinertia", ("true", "false")), ("alignfree", ("true", "false")),
        ):  # fmt: skip
            if name in settings:
                self.choice(at, name, settings[name], choices)
        if len(settings.get("eulerseq", "xyz")) != 3 or set(settings.get("eulerseq", "xyz").lower()) - set("xyz"):
            raise self.error(at, f"eulerseq={settings['eulerseq']!r}, where three of xyzXYZ are needed, in")
        for name in ("boundmass", "boundinertia", "settotalmass"):
            if name in settings:
                self.numbers(at, f"{name}={settings[name]!r}", settings[name], 1)

    def _read_defaults(
        self, element: Element, name: str, above: dict[str, dict[str, str]], is_top: bool
    ) -> None:  # fmt: skip
        name = element.get("class", "main" if is_top else "")
        if not name:
            raise self.error(element, "there is no class in")
        own = {tag: dict(values) for tag, values in self._defaults.get(name, above).items()}
        for child in element:
            if child.tag != "default":
                own[child.tag] = own.get(child.tag, {}) | dict(child.attrib)
        self._defaults[name] = own
        for child in element:
            if child.tag == "default":
                self._read_defaults(child, "", own, False)

    def attributes(self, element: Element, childclass: str | None, tag: str | None = None) -> dict[str, str]:
        """Attributes of an element, with those that its class has for a tag: its own by default."""
        name = element.get("class", childclass or "main")
        if name not in self._defaults:
            raise self.error(element, f"there is no default class {name!r}{suggest(name, self._defaults)}, as in")
        own, found = dict(element.attrib), dict(self._defaults[name].get(tag or element.tag, {}))
        if any(k in own for k in ORIENTATIONS):  # one orientation takes the place of another
            found = {k: v for k, v in found.items() if k not in ORIENTATIONS}
        return found | own

    # -- numbers ---------------------------------------------------------------------------------------------

    def vector(self, element: Element, values: dict[str, str], name: str, default: str, count: int | None) -> Array:
        """Numbers of an attribute."""
        text = values.get(name, default)
        return np.array(self.numbers(element, f"{name}={text!r}", text, count))

    def flag(self, element: Element, values: dict[str, str], name: str, default: str) -> str:
        """"true", "false" or "auto"."""
        return self.choice(element, name, values.get(name, default), ("true", "false", "auto"))

    @property
    def angle(self) -> float:
        """Radians of a unit of angle."""
        return 1.0 if self.settings.get("angle", "degree") == "radian" else np.pi / 180

    def frame(self, element: Element, values: dict[str, str]) -> Array:
        """Pose (4, 4) of an element's attributes."""
        return homogeneous(self.rotation(element, values), self.vector(element, values, "pos", "0 0 0", 3))

    def rotation(self, element: Element, values: dict[str, str]) -> Array:
        """Rotation (3, 3) of an element's attributes."""
        found = [name for name in ORIENTATIONS if name in values]
        if not found:
            return np.eye(3)
        name = found[-1]  # others come before quat
        numbers = self.vector(element, values, name, "", {"quat": 4, "axisangle": 4, "xyaxes": 6}.get(name, 3))
        if name == "euler":
            return self._rotation_of_euler(numbers * self.angle)
        short = {"quat": numbers, "axisangle": numbers[:3], "xyaxes": numbers[:3], "zaxis": numbers}[name]
        if not np.abs(short).max() > 1e-14:
            raise self.error(element, f"{name}={values[name]!r} has no direction in")
        if name == "quat":
            size = hypot(*numbers)
            if abs(size - 1) > NOT_UNIT and not self._is_warned:
                self._is_warned = True
                warnings.warn(
                    f"{self.path}:{self.line(element)}: quat={values[name]!r} is {size:.4g} long and is normalized, as "
                    "others may be; the order is w, x, y, z.",
                    stacklevel=2,
                )
            return rotation_of_quaternion(numbers)
        if name == "axisangle":
            return rotation_about(unit_vector(short), float(numbers[3] * self.angle))
        if name == "zaxis":
            return rotation_to(numbers)
        x, y = unit_vector(short), unit_vector(numbers[3:])
        y = y - (x @ y) * x
        if not np.linalg.norm(y) > 1e-14:
            raise self.error(element, f"xyaxes={values[name]!r} are parallel in")
        y = unit_vector(y)
        return np.stack([x, y, np.cross(x, y)], 1)

    def _rotation_of_euler(self, angles: Array) -> Array:
        """Lower case: about axes that turn along; upper case: about fixed ones."""
        rotation = np.eye(3)
        for letter, angle in zip(self.settings.get("eulerseq", "xyz"), angles.tolist(), strict=True):
            step = rotation_about(np.eye(3)["xyz".index(letter.lower())], angle)
            rotation = rotation @ step if letter.islower() else step @ rotation
        return rotation

    def children(self, body: Element, childclass: str | None) -> Iterator[tuple[Element, Array, str | None]]:
        """Children of a body, those in <frame> included, with the frame (4, 4) that they are in and their class."""
        front = [(child, np.eye(4), childclass) for child in reversed(body)]
        while front:
            child, frame, name = front.pop()
            if child.tag == "frame":
                inner = frame @ self.frame(child, dict(child.attrib))
                front += [(x, inner, child.get("childclass", name)) for x in reversed(child)]
            else:
                yield child, frame, name
