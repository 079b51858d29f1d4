"""Rays against surfaces evolved between circles: no root lost, none false, and where plain geometry says."""

from __future__ import annotations

from collections import namedtuple
from math import comb

import mpmath
import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.formulas.objects.blades import blade_projector
from bladesmith.codegen.programs import cga3d
from bladesmith.codegen.programs.tracer.scene import needs
from bladesmith.codegen.programs.tracer.surface_kinds import surface_kind
from bladesmith.codegen.rings.protocol import NumericRing, PrecisionRing
from bladesmith.core.registry import stock_algebra
from bladesmith.curves import Bezier, Interpolating, KochanekBartels, RationalBezier
from bladesmith.status import Status
from bladesmith.tracer.rendering.program import engine_for
from bladesmith.tracer.rendering.surface_tables import build_surface_tables

from ....support.tracer.scenes import TUBE


def random_surfaces(count, seed, degree=1):
    """Between any two circles; of higher degree along tubes, so that they stay real."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        axis = random.normal(size=3)
        spread = 0.4 if degree > 1 else 1.0
        controls = [
            (
                (degree > 1) * k * axis * 0.5 + spread * random.normal(size=3),
                (degree > 1) * axis + spread * random.normal(size=3),
                random.uniform(0.4, 1.2) if degree > 1 else random.uniform(0.2, 1.5),
            )
            for k in range(degree + 1)
        ]
        yield tracer.EvolvedCircles(Bezier(controls), align=True, gaps=degree > 1)


Circle = namedtuple("Circle", "center normal radius")


def controls_of(surface):
    """The circles that were given, flipped where the surface says so."""
    turns = np.where(surface.flipped, -1.0, 1.0)
    return [
        Circle(np.asarray(c, float), turn * np.asarray(n, float) / np.linalg.norm(n), float(r))
        for (c, n, r), turn in zip(surface.segments.source.original_controls, turns, strict=True)
    ]


class Geometry:
    """The surface as it is defined: C' = a C1 + b C2 projected to a circle, on any ring; nothing of the tracer's."""

    def __init__(self, surface, ring, number=float):
        self.ring = ring
        self.like = from_values(cga3d(), ring, (0,), [number(1)])
        self.circles = [self._circle(c, number) for c in controls_of(surface)]

    def scalar(self, x):
        return from_values(cga3d(), self.ring, (0,), [x])

    def vector(self, x):
        return from_values(cga3d(), self.ring, (1, 2, 4), list(x))

    def up(self, x):
        square = self.scalar(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
        return self.vector(x) + square / 2 * self.like.basis("ni") + self.like.basis("no")

    def _circle(self, circle, number):
        """C = A ^ B ^ C through three points, normalised."""
        c, n, r = ([number(v) for v in circle.center], [number(v) for v in circle.normal], number(circle.radius))
        length = (n[0] ** 2 + n[1] ** 2 + n[2] ** 2) ** (number(1) / 2)
        n = [x / length for x in n]
        least = min(range(3), key=lambda i: abs(n[i]))
        u = [number(i == least) for i in range(3)]
        u = [n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]]
        length = (u[0] ** 2 + u[1] ** 2 + u[2] ** 2) ** (number(1) / 2)
        u = [x / length for x in u]
        v = [n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]]
        points = [
            self.up([c[i] + r * (cos * u[i] + sin * v[i]) for i in range(3)]) for cos, sin in ((1, 0), (0, 1), (-1, 0))
        ]
        blade = points[0] ^ points[1] ^ points[2]
        norm = (blade * blade).grade(0).scalar() ** (number(1) / 2)
        return blade * self.scalar(1 / norm)

    def circle(self, a):
        """The circle of weight a = 1 - t of the first end."""
        n = len(self.circles) - 1
        parts = (
            self.scalar(comb(n, k) * a ** (n - k) * (1 - a) ** k) * circle for k, circle in enumerate(self.circles)
        )
        mixed = self.scalar(0 * a).sum(parts)
        return (blade_projector(mixed) * mixed).grade(3)

    def parameters(self, a):
        """Centre, normal, which is not of unit length, and radius."""
        circle = self.circle(a)
        ni = circle.basis("ni")
        image = (circle * ni * circle).grade(1)
        weight = -image.scalar_product(ni).scalar()
        center = [image[n].scalar() / weight for n in ("e1", "e2", "e3")]
        plane = (circle ^ ni).dual()
        normal = [plane[n].scalar() for n in ("e1", "e2", "e3")]
        return center, normal, 1 / (normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2) ** (a * 0 + 1 / 2)

    def meet(self, origin, direction, a):
        """(L v C), a vector, and its square."""
        line = self.up(origin) ^ self.vector(direction) ^ self.like.basis("ni")
        y = (line & self.circle(a)).grade(1)
        return y, y.scalar_product(y).scalar()


def reference_roots(surface, origin, direction):
    """(t, point) of every sign change of f on a fine grid, refined at 40 digits."""
    numeric = Geometry(surface, NumericRing())
    grid = np.linspace(0, 1, 4001)
    with np.errstate(all="ignore"):
        _, f = numeric.meet(origin, direction, grid)
    ring = PrecisionRing(40)
    number = ring.context.mpf
    precise = Geometry(surface, ring, lambda x: number(x))
    o, d = ([number(float(x)) for x in v] for v in (origin, direction))
    roots = []
    for i in np.nonzero((f[:-1] < 0) != (f[1:] < 0))[0]:
        bracket = (number(grid[i]), number(grid[i + 1]))
        a = ring.context.findroot(
            lambda a: precise.meet(o, d, a)[1], bracket, solver="anderson", tol=1e-60, verify=False, maxsteps=40
        )
        y, _ = precise.meet(o, d, a)
        weight = -y.scalar_product(y.basis("ni")).scalar()
        roots.append((float(1 - a), [float(y[name].scalar() / weight) for name in ("e1", "e2", "e3")]))
    return sorted(roots)


@pytest.mark.slow
@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_every_root_is_found_and_none_is_false(degree):
    random = np.random.default_rng(5)
    total = 0
    for surface in random_surfaces(3, 11, degree):
        middle = points_on(surface, np.array([0.5]), np.array([0.0]))[0] if degree > 1 else np.zeros(3)
        origins = middle + random.normal(size=(12, 3)) * 3
        directions = middle + random.normal(size=(12, 3)) * 0.6 - origins
        found = surface.intersect(origins, directions)
        for i in range(12):
            expected = reference_roots(surface, origins[i], directions[i])
            order = np.argsort(found.alpha[i, : found.count[i]])
            assert len(expected) == found.count[i], (controls_of(surface), origins[i], directions[i])
            for (alpha, point), j in zip(expected, order, strict=True):
                assert abs(found.alpha[i, j] - alpha) < 1e-10
                np.testing.assert_allclose(found.point[i, j], point, atol=1e-9)
            total += len(expected)
    assert total > 20


def precise_normal(surface, alpha, point):
    """At 50 digits: across the circle through the point, and from it to the circles beside it."""
    ring = PrecisionRing(50)
    number = ring.context.mpf
    geometry = Geometry(surface, ring, number)
    step = number(10) ** -16

    def at(a):
        center, normal, radius = geometry.parameters(a)
        return np.array(center), np.array(normal) * radius, radius

    center, axis, radius = at(1 - number(alpha))
    away = np.array([number(float(x)) for x in point]) - center
    away -= axis * (axis @ away)
    away *= radius / (away @ away) ** (number(1) / 2)

    def beside(shift):  # the point of another circle in the plane through its own axis and the given point
        other, turned, size = at(1 - number(alpha) + shift)
        flat = away - turned * (turned @ away)
        return other + flat * (size / (flat @ flat) ** (number(1) / 2))

    normal = np.cross(np.cross(axis, away), beside(step) - beside(-step))
    return normal / (normal @ normal) ** (number(1) / 2)


@pytest.mark.slow
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_normals_at_fifty_digits(degree):
    """1 - |cos| is the square of half the angle: taken from the angle, it keeps its digits."""
    random = np.random.default_rng(degree)
    seen = 0
    for surface in random_surfaces(3, 71, degree):
        targets = points_on(surface, random.uniform(0.05, 0.95, size=4), random.uniform(0, 6, size=4))
        found = surface.intersect(targets + (3, 2, 4), -np.array([3.0, 2, 4]))
        for i, j in zip(*np.nonzero(~np.isnan(found.t)), strict=True):
            expected = precise_normal(surface, found.alpha[i, j], found.point[i, j])
            across = np.cross(expected, found.normal[i, j])
            assert float(across @ across) / 2 < 1e-12, (surface.segments.source, found.alpha[i, j], found.point[i, j])
            seen += 1
    assert seen >= 12


def circles_of(surface, alphas):
    """Centres, unit normals and radii of the surface's circles, from their own geometry."""
    center, normal, _ = Geometry(surface, NumericRing()).parameters(1 - alphas)
    center, normal = np.stack(center, -1), np.stack(normal, -1)
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    return center, normal / size, 1 / size


