"""Rays in the plane of a disc, and at the corners of planes, discs and spheres."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import tracer
from bladesmith.codegen.formulas.objects.euclidean import cross, dot
from bladesmith.codegen.formulas.rays import rays
from bladesmith.status import Status

from ...support.tracer.exact_lines import RING, coordinates, exact, mpf, scalar
from ...support.vectors import unit

DTYPES = (np.float64, np.float32)


# -- rays in the plane of a disc -----------------------------------------------------------------------------


def in_plane(center, normal, radius, foot, along, back):
    """A ray in a disc's plane that passes the centre at ``foot`` radii, from ``back`` radii before that point."""
    u = unit(np.cross(normal, (0.3, -0.5, 0.8)))
    v = np.cross(unit(normal), u)
    side, ahead = math.cos(along) * u + math.sin(along) * v, -math.sin(along) * u + math.cos(along) * v
    middle = np.asarray(center) + foot * radius * side
    return middle - back * radius * ahead, ahead, middle


@pytest.mark.parametrize("dtype", DTYPES)
def test_rays_in_the_plane_meet_the_rim(dtype):
    random = np.random.default_rng(1)
    eps = np.finfo(dtype).eps
    for scale in (1e-9, 1.0, 1e6):
        for _ in range(20):
            center, normal, radius = (
                random.normal(size=3) * scale,
                random.normal(size=3),
                random.uniform(0.3, 2) * scale,
            )
            disc = tracer.Disc(center, normal, radius)
            foot, back = random.uniform(0, 0.98), random.uniform(-3, 3)
            origin, ahead, middle = in_plane(center, normal, radius, foot, random.uniform(0, 6), back)
            found = disc.intersect(origin.astype(dtype), (ahead * 2).astype(dtype))
            assert found.count == 2 and found.status == Status.OK
            half = math.sqrt(1 - foot**2) * radius
            expected = back * radius + np.array([-half, half])
            slack = 200 * eps * (np.abs(origin).sum() + np.abs(center).sum() + radius) * radius / half
            np.testing.assert_allclose(found.t, expected, atol=slack)
            np.testing.assert_allclose(found.point, middle + np.outer([-half, half], ahead), atol=slack)
            np.testing.assert_allclose(np.abs(found.normal @ unit(normal)), 1, atol=10 * eps)


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_tangent_in_the_plane_meets_the_rim_once_and_others_never(dtype):
    random = np.random.default_rng(2)
    for shift in (0.0, 50.0):
        for _ in range(20):
            center, normal, radius = random.normal(size=3) + shift, random.normal(size=3), random.uniform(0.3, 2)
            disc = tracer.Disc(center, normal, radius)
            for foot, count in ((1.0, 1), (1.01, 0), (1.7, 0)):
                origin, ahead, middle = in_plane(center, normal, radius, foot, random.uniform(0, 6), 2.0)
                found = disc.intersect(origin.astype(dtype), ahead.astype(dtype))
                assert found.count == count, (shift, foot)
                if count:
                    np.testing.assert_allclose(found.t[0], 2 * radius, atol=1e3 * np.finfo(dtype).eps * (1 + shift))
                    np.testing.assert_allclose(found.point[0], middle, atol=1e3 * np.finfo(dtype).eps * (1 + shift))


def test_rays_beside_the_plane_miss_and_tilted_ones_cross_it_once():
    disc = tracer.Disc((0, 0, 0), (0, 0, 1), 1.0)
    assert disc.intersect((-3, 0, 1e-9), (1, 0, 0)).count == 0
    for tilt in (1e-3, 1e-6, 1e-9, 1e-12):
        for place in (-0.9, 0.0, 0.5):
            found = disc.intersect((-3.0, 0.2, (3 + place) * tilt), (1.0, 0.0, -tilt))
            assert found.count == 1
            assert found.point[0, 0] == pytest.approx(place, abs=1e-15 / tilt)
            assert abs(found.point[0, 2]) < 1e-15
        assert disc.intersect((-3.0, 0.2, 4.1 * tilt), (1.0, 0.0, -tilt)).count == 0
    for tilt in (1e-15, 1e-17, 0.0):  # within rounding of the plane
        found = disc.intersect((-3.0, 0.6, 3 * tilt), (1.0, 0.0, -tilt))
        np.testing.assert_allclose(found.t, [2.2, 3.8], rtol=1e-14)


