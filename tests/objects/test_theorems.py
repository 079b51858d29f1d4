"""Theorems 1 to 5 and Conjectures 1 and 2 of the thesis (3.7, 3.8), under their true conditions.

Objects are made from Euclidean numbers and checked with Euclidean numbers: points of circles, centres and powers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bladesmith import Status, objects
from bladesmith import cga3d as cga

Array = Any
QUICK = settings(max_examples=30, deadline=None)
#: Squares, determinants and margins nearer to zero than this are another case, or nearly.
MARGIN = 1e-2
CLOSE = 1e-8

number = st.floats(-2, 2, allow_subnormal=False)
position = st.tuples(number, number, number).map(np.array)
size = st.floats(0.4, 2)
angle = st.floats(0, 2 * np.pi)
fraction = st.floats(0.1, 0.9)


@st.composite
def directions(draw: Any) -> Array:
    """Unit vectors."""
    z, turn = draw(st.floats(-1, 1)), draw(angle)
    return np.array([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z])


def frame_of(n: Array) -> tuple[Array, Array]:
    """Two unit vectors perpendicular to n and to each other, right-handed with it."""
    u = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    u /= np.linalg.norm(u)
    return u, np.cross(n, u)


def on_circle(c: Array, n: Array, r: float, t: Any) -> Array:
    """Points of a circle."""
    u, w = frame_of(n)
    return c + r * (np.multiply.outer(np.cos(t), u) + np.multiply.outer(np.sin(t), w))


def circle_points(x: Any) -> Array:
    """Points of a circle of the algebra, from its parameters."""
    p = x.parameters()
    return on_circle(p.center, p.normal, float(p.radius), np.linspace(0, 6, 7))


@st.composite
def circles_of_sphere(draw: Any) -> tuple[Array, float, list[tuple[Array, Array, float]]]:
    """A sphere and two circles on it: centre, radius, and centre, normal, radius of each."""
    c, radius = draw(position), draw(size)
    circles = []
    for _ in range(2):
        n, h = draw(directions()), draw(st.floats(-0.8, 0.8)) * radius
        circles.append((c + h * n, n, float(np.sqrt(radius**2 - h**2))))
    return c, radius, circles


def margin_of(x: Any) -> float:
    """<x x>_0 against the size of x: how real a sum of two circles or point pairs is that is a blade."""
    return float((x * x)["1"]) / max(1.0, float(np.abs(x.values).max()) ** 2)


@QUICK
@given(position, directions(), size, st.tuples(angle, angle, angle, angle), fraction)
def test_theorem_1_chords_of_one_circle(c: Array, n: Array, r: float, t: Array, alpha: float) -> None:
    """Sums of chords of one circle are blades, and chords of it where they are real."""
    ends = on_circle(c, n, r, np.array(t))
    assume(min(np.linalg.norm(ends[0] - ends[1]), np.linalg.norm(ends[2] - ends[3])) > 0.1)
    a, b = cga.point_pair(ends[0], ends[1]), cga.point_pair(ends[2], ends[3])
    assert np.abs((a ^ b).values).max() < CLOSE * np.abs(a.values).max() * np.abs(b.values).max()
    total = alpha * a + (1 - alpha) * b
    square = margin_of(total)
    assume(abs(square) > MARGIN)
    found = objects.interpolate(a, b, alpha=alpha)
    if square < 0:  # crossed chords, run through the other way
        assert found.status == Status.IMAGINARY and np.isnan(found.values).all()
        return
    assert found.status == Status.OK
    assert np.allclose(found.values, total.values / np.sqrt(float((total * total)["1"])), atol=1e-6)  # S is a scalar
    for p in found.parameters():
        assert abs(np.linalg.norm(p - c) - r) < 1e-6 and abs((p - c) @ n) < 1e-6


@QUICK
@given(position, position, position, position, fraction)
def test_theorem_2_point_pairs_on_a_sphere(p: Array, q: Array, u: Array, v: Array, alpha: float) -> None:
    """Of point pairs that are not coplanar, every interpolant is real and on the sphere through the four points."""
    edges = np.stack([q - p, u - p, v - p])
    assume(abs(np.linalg.det(edges)) > 0.3 and np.linalg.norm(u - v) > 0.3)
    center = p + np.linalg.solve(2 * edges, (edges**2).sum(-1))
    radius = np.linalg.norm(center - p)
    a, b = cga.point_pair(p, q), cga.point_pair(u, v)
    sphere = objects.common_sphere(a, b)
    assert sphere.status == Status.OK
    assert np.allclose(sphere.parameters().center, center, atol=1e-7 * (1 + radius**2))
    assert (
        np.isclose(sphere.parameters().radius, radius, rtol=1e-7 * (1 + radius))
        and sphere.parameters().orientation == 1
    )
    found = objects.interpolate(a, b, alpha=alpha)
    assert found.status == Status.OK
    for end in found.parameters():
        assert abs(np.linalg.norm(end - center) - radius) < 1e-6 * (1 + radius)


@QUICK
@given(circles_of_sphere(), fraction)
def test_theorems_3_and_4_circles_on_a_sphere(drawn: Any, alpha: float) -> None:
    """<C1 C2>_4 = 0, sums are blades, and circles of the sphere where they are real."""
    center, radius, circles = drawn
    a, b = (cga.circle(*c) for c in circles)
    assert np.abs((a * b).grade(4).values).max() < CLOSE * np.abs(a.values).max() * np.abs(b.values).max()
    total = alpha * a + (1 - alpha) * b
    square = margin_of(total)
    assume(abs(square) > MARGIN)
    found = objects.interpolate(a, b, alpha=alpha)
    if square < 0:  # disjoint circles of opposite orientation as seen from the plane between them
        assert found.status == Status.IMAGINARY
        return
    assert found.status == Status.OK
    assert np.allclose(found.values, total.values / np.sqrt(float((total * total)["1"])), atol=1e-6)
    assert np.allclose(np.linalg.norm(circle_points(found) - center, axis=-1), radius, atol=1e-6)


def plane_hits(c: Array, n: Array, r: float, c0: Array, n0: Array) -> Array | None:
    """Where a circle meets a plane, and None where it does not or nearly touches it."""
    along = np.cross(n, n0)
    if np.linalg.norm(along) < 0.1:
        return None
    e = along / np.linalg.norm(along)
    across = np.cross(e, n)
    h = (n0 @ (c0 - c)) / (n0 @ across)
    if abs(abs(h) - r) < MARGIN:
        return None
    if abs(h) > r:
        return np.zeros((0, 3))
    return c + h * across + np.multiply.outer([-1, 1], np.sqrt(r * r - h * h) * e)


def linked(one: Any, other: Any) -> bool | None:
    """Whether two circles are linked: exactly one hit of the other with the plane of one is inside it."""
    hits = plane_hits(*other, one[0], one[1])
    if hits is None:
        return None
    gaps = np.linalg.norm(hits - one[0], axis=-1) - one[2]
    if np.any(np.abs(gaps) < 0.05):
        return None
    return bool((gaps < 0).sum() == 1)


circle = st.tuples(position, directions(), size)


@settings(max_examples=60, deadline=None)
@given(circle, circle, fraction)
def test_theorem_5_the_orthogonal_sphere(one: Any, other: Any, alpha: float) -> None:
    """Circles on no common sphere meet one sphere at right angles, as all their interpolants do; linked ones none.

    A circle meets a sphere at right angles if the centre is in its plane with the power of the radius squared.
    """
    a, b = cga.circle(*one), cga.circle(*other)
    assume(np.abs((a * b).grade(4).values).max() > 0.1)
    is_linked = linked(one, other)
    assume(is_linked is not None)
    found = objects.orthogonal_sphere(a, b)
    assert found.status == (Status.IMAGINARY if is_linked else Status.OK)
    between = objects.interpolate(a, b, alpha=alpha)
    square = (alpha * a + (1 - alpha) * b).values
    assume(np.abs(square).max() > MARGIN)
    assert between.status == Status.OK  # real even where the sphere is not
    if is_linked:
        return
    p = found.parameters()
    assume(p.radius < 20)  # it may be a plane
    for c in (a, b, between):
        q = c.parameters()
        scale = 1 + p.radius**2 + q.radius**2 + np.linalg.norm(p.center) ** 2
        assert abs((p.center - q.center) @ q.normal) < 1e-5 * scale
        assert abs(np.sum((p.center - q.center) ** 2) - q.radius**2 - p.radius**2) < 1e-5 * scale


@QUICK
@given(circles_of_sphere())
def test_conjecture_1_the_common_sphere(drawn: Any) -> None:
    """<C1 S>_3 = <C2 S>_3 = 0 has one solution S, and `common_sphere` finds it."""
    center, radius, circles = drawn
    a, b = (cga.circle(*c) for c in circles)
    assume(np.abs((a - b).values).max() > 0.1 and np.abs((a + b).values).max() > 0.1)
    sphere = objects.common_sphere(a, b)
    assert sphere.status == Status.OK
    assert np.allclose(sphere.parameters().center, center, atol=1e-6)
    assert np.isclose(sphere.parameters().radius, radius, atol=1e-6) and sphere.parameters().orientation == 1
    for c in (a, b):
        assert np.abs((c * sphere).grade(3).values).max() < 1e-6 * np.abs(c.values).max()


def equal_radius_sphere(a: Any, b: Any) -> Any:
    """(C1 + C2)((C1 + C2) ^ n_inf) I5, as printed."""
    total = a + b
    return (total * (total ^ cga.ni)).dual().grade(4).normalized()


@QUICK
@given(position, size, st.floats(0.1, 0.8), directions(), directions())
def test_conjecture_1_equal_radii(c: Array, radius: float, h: float, m: Array, n: Array) -> None:
    """The printed formula holds where one normal points out of the sphere and the other in, and not otherwise."""
    assume(np.linalg.norm(m + n) > 0.3 and np.linalg.norm(m - n) > 0.3)
    h *= radius
    r = float(np.sqrt(radius**2 - h**2))
    a = cga.circle(c + h * m, m, r)
    parallel, opposite = cga.circle(c - h * n, n, r), cga.circle(c - h * n, -n, r)
    good = equal_radius_sphere(a, parallel)
    expected = cga.sphere(c, radius)
    sign = np.sign(good.values @ expected.values)
    assert np.allclose(sign * good.values, expected.values, atol=1e-7)
    bad = equal_radius_sphere(a, opposite)
    assert min(np.abs(bad.values - s * expected.values).max() for s in (1, -1)) > 1e-3
    for b in (parallel, opposite):
        assert np.allclose(objects.common_sphere(a, b).values, expected.values, atol=1e-7)


@settings(max_examples=60, deadline=None)
@given(circle, circle, fraction)
def test_conjecture_2_point_pairs_on_the_orthogonal_sphere(one: Any, other: Any, alpha: float) -> None:
    """The point pairs of interpolants on a real orthogonal sphere are interpolants of the circles' point pairs."""
    a, b = cga.circle(*one), cga.circle(*other)
    assume(np.abs((a * b).grade(4).values).max() > 0.1)
    assume(linked(one, other) is False)
    sphere = objects.orthogonal_sphere(a, b)
    assert sphere.status == Status.OK
    ends = [(c & sphere).normalized("point_pair") for c in (a, b, objects.interpolate(a, b, alpha=alpha))]
    found = objects.interpolate(ends[0], ends[1], alpha=alpha)
    assume(max(np.abs(x.values).max() for x in (*ends, found, sphere)) < 50)
    assert found.status == Status.OK
    assert np.allclose(found.values, ends[2].values, atol=1e-5)
