"""Normals of evolved surfaces: 50 digits, differences between neighbouring points, ends in the light."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import tracer
from bladesmith.codegen.rings.protocol import PrecisionRing
from bladesmith.curves import RationalBezier

from ....support.tracer.evolved import Geometry, points_on, random_surfaces


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
