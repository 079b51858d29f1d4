"""Shape of each kind of object: the positions that a view must contain, and lines, surfaces and marks in a box.

A `Drawable` is a group of objects with its colors. It does not depend on matplotlib: it gives `Strokes`, `Faces` and
`Marks` to `drawing`, which makes one collection of each.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import palette, tessellation
from .input_groups import Group
from .palette import Rgba
from .tessellation import Array, Box

#: Number of corners of a circle.
CIRCLE_SAMPLES = 128
#: Largest number of circles with that many corners.
MANY_CIRCLES = 500
#: Number of corners of each circle in larger sets, where circles are small or overlap.
CIRCLE_SAMPLES_OF_MANY = 64
#: Largest number of spheres, and rings and sectors of their surfaces; more spheres are drawn as three great circles.
SPHERE_MESHES = ((6, 24, 48), (60, 12, 24))
#: Opacity of the surface of a sphere.
SURFACE_OPACITY = 0.16
#: Opacity of the surface of a plane.
PLANE_OPACITY = 0.22
#: Length of a frame's axes, relative to the size of the view.
FRAME = 0.12
#: Length of the arrows that show orientations, relative to the size of the view.
ARROW = 0.12
#: Length of the heads of arrows, relative to the size of the view.
HEAD = 0.03
#: Direction towards the light.
LIGHT = tessellation.unit(np.array([-0.4, -0.6, 0.8]))
#: Brightness of a surface that faces away from the light.
SHADE = 0.55


class Strokes(NamedTuple):
    """Polylines (n, m, 3) with colors (1 or n, 4); ``width`` is relative."""

    positions: Array
    colors: Rgba
    width: float = 1.0


class Faces(NamedTuple):
    """Polygons (n, m, 3) with colors (1 or n, 4)."""

    positions: Array
    colors: Rgba


class Marks(NamedTuple):
    """Points (n, 3) with colors (1 or n, 4), a marker of matplotlib, and a relative size."""

    positions: Array
    colors: Rgba
    marker: str = "o"
    size: float = 1.0


@dataclass(frozen=True)
class Drawable:
    """A group of objects with colors, to be drawn in a box.

    Attributes
    ----------
    group : Group
    colors : (1 or n, 4)
    orientation : bool
        Add arrows for the orientation of lines, circles, planes and spheres.
    surface : bool
        Spheres and planes as surfaces, not only as wires.
    coarse : bool
        Spheres of fewer faces, which are drawn sooner.
    count : int
        Number of objects among which they are drawn, the more the coarser. Default: those of the group.
    """

    group: Group
    colors: Rgba
    orientation: bool = False
    surface: bool = True
    coarse: bool = False
    count: int = 0

    def bounding_points(self) -> Array:
        """Positions (m, 3) that bound finite objects; empty for lines and planes."""
        positions: Array = _REACH[self.group.sort](*self.group.parameters)
        return positions

    def flats(self) -> tuple[Array, Array] | None:
        """Points on lines and planes, and the projections (n, 3, 3) onto their orthogonal complements; else None."""
        if self.group.sort == "line":
            point, direction = self.group.parameters
            return point, np.eye(3) - direction[:, :, None] * direction[:, None]
        if self.group.sort == "plane":
            normal, offset = self.group.parameters
            return normal * offset[:, None], normal[:, :, None] * normal[:, None]
        return None

    def feet(self, center: Array) -> Array:
        """Points of lines and planes nearest to ``center``; ends of directions as arrows from there."""
        flats = self.flats()
        if flats is not None:
            point, spread = flats
            return np.asarray(center + np.einsum("nij,nj->ni", spread, point - center))
        if self.group.sort == "direction":
            return np.concatenate([center + self.group.parameters[0], center[None]])
        return np.empty((0, 3))

    def outline(self, box: Box) -> list[Strokes | Faces | Marks]:
        """Lines, surfaces and marks of the group in a box: as many rows for each object, in their order."""
        return _OUTLINE[self.group.sort](self, box, *self.group.parameters)


# -- positions that a view must contain ------------------------------------------------------------------------


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
    "circle": lambda c, n, r: _around(c, tessellation.circle_extent(n, r)),
    "sphere": lambda c, r, _: _around(c, r[:, None]),
    "frame": lambda origin, _: origin,
    "path": lambda xyz: xyz[np.isfinite(xyz).all(-1)],
}

# -- outlines --------------------------------------------------------------------------------------------------


def _inside(box: Box, xyz: Array) -> Array:
    """Positions, NaN outside the view."""
    return np.where(box.contains(xyz)[..., None], xyz, np.nan)


def _point(d: Drawable, box: Box, xyz: Array) -> list[Any]:
    return [Marks(_inside(box, xyz), d.colors)]


def _flat_point(d: Drawable, box: Box, xyz: Array) -> list[Any]:
    return [Marks(_inside(box, xyz), d.colors, "D", 0.8)]


def _direction(d: Drawable, box: Box, v: Array) -> list[Any]:
    return [Strokes(tessellation.arrows(np.broadcast_to(box.center, v.shape), v, HEAD * box.size), d.colors)]


def _point_pair(d: Drawable, box: Box, a: Array, b: Array) -> list[Any]:
    parts: list[Any] = [Strokes(np.stack([a, b], 1), d.colors), Marks(np.stack([a, b], 1).reshape(-1, 3),
                        _repeat_rows(d.colors, 2), "o", 0.6)]  # fmt: skip
    if d.orientation:
        parts.append(Strokes(tessellation.arrows(a, 0.55 * (b - a), HEAD * box.size), d.colors))
    return parts


def _line(d: Drawable, box: Box, point: Array, direction: Array) -> list[Any]:
    segments = tessellation.lines_in(box, point, direction)
    parts = [Strokes(segments, d.colors)]
    if d.orientation:
        middle = segments.mean(1)
        parts.append(Strokes(tessellation.arrows(middle, HEAD * box.size * direction, HEAD * box.size), d.colors))
    return parts


def _circle(d: Drawable, box: Box, center: Array, normal: Array, radius: Array) -> list[Any]:
    count = CIRCLE_SAMPLES if (d.count or len(radius)) <= MANY_CIRCLES else CIRCLE_SAMPLES_OF_MANY
    rings = tessellation.circles(center, normal, radius, count, box)
    parts = [Strokes(_inside(box, rings), d.colors)]
    if d.orientation:  # an arrow head on the circle, in its sense of rotation, and an arrow for its normal
        middle = count // 2
        step = tessellation.unit(rings[:, middle + 1] - rings[:, middle - 1])
        head = HEAD * box.size
        parts.append(Strokes(tessellation.arrows(rings[:, middle] - head * step, head * step, head), d.colors))
        parts.append(Strokes(tessellation.arrows(center, ARROW * box.size * normal, head), d.colors, 0.6))
    return parts


def _plane(d: Drawable, box: Box, normal: Array, offset: Array) -> list[Any]:
    polygons = tessellation.planes_in(box, normal, offset)
    closed = np.concatenate([polygons, polygons[:, :1]], 1)
    parts: list[Any] = [Strokes(closed, d.colors, 0.6)]
    if d.surface:
        parts.append(Faces(polygons, palette.with_opacity(d.colors, PLANE_OPACITY)))
    if d.orientation:
        parts.append(
            Strokes(tessellation.arrows(d.feet(box.center), ARROW * box.size * normal, HEAD * box.size), d.colors)
        )
    return parts


def _sphere(d: Drawable, box: Box, center: Array, radius: Array, orientation: Array) -> list[Any]:
    mesh = next(((r, s) for most, r, s in SPHERE_MESHES[d.coarse :] if (d.count or len(radius)) <= most), None)
    axes = (2, 1, 0) if mesh is None or not d.surface else (2,)
    great = tessellation.scaled(tessellation.great_circles(axes, CIRCLE_SAMPLES_OF_MANY), center, radius)
    rings = great.reshape(-1, *great.shape[2:])
    parts: list[Any] = [Strokes(_inside(box, rings), _repeat_rows(d.colors, len(axes)), 0.6)]
    if d.surface and mesh is not None:
        quads, normals = tessellation.unit_sphere(*mesh)
        faces = tessellation.scaled(quads, center, radius).reshape(-1, 4, 3)
        light = SHADE + (1 - SHADE) * np.clip(normals @ LIGHT, 0, 1)
        rows = np.repeat(np.broadcast_to(d.colors, (len(radius), 4)), len(quads), 0)
        rows[:, :3] *= np.tile(light, len(radius))[:, None]
        visible = np.asarray(box.contains(faces).all(-1))
        seen = faces if visible.all() else np.where(visible[:, None, None], faces, np.nan)
        parts.append(Faces(seen, palette.with_opacity(rows, SURFACE_OPACITY)))
    if d.orientation:  # out of, or into, the north pole
        pole = center + radius[:, None] * np.array([0.0, 0.0, 1.0])
        step = ARROW * box.size * orientation[:, None] * np.array([0.0, 0.0, 1.0])
        parts.append(Strokes(tessellation.arrows(pole - np.minimum(step, 0), step, HEAD * box.size), d.colors))
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


def _repeat_rows(rows: NDArray[Any], times: int) -> NDArray[Any]:
    """Repeat the color of each item for consecutive parts."""
    return rows if len(rows) == 1 else np.repeat(rows, times, 0)
