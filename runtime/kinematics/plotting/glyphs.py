"""Sketch of a mechanism at a pose: position and axes of each joint, and the joints that each body connects.

Plain data: no picture is made here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import BladesmithError
from ...mechanics.joints.base import Joint, direction_of
from ...mechanics.joints.displaced import DisplacedJoint
from ...mechanics.screws import screw_coordinates

if TYPE_CHECKING:
    from ...core.multivector import Multivector
    from ..mechanism.mechanism import Mechanism

Array = NDArray[Any]
#: Two directions whose cross product is shorter are one.
PARALLEL = 1e-9


@dataclass(frozen=True, eq=False)
class Mark:
    """A joint.

    Attributes
    ----------
    name, kind : str
        The kind in lower case: "revolute".
    position : array (3,)
    axes : array (m, 3)
        Unit vectors: along which it slides or about which it turns, or the normal; of a universal joint both.
    """

    name: str
    kind: str
    position: Array
    axes: Array


@dataclass(frozen=True, eq=False)
class Sketch:
    """A mechanism at a pose.

    Attributes
    ----------
    marks : tuple of Mark
    bodies : dict of str to array (m, 3)
        Positions of each body's joints, and of its tool.
    fixed : str
    """

    marks: tuple[Mark, ...]
    bodies: dict[str, Array]
    fixed: str

    @property
    def span(self) -> float:
        """Longest side of the box around all positions; 1 if they coincide."""
        points = np.concatenate(list(self.bodies.values()))
        side = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
        return side if side > 0 else 1.0


def mechanism_sketch(mechanism: Mechanism, tool: str = "", position: Any = None) -> Sketch:
    """Positions and axes of the joints of a mechanism.

    Parameters
    ----------
    mechanism : Mechanism
    tool : str, optional
        A body, and ``position`` (3,) a point of it in the world, the end of its stick.
    """
    parts = [_location(joint) for joint in mechanism.joints]
    corners: dict[str, list[Array]] = {name: [] for name in mechanism.bodies}
    for joint, (at, _) in zip(mechanism.joints, parts, strict=True):
        if at is not None:
            corners[joint.a].append(at)
            corners[joint.b].append(at)
    if tool and position is not None:
        corners[tool].append(np.asarray(position, float))
    every = [x for points in corners.values() for x in points]
    middle = np.mean(every, 0) if every else np.zeros(3)
    marks = []
    for name, joint, (at, flats) in zip(mechanism.joint_names, mechanism.joints, parts, strict=True):
        position = at
        if position is None:  # on a line or in a plane: near the other joints of its bodies
            near = [np.mean(corners[body], 0) for body in (joint.a, joint.b) if corners[body]]
            position = _nearest(np.mean(near, 0) if near else middle, flats)
            corners[joint.a].append(position)
            corners[joint.b].append(position)
        marks.append(Mark(name, kind_of(joint), position, _axes(joint)))
    return Sketch(tuple(marks), {n: np.array(p).reshape(-1, 3) for n, p in corners.items()}, mechanism.fixed)


def kind_of(joint: Joint) -> str:
    """The kind of a joint, in lower case."""
    return type(joint.joint if isinstance(joint, DisplacedJoint) else joint).__name__.lower()


def _location(joint: Joint) -> tuple[Array | None, list[tuple[Array, Array]]]:
    """Position of a joint, if its objects have one; else the lines and planes (point, projector) that they lie in."""
    flats = []
    for c in joint.conditions():
        for x in (c.x, c.y):
            position, flat = _where(x)
            if position is not None:
                return position, []
            flats += [] if flat is None else [flat]
    return None, flats


def _where(x: Multivector) -> tuple[Array | None, tuple[Array, Array] | None]:
    """Position of an object, or the line or plane (point, projector) that it is."""
    try:
        p: Any = x.parameters()
    except BladesmithError:  # a screw, by its axis
        if not set(x.kind.blades) <= set(x.algebra.kind("twist").blades):
            return None, None
        angular, linear = np.split(np.asarray(screw_coordinates(x), float), 2)
        square = float(angular @ angular)
        return None, (np.cross(angular, linear) / square, np.outer(angular, angular) / square) if square > 0 else None
    for name in ("xyz", "center"):
        if hasattr(p, name):
            return np.asarray(getattr(p, name), float), None
    if hasattr(p, "b"):
        return np.asarray((p.a + p.b) / 2, float), None
    if hasattr(p, "offset"):
        return None, (p.offset * np.asarray(p.normal), np.eye(3) - np.outer(p.normal, p.normal))
    return None, (np.asarray(p.point), np.outer(p.direction, p.direction)) if hasattr(p, "point") else None


def _nearest(position: Array, flats: Sequence[tuple[Array, Array]]) -> Array:
    """The point of the first line or plane that is nearest to a position."""
    if not flats:
        return position
    point, along = flats[0]
    return np.asarray(point + along @ (position - point))


def _axes(joint: Joint) -> Array:
    """Unit vectors (n, 3) along the axes of a joint; the direction of its coordinate first."""
    conditions = joint.conditions()
    axis = joint.axes([c.x for c in conditions])
    if axis is not None:
        directions = [axis]
    elif kind_of(joint) == "universal":
        directions = [x for c in conditions[1:] for x in (direction_of(c.x), direction_of(c.y)) if x is not None]
    else:
        directions = []
    rows = np.array(directions, float).reshape(-1, 3)
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    nonzero = sizes[:, 0] > PARALLEL
    return np.asarray(rows[nonzero] / sizes[nonzero])


__all__ = ["Mark", "Sketch", "kind_of", "mechanism_sketch"]