def points_on(surface, alphas, angles):
    """Points of the surface's circles."""
    center, normal, radius = circles_of(surface, alphas)
    u = np.cross(normal, np.where(np.abs(normal[:, :1]) < 0.9, [1.0, 0, 0], [0, 1.0, 0]))
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    v = np.cross(normal, u)
    return center + radius * (np.cos(angles)[:, None] * u + np.sin(angles)[:, None] * v)


@pytest.mark.parametrize("seed", range(4))
def test_rays_to_points_of_the_surface_find_them(seed):
    """Brute force: also proves that the bounding sphere cuts nothing off."""
    random = np.random.default_rng(seed)
    for surface in random_surfaces(6, seed):
        alphas, angles = random.uniform(size=800), random.uniform(0, 2 * np.pi, size=800)
        targets = points_on(surface, alphas, angles)
        size = np.linalg.norm(targets - controls_of(surface)[0].center, axis=1).max()
        directions = random.normal(size=(800, 3))
        origins = targets - 3 * size * directions
        found = surface.intersect(origins, directions)
        assert found.count.min() >= 1, origins[np.argmin(found.count)]
        miss = np.linalg.norm(found.point - targets[:, None], axis=-1)
        best = np.nanargmin(miss, axis=1)
        worst = np.nanmin(miss, axis=1)
        facing = np.einsum("ijk,ik->ij", found.normal, directions)[np.arange(800), best]
        grazing = np.abs(facing) / np.linalg.norm(directions, axis=1)  # a grazing ray loses digits by itself
        assert np.all(worst < 1e-11 * size / np.maximum(grazing, 1e-6)), origins[np.argmax(worst * grazing)]
        near = np.abs(found.alpha[np.arange(800), best] - alphas)
        assert np.all(near < 1e-9 / np.maximum(grazing, 1e-6))


