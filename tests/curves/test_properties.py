"""Curves of points are the classical ones; curves of objects keep what all curves promise, in any form."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BPoly, CubicHermiteSpline, CubicSpline, make_interp_spline

import bladesmith as bs
from bladesmith import Status, curves, errors
from bladesmith import cga3d as cga

from ..support.curves import FAMILIES, KNOTS, MP, POINTS, POSITIONS, RANDOM, near_objects, parameters

# -- points: the classical curves --------------------------------------------------------------------------


def assert_is(curve: Any, truth: Any, rate: Any) -> None:
    t = np.linspace(*curve.domain, 41)
    np.testing.assert_allclose(curve(t).parameters().xyz, truth(t), rtol=0, atol=1e-13)
    d = curve.derivative(t)
    np.testing.assert_allclose(np.stack([d[f"e{i}"] for i in (1, 2, 3)], -1), rate(t), rtol=0, atol=1e-12)
    # X . dX = 0: the derivative moves the point along the null cone
    np.testing.assert_allclose((curve(t) | d)["1"], 0, atol=1e-11)


def test_bezier_curves_of_points() -> None:
    for n in (2, 3, 4, 6):
        truth = BPoly(POSITIONS[:n, None], [0, 1])
        assert_is(curves.Bezier(POINTS[:n]), truth, truth.derivative())


def test_a_bezier_curve_of_degree_forty_has_the_digits_of_its_controls() -> None:
    xyz = np.random.default_rng(1).normal(size=(41, 3))
    t = np.linspace(0, 1, 11)
    basis = np.array([[mpmath.binomial(40, i) * mpmath.mpf(x) ** i * (1 - mpmath.mpf(x)) ** (40 - i)
                       for i in range(41)] for x in t])  # fmt: skip
    np.testing.assert_allclose(curves.Bezier(cga.point(xyz))(t).parameters().xyz, basis.astype(float) @ xyz, atol=1e-14)


def test_a_rational_quadratic_is_a_circular_arc() -> None:
    arc = curves.RationalBezier(cga.point([[1, 0, 0], [1, 1, 0], [0, 1, 0]]), [1, np.sqrt(0.5), 1])
    t = np.linspace(0, 1, 21)
    xyz, d = arc(t).parameters().xyz, arc.derivative(t)
    np.testing.assert_allclose((xyz**2).sum(-1), 1, rtol=1e-15 * 4)
    np.testing.assert_allclose(xyz[:, 0] * d["e1"] + xyz[:, 1] * d["e2"], 0, atol=1e-15 * 4)
    np.testing.assert_allclose(d["e2"][0], np.sqrt(2), rtol=1e-15 * 4)  # 2 w1/w0 |P1 - P0|


def test_equal_weights_change_nothing() -> None:
    t = np.linspace(0, 1, 9)
    one, two = curves.Bezier(POINTS), curves.RationalBezier(POINTS, np.full(6, 7.0))
    assert one.raw(t).isclose(two.raw(t), rtol=1e-14).all()
    assert one.raw_derivative(t).isclose(two.raw_derivative(t), rtol=1e-13).all()


def test_hermite_curves_of_points() -> None:
    """Tangents of the raw curve; the n_inf part of a tangent does not move the projected point."""
    v = RANDOM.normal(size=(2, 3))
    tangents = [cga.multivector({"e1": a, "e2": b, "e3": c, "ni": 5.0}) for a, b, c in v]
    curve = curves.Hermite(POINTS[0], tangents[0], POINTS[1], tangents[1])
    truth = CubicHermiteSpline([0, 1], POSITIONS[:2], v)
    assert_is(curve, truth, truth.derivative())
    assert_is(curve.to_bezier(), truth, truth.derivative())


def test_catmull_rom_of_points() -> None:
    p = POSITIONS
    inner = (p[2:] - p[:-2]) / 2
    truth = CubicHermiteSpline(np.arange(6), p, np.concatenate([p[1:2] - p[:1], inner, p[-1:] - p[-2:-1]]))
    assert_is(curves.KochanekBartels(POINTS), truth, truth.derivative())
    ring = np.concatenate([p, p[:1]])
    around = (np.roll(p, -1, 0) - np.roll(p, 1, 0)) / 2
    truth = CubicHermiteSpline(np.arange(7), ring, np.concatenate([around, around[:1]]))
    assert_is(curves.KochanekBartels(POINTS, closed=True), truth, truth.derivative())


def test_kochanek_bartels_tangents_as_published() -> None:
    """Source and destination derivatives at one control, with parameters of that control."""
    r = np.random.default_rng(8)
    t, b, c = r.uniform(-0.9, 0.9, (3, 6))
    raw = POINTS.values
    before, after = raw - np.roll(raw, 1, 0), np.roll(raw, -1, 0) - raw
    factors = [(1 - t) * (1 + s * b) * (1 + r * c) / 2 for s, r in ((1, 1), (-1, -1), (1, -1), (-1, 1))]
    leaving = factors[0][:, None] * before + factors[1][:, None] * after
    reaching = factors[2][:, None] * before + factors[3][:, None] * after
    curve = curves.KochanekBartels(POINTS, t, b, c, closed=True)
    np.testing.assert_allclose(curve.raw_derivative(np.arange(6.0)).values, leaving, rtol=1e-12, atol=1e-14)
    pieces = curve.to_beziers()
    arrived = np.stack([piece.raw_derivative(1.0).values for piece in pieces])
    np.testing.assert_allclose(arrived, np.roll(reaching, -1, 0), rtol=1e-12, atol=1e-13)


def test_splines_through_points() -> None:
    for n in (2, 3, 4, 6):
        knots, xyz = KNOTS[:n], POSITIONS[:n]
        linear = make_interp_spline(knots, xyz, k=1)
        assert_is(curves.Interpolating(POINTS[:n], knots, 1), linear, linear.derivative())
        if n > 2:
            quadratic = make_interp_spline(knots, xyz, k=2)
            assert_is(curves.Interpolating(POINTS[:n], knots, 2), quadratic, quadratic.derivative())
        for ends in ("not-a-knot", "natural"):
            cubic = CubicSpline(knots, xyz, bc_type=ends)
            assert_is(curves.Interpolating(POINTS[:n], knots, 3, ends=ends), cubic, cubic.derivative())


def test_splines_through_many_objects_at_uneven_knots() -> None:
    r = np.random.default_rng(2)
    knots = np.cumsum(10.0 ** r.uniform(-3, 0, 300))
    xyz = np.cumsum(r.normal(size=(300, 3)), 0)
    t = r.uniform(knots[0], knots[-1], 500)
    for degree, truth in ((2, make_interp_spline(knots, xyz, k=2)), (3, CubicSpline(knots, xyz))):
        found = curves.Interpolating(cga.point(xyz), knots, degree)(t).parameters().xyz
        np.testing.assert_allclose(found, truth(t), rtol=1e-9, atol=1e-9 * np.abs(truth(t)).max())


# -- what all curves promise -------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["point", "line", "circle", "mixed", "sphere"])
def test_curves_pass_through_what_they_should(kind: str) -> None:
    objects = near_objects(kind, 6)
    x = curves.Bezier(objects).controls
    assert len(x) == 6
    for name in ("bezier", "rational", "hermite"):
        curve = FAMILIES[name](objects)
        assert curve.domain == (0.0, 1.0) and curve.segments == 1
        assert curve([0, 1]).isclose(x[[0, -1]], rtol=1e-14).all()
    for name in ("catmull-rom", "linear"):
        curve = FAMILIES[name](objects)
        assert curve.domain == (0.0, 5.0) and curve.segments == 5 and len(curve) == 6
        assert curve(np.arange(6)).isclose(x, rtol=1e-14).all()
    closed = FAMILIES["kochanek-bartels"](objects)
    assert closed.domain == (0.0, 6.0) and closed.segments == 6 and closed.closed
    assert closed(np.arange(7)).isclose(x[[0, 1, 2, 3, 4, 5, 0]], rtol=1e-14).all()
    for name in ("quadratic", "cubic", "natural"):
        curve = FAMILIES[name](objects)
        assert curve.domain == (-1.0, 4.0) and np.array_equal(curve.knots, KNOTS)
        assert curve(KNOTS).isclose(x, rtol=1e-12).all()
    assert [FAMILIES[n](objects).segments for n in ("quadratic", "cubic", "natural")] == [4, 5, 5]
    assert np.array_equal(FAMILIES["quadratic"](objects).breaks, [-1, 0.15, 1.15, 2.25, 4])


def sides(curve: Any, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Projected derivatives just before and at joints, from both pieces' own polynomials."""
    pieces = curve.to_beziers()
    lengths = np.diff(getattr(curve, "breaks", np.arange(curve.segments + 1.0)))
    before = [pieces[i - 1].derivative(1.0).values / lengths[i - 1] for i in at]
    after = [pieces[i].derivative(0.0).values / lengths[i] for i in at]
    return np.array(before), np.array(after)


