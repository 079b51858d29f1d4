"""What curves are told, and what they tell: orientation, statuses, errors, circles by their parameters."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import Status, curves, errors
from bladesmith import cga3d as cga

from ..support.curves import KNOTS, POINTS, POSITIONS, near_objects, parameters

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
    (lambda: curves.Bezier(3), errors.InputError, "controls is 3"),
    (lambda: curves.Bezier([((0, 0, 0), (0, 0, 1), -0.4)] * 2), errors.InputError, "radius is not positive"),
    (lambda: curves.Bezier([{"center": (0, 0, 0)}] * 2), errors.InputError, r"controls\[0\] has no normal"),
    (lambda: curves.Bezier([CIRCLE, CIRCLE * np.nan], raw=True), errors.InputError, r"controls\[1\] is not finite"),
    (lambda: curves.Bezier([CIRCLE, CIRCLE], raw=True, align=True), errors.InputError, "raw"),
    (lambda: curves.RationalBezier(POINTS, np.ones(5)), errors.ShapeError, r"weights has shape \(5,\)"),
    (lambda: curves.RationalBezier(POINTS, [1, 1, 0, 1, 1, 1]), errors.InputError, r"weights\[2\] is 0"),
    (lambda: curves.RationalBezier(POINTS, [1, 1, 1, -2, 1, 1]), errors.InputError, r"weights\[3\] is -2"),
    (lambda: curves.RationalBezier(POINTS, [1, np.nan, 1, 1, 1, 1]), errors.InputError, r"weights\[1\] is nan"),
    (lambda: curves.RationalBezier(POINTS, 1.0), errors.InputError, "one for each"),
    (lambda: curves.Hermite(CIRCLE, LINE, CIRCLE, POINTS[0]), errors.GradeError, r"tangents\[1\]"),
    (lambda: curves.Hermite(CIRCLE, LINE, 2 * CIRCLE, LINE), errors.InputError, r"controls\[1\]"),
    (lambda: curves.Hermite(CIRCLE, LINE, CIRCLE, LINE * np.nan), errors.InputError, r"tangents\[1\] is not finite"),
    (lambda: curves.Hermite(POINTS[:2], POINTS[0], POINTS[0], POINTS[1]), errors.InputError, "at each end"),
    (lambda: curves.KochanekBartels(POINTS, tension=[0, 1]), errors.ShapeError, "tension"),
    (lambda: curves.KochanekBartels(POINTS, bias=np.inf), errors.InputError, "bias is inf"),
    (lambda: curves.Interpolating(POINTS, [0, 1, 2, 2, 3, 4]), errors.InputError, r"knots\[3\] is 2"),
    (lambda: curves.Interpolating(POINTS, [0, 1, 2, np.nan, 3, 4]), errors.InputError, r"knots\[3\] is nan"),
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
    assert curve.original_controls is given_ and curve(t).isclose(curves.Bezier(circles)(t)).all()
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
        assert tube.curve(0.5).isclose(curve.with_flipped_controls(tube.flipped)(0.5)) or curve.kind.is_layout
    with pytest.raises(errors.SceneError, match="spheres"):
        tracer.EvolvedCircles(curves.Bezier(near_objects("sphere", 2)))


def test_curves_describe_themselves() -> None:
    assert repr(curves.KochanekBartels(POINTS)) == "<KochanekBartels of 6 points, degree 3, on [0, 5]>"
    curve = curves.RationalBezier(POINTS, np.arange(1.0, 7.0))
    assert np.array_equal(curve.weights, np.arange(1.0, 7.0) / 6) and curve.degree == 5
    assert curves.Interpolating(POINTS[:2], degree=3).degree == 1  # no more objects than that