def constants_of(surface):
    engine = engine_for(needs([surface.program_kind], pictures=False))
    (row,) = build_surface_tables(engine, [surface])[surface.program_kind].constants
    return row


def test_bounding_spheres_hold_the_surface_tightly():
    random = np.random.default_rng(8)
    for surface in random_surfaces(20, seed=3):
        row = constants_of(surface)
        center, unit = surface.segments.center[0], surface.segments.size[0]
        x, y, z, radius = row[surface_kind("evolved_circles_1").slice("bound")]
        points = points_on(surface, random.uniform(size=2000), random.uniform(0, 2 * np.pi, size=2000))
        reach = np.linalg.norm((points - center) / unit - (x, y, z), axis=1).max()
        assert reach < radius < 2.5 * reach


def through_one_point(random):
    """Two circles with one point in common: K = 0, and Q is not."""
    shared, controls = random.normal(size=3), []
    for _ in range(2):
        spoke, other = random.normal(size=(2, 3))
        controls.append((shared + spoke, np.cross(spoke, other), float(np.linalg.norm(spoke))))
    return tracer.EvolvedCircles(Bezier(controls))


@pytest.mark.slow
def test_circles_that_share_a_point():
    random = np.random.default_rng(61)
    total = 0
    for _ in range(3):
        surface = through_one_point(random)
        row = constants_of(surface)
        kind = surface_kind("evolved_circles_1")
        (kappa,) = row[kind.slice("kappa")]
        assert abs(kappa) < 1e-13 and np.abs(row[kind.slice("products")]).max() > 0.05
        middle = surface.segments.center[0]
        origins = middle + random.normal(size=(6, 3)) * 3
        directions = middle + random.normal(size=(6, 3)) - origins
        found = surface.intersect(origins, directions)
        for i in range(6):
            expected = reference_roots(surface, origins[i], directions[i])
            alpha = np.sort(found.alpha[i, : found.count[i]])
            np.testing.assert_allclose(alpha, [a for a, _ in expected], rtol=0, atol=1e-11)
            total += len(alpha)
    assert total > 6


@pytest.mark.parametrize("degree", [2, 3])
def test_rays_in_the_plane_of_a_circle_along_curves(degree):
    """Both points on the circle of the root, exactly there."""
    random = np.random.default_rng(degree)
    for surface in random_surfaces(3, 43, degree):
        alphas = random.uniform(0.1, 0.9, size=12)
        center, normal, radius = circles_of(surface, alphas)
        across = np.cross(normal, random.normal(size=(12, 3)))
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        for offset, hits in ((0.4, 2), (1.4, 0)):
            origins = center + radius * (offset * np.cross(normal, across) - 3 * across)
            found = surface.intersect(origins, across)
            flat = np.abs(found.alpha - alphas[:, None]) < 1e-11
            assert np.all(flat.sum(axis=1) == hits)
            away = np.linalg.norm(found.point - center[:, None], axis=-1) - radius
            assert not np.any(np.abs(away[flat]) > 1e-10)


