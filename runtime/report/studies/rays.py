"""Rays against surfaces evolved between circles: roots lost, false, and how far off, per method and time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from ..study import Case, Errors, Method, Study
from . import crossings

Array = NDArray[np.float64]
Control = tuple[Any, ...]
#: Surfaces per case; the rays are shared among them.
SURFACES = 5
#: Each ray is computed this many times in one call, so that the time is the loop's and not the call's.
COPIES = 40
#: A computed root belongs to a true one if their parameters differ by less than this.
REACH = 1e-2
#: How far near-tangent rays are off, relative to the size of the surface.
OFF = 1e-9
#: Step in t of the differences that give tangents.
STEP = 1e-6
#: How far from the origin far surfaces stand.
FAR = 1e6
SAMPLES = (8, 16, 32, 64, 128, 256, 512, 1024)
Maker = Callable[[np.random.Generator], list[Control]]


@dataclass(frozen=True)
class Rays:
    """Surfaces by the parameters of their Bezier controls, and rays: each surface has the same number of them.

    Attributes
    ----------
    kind : "circles" or "pairs"
    controls : list
        Of each surface: (center, normal, radius), or (a, b).
    shifts : (surfaces, 3) array
        What was added to all positions.
    origins, directions : (surfaces, rays, 3) arrays
    """

    kind: str
    controls: list[list[Control]]
    shifts: Array
    origins: Array
    directions: Array


def unit(v: Array) -> Array:
    """Vectors over their lengths."""
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def rays(kind: str, controls: Maker, distance: float = 0.0, is_tangent: bool = False) -> Any:
    """Maker of surfaces at a distance from the origin, with rays aimed near them, or tangent to about 1e-9."""

    def make(rng: np.random.Generator, count: int) -> Rays:
        share = -(-count // SURFACES)
        surfaces: list[Any] = []
        shifts, origins, directions = [], [], []
        while len(surfaces) < SURFACES:
            near = controls(rng)
            surface = surface_of(kind, near)
            if surface is None:
                continue
            shift = distance * unit(np.array([1.0, 0.8, -0.9]) + 0.1 * rng.normal(size=3))
            target, direction = tangents(surface, rng, share) if is_tangent else aimed(surface, rng, share)
            surfaces.append([moved(kind, c, shift) for c in near])
            shifts.append(shift)
            origins.append(shift + target - 5 * direction)
            directions.append(direction)
        return Rays(kind, surfaces, np.stack(shifts), np.stack(origins), np.stack(directions))

    return make


def moved(kind: str, control: Control, shift: Array) -> Control:
    """Parameters of an object elsewhere."""
    if kind == "circles":
        center, normal, radius = control
        return center + shift, normal, radius
    return tuple(end + shift for end in control)


def surface_of(kind: str, controls: list[Control], is_checked: bool = True) -> Any:
    """The surface, or None where objects oppose each other or, if that is checked, where it is imaginary on the way."""
    from ... import tracer
    from ...tracer.surfaces.evolved import quietly

    made = tracer.EvolvedCircles if kind == "circles" else tracer.EvolvedPointPairs
    with quietly():  # those that were turned over are drawn again
        surface = made(controls)
    if np.any(surface.flipped):
        return None
    try:
        if is_checked:
            surface.intersect(np.zeros(3), np.ones(3))
    except SceneError:
        return None
    return surface


def aimed(surface: Any, rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Targets about the surface, and directions."""
    points = np.concatenate([_points(surface, t, rng.uniform(-1, 1, count))[0] for t in (0.2, 0.5, 0.8)])
    middle = points[rng.integers(0, len(points), count)]
    return middle + 0.3 * rng.normal(size=(count, 3)), unit(rng.normal(size=(count, 3)))


