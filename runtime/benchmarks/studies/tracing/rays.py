"""Rays against surfaces evolved between circles: lost roots, false roots and errors, by method and time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from .... import tracer
from ....errors import SceneError
from ....tracer.surfaces.evolved import suppress_flip_warnings
from ...harness.study import PRECISIONS, Array, Case, Errors, Method, Study
from ...harness.vectors import directions, unit
from . import crossings

Control = tuple[Any, ...]
#: Surfaces per case; the rays are divided among them.
SURFACES = 5
#: Each ray is computed this many times in one call, so that the time is the loop's and not the call's.
COPIES = 40
#: A computed root belongs to a true one if their parameters differ by less than this.
ROOT_TOLERANCE = 1e-2
#: Distance of near-tangent rays from the surface, relative to its size.
OFF = 1e-9
#: Step in t of the differences that give tangents.
STEP = 1e-6
#: Distance of far surfaces from the origin.
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
        Parameters of each surface: (center, normal, radius), or (a, b).
    shifts : (surfaces, 3) array
        Displacement of all positions.
    origins, directions : (surfaces, rays, 3) arrays
    """

    kind: str
    controls: list[list[Control]]
    shifts: Array
    origins: Array
    directions: Array

    @cached_property
    def surfaces(self) -> list[Any]:
        """The surfaces, prepared once: preparation is per scene, not per ray, and is not timed."""
        return [surface_of(self.kind, controls) for controls in self.controls]


