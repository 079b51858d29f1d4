"""What each sort of object looks like: the positions that a view must hold, and lines, surfaces and marks in a box.

A `Drawable` is a group of objects with its colours. It knows no matplotlib: it hands `Strokes`, `Faces` and `Marks`
to `drawing`, which makes one collection of each.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import palette, shapes
from .palette import Rgba
from .shapes import Array, Box
from .things import Group

#: Corners of circles: fewer for those in large sets, which are small or many on top of each other.
CIRCLE_SAMPLES, MANY_CIRCLES, CIRCLE_SAMPLES_OF_MANY = 128, 500, 64
#: Rings and sectors of a sphere's surface, up to so many spheres; more are drawn as three great circles each.
SPHERE_MESHES = ((6, 24, 48), (60, 12, 24))
#: Opacity of spheres' and planes' surfaces.
SURFACE_OPACITY, PLANE_OPACITY = 0.16, 0.22
#: Length of a frame's axes and of the arrows that show orientations, over the size of the view.
FRAME, ARROW, HEAD = 0.12, 0.12, 0.03
#: Where light comes from, and how bright a surface is that faces away from it.
LIGHT, SHADE = shapes.unit(np.array([-0.4, -0.6, 0.8])), 0.55


class Strokes(NamedTuple):
    """Polylines (n, m, 3) with colours (1 or n, 4); ``width`` is relative."""

    positions: Array
    colors: Rgba
    width: float = 1.0


class Faces(NamedTuple):
    """Polygons (n, m, 3) with colours (1 or n, 4)."""

    positions: Array
    colors: Rgba


class Marks(NamedTuple):
    """Points (n, 3) with colours (1 or n, 4), a marker of matplotlib, and a relative size."""

    positions: Array
    colors: Rgba
    marker: str = "o"
    size: float = 1.0


@dataclass(frozen=True)
class Drawable:
    """A group of objects with colours, to be drawn in a box.

    Attributes
    ----------
    group : Group
    colors : (1 or n, 4)
    orientation : bool
        Add arrows that show which way lines, circles, planes and spheres are turned.
    surface : bool
        Spheres and planes as surfaces, not only as wires.
    """

    group: Group
    colors: Rgba
    orientation: bool = False
    surface: bool = True

    def reach(self) -> Array:
        """Positions (m, 3) that bound what is finite; none for lines and planes."""
        found: Array = _REACH[self.group.sort](*self.group.parameters)
        return found

    def flats(self) -> tuple[Array, Array] | None:
        """Of lines and planes: points on them, and the projections (n, 3, 3) onto what is perpendicular to them."""
        if self.group.sort == "line":
            point, direction = self.group.parameters
            return point, np.eye(3) - direction[:, :, None] * direction[:, None]
        if self.group.sort == "plane":
            normal, offset = self.group.parameters
            return normal * offset[:, None], normal[:, :, None] * normal[:, None]
        return None

    def feet(self, center: Array) -> Array:
        """Of lines and planes: the points nearest to ``center``; of directions: arrows from there."""
        flats = self.flats()
        if flats is not None:
            point, spread = flats
            return np.asarray(center + np.einsum("nij,nj->ni", spread, point - center))
        if self.group.sort == "direction":
            return np.concatenate([center + self.group.parameters[0], center[None]])
        return np.empty((0, 3))

    def outline(self, box: Box) -> list[Strokes | Faces | Marks]:
        """What is to be drawn, for a view of this box."""
        return _OUTLINE[self.group.sort](self, box, *self.group.parameters)


# -- what a view must hold -------------------------------------------------------------------------------------


def _around(center: Array, half: Array) -> Array:
    return np.concatenate([center - half, center + half])


def _nothing(*_: Array) -> Array:
    return np.empty((0, 3))


_REACH: dict[str, Callable[..., Array]] = {
    "point": lambda xyz: xyz,
    "flat_point": lambda xyz: xyz,
    "direction": _nothing,
    "point_pair": lambda a, b: np.concatenate([a, b]),
    "line": _nothing,
    "plane": _nothing,
    "circle": lambda c, n, r: _around(c, shapes.circle_reach(n, r)),
    "sphere": lambda c, r, _: _around(c, r[:, None]),
    "frame": lambda origin, _: origin,
    "path": lambda xyz: xyz[np.isfinite(xyz).all(-1)],
}

# -- outlines --------------------------------------------------------------------------------------------------


def _inside(box: Box, xyz: Array) -> Array:
    """Positions, NaN where they are not in the view."""
    return np.where(box.contains(xyz)[..., None], xyz, np.nan)


def _point(d: Drawable, box: Box, xyz: Array) -> list[Any]:
    return [Marks(_inside(box, xyz), d.colors)]


def _flat_point(d: Drawable, box: Box, xyz: Array) -> list[Any]:
    return [Marks(_inside(box, xyz), d.colors, "D", 0.8)]


def _direction(d: Drawable, box: Box, v: Array) -> list[Any]:
    return [Strokes(shapes.arrows(np.broadcast_to(box.center, v.shape), v, HEAD * box.size), d.colors)]


def _point_pair(d: Drawable, box: Box, a: Array, b: Array) -> list[Any]:
    parts: list[Any] = [Strokes(np.stack([a, b], 1), d.colors), Marks(np.stack([a, b], 1).reshape(-1, 3),
                        _repeated(d.colors, 2), "o", 0.6)]  # fmt: skip
    if d.orientation:
        parts.append(Strokes(shapes.arrows(a, 0.55 * (b - a), HEAD * box.size), d.colors))
    return parts


def _line(d: Drawable, box: Box, point: Array, direction: Array) -> list[Any]:
    segments = shapes.lines_in(box, point, direction)
    parts = [Strokes(segments, d.colors)]
    if d.orientation:
        middle = segments.mean(1)
        parts.append(Strokes(shapes.arrows(middle, HEAD * box.size * direction, HEAD * box.size), d.colors))
    return parts


def _circle(d: Drawable, box: Box, center: Array, normal: Array, radius: Array) -> list[Any]:
    count = CIRCLE_SAMPLES if len(radius) <= MANY_CIRCLES else CIRCLE_SAMPLES_OF_MANY
    rings = shapes.circles(center, normal, radius, count, box)
    parts = [Strokes(_inside(box, rings), d.colors)]
    if d.orientation:  # a head on the circle, in the way that it turns, and one for its normal
        middle = count // 2
        step = shapes.unit(rings[:, middle + 1] - rings[:, middle - 1])
        head = HEAD * box.size
        parts.append(Strokes(shapes.arrows(rings[:, middle] - head * step, head * step, head), d.colors))
        parts.append(Strokes(shapes.arrows(center, ARROW * box.size * normal, head), d.colors, 0.6))
    return parts


def _plane(d: Drawable, box: Box, normal: Array, offset: Array) -> list[Any]:
    polygons = shapes.planes_in(box, normal, offset)
    closed = np.concatenate([polygons, polygons[:, :1]], 1)
    parts: list[Any] = [Strokes(closed, d.colors, 0.6)]
    if d.surface:
        parts.append(Faces(polygons, palette.faded(d.colors, PLANE_OPACITY)))
    if d.orientation:
        parts.append(Strokes(shapes.arrows(d.feet(box.center), ARROW * box.size * normal, HEAD * box.size), d.colors))
    return parts


def _sphere(d: Drawable, box: Box, center: Array, radius: Array, orientation: Array) -> list[Any]:
    mesh = next(((r, s) for most, r, s in SPHERE_MESHES if len(radius) <= most), None)
    great = [
        shapes.circles(center, np.broadcast_to(axis, center.shape), radius, CIRCLE_SAMPLES_OF_MANY)
        for axis in np.eye(3)[:: -1 if mesh is None or not d.surface else -3]
    ]
    parts: list[Any] = [Strokes(_inside(box, np.concatenate(great)), _tiled(d.colors, len(great)), 0.6)]
    if d.surface and mesh is not None:
        faces, normals = shapes.sphere_mesh(center, radius, *mesh)
        light = SHADE + (1 - SHADE) * np.clip(normals @ LIGHT, 0, 1)
        shaded = np.array(np.broadcast_to(_repeated(d.colors, mesh[0] * mesh[1]), (len(faces), 4)))
        shaded[:, :3] *= light[:, None]
        seen = box.contains(faces).all(-1)
        parts.append(Faces(faces[seen], palette.faded(shaded[seen], SURFACE_OPACITY)))
    if d.orientation:  # out of, or into, the north pole
        pole = center + radius[:, None] * np.array([0.0, 0.0, 1.0])
        step = ARROW * box.size * orientation[:, None] * np.array([0.0, 0.0, 1.0])
        parts.append(Strokes(shapes.arrows(pole - np.minimum(step, 0), step, HEAD * box.size), d.colors))
    return parts


def _frame(_: Drawable, box: Box, origin: Array, axes: Array) -> list[Any]:
    ends = origin[:, None] + FRAME * box.size * axes
    segments = np.stack([np.broadcast_to(origin[:, None], ends.shape), ends], 2).reshape(-1, 2, 3)
    return [Strokes(segments, np.tile([palette.per_item(c, 1, "")[0] for c in palette.AXES], (len(origin), 1)))]


def _path(d: Drawable, box: Box, xyz: Array) -> list[Any]:
    return [Strokes(_inside(box, xyz), d.colors)]


_OUTLINE: dict[str, Callable[..., list[Any]]] = {
    "point": _point, "flat_point": _flat_point, "direction": _direction, "point_pair": _point_pair, "line": _line,
    "circle": _circle, "plane": _plane, "sphere": _sphere, "frame": _frame, "path": _path,
}  # fmt: skip


def _repeated(rows: NDArray[Any], times: int) -> NDArray[Any]:
    """Each item's colour for so many parts that stand together."""
    return rows if len(rows) == 1 else np.repeat(rows, times, 0)


def _tiled(rows: NDArray[Any], times: int) -> NDArray[Any]:
    """The colours again for each set of parts."""
    return rows if len(rows) == 1 else np.tile(rows, (times, 1))
