"""What a ray costs in scenes of few and of many evolved surfaces: the hierarchy of bounds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..study import Case, Errors, Method, Study
from . import crossings
from .rays import Array, Control, surface_of, unit

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
    places : dict of int to array (n, 3)
        About where each surface is.
    origins, directions : (rays, 3) arrays
    """

    kind: str
    controls: dict[int, list[list[Control]]]
    surfaces: dict[int, list[Any]]
    scenes: dict[int, Any]
    places: dict[int, Array]
    origins: Array
    directions: Array


def tubes(rng: np.random.Generator, place: Array, size: float) -> list[Control]:
    """A small tube somewhere."""
    axis = unit(rng.normal(size=3))
    return [
        (place + side * size * axis, unit(axis + 0.3 * rng.normal(size=3)), float(size * rng.uniform(0.3, 0.7)))
        for side in (-0.5, 0.5)
    ]


def ribbons(rng: np.random.Generator, place: Array, size: float) -> list[Control]:
    """A small ribbon somewhere."""
    axis, across = unit(rng.normal(size=(2, 3)))
    found = []
    for side in (-0.5, 0.5):
        half = size / 2 * unit(across + 0.3 * rng.normal(size=3))
        found.append((place + side * size * axis - half, place + side * size * axis + half))
    return found


def crowd(kind: str, make_one: Callable[..., list[Control]]) -> Any:
    """Maker of scenes of all sizes, with surfaces all over a cube."""

    def make(rng: np.random.Generator, count: int) -> Crowd:
        from ... import tracer

        surfaces: dict[int, list[Any]] = {}
        controls: dict[int, list[list[Control]]] = {}
        places: dict[int, Array] = {}
        for number in NUMBERS:
            size = SIZE * float(np.sqrt(NUMBERS[0] / number))
            places[number] = rng.uniform(-1, 1, (number, 3))
            surfaces[number], controls[number] = [], []
            for place in places[number]:
                surface, two = None, []
                while surface is None:
                    two = make_one(rng, place, size)
                    surface = surface_of(kind, two, is_checked=False)
                surfaces[number].append(surface)
                controls[number].append(two)
        camera = tracer.Camera.look_at((0, -AWAY, 0), (0, 0, 0))
        scenes = {number: tracer.Scene(camera, [], found) for number, found in surfaces.items()}
        x, y = rng.uniform(-0.17, 0.17, (2, count))
        directions = unit(np.stack([x, np.ones(count), y], -1))
        return Crowd(kind, controls, surfaces, scenes, places, np.tile([0.0, -AWAY, 0.0], (count, 1)), directions)

    return make


def traced(inputs: Crowd, number: int) -> tuple[int, Array]:
    """How many surfaces, and distances of first hits."""
    origins, directions = (np.tile(a, (COPIES, 1)) for a in (inputs.origins, inputs.directions))
    hits = inputs.scenes[number].intersect(origins, directions, threads=1)
    n = len(inputs.origins)
    return number, np.where(hits.hit[:n], hits.t[:n], np.nan)


def truth(inputs: Crowd) -> dict[int, Array]:
    """Distances of first hits: which surface is first by asking those near the ray one by one, where with 50 digits."""
    return {number: _first(inputs, number) for number in inputs.surfaces}


def _first(inputs: Crowd, number: int) -> Array:
    size = 2 * SIZE * float(np.sqrt(NUMBERS[0] / number))  # no surface reaches further from its place
    relative = inputs.places[number][:, None] - inputs.origins
    along = np.einsum("srk,rk->sr", relative, inputs.directions)
    beside = np.linalg.norm(relative - along[..., None] * inputs.directions, axis=-1) < size
    nearest, which = np.full(len(inputs.origins), np.inf), np.full(len(inputs.origins), -1)
    for i, (surface, near) in enumerate(zip(inputs.surfaces[number], beside, strict=True)):
        rays = np.flatnonzero(near)
        if len(rays):
            t = surface.intersect(inputs.origins[rays], inputs.directions[rays], threads=1).t[:, 0]
            closer = rays[t < nearest[rays]]
            which[closer] = i
            nearest[rays] = np.fmin(nearest[rays], t)
    found = np.full(len(which), np.nan)
    for ray in np.flatnonzero(which >= 0):
        exact = crossings.Surface(inputs.kind, inputs.controls[number][which[ray]])
        found[ray] = min(float(t) for _, t in exact.roots(inputs.origins[ray], inputs.directions[ray]))
    return found


def error(answer: tuple[int, Array], exact: dict[int, Array], _: Crowd) -> Errors:
    """Difference of distances; infinite where a hit is lost, false, or another surface's."""
    number, found = answer
    want = exact[number]
    off = np.abs(found - want)
    return np.where(np.isnan(want) & np.isnan(found), 0.0, np.where(off < 1e-6, off, np.inf))


def describe(inputs: Crowd, i: int) -> str:
    """One ray."""
    return f"from {inputs.origins[i].tolist()} along {inputs.directions[i].tolist()}"


STUDY = Study(
    name="crowds",
    title="Scenes of few and of many evolved surfaces",
    methods=(Method("first hit", traced, "surfaces", NUMBERS),),
    cases=(
        Case("tubes", crowd("circles", tubes), "ordinary", describe),
        Case("ribbons", crowd("pairs", ribbons), "ordinary", describe),
    ),
    reference=truth,
    error=error,
    unit="of the view's half width",
    count=60,
    copies=COPIES,
    source="thesis 4.5 and 4.7",
    notes="Surfaces shrink with the root of their number, so that they cover as much of the view. Which one is hit "
    "first is known from asking all near the ray, without the hierarchy.",
)
