"""Objects of CGA and PGA against plain vector geometry."""

from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.formulas.motions import motions
from bladesmith.codegen.formulas.objects import conformal, projective
from bladesmith.codegen.formulas.products import products
from bladesmith.codegen.status import Status

from ...support.formulas import EPS, Array, Traced, multivector, rows
from ...support.objects.coordinates import CGA, COUNT, PGA, PLANE, N, V, outer_of_points, positive, vectors, widened
from ...support.vectors import unit

# -- CGA objects -------------------------------------------------------------------------------------------------


def test_points() -> None:
    a, b = vectors(1, count=2)
    point = Traced(CGA, conformal.point, V)
    assert point.returns == CGA.kind("point")
    distance = Traced(CGA, products.inner, "point", "point")(point(a), point(b))
    assert np.allclose(distance, -np.sum((a - b) ** 2, 1) / 2, atol=1e-14)
    assert np.allclose(Traced(CGA, conformal.normalise_point, "~point")(-2.5 * point(a)), point(a), rtol=4 * EPS)
    found, status = Traced(CGA, conformal.point_parameters, "~point").all(-2.5 * point(a))
    assert np.all(status == Status.OK) and np.allclose(found, a, rtol=4 * EPS)
    _, status = Traced(CGA, conformal.point_parameters, "~point").all(np.array([[0, 0, 0, 0, 1.0]]))
    assert np.all(status == Status.SINGULAR)


def test_flat_points_and_directions() -> None:
    a = vectors(2)
    flat = Traced(CGA, conformal.flat_point, V)
    assert flat.returns == CGA.kind("flat_point")
    point = multivector(CGA.kind("point"), Traced(CGA, conformal.point, V)(a))
    assert np.allclose(flat(a), rows(CGA.kind("flat_point"), point ^ point.basis("ni")), atol=0)
    assert np.array_equal(Traced(CGA, conformal.flat_point_parameters, "flat_point")(flat(a)), a)
    normalise = Traced(CGA, conformal.normalise_flat_point, "~flat_point")
    assert normalise.returns == CGA.kind("flat_point") and np.allclose(normalise(-3 * flat(a)), flat(a))
    direction = Traced(CGA, conformal.direction, V)
    assert np.array_equal(direction(a), a)
    assert np.array_equal(Traced(CGA, conformal.direction_parameters, "direction")(direction(a)), a)


def test_point_pairs() -> None:
    a, b = vectors(3, count=2)
    pair, status = Traced(CGA, conformal.point_pair, V, V).all(a, b)
    assert Traced(CGA, conformal.point_pair, V, V).returns == CGA.kind("point_pair")
    assert np.all(status == Status.OK)
    expected = outer_of_points(a, b) / (np.sum((b - a) ** 2, 1) / 2)[:, None]
    assert np.allclose(pair, expected, rtol=1e-12, atol=1e-12 * np.max(np.abs(expected)))
    found = Traced(CGA, conformal.point_pair_parameters, "point_pair").all(pair)
    assert np.allclose(found[0], a, atol=1e-12) and np.allclose(found[1], b, atol=1e-12)
    nothing, status = Traced(CGA, conformal.point_pair, V, V).all(a, a)
    assert np.all(np.isnan(nothing)) and np.all(status == Status.SINGULAR)


def test_close_point_pairs_far_away_keep_their_ends() -> None:
    """The printed (4.5) loses 9e-7 at a separation of 1e-5; centre and half vector keep the rounding of the storage."""
    center, axis = vectors(4), unit(vectors(5))
    for offset, separation, allowed in ((1.0, 1e-5, 1e-9), (1e3, 1.0, 1e-8)):
        a, b = center * offset - axis * separation / 2, center * offset + axis * separation / 2
        pair = Traced(CGA, conformal.point_pair, V, V)(a, b)
        found = Traced(CGA, conformal.point_pair_parameters, "point_pair").all(pair)
        assert max(np.max(np.abs(found[0] - a)), np.max(np.abs(found[1] - b))) < allowed