@pytest.mark.parametrize("degree", [2, 3])
def test_curves_of_circles_on_a_common_sphere(degree):
    """Hits are points of the sphere, once for each change of side of the circle's plane."""
    random = np.random.default_rng(degree)
    alphas, seen = np.linspace(0, 1, 2001), 0
    for _ in range(3):
        normals = np.array([0, 0, 1.0]) + 0.3 * random.normal(size=(degree + 1, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        heights = np.linspace(-0.7, 0.7, degree + 1)
        controls = [(h * n, n, np.sqrt(1 - h * h)) for h, n in zip(heights, normals, strict=True)]
        surface = tracer.EvolvedCircles(Bezier(controls))
        center, normal, _ = circles_of(surface, alphas)
        origins = random.normal(size=(60, 3)) * 3
        directions = random.normal(size=(60, 3)) * 0.4 - origins
        found, sphere = (
            surface.intersect(origins, directions),
            tracer.Sphere((0, 0, 0), 1.0).intersect(origins, directions),
        )
        for i in range(60):
            side = np.einsum("kj,ikj->ik", normal, sphere.point[i, : sphere.count[i], None] - center)
            changes = alphas[:-1][np.nonzero(side[:, :-1] * side[:, 1:] < 0)[1]]
            alpha = np.sort(found.alpha[i, : found.count[i]])
            assert len(alpha) == len(changes)
            assert np.all(np.abs(alpha - np.sort(changes) - 2.5e-4) < 2.6e-4)
            seen += len(alpha)
        hit = ~np.isnan(found.t)
        np.testing.assert_allclose(np.linalg.norm(found.point[hit], axis=-1), 1.0, atol=1e-11)
    assert seen > 60


TILTS = [0.0, 1e-15, 1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4, 1e-3, 0.0099, 0.0101]


@pytest.mark.slow
@pytest.mark.parametrize("tilt", TILTS)
def test_rays_in_and_near_the_plane_of_a_circle(tilt):
    """The meet vanishes there; both points on the circle are found, and beside the circle none is invented."""
    random = np.random.default_rng(10)
    for surface in random_surfaces(8, seed=41):
        alphas = random.uniform(0.1, 0.9, size=30)
        center, normal, radius = circles_of(surface, alphas)
        across = np.cross(normal, random.normal(size=(30, 3)))
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        beside = np.cross(normal, across)
        for offset, least in ((0.4, 2), (1.5, 0)):
            middle = center + offset * radius * beside
            directions = across + tilt * normal
            found = surface.intersect(middle - 3 * radius * directions, directions)
            if tilt <= 1e-9:
                flat = np.abs(found.alpha - alphas[:, None]) < 1e-12 + 1e4 * tilt
                assert np.all(flat.sum(axis=1) == least), tilt
            used, k = np.nonzero(~np.isnan(found.alpha))
            c, n, r = circles_of(surface, found.alpha[used, k])
            away = found.point[used, k] - c
            scale = np.maximum(r[:, 0], np.linalg.norm(away, axis=1))
            assert np.all(np.abs(np.einsum("ij,ij->i", away, n)) < 1e-8 * scale)
            assert np.all(np.abs(np.linalg.norm(away, axis=1) - r[:, 0]) < 1e-7 * scale)


def test_circles_on_a_common_sphere_sweep_that_sphere():
    """M4 = 0, where the polynomial of degree 8 vanishes identically."""
    surface = tracer.EvolvedCircles(Bezier([((0, 0, 0.6), (0, 0, 1), 0.8), ((0, 0, -0.6), (0, 0, 1), 0.8)]))
    random = np.random.default_rng(6)
    origins = random.normal(size=(400, 3)) * 3
    directions = random.normal(size=(400, 3)) * 0.5 - origins
    found = surface.intersect(origins, directions)
    some = ~np.isnan(found.t)
    np.testing.assert_allclose(np.linalg.norm(found.point[some], axis=-1), 1.0, atol=1e-9)
    sphere = tracer.Sphere((0, 0, 0), 1.0).intersect(origins, directions)
    band = np.abs(sphere.point[..., 2]) < 0.6
    np.testing.assert_array_equal(found.count, band.sum(axis=1))
    np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", found.point[some], found.normal[some])), 1.0, atol=1e-7)


def test_normals_equal_differences_between_neighbouring_points():
    random = np.random.default_rng(7)
    step = 1e-5
    for surface in random_surfaces(4, seed=21):
        alphas, angles = random.uniform(0.05, 0.95, size=100), random.uniform(0, 2 * np.pi, size=100)
        along = points_on(surface, alphas, angles + step) - points_on(surface, alphas, angles - step)
        across = points_on(surface, alphas + step, angles) - points_on(surface, alphas - step, angles)
        normals = np.cross(along, across)
        length = np.linalg.norm(normals, axis=1)
        fine = length > 1e-3 * np.linalg.norm(along, axis=1) * np.linalg.norm(across, axis=1)
        normals /= length[:, None]
        targets = points_on(surface, alphas, angles)
        found = surface.intersect(targets - normals, normals)
        j = np.nanargmin(np.linalg.norm(found.point - targets[:, None], axis=-1), axis=1)
        cosine = np.abs(np.einsum("ij,ij->i", found.normal[np.arange(100), j], normals))
        assert np.all(cosine[fine] > 1 - 1e-8)


def test_the_ends_belong_to_the_surface():
    surface = tracer.EvolvedCircles(Bezier(TUBE))
    angles = np.linspace(0, 6, 20)
    for alpha in (0.0, 1.0):
        targets = points_on(surface, np.full(20, alpha), angles)
        for target in targets:
            found = surface.intersect((0.3, 0.4, 7.0), target - (0.3, 0.4, 7.0))
            assert np.all((found.alpha[: found.count] >= 0) & (found.alpha[: found.count] <= 1))


def test_far_away_the_surface_is_the_same():
    random = np.random.default_rng(9)
    near = tracer.EvolvedCircles(Bezier(TUBE))
    shift = np.array([1e6, -2e6, 5e5])
    far = tracer.EvolvedCircles(Bezier([(np.add(c, shift), n, r) for c, n, r in TUBE]))
    origins = random.normal(size=(300, 3)) * 3
    directions = random.normal(size=(300, 3)) * 0.4 - origins
    moved = origins + shift
    a, b = near.intersect(moved - shift, directions), far.intersect(moved, directions)
    np.testing.assert_array_equal(a.count, b.count)
    np.testing.assert_allclose(a.alpha, b.alpha, atol=1e-9)
    np.testing.assert_allclose(b.point - shift, a.point, atol=2e-9)


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 1e-3, 0.3])
def test_rays_from_far_away_meet_it_too(tilt):
    """Also near the plane of a circle, where points are found by steps that must settle."""
    random = np.random.default_rng(15)
    for surface in random_surfaces(5, seed=51):
        center, normal, radius = circles_of(surface, random.uniform(0.2, 0.8, size=20))
        across = np.cross(normal, random.normal(size=(20, 3)))
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        middle = center + 0.3 * radius * np.cross(normal, across)
        directions = across + tilt * normal
        near = surface.intersect(middle - 3 * radius * directions, directions)
        for distance in (1e3, 1e6):
            far = surface.intersect(middle - distance * directions, directions)
            assert np.all(far.count[near.count == 2] >= 1)
            same = far.count == near.count
            assert same.mean() > 0.9
            width = near.point.shape[1]
            miss = np.abs(far.point[same][:, :width] - near.point[same])
            assert np.nanmedian(miss) < 1e-12 * distance