@pytest.mark.parametrize("kind", ["point", "line", "circle", "mixed", "sphere"])
def test_splines_of_objects_are_smooth(kind: str) -> None:
    """C1 survives projection; a continuity parameter other than zero breaks it, as does a linear spline."""
    objects = near_objects(kind, 6)
    smooth = [curves.KochanekBartels(objects, 0.3, -0.4, 0.0), *(FAMILIES[n](objects) for n in ("quadratic", "cubic"))]
    for curve in smooth:
        before, after = sides(curve, np.arange(1, curve.segments))
        np.testing.assert_allclose(before, after, rtol=0, atol=1e-12 * np.abs(after).max())
    for curve in (curves.KochanekBartels(objects, 0.3, -0.4, 0.5), FAMILIES["linear"](objects)):
        before, after = sides(curve, np.arange(1, curve.segments))
        assert (np.abs(before - after).max(-1) > 1e-3).all()


@pytest.mark.parametrize("name", FAMILIES)
def test_motions_of_the_controls_move_the_curve(name: str) -> None:
    motor = cga.translator([1, -2, 0.5]) * cga.rotor([1, 2, 3], 0.7) * cga.dilator(1.7)
    objects = near_objects("circle", 5)
    moved = (motor >> objects).normalized("circle")
    t = parameters(FAMILIES[name](objects))
    for one, two in (
        (motor >> FAMILIES[name](objects)(t), FAMILIES[name](moved)(t)),
        (motor >> FAMILIES[name](objects).derivative(t), FAMILIES[name](moved).derivative(t)),
    ):
        assert one.isclose(two, rtol=1e-10).all()


