"""Fits against SciPy's optimiser on plain distances, exact data at every scale and place, and degenerate sets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith import objects
from bladesmith.core.kind_constraints import satisfies_constraints

from ..support.vectors import rotation_matrix, unit

RNG = np.random.default_rng(3)
OK, SINGULAR, NOT_UNIQUE, INVALID = bs.Status.OK, bs.Status.SINGULAR, bs.Status.NOT_UNIQUE, bs.Status.INVALID
FITS = {
    "line": objects.fit_line,
    "plane": objects.fit_plane,
    "circle": objects.fit_circle,
    "sphere": objects.fit_sphere,
}


def distances(name: str, found: Any, points: Any) -> Any:
    """Distances of points from an object, from its parameters, by plain vector geometry."""
    p = found.parameters()
    if name == "line":
        return np.linalg.norm(np.cross(points - p.point, p.direction), axis=-1)
    if name == "plane":
        return points @ p.normal - p.offset
    if name == "sphere":
        return np.linalg.norm(points - p.center, axis=-1) - p.radius
    height = (points - p.center) @ p.normal
    across = np.linalg.norm(np.cross(points - p.center, p.normal), axis=-1)
    return np.hypot(height, across - p.radius)


def best_cost(name: str, points: Any, weights: Any, start: Any) -> float:
    """The least weighted sum of squared distances that SciPy finds from plain parameters near a start."""
    root = np.sqrt(weights)

    def residuals(v: Any) -> Any:
        if name == "sphere":
            return root * (np.linalg.norm(points - v[:3], axis=-1) - v[3])
        if name == "plane":
            n = v[:3] / np.linalg.norm(v[:3])
            return root * ((points - v[3:]) @ n)
        n = v[3:6] / np.linalg.norm(v[3:6])
        relative = points - v[:3]
        height, across = relative @ n, np.linalg.norm(np.cross(relative, n), axis=-1)
        if name == "line":
            return np.ravel(root[:, None] * np.cross(relative, n))
        return np.concatenate([root * height, root * (across - v[6])])

    return float(2 * least_squares(residuals, start, xtol=1e-15, ftol=1e-15, gtol=1e-15).cost)


def start_of(name: str, p: Any) -> Any:
    if name == "sphere":
        return [*p.center, p.radius]
    if name == "plane":
        return [*p.normal, *(p.normal * p.offset)]
    if name == "line":
        return [*p.point, *p.direction]
    return [*p.center, *p.normal, p.radius]


def on_object(name: str, count: int, noise: float, span: float = 2 * np.pi) -> Any:
    """Points of a random object, in a random order along it, with noise."""
    turn = rotation_matrix(RNG.normal(size=3), RNG.uniform(0, 3))
    t, u = np.sort(RNG.uniform(0, span, count)), RNG.normal(size=count)
    flat = np.zeros(count)
    local = {
        "line": np.stack([t, flat, flat], -1),
        "plane": np.stack([t * np.cos(t), t * np.sin(t), flat], -1),
        "circle": 1.7 * np.stack([np.cos(t), np.sin(t), flat], -1),
        "sphere": 1.7 * unit(np.stack([np.cos(t), np.sin(t), u], -1)),
    }[name]
    return local @ turn.T + RNG.normal(size=3) + noise * RNG.normal(size=(count, 3))


@pytest.mark.parametrize("noise", [1e-3, 0.3])
@pytest.mark.parametrize("name", FITS)
def test_fits_are_at_the_minimum_that_scipy_finds(name: str, noise: float) -> None:
    for _ in range(4):
        points, weights = on_object(name, 25, noise), RNG.uniform(0.1, 3, 25)
        found, rms = FITS[name](points, weights, rms=True)
        assert found.status == OK and found.kind == cga.kind(name)
        cost = (weights * distances(name, found, points) ** 2).sum()
        assert np.isclose(rms, np.sqrt(cost / weights.sum()), rtol=1e-9)
        best = best_cost(name, points, weights, start_of(name, found.parameters()))
        assert cost <= best * (1 + 1e-9)
        moved = np.array(start_of(name, found.parameters())) + 0.05 * noise * RNG.normal(size=1)
        assert cost <= best_cost(name, points, weights, moved) * (1 + 1e-9)


@pytest.mark.parametrize("name", ["circle", "sphere"])
def test_the_slope_vanishes(name: str) -> None:
    """No small motion or growth of the fitted object comes nearer to the points, to first order."""
    points = on_object(name, 30, 0.2)
    p = FITS[name](points).parameters()
    start = np.array(start_of(name, p))

    def cost(v: Any) -> float:
        if name == "sphere":
            return float(((np.linalg.norm(points - v[:3], axis=-1) - v[3]) ** 2).sum())
        n = v[3:6] / np.linalg.norm(v[3:6])
        height, across = (points - v[:3]) @ n, np.linalg.norm(np.cross(points - v[:3], n), axis=-1)
        return float((height**2 + (across - v[6]) ** 2).sum())

    h = 1e-5
    for step in np.eye(len(start)) * h:
        assert abs(cost(start + step) - cost(start - step)) / (2 * h) <= 1e-8


@given(st.floats(-6, 6), st.floats(-3, 6), st.integers(0, 1000))
def test_exact_data_of_every_size_and_place(size: float, far: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    r, c = 10.0**size, 10.0**far * unit(rng.normal(size=3))
    noise = np.finfo(float).eps * np.abs(c).max() / r  # what rounding did to the points, in radii
    t, u = rng.uniform(0, 6.3, 20), rng.normal(size=20)
    turn = rotation_matrix(rng.normal(size=3), 1.0)
    ball = unit(np.stack([np.cos(t), np.sin(t), u], -1))
    p = objects.fit_sphere(c + r * ball).parameters()
    limit = 1e-13 + 8 * noise
    assert abs(p.radius / r - 1) <= limit and np.abs(p.center - c).max() <= limit * r
    ring = np.stack([np.cos(t), np.sin(t), 0 * t], -1) @ turn.T
    circle = objects.fit_circle(c + r * ring)
    q = circle.parameters()
    assert circle.status == OK and satisfies_constraints(cga.kind("circle"), circle.values)
    assert abs(q.radius / r - 1) <= limit and np.abs(q.center - c).max() <= limit * r
    assert np.abs(np.cross(q.normal, turn[:, 2])).max() <= limit
    plane = objects.fit_plane(c + r * ring).parameters()
    assert np.abs(np.cross(plane.normal, turn[:, 2])).max() <= limit
    assert abs(plane.offset - plane.normal @ c) <= limit * r + 4e-16 * 10.0**far
    line = objects.fit_line(c + r * np.outer(u, turn[:, 0])).parameters()
    assert np.abs(np.cross(line.direction, turn[:, 0])).max() <= limit
    foot = np.cross(c - line.point, line.direction)
    assert np.abs(foot).max() <= limit * r + 1e-15 * 10.0**far + limit * 10.0**far


def test_orientation_follows_the_order_of_the_points() -> None:
    a, b, c = RNG.normal(size=(3, 40, 3))
    assert objects.fit_line(np.stack([a, b], 1)).isclose(cga.line_through(a, b), rtol=1e-10).all()
    three = np.stack([a, b, c], 1)
    assert objects.fit_plane(three).isclose(cga.plane_through(a, b, c), rtol=1e-8, atol=1e-9).all()
    assert objects.fit_circle(three).isclose(cga.circle_through(a, b, c), rtol=1e-6, atol=1e-7).all()
    d = RNG.normal(size=(40, 3))
    found, exact = objects.fit_sphere(np.stack([a, b, c, d], 1)), cga.sphere_through(a, b, c, d).parameters()
    assert np.allclose(found.parameters().radius, exact.radius, rtol=1e-6)
    assert (found.parameters().orientation == 1).all()
    t = np.linspace(0, 2 * np.pi, 9)[:-1]
    ring = np.stack([np.cos(t), np.sin(t), 0 * t], -1)
    assert np.allclose(objects.fit_circle(ring).parameters().normal, [0, 0, 1])
    assert np.allclose(objects.fit_circle(ring[::-1]).parameters().normal, [0, 0, -1])
    assert np.allclose(objects.fit_line([[0.0, 0, 0], [3, 0, 0], [1, 0, 0]]).parameters().direction, [1, 0, 0])
    assert np.allclose(objects.fit_line([[1.0, 0, 0], [3, 0, 0], [0, 0, 0]]).parameters().direction, [-1, 0, 0])


def test_batches_points_and_weights() -> None:
    points = RNG.normal(size=(3, 4, 12, 3))
    weights = RNG.uniform(0.5, 2, (4, 12))
    for fit in FITS.values():
        found, rms = fit(points, weights, rms=True)
        assert found.shape == (3, 4) and rms.shape == (3, 4) and (found.status == OK).all()
        single = fit(points[1, 2], weights[2])
        assert single.shape == () and single.isclose(found[1, 2], rtol=1e-7, atol=1e-9)
        assert fit(cga.point(points), weights).isclose(found, rtol=1e-6, atol=1e-8).all()
        assert fit([cga.point(points[0, 0])], weights[0]).isclose(fit(points[0, 0], weights[0]), rtol=1e-6, atol=1e-8)
        doubled = np.concatenate([points[0, 0, :1], points[0, 0]])
        first = np.ones(12)
        first[0] = 2
        assert fit(doubled).isclose(fit(points[0, 0], first), rtol=1e-6, atol=1e-8)
        ignored = np.concatenate([points[0, 0], [[50.0, 60, 70]]])
        kept = fit(ignored, [*np.ones(12), 0.0])
        same = kept.isclose(fit(points[0, 0]), rtol=1e-6, atol=1e-8) or (-kept).isclose(fit(points[0, 0]), rtol=1e-6)
        assert same
        assert fit(points[:0]).shape == (0, 4)
        assert fit(points[..., :1, :]).shape == (3, 4)


def test_arcs_that_are_nearly_straight() -> None:
    """A short arc keeps its curvature as long as it is above rounding, with no special case on the way to a line."""
    for bend in (1e-2, 1e-4, 1e-6):
        t = np.linspace(-bend, bend, 15)
        arc = np.stack([np.sin(t), 1 - np.cos(t), 0 * t], -1) / bend
        p = objects.fit_circle(arc).parameters()
        assert abs(p.radius * bend - 1) <= 1e-14 / bend**2 + 1e-10
        cap = np.concatenate([arc, arc[:, [2, 1, 0]], arc[::3] * [0.5, 0.25, 1] + [0, 0, 0]])[:30]
        q = objects.fit_sphere(cap).parameters()
        assert abs(q.radius * bend - 1) <= 1e-13 / bend**2 + 1e-10
    noisy = np.stack([np.linspace(-1, 1, 40), 0 * t.repeat(3)[:40], 0 * t.repeat(3)[:40]], -1)
    noisy[:, 1:] = 1e-3 * RNG.normal(size=(40, 2))
    found, rms = objects.fit_circle(noisy, rms=True)
    assert found.status == OK and rms <= objects.fit_line(noisy, rms=True)[1] and found.parameters().radius > 10


def test_degenerate_sets() -> None:
    one = np.tile([1.0, 2, 3], (5, 1))
    straight = np.outer(np.arange(5.0), [1.0, 2, -1]) + 0.1
    square = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0], [1, 1, 0]])
    flat = np.array([[1.0, 1, 5], [-1, 1, 5], [-1, -1, 5], [2, -1, 5], [0.3, 0.2, 5]])
    sets = np.stack([one, straight, square, flat])
    expected = {
        "line": [SINGULAR, OK, NOT_UNIQUE, OK],
        "plane": [SINGULAR, NOT_UNIQUE, OK, OK],
        "circle": [SINGULAR, SINGULAR, OK, OK],
        "sphere": [SINGULAR, SINGULAR, NOT_UNIQUE, SINGULAR],
    }
    weights = np.ones((4, 5))
    weights[2, 4] = 0  # a square
    for far in (0.0, 1e6):
        for name, fit in FITS.items():
            found, rms = fit(sets + far, weights, rms=True)
            assert [bs.Status(s) for s in found.status] == expected[name], (name, far)
            missing = found.status == SINGULAR
            assert np.isnan(found.values[missing]).all() and np.isfinite(found.values[~missing]).all()
            assert np.array_equal(np.isnan(rms), missing)
            with pytest.raises(bs.errors.SingularError, match="item 0 is SINGULAR"):
                fit(sets + far, weights, strict=True)
    ball = objects.fit_sphere(square[:4]).parameters()
    assert np.allclose(ball.center, 0, atol=1e-14) and np.isclose(ball.radius, np.sqrt(2))
    plane = objects.fit_plane(straight).parameters()
    assert np.allclose(straight @ plane.normal, plane.offset, atol=1e-13)
    assert objects.fit_line([[1.0, 2, 3]]).status == SINGULAR
    assert objects.fit_plane([[0.0, 0, 0], [1, 0, 0]]).status == NOT_UNIQUE
    assert objects.fit_circle([[0.0, 0, 0], [1, 0, 0]]).status == SINGULAR
    three = objects.fit_sphere([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0]])
    assert three.status == NOT_UNIQUE and np.allclose(three.parameters().center, 0, atol=1e-14)


def test_bad_input() -> None:
    points = np.tile(RNG.normal(size=(6, 3)), (4, 1, 1))
    points[1, 2, 0], points[2, 0, 1] = np.nan, np.inf
    weights = np.ones((4, 6))
    weights[3, 0] = -1
    for fit in FITS.values():
        found, rms = fit(points, weights, rms=True)
        assert list(found.status) == [OK, INVALID, INVALID, INVALID] and np.isnan(rms[1:]).all()
        assert np.isnan(found.values[1:]).all() and np.isfinite(found.values[0]).all()
        assert fit(points[0], np.zeros(6)).status == INVALID
        for bad in (np.zeros((0, 3)), np.zeros(3), np.zeros((4, 2))):
            with pytest.raises(bs.errors.ShapeError):
                fit(bad)
        with pytest.raises(bs.errors.ShapeError):
            fit(points, np.ones(5))
        with pytest.raises(bs.errors.GradeError):
            fit(cga.line(points[0], points[0]))
        with pytest.raises(bs.errors.InputError):
            fit("points")


def test_single_precision() -> None:
    points = on_object("sphere", 30, 0.01).astype(np.float32)
    for name, fit in FITS.items():
        found, rms = fit(points, rms=True)
        assert found.dtype == np.float32 and rms.dtype == np.float32
        exact = fit(points.astype(float))
        assert found.isclose(exact, rtol=1e-5, atol=1e-5), name
    ring = on_object("circle", 12, 0.0).astype(np.float32)
    assert objects.fit_sphere(ring).status == NOT_UNIQUE


@pytest.mark.parametrize("name", FITS)
@pytest.mark.parametrize("size", [1e150, 1e306, 1e308, np.finfo(float).max])
def test_huge_coordinates_have_an_answer_or_a_status(name: str, size: float) -> None:
    """In silence of NumPy as well, and beside them the others are what they are alone."""
    sets = RNG.normal(size=(4, 8, 3))
    sets[1, 2, 0] = size
    sets[3] = sets[3] / np.abs(sets[3]).max() * size
    found, alone = FITS[name](sets), FITS[name](sets[::2])
    finite = np.isfinite(found.values).all(-1)
    assert (finite == np.isin(found.status, (OK, NOT_UNIQUE))).all() and (found.values[::2] == alone.values).all()
    if name == "line" and size < 1e307:
        assert found.status[1] == OK and np.abs(found[1].parameters().direction[0]) == 1