def test_opposed_circles_are_turned_over_and_it_is_said(caplog):
    circles = [((0, 0, 0), (0, 0, 1), 1.0), ((0, 0, 0.5), (0, 0, -1), 1.0)]
    with caplog.at_level("WARNING", "bladesmith"):
        surface = tracer.EvolvedCircles(Bezier(circles), align=True)
    assert surface.flipped.tolist() == [False, True] and "orientation reversed" in caplog.text
    assert not tracer.EvolvedCircles(Bezier(TUBE), align=True).flipped.any()


def test_surfaces_follow_the_curve_through_their_controls():
    """Opposed or not, with and without align: one default for both."""
    random = np.random.default_rng(8)
    t = np.linspace(0, 1, 21)
    for _ in range(20):
        circles = [(3 * k * np.eye(3)[2] + random.normal(size=3), random.normal(size=3), 1.0) for k in range(4)]
        for options in ({}, {"align": False}, {"align": True}):
            for make in (Bezier, KochanekBartels, lambda x, **o: RationalBezier(x, [1, 2, 2, 1], **o)):
                curve = make(circles, **options)
                for followed in (curve, *([circles] if make is Bezier else [])):
                    surface = tracer.EvolvedCircles(followed, gaps=True, **options)
                    assert np.array_equal(surface.flipped, curve.flipped)
                    at = t * curve.segments
                    assert np.array_equal(surface.curve(at).status, curve(at).status)
                    assert np.array_equal(surface.curve(at).values, curve(at).values, equal_nan=True)


