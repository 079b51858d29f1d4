"""Joints and inertias of checked URDF texts."""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from ..robots.description import Description, Follower, LinkInertia, RobotJoint, with_leaders
from ..robots.frames import rotation_of_rpy, unit_vector
from .parser import Text

Array = NDArray[Any]


def description_of(text: Text) -> Description:
    """The robot of a checked text."""
    links = {x.get("name", ""): x.find("inertial") for x in text.root.findall("link")}
    elements = {str(x.get("name")): x for x in text.root.findall("joint")}
    joints = {name: joint_of(x, text) for name, x in elements.items()}
    joints = with_leaders(joints, lambda joint, what, remedy: text.error(elements[joint.name], what, remedy))
    inertias = {name: inertia_of(x) for name, x in links.items() if x is not None}
    return Description(str(text.root.get("name")), text.path, tuple(links), joints, inertias)


def joint_of(element: Element, text: Text) -> RobotJoint:
    """A joint of a checked text."""
    kind, limit = str(element.get("type")), element.find("limit")
    lower, upper = (
        None if limit is None or kind == "continuous" or limit.get(name) is None else float(limit.get(name, ""))
        for name in ("lower", "upper")
    )
    if lower is not None and upper is not None and lower > upper:
        raise text.error(element, f"the limits are {lower:g} and {upper:g}: least, then greatest, in")
    axis = _vector(element.find("axis"), "xyz", "1 0 0")
    if not axis.any() and kind not in ("fixed", "floating"):
        raise text.error(element, "the axis has no length in")
    parent, child = (_part(element, tag).get("link", "") for tag in ("parent", "child"))
    mimic = element.find("mimic")
    follows = None
    if mimic is not None:
        numbers = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
        follows = Follower(mimic.get("joint", ""), *numbers)
    return RobotJoint(
        element.get("name", ""), kind, parent, child, _origin(element), unit_vector(axis),
        np.array([-np.inf if lower is None else lower, np.inf if upper is None else upper]), follows=follows,
    )  # fmt: skip


def inertia_of(element: Element) -> LinkInertia:
    """An inertia of a checked text."""
    moments = _part(element, "inertia")
    xx, yy, zz, xy, xz, yz = (float(moments.get(f"i{name}", "0")) for name in ("xx", "yy", "zz", "xy", "xz", "yz"))
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return LinkInertia(float(_part(element, "mass").get("value", "")), tensor, _origin(element))


def _part(element: Element, tag: str) -> Element:
    part = element.find(tag)
    assert part is not None  # the text is checked
    return part


def _vector(element: Element | None, name: str, default: str) -> Array:
    return np.array([float(x) for x in (default if element is None else element.get(name, default)).split()])


def _origin(element: Element) -> Array:
    """Pose (4, 4) of an ``<origin>``: rotation by roll, pitch, yaw about the fixed x, y, z, then translation."""
    origin, rotation, translation = element.find("origin"), np.eye(4), np.eye(4)
    if origin is None:
        return rotation
    rotation[:3, :3] = rotation_of_rpy(_vector(origin, "rpy", "0 0 0"))
    translation[:3, 3] = _vector(origin, "xyz", "0 0 0")
    transform: Array = np.dot(translation, rotation)
    return transform