@pytest.mark.slow
@given(st.integers(2, 12), st.integers(0, 10_000))
def test_reversed_controls_give_the_curve_run_backwards(n: int, seed: int) -> None:
    objects = near_objects("line", n, seed)
    t = np.linspace(0, 1, 9)
    for make, end in ((curves.Bezier, 1), (curves.KochanekBartels, n - 1), (curves.Interpolating, n - 1)):
        there, back = make(objects), make(objects[::-1])
        assert there(t * end).isclose(back(end - t * end), rtol=1e-10).all()
        rate, opposite = there.derivative(t * end * 0.99), back.derivative(end - t * end * 0.99)
        away = np.abs((rate + opposite).values).max()
        assert away <= 1e-9 * np.abs(rate.values).max()


@given(st.integers(2, 8), st.integers(0, 10_000), st.floats(0.1, 10.0))
def test_weights_count_by_their_ratios(n: int, seed: int, factor: float) -> None:
    objects = near_objects("point_pair", n, seed)
    weights = np.random.default_rng(seed).uniform(0.1, 3.0, n)
    t = np.linspace(0, 1, 7)
    one, two = curves.RationalBezier(objects, weights), curves.RationalBezier(objects, factor * weights)
    assert one.raw(t).isclose(two.raw(t), rtol=1e-12).all()
    other = one.to_bezier()  # other sums, the same objects at the same parameters
    ok = one(t).status == Status.OK
    assert np.array_equal(ok, other(t).status == Status.OK)
    assert one(t).isclose(other(t), rtol=1e-10)[ok].all()