def test_lines() -> None:
    p, d, q = vectors(6, count=3)
    line, status = Traced(CGA, conformal.line, V, V).all(p, d)
    assert Traced(CGA, conformal.line, V, V).returns == CGA.kind("line")
    assert np.all(status == Status.OK)
    m = unit(d)
    expected = outer_of_points(p, p + m, flat=True)
    assert np.allclose(widened("line", line, "trivector"), expected, atol=1e-13)
    point, direction = Traced(CGA, conformal.line_parameters, "line").all(line)
    assert np.allclose(direction, m, atol=1e-15) and np.allclose(point, p - np.sum(p * m, 1)[:, None] * m, atol=1e-14)
    through = Traced(CGA, conformal.line_through, V, V)(p, q)
    assert np.allclose(through, Traced(CGA, conformal.line, V, V)(p, q - p), atol=1e-13)
    dual = products.dual(multivector(CGA.kind("line"), line))  # m I3 + (p x m) n_inf
    moment = np.stack([dual.terms[dual.algebra.parse_blade(f"e{i}ni")[0]] for i in (1, 2, 3)], -1)
    assert np.allclose(moment, np.cross(p, m), atol=1e-14)
    nothing, status = Traced(CGA, conformal.line, V, V).all(p, 0 * p)
    assert np.all(np.isnan(nothing).any(1)) and np.all(status == Status.INVALID)
    _, status = Traced(CGA, conformal.line_through, V, V).all(p, p)
    assert np.all(status == Status.SINGULAR)


@pytest.mark.parametrize("algebra", [CGA, PGA], ids=lambda a: a.name)
def test_directions_of_any_size(algebra: Any) -> None:
    """Neither squares that overflow nor such that vanish matter; ordinary directions are not touched."""
    p, d = vectors(60, count=2)
    formulas = conformal if algebra is CGA else projective
    for formula, kinds, arguments in (
        (formulas.line, (V, V), lambda v: (p, v)),
        (motions.rotor, (V, N), lambda v: (v, p[:, 0])),
        (formulas.plane, (V, N), lambda v: (v, 0 * p[:, 0])),
    ):
        traced = Traced(algebra, formula, *kinds)
        assert traced.returns == algebra.kind(formula.__name__)
        expected = traced(*arguments(d))
        for scale in (1e200, 1e-165, 2.0**40):
            found, status = traced.all(*arguments(d * scale))
            assert np.all(status == Status.OK) and np.allclose(found, expected, rtol=8 * EPS, atol=8 * EPS)
        _, status = traced.all(*arguments(0 * d))
        assert np.all(status == Status.INVALID)


@pytest.mark.parametrize("algebra", [CGA, PLANE], ids=lambda a: a.name)
def test_circles_through_points_on_a_line_are_singular(algebra: Any) -> None:
    size = 3 if algebra is CGA else 2
    a, u = vectors(61, size=size, count=2)
    through = Traced(algebra, conformal.circle_through, V, V, V)
    nothing, status = through.all(0 * a, u, -2.5 * u)
    assert np.all(status == Status.SINGULAR) and np.all(np.isnan(nothing))
    whole = np.round(8 * a), np.round(8 * u)
    _, status = through.all(whole[0], whole[0] + whole[1], whole[0] + 3 * whole[1])
    assert np.all(status == Status.SINGULAR)
    w = np.roll(u, 1, 1) * np.array([1, -1, 1][:size])
    _, status = through.all(a, a + u, a - u + 1e-6 * w)
    assert np.all(status == Status.OK)


def test_circles() -> None:
    c, n = vectors(7, count=2)
    r = positive(8)
    circle, status = Traced(CGA, conformal.circle, V, V, N).all(c, n, r)
    assert Traced(CGA, conformal.circle, V, V, N).returns == CGA.kind("circle")
    assert np.all(status == Status.OK)
    m = unit(n)  # three points, counter-clockwise about n
    u = unit(np.cross(m, vectors(9)))
    w = np.cross(m, u)
    points = [c + r[:, None] * (np.cos(t) * u + np.sin(t) * w) for t in (0.3, 1.9, 4.4)]
    product = outer_of_points(*points)
    expected = product / np.sqrt(norm_of_trivector(product))[:, None]
    assert np.allclose(circle, expected, atol=1e-9 * np.max(np.abs(expected)))
    through, status = Traced(CGA, conformal.circle_through, V, V, V).all(*points)
    assert Traced(CGA, conformal.circle_through, V, V, V).returns == CGA.kind("circle")
    assert np.all(status == Status.OK) and np.allclose(through, circle, atol=1e-10 * np.max(np.abs(circle)))
    center, normal, radius, status = Traced(CGA, conformal.circle_parameters, "circle").all(circle)
    assert np.all(status == Status.OK)
    assert np.allclose(center, c, atol=1e-12) and np.allclose(normal, m, atol=1e-12)
    assert np.allclose(radius, r, rtol=1e-12)
    for bad in ((c, n, -r), (c, 0 * n, r), (c, n, np.full(COUNT, np.nan))):
        value, status = Traced(CGA, conformal.circle, V, V, N).all(*bad)
        assert np.all(status == Status.INVALID) and np.all(np.isnan(value).any(1))
    line = Traced(CGA, conformal.line, V, V)(c, n)
    *_, status = Traced(CGA, conformal.circle_parameters, "~circle").all(widened("line", line, "trivector"))
    assert np.all(status == Status.SINGULAR)