def test_no_hit_is_lost_where_the_treatment_changes():
    """Over all slopes and heights about the rounding of the plane: what crosses well inside is always found."""
    disc = tracer.Disc((0, 0, 0), (0, 0, 1), 1.0)
    slope = (np.geomspace(1e-18, 1e-8, 300)[:, None] * np.array([1, -1])).reshape(-1, 1)
    place = np.linspace(-0.99, 0.99, 41)
    origins = np.stack(np.broadcast_arrays(0.0 * slope - 0.5, 0.05, -slope * (place + 0.5)), -1)
    directions = np.stack(np.broadcast_arrays(1.0, 0.0, slope), -1)
    assert (disc.intersect(origins, directions).count > 0).all()


def test_scenes_see_the_rim_and_shadows_do_not_end():
    scene = tracer.Scene(
        tracer.Camera.look_at((0, -5, 0), (0, 0, 0)),
        [tracer.Light((0, 0, 5))],
        [tracer.Disc((0, 0, 0), (0, 0, 1), 1.0, material={"color": (1, 0, 0)})],
    )
    hits = scene.intersect((0, -5, 0), [(0, 1, 0), (0.1, 1, 0), (0.5, 1, 0), (0, 1, -0.01)])
    assert hits.hit.tolist() == [True, True, False, False]
    np.testing.assert_allclose(hits.point[0], (0, -1, 0), atol=1e-15)
    assert np.isfinite(scene.render(33, 33)).all()


def test_the_meet_in_the_plane_at_fifty_digits():
    """4.4.1: <L C>_2 dualised in the plane is A ^ B where its square is positive; the tangent is A ^ t ^ ..."""
    center, normal, radius = exact((0.25, -1.5, 2.0)), exact((0.0, 0.6, 0.8)), scalar(1.25)
    normal = rays.unit(normal)
    u = rays.unit(exact((1, 0, 0)))
    v = cross(normal, u)
    disc = rays.circle(center, normal, radius)
    plane = rays.dual_plane(normal, dot(normal, center)).undual()
    for share, sign in ((0, 1), (0.5, 1), (1, 0), (1.5, -1)):
        origin = center + scalar(share) * radius * v - scalar(3) * u
        ray = rays.line(origin, u)
        pair = ((ray * disc).grade(2) * plane).grade(2)
        square = pair.scalar_product(pair).scalar()
        assert abs((ray & disc).scalar_product(ray & disc).scalar()) < 1e-40  # Y vanishes
        assert square * sign > 0 if sign else abs(square) < 1e-40
        t, first, last = (
            r.value if not r.is_row else r.values for r in rays.rim_hit(origin, u, center, normal, radius)
        )
        if sign > 0:
            a, b = rays.pair_points(pair)
            ends = sorted(map(tuple, (coordinates(a), coordinates(b))))
            got = sorted(map(tuple, (coordinates(first + center), coordinates(last + center))))
            assert max(abs(p - q) for x, y in zip(ends, got, strict=True) for p, q in zip(x, y, strict=True)) < 1e-40
            assert abs(t[0].scalar() - (3 - mpf(1.25) * mpmath.sqrt(1 - mpf(share) ** 2))) < 1e-15
        else:
            assert [bool(RING.context.isnan(x.scalar())) for x in t] == ([False, True] if sign == 0 else [True, True])