def test_files_turn_opposing_controls_over_unless_they_say_otherwise(tmp_path):
    text = """
[camera]
position = [0.0, -8.0, 2.0]
look_at = [0.0, 0.0, 0.0]

[[surfaces]]
kind = "evolved_circles"
controls = [
    { center = [0, 0, 0], normal = [0, 0, 1], radius = 1.0 },
    { center = [0, 0, 2], normal = [0, 0, -1], radius = 1.0 },
]
"""
    for option, turned in (("", True), ("align = true\n", True), ("align = false\ngaps = true\n", False)):
        path = tmp_path / "scene.toml"
        path.write_text(text + option)
        assert tracer.Scene.load(path).surfaces[0].flipped.tolist() == [False, turned]


def test_opposition_is_the_sign_of_the_scalar_part():
    for surface in random_surfaces(40, seed=31):
        first, second = Geometry(surface, NumericRing()).circles
        assert (first * second).grade(0).scalar() >= 0


def test_a_ray_in_the_surface_is_singular():
    """Circles of one plane sweep a flat ring; a ray in that plane meets all of them."""
    ring = tracer.EvolvedCircles(Bezier([((0, 0, 0), (0, 0, 1), 1.0), ((0.2, 0, 0), (0, 0, 1), 0.5)]))
    found = ring.intersect([(0.75, 0, 3), (-3, 0, 0)], [(0, 0, -1), (1, 0, 0)])
    assert found.count.tolist() == [1, 0]
    assert found.status.tolist() == [Status.OK, Status.SINGULAR]
    assert found.t[0, 0] == pytest.approx(3.0) and abs(found.normal[0, 0, 2]) == pytest.approx(1.0)


@pytest.mark.compiles
def test_methods_agree_where_they_find_roots():
    surface = tracer.EvolvedCircles(Bezier(TUBE))
    random = np.random.default_rng(12)
    origins = random.normal(size=(1500, 3)) * 3
    directions = random.normal(size=(1500, 3)) * 0.5 - origins
    isolate = surface.intersect(origins, directions)
    sampled = surface.intersect(origins, directions, method="sampled", samples=500)
    companion = surface.intersect(origins, directions, method="companion")
    same = isolate.count == sampled.count
    assert same.mean() > 0.97 and np.all(sampled.count <= isolate.count)
    np.testing.assert_allclose(sampled.alpha[same], isolate.alpha[same], atol=1e-3)
    assert np.mean(companion.count == isolate.count) > 0.7


def answers_of_both_precisions(ask, origins, directions):
    """What rays of single precision are answered, and the same rays written in double."""
    rays = origins.astype(np.float32), directions.astype(np.float32)
    return ask(*rays), ask(*(x.astype(np.float64) for x in rays))


@pytest.mark.compiles
@pytest.mark.parametrize("kind", ["circles", "point pairs"])
def test_rays_of_single_precision_have_the_roots_of_double(kind):
    """Whatever the precision of the rays, the work is done in double: every root, none false, then one rounding."""
    random = np.random.default_rng(12)
    pairs = [((-1.0, 0.0, 0.2), (1.0, 0.3, 0.0)), ((-0.8, 0.9, 0.9), (0.9, 1.4, 0.3))]
    surface = tracer.EvolvedCircles(TUBE) if kind == "circles" else tracer.EvolvedPointPairs(pairs)
    origins = random.normal(size=(2000, 3)) * 3
    directions = random.normal(size=(2000, 3)) * 0.5 - origins
    single, double = answers_of_both_precisions(surface.intersect, origins, directions)
    assert single.t.dtype == np.float32 and double.count.sum() > 300
    for name in ("count", "row", "status", "t", "alpha", "point", "normal"):
        want = getattr(double, name)
        np.testing.assert_array_equal(getattr(single, name), want.astype(getattr(single, name).dtype))
    scene = tracer.Scene(tracer.Camera.look_at((0, -5, 1), (0, 0, 0)), [], [surface, tracer.Sphere((1, 1, 1), 0.5)])
    single, double = answers_of_both_precisions(scene.intersect, origins, directions)
    assert single.t.dtype == np.float32
    for name in ("surface", "status", "t", "alpha", "point", "normal"):
        want = getattr(double, name)
        np.testing.assert_array_equal(getattr(single, name), want.astype(getattr(single, name).dtype))
    picture = scene.render(24, 16, dtype=np.float32)
    assert picture.dtype == np.float32
    np.testing.assert_array_equal(picture, scene.render(24, 16).astype(np.float32))