def tangents(surface: Any, rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Points beside the surface, every second one on the other side, and directions in the tangent plane."""
    t, place = rng.uniform(0.1, 0.9, count), rng.uniform(-0.9, 0.9, count)
    here, across = _points(surface, t, place)
    along = _points(surface, t + STEP, place)[0] - _points(surface, t - STEP, place)[0]
    normal = unit(np.cross(along, across))
    turn = rng.uniform(0, np.pi, (count, 1))
    side = OFF * np.where(np.arange(count) % 2 == 0, 1.0, -1.0)[:, None]
    return here + side * normal, unit(np.cos(turn) * unit(along) + np.sin(turn) * unit(across))


def _points(surface: Any, t: Any, place: Array) -> tuple[Array, Array]:
    """Points of the objects at t, at places from -1 to 1 of each, and directions along the objects."""
    found = surface.curve(np.broadcast_to(t, place.shape)).parameters()
    if surface.kind == "evolved_point_pairs":
        return (found.a + found.b) / 2 + place[:, None] * (found.b - found.a) / 2, found.b - found.a
    u = unit(np.cross(found.normal, [0.3, -0.5, 0.8]))
    v, angle = np.cross(found.normal, u), np.pi * place[:, None]
    ring = np.cos(angle) * u + np.sin(angle) * v
    return found.center + found.radius[:, None] * ring, np.cos(angle) * v - np.sin(angle) * u


# -- objects -------------------------------------------------------------------------------------------


def any_circles(rng: np.random.Generator) -> list[Control]:
    """Two circles of any place, direction and size."""
    return [(rng.normal(size=3), unit(rng.normal(size=3)), float(rng.uniform(0.4, 1.5))) for _ in range(2)]


def tube(degree: int, rng: np.random.Generator) -> list[Control]:
    """Circles along a path, as a piece of tube."""
    axis = unit(rng.normal(size=3))
    return [
        (
            (1.6 * k / degree - 0.8) * axis + 0.2 * rng.normal(size=3),
            unit(axis + 0.4 * rng.normal(size=3)),
            float(rng.uniform(0.3, 0.9)),
        )
        for k in range(degree + 1)
    ]


def cospherical_circles(rng: np.random.Generator) -> list[Control]:
    """Two circles that miss lying on a common sphere by 1e-8."""
    circles = []
    for _ in range(2):
        normal, height = unit(rng.normal(size=3)), float(rng.uniform(-0.7, 0.7))
        circles.append((height * normal + 1e-8 * rng.normal(size=3), normal, float(np.sqrt(1 - height**2))))
    return circles


# -- methods and truth ---------------------------------------------------------------------------------


def intersect(method: str) -> Callable[[Rays, Any], list[Array] | None]:
    """The compiled method; the setting is a number of samples or a precision. None where there is no such method."""

    def run(inputs: Rays, setting: Any) -> list[Array] | None:
        dtype = np.float32 if setting == "float32" else np.float64
        samples = setting if isinstance(setting, int) else 64
        found: list[Array] = []
        for number, surface in enumerate(_surfaces(inputs)):
            own = (inputs.origins[number], inputs.directions[number])
            origins, directions = (np.tile(a, (COPIES, 1)).astype(dtype) for a in own)
            try:
                hits = surface.intersect(origins, directions, method=method, samples=samples, threads=1)
            except SceneError:
                return None
            first = zip(hits.alpha[: len(own[0])], hits.count[: len(own[0])], strict=True)
            found.extend(np.asarray(row[:count], float) for row, count in first)
        return found

    return run


_made: dict[int, tuple[Rays, list[Any]]] = {}


def _surfaces(inputs: Rays) -> list[Any]:
    """The surfaces of a case, prepared once: preparation is per scene, not per ray, and is not timed."""
    known = _made.get(id(inputs))
    if known is None or known[0] is not inputs:
        _made[id(inputs)] = known = (inputs, [surface_of(inputs.kind, two) for two in inputs.controls])
    return known[1]


def truth(inputs: Rays) -> list[list[Any]]:
    """Curve parameters of all hits, with more than 50 digits."""
    rows = []
    for controls, shift, origins, directions in zip(
        inputs.controls, inputs.shifts, inputs.origins, inputs.directions, strict=True
    ):
        surface = crossings.Surface(inputs.kind, [moved(inputs.kind, c, -shift) for c in controls])  # exact there
        for origin, direction in zip(origins - shift, directions, strict=True):
            rows.append([t for t, _ in surface.roots(origin, direction)])
    return rows


def error(answer: list[Array], exact: list[list[Any]], _: Rays) -> Errors:
    """Largest error of a ray's parameters; infinite where a root is lost or false."""
    errors = np.full(len(exact), np.inf)
    for i, (got, want) in enumerate(zip(answer, exact, strict=True)):
        if len(got) == len(want):
            away = [abs(float(w - float(g))) for g, w in zip(np.sort(got), want, strict=True)]
            if all(d < REACH for d in away):
                errors[i] = max(away, default=0.0)
    return errors


def describe(inputs: Rays, i: int) -> str:
    """One ray and its surface, in full."""
    surface, ray = divmod(i, inputs.origins.shape[1])
    controls = "; ".join(str([np.asarray(x).tolist() for x in c]) for c in inputs.controls[surface])
    origin, direction = inputs.origins[surface, ray], inputs.directions[surface, ray]
    return f"{inputs.kind} {controls}, origin {origin.tolist()}, direction {direction.tolist()}"


METHODS = (
    Method("isolate", intersect("isolate"), "precision", ("float32", "float64")),
    Method("companion (as printed)", intersect("companion"), "precision", ("float64",)),
    Method("sampled (as printed)", intersect("sampled"), "samples", SAMPLES),
)
NOTES = (
    "Lost: rays of which a hit is missing, or reported where there is none. Single precision rounds the surface and "
    "the rays themselves, and is compared with the exact answer of the unrounded ones: near tangents and far away it "
    "must lose. Degrees are those of the curve; the printed methods are extended to them."
)

STUDY = Study(
    name="rays",
    title="Rays against surfaces evolved between circles",
    methods=METHODS,
    cases=(
        Case("random circles", rays("circles", any_circles), "ordinary", describe),
        Case("rays 1e-9 off tangents", rays("circles", partial(tube, 1), is_tangent=True), "extreme", describe),
        Case("1e-8 off a common sphere", rays("circles", cospherical_circles), "extreme", describe),
        Case("tubes, 1e6 from the origin", rays("circles", partial(tube, 1), FAR), "stiff", describe),
        Case("tubes of degree 2", rays("circles", partial(tube, 2)), "ordinary", describe),
        Case("tubes of degree 3", rays("circles", partial(tube, 3)), "ordinary", describe),
    ),
    reference=truth,
    error=error,
    unit="curve parameter",
    count=100,
    copies=COPIES,
    source="thesis 4.5.1, corrected",
    notes=NOTES,
)