def norm_of_trivector(x: Array) -> Array:
    kind = CGA.kind("trivector")
    mv = multivector(kind, x)
    return np.asarray((mv * mv).terms[0])


def test_planes() -> None:
    n, p, a, b, c = vectors(10, count=5)
    d = np.sum(n * p, 1)
    plane, status = Traced(CGA, conformal.plane, V, N).all(n, d)
    assert Traced(CGA, conformal.plane, V, N).returns == CGA.kind("plane")
    assert np.all(status == Status.OK)
    incidence = Traced(CGA, products.outer, "plane", "point")(plane, Traced(CGA, conformal.point, V)(p))
    assert np.max(np.abs(incidence)) < 1e-13
    normal, offset = Traced(CGA, conformal.plane_parameters, "plane").all(plane)
    assert np.allclose(normal, unit(n), atol=1e-15)
    assert np.allclose(offset, d / np.linalg.norm(n, axis=1), atol=1e-15)
    through, status = Traced(CGA, conformal.plane_through, V, V, V).all(a, b, c)
    assert Traced(CGA, conformal.plane_through, V, V, V).returns == CGA.kind("plane")
    product = outer_of_points(a, b, c, flat=True)
    expected = product / np.linalg.norm(np.cross(b - a, c - a), axis=1)[:, None]
    assert np.allclose(widened("plane", through, "quadvector"), expected, atol=1e-12 * np.max(np.abs(expected)))
    assert np.all(status == Status.OK)
    nothing, status = Traced(CGA, conformal.plane_through, V, V, V).all(a, b, a + 2 * (b - a))
    assert np.all(status == Status.SINGULAR) and np.all(np.isnan(nothing))
    value, status = Traced(CGA, conformal.plane, V, N).all(0 * n, d)
    assert np.all(status == Status.INVALID) and np.all(np.isnan(value).any(1))


def test_spheres() -> None:
    c, x = vectors(11, count=2)
    r = positive(12)
    sphere, status = Traced(CGA, conformal.sphere, V, N).all(c, r)
    assert Traced(CGA, conformal.sphere, V, N).returns == CGA.kind("sphere")
    assert np.all(status == Status.OK)
    dual = products.dual(multivector(CGA.kind("sphere"), sphere))
    assert np.all((dual | dual.basis("ni")).terms[0] < 0)  # outward
    inside = (dual | multivector(CGA.kind("point"), Traced(CGA, conformal.point, V)(x))).terms[0]
    assert np.allclose(inside, (r**2 - np.sum((x - c) ** 2, 1)) / (2 * r), atol=1e-12)
    center, radius, orientation, status = Traced(CGA, conformal.sphere_parameters, "sphere").all(-sphere)
    assert np.allclose(center, c, atol=1e-13) and np.allclose(radius, r, rtol=1e-13)
    assert np.all(orientation == -1) and np.all(status == Status.OK)
    points = [c + r[:, None] * unit(vectors(13 + i)) for i in range(4)]
    through, status = Traced(CGA, conformal.sphere_through, V, V, V, V).all(*points)
    assert Traced(CGA, conformal.sphere_through, V, V, V, V).returns == CGA.kind("sphere")
    volume = np.linalg.det(np.stack([p - points[0] for p in points[1:]], -1))
    shape = np.abs(volume) > 1e-3 * r**3  # flat tetrahedra determine their sphere badly
    center, radius, orientation, _ = Traced(CGA, conformal.sphere_parameters, "sphere").all(through)
    assert np.allclose(center[shape], c[shape], atol=1e-9) and np.allclose(radius[shape], r[shape], rtol=1e-9)
    product = outer_of_points(*points)
    assert np.all(np.sum(product * through, 1) > 0) and np.all(orientation == np.sign(orientation_of(product)))
    for bad in (0 * r, -r, r * np.nan):
        value, status = Traced(CGA, conformal.sphere, V, N).all(c, bad)
        assert np.all(status == Status.INVALID) and np.all(np.isnan(value).any(1))


def orientation_of(quadvectors: Array) -> Array:
    dual = products.dual(multivector(CGA.kind("quadvector"), quadvectors))
    return -np.asarray((dual | dual.basis("ni")).terms[0])