def test_exact_arithmetic_of_the_oracle():
    """The oracle itself: a circle through three points is where it was put."""
    mpmath.mp.dps = 30
    surface = tracer.EvolvedCircles(Bezier(TUBE))
    points = points_on(surface, np.zeros(5), np.linspace(0, 5, 5))
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(points[:, 2], 0.0, atol=1e-12)


def tube_controls(random, count):
    axis = np.array([0.2, -0.1, 1.0])
    return [
        (0.8 * k * axis + 0.25 * random.normal(size=3), axis + 0.25 * random.normal(size=3), random.uniform(0.5, 1.0))
        for k in range(count)
    ]


CURVES = {
    "kochanek_bartels": lambda c: KochanekBartels(c),
    "rational": lambda c: RationalBezier(c, weights=[1.0, 2.0, 0.5, 1.0]),
    "interpolating": lambda c: Interpolating(c, [0, 1, 2, 3]),
    "quadratic": lambda c: Interpolating(c[:3], [0, 0.5, 1], degree=2),
    "coefficients": lambda c: [np.ravel(stock_algebra("cga3d").circle(*x).values) for x in c],
}


@pytest.mark.parametrize("name", CURVES)
def test_curves_of_every_class(name):
    """Changes of sign of (L v C)^2 by the public algebra on the public curve, where no two roots are close."""
    random = np.random.default_rng(17)
    surface = tracer.EvolvedCircles(CURVES[name](tube_controls(random, 4)))
    curve, cga = surface.curve, stock_algebra("cga3d")
    start, end = (curve.breaks[0], curve.breaks[-1]) if hasattr(curve, "breaks") else (0.0, 1.0)
    alphas = np.linspace(start, end, 1501)
    circles = curve(alphas)
    origins = random.normal(size=(60, 3)) * 3 + (0, 0, 1)
    directions = random.normal(size=(60, 3)) * 0.6 + (0, 0, 1) - origins
    found = surface.intersect(origins, directions)
    seen = 0
    for i in range(60):
        meet = cga.line(origins[i], directions[i]) & circles
        f = (meet * meet).grade(0).values.ravel()
        changes = alphas[:-1][(f[:-1] < 0) != (f[1:] < 0)]
        alpha = np.sort(found.alpha[i, : found.count[i]])
        if len(alpha) > 1 and np.diff(alpha).min() < 2 * (alphas[1] - alphas[0]):
            continue
        assert len(alpha) == len(changes), (i, alpha, changes)
        assert np.all((alpha >= changes - 1e-12) & (alpha <= changes + alphas[1] - alphas[0] + 1e-12))
        seen += len(alpha)
    assert seen > 40
    some = ~np.isnan(found.alpha)
    held = curve(found.alpha[some])
    residual = np.linalg.norm((cga.point(found.point[some]) ^ held).values, axis=-1)
    reach = 1 + np.sum(found.point[some] ** 2, axis=-1)
    assert np.all(residual < 1e-12 * reach * np.linalg.norm(held.values, axis=-1))
    single, double = answers_of_both_precisions(surface.intersect, origins, directions)
    np.testing.assert_array_equal(single.count, double.count)


@pytest.mark.compiles
def test_both_printed_methods_at_degree_two():
    (surface,) = random_surfaces(1, 91, 2)
    random = np.random.default_rng(19)
    middle = points_on(surface, np.array([0.5]), np.array([0.0]))[0]
    origins = middle + random.normal(size=(300, 3)) * 3
    directions = middle + random.normal(size=(300, 3)) * 0.5 - origins
    isolate = surface.intersect(origins, directions)
    for method, samples, share in (("sampled", 400, 0.97), ("companion", 64, 0.5)):
        found = surface.intersect(origins, directions, method=method, samples=samples)
        assert np.all(found.count <= isolate.count)
        same = found.count == isolate.count
        assert same.mean() > share
        width = min(found.alpha.shape[1], isolate.alpha.shape[1])
        np.testing.assert_allclose(found.alpha[same][:, :width], isolate.alpha[same][:, :width], atol=1e-3)


