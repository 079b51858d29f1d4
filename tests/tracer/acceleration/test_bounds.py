"""Bounds of surfaces hold every point, and little more: against objects of the curves themselves, densely sampled."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import numpy as np
import pytest

from bladesmith import cga3d, tracer
from bladesmith.codegen.algebra.multivector import Multivector, reciprocal, select, sqrt
from bladesmith.codegen.programs import cga3d as algebra
from bladesmith.codegen.programs.tracer.scene import needs
from bladesmith.codegen.programs.tracer.surface_kinds import surface_kind
from bladesmith.curves import Bezier
from bladesmith.tracer.acceleration.affine_arithmetic import AffineForm, AffineRing, polynomial
from bladesmith.tracer.acceleration.bounds import FAR, compute_bounds
from bladesmith.tracer.rendering.program import engine_for
from bladesmith.tracer.rendering.surface_tables import build_surface_tables
from bladesmith.tracer.surfaces.evolved import EvolvedSurface

RING = AffineRing()
#: A sampled surface reaches a little less far than the surface.
SAMPLES, ANGLES = 201, 48
#: Relative margin that bounds keep for rounding: points are told to far less.
NOISE = 1e-9


# -- the arithmetic ------------------------------------------------------------------------------------------


def scalar(enclosure: AffineForm) -> Multivector:
    return Multivector(algebra(), RING, {0: enclosure})


def exact_range(enclosure: AffineForm) -> tuple[float, float]:
    """Its ends; everything where nothing is known."""
    known = np.isfinite(enclosure.radius)
    return (float(enclosure.low), float(enclosure.high)) if known else (-np.inf, np.inf)


def functions(x, one):
    """What the tests run on enclosures and on numbers at 50 digits alike."""
    square = x * x + one / 3
    root = sqrt(square) if isinstance(x, Multivector) else mpmath.sqrt(square)
    over = reciprocal(root + x) if isinstance(x, Multivector) else 1 / (root + x)
    return [square - 2 * x, root * x - x / 7, over * over * x]


@pytest.mark.parametrize("width", [1e-12, 1e-3, 0.1, 1.0])
def test_enclosures_hold_every_value(width):
    mpmath.mp.dps = 50
    random = np.random.default_rng(1)
    for middle in random.normal(size=12) * 2:
        slope = float(width * random.choice([-1, 1]))
        with np.errstate(invalid="ignore"):  # infinity times zero: what is unknown stays so
            found = functions(scalar(AffineForm(np.float64(middle), np.float64(slope), np.float64(0.0))), 1)
        assert width > 0.1 or all(np.isfinite(y.scalar().radius) for y in found)
        for x in np.linspace(-1, 1, 41):
            exact = mpmath.mpf(float(middle)) + mpmath.mpf(slope) * mpmath.mpf(float(x))
            for value, enclosed in zip(functions(exact, mpmath.mpf(1)), found, strict=True):
                low, high = exact_range(enclosed.scalar())
                assert low <= value <= high


def test_enclosures_narrow_with_the_square_of_the_piece():
    errors = []
    for width in (0.1, 0.05, 0.025):
        found = functions(scalar(AffineForm(np.float64(0.7), np.float64(width), np.float64(0.0))), 1)
        errors.append(float(found[2].scalar().radius))
    assert errors[0] / errors[1] > 3.5 and errors[1] / errors[2] > 3.5


def test_what_cannot_be_told_is_unbounded_or_both():
    across = scalar(AffineForm(np.float64(0.1), np.float64(1.0), np.float64(0.0)))
    assert not np.isfinite(reciprocal(across).scalar().radius)
    either = select(across > 0, across + 5, across - 5).scalar()
    assert exact_range(either)[0] <= -5.9 and exact_range(either)[1] >= 6.1
    below = sqrt(scalar(AffineForm(np.float64(0.0), np.float64(1.0), np.float64(0.0)))).scalar()
    for y in np.linspace(0, 1, 21):
        assert exact_range(below)[0] <= np.sqrt(y) <= exact_range(below)[1]


@pytest.mark.parametrize("degree", [1, 2, 3, 7])
def test_polynomials_are_enclosed_over_pieces(degree):
    random = np.random.default_rng(degree)
    mpmath.mp.dps = 50
    coefficients = random.normal(size=(degree + 1, 30))
    begin = random.uniform(0, 1, 30)
    end = begin + (1 - begin) * random.uniform(0, 1, 30) ** 3
    found = polynomial(coefficients, begin, end)
    for i in range(30):
        given = [mpmath.mpf(float(c)) for c in coefficients[:, i]]
        for x in np.linspace(0, 1, 11):
            t = mpmath.mpf(float(begin[i])) + (mpmath.mpf(float(end[i])) - mpmath.mpf(float(begin[i]))) * float(x)
            value = sum(mpmath.binomial(degree, k) * t**k * (1 - t) ** (degree - k) * c for k, c in enumerate(given))
            assert found.low[i] <= value <= found.high[i]


# -- surfaces ------------------------------------------------------------------------------------------------


def bounds_of(surfaces):
    """Box of each row in the world, and centre and radius of the sphere of each; all of one kind."""
    kind = surface_kind(surfaces[0].program_kind)
    engine = engine_for(needs([kind.name], pictures=False))
    rows = build_surface_tables(engine, surfaces)[kind.name]
    bound = rows.constants[:, kind.slice("bound")]
    unit = rows.constants[:, kind.slice("unit")][:, :1]
    center = rows.constants[:, kind.slice("center")] + unit * bound[:, :3]
    return rows.boxes, center, np.where(bound[:, 3] < FAR, unit[:, 0] * np.minimum(bound[:, 3], 1e300), np.inf)


def circle_points(surface: EvolvedSurface, t=None) -> np.ndarray:
    """Points of the surface's circles, from the curve itself: none of the tracer's formulas."""
    t = np.linspace(0, 1, SAMPLES) if t is None else t
    parts = surface.curve(t).parameters()
    normal = np.asarray(parts.normal)
    helper = np.eye(3)[np.argmin(np.abs(normal), axis=-1)]
    u = np.cross(normal, helper)
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    v = np.cross(normal, u)
    angle = np.linspace(0, 2 * np.pi, ANGLES, endpoint=False)[:, None]
    across = np.cos(angle) * u[:, None] + np.sin(angle) * v[:, None]
    return np.asarray(parts.center)[:, None] + np.asarray(parts.radius)[:, None, None] * across


def random_circles(random, count, degree, spread, tilt, scale=1.0):
    """Surfaces along Bezier curves, parts with imaginary circles left out."""
    made = []
    for _ in range(count):
        centers = np.cumsum(random.normal(size=(degree + 1, 3)) * spread, axis=0) * scale
        normals = np.array([0, 0, 1]) + tilt * random.normal(size=(degree + 1, 3))
        radii = random.uniform(0.2, 1.0, degree + 1) * scale
        controls = list(zip(centers, normals, radii, strict=True))
        made.append(tracer.EvolvedCircles(Bezier(controls), gaps=True))
    return made


def is_held(points, box, center, radius):
    size = np.max(np.abs(points)) + radius
    low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    inside = np.all(low >= box[:3] - NOISE * size) and np.all(high <= box[3:] + NOISE * size)
    return inside and np.max(np.linalg.norm(points - center, axis=-1)) <= radius + NOISE * size


@pytest.mark.slow
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_bounds_hold_every_point_and_little_more(degree):
    random = np.random.default_rng(degree)
    surfaces = random_circles(random, 60, degree, 0.6, 0.25) + random_circles(random, 60, degree, 2.0, 0.8, 30.0)
    boxes, centers, radii = bounds_of(surfaces)
    ratios = []
    for surface, box, center, radius in zip(surfaces, boxes, centers, radii, strict=True):
        points = circle_points(surface)
        points = points[np.isfinite(points).all(axis=(1, 2))]
        assert is_held(points, box, center, radius)
        if len(points) == SAMPLES and np.isfinite(radius):
            ratios.append(radius / np.max(np.linalg.norm(points - center, axis=-1)))
    assert len(ratios) > 40
    assert np.median(ratios) < 1.05 and np.percentile(ratios, 90) < 1.25


@pytest.mark.compiles
def test_bounds_of_point_pairs_hold_their_segments():
    if not hasattr(tracer, "EvolvedPointPairs"):
        from bladesmith.tracer.surfaces.evolved import EvolvedPointPairs
    else:
        EvolvedPointPairs = tracer.EvolvedPointPairs
    random = np.random.default_rng(7)
    for degree in (1, 2):
        surfaces = []
        for _ in range(60):
            first = np.cumsum(random.normal(size=(degree + 1, 3)), axis=0)
            second = first + np.array([1.0, 0.2, 0.1]) + 0.3 * random.normal(size=(degree + 1, 3))
            surfaces.append(EvolvedPointPairs(list(zip(first, second, strict=True)), gaps=True))
        boxes, centers, radii = bounds_of(surfaces)
        for surface, box, center, radius in zip(surfaces, boxes, centers, radii, strict=True):
            ends = surface.curve(np.linspace(0, 1, SAMPLES)).parameters()
            points = np.stack([np.asarray(ends[0]), np.asarray(ends[1])], axis=1)
            points = points[np.isfinite(points).all(axis=(1, 2))]
            assert is_held(points, box, center, radius)


def test_a_million_away_the_frame_keeps_bounds_tight():
    tube = [((0, 0, 0), (0, 0, 1), 1.0), ((0, 1, 2), (0, 0.5, 1), 0.6)]
    near = tracer.EvolvedCircles(Bezier(tube))
    shift = np.array([1e6, -2e6, 3e6])
    far = tracer.EvolvedCircles(Bezier([(np.add(c, shift), n, r) for c, n, r in tube]))
    (box,), (center,), (radius,) = bounds_of([near])
    (far_box,), (far_center,), (far_radius,) = bounds_of([far])
    assert far_radius == pytest.approx(radius, rel=1e-6)
    np.testing.assert_allclose(far_center - shift, center, atol=1e-6)
    np.testing.assert_allclose(far_box - np.tile(shift, 2), box, atol=1e-6)


def test_circles_that_open_into_a_line_are_unbounded():
    """Two circles of one plane and one radius that turn against each other pass through a line between them."""
    first, second = ((-1.0, 0, 0), (0, 0, 1), 1.0), ((1.0, 0, 0), (0, 0, -1), 1.0)
    surface = tracer.EvolvedCircles([first, second], align=False, gaps=True)
    assert np.max(surface.curve(np.linspace(0, 1, 2001)).parameters().radius) > 1e3
    boxes, _, radii = bounds_of([surface])
    assert np.isinf(radii).all() and np.isinf(boxes).all()


def test_boxes_of_plain_surfaces():
    random = np.random.default_rng(4)
    angle = np.linspace(0, 2 * np.pi, 721)
    for scale, shift in ((1.0, 0.0), (1e-3, 0.0), (1.0, 1e6)):
        centers, normals = random.normal(size=(2, 40, 3))
        normals[0], normals[1] = (0, 0, 1), (1e-9, 0, 1)
        centers = centers * scale + shift
        discs = [tracer.Disc(c, n, 0.4 * scale) for c, n in zip(centers, normals, strict=True)]
        _, boxes = compute_bounds(surface_kind("disc"), np.concatenate([d.parameters for d in discs]))
        for disc, box in zip(discs, boxes, strict=True):
            helper = np.eye(3)[np.argmin(np.abs(disc.normal))]
            u = np.cross(disc.normal, helper) / np.linalg.norm(np.cross(disc.normal, helper))
            v = np.cross(disc.normal, u)
            rim = 0.4 * scale * (np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v) + disc.center
            slack = 4e-16 * (abs(shift) + scale)
            assert np.all(rim.min(axis=0) >= box[:3] - slack) and np.all(rim.max(axis=0) <= box[3:] + slack)
            assert np.all(box[3:] - box[:3] <= 0.81 * scale + 1e-9)
        spheres = np.concatenate([centers, np.full((40, 1), 0.3 * scale)], axis=1)
        _, boxes = compute_bounds(surface_kind("sphere"), spheres)
        for row, box in zip(spheres, boxes, strict=True):
            for i in range(3):
                assert Fraction(box[i]) <= Fraction(row[i]) - Fraction(row[3])
                assert Fraction(box[3 + i]) >= Fraction(row[i]) + Fraction(row[3])
    _, boxes = compute_bounds(surface_kind("plane"), np.ones((2, 4)))
    assert np.all(np.isinf(boxes))
    assert compute_bounds(surface_kind("sphere"), np.zeros((0, 4)))[1].shape == (0, 6)


def test_circles_of_the_algebra_are_bounded_like_their_parameters():
    tube = [((0, 0, 0), (0, 0, 1), 1.0), ((0, 1, 2), (0, 0.5, 1), 0.6)]
    plain, given = tracer.EvolvedCircles(tube), tracer.EvolvedCircles(Bezier([cga3d.circle(*c) for c in tube]))
    np.testing.assert_allclose(bounds_of([plain])[0], bounds_of([given])[0], atol=1e-6)
