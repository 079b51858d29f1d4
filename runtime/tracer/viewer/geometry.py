"""Geometry of the interactive page as plain arrays: triangles of surfaces, outlines of controls, camera and lights.

This module does not depend on plotly or HTML.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from ...plot.tessellation import circles
from ..meshing import TriangleMesh, mesh_of
from ..output.image import encode
from ..scene.camera import Camera
from ..scene.defaults import HEIGHT, WIDTH
from ..scene.scene import Scene
from ..surfaces import Plane, Sphere, Surface
from ..surfaces.evolved import EvolvedSurface
from ..surfaces.material import perpendicular_basis
from ..sweeps.control_parameters import read_controls

Array = NDArray[Any]
#: Smallest number of vertices along each side of a surface's mesh: fewer lose its shape.
COARSEST = 6
#: Largest number of vertices along each side: more are not visible.
FINEST = 96
#: Quads across evolved point pairs, whose segments are straight.
ACROSS = 8
#: Vertices around discs.
AROUND = 96
#: Decimals to which normals of merged vertices at one position agree: a seam must be invisible, an edge visible.
NORMAL_DECIMALS = 2
#: Half the side of the square of a plane, in radii of the other surfaces.
PLANE_RADII = 1.5
#: Largest number of checkers along a side of the square of a plane.
MOST_SQUARES = 64
#: Largest distance of a camera that is drawn, in radii of the scene.
FAR_AWAY = 8.0
#: Largest distance at which a light is drawn, in radii of the scene.
LIGHT_AWAY = 3.0
#: Depth of the drawn camera, in radii of the scene.
FRUSTUM = 0.18
#: Number of points of a drawn control circle.
OUTLINE = 64


@dataclass(frozen=True, eq=False)
class MeshGroup:
    """Triangles of one surface, or of several merged ones.

    Attributes
    ----------
    label, kind : str
        Texts for the reader; the label may be any text.
    vertices, faces : (n, 3) arrays
    color : (3,) array
        sRGB bytes.
    owner : (n,) array of int
        Index of each vertex's surface in the scene's list.
    alpha : (n,) array
        Parameter of the surface's curve; NaN for surfaces without one.
    face_colors : (m, 3) array or None
    vertex_colors : (n, 3) array or None
    """

    label: str
    kind: str
    vertices: Array
    faces: Array
    color: Array
    owner: Array
    alpha: Array
    face_colors: Array | None = None
    vertex_colors: Array | None = None
    material: Any = None


class Box(NamedTuple):
    """An axis-aligned box; its radius is half its diagonal."""

    low: Array
    high: Array

    @property
    def center(self) -> Array:
        """Center of the box."""
        return self.low + (self.high - self.low) / 2

    @property
    def radius(self) -> float:
        """Half the diagonal; 1 for a single point."""
        return float(np.linalg.norm(self.high - self.low) / 2) or 1.0

    def around(self, points: Array) -> Box:
        """Extend the box to more points."""
        rows = np.concatenate([[self.low, self.high], np.reshape(points, (-1, 3))])
        return Box(rows.min(0), rows.max(0))


@dataclass(frozen=True, eq=False)
class ViewerCamera:
    """Position and axes of the scene's camera, and the tangents of half its fields of view."""

    position: Array
    forward: Array
    right: Array
    up: Array
    wide: float
    high: float


@dataclass(frozen=True, eq=False)
class ViewerScene:
    """Everything that the page shows."""

    groups: list[MeshGroup]
    controls: list[Array]
    camera: ViewerCamera
    main: Box  # without the lights
    box: Box
    frustum: Array | None
    lights: list[tuple[Array, Array, Array]] = field(default_factory=list)  # drawn at, position, sRGB bytes
    missing: list[str] = field(default_factory=list)


def build_viewer_scene(scene: Scene, names: Sequence[str | None] | None, budget: int) -> ViewerScene:
    """Collect everything that the page of a scene shows, with about as many vertices as the budget allows."""
    vertices_each = budget // max(1, len(scene.surfaces))
    groups: dict[int, MeshGroup] = {}
    missing = []
    for i, surface in enumerate(scene.surfaces):
        if not isinstance(surface, Plane):
            try:
                groups[i] = _mesh_group(surface, i, names, vertices_each)
            except SceneError as error:
                missing.append(f"surfaces[{i}] is not shown: {error}")
    camera = viewer_camera(scene)
    box = visible = _around(list(groups.values()), camera, scene)
    for i, surface in enumerate(scene.surfaces):
        if isinstance(surface, Plane):
            groups[i] = _plane_square(surface, i, names, box, vertices_each)
            visible = visible.around(groups[i].vertices)
    controls = [line for i in groups for line in control_outlines(scene.surfaces[i])]
    frustum = _frustum(camera, box) if np.linalg.norm(camera.position - box.center) < FAR_AWAY * box.radius else None
    for points in (*controls, *([] if frustum is None else [frustum])):
        visible = visible.around(points)
    lights = _lights(scene, box)
    everything = visible.around(np.array([drawn for drawn, _, _ in lights]))
    return ViewerScene(
        [groups[i] for i in sorted(groups)], controls, camera, visible, everything, frustum, lights, missing
    )


