"""What the interactive page shows, as plain arrays: triangles of surfaces, outlines of controls, camera and lights.

Nothing here knows of plotly or of HTML.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..plot.shapes import circles
from .camera import Camera
from .controls import read_controls
from .image import encode
from .meshing import TriangleMesh, mesh_of
from .meshing.plain import across
from .options import HEIGHT, WIDTH
from .scene import Scene
from .surfaces import Plane, Sphere, Surface
from .surfaces.evolved import EvolvedSurface

Array = NDArray[Any]
#: Vertices along each side of a surface's mesh: fewer are no shape any more, more are not seen.
COARSEST, FINEST = 6, 96
#: Quads across evolved point pairs, whose segments are straight, and places around discs.
ACROSS, AROUND = 8, 96
#: Vertices at one position are one where their normals agree to this many decimals: a seam must not be seen, an edge
#: must.
ALIKE = 2
#: Half the side of what is shown of a plane, in radii of the other surfaces.
PATCH = 1.5
#: Squares along a side of what is shown of a checkered plane, at most.
MOST_SQUARES = 64
#: A camera farther away than this many radii is not drawn; a light is drawn no farther away than this.
FAR_AWAY, LIGHT_AWAY = 8.0, 3.0
#: The drawn camera's depth, in radii of the scene.
FRUSTUM = 0.18
#: Points of a drawn control circle.
OUTLINE = 64


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one surface or of several.

    Attributes
    ----------
    label, kind : str
        As people read them; the label may be anything.
    vertices, faces : (n, 3) arrays
    color : (3,) array
        sRGB bytes.
    owner : (n,) array of int
        Of each vertex, the place of its surface in the scene's list.
    alpha : (n,) array
        Parameter of the surface's curve; NaN where there is none.
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
    """A box around what is shown; its radius is half its diagonal."""

    low: Array
    high: Array

    @property
    def center(self) -> Array:
        """Its middle."""
        return self.low + (self.high - self.low) / 2

    @property
    def radius(self) -> float:
        """Half its diagonal; 1 for a single point."""
        return float(np.linalg.norm(self.high - self.low) / 2) or 1.0

    def around(self, points: Array) -> Box:
        """The box around this one and more points."""
        rows = np.concatenate([[self.low, self.high], np.reshape(points, (-1, 3))])
        return Box(rows.min(0), rows.max(0))


@dataclass(frozen=True, eq=False)
class Eye:
    """The scene's camera: where it stands and its axes, half the angles that it sees, as tangents."""

    position: Array
    forward: Array
    right: Array
    up: Array
    wide: float
    high: float


@dataclass(frozen=True, eq=False)
class Shown:
    """All of the page."""

    parts: list[Part]
    controls: list[Array]
    eye: Eye
    main: Box  # without the lights
    box: Box
    frustum: Array | None
    lights: list[tuple[Array, Array, Array]] = field(default_factory=list)  # drawn at, position, sRGB bytes
    missing: list[str] = field(default_factory=list)


def shown(scene: Scene, names: Sequence[str | None] | None, budget: int) -> Shown:
    """Everything that the page of a scene shows, with about as many vertices as the budget allows."""
    share = budget // max(1, len(scene.surfaces))
    parts: dict[int, Part] = {}
    missing = []
    for i, surface in enumerate(scene.surfaces):
        if not isinstance(surface, Plane):
            try:
                parts[i] = _meshed(surface, i, names, share)
            except SceneError as error:
                missing.append(f"surfaces[{i}] is not shown: {error}")
    eye = eye_of(scene)
    box = room = _around(list(parts.values()), eye, scene)
    for i, surface in enumerate(scene.surfaces):
        if isinstance(surface, Plane):
            parts[i] = _patch(surface, i, names, box, share)
            room = room.around(parts[i].vertices)
    controls = [line for i in parts for line in control_outlines(scene.surfaces[i])]
    frustum = _frustum(eye, box) if np.linalg.norm(eye.position - box.center) < FAR_AWAY * box.radius else None
    for points in (*controls, *([] if frustum is None else [frustum])):
        room = room.around(points)
    lights = _lights(scene, box)
    everything = room.around(np.array([drawn for drawn, _, _ in lights]))
    return Shown([parts[i] for i in sorted(parts)], controls, eye, room, everything, frustum, lights, missing)


def _lights(scene: Scene, box: Box) -> list[tuple[Array, Array, Array]]:
    """Where lights are drawn, where they are, and their colors; those far away are drawn in their direction."""
    found = []
    for light in scene.lights:
        away = light.position - box.center
        far = max(1.0, float(np.linalg.norm(away)) / (LIGHT_AWAY * box.radius))
        drawn = light.position if far == 1 else box.center + away / far
        found.append((drawn, light.position, encode(light.color / max(1.0, light.color.max()))))
    return found


