"""First hits on evolved surfaces: exact methods beside triangle meshes traced by Embree, error against time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ...errors import SceneError
from ..study import Case, Errors, Method, Study
from . import crossings
from .rays import Array, Control, surface_of, tube
from .ribbons import ribbon

#: Rays of a case are taken this many times in a call: about those of a picture of 640 x 480, so that building a mesh
#: weighs what it does there.
COUNT, COPIES = 150, 2000
#: Less for what takes microseconds a ray anyway.
FEW_COPIES = 40
#: Triangles.
TRIANGLES = (1_000, 10_000, 100_000, 1_000_000)
#: A camera this far away looks at the surface.
AWAY = 6.0
#: Quads of a ribbon's mesh across, for each along: they are straight that way.
NARROW = 1 / 8


@dataclass(frozen=True)
class View:
    """A surface, and rays from a camera.

    Attributes
    ----------
    kind : "circles" or "pairs"
    controls : list
    origins, directions : (n, 3) arrays
        Directions have length 1.
    meshes : dict
        Scenes of Embree by the number of triangles, once built.
    """

    kind: str
    controls: list[Control]
    surface: Any
    origins: Array
    directions: Array
    meshes: dict[int, Any]


def view(kind: str, controls: Callable[[np.random.Generator], list[Control]]) -> Any:
    """Maker of a surface in the middle of a view."""

    def make(rng: np.random.Generator, count: int) -> View:
        surface, found = None, []
        while surface is None:
            found = controls(rng)
            surface = surface_of(kind, found)
        x, y = rng.uniform(-0.2, 0.2, (2, count))
        directions = np.stack([x, np.ones(count), y], -1)
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        # single precision holds them exactly, so that all answer the same question
        directions = directions.astype(np.float32).astype(float)
        return View(kind, found, surface, np.tile([0.0, -AWAY, 0.0], (count, 1)), directions, {})

    return make


def first_hits(method: str, copies: int) -> Callable[[View, Any], Array | None]:
    """Distances of first hits before the camera; NaN beside the surface. None where there is no such method."""

    def run(inputs: View, setting: Any) -> Array | None:
        dtype = np.float32 if setting == "float32" else np.float64
        samples = setting if isinstance(setting, int) else 64
        origins, directions = (np.tile(a, (copies, 1)).astype(dtype) for a in (inputs.origins, inputs.directions))
        try:
            hits = inputs.surface.intersect(origins, directions, method=method, samples=samples, threads=1)
        except SceneError:
            return None
        n = len(inputs.origins)
        return np.asarray(hits.t[:n, 0], float)  # all lie before the camera, the nearest first

    return run


def embree(is_built: bool) -> Callable[[View, int], Array | None]:
    """Distances by a mesh of about so many triangles; it is built in the call, or once before. None without embreex."""

    def run(inputs: View, triangles: int) -> Array | None:
        try:
            scene = built(inputs, triangles) if is_built else _build(inputs, triangles)
        except ImportError:
            return None
        origins, directions = (np.tile(a, (COPIES, 1)).astype(np.float32) for a in (inputs.origins, inputs.directions))
        away = scene.run(origins, directions, query="DISTANCE")
        n = len(inputs.origins)
        return np.where(away[:n] < 10 * AWAY, away[:n], np.nan).astype(float)

    return run


def built(inputs: View, triangles: int) -> Any:
    """A mesh in Embree, kept."""
    if triangles not in inputs.meshes:
        inputs.meshes[triangles] = _build(inputs, triangles)
    return inputs.meshes[triangles]


def _build(inputs: View, triangles: int) -> Any:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    vertices, faces = tessellated(inputs.surface, triangles)
    scene = EmbreeScene()
    TriangleMesh(scene, vertices.astype(np.float32), faces)
    return scene


def tessellated(surface: Any, triangles: int) -> tuple[Array, Any]:
    """A plain grid of the surface: as many triangles as that, twice as many along circles as along the curve."""
    is_pair = surface.kind == "evolved_point_pairs"
    shape = NARROW if is_pair else 2.0
    rings = max(2, round(np.sqrt(triangles / 2 / shape)))
    around = max(1, round(shape * rings))
    start, end = surface.curve.domain
    found = surface.curve(np.linspace(start, end, rings + 1)).parameters()
    share = np.linspace(0, 1, around + 1)[:, None]
    if is_pair:
        vertices = (1 - share) * found.a[:, None] + share * found.b[:, None]
    else:
        axes = _frames(found.normal)
        ring = np.cos(2 * np.pi * share) * axes[0][:, None] + np.sin(2 * np.pi * share) * axes[1][:, None]
        vertices = found.center[:, None] + found.radius[:, None, None] * ring
    corner = np.arange(rings)[:, None] * (around + 1) + np.arange(around)
    quads = np.stack([corner, corner + 1, corner + around + 2, corner + around + 1], -1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    return vertices.reshape(-1, 3), faces


def _frames(normal: Array) -> tuple[Array, Array]:
    """Two axes across each normal that turn with it as little as possible."""
    u = np.empty_like(normal)
    last = np.eye(3)[np.argmin(np.abs(normal[0]))]
    for i, n in enumerate(normal):
        last = last - (last @ n) * n
        last = last / np.linalg.norm(last)
        u[i] = last
    return u, np.cross(normal, u)


def truth(inputs: View) -> list[float]:
    """Distances of first hits with 50 digits; NaN where there is none."""
    surface = crossings.Surface(inputs.kind, inputs.controls)
    found = []
    for origin, direction in zip(inputs.origins, inputs.directions, strict=True):
        length = float(np.linalg.norm(direction))
        found.append(min((float(away) * length for _, away in surface.roots(origin, direction)), default=np.nan))
    return found


def error(answer: Array, exact: list[float], _: View) -> Errors:
    """Distance between the points; infinite where a hit is lost or false."""
    want = np.array(exact)
    off = np.abs(answer - want)
    return np.where(np.isnan(want) & np.isnan(answer), 0.0, np.where(np.isfinite(off), off, np.inf))


def describe(inputs: View, i: int) -> str:
    """One ray and the surface."""
    controls = "; ".join(str([np.asarray(x).tolist() for x in c]) for c in inputs.controls)
    return f"{inputs.kind} {controls}, from {inputs.origins[i].tolist()} along {inputs.directions[i].tolist()}"


STUDY = Study(
    name="hits",
    title="First hits on evolved surfaces, beside meshes traced by Embree",
    methods=(
        Method("isolate", first_hits("isolate", COPIES), "precision", ("float32", "float64")),
        Method(
            "companion (as printed)", first_hits("companion", FEW_COPIES), "precision", ("float64",), copies=FEW_COPIES,
        ),
        Method(
            "sampled (as printed)", first_hits("sampled", FEW_COPIES), "samples",
            (8, 16, 32, 64, 128, 256, 512, 1024), copies=FEW_COPIES,
        ),
        Method("Embree, mesh built before", embree(True), "triangles", TRIANGLES),
        Method("Embree, build included", embree(False), "triangles", TRIANGLES[:-1]),
        Method("Embree, build included, fine", embree(False), "triangles", TRIANGLES[-1:], slow=True),
    ),
    cases=(
        Case("tube", view("circles", partial(tube, 1)), "ordinary", describe),
        Case("ribbon", view("pairs", partial(ribbon, 1)), "ordinary", describe),
        Case("tube of degree 3", view("circles", partial(tube, 3)), "ordinary", describe),
    ),
    reference=truth,
    error=error,
    unit="of a surface of size one",
    count=COUNT,
    copies=COPIES,
    source="thesis 4.5 and 4.10",
    notes="Lost: a hit is missed, or seen where there is none, as meshes do at silhouettes. Meshes are traced in "
    "single precision and built by all threads, a build being shared by 300 000 rays, those of a picture.",
)  # fmt: skip
