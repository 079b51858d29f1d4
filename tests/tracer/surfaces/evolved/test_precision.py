"""Evolved surfaces far from the origin and from the ray, in single precision, and by the methods as printed."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.curves import Bezier

from ....support.tracer.evolved import answers_of_both_precisions, circles_of, points_on, random_surfaces
from ....support.tracer.scenes import TUBE


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
