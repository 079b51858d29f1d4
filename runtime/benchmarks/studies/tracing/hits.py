"""First hits on evolved surfaces: exact methods beside triangle meshes traced by Embree, error against time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ...harness.study import PRECISIONS, Array, Case, Errors, Method, Study
from ...harness.vectors import unit
from . import crossings
from .rays import SAMPLES, Control, Maker, controls_text, intersect, random_surface, tube
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


def view(rng: np.random.Generator, count: int, kind: str, controls: Maker) -> View:
    """A surface in the middle of a view."""
    surface, drawn = random_surface(rng, kind, controls)
    x, y = rng.uniform(-0.2, 0.2, (2, count))
    # single precision holds them exactly, so that all answer the same question
    directions = unit(np.stack([x, np.ones(count), y], -1)).astype(np.float32).astype(float)
    return View(kind, drawn, surface, np.tile([0.0, -AWAY, 0.0], (count, 1)), directions, {})


def first_hits(inputs: View, setting: Any, *, method: str, copies: int = COPIES) -> Array | None:
    """Distances of first hits before the camera; NaN beside the surface. None where there is no such method."""
    hits = intersect(inputs.surface, (inputs.origins, inputs.directions), method, setting, copies)
    # all lie before the camera, the nearest first
    return None if hits is None else np.asarray(hits.t[: len(inputs.origins), 0], float)


def embree(inputs: View, triangles: int, *, is_built: bool) -> Array:
    """Distances by a mesh of about so many triangles; it is built in the call, or once before."""
    scene = inputs.meshes.get(triangles) if is_built else None
    if scene is None:
        scene = inputs.meshes[triangles] = build_mesh(inputs.surface, triangles)
    origins, directions = (np.tile(a, (COPIES, 1)).astype(np.float32) for a in (inputs.origins, inputs.directions))
    away = scene.run(origins, directions, query="DISTANCE")[: len(inputs.origins)]
    return np.where(away < 10 * AWAY, away, np.nan).astype(float)


def build_mesh(surface: Any, triangles: int) -> Any:
    """Mesh in Embree."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    vertices, faces = tessellate(surface, triangles)
    scene = EmbreeScene()
    TriangleMesh(scene, vertices.astype(np.float32), faces)
    return scene


def tessellate(surface: Any, triangles: int) -> tuple[Array, Any]:
    """A plain grid of the surface: as many triangles as that, twice as many along circles as along the curve."""
    is_pair = surface.kind == "evolved_point_pairs"
    shape = NARROW if is_pair else 2.0
    rings = max(2, round(np.sqrt(triangles / 2 / shape)))
    around = max(1, round(shape * rings))
    start, end = surface.curve.domain
    x = surface.curve(np.linspace(start, end, rings + 1)).parameters()
    fraction = np.linspace(0, 1, around + 1)[:, None]
    if is_pair:
        vertices = (1 - fraction) * x.a[:, None] + fraction * x.b[:, None]
    else:
        u, v = _frames(x.normal)
        ring = np.cos(2 * np.pi * fraction) * u[:, None] + np.sin(2 * np.pi * fraction) * v[:, None]
        vertices = x.center[:, None] + x.radius[:, None, None] * ring
    corner = np.arange(rings)[:, None] * (around + 1) + np.arange(around)
    quads = np.stack([corner, corner + 1, corner + around + 2, corner + around + 1], -1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    return vertices.reshape(-1, 3), faces


def _frames(normal: Array) -> tuple[Array, Array]:
    """Two axes across each normal that rotate with it as little as possible."""
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
    nearest = []
    for origin, direction in zip(inputs.origins, inputs.directions, strict=True):
        length = float(np.linalg.norm(direction))
        nearest.append(min((float(away) * length for _, away in surface.roots(origin, direction)), default=np.nan))
    return nearest


def distance_errors(answer: Array, exact: Array, limit: float = np.inf) -> Errors:
    """Difference of distances; infinite where a hit is lost or false, or off by a limit."""
    off = np.abs(answer - exact)
    return np.where(np.isnan(exact) & np.isnan(answer), 0.0, np.where(off < limit, off, np.inf))


def describe(inputs: View, i: int) -> str:
    """One ray and the surface."""
    ray = f"from {inputs.origins[i].tolist()} along {inputs.directions[i].tolist()}"
    return f"{controls_text(inputs.kind, inputs.controls)}, {ray}"


STUDY = Study(
    name="hits",
    title="First hits on evolved surfaces, beside meshes traced by Embree",
    methods=(
        Method("isolate", partial(first_hits, method="isolate"), "precision", PRECISIONS),
        Method(
            "companion (as printed)", partial(first_hits, method="companion", copies=FEW_COPIES), "precision",
            ("float64",), copies=FEW_COPIES,
        ),
        Method(
            "sampled (as printed)", partial(first_hits, method="sampled", copies=FEW_COPIES), "samples", SAMPLES,
            copies=FEW_COPIES,
        ),
        *(
            Method(f"Embree, {name}", partial(embree, is_built=is_built), "triangles", settings, slow=slow,
                   requires="embreex")
            for name, is_built, settings, slow in (
                ("mesh built before", True, TRIANGLES, False),
                ("build included", False, TRIANGLES[:-1], False),
                ("build included, fine", False, TRIANGLES[-1:], True),
            )
        ),
    ),
    cases=(
        Case("tube", partial(view, kind="circles", controls=partial(tube, 1))),
        Case("ribbon", partial(view, kind="pairs", controls=partial(ribbon, 1))),
        Case("tube of degree 3", partial(view, kind="circles", controls=partial(tube, 3))),
    ),
    reference=truth,
    error=lambda answer, exact, _: distance_errors(answer, np.array(exact)),
    describe=describe,
    unit="of a surface of size one",
    count=COUNT,
    copies=COPIES,
    source="thesis 4.5 and 4.10",
    notes="Lost: a hit is missed, or seen where there is none, as meshes do at silhouettes. Meshes are traced in "
    "single precision and built by all threads, a build being shared by 300 000 rays, those of a picture.",
)  # fmt: skip