def ring_of(kind, count):
    """A closed curve of circles or of point pairs around the origin, of unequal ones."""
    turns = 2 * np.pi * np.arange(count) / count
    middles = np.stack([3 * np.cos(turns), 3 * np.sin(turns), 0.3 * np.sin(2 * turns + 1)], axis=-1)
    out = middles / np.linalg.norm(middles, axis=-1, keepdims=True)
    if kind == "circle":
        axes = np.cross((0.0, 0.1, 1.0), out)
        controls = [(tuple(c), tuple(n), 0.8 + 0.1 * i) for i, (c, n) in enumerate(zip(middles, axes, strict=True))]
        return tracer.EvolvedCircles(KochanekBartels(controls, closed=True))
    pairs = [(tuple(c - 0.8 * n), tuple(c + (0.7, 0.1, 0.4) * n)) for c, n in zip(middles, out, strict=True)]
    return tracer.EvolvedPointPairs(KochanekBartels(pairs, closed=True))


def points_of_controls(surface, places, random):
    """Points of the objects at joints of a curve, by their parameters."""
    held = [surface.curve(np.array([float(p)])).parameters() for p in range(max(places) + 1)]
    if isinstance(surface, tracer.EvolvedPointPairs):
        shares = random.uniform(0.05, 0.95, (len(places), 1))
        return np.array([held[p].a[0] for p in places]) * shares + np.array([held[p].b[0] for p in places]) * (
            1 - shares
        )
    targets = []
    for place, angle in zip(places, random.uniform(0, 2 * np.pi, len(places)), strict=True):
        center, normal, radius = held[place].center[0], held[place].normal[0], held[place].radius[0]
        across = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
        across /= np.linalg.norm(across)
        targets.append(center + radius * (np.cos(angle) * across + np.sin(angle) * np.cross(normal, across)))
    return np.array(targets)


@pytest.mark.parametrize("seed", range(2))
def test_no_ray_is_lost_between_two_pieces(seed):
    """Rays aimed at joints: rounding must not put the root beyond the ends of both pieces, nor count it twice."""
    random = np.random.default_rng([seed, 4])
    centers = random.normal(size=(5, 3)) + 1.5 * np.arange(5)[:, None] * (1, 0, 0)
    normals = 0.3 * random.normal(size=(5, 3)) + (1, 0, 0)
    radii = random.uniform(0.3, 1.5, 5)
    controls = [(tuple(c), tuple(n), float(r)) for c, n, r in zip(centers, normals, radii, strict=True)]
    surface = tracer.EvolvedCircles(Interpolating(controls, np.arange(5.0), 3), gaps=True)
    joints = np.repeat([1, 2, 3], 2000 // 3)
    targets = points_of_controls(surface, joints, random)
    directions = random.normal(size=targets.shape)
    found = surface.intersect(targets - 2 * directions, directions)
    near = np.linalg.norm(found.point - targets[:, None], axis=-1) < 1e-6
    assert np.all(near.sum(axis=1) == 1)
    np.testing.assert_allclose(found.alpha[near], joints, atol=1e-7)


@pytest.mark.compiles
@pytest.mark.parametrize("kind", ["circle", "point_pair"])
@pytest.mark.parametrize("count", [3, 4])
def test_points_at_the_seam_of_a_closed_curve_count_once(kind, count):
    random = np.random.default_rng([count, 5])
    surface = ring_of(kind, count)
    targets = points_of_controls(surface, [0] * 300, random)
    directions = random.normal(size=targets.shape)
    found = surface.intersect(targets - 2 * directions, directions)
    near = np.linalg.norm(found.point - targets[:, None], axis=-1) < 1e-6
    assert np.all(near.sum(axis=1) == 1)
    period = surface.segments.starts[-1] + surface.segments.lengths[-1]
    np.testing.assert_allclose(np.minimum(found.alpha[near], period - found.alpha[near]), 0, atol=1e-7)


@pytest.mark.parametrize("power", [2, 3, 4, 5, 6])
def test_light_ends_keep_their_normals(power):
    weight = 10.0**-power
    random = np.random.default_rng(3)
    controls = []
    for i in range(4):
        center, normal = random.normal(size=3) + (1.5 * i, 0, 0), 0.3 * random.normal(size=3) + (1, 0, 0)
        controls.append((tuple(center), tuple(normal), float(random.uniform(0.3, 1.5))))
    surface = tracer.EvolvedCircles(RationalBezier(controls, [weight, 1.0, 1.0, weight]), gaps=True)
    directions = random.normal(size=(200, 3)).astype(np.float32)
    origins = (1.5 * random.normal(size=(200, 3)) + (2.2, 0, 0)).astype(np.float32) - 2 * directions
    double = surface.intersect(origins.astype(float), directions.astype(float))
    single = surface.intersect(origins, directions)
    for found, rounding in ((single, 1e-6), (double, 1e-14)):
        hit = ~np.isnan(found.t)
        assert hit.sum() > 100
        np.testing.assert_allclose(np.linalg.norm(found.normal[hit], axis=-1), 1, atol=rounding)