def rays(
    rng: np.random.Generator, count: int, kind: str, controls: Maker, distance: float = 0.0, is_tangent: bool = False
) -> Rays:
    """Surfaces at a distance from the origin, with rays aimed near them, or tangent to about 1e-9."""
    each = -(-count // SURFACES)
    surfaces, shifts, origins, along = [], [], [], []
    for _ in range(SURFACES):
        surface, near = random_surface(rng, kind, controls)
        shift = distance * unit(np.array([1.0, 0.8, -0.9]) + 0.1 * rng.normal(size=3))
        target, direction = tangents(surface, rng, each) if is_tangent else aim_rays(surface, rng, each)
        surfaces.append([translate_control(kind, c, shift) for c in near])
        shifts.append(shift)
        origins.append(shift + target - 5 * direction)
        along.append(direction)
    return Rays(kind, surfaces, *(np.stack(x) for x in (shifts, origins, along)))


def random_surface(
    rng: np.random.Generator, kind: str, controls: Maker, is_checked: bool = True
) -> tuple[Any, list[Control]]:
    """The first surface that there is of random controls, and these."""
    while True:
        drawn = controls(rng)
        surface = surface_of(kind, drawn, is_checked)
        if surface is not None:
            return surface, drawn


def translate_control(kind: str, control: Control, shift: Array) -> Control:
    """Parameters of a translated object."""
    if kind == "circles":
        center, normal, radius = control
        return center + shift, normal, radius
    return tuple(end + shift for end in control)


def surface_of(kind: str, controls: list[Control], is_checked: bool = True) -> Any:
    """The surface, or None where objects oppose each other or, if that is checked, where it is imaginary on the way."""
    constructor = tracer.EvolvedCircles if kind == "circles" else tracer.EvolvedPointPairs
    with suppress_flip_warnings():  # those with reversed objects are drawn again
        surface = constructor(controls)
    if np.any(surface.flipped):
        return None
    try:
        if is_checked:
            surface.intersect(np.zeros(3), np.ones(3))
    except SceneError:
        return None
    return surface


def aim_rays(surface: Any, rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Targets about the surface, and directions."""
    points = np.concatenate([_points(surface, t, rng.uniform(-1, 1, count))[0] for t in (0.2, 0.5, 0.8)])
    middle = points[rng.integers(0, len(points), count)]
    return middle + 0.3 * rng.normal(size=(count, 3)), directions(rng, count)


def tangents(surface: Any, rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Points beside the surface, every second one on the other side, and directions in the tangent plane."""
    t, offset = rng.uniform(0.1, 0.9, count), rng.uniform(-0.9, 0.9, count)
    here, across = _points(surface, t, offset)
    along = _points(surface, t + STEP, offset)[0] - _points(surface, t - STEP, offset)[0]
    normal = unit(np.cross(along, across))
    angle = rng.uniform(0, np.pi, (count, 1))
    side = OFF * np.where(np.arange(count) % 2 == 0, 1.0, -1.0)[:, None]
    return here + side * normal, unit(np.cos(angle) * unit(along) + np.sin(angle) * unit(across))


def _points(surface: Any, t: Any, offset: Array) -> tuple[Array, Array]:
    """Points of the objects at t, at offsets from -1 to 1 along each, and directions along the objects."""
    x = surface.curve(np.broadcast_to(t, offset.shape)).parameters()
    if surface.kind == "evolved_point_pairs":
        return (x.a + x.b) / 2 + offset[:, None] * (x.b - x.a) / 2, x.b - x.a
    u = unit(np.cross(x.normal, [0.3, -0.5, 0.8]))
    v, angle = np.cross(x.normal, u), np.pi * offset[:, None]
    ring = np.cos(angle) * u + np.sin(angle) * v
    return x.center + x.radius[:, None] * ring, np.cos(angle) * v - np.sin(angle) * u


# -- objects -------------------------------------------------------------------------------------------


def any_circles(rng: np.random.Generator) -> list[Control]:
    """Two circles of any position, direction and size."""
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


def intersect(surface: Any, rays: tuple[Array, Array], method: str, setting: Any, copies: int) -> Any:
    """Hits of copies of the rays; the setting is a number of samples or a precision. None without such a method."""
    dtype = np.float32 if setting == "float32" else np.float64
    samples = setting if isinstance(setting, int) else 64
    repeated = (np.tile(a, (copies, 1)).astype(dtype) for a in rays)
    try:
        return surface.intersect(*repeated, method=method, samples=samples, threads=1)
    except SceneError:
        return None


def run_intersect(inputs: Rays, setting: Any, *, method: str) -> list[Array] | None:
    """Curve parameters of all hits of each ray."""
    parameters: list[Array] = []
    for surface, *rays in zip(inputs.surfaces, inputs.origins, inputs.directions, strict=True):
        hits = intersect(surface, (rays[0], rays[1]), method, setting, COPIES)
        if hits is None:
            return None
        first = zip(hits.alpha[: len(rays[0])], hits.count[: len(rays[0])], strict=True)
        parameters.extend(np.asarray(row[:count], float) for row, count in first)
    return parameters


def truth(inputs: Rays) -> list[list[Any]]:
    """Curve parameters of all hits, with more than 50 digits."""
    rows = []
    cases = zip(inputs.controls, inputs.shifts, inputs.origins, inputs.directions, strict=True)
    for controls, shift, origins, along in cases:  # exact without the shift
        surface = crossings.Surface(inputs.kind, [translate_control(inputs.kind, c, -shift) for c in controls])
        for origin, direction in zip(origins - shift, along, strict=True):
            rows.append([t for t, _ in surface.roots(origin, direction)])
    return rows


def error(answer: list[Array], exact: list[list[Any]], _: Rays) -> Errors:
    """Largest error of a ray's parameters; infinite where a root is lost or false."""
    errors = np.full(len(exact), np.inf)
    for i, (computed, true) in enumerate(zip(answer, exact, strict=True)):
        if len(computed) == len(true):
            away = [abs(float(t - float(x))) for x, t in zip(np.sort(computed), true, strict=True)]
            if all(d < ROOT_TOLERANCE for d in away):
                errors[i] = max(away, default=0.0)
    return errors


def controls_text(kind: str, controls: list[Control]) -> str:
    """The controls of a surface, in full."""
    return f"{kind} {'; '.join(str([np.asarray(x).tolist() for x in c]) for c in controls)}"


def describe(inputs: Rays, i: int) -> str:
    """One ray and its surface, in full."""
    surface, ray = divmod(i, inputs.origins.shape[1])
    origin, direction = inputs.origins[surface, ray].tolist(), inputs.directions[surface, ray].tolist()
    return f"{controls_text(inputs.kind, inputs.controls[surface])}, origin {origin}, direction {direction}"


def study(kind: str, any_controls: Maker, special: Maker, path: Callable[..., list[Control]], **options: Any) -> Study:
    """A study of surfaces between random objects, nearly degenerate ones, and along paths of some degree.

    Parameters
    ----------
    kind : "circles" or "pairs"
    any_controls, special, path : callables
        ``path(degree, rng)``.
    options
        Name, title and source of the study; ``special_name`` and ``path_name`` for its cases.
    """
    make = partial(rays, kind=kind)
    name, several = options.pop("special_name"), options.pop("path_name")
    return Study(
        methods=(
            Method("isolate", partial(run_intersect, method="isolate"), "precision", PRECISIONS),
            Method("companion (as printed)", partial(run_intersect, method="companion"), "precision", ("float64",)),
            Method("sampled (as printed)", partial(run_intersect, method="sampled"), "samples", SAMPLES),
        ),
        cases=(
            Case(f"random {'circles' if kind == 'circles' else 'point pairs'}", partial(make, controls=any_controls)),
            Case("rays 1e-9 off tangents", partial(make, controls=partial(path, 1), is_tangent=True), "extreme"),
            Case(f"1e-8 off a common {name}", partial(make, controls=special), "extreme"),
            Case(f"{several}, 1e6 from the origin", partial(make, controls=partial(path, 1), distance=FAR), "stiff"),
            Case(f"{several} of degree 2", partial(make, controls=partial(path, 2))),
            Case(f"{several} of degree 3", partial(make, controls=partial(path, 3))),
        ),
        reference=truth,
        error=error,
        describe=describe,
        unit="curve parameter",
        count=100,
        copies=COPIES,
        notes="Lost: rays of which a hit is missing, or reported where there is none. Single precision rounds the "
        "surface and the rays themselves, and is compared with the exact answer of the unrounded ones: near tangents "
        "and far away it must lose. Degrees are those of the curve; the printed methods are extended to them.",
        **options,
    )


STUDY = study(
    "circles", any_circles, cospherical_circles, tube, special_name="sphere", path_name="tubes", name="rays",
    title="Rays against surfaces evolved between circles", source="thesis 4.5.1, corrected",
)  # fmt: skip
