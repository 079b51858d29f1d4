"""Curves of circles and point pairs as pieces in frames of their own, at 50 digits."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from mpmath import mpf
from scipy.interpolate import BPoly, CubicSpline

from bladesmith import cga3d as cga
from bladesmith import curves, errors
from bladesmith.codegen.programs.tracer.surface_kinds import surface_kind
from bladesmith.tracer.sweeps.local_segments import local_segments

from ...oracles import circle_sums as oracle
from ...support.tracer.segments import FAR, GOOD, assert_controls, circles, combined, exact, pairs

# -- controls ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("at", [(0, 0, 0), FAR])
@pytest.mark.parametrize("kind", ["circle", "point_pair"])
@pytest.mark.parametrize("count", [2, 3, 6])
def test_controls_of_bezier_curves_are_the_objects_seen_from_the_frame(kind, count, at):
    objects = (circles if kind == "circle" else pairs)(count, count, at)
    for curve in (objects, curves.Bezier(objects)):
        found = local_segments(curve, kind, align=False)
        assert found.controls.shape == (1, count, 10) and not found.free and not found.flipped.any()
        assert_controls(found, 0, combined(np.eye(count), objects, kind, found, 0))
        assert np.abs((np.array([o[0] for o in objects]) - found.center) / found.size).max() <= 1.01


@pytest.mark.parametrize("length", [1e-2, 1e-5, 1e-9])
def test_short_pairs_keep_the_digits_of_their_direction(length):
    random = np.random.default_rng(2)
    for _ in range(5):
        a, step = random.normal(size=3), random.normal(size=3)
        objects = [(tuple(a.tolist()), tuple((a + length * step).tolist())), pairs(1, 5)[0]]
        found = local_segments(objects, "point_pair", align=False)
        assert_controls(found, 0, combined(np.eye(2), objects, "point_pair", found, 0), ulps=16)
        made = [cga.point_pair(*obj) for obj in objects]
        found = local_segments(made, "point_pair", align=False)
        assert_controls(found, 0, combined(np.eye(2), objects, "point_pair", found, 0), ulps=32)


@pytest.mark.parametrize("at", [(0, 0, 0), FAR])
def test_rational_curves_have_weighted_controls(at):
    objects, weights = circles(4, 1, at), [1.0, 0.25, 3.0, 2.0]
    found = local_segments(curves.RationalBezier(objects, weights), "circle", align=False)
    shares = np.diag(np.array(weights) / 3.0)
    assert_controls(found, 0, combined(shares, objects, "circle", found, 0))


@pytest.mark.parametrize("at", [(0, 0, 0), FAR])
@pytest.mark.parametrize("kind", ["circle", "point_pair"])
@pytest.mark.parametrize("closed", [False, True])
def test_kochanek_bartels_pieces_are_hermite_cubics_of_their_neighbours(kind, closed, at):
    objects = (circles if kind == "circle" else pairs)(5, 3, at)
    tension, bias, continuity = [0.2, -0.5, 0.1, 0.0, 0.3], [0.1, 0.4, 0.0, -0.2, 0.5], [0.3, 0.0, -0.4, 0.1, 0.2]
    found = local_segments(curves.KochanekBartels(objects, tension, bias, continuity, closed), kind, align=False)
    assert len(found.controls) == (5 if closed else 4) and not found.free

    def step(i):  # shares of X_i+1 - X_i, or of the nearest there is
        i = i % 5 if closed else min(max(i, 0), 3)
        shares = [mpf(0)] * 5
        shares[i], shares[(i + 1) % 5] = mpf(-1), mpf(1)
        return shares

    def tangent(i, side):
        t, b, c = (mpf(x[i % 5]) for x in (tension, bias, continuity))
        before, after = (1 - t) * (1 + b) * (1 + side * c) / 2, (1 - t) * (1 - b) * (1 - side * c) / 2
        return [before * x + after * y for x, y in zip(step(i - 1), step(i), strict=True)]

    for i in range(len(found.controls)):
        one = [[mpf(int(j == k % 5)) for j in range(5)] for k in (i, i + 1)]
        inner = [
            [x + v / 3 for x, v in zip(one[0], tangent(i, 1), strict=True)],
            [x - v / 3 for x, v in zip(one[1], tangent((i + 1) % 5 if closed else i + 1, -1), strict=True)],
        ]
        assert_controls(found, i, combined([one[0], *inner, one[1]], objects, kind, found, i))
    assert found.starts.tolist() == list(range(len(found.controls))) and (found.lengths == 1).all()


@pytest.mark.parametrize("at", [(0, 0, 0), FAR])
def test_hermite_tangents_as_differences_keep_their_digits_far_away(at):
    objects = circles(6, 5, at)
    tangents = [
        {"from": objects[2], "to": objects[3], "scale": 2.0},
        {"from": objects[4], "to": dict(zip(("center", "normal", "radius"), objects[5], strict=True))},
    ]
    found = local_segments(curves.Hermite(objects[0], tangents[0], objects[1], tangents[1]), "circle", align=False)
    third = mpf(1) / 3
    shares = [
        [1, 0, 0, 0, 0, 0], [1, 0, -2 * third, 2 * third, 0, 0], [0, 1, 0, 0, third, -third], [0, 1, 0, 0, 0, 0]
    ]  # fmt: skip
    assert_controls(found, 0, combined(shares, objects, "circle", found, 0), ulps=4000 if at is FAR else 200)


def test_hermite_tangents_may_be_multivectors():
    x = [cga.circle(*c) for c in circles(4, 6)]
    plain = curves.Hermite(x[0], 2 * (x[2] - x[3]), x[1], x[2] - x[0])
    named = curves.Hermite(x[0], {"from": x[3], "to": x[2], "scale": 2}, x[1], {"from": x[0], "to": x[2]})
    np.testing.assert_allclose(plain.tangents.values, named.tangents.values, atol=1e-15)
    a, b = (local_segments(c, "circle", align=False) for c in (plain, named))
    np.testing.assert_allclose(a.controls, b.controls, atol=1e-13 * np.abs(a.controls).max())


@pytest.mark.parametrize("knots", [[0, 1, 2, 3, 4, 5], [0, 0.5, 2, 3, 3.25, 7]])
def test_interpolating_cubics_equal_another_librarys(knots):
    objects = circles(6, 7, FAR)
    found = local_segments(curves.Interpolating(objects, knots), "circle", align=False)
    shares = BPoly.from_power_basis(CubicSpline(knots, np.eye(6))).c  # (4, pieces, 6)
    for i in range(5):
        expected = np.array(combined(shares[:, i], objects, "circle", found, i), float)
        np.testing.assert_allclose(found.controls[i], expected, atol=1e-11 * np.abs(expected).max())
    np.testing.assert_allclose(found.starts, knots[:-1])
    np.testing.assert_allclose(found.lengths, np.diff(knots))


def test_pieces_that_end_between_objects_are_free_and_have_the_curves_parameters():
    curve = curves.Interpolating(circles(5, 8), [0, 1, 3, 3.5, 7], degree=2)
    found = local_segments(curve, "circle", align=False)
    assert found.free and not local_segments(curves.Interpolating(circles(5, 8)), "circle", True).free
    t = np.linspace(0, 1, 7)
    for i in range(len(found.controls)):
        basis = np.array([[float(b) for b in oracle.bernstein(2, x)] for x in t])
        world = curve.raw(found.starts[i] + found.lengths[i] * t)
        local = cga.dilator(1 / found.size[i]) >> (~cga.translator(found.center[i]) >> world)
        np.testing.assert_allclose(basis @ found.controls[i], local.values, atol=1e-13 * np.abs(local.values).max())


@pytest.mark.parametrize("at", [(0, 0, 0), FAR / 1e3])
def test_converted_curves_are_the_pieces_that_they_were(at):
    """Bezier curves of sums that are no objects, in frames that they have already."""
    spline = curves.KochanekBartels([cga.circle(*c) for c in circles(4, 9, at)])
    whole = local_segments(spline, "circle", align=False)
    for i, piece in enumerate(spline.to_beziers()):
        found = local_segments(piece, "circle", align=False)
        assert not found.free
        moved = (found.center[0] - whole.center[i]) / whole.size[i]
        here = cga.multivector(found.controls[0], kind=cga.layout("circle"))
        there = cga.translator(moved) >> (cga.dilator(found.size[0] / whole.size[i]) >> here)
        np.testing.assert_allclose(there.values, whole.controls[i], atol=2e-9 * np.abs(whole.controls[i]).max())
    cut = curves.Bezier(spline.raw(np.array([0.2, 0.5, 0.7, 0.9])), raw=True)
    assert local_segments(cut, "circle", align=True).free


def test_parameters_hold_the_frame_and_what_is_asked():
    found = local_segments(curves.KochanekBartels(circles(4, 1)), "circle")
    rows = found.parameters()
    assert rows.shape == (3, 15 + 40) == (3, surface_kind("evolved_circles_3").parameters)
    np.testing.assert_array_equal(rows[:, :3], found.center)
    np.testing.assert_array_equal(rows[:, 3:7].T, [found.size, 1 / found.size, found.starts, found.lengths])
    assert (rows[:, 7:15] == [0, 1, 1, 0, 1, 0, 1, 0]).all()
    np.testing.assert_array_equal(rows[:, 15:].reshape(3, 4, 10), found.controls)
    assert (found.parameters(gaps=True)[:, 7:9] == 2).all()


def test_a_long_spline_has_the_digits_of_each_pieces_own_size():
    n = 200
    objects = [((50.0 * i, 0.0, 0.0), (1.0, 0.02 * (i % 3), 0.0), 1e-3) for i in range(n)]
    found = local_segments(curves.KochanekBartels(objects), "circle", align=False)
    assert found.size.max() == 50
    assert_controls(found, 150, [*combined(np.eye(2)[:1], objects[150:152], "circle", found, 150),
                                 found.controls[150, 1], found.controls[150, 2],
                                 *combined(np.eye(2)[1:], objects[150:152], "circle", found, 150)])  # fmt: skip


def test_weights_of_extreme_size_are_levelled():
    objects = circles(3, 2)
    tiny = local_segments(curves.RationalBezier(objects, [1, 1e-19, 1]), "circle")
    assert np.abs(tiny.controls[0, [0, 2]]).max() > 0.1
    huge = curves.Hermite(objects[0], {"from": objects[1], "to": objects[2], "scale": 1e12}, objects[1],
                          {"from": objects[1], "to": objects[2], "scale": 1e12})  # fmt: skip
    assert 0.1 < np.abs(local_segments(huge, "circle").controls).max() < 2


# -- orientation ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["circle", "point_pair"])
@pytest.mark.parametrize("at", [(0, 0, 0), FAR])
def test_controls_are_turned_where_they_oppose_the_one_before(kind, at):
    for seed in range(8):
        objects = (circles if kind == "circle" else pairs)(6, seed, at)
        signs = [oracle.agreement(exact(x), exact(y), kind) for x, y in zip(objects, objects[1:], strict=False)]
        expected = np.cumsum([0, *(s < 0 for s in signs)]) % 2 == 1
        for curve in (objects, curves.Bezier(objects), curves.KochanekBartels(objects), curves.Interpolating(objects)):
            found = local_segments(curve, kind, align=True)
            assert found.flipped.tolist() == expected.tolist()
            assert found.newly_flipped.tolist() == expected.tolist()
            plain = local_segments(curve, kind, align=False)
            assert not plain.flipped.any()
            if not isinstance(curve, curves.Curve):
                turned = np.where(expected, -1, 1)[:, None]
                np.testing.assert_array_equal(found.controls[0], plain.controls[0] * turned)


def test_the_curve_of_a_surface_is_the_one_it_shows():
    objects = circles(4, 3)
    aligned = curves.KochanekBartels(objects, align=True)
    assert aligned.flipped.any() and aligned.original_controls is objects
    kept = local_segments(aligned, "circle", align=False)
    np.testing.assert_array_equal(kept.flipped, aligned.flipped)
    again = local_segments(curves.KochanekBartels(objects), "circle", align=True)
    np.testing.assert_array_equal(again.controls, kept.controls)
    assert not kept.newly_flipped.any() and again.newly_flipped.any()
    t = np.linspace(0, 3, 10)
    assert again.curve(t).isclose(aligned(t)).all() and kept.curve is aligned
    plain = local_segments(objects, "circle", align=True).curve
    assert plain(t / 3).isclose(curves.Bezier(objects, align=True)(t / 3)).all()


@pytest.mark.parametrize("make", [
    lambda c: curves.Bezier(c), lambda c: curves.RationalBezier(c, [1, 2, 3, 1]),
    lambda c: curves.KochanekBartels(c, closed=True), lambda c: curves.Interpolating(c, [0, 1, 3, 4]),
    lambda c: curves.Hermite(c[0], {"from": c[0], "to": c[2]}, c[1], {"from": c[3], "to": c[1]}),
])  # fmt: skip
def test_turning_controls_of_a_curve(make):
    curve = make(circles(4, 3))
    which = np.arange(len(curve)) % 2 == 1
    turned = curve.with_flipped_controls(which)
    assert turned.flipped.tolist() == which.tolist() and turned.original_controls is curve.original_controls
    np.testing.assert_array_equal(turned.controls.values, curve.controls.values * np.where(which, -1, 1)[:, None])
    start, end = curve.domain
    assert turned(start).isclose(curve(start)) and turned.with_flipped_controls(which)(end).isclose(curve(end))
    if not isinstance(curve, curves.Hermite) and not isinstance(curve, curves.KochanekBartels):
        assert turned(end).isclose(-curve(end))
    with pytest.raises(errors.ShapeError, match="which has shape"):
        curve.with_flipped_controls([True])


def test_a_hermite_curve_turns_its_second_tangent_with_its_second_control():
    objects, seen = circles(4, 3), 0
    for i in range(4):
        first, second = objects[i], objects[(i + 1) % 4]
        tangents = [{"from": objects[0], "to": objects[2]}, {"from": objects[3], "to": objects[1]}]
        found = local_segments(curves.Hermite(first, tangents[0], second, tangents[1]), "circle", align=True)
        aligned = curves.Hermite(first, tangents[0], second, tangents[1], align=True)
        np.testing.assert_array_equal(found.controls, local_segments(aligned, "circle", align=False).controls)
        shares = np.array([[1, 0, 0, 0], [1, 0, 1 / 3, 0], [0, 1, 0, -1 / 3], [0, 1, 0, 0]])
        rows = np.concatenate([aligned.controls.values, aligned.tangents.values])
        here = cga.multivector(shares @ rows, kind=cga.layout("circle"))
        local = cga.dilator(1 / found.size[0]) >> (~cga.translator(found.center[0]) >> here)
        np.testing.assert_allclose(found.controls[0], local.values, atol=1e-13 * np.abs(local.values).max())
        seen += found.flipped.any()
    assert 0 < seen < 4


def test_pieces_can_be_pickled():
    found = local_segments(curves.KochanekBartels(circles(4, 3)), "circle")
    copied = pickle.loads(pickle.dumps(found))
    np.testing.assert_array_equal(copied.parameters(), found.parameters())
    assert copied.curve(1.0).isclose(found.curve(1.0))


# -- what is refused -----------------------------------------------------------------------------------------

BAD = [
    ([GOOD], "at least 2 controls, not 1"),
    ([], "at least 2"),
    ([GOOD, GOOD], "all the same circle"),
    (curves.KochanekBartels([GOOD] * 3), "3 controls are all the same"),
    ([GOOD, ((0, 0, 1), (0, 0, 1), 0.0)], r"controls\[1\].radius is 0"),
    ([GOOD, ((0, 0, 1), (0, 0, 0), 1.0)], r"controls\[1\].normal"),
    ([GOOD, ((0, np.nan, 1), (0, 0, 1), 1.0)], r"controls\[1\].center"),
    ([GOOD, ((0, 1e200, 1), (0, 0, 1), 1.0)], r"controls\[1\].center .* go to 1e\+90"),
    ([GOOD, ((0, "1", 1), (0, 0, 1), 1.0)], r"controls\[1\].center"),
    ([GOOD, ((0, 1), (0, 0, 1), 1.0)], r"controls\[1\].center has shape"),
    ([GOOD, ((0, 1, 1), (0, 0, 1))], r"controls\[1\] is not a circle"),
    ([GOOD, {"center": (0, 0, 1), "radius": 1}], r"controls\[1\] has no normal"),
    ([GOOD, cga.line((0, 0, 0), (0, 0, 1))], r"controls\[1\]"),
    (cga.circle(*GOOD), "one object"),
    ("circles", "curve is a str"),
    (3, "curve is a int"),
    (curves.Bezier([cga.sphere((0, 0, 0), 1.0), cga.sphere((1, 0, 0), 1.0)]), "one of spheres"),
    (curves.Bezier([((0, 0, 0), (0, 0, 1)), ((0, 1, 0), (0, 1, 1))]), "one of point pairs"),
    (curves.Interpolating([((i, 0, 0), (1, 0, 0), 1.0) for i in range(2001)], degree=1), "interpolates 2001 objects"),
    (curves.Bezier([GOOD, cga.line((0, 0, 0), (0, 0, 1))]), r"controls\[1\] is a line, not a circle"),
]


@pytest.mark.parametrize(("given_", "message"), BAD)
def test_bad_controls_are_named(given_, message):
    with pytest.raises(errors.SceneError, match=message):
        local_segments(given_, "circle", True)


def test_point_pairs_with_one_end_are_named():
    with pytest.raises(errors.SceneError, match=r"controls\[1\].b is .* two end points"):
        local_segments([((0, 0, 0), (0, 0, 1)), ((1, 0, 0), (1, 0, 0))], "point_pair")
    with pytest.raises(errors.InputError, match=r"controls\[1\] is not a point pair: .*end points are one"):
        curves.Bezier([((0, 0, 0), (0, 0, 1)), ((1, 0, 0), (1, 0, 0))])
    with pytest.raises(errors.InputError, match=r"controls\[0\] has no b; a point pair has a and b"):
        curves.Bezier([{"a": (0, 0, 0)}])


@pytest.mark.parametrize(("tangent", "message"), [
    ({"from": GOOD}, "v0 has no to"), ({"from": GOOD, "to": GOOD, "length": 1}, "v0 has a 'length'"),
    (GOOD, "a mapping with from, to and scale, is needed"), ({"from": GOOD, "to": ((0, 0, 0), (0, 0, 1))}, "v0.to"),
    ({"from": GOOD, "to": GOOD, "scale": "x"}, "v0.scale"),
])  # fmt: skip
def test_bad_tangents_are_named(tangent, message):
    with pytest.raises(errors.BladesmithError, match=message):
        curves.Hermite(GOOD, tangent, GOOD, {"from": GOOD, "to": GOOD})


def test_objects_of_any_weight_and_coefficients_are_read():
    objects = circles(3, 4)
    expected = local_segments(objects, "circle").controls
    x = [cga.circle(*c) for c in objects]
    for given_ in (x, cga.circle(*map(np.array, zip(*objects, strict=True))), [x[0], objects[1], x[2]],
                   [2.5 * x[0], x[1], x[2]], np.stack([c.values for c in x])):  # fmt: skip
        np.testing.assert_allclose(local_segments(given_, "circle").controls, expected, rtol=0, atol=1e-13)
