"""Enclosing spheres: that they hold everything, to the last bit, and that a solver finds none that is smaller."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import objects
from bladesmith.objects.interpolation.sphere_weights import sphere_weights

RNG = np.random.default_rng(8)
EPS = np.finfo(float).eps
OK, SINGULAR, INVALID = bs.Status.OK, bs.Status.SINGULAR, bs.Status.INVALID


def holds_all(found: Any, centers: Any, radii: Any) -> bool:
    """Whether the sphere that is read back holds each ball, at 50 digits."""
    p = found.parameters()
    with mpmath.workdps(50):
        at, size = [mpmath.mpf(float(v)) for v in p.center], mpmath.mpf(float(p.radius))
        reaches = [
            mpmath.sqrt(sum((mpmath.mpf(float(c)) - a) ** 2 for c, a in zip(row, at, strict=True)))
            + mpmath.mpf(float(r))
            for row, r in zip(centers, np.broadcast_to(radii, len(centers)), strict=True)
        ]
        return bool(max(reaches) <= size)


def least_radius(centers: Any, radii: Any) -> float:
    """The radius that a constrained solver finds: least R with |c_i - x| + r_i <= R, as smooth cones."""
    start = centers.mean(0)
    reach = (np.linalg.norm(centers - start, axis=-1) + radii).max()
    found = minimize(
        lambda v: v[3],
        [*start, reach],
        jac=lambda v: np.array([0.0, 0, 0, 1]),
        constraints={
            "type": "ineq",
            "fun": lambda v: (v[3] - radii) ** 2 - ((centers - v[:3]) ** 2).sum(-1),
            "jac": lambda v: np.concatenate([2 * (centers - v[:3]), 2 * (v[3] - radii)[:, None]], -1),
        },
        bounds=[(None, None)] * 3 + [(radii.max(), None)],
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    return float((np.linalg.norm(centers - found.x[:3], axis=-1) + radii).max())


@given(st.floats(-6, 6), st.floats(-6, 6), st.floats(0, 6), st.integers(0, 999))
def test_two_spheres(ratio: float, gap: float, far: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    offset = rng.normal(size=3)
    centers = 10.0**far * rng.normal(size=3) + np.stack([np.zeros(3), 10.0**gap * offset])
    radii = np.array([1.0, 10.0**ratio])
    found = objects.enclosing_sphere(cga.sphere(centers, radii))
    distance = np.linalg.norm(centers[1] - centers[0])
    exact = max((distance + radii.sum()) / 2, *radii)
    assert found.status == OK and holds_all(found, centers, radii)
    assert found.parameters().radius <= exact * (1 + 64 * EPS) + 64 * EPS * np.abs(centers).max()


def test_two_spheres_touch_their_enclosing_sphere() -> None:
    centers, radii = RNG.normal(size=(40, 2, 3)) * 3, RNG.uniform(0.1, 1, (40, 2))
    found = objects.enclosing_sphere(cga.sphere(centers, radii), axis=1)
    p = found.parameters()
    gaps = p.radius[:, None] - np.linalg.norm(p.center[:, None] - centers, axis=-1) - radii
    inside = np.linalg.norm(centers[:, 0] - centers[:, 1], axis=-1) < np.abs(radii[:, 0] - radii[:, 1])
    assert np.allclose(gaps[~inside], 0, atol=1e-13)
    dual = found.dual()  # in the algebra: no point of either is outside
    u = RNG.normal(size=(40, 3))
    for i in (0, 1):
        x = cga.point(centers[:, i] + radii[:, i, None] * u / np.linalg.norm(u, axis=-1, keepdims=True))
        assert ((dual | x)["1"] > 0).all()


def test_equal_centers_and_contained_spheres() -> None:
    center = np.array([1.0, -2, 3])
    found = objects.enclosing_sphere([cga.sphere(center, 0.5), cga.sphere(center, 2.0)]).parameters()
    assert np.array_equal(found.center, center) and np.isclose(found.radius, 2, rtol=1e-13)
    found = objects.enclosing_sphere([cga.sphere(center, 2.0), cga.sphere(center + 0.3, 0.5)]).parameters()
    assert np.allclose(found.center, center, atol=1e-15) and np.isclose(found.radius, 2, rtol=1e-13)
    twice = objects.enclosing_sphere([cga.sphere(center, 2.0)] * 2).parameters()
    assert np.isclose(twice.radius, 2, rtol=1e-13)
    one = objects.enclosing_sphere(cga.sphere(center, 2.0))
    assert one.shape == () and np.isclose(one.parameters().radius, 2, rtol=1e-13)


@pytest.mark.parametrize("count", [3, 4, 5, 30])
@pytest.mark.parametrize("spread", [0.0, 0.3, 1.5])
def test_many_against_a_solver(count: int, spread: float) -> None:
    for _ in range(6):
        centers = RNG.normal(size=(count, 3)) * [1, 1, RNG.choice([1.0, 1e-3])]
        radii = spread * RNG.uniform(0, 1, count) + 1e-3
        found = objects.enclosing_sphere(cga.sphere(centers, radii))
        assert found.status == OK and holds_all(found, centers, radii)
        assert found.parameters().radius <= least_radius(centers, radii) * (1 + 1e-12)


def test_points_in_special_position() -> None:
    corners = np.array([[x, y, z] for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])
    cube = objects.enclosing_sphere(cga.point(corners)).parameters()
    assert np.allclose(cube.center, 0, atol=1e-12) and np.isclose(cube.radius, np.sqrt(3), rtol=1e-12)
    t = np.linspace(0, 2 * np.pi, 40)
    ring = np.stack([np.cos(t), np.sin(t), 0 * t], -1)
    assert np.isclose(objects.enclosing_sphere(cga.point(ring)).parameters().radius, 1, rtol=1e-12)
    row = np.outer(np.arange(9.0), [1.0, 2, 2])
    assert np.isclose(objects.enclosing_sphere(cga.point(row)).parameters().radius, 12, rtol=1e-12)
    same = objects.enclosing_sphere(cga.point(np.tile([1.0, 2, 3], (5, 1))))
    assert same.status == OK and 0 < same.parameters().radius < 1e-13
    nested = cga.sphere(np.zeros((20, 3)), np.linspace(0.1, 2, 20))
    assert np.isclose(objects.enclosing_sphere(nested).parameters().radius, 2, rtol=1e-13)
    tangent = cga.sphere(
        np.outer(np.linspace(0, 1, 10), [1.0, 0, 0]), 2 - np.linspace(0, 1, 10)
    )  # all touch at one point
    assert np.isclose(objects.enclosing_sphere(tangent).parameters().radius, 2, rtol=1e-12)


@given(st.integers(3, 12), st.floats(-5, 5), st.floats(0, 6), st.integers(0, 999))
def test_conservative_everywhere(count: int, size: float, far: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scale = 10.0**size
    local, radii = rng.normal(size=(count, 3)), rng.uniform(0.01, 1, count)
    local[rng.integers(0, count)] = local[0]
    centers = 10.0**far * rng.normal(size=3) + scale * local
    found = objects.enclosing_sphere(cga.sphere(centers, scale * radii))
    assert found.status == OK
    p = cga.sphere(centers, scale * radii).parameters()  # what the spheres themselves say
    assert holds_all(found, p.center, p.radius)
    near = objects.enclosing_sphere(cga.sphere(local, radii)).parameters().radius
    assert found.parameters().radius <= scale * near * (1 + 1e-12) + 100 * EPS * np.abs(centers).max()


def test_kinds_of_objects_and_axes() -> None:
    centers, radii = RNG.normal(size=(4, 3)), RNG.uniform(0.5, 1, 4)
    circles = cga.circle(centers, RNG.normal(size=(4, 3)), radii)
    as_spheres = objects.enclosing_sphere(cga.sphere(centers, radii))
    assert objects.enclosing_sphere(circles).isclose(as_spheres, rtol=1e-9, atol=1e-9)
    half = RNG.normal(size=(4, 3))
    pairs = cga.point_pair(centers - half, centers + half)
    expected = objects.enclosing_sphere(cga.sphere(centers, np.linalg.norm(half, axis=-1)))
    assert objects.enclosing_sphere(pairs).isclose(expected, rtol=1e-9, atol=1e-9)
    mixed = objects.enclosing_sphere([circles[0], cga.point(centers[1]), cga.sphere(centers[2:], radii[2:])])
    expected = objects.enclosing_sphere([cga.sphere(centers[[0, 2, 3]], radii[[0, 2, 3]]), cga.point(centers[1])])
    assert mixed.shape == () and mixed.isclose(expected, rtol=1e-9, atol=1e-9)
    grid = cga.sphere(RNG.normal(size=(5, 7, 3)), RNG.uniform(0.1, 1, (5, 7)))
    rows, columns = objects.enclosing_sphere(grid, axis=1), objects.enclosing_sphere(grid)
    assert rows.shape == (5,) and columns.shape == (7,) and objects.enclosing_sphere(grid, axis=-1).isclose(rows).all()
    assert rows[2].isclose(objects.enclosing_sphere(grid[2]), rtol=1e-12)
    inside_out = -cga.sphere(centers, radii)
    assert objects.enclosing_sphere(inside_out).isclose(as_spheres, rtol=1e-12)


def test_bad_input() -> None:
    spheres = cga.sphere(np.zeros((4, 3)), [[1.0, 1, 1, 1], [1, np.nan, 1, 1], [1, 1, -1, 1]])
    found = objects.enclosing_sphere(spheres, axis=1)
    assert list(found.status) == [OK, INVALID, INVALID] and np.isnan(found.values[1:]).all()
    with pytest.raises(bs.errors.SingularError, match="item 1 is INVALID"):
        objects.enclosing_sphere(spheres, axis=1, strict=True)
    plane = cga.plane([0.0, 0, 1], 2.0)
    assert objects.enclosing_sphere([cga.sphere([0.0, 0, 0], 1.0), plane]).status == SINGULAR
    assert objects.enclosing_sphere([plane.as_kind("sphere"), cga.point([0.0, 0, 0])]).status == SINGULAR
    assert objects.enclosing_sphere(cga.sphere(np.zeros((3, 0, 3)), np.zeros((3, 0)))).shape == (0,)
    for empty in ([], cga.sphere(np.zeros((0, 3)), np.zeros(0))):
        with pytest.raises(bs.errors.InputError):
            objects.enclosing_sphere(empty)
    with pytest.raises(bs.errors.ShapeError):
        objects.enclosing_sphere(spheres, axis=2)
    with pytest.raises(bs.errors.InputError):
        objects.enclosing_sphere(np.zeros((4, 3)))


def test_single_precision() -> None:
    centers, radii = RNG.normal(size=(30, 3)).astype(np.float32), RNG.uniform(0.1, 1, 30).astype(np.float32)
    spheres = cga.sphere(centers, radii)
    found = objects.enclosing_sphere(spheres)
    p = spheres.parameters()
    assert found.dtype == np.float32 and holds_all(found, p.center, p.radius)
    assert found.parameters().radius <= least_radius(centers.astype(float), radii.astype(float)) * (1 + 1e-5)


def test_sphere_weights_blend_centers_and_radii() -> None:
    """Thesis 3.11's radius, by vectors, from unit spheres weighted so."""
    centers, radii = RNG.normal(size=(3, 6, 3)) * 0.3, RNG.uniform(1, 2, (3, 6))
    w = RNG.dirichlet(np.ones(3), 6).T
    spheres = cga.sphere(centers, radii)
    a = sphere_weights(spheres, w)
    total = a[0] * spheres[0] + a[1] * spheres[1] + a[2] * spheres[2]
    p = total.normalized().parameters()
    assert np.allclose(a.sum(0), 1) and np.allclose(p.center, (w[..., None] * centers).sum(0), atol=1e-13)
    pairs = [(0, 1), (0, 2), (1, 2)]
    gaps = sum(w[i] * w[j] * ((centers[i] - centers[j]) ** 2).sum(-1) for i, j in pairs)
    assert np.allclose(p.radius**2, (w * radii**2).sum(0) - gaps)
    again = (a / radii) / (a / radii).sum(0)
    assert np.allclose(again, w)
    with pytest.raises(bs.errors.GradeError):
        sphere_weights(cga.plane(centers[0], 1.0))
    with pytest.raises(bs.errors.ShapeError):
        sphere_weights(spheres, np.ones(5))
    with pytest.raises(bs.errors.ShapeError):
        sphere_weights(spheres[0, 0])