# -- corners of planes and spheres ---------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("radius", [1e-12, 1e-3, 1e12])
def test_spheres_and_discs_of_all_sizes(dtype, radius):
    eps = np.finfo(dtype).eps
    rays_ = np.array([(-3, 0, 0), (-3, 0.5, 0), (0, 0, 0), (1, 0, 0), (0, 0.1, 0)]) * radius
    directions = np.array([(1, 0, 0), (2, 0, 0), (0, 0, 1), (-1, 0, 0), (1e-4, 1e-4, 0)])
    sphere = tracer.Sphere((0, 0, 0), radius).intersect(rays_.astype(dtype), directions.astype(dtype))
    assert sphere.count.tolist() == [2] * 5
    root = math.sqrt(0.75)
    near = math.sqrt(0.995)
    expected = [(2, 4), (3 - root, 3 + root), (-1, 1), (0, 2), (-near - 0.1 / 2**0.5, near - 0.1 / 2**0.5)]
    np.testing.assert_allclose(sphere.t / radius, expected, atol=20 * eps)
    np.testing.assert_allclose(np.linalg.norm(sphere.point / radius, axis=-1), 1, atol=20 * eps)
    disc = tracer.Disc((0, 0, 0), (0, 0, 1), radius)
    starts = np.array([(0.5, 0.5, -2), (1.01, 0, 3), (0.3, 0, 0), (0.999, 0, 1)]) * radius
    found = disc.intersect(starts.astype(dtype), np.array([(0, 0, 1), (0, 0, -1), (0, 1, 1), (0, 0, -3)], dtype))
    assert found.count.tolist() == [1, 0, 1, 1]
    np.testing.assert_allclose(found.t[[0, 2, 3], 0] / radius, [2, 0, 1], atol=10 * eps)


def test_rays_that_start_on_surfaces_and_inside_of_them():
    sphere = tracer.Sphere((1, 2, 3), 2.0)
    inside = sphere.intersect((1.5, 2, 3), unit(np.random.default_rng(3).normal(size=(50, 3))))
    assert (inside.t[:, 0] < 0).all() and (inside.t[:, 1] > 0).all()
    toward = np.einsum("ij,ij->i", inside.normal[:, 1], inside.point[:, 1] - sphere.center)
    assert (toward < 0).all()  # seen from inside
    scene = tracer.Scene(tracer.Camera.look_at((1.5, 2, 3), (1, 2, 3)), [], [sphere])
    assert scene.intersect((1.5, 2, 3), (1, 0, 0)).t == pytest.approx(1.5)
    on = sphere.intersect((3, 2, 3), [(1, 0, 0), (-1, 0, 0), (0, 1, 0)])
    np.testing.assert_allclose(on.t, [(-4, 0), (0, 4), (0, 0)], atol=1e-15)
    plane = tracer.Plane((0, 0, 1), 2.0)
    assert plane.intersect((5, 5, 2), (1, 2, 3)).t[0] == 0
    assert plane.intersect((5, 5, 2), (1, 2, 0)).count == 0  # in the plane: no single point
    far = plane.intersect((0, 0, 3), (1, 0, -1e-9))
    assert far.t[0] == pytest.approx(1e9, rel=1e-12)


def test_the_rim_belongs_to_the_disc():
    random = np.random.default_rng(4)
    disc = tracer.Disc(cga.circle((1.0, 0.0, 2.0), (0.0, 0.6, 0.8), 0.7))
    u, v = np.array([1.0, 0, 0]), np.array([0, 0.8, -0.6])
    angle = random.uniform(0, 2 * np.pi, 200)[:, None]
    rim = np.cos(angle) * u + np.sin(angle) * v
    origins = random.normal(size=(200, 3)) * 3
    for share, hit in ((1 - 1e-12, True), (1 + 1e-12, False)):
        points = disc.center + 0.7 * share * rim
        found = disc.intersect(origins, points - origins)
        steep = np.abs(unit(points - origins) @ disc.normal) > 0.1
        assert steep.sum() > 150
        assert ((found.count > 0) == hit)[steep].all()
    assert tracer.Disc((0, 0, 0), (0, 0, 1), 1.0).intersect((0.6, 0.8, 3), (0, 0, -1)).count == 1
