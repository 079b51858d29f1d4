"""Curves of objects against 50 digits, and far away, in single precision, in the plane, in any shape."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import bladesmith as bs
from bladesmith import Status, curves
from bladesmith import cga3d as cga

from ..support.curves import FAMILIES, KNOTS, MP, RANDOM, RING, near_objects, parameters
from ..support.formulas import precise, stock

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


@pytest.mark.slow
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
