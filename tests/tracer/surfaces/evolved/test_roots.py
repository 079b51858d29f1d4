"""Rays against surfaces evolved between circles: no root lost, none false, and where plain geometry says."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.programs.tracer.surface_kinds import surface_kind
from bladesmith.curves import Bezier
from bladesmith.status import Status

from ....support.tracer.evolved import (
    circles_of,
    constants_of,
    controls_of,
    points_on,
    random_surfaces,
    reference_roots,
)
from ....support.tracer.scenes import TUBE


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


def test_the_ends_belong_to_the_surface():
    surface = tracer.EvolvedCircles(Bezier(TUBE))
    angles = np.linspace(0, 6, 20)
    for alpha in (0.0, 1.0):
        targets = points_on(surface, np.full(20, alpha), angles)
        for target in targets:
            found = surface.intersect((0.3, 0.4, 7.0), target - (0.3, 0.4, 7.0))
            assert np.all((found.alpha[: found.count] >= 0) & (found.alpha[: found.count] <= 1))


def test_a_ray_in_the_surface_is_singular():
    """Circles of one plane sweep a flat ring; a ray in that plane meets all of them."""
    ring = tracer.EvolvedCircles(Bezier([((0, 0, 0), (0, 0, 1), 1.0), ((0.2, 0, 0), (0, 0, 1), 0.5)]))
    found = ring.intersect([(0.75, 0, 3), (-3, 0, 0)], [(0, 0, -1), (1, 0, 0)])
    assert found.count.tolist() == [1, 0]
    assert found.status.tolist() == [Status.OK, Status.SINGULAR]
    assert found.t[0, 0] == pytest.approx(3.0) and abs(found.normal[0, 0, 2]) == pytest.approx(1.0)
