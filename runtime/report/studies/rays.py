"""Rays against surfaces evolved between two circles: roots lost, false, and how far off, per method and time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, Study

Array = NDArray[np.float64]
DIGITS = 50
#: Surfaces per case; the rays are shared among them.
SURFACES = 5
#: Each ray is computed this many times in one call, so that the time is the loop's and not the call's.
COPIES = 40
#: A computed root belongs to a true one if their parameters differ by less than this.
REACH = 1e-2


@dataclass(frozen=True)
class Rays:
    """Pairs of circles (center, normal, radius), and rays: each of the surfaces has the same number of them."""

    circles: list[list[tuple[Array, Array, float]]]
    origins: Array
    directions: Array


def rays(pair: Callable[[np.random.Generator], list[tuple[Array, Array, float]]], distance: float = 0.0) -> Any:
    """Maker of surfaces from ``pair`` at a distance from the origin, with rays aimed near them."""

    def make(rng: np.random.Generator, count: int) -> Rays:
        circles, origins, directions = [], [], []
        for _ in range(SURFACES):
            shift = distance * unit(rng.normal(size=3))
            two = [(center + shift, normal, radius) for center, normal, radius in pair(rng)]
            circles.append(_aligned(two))
            share = -(-count // SURFACES)
            target = shift + rng.normal(size=(share, 3)) * 0.7
            direction = unit(rng.normal(size=(share, 3)))
            origins.append(target - 5 * direction)
            directions.append(direction)
        return Rays(circles, np.stack(origins), np.stack(directions))

    return make


def unit(v: Array) -> Array:
    """Vectors over their lengths."""
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def random_pair(rng: np.random.Generator) -> list[tuple[Array, Array, float]]:
    """Two circles of any place, direction and size."""
    return [(rng.normal(size=3), unit(rng.normal(size=3)), float(rng.uniform(0.4, 1.5))) for _ in range(2)]


def tube_pair(rng: np.random.Generator) -> list[tuple[Array, Array, float]]:
    """Two circles as the ends of a piece of tube."""
    axis = unit(rng.normal(size=3))
    ends = []
    for side in (-1.0, 1.0):
        normal = unit(axis + 0.4 * rng.normal(size=3))
        ends.append((side * 0.8 * axis + 0.2 * rng.normal(size=3), normal, float(rng.uniform(0.3, 0.9))))
    return ends


def cospherical_pair(rng: np.random.Generator) -> list[tuple[Array, Array, float]]:
    """Two circles that miss lying on a common sphere by 1e-6."""
    circles = []
    for _ in range(2):
        normal = unit(rng.normal(size=3))
        height = float(rng.uniform(-0.7, 0.7))
        circles.append((height * normal * (1 + 1e-6 * rng.normal()), normal, float(np.sqrt(1 - height**2))))
    return circles


def intersect(method: str) -> Callable[[Rays, Any], list[Array]]:
    """The compiled method; the setting is a number of samples or a precision."""

    def run(inputs: Rays, setting: Any) -> list[Array]:
        dtype = np.float32 if setting == "float32" else np.float64
        samples = setting if isinstance(setting, int) else 64
        found: list[Array] = []
        for number, surface in enumerate(_surfaces(inputs)):
            own = (inputs.origins[number], inputs.directions[number])
            origins, directions = (np.tile(a, (COPIES, 1)).astype(dtype) for a in own)
            hits = surface.intersect(origins, directions, method=method, samples=samples, threads=1)
            first = zip(hits.alpha[: len(own[0])], hits.count[: len(own[0])], strict=True)
            found.extend(np.asarray(row[:count], float) for row, count in first)
        return found

    return run


_made: dict[int, tuple[Rays, list[Any]]] = {}


def _surfaces(inputs: Rays) -> list[Any]:
    """The surfaces of a case, prepared once: preparation is per scene, not per ray, and is not timed."""
    from ... import tracer
    from ...curves import Bezier

    known = _made.get(id(inputs))
    if known is None or known[0] is not inputs:
        surfaces = [tracer.EvolvedCircles(Bezier(two)) for two in inputs.circles]
        _made[id(inputs)] = known = (inputs, surfaces)
    return known[1]


def truth(inputs: Rays) -> list[list[Any]]:
    """Curve parameters of all hits with 50 digits: roots of the octic at which the un-squared condition vanishes."""
    from ... import cga3d
    from ...codegen.formulas.surfaces import evolved_condition, evolved_constants, evolved_octic, evolved_ray
    from ...codegen.multivector import Multivector
    from ...codegen.rings import PrecisionRing

    ring = PrecisionRing(DIGITS)
    mp = ring.context

    def vector(v: Array) -> Multivector:
        return Multivector(cga3d, ring, {1 << i: mp.mpf(float(x)) for i, x in enumerate(v)})

    def number(x: Any) -> Multivector:
        return Multivector(cga3d, ring, {0: mp.mpf(x)})

    rows = []
    for two, origins, directions in zip(inputs.circles, inputs.origins, inputs.directions, strict=True):
        (c1, n1, r1), (c2, n2, r2) = two
        centre = (c1 + c2) / 2  # exact enough: any frame near the surface serves, the same for all that follows
        constants = evolved_constants(
            vector(c1) - vector(centre), vector(n1), number(r1), vector(c2) - vector(centre), vector(n2), number(r2)
        )
        frame = [c.value for c in constants[:4]]
        surface = constants[4].values
        for origin, direction in zip(origins, directions, strict=True):
            ray = evolved_ray(vector(origin) - vector(centre), vector(direction), *frame).values
            octic = [c.scalar() for c in evolved_octic(ray, surface).values]

            def condition(a: Any, ray: Any = ray, surface: Any = surface) -> Any:
                return evolved_condition(ray, surface, number(a), number(1 - a)).value.scalar()

            rows.append(sorted(1 - a for a in _roots(mp, octic, condition)))
    return rows


def _aligned(two: list[tuple[Array, Array, float]]) -> list[tuple[Array, Array, float]]:
    """The circles with the second turned round if they are oppositely oriented, as a surface would do itself."""
    from ... import cga3d

    middle = (two[0][0] + two[1][0]) / 2
    first, second = (cga3d.circle(center - middle, normal, radius) for center, normal, radius in two)
    if float(np.asarray(first.scalar_product(second).values).ravel()[0]) >= 0:
        return two
    center, normal, radius = two[1]
    return [two[0], (center, -normal, radius)]


def _roots(mp: Any, bernstein: list[Any], condition: Callable[[Any], Any]) -> list[Any]:
    """Real roots in [0, 1] of sum h_k a^k (1 - a)^(8 - k) that belong to the true projector."""
    degree = len(bernstein) - 1
    # in u = a/(1 - a), which maps (0, 1) to (0, inf), the coefficients are the polynomial's own
    scale = max(abs(h) for h in bernstein)
    powers = [h / scale for h in reversed(bernstein)]
    with mp.workdps(DIGITS):
        roots = mp.polyroots(powers, maxsteps=400, extraprec=400, error=False)
    found = []
    size = max(abs(condition(mp.mpf(k) / degree)) for k in range(degree + 1))
    for u in roots:
        if abs(mp.im(u)) < mp.mpf(10) ** -18 * (1 + abs(u)) and mp.re(u) >= 0:
            a = mp.re(u) / (1 + mp.re(u))
            if abs(condition(a)) < mp.mpf(10) ** -15 * size:
                found.append(a)
    return found


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
    circles = [f"({c.tolist()}, {n.tolist()}, {r!r})" for c, n, r in inputs.circles[surface]]
    origin, direction = inputs.origins[surface, ray], inputs.directions[surface, ray]
    return f"circles {circles[0]} {circles[1]}, origin {origin.tolist()}, direction {direction.tolist()}"


STUDY = Study(
    name="rays",
    title="Rays against surfaces evolved between two circles",
    methods=(
        Method("isolate", intersect("isolate"), "precision", ("float32", "float64")),
        Method("companion (as printed)", intersect("companion"), "precision", ("float64",)),
        Method("sampled (as printed)", intersect("sampled"), "samples", (8, 16, 32, 64, 128, 256, 512)),
    ),
    cases=(
        Case("tubes", rays(tube_pair), "ordinary", describe),
        Case("random circles", rays(random_pair), "ordinary", describe),
        Case("tubes, 1e4 from the origin", rays(tube_pair, 1e4), "stiff", describe),
        Case("nearly on a common sphere", rays(cospherical_pair), "extreme", describe),
    ),
    reference=truth,
    error=error,
    unit="curve parameter",
    count=300,
    copies=COPIES,
    source="thesis 4.5.1, corrected",
    notes="Lost: rays of which a hit is missing, or reported where there is none. Single precision rounds the surface "
    "and the rays themselves, and is compared with the exact answer of the unrounded ones.",
)
