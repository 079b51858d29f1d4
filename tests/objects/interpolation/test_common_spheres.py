"""Spheres through two circles, spheres orthogonal to them, imaginary interpolants."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bladesmith import Status, objects
from bladesmith import cga3d as cga

from ...support.objects.blends import FAR


def test_common_spheres() -> None:
    circle = cga.circle([1, 2, 3], [0, 1, 1], 2.0)
    for again in (circle, -1 * circle):  # the great sphere
        found = objects.common_sphere(circle, again)
        assert found.status == Status.NOT_UNIQUE
        assert np.allclose(found.parameters().center, [1, 2, 3]) and np.isclose(found.parameters().radius, 2)
    coplanar = cga.circle([2, 2, 3], [0, -1, -1], 1.0)
    plane = objects.common_sphere(circle, coplanar)
    assert plane.status == Status.OK and cga.classify(plane) == "plane"
    assert np.allclose(plane.as_kind("plane").parameters().normal, np.array([0, 1, 1]) / np.sqrt(2))
    assert np.isclose(plane.as_kind("plane").parameters().offset, 5 / np.sqrt(2))
    x_axis = cga.line([0, 0, 1], [1, 0, 0])
    crossed = objects.common_sphere(x_axis, cga.line([0, 0, 1], [0, 1, 0]))
    assert crossed.kind == cga.kind("plane") and np.allclose(np.abs(crossed.parameters().normal), [0, 0, 1])
    assert objects.common_sphere(x_axis, x_axis).status == Status.SINGULAR
    assert objects.common_sphere(x_axis, cga.line([0, 0, 2], [0, 1, 0])).status == Status.SINGULAR
    assert objects.common_sphere(circle, cga.circle([5, 0, 0], [1, 0, 0], 1.0)).status == Status.SINGULAR
    chords = cga.point_pair([1, 0, 0], [0, 1, 0]), cga.point_pair([-1, 0, 0], [0, -1, 0])
    assert objects.common_sphere(*chords).status == Status.SINGULAR


@pytest.mark.parametrize(("at", "scale"), [(0.0, 1e-6), (0.0, 1.0), (0.0, 1e5), (FAR, 1.0), (FAR, 100.0)])
def test_common_spheres_at_every_scale(at: Any, scale: float) -> None:
    rng = np.random.default_rng(35)
    n = rng.normal(size=(2, 200, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    c, radius = rng.normal(size=(200, 3)) * scale, rng.uniform(0.5, 2, 200) * scale
    h = rng.uniform(-0.8, 0.8, (2, 200)) * radius
    a, b = (cga.circle(c + at + h[i][:, None] * n[i], n[i], np.sqrt(radius**2 - h[i] ** 2)) for i in range(2))
    found = objects.common_sphere(a, b)
    assert np.all(found.status == Status.OK) and np.all(found.parameters().orientation == 1)
    limit = (1e-8 if np.ndim(at) else 1e-11) * max(scale, 1.0 if np.ndim(at) else 0.0)
    assert np.median(np.abs(found.parameters().center - c - at)) < limit
    assert np.median(np.abs(found.parameters().radius - radius)) < limit
    assert np.all(objects.orthogonal_sphere(a, b).status == Status.SINGULAR)


def test_orthogonal_spheres() -> None:
    ring = cga.circle([0, 0, 0], [0, 0, 1], 1.0)
    assert objects.orthogonal_sphere(ring, cga.circle([1, 0, 0], [0, 1, 0], 1.0)).status == Status.IMAGINARY
    assert objects.orthogonal_sphere(ring, cga.line([0.2, 0, 0], [0.1, 0, 1])).status == Status.IMAGINARY
    assert objects.orthogonal_sphere(ring, cga.circle([2, 0, 0], [0, 1, 0], 1.0)).status == Status.SINGULAR  # touching
    found = objects.orthogonal_sphere(ring, cga.circle([3, 0, 0], [0, 1, 1], 1.0))
    p = found.parameters()
    assert np.allclose(p.center, [1.5, 0, 0], atol=1e-14) and np.isclose(p.radius, np.sqrt(1.25))
    assert found.kind == cga.kind("sphere") and p.orientation == 1


@pytest.mark.parametrize(("distance", "radius"), [(30, 0.01), (1e3, 1.0), (1e5, 5.0)])
def test_imaginary_interpolants_far_away_are_no_noise(distance: float, radius: float) -> None:
    """Circles on a sphere, disjoint and opposed: their places are rounded, and that makes no real circle of the sum."""
    rng = np.random.default_rng(17)
    n, m = 200, rng.normal(size=(200, 3))
    m /= np.linalg.norm(m, axis=-1, keepdims=True)
    tilt = m + 0.2 * rng.normal(size=(n, 3))
    tilt /= np.linalg.norm(tilt, axis=-1, keepdims=True)
    place = distance * rng.normal(size=(n, 3))
    h, r = 0.95 * radius, np.sqrt(1 - 0.95**2) * radius
    a, b = cga.circle(place + h * m, m, r), cga.circle(place - h * tilt, tilt, r)
    # sphere* ^ plane*: -<a ~b>_0 is the product of unit planes about the sphere, n.n' - h h' over both radii
    product = ((m * tilt).sum(-1) + 0.95**2) / (1 - 0.95**2)
    assert np.all(product > 1)
    middle = objects.interpolate(a, -b, alpha=0.5)
    assert np.all(middle.status == Status.IMAGINARY)
    assert np.all(objects.interpolate_derivative(a, -b, alpha=0.5).status == Status.IMAGINARY)
    three = cga.multivector(np.stack([a.values, -b.values, a.values, -b.values]), kind="circle")
    assert np.all(objects.average(three).status == Status.IMAGINARY)
    assert np.all(objects.interpolate(a, b, alpha=0.5).status == Status.OK)
