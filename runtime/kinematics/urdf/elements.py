"""Joints and inertias of checked URDF texts; their numbers are read by yourdfpy."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import MissingExtraError
from .parser import Text

Array = NDArray[Any]
#: Types of joints with one coordinate.
MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class UrdfJoint:
    """A joint of a file.

    Attributes
    ----------
    name, type, parent, child : str
    origin : array (4, 4)
        Pose of the child's frame in the parent's, at zero.
    axis : array (3,)
        A unit vector in the child's frame; the normal of a planar joint.
    limits : array (2,)
        Least and greatest coordinate; infinite by default.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: Array
    axis: Array
    limits: Array


@dataclass(frozen=True)
class UrdfInertia:
    """Mass, and the tensor (3, 3) about the center of mass along the axes of ``origin`` (4, 4) in the link's frame."""

    mass: float
    tensor: Array
    origin: Array


def parse_robot(text: Text) -> Any:
    """The robot of a checked text, as parsed by yourdfpy."""
    try:
        from yourdfpy import URDF  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        raise MissingExtraError("urdf", "Loading a URDF") from None
    data = BytesIO(ElementTree.tostring(text.root, "utf-8"))
    return URDF.load(data, build_scene_graph=False, load_meshes=False).robot


def joint_of(joint: Any, text: Text, element: Any) -> UrdfJoint:
    limit = joint.limit
    lower, upper = (None, None) if limit is None or joint.type == "continuous" else (limit.lower, limit.upper)
    if lower is not None and upper is not None and lower > upper:
        raise text.error(element, f"the limits are {lower:g} and {upper:g}: least, then greatest, in")
    axis = np.asarray(joint.axis, float)
    size = float(np.linalg.norm(axis))
    if not size > 0 and joint.type in (*MOVING, "planar"):
        raise text.error(element, "the axis has no length in")
    origin = np.eye(4) if joint.origin is None else np.asarray(joint.origin, float)
    return UrdfJoint(
        joint.name, joint.type, joint.parent, joint.child, origin, axis / size if size > 0 else axis,
        np.array([-np.inf if lower is None else lower, np.inf if upper is None else upper]),
    )  # fmt: skip


def inertia_of(inertial: Any) -> UrdfInertia:
    origin = np.eye(4) if inertial.origin is None else np.asarray(inertial.origin, float)
    return UrdfInertia(float(inertial.mass), np.asarray(inertial.inertia, float), origin)
