"""Blends and averages of objects where plain geometry says what they are; statuses and bad input."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import Status, cga2d, errors, objects
from bladesmith import cga3d as cga

from ...support.objects.blends import KINDS, drawn


def test_in_the_plane() -> None:
    """Circles of the plane blend as spheres do: with points on a line, radii by the weights of their points."""
    one, two = cga2d.circle([0.0, 0.0], 1.0), cga2d.circle([1.0, 0.0], 2.0)
    found = objects.interpolate(one, two, alpha=0.5)
    w = 1.0 / 1.5
    assert np.allclose(found.parameters().center, [1 - w, 0], atol=1e-14)
    assert np.isclose(found.parameters().radius, np.sqrt(w + (1 - w) * 4 - w * (1 - w)))
    far = cga2d.circle([[1e6, 1e6], [1e6 + 1, 1e6]], [1.0, 2.0])
    for far_found in (objects.interpolate(far[0], far[1], alpha=0.5), objects.average(far)):
        assert np.allclose(far_found.parameters().center - 1e6, [1 - w, 0], atol=1e-9)


# -- geometry ----------------------------------------------------------------------------------------------


def test_concentric_circles_meet_at_the_geometric_mean() -> None:
    r = np.array([[1.0, 4.0], [0.25, 9.0], [3.0, 3.0]])
    c, n = np.array([1.0, -2.0, 0.5]), np.array([1.0, 2.0, 2.0]) / 3
    found = objects.interpolate(cga.circle(c, n, r[:, 0]), cga.circle(c, n, r[:, 1]), alpha=0.5).parameters()
    assert np.allclose(found.radius, np.sqrt(r[:, 0] * r[:, 1]), rtol=1e-14)
    assert np.allclose(found.center, c, atol=1e-14) and np.allclose(found.normal, n, atol=1e-14)


def test_spheres_by_the_weights_of_their_points() -> None:
    """Radii as in 3.11 with w = (a/r1)/(a/r1 + b/r2) for alpha: imaginary where the square is negative."""
    a, b = drawn("sphere", 200, 11), drawn("sphere", 200, 12)
    p, q = a.parameters(), b.parameters()
    alpha = 0.3
    w = alpha / p.radius / (alpha / p.radius + (1 - alpha) / q.radius)
    gap = ((p.center - q.center) ** 2).sum(-1)
    square = w * p.radius**2 + (1 - w) * q.radius**2 - w * (1 - w) * gap
    found = objects.interpolate(a, b, alpha=alpha)
    assert np.array_equal(found.status == Status.OK, square > 0) and np.array_equal(
        found.status == Status.IMAGINARY, square < 0
    )
    good = square > 1e-3
    centers = w[:, None] * p.center + (1 - w[:, None]) * q.center
    assert np.allclose(found[good].parameters().center, centers[good], atol=1e-12)
    assert np.allclose(found[good].parameters().radius, np.sqrt(square[good]), rtol=1e-11)


def test_separate_spheres_are_mostly_imaginary_half_way() -> None:
    """Outward spheres apart from each other: about seven in ten have no real half-way sphere; aligned ones all do."""
    rng = np.random.default_rng(13)
    c, r = rng.normal(size=(2, 4000, 3)) * 2, rng.uniform(0.1, 1, (2, 4000))
    apart = np.linalg.norm(c[0] - c[1], axis=-1) > r.sum(0)
    a, b = (cga.sphere(c[i][apart], r[i][apart]) for i in range(2))
    found = objects.interpolate(a, b, alpha=0.5)
    assert 0.5 < np.mean(found.status == Status.IMAGINARY) <= 1
    assert np.all(np.isnan(found.values[found.status == Status.IMAGINARY]))
    assert np.all(objects.interpolate(a, b, alpha=0.5, align=True).status == Status.OK)


def test_planes_interpolate_the_dual() -> None:
    """Normal a n1 + b n2, and the offset a d1 + b d2 divided by its length."""
    a, b = drawn("plane", 50, 14), drawn("plane", 50, 15)
    p, q = a.parameters(), b.parameters()
    m = 0.3 * p.normal + 0.7 * q.normal
    size = np.linalg.norm(m, axis=-1)
    found = objects.interpolate(a, b, alpha=0.3).parameters()
    assert np.allclose(found.normal, m / size[:, None], atol=1e-13)
    assert np.allclose(found.offset, (0.3 * p.offset + 0.7 * q.offset) / size, atol=1e-12)


def test_lines_take_the_axis_of_the_screw() -> None:
    """At (b^2 + a b c)/(a^2 + b^2 + 2 a b c) of the common perpendicular, along a m1 + b m2."""
    x, y = drawn("line", 50, 16), drawn("line", 50, 17)
    p, q = x.parameters(), y.parameters()
    n = np.cross(p.direction, q.direction)
    system = np.stack([p.direction, -q.direction, n], -1)
    s = np.linalg.solve(system, (q.point - p.point)[..., None])[..., 0]
    feet = p.point + s[:, :1] * p.direction, q.point + s[:, 1:2] * q.direction
    a, b = 0.3, 0.7
    c = (p.direction * q.direction).sum(-1)
    fraction = ((b * b + a * b * c) / (a * a + b * b + 2 * a * b * c))[:, None]
    through = (1 - fraction) * feet[0] + fraction * feet[1]
    m = a * p.direction + b * q.direction
    expected = cga.line(through, m)
    assert np.allclose(objects.interpolate(x, y, alpha=a).values, expected.values, atol=1e-10)


def test_points_go_straight() -> None:
    a, b = drawn("point", 20, 18), drawn("point", 20, 19)
    p, q = a.parameters().xyz, b.parameters().xyz
    for method in ("direct", "rotor"):
        found = objects.interpolate(a, b, alpha=0.3, method=method)
        assert found.kind == cga.kind("point") and np.allclose(found.parameters().xyz, 0.3 * p + 0.7 * q, atol=1e-14)
    rate = objects.interpolate_derivative(a, b, alpha=0.3)
    assert np.allclose(rate.values[:, :3], p - q, atol=1e-14)
    w = np.random.default_rng(20).uniform(0, 1, 20)
    assert np.allclose(objects.average(a, w).parameters().xyz, np.average(p, 0, w), atol=1e-14)
    assert np.allclose(objects.average(a).parameters().xyz, p.mean(0), atol=1e-14)


@pytest.mark.parametrize("kind", ["line", "circle"])
def test_the_rotors_way(kind: str) -> None:
    """The ends are met; the way is that of the group: a quarter of it four times is all of it."""
    a, b = drawn(kind, 20, 21), drawn(kind, 20, 22)
    way = objects.interpolate(a, b[:, None], alpha=np.ones(20), method="rotor")
    assert way.shape == (20, 20)
    ends = [objects.interpolate(a, b, alpha=t, method="rotor") for t in (1.0, 0.0)]
    assert ends[0].kind == a.kind and ends[0].isclose(a).all() and ends[1].isclose(b).all()
    step = objects.interpolate(a, b, alpha=0.75, method="rotor")
    rotor = objects.rotor_between(a, step)
    assert (rotor >> (rotor >> (rotor >> step))).isclose(b, 1e-8).all()


def test_mixed_flats_and_rounds() -> None:
    """A line is a circle of no curvature: the interpolant of the two has half the curvature vector."""
    circle, line = cga.circle([0, 0, 0], [0, 0, 1], 2.0), cga.line([2, 0, 0], [0, 1, 0])
    found = objects.interpolate(circle, line, alpha=0.5)
    assert found.kind == cga.kind("circle") and found.status == Status.OK
    p = found.parameters()  # they touch, with the same direction: so does this
    assert np.allclose(p.center, [-2, 0, 0], atol=1e-12) and np.isclose(p.radius, 4.0)
    many = objects.average([circle, line, circle])
    assert many.shape == () and many.status == Status.OK


def test_extrapolation() -> None:
    a, b = drawn("line", 5, 23), drawn("line", 5, 24)
    beyond = objects.interpolate(a, b, alpha=1.5)
    assert np.allclose(beyond.values, objects.project_to_blade(1.5 * a - 0.5 * b).values, atol=1e-13)


# -- statuses and bad input --------------------------------------------------------------------------------


def test_what_cancels_is_singular() -> None:
    for kind in KINDS:
        x = drawn(kind, 3, 27)
        found = objects.interpolate(x, -1 * x, alpha=0.5)
        assert np.all(found.status == Status.SINGULAR) and np.isnan(found.values).all()
        assert np.all(objects.interpolate_derivative(x, -1 * x, alpha=0.5).status == Status.SINGULAR)
        with pytest.raises(errors.SingularError, match="item 0 is SINGULAR"):
            objects.interpolate(x, -1 * x, alpha=0.5, strict=True)
        assert objects.interpolate(x, -1 * x, alpha=0.5, align=True).isclose(x).all()
    # opposite and apart: only a line at infinity is left
    parallel = objects.interpolate(cga.line([0, 0, 0], [0, 0, 1]), cga.line([1, 0, 0], [0, 0, -1]), alpha=0.5)
    assert parallel.status == Status.SINGULAR
    # nearly opposite is no noise: the answer has the digits that are left
    tilted = objects.interpolate(cga.line([0, 0, 0], [1, 0, 0]), cga.line([0, 0, 0], [-1, 1e-10, 0]), alpha=0.5)
    assert tilted.status == Status.OK and np.allclose(tilted.parameters().direction, [0, 1, 0], atol=1e-5)


def test_noise_in_the_quadrivector_is_no_real_root() -> None:
    """Circles on a common sphere have an S4 of rounding noise: where Sigma0 < 0 the interpolant is imaginary."""
    rng = np.random.default_rng(28)
    n = rng.normal(size=(2, 500, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    c, h = rng.normal(size=(500, 3)), rng.uniform(-0.9, 0.9, (2, 500))
    a, b = (cga.circle(c + h[i][:, None] * n[i], n[i], np.sqrt(1 - h[i] ** 2)) for i in range(2))
    x = 0.5 * a + 0.5 * b
    square = (x * x)["1"]
    status = objects.interpolate(a, b, alpha=0.5).status
    sure = np.abs(square) > 1e-9
    assert np.array_equal((status == Status.IMAGINARY)[sure], (square < 0)[sure]) and (square < 0).sum() > 5
    assert np.array_equal((status == Status.OK)[sure], (square > 0)[sure])


def test_bad_items_keep_their_reasons() -> None:
    a, b = drawn("sphere", 4, 29), cga.sphere(np.zeros((4, 3)), np.array([1.0, -1.0, 1.0, 1.0]))
    found = objects.interpolate(a, b, alpha=np.array([0.9, 0.9, np.nan, 0.9]))
    assert list(found.status) == [Status.OK, Status.INVALID, Status.INVALID, Status.OK]
    assert np.isnan(found.values[1:3]).all()
    assert objects.average(b).status == Status.INVALID
    x = cga.multivector(np.full((2, 10), [[np.nan], [1.0]]), grades=[3])
    assert objects.project_to_blade(x).status[0] == Status.INVALID


@pytest.mark.compiles
def test_averages() -> None:
    """Any axis, weights, and alignment to the first object."""
    lines = cga.line(np.random.default_rng(30).normal(size=(6, 4, 3)) * 0.1, [0.0, 0.0, 1.0])
    flipped = np.random.default_rng(31).random((6, 4)) < 0.5
    mixed = np.where(flipped, -1.0, 1.0) * lines
    for axis in (0, 1, -1):
        plain = objects.average(lines, axis=axis)
        assert plain.shape == ((4,) if axis == 0 else (6,)) and plain.kind == cga.kind("line")
        aligned = objects.average(mixed, axis=axis, align=True)
        same = aligned.values * np.sign(aligned.values[..., -1:]) * np.sign(plain.values[..., -1:])
        assert np.allclose(same, plain.values, atol=1e-13)
    w = np.arange(1.0, 7)
    weighted = objects.average(lines, w)
    assert np.allclose(weighted.values, objects.average(lines, 5 * w).values, atol=1e-14)
    assert np.allclose(weighted.values, objects.average(lines, np.repeat(w[:, None], 4, 1)).values, atol=1e-14)
    assert np.allclose(
        weighted.values,
        objects.project_to_blade(cga.line(np.einsum("i,ijk->jk", w, lines.parameters().point) / 21, [0, 0, 1])).values,
        atol=1e-13,
    )
    single = objects.average(lines.astype(np.float32), w)
    assert single.dtype == np.float32 or single.dtype == np.float64
    assert np.allclose(single.values, weighted.values, atol=1e-5)
    assert objects.average(cga.line(np.zeros((3, 0, 3)), np.ones((3, 0, 3)))).shape == (0,)


def test_align() -> None:
    lines = cga.line([0, 0, 0], np.array([[1.0, 0, 0], [-1, 0.1, 0], [0, 1, 0], [1, 1, 1]]))
    aligned, flipped = objects.align(lines)
    assert list(flipped) == [False, True, False, False]  # the tie keeps its sign
    assert np.allclose(aligned.parameters().direction[1], -lines.parameters().direction[1])
    _, flipped = objects.align(lines, cga.line([5, 5, 5], [-1, -1, 0]))
    assert list(flipped) == [True, False, True, True]
    _, flipped = objects.align(drawn("point", 3, 32))
    assert not flipped.any()
    apart = cga.sphere([[0, 0, 0], [3, 0, 0], [0.5, 0, 0]], 1.0)
    assert list(objects.align(apart)[1]) == [False, True, False]
    aligned, flipped = objects.align(lines[:0])
    assert aligned.shape == flipped.shape == (0,)


def test_shapes() -> None:
    a, b = drawn("circle", 3, 33), drawn("circle", 4, 34)
    assert objects.interpolate(a[:, None], b, alpha=0.5).shape == (3, 4)
    assert objects.interpolate(a[0], b[0], alpha=np.linspace(0, 1, 7)).shape == (7,)
    assert objects.interpolate(a[:0], b[0], alpha=0.5).shape == (0,)
    assert objects.project_to_blade(a[0]).shape == () and objects.project_to_blade(a[0]).status == Status.OK


def test_bad_calls() -> None:
    line, point = cga.line([0, 0, 0], [1, 0, 0]), cga.point([0, 0, 0])
    two = [line, line]
    for call, error, words in (
        (lambda: objects.average([]), errors.InputError, "empty"),
        (lambda: objects.average(drawn("line", 2, 1)[:0]), errors.InputError, "no objects"),
        (lambda: objects.average(line), errors.InputError, "single"),
        (lambda: objects.average(two, axis=1), errors.InputError, "axis 1"),
        (lambda: objects.average(two, [1.0, -1.0]), errors.InputError, "sum to zero"),
        (lambda: objects.average(two, [1.0, np.nan]), errors.InputError, r"weights\[1\] is nan"),
        (lambda: objects.average(two, [1.0, 1.0, 1.0]), errors.ShapeError, "weights"),
        (lambda: objects.interpolate(line, point, alpha=0.5), errors.GradeError, "grade"),
        (lambda: objects.interpolate(line, 3.0, alpha=0.5), errors.InputError, "multivector"),
        (lambda: objects.interpolate(line, line, alpha="x"), errors.InputError, "alpha"),
        (lambda: objects.interpolate(line, line, alpha=0.5, method="rotors"), errors.InputError, "did you mean"),
        (lambda: objects.interpolate(drawn("line", 3, 1), line, alpha=np.ones(2)), errors.ShapeError, "alpha"),
        (lambda: objects.project_to_blade(cga.translator([1, 2, 3])), errors.GradeError, "one grade"),
        (lambda: objects.project_to_blade(3.0), errors.InputError, "multivector"),
        (lambda: objects.align(line, point), errors.GradeError, "grade"),
        (lambda: objects.common_sphere(point, point), errors.GradeError, "grade"),
        (lambda: objects.orthogonal_sphere(*[drawn("point_pair", 1, 1)] * 2), errors.GradeError, "grade"),
    ):
        with pytest.raises(error, match=words):
            call()
