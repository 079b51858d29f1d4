"""Cost of a ray in scenes of few and of many evolved surfaces: the hierarchy of bounds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from .... import tracer
from ...harness.study import Array, Case, Errors, Method, Study
from ...harness.vectors import unit
from . import crossings
from .hits import distance_errors
from .rays import Control, random_surface

#: Surfaces of a scene.
NUMBERS = (10, 100, 1_000, 10_000)
#: Size of one of ten surfaces; with the root of their number they shrink, so that as much of the view is covered.
SIZE = 0.45
COPIES = 100
AWAY = 6.0


@dataclass(frozen=True)
class Crowd:
    """Scenes of one size each, and rays from a camera for all.

    Attributes
    ----------
    kind : "circles" or "pairs"
    controls, surfaces : dict of int to list
        By how many there are.
    scenes : dict of int to Scene
    positions : dict of int to array (n, 3)
        Position about which each surface is.
    origins, directions : (rays, 3) arrays
    """

    kind: str
    controls: dict[int, list[list[Control]]]
    surfaces: dict[int, list[Any]]
    scenes: dict[int, Any]
    positions: dict[int, Array]
    origins: Array
    directions: Array


def tubes(rng: np.random.Generator, position: Array, size: float) -> list[Control]:
    """A small tube about a position."""
    axis = unit(rng.normal(size=3))
    return [
        (position + side * size * axis, unit(axis + 0.3 * rng.normal(size=3)), float(size * rng.uniform(0.3, 0.7)))
        for side in (-0.5, 0.5)
    ]


def ribbons(rng: np.random.Generator, position: Array, size: float) -> list[Control]:
    """A small ribbon about a position."""
    axis, across = unit(rng.normal(size=(2, 3)))
    controls = []
    for side in (-0.5, 0.5):
        half = size / 2 * unit(across + 0.3 * rng.normal(size=3))
        controls.append((position + side * size * axis - half, position + side * size * axis + half))
    return controls


def crowd(rng: np.random.Generator, count: int, kind: str, make_one: Callable[..., list[Control]]) -> Crowd:
    """Scenes of all sizes, with surfaces all over a cube."""
    surfaces: dict[int, list[Any]] = {}
    controls: dict[int, list[list[Control]]] = {}
    positions: dict[int, Array] = {}
    for number in NUMBERS:
        positions[number] = rng.uniform(-1, 1, (number, 3))
        makers = (partial(make_one, position=x, size=size_of(number)) for x in positions[number])
        pairs = [random_surface(rng, kind, make, is_checked=False) for make in makers]
        surfaces[number], controls[number] = [x for x, _ in pairs], [x for _, x in pairs]
    camera = tracer.Camera.look_at((0, -AWAY, 0), (0, 0, 0))
    scenes = {number: tracer.Scene(camera, [], several) for number, several in surfaces.items()}
    x, y = rng.uniform(-0.17, 0.17, (2, count))
    directions = unit(np.stack([x, np.ones(count), y], -1))
    return Crowd(kind, controls, surfaces, scenes, positions, np.tile([0.0, -AWAY, 0.0], (count, 1)), directions)


def size_of(number: int) -> float:
    """Size of one of so many surfaces."""
    return SIZE * float(np.sqrt(NUMBERS[0] / number))


def trace_scene(inputs: Crowd, number: int) -> tuple[int, Array]:
    """Number of surfaces, and distances of first hits."""
    origins, directions = (np.tile(a, (COPIES, 1)) for a in (inputs.origins, inputs.directions))
    hits = inputs.scenes[number].intersect(origins, directions, threads=1)
    n = len(inputs.origins)
    return number, np.where(hits.hit[:n], hits.t[:n], np.nan)


def truth(inputs: Crowd) -> dict[int, Array]:
    """Distances of first hits: the first surface by intersecting those near the ray one by one, where with 50
    digits."""
    return {number: _first(inputs, number) for number in inputs.surfaces}


def _first(inputs: Crowd, number: int) -> Array:
    relative = inputs.positions[number][:, None] - inputs.origins
    along = np.einsum("srk,rk->sr", relative, inputs.directions)
    # no surface extends further from its position
    beside = np.linalg.norm(relative - along[..., None] * inputs.directions, axis=-1) < 2 * size_of(number)
    nearest, which = np.full(len(inputs.origins), np.inf), np.full(len(inputs.origins), -1)
    for i, (surface, near) in enumerate(zip(inputs.surfaces[number], beside, strict=True)):
        rays = np.flatnonzero(near)
        if len(rays):
            t = surface.intersect(inputs.origins[rays], inputs.directions[rays], threads=1).t[:, 0]
            closer = rays[t < nearest[rays]]
            which[closer] = i
            nearest[rays] = np.fmin(nearest[rays], t)
    distances = np.full(len(which), np.nan)
    for ray in np.flatnonzero(which >= 0):
        exact = crossings.Surface(inputs.kind, inputs.controls[number][which[ray]])
        distances[ray] = min(float(t) for _, t in exact.roots(inputs.origins[ray], inputs.directions[ray]))
    return distances


def error(answer: tuple[int, Array], exact: dict[int, Array], _: Crowd) -> Errors:
    """Difference of distances; infinite where a hit is lost, false, or another surface's."""
    number, distances = answer
    return distance_errors(distances, exact[number], limit=1e-6)


STUDY = Study(
    name="crowds",
    title="Scenes of few and of many evolved surfaces",
    methods=(Method("first hit", trace_scene, "surfaces", NUMBERS),),
    cases=(
        Case("tubes", partial(crowd, kind="circles", make_one=tubes)),
        Case("ribbons", partial(crowd, kind="pairs", make_one=ribbons)),
    ),
    reference=truth,
    error=error,
    describe=lambda inputs, i: f"from {inputs.origins[i].tolist()} along {inputs.directions[i].tolist()}",
    unit="of the view's half width",
    count=60,
    copies=COPIES,
    source="thesis 4.5 and 4.7",
    notes="Surfaces shrink with the root of their number, so that they cover as much of the view. Which one is hit "
    "first is known from asking all near the ray, without the hierarchy.",
)