def _meshed(surface: Surface, place: int, names: Sequence[str | None] | None, share: int) -> Part:
    side = int(np.clip(np.sqrt(share), COARSEST, FINEST))
    if isinstance(surface, Sphere):  # all have the same mesh
        vertices, faces = _unit_sphere(max(2, side * 2 // 3), side * 3 // 2)
        vertices, alpha = surface.center + surface.radius * vertices, np.full(len(vertices), np.nan)
        return _part(surface, place, names, vertices, faces, alpha)
    rings, segments = {
        "evolved_point_pairs": (max(2, min(share // ACROSS, FINEST * ACROSS)), min(ACROSS, side)),
        "disc": (1, int(np.clip(share, COARSEST, AROUND))),
    }.get(surface.kind, (side, side))
    vertices, faces, alpha = _welded(mesh_of(surface, rings, segments))
    if not isinstance(surface, EvolvedSurface):
        alpha = np.full(len(vertices), np.nan)
    return _part(surface, place, names, vertices, faces, alpha)


@cache
def _unit_sphere(rings: int, segments: int) -> tuple[Array, Array]:
    vertices, faces, _ = _welded(mesh_of(Sphere((0.0, 0.0, 0.0), 1.0), rings, segments))
    return vertices, faces


def _welded(mesh: TriangleMesh) -> tuple[Array, Array, Array]:
    """Vertices, faces and the second texture coordinate, without the seam where a texture begins and ends."""
    if mesh.uv is None:
        return mesh.vertices, mesh.faces, np.full(len(mesh.vertices), np.nan)
    keys = np.concatenate([mesh.vertices, np.round(mesh.vertex_normals, ALIKE)], 1) + 0.0  # -0 and 0 are one
    _, first, place = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return mesh.vertices[first], place.ravel()[mesh.faces], mesh.uv[first, 1]


def _part(surface: Surface, place: int, names: Any, vertices: Array, faces: Array, alpha: Array) -> Part:
    kind = surface.kind.replace("_", " ")
    given = None if names is None else names[place]
    label = str(given) if given else surface.called(place)
    color = encode(surface.material.color)
    owner = np.full(len(vertices), place, np.int32)
    return Part(label, kind, vertices, faces, color, owner, alpha, material=surface.material)


def _around(parts: list[Part], eye: Eye, scene: Scene) -> Box:
    """The box of the bounded surfaces; without any, one in front of the camera."""
    vertices = [p.vertices[np.isfinite(p.vertices).all(-1)] for p in parts]
    vertices = [v for v in vertices if len(v)]
    if vertices:
        return Box(np.min([v.min(0) for v in vertices], 0), np.max([v.max(0) for v in vertices], 0))
    planes = [s for s in scene.surfaces if isinstance(s, Plane)]
    away = [abs(float(s.normal @ eye.position - s.offset)) for s in planes]
    reach = max([*away, 0.0]) or 1.0
    middle = eye.position + 2 * reach * eye.forward
    return Box(middle - reach, middle + reach)


def _patch(surface: Plane, place: int, names: Sequence[str | None] | None, box: Box, budget: int) -> Part:
    """A square of a plane around what else there is; with the squares of a checkered one."""
    material, half = surface.material, PATCH * box.radius
    middle = box.center - (surface.normal @ box.center - surface.offset) * surface.normal
    u, v = across(surface.normal)
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
        both = np.stack([encode(material.color), encode(material.checker)])
        colors = np.repeat(both[(square % 2 != 0).astype(int).reshape(-1)], 2, axis=0)
    # every square has corners of its own, so that colors end sharply
    at = (np.stack(np.meshgrid(np.arange(count), np.arange(count), indexing="ij"), -1).reshape(-1, 2)) - count / 2
    corners = at[:, None] + np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    vertices = (middle + step * (corners[..., :1] * u + corners[..., 1:] * v)).reshape(-1, 3)
    faces = (4 * np.arange(count * count)[:, None, None] + np.array([(0, 1, 2), (0, 2, 3)])).reshape(-1, 3)
    part = _part(surface, place, names, vertices, faces, np.full(len(vertices), np.nan))
    return replace(part, face_colors=colors)


def control_outlines(surface: Surface) -> list[Array]:
    """Control objects of an evolved surface: closed circles, segments between the points of a pair."""
    if not isinstance(surface, EvolvedSurface):
        return []
    try:
        rows = read_controls(surface.curve.given, surface.swept).rows
    except SceneError:  # sums that are no objects, of raw curves
        return []
    rows = rows[np.isfinite(rows).all(1)]
    if surface.swept == "point_pair":
        return list(rows.reshape(-1, 2, 3))
    normal = rows[:, 3:6] / np.linalg.norm(rows[:, 3:6], axis=1, keepdims=True)
    return list(circles(rows[:, :3], normal, rows[:, 6], OUTLINE))


def eye_of(scene: Scene) -> Eye:
    """The scene's camera, read from its own rays."""
    camera: Camera = scene.camera
    width, height = scene.settings.get("width", WIDTH), scene.settings.get("height", HEIGHT)
    focal, x_max, y_max = camera.constants(width, height)[8:]
    forward = camera.rays(1, 1)[1][0, 0]
    four = camera.rays(2, 2)[1]
    right, up = four[0, 1] - four[0, 0], four[0, 0] - four[1, 0]
    right, up = right / np.linalg.norm(right), up / np.linalg.norm(up)
    return Eye(camera.position, forward, right, up, x_max / (2 * focal), y_max / (2 * focal))


def _frustum(eye: Eye, box: Box) -> Array:
    """One polyline over the edges of the camera's pyramid, with a mark above its upper edge."""
    depth = FRUSTUM * box.radius
    x, y = eye.wide * eye.right, eye.high * eye.up
    a, b, c, d = (eye.position + depth * (eye.forward + corner) for corner in (-x - y, x - y, x + y, -x + y))
    top = eye.position + depth * (eye.forward + 1.4 * y)
    o = eye.position
    return np.stack([o, a, b, o, c, b, c, d, top, c, d, a, d, o])


def merged(parts: Sequence[Part]) -> list[Part]:
    """Parts by kind, one for each: a page of thousands would stand still."""
    kinds: dict[str, list[Part]] = {}
    for part in parts:
        kinds.setdefault(part.kind, []).append(part)
    return [_joined(kind, members) for kind, members in kinds.items()]


def _joined(kind: str, members: list[Part]) -> Part:
    first = np.cumsum([0, *(len(p.vertices) for p in members)])
    colors = [np.broadcast_to(p.color, p.vertices.shape) for p in members]
    return Part(
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
