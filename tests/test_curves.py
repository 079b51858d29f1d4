"""Curves of objects: classical curves where the objects are points, 50 digits and a spectral projection elsewhere."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
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
from bladesmith.codegen.rings import PrecisionRing

sys.path.insert(0, str(Path(__file__).parent))

from formula_support import precise, stock

RANDOM = np.random.default_rng(5)
POSITIONS = RANDOM.normal(size=(6, 3))
KNOTS = np.array([-1.0, 0.0, 0.3, 2.0, 2.5, 4.0])
POINTS = cga.point(POSITIONS)
RING = PrecisionRing(50)
MP = RING.context
#: One entry per way to add up controls: a curve of the given objects.
FAMILIES: dict[str, Any] = {
    "bezier": curves.Bezier,
    "rational": lambda x: curves.RationalBezier(x, np.linspace(0.5, 3.0, len(x))),
    "hermite": lambda x: curves.Hermite(x[0], x[1] - x[0], x[-1], 2 * x[-1] - 2 * x[1]),
    "catmull-rom": curves.KochanekBartels,
    "kochanek-bartels": lambda x: curves.KochanekBartels(x, 0.3, -0.2, np.linspace(-0.4, 0.4, len(x)), closed=True),
    "linear": partial(curves.Interpolating, degree=1),
    "quadratic": lambda x: curves.Interpolating(x, KNOTS[: len(x)], 2),
    "cubic": lambda x: curves.Interpolating(x, KNOTS[: len(x)], 3),
    "natural": lambda x: curves.Interpolating(x, KNOTS[: len(x)], 3, ends="natural"),
}


def near_objects(kind: str, n: int, seed: int = 3, shift: Any = 0.0) -> Any:
    """Objects of one kind that differ moderately, so that sums of them stand for objects."""
    r = np.random.default_rng(seed)
    at = 0.2 * r.normal(size=(n, 3)) + shift
    up = [0, 0, 1] + 0.3 * r.normal(size=(n, 3))
    radius = r.uniform(0.8, 1.5, n)
    if kind == "mixed":  # every other circle is a line
        one, two = cga.line(at[::2], up[::2]), cga.circle(at[1::2] + [3, 0, 0], [0, 1, 0] + 0 * at[1::2], 3.0)
        return [x[i] for i in range(len(two)) for x in (one, two)]
    return {
        "point": lambda: cga.point(at),
        "point_pair": lambda: cga.point_pair(at - up, at + up),
        "line": lambda: cga.line(at, up),
        "circle": lambda: cga.circle(at, up, radius),
        "plane": lambda: cga.plane(up, (up * at).sum(-1)),
        "sphere": lambda: cga.sphere(at, radius),
    }[kind]()


def parameters(curve: Any, count: int = 7) -> np.ndarray:
    """Parameters inside, away from the joints."""
    start, end = curve.domain
    return start + (end - start) * (np.arange(count) + 0.43) / count


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


# -- objects: 50 digits ------------------------------------------------------------------------------------


def spectral(x: Any) -> Any:
    """Sigma^(-1/2) x by the eigenvalues s0 +- sqrt(s4^2) of Sigma = -x ~x, real or not; for points (3.1)."""
    if x.grades == (1,):
        weight = (x | x.basis("ni")).scalar()
        return (x * x.basis("ni") * x).grade(1) * x.new({0: -1 / (2 * weight * weight)})
    sigma = -(x * ~x)
    s0, s4 = sigma.scalar(), sigma.grade(4)
    square = (s4 * s4).scalar() if s4.terms else MP.mpf(0)
    if square == 0:
        return (x.new({0: 1 / MP.sqrt(s0)}) - s4 * x.new({0: 1 / (2 * s0 * MP.sqrt(s0))})) * x
    apart = MP.sqrt(MP.mpc(square))
    one, two = 1 / MP.sqrt(s0 + apart), 1 / MP.sqrt(s0 - apart)
    return (x.new({0: MP.re((one + two) / 2)}) + s4 * x.new({0: MP.re((one - two) / (2 * apart))})) * x


def exact_raw(name: str, rows: list[list[Any]]) -> Any:
    """The sum as a function of t in 50 digits, from the definition of the curve and rows of controls."""
    x = MP.matrix(rows)
    n = len(rows)

    def bezier(t: Any, w: Any) -> Any:
        b = [w[i] * MP.binomial(n - 1, i) * t**i * (1 - t) ** (n - 1 - i) for i in range(n)]
        return (MP.matrix([b]) * x) / MP.fsum(b)

    def hermite(t: Any, c0: Any, v0: Any, c1: Any, v1: Any) -> Any:
        return (
            (2 * t**3 - 3 * t**2 + 1) * c0
            + (t**3 - 2 * t**2 + t) * v0
            + (3 * t**2 - 2 * t**3) * c1
            + (t**3 - t**2) * v1
        )

    def kochanek_bartels(t: Any, tension: Any, bias: Any, continuity: Any, closed: bool) -> Any:
        def row(i: int) -> Any:
            return (
                x[i % n, :]
                if closed or 0 <= i < n
                else 2 * x[0, :] - x[1, :]
                if i < 0
                else 2 * x[n - 1, :] - x[n - 2, :]
            )

        def tangent(i: int, sign: int) -> Any:
            a, b, c = (MP.mpf(float(p[i % n])) for p in (tension, bias, continuity))
            one, two = row(i) - row(i - 1), row(i + 1) - row(i)
            return (1 - a) / 2 * ((1 + b) * (1 + sign * c) * one + (1 - b) * (1 - sign * c) * two)

        i = int(MP.floor(t))
        return hermite(t - i, row(i), tangent(i, 1), row(i + 1), tangent(i + 1, -1))

    zero = np.zeros(n)
    if name in ("linear", "quadratic", "cubic", "natural"):
        return exact_spline(name, x)
    return {
        "bezier": lambda t: bezier(t, [1] * n),
        "rational": lambda t: bezier(t, [MP.mpf(float(w)) for w in np.linspace(0.5, 3.0, n)]),
        "hermite": lambda t: hermite(t, x[0, :], x[1, :] - x[0, :], x[n - 1, :], 2 * x[n - 1, :] - 2 * x[1, :]),
        "catmull-rom": lambda t: kochanek_bartels(t, zero, zero, zero, False),
        "kochanek-bartels": lambda t: kochanek_bartels(t, zero + 0.3, zero - 0.2, np.linspace(-0.4, 0.4, n), True),
    }[name]


def exact_spline(name: str, x: Any) -> Any:
    """All pieces of a spline from one dense system: through the rows, smooth where pieces join."""
    n = x.rows
    degree = {"linear": 1, "quadratic": 2}.get(name, 3)
    knots = [MP.mpf(k) for k in (range(n) if name == "linear" else KNOTS[:n].tolist())]
    breaks = {
        "quadratic": [knots[0], *((a + b) / 2 for a, b in zip(knots[1:-2], knots[2:-1], strict=True)), knots[-1]],
        "cubic": [knots[0], *knots[2:-2], knots[-1]],
    }.get(name, knots)

    def piece_of(t: Any) -> int:
        return max(i for i in range(len(breaks) - 1) if i == 0 or t >= breaks[i])

    def powers(piece: int, t: Any, order: int) -> list[Any]:
        row = [MP.mpf(0)] * ((degree + 1) * (len(breaks) - 1))
        for k in range(order, degree + 1):
            row[(degree + 1) * piece + k] = (
                MP.factorial(k) / MP.factorial(k - order) * (t - breaks[piece]) ** (k - order)
            )
        return row

    system = [powers(piece_of(k), k, 0) for k in knots]
    system += [
        [a - b for a, b in zip(powers(i, breaks[i + 1], order), powers(i + 1, breaks[i + 1], order), strict=True)]
        for i in range(len(breaks) - 2)
        for order in range(degree)
    ]
    if name == "natural":
        system += [powers(0, knots[0], 2), powers(len(breaks) - 2, knots[-1], 2)]
    right = MP.zeros(len(system), x.cols)
    right[:n, :] = x
    solution = MP.inverse(MP.matrix(system)) * right
    return lambda t: MP.matrix([powers(piece_of(t), t, 0)]) * solution


@pytest.mark.parametrize("kind", ["point", "point_pair", "line", "circle", "plane", "sphere", "mixed"])
@pytest.mark.parametrize("name", FAMILIES)
def test_values_and_derivatives_have_fifty_digits_behind_them(name: str, kind: str) -> None:
    objects = near_objects(kind, 6)
    curve = FAMILIES[name](objects)
    layout = stock("cga3d").layout("circle" if kind == "mixed" else kind)
    assert curve.kind == cga.kind("circle" if kind == "mixed" else kind)
    rows = [precise(layout, x.as_kind(curve.kind).values, RING) for x in objects]
    raw = exact_raw(name, [[x.terms.get(b, MP.mpf(0)) for b in layout.blades] for x in rows])

    def exact(t: Any, projected: bool = True) -> np.ndarray:
        sums = raw(t)
        x = rows[0].new({b: sums[i] for i, b in enumerate(layout.blades)})
        x = spectral(x) if projected else x
        return np.array([x.terms.get(b, MP.mpf(0)) for b in layout.blades])

    t = parameters(curve, 3)
    values, rates = curve(t), curve.derivative(t)
    assert (values.status == Status.OK).all() and values.kind == curve.kind
    step = MP.mpf(10) ** -18
    for i, at in enumerate(map(MP.mpf, t.tolist())):
        for found, projected in ((values, True), (curve.raw(t), False)):
            truth = exact(at, projected).astype(float)
            assert np.abs(found.values[i] - truth).max() <= 1e-13 * np.abs(truth).max()
        for found, projected in ((rates, True), (curve.raw_derivative(t), False)):
            truth = ((exact(at + step, projected) - exact(at - step, projected)) / (2 * step)).astype(float)
            coefficients = np.stack([found[i][str(b)] for b in curve.controls.blades])
            assert np.abs(coefficients - truth).max() <= 1e-12 * np.abs(truth).max()


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


# -- far away, in single precision, in the plane, in any shape ---------------------------------------------


@pytest.mark.parametrize("name", [n for n in FAMILIES if n != "hermite"])
def test_a_million_units_away(name: str) -> None:
    shift = np.array([1e6, -5e5, 3e5])
    for kind in ("point", "circle", "sphere", "point_pair", "line", "plane"):
        near, far = (FAMILIES[name](near_objects(kind, 5, shift=s)) for s in (0.0, shift))
        t = parameters(near)
        one, two = near(t), far(t)
        assert (two.status == Status.OK).all()
        for field, a, b in zip(one.parameters()._fields, one.parameters(), two.parameters(), strict=True):
            if field in ("point", "offset"):  # of the origin's own nearest point
                continue
            moved = shift if field in ("xyz", "a", "b", "center") else 0.0
            assert np.abs(b - moved - a).max() <= 1e-9, (kind, field)


def test_hermite_curves_away_from_the_origin() -> None:
    """Tangents are moved to the local origin as what they are: sums, which keep 1e-16 of coefficients of 1e6."""
    x = near_objects("circle", 4)
    move = cga.translator([1e3, -300, 200])
    near = curves.Hermite(x[0], x[1] - x[0], x[3], x[3] - x[2])
    far = curves.Hermite(
        near_objects("circle", 4, shift=[1e3, -300, 200])[0],
        move >> (x[1] - x[0]),
        near_objects("circle", 4, shift=[1e3, -300, 200])[3],
        move >> (x[3] - x[2]),
    )
    t = np.linspace(0, 1, 7)
    for a, b in zip(near(t).parameters(), far(t).parameters(), strict=True):
        moved = [1e3, -300, 200] if a.shape == (7, 3) and np.abs(b).max() > 100 else 0.0
        np.testing.assert_allclose(b - moved, a, rtol=0, atol=1e-8)


def test_single_precision() -> None:
    x = near_objects("circle", 4)
    t = np.linspace(0, 1, 9)
    double, single = curves.Bezier(x), curves.Bezier(x.astype(np.float32))
    for name in ("__call__", "derivative", "raw", "raw_derivative"):
        a, b = getattr(double, name)(t), getattr(single, name)(t.astype(np.float32))
        assert b.dtype == np.float32 and a.isclose(b, rtol=1e-5).all(), name
    assert curves.Hermite(*x[[0, 1, 2, 3]].astype(np.float32)).tangents.dtype == np.float32
    assert double(np.float32(0.5)).dtype == np.float64


def test_parameters_of_any_shape() -> None:
    curve = curves.KochanekBartels(near_objects("circle", 4))
    t = np.linspace(0, 3, 24).reshape(2, 3, 4)
    for f in (curve, curve.derivative, curve.raw, curve.raw_derivative):
        assert f(t).shape == t.shape and f(1.5).shape == () and f(np.zeros((0, 3))).shape == (0, 3)
        assert f(t)[1, 2, 3].isclose(f(t[1, 2, 3]), rtol=1e-14)
    assert curve(2).isclose(curve.controls[2], rtol=1e-14)


def test_curves_of_the_plane() -> None:
    plane = bs.cga2d
    xy = RANDOM.normal(size=(5, 2))
    truth = CubicSpline(np.arange(5), xy)
    t = np.linspace(0, 4, 9)
    np.testing.assert_allclose(curves.Interpolating(plane.point(xy))(t).parameters().xyz, truth(t), atol=1e-13)
    circles = plane.circle(np.zeros((2, 2)), [1.0, 4.0])
    assert np.isclose(curves.Bezier(circles)(0.5).parameters().radius, 2.0)  # the geometric mean


# -- orientation, statuses, errors -------------------------------------------------------------------------


def test_alignment() -> None:
    x = near_objects("line", 5)
    signs = np.array([1.0, -1.0, -1.0, 1.0, -1.0])
    opposed = (x * signs).as_kind("line")
    for make in (curves.Bezier, curves.KochanekBartels, curves.Interpolating):
        plain, aligned = make(opposed), make(opposed, align=True)
        assert not plain.flipped.any() and np.array_equal(aligned.flipped, signs < 0)
        assert aligned.controls.isclose(x).all() and aligned.kind == cga.kind("line")
        t = parameters(plain)
        assert aligned(t).isclose(make(x)(t)).all() and not aligned(t).isclose(plain(t)).any()
    v = 0.1 * x[1]
    hermite = curves.Hermite(x[0], v, opposed[1], v, align=True)
    assert np.array_equal(hermite.flipped, [False, True]) and hermite.tangents[1].isclose(-v)
    assert not curves.Bezier(POINTS, align=True).flipped.any()
    far = cga.sphere([[1e6, 0, 0], [1e6, 0.1, 0]], 1.0)
    assert np.array_equal(curves.Bezier([far[0], (-far[1]).as_kind("sphere")], align=True).flipped, [False, True])


def test_sums_that_stand_for_nothing() -> None:
    spheres = cga.sphere([[0, 0, 0], [5, 0, 0]], 1.0)
    line = cga.line([0, 0, 0], [0, 0, 1])
    for curve, status in (
        (curves.Bezier(spheres), Status.IMAGINARY),
        (curves.Bezier([line, -line]), Status.SINGULAR),
        (curves.Interpolating([line, -line, line], [0, 0.5, 1], 1), None),
    ):
        for f in (curve, curve.derivative):
            x = f([0, 0.5, 1])
            assert list(x.status) == [Status.OK, Status.OK if status is None else status, Status.OK]
            assert np.isnan(x.values[1]).all() == (status is not None) and np.isfinite(x.values[[0, 2]]).all()
            if status is not None:
                with pytest.raises(errors.SingularError, match=rf"item 1 is {status.name}"):
                    f([0, 0.5, 1], strict=True)
        assert np.isfinite(curve.raw([0, 0.5, 1]).values).all()


def test_rounding_noise_is_no_line() -> None:
    """Controls that cancel leave sums of 1e-17, whose direction means nothing."""
    line = cga.line([0.1, 0.2, 0.3], [0.3, -0.2, 0.7])
    curve = curves.Bezier([line, -line, line, -line])
    t = 0.5 + np.linspace(-4, 4, 9) * np.finfo(float).eps
    assert (curve(t).status == Status.SINGULAR).all() and (curve.derivative(t).status == Status.SINGULAR).all()


def test_parameters_outside_the_curve() -> None:
    curve = curves.Interpolating(POINTS, KNOTS)
    for t, message in (
        (4.1, r"t is 4\.1; the curve runs over \[-1, 4\]"),
        ([[0, -1.5], [0, 9]], r"t\[0, 1\] is -1\.5"),
        ([0, np.nan], r"t\[1\] is nan"),
        (np.inf, "t is inf"),
    ):
        for f in (curve, curve.derivative, curve.raw, curve.raw_derivative):
            with pytest.raises(errors.InputError, match=message):
                f(t)
    assert curve(np.nextafter(4.0, 5.0)).isclose(POINTS[-1])
    with pytest.raises(errors.InputError, match="real numbers"):
        curve("1")


CIRCLE, LINE = cga.circle([0, 0, 0], [0, 0, 1], 1.0), cga.line([0, 0, 0], [0, 0, 1])
BAD = [
    (lambda: curves.Bezier([]), errors.InputError, "at least 2 controls, not 0"),
    (lambda: curves.Bezier([CIRCLE]), errors.InputError, "at least 2 controls, not 1"),
    (lambda: curves.Bezier(POINTS[:0]), errors.InputError, "not 0"),
    (lambda: curves.Bezier(CIRCLE), errors.ShapeError, r"\(n,\)"),
    (lambda: curves.Bezier(POINTS[:, None]), errors.ShapeError, r"\(6, 1\)"),
    (lambda: curves.Bezier([CIRCLE, LINE, 2 * CIRCLE]), errors.InputError, r"controls\[2\] is INVALID: no unit circle"),
    (lambda: curves.Bezier([CIRCLE, cga.circle([0, 0, np.nan], [0, 0, 1], 1)]), errors.InputError, r"controls\[1\]"),
    (lambda: curves.Bezier([CIRCLE, POINTS[0]]), errors.GradeError, r"controls\[1\]"),
    (lambda: curves.Bezier([CIRCLE, bs.cga2d.circle([0, 0], 1)]), errors.AlgebraMismatchError, r"controls\[1\]"),
    (lambda: curves.Bezier(bs.pga3d.point(POSITIONS)), errors.InputError, "conformal geometry"),
    (lambda: curves.Bezier([CIRCLE, "circle"]), errors.InputError, r"controls\[1\] is a str"),
    (lambda: curves.Bezier(3), errors.InputError, "controls are a int"),
    (lambda: curves.Bezier([((0, 0, 0), (0, 0, 1), -0.4)] * 2), errors.InputError, "radius is not positive"),
    (lambda: curves.Bezier([{"center": (0, 0, 0)}] * 2), errors.InputError, r"controls\[0\] has no normal"),
    (lambda: curves.Bezier([CIRCLE, CIRCLE * np.nan], raw=True), errors.InputError, r"controls\[1\] is not finite"),
    (lambda: curves.Bezier([CIRCLE, CIRCLE], raw=True, align=True), errors.InputError, "raw"),
    (lambda: curves.RationalBezier(POINTS, np.ones(5)), errors.ShapeError, r"weights has shape \(5,\)"),
    (lambda: curves.RationalBezier(POINTS, [1, 1, 0, 1, 1, 1]), errors.InputError, r"weights\[2\] is 0"),
    (lambda: curves.RationalBezier(POINTS, [1, 1, 1, -2, 1, 1]), errors.InputError, r"weights\[3\] is -2"),
    (lambda: curves.RationalBezier(POINTS, [1, np.nan, 1, 1, 1, 1]), errors.InputError, r"weights\[1\] is not finite"),
    (lambda: curves.RationalBezier(POINTS, 1.0), errors.InputError, "one for each"),
    (lambda: curves.Hermite(CIRCLE, LINE, CIRCLE, POINTS[0]), errors.GradeError, r"tangents\[1\]"),
    (lambda: curves.Hermite(CIRCLE, LINE, 2 * CIRCLE, LINE), errors.InputError, r"controls\[1\]"),
    (lambda: curves.Hermite(CIRCLE, LINE, CIRCLE, LINE * np.nan), errors.InputError, r"tangents\[1\] is not finite"),
    (lambda: curves.Hermite(POINTS[:2], POINTS[0], POINTS[0], POINTS[1]), errors.InputError, "at each end"),
    (lambda: curves.KochanekBartels(POINTS, tension=[0, 1]), errors.ShapeError, "tension"),
    (lambda: curves.KochanekBartels(POINTS, bias=np.inf), errors.InputError, "bias is not finite"),
    (lambda: curves.Interpolating(POINTS, [0, 1, 2, 2, 3, 4]), errors.InputError, r"knots\[3\] is 2"),
    (lambda: curves.Interpolating(POINTS, [0, 1, 2, np.nan, 3, 4]), errors.InputError, r"knots\[3\] is not finite"),
    (lambda: curves.Interpolating(POINTS, [0, 1]), errors.ShapeError, "knots"),
    (lambda: curves.Interpolating(POINTS, np.arange(6) * 5e-324), errors.InputError, r"knots\[1\] - knots\[0\]"),
    (lambda: curves.Interpolating(POINTS, [-1.7e308, 0, 1, 2, 3, 4]), errors.InputError, "another unit"),
    (lambda: curves.KochanekBartels(POINTS, 1e200, 1e200)(0.0), errors.InputError, "KochanekBartels overflow"),
    (lambda: curves.Bezier([1.7e308 * CIRCLE, -1.7e308 * CIRCLE], raw=True)(0), errors.InputError, "overflow"),
    (lambda: curves.RationalBezier(POINTS, [1, 1, 1e-61, 1, 1, 1]), errors.InputError, r"weights\[2\] is 1e-61"),
    (lambda: curves.Bezier([((0, 0, np.nan), (0, 0, 1), 0.4)] * 2), errors.InputError, "not finite"),
    (lambda: curves.Interpolating(POINTS, degree=4), errors.InputError, "degree is 4"),
    (lambda: curves.Interpolating(POINTS, ends="clamped"), errors.InputError, "clamped"),
]


@pytest.mark.parametrize(("make", "error", "message"), BAD)
def test_bad_input_is_named(make: Any, error: Any, message: str) -> None:
    with pytest.raises(error, match=message):
        make()


# -- circles by their parameters, and the ray tracer -------------------------------------------------------


def test_circles_by_parameters() -> None:
    given_ = [((0, 0, 0), (0, 0, 1), 1.0), {"center": (0, 1, 2), "normal": (0, 0.5, 1), "radius": 0.6}]
    circles = [cga.circle((0, 0, 0), (0, 0, 1), 1.0), cga.circle((0, 1, 2), (0, 0.5, 1), 0.6)]
    t = np.linspace(0, 1, 5)
    curve = curves.Bezier(given_)
    assert curve.given is given_ and curve(t).isclose(curves.Bezier(circles)(t)).all()
    rows = np.stack([c.values for c in circles])
    assert curves.Bezier(rows)(t).isclose(curve(t)).all()
    mixed = curves.KochanekBartels([given_[0], circles[1], LINE])
    assert mixed.controls.isclose(curves.KochanekBartels([*circles, LINE]).controls).all()


def test_the_ray_tracer_follows_every_curve_of_circles() -> None:
    from bladesmith import tracer

    x = near_objects("circle", 3)
    for curve, kind in (
        (curves.Bezier(x[:2]), "evolved_circles_1"),
        (curves.RationalBezier(x[:2], [1, 2]), "evolved_circles_1"),
        (curves.KochanekBartels(x[:2]), "evolved_circles_3"),
        (curves.Bezier([2 * x[0], x[1]], raw=True), "evolved_circles_1"),
        (curves.Bezier(x), "evolved_circles_2"),
    ):
        tube = tracer.EvolvedCircles(curve)
        assert tube.program_kind == kind
        assert tube.curve(0.5).isclose(curve.turned(tube.flipped)(0.5)) or curve.kind.is_layout
    with pytest.raises(errors.SceneError, match="spheres"):
        tracer.EvolvedCircles(curves.Bezier(near_objects("sphere", 2)))


def test_curves_describe_themselves() -> None:
    assert repr(curves.KochanekBartels(POINTS)) == "<KochanekBartels of 6 points, degree 3, on [0, 5]>"
    curve = curves.RationalBezier(POINTS, np.arange(1.0, 7.0))
    assert np.array_equal(curve.weights, np.arange(1.0, 7.0) / 6) and curve.degree == 5
    assert curves.Interpolating(POINTS[:2], degree=3).degree == 1  # no more objects than that