def _lights(scene: Scene, box: Box) -> list[tuple[Array, Array, Array]]:
    """Drawn positions, positions and colors of lights; distant ones are drawn nearer, in their direction."""
    lights = []
    for light in scene.lights:
        away = light.position - box.center
        far = max(1.0, float(np.linalg.norm(away)) / (LIGHT_AWAY * box.radius))
        drawn = light.position if far == 1 else box.center + away / far
        lights.append((drawn, light.position, encode(light.color / max(1.0, light.color.max()))))
    return lights


def _mesh_group(surface: Surface, index: int, names: Sequence[str | None] | None, vertices_each: int) -> MeshGroup:
    side = int(np.clip(np.sqrt(vertices_each), COARSEST, FINEST))
    if isinstance(surface, Sphere):  # all have the same mesh
        vertices, faces = _unit_sphere(max(2, side * 2 // 3), side * 3 // 2)
        vertices, alpha = surface.center + surface.radius * vertices, np.full(len(vertices), np.nan)
        return _group(surface, index, names, vertices, faces, alpha)
    rings, segments = {
        "evolved_point_pairs": (max(2, min(vertices_each // ACROSS, FINEST * ACROSS)), min(ACROSS, side)),
        "disc": (1, int(np.clip(vertices_each, COARSEST, AROUND))),
    }.get(surface.kind, (side, side))
    vertices, faces, alpha = _weld(mesh_of(surface, rings, segments))
    if not isinstance(surface, EvolvedSurface):
        alpha = np.full(len(vertices), np.nan)
    return _group(surface, index, names, vertices, faces, alpha)


@cache
def _unit_sphere(rings: int, segments: int) -> tuple[Array, Array]:
    vertices, faces, _ = _weld(mesh_of(Sphere((0.0, 0.0, 0.0), 1.0), rings, segments))
    return vertices, faces


def _weld(mesh: TriangleMesh) -> tuple[Array, Array, Array]:
    """Vertices, faces and the second texture coordinate, without the seam of the texture."""
    if mesh.uv is None:
        return mesh.vertices, mesh.faces, np.full(len(mesh.vertices), np.nan)
    keys = np.concatenate([mesh.vertices, np.round(mesh.vertex_normals, NORMAL_DECIMALS)], 1) + 0.0  # -0 and 0 are one
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return mesh.vertices[first], index.ravel()[mesh.faces], mesh.uv[first, 1]


def _group(surface: Surface, index: int, names: Any, vertices: Array, faces: Array, alpha: Array) -> MeshGroup:
    kind = surface.kind.replace("_", " ")
    name = None if names is None else names[index]
    label = str(name) if name else surface.display_name(index)
    color = encode(np.asarray(surface.material.color))
    owner = np.full(len(vertices), index, np.int32)
    return MeshGroup(label, kind, vertices, faces, color, owner, alpha, material=surface.material)


def _around(groups: list[MeshGroup], camera: ViewerCamera, scene: Scene) -> Box:
    """Box around the bounded surfaces; without any, one in front of the camera."""
    vertices = [p.vertices[np.isfinite(p.vertices).all(-1)] for p in groups]
    vertices = [v for v in vertices if len(v)]
    if vertices:
        return Box(np.min([v.min(0) for v in vertices], 0), np.max([v.max(0) for v in vertices], 0))
    planes = [s for s in scene.surfaces if isinstance(s, Plane)]
    away = [abs(float(s.normal @ camera.position - s.offset)) for s in planes]
    half = max([*away, 0.0]) or 1.0
    middle = camera.position + 2 * half * camera.forward
    return Box(middle - half, middle + half)


def _plane_square(surface: Plane, index: int, names: Sequence[str | None] | None, box: Box, budget: int) -> MeshGroup:
    """Square of a plane around all other surfaces; a checkered one with its pattern."""
    material, half = surface.material, PLANE_RADII * box.radius
    middle = box.center - (surface.normal @ box.center - surface.offset) * surface.normal
    u, v = perpendicular_basis(surface.normal)
    step, count = 2 * half, 1
    colors = None
    if material.checker is not None:
        rows = material.row(surface.normal)[11:17].reshape(2, 3)
        step = 1 / float(np.linalg.norm(rows[0]))
        count = int(np.clip(np.ceil(2 * half / step), 1, min(MOST_SQUARES, max(1, int(np.sqrt(budget / 4))))))
        u, v = rows * step
        corner = np.floor(rows @ middle - count / 2)
        middle = middle + ((corner + count / 2) - rows @ middle) @ np.stack([u, v]) * step
        square = corner.sum() + np.add.outer(np.arange(count), np.arange(count))
        both = np.stack([encode(np.asarray(color)) for color in (material.color, material.checker)])
        colors = np.repeat(both[(square % 2 != 0).astype(int).reshape(-1)], 2, axis=0)
    # every checker has corners of its own, so that its edges are sharp
    at = (np.stack(np.meshgrid(np.arange(count), np.arange(count), indexing="ij"), -1).reshape(-1, 2)) - count / 2
    corners = at[:, None] + np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    vertices = (middle + step * (corners[..., :1] * u + corners[..., 1:] * v)).reshape(-1, 3)
    faces = (4 * np.arange(count * count)[:, None, None] + np.array([(0, 1, 2), (0, 2, 3)])).reshape(-1, 3)
    group = _group(surface, index, names, vertices, faces, np.full(len(vertices), np.nan))
    return replace(group, face_colors=colors)


def control_outlines(surface: Surface) -> list[Array]:
    """Polylines of the controls of an evolved surface: closed circles, segments between the points of pairs."""
    if not isinstance(surface, EvolvedSurface):
        return []
    try:
        rows = read_controls(surface.curve.original_controls, surface.swept).rows
    except SceneError:  # sums that are not objects, in raw curves
        return []
    rows = rows[np.isfinite(rows).all(1)]
    if surface.swept == "point_pair":
        return list(rows.reshape(-1, 2, 3))
    normal = rows[:, 3:6] / np.linalg.norm(rows[:, 3:6], axis=1, keepdims=True)
    return list(circles(rows[:, :3], normal, rows[:, 6], OUTLINE))


def viewer_camera(scene: Scene) -> ViewerCamera:
    """Position and axes of the scene's camera, from its own rays."""
    camera: Camera = scene.camera
    width, height = scene.settings.get("width", WIDTH), scene.settings.get("height", HEIGHT)
    focal, x_max, y_max = camera.constants(width, height)[8:]
    forward = camera.rays(1, 1)[1][0, 0]
    four = camera.rays(2, 2)[1]
    right, up = four[0, 1] - four[0, 0], four[0, 0] - four[1, 0]
    right, up = right / np.linalg.norm(right), up / np.linalg.norm(up)
    return ViewerCamera(camera.position, forward, right, up, x_max / (2 * focal), y_max / (2 * focal))


def _frustum(camera: ViewerCamera, box: Box) -> Array:
    """Polyline along the edges of the camera's frustum, with a mark above its upper edge."""
    depth = FRUSTUM * box.radius
    x, y = camera.wide * camera.right, camera.high * camera.up
    a, b, c, d = (camera.position + depth * (camera.forward + corner) for corner in (-x - y, x - y, x + y, -x + y))
    top = camera.position + depth * (camera.forward + 1.4 * y)
    o = camera.position
    return np.stack([o, a, b, o, c, b, c, d, top, c, d, a, d, o])


def merge_by_kind(groups: Sequence[MeshGroup]) -> list[MeshGroup]:
    """Merge groups by kind: a page of thousands would not respond."""
    kinds: dict[str, list[MeshGroup]] = {}
    for group in groups:
        kinds.setdefault(group.kind, []).append(group)
    return [_merge_groups(kind, members) for kind, members in kinds.items()]


def _merge_groups(kind: str, members: list[MeshGroup]) -> MeshGroup:
    first = np.cumsum([0, *(len(p.vertices) for p in members)])
    colors = [np.broadcast_to(p.color, p.vertices.shape) for p in members]
    return MeshGroup(
        f"{kind} ({len(members)})",
        kind,
        np.concatenate([p.vertices for p in members]),
        np.concatenate([p.faces + start for p, start in zip(members, first, strict=False)]),
        members[0].color,
        np.concatenate([p.owner for p in members]),
        np.concatenate([p.alpha for p in members]),
        vertex_colors=np.concatenate(colors),
        material=members[0].material,
    )