def test_what_goes_through_far_points_keeps_its_shape() -> None:
    """Built about the first point: a unit circle 1e5 away has its radius to rounding of the stored 1e10."""
    far = np.array([1e5, -2e5, 5e4])
    u, w = np.array([0.6, 0.8, 0.0]), np.array([0.0, 0.0, 1.0])
    points = [far + np.cos(t) * u + np.sin(t) * w for t in (0.1, 2.0, 4.0)]
    circle = Traced(CGA, conformal.circle_through, V, V, V)(*points)
    center, normal, radius, _ = Traced(CGA, conformal.circle_parameters, "circle").all(circle)
    assert np.allclose(center, far, atol=1e-4) and abs(radius - 1) < 1e-9
    assert np.allclose(normal, np.cross(u, w), atol=1e-9)


def test_the_plane_has_circles_and_lines_too() -> None:
    c, n = vectors(17, size=2, count=2)
    r = positive(18)
    circle = Traced(PLANE, conformal.sphere, V, N)
    assert circle.returns == PLANE.kind("circle")
    center, radius, orientation, _ = Traced(PLANE, conformal.sphere_parameters, "circle").all(circle(c, r))
    assert np.allclose(center, c, atol=1e-13) and np.allclose(radius, r) and np.all(orientation == 1)
    line = Traced(PLANE, conformal.plane, V, N)
    assert line.returns == PLANE.kind("line")
    incidence = Traced(PLANE, products.outer, "line", "point")(
        line(n, np.sum(n * c, 1)), Traced(PLANE, conformal.point, V)(c)
    )
    assert np.max(np.abs(incidence)) < 1e-13
    turn = Traced(PLANE, motions.planar_rotor, N, V)
    assert turn.returns == PLANE.kind("motor")
    moved = Traced(PLANE, products.sandwich, "motor", "point")(turn(r, c), Traced(PLANE, conformal.point, V)(n))
    s, k = np.sin(r)[:, None], np.cos(r)[:, None]
    x = n - c
    expected = c + k * x + s * np.stack([-x[:, 1], x[:, 0]], -1)
    assert np.allclose(Traced(PLANE, conformal.point_parameters, "point")(moved), expected, atol=1e-13)


# -- PGA objects -------------------------------------------------------------------------------------------------


def test_pga_objects() -> None:
    p, d, n = vectors(19, count=3)
    offset = vectors(20)[:, 0]
    for formula, arguments, kind in (
        (projective.point, (p,), "point"),
        (projective.line, (p, d), "line"),
        (projective.plane, (n, offset), "plane"),
    ):
        traced = Traced(PGA, formula, *[V if np.ndim(a) == 2 else N for a in arguments])
        assert traced.returns == PGA.kind(kind)
    assert np.allclose(Traced(PGA, projective.point_parameters, "point")(Traced(PGA, projective.point, V)(p)), p)
    line, plane = Traced(PGA, projective.line, V, V)(p, d), Traced(PGA, projective.plane, V, N)(n, offset)
    position, direction = Traced(PGA, projective.line_parameters, "line").all(line)
    m = unit(d)
    assert np.allclose(direction, m, atol=1e-15)
    assert np.allclose(position, p - np.sum(p * m, 1)[:, None] * m, atol=1e-14)
    normal, found = Traced(PGA, projective.plane_parameters, "plane").all(plane)
    assert np.allclose(normal, unit(n)) and np.allclose(found, offset / np.linalg.norm(n, axis=1))
    kinds, point = (PGA.kind("point"), PGA.kind("direction")), Traced(PGA, projective.point, V)
    difference = rows(kinds[1], multivector(kinds[0], point(p + d) - point(p)))
    direction = Traced(PGA, projective.direction, V)(d)
    assert np.allclose(direction, difference, atol=1e-14)
    normalise = Traced(PGA, projective.normalise_point, "~point")
    assert normalise.returns == PGA.kind("point") and np.allclose(normalise(-3 * point(p)), point(p))
    at_infinity = np.where(np.array(kinds[0].blades) == PGA.parse_blade("e123")[0], 0.0, point(p))
    nothing, status = normalise.all(at_infinity)
    assert np.all(status == Status.SINGULAR) and np.all(np.isnan(nothing))
    assert np.array_equal(Traced(PGA, projective.direction_parameters, "direction")(direction), d)
    for formula, arguments in ((projective.line, (p, 0 * d)), (projective.plane, (0 * n, offset))):
        traced = Traced(PGA, formula, *[V if np.ndim(a) == 2 else N for a in arguments])
        value, status = traced.all(*arguments)
        assert np.all(status == Status.INVALID) and np.all(np.isnan(value).any(1))
    _, status = Traced(PGA, projective.line_through, V, V).all(p, p)
    assert np.all(status == Status.SINGULAR)
    _, status = Traced(PGA, projective.plane_through, V, V, V).all(p, n, p + 0.5 * (n - p))
    assert np.all(status == Status.SINGULAR)