def test_rational_derivatives_of_near_controls_keep_their_digits() -> None:
    """The quotient rule as printed subtracts products of size 1 here, and loses nine digits of the 1e-9 left."""
    rows = [[1.0 + 1e-9 * i * i, float(i == 2) * 1e-9, 0.0] for i in range(4)]
    weights = [0.5, 1.0, 2.0, 0.7]
    curve = curves.RationalBezier(cga.point(rows), weights)
    x, w = MP.matrix([[*precise_row] for precise_row in curve.controls.values.tolist()]), MP.matrix([weights])
    w /= 2

    def raw(t: Any) -> Any:
        b = MP.matrix([[w[i] * MP.binomial(3, i) * t**i * (1 - t) ** (3 - i) for i in range(4)]])
        return b * x / MP.fsum(b)

    at, step = MP.mpf(0.375), MP.mpf(10) ** -18
    truth = np.array((raw(at + step) - raw(at - step)) / (2 * step)).astype(float).ravel()
    np.testing.assert_allclose(curve.raw_derivative(0.375).values, truth, rtol=1e-14, atol=1e-28)


# -- conversions -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["hermite", "catmull-rom", "kochanek-bartels", "linear", "quadratic", "cubic", "natural"]
)
@pytest.mark.parametrize("shift", [0.0, 1e6])
def test_pieces_as_bezier_curves(name: str, shift: float) -> None:
    curve = FAMILIES[name](near_objects("circle", 5, shift=shift))
    breaks = getattr(curve, "breaks", np.arange(curve.segments + 1.0))
    pieces = curve.to_beziers()
    assert len(pieces) == curve.segments and {p.degree for p in pieces} == {curve.degree}
    u = np.array([0.0, 0.3, 0.9])
    for i, piece in enumerate(pieces):
        t = breaks[i] + u * (breaks[i + 1] - breaks[i])
        assert piece(u).isclose(curve(t), rtol=1e-12).all()
        rate = (breaks[i + 1] - breaks[i]) * curve.derivative(t)
        assert piece.derivative(u).isclose(rate, rtol=1e-11).all()
        assert piece.raw(u).isclose(curve.raw(t), rtol=1e-12).all()


def test_the_lightest_weights_that_are_taken_have_derivatives() -> None:
    for weights in ([1e-60, 1, 1, 1e-60], [1, 1e-60, 1e-60, 1]):
        curve = curves.RationalBezier(near_objects("circle", 4), weights)
        t = np.linspace(0, 1, 5)
        assert (curve(t).status == bs.Status.OK).all() and (curve.derivative(t).status == bs.Status.OK).all()
        assert curve.to_bezier()(t).isclose(curve(t)).all()


def test_rational_curves_of_many_controls() -> None:
    n = 800  # binomials of it are no floating-point numbers: C(1598, 799) is about 1e479
    angle = np.linspace(0, 3, n + 1)
    xyz = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    weights = 1 + 0.5 * np.cos(7 * angle)
    curve = curves.RationalBezier(cga.point(xyz), weights)
    h, t = 1e-5, np.array([0.2, 0.5, 0.9])
    slope = (curve.raw(t + h) - curve.raw(t - h)) / (2 * h)
    assert slope.isclose(curve.raw_derivative(t), rtol=1e-6).all()


def test_hermite_and_bezier_are_one_curve() -> None:
    x = near_objects("circle", 4)
    hermite = curves.Hermite(x[0], 3 * (x[1] - x[0]), x[3], 3 * (x[3] - x[2]))
    t = np.linspace(0, 1, 9)
    for other in (curves.Bezier(x), hermite.to_bezier(), hermite.to_bezier().to_hermite()):
        assert hermite(t).isclose(other(t), rtol=1e-13).all()
        assert hermite.derivative(t).isclose(other.derivative(t), rtol=1e-12).all()
    with pytest.raises(errors.InputError, match="degree 2"):
        curves.Bezier(x[:3]).to_hermite()
    line = cga.line([0, 0, 0], [0, 1, 0])  # a tangent that leaves the lines makes circles of them
    bent = curves.Hermite(line, x[1] - x[0], line, x[1] - x[0])
    assert bent.kind == cga.kind("circle") and bent(0.0).isclose(line) and cga.classify(bent(0.3)) == "circle"
