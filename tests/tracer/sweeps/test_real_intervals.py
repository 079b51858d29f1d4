"""Where the sums along curves of circles and point pairs are real, at 50 digits, and what is said where not."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mpf

from bladesmith import curves, errors, tracer
from bladesmith.codegen.programs.tracer.surface_kinds import surface_kind
from bladesmith.tracer.sweeps import imaginary_gaps, real_intervals
from bladesmith.tracer.sweeps import local_segments as segments
from bladesmith.tracer.sweeps.local_segments import local_segments

from ...oracles import circle_sums as oracle
from ...support.tracer.segments import GOOD, circles, exact

# -- where sums are real -------------------------------------------------------------------------------------


def on_a_sphere(random, n):
    """Circles of one sphere, exactly: heights and radii of Pythagorean triples over 65."""
    triples = [(16, 63), (25, 60), (33, 56), (39, 52), (63, 16), (60, 25), (56, 33), (52, 39)]
    axes = [(2, 3, 6), (-3, 6, 2), (6, 2, -3), (0, 0, 7)]  # of length 7
    chosen = []
    for _ in range(n):
        (h, r), axis, turn = triples[random.integers(8)], axes[random.integers(4)], random.choice([-1, 1])
        normal = tuple(turn * x for x in axis)
        chosen.append((tuple(float(h * x) for x in axis), tuple(map(float, normal)), float(7 * r)))
    return chosen


def gaps_of(objects, kind):
    found = local_segments(objects, kind, align=False)
    return imaginary_gaps.imaginary_gaps(found.parameters()[:, segments.CONTROLS], kind)


def assert_gaps(objects, kind, found, places=41):
    """The sum is real outside the gaps and imaginary inside, 1e-9 from their ends as well."""
    mp = [exact(x) for x in objects]
    ends = np.concatenate([found.low, found.high])
    t = np.concatenate([np.linspace(0.001, 0.999, places), ends - 1e-9, ends + 1e-9])
    for x in t[(t > 0) & (t < 1)]:
        inside = bool(((found.low < x) & (x < found.high)).any())
        assert oracle.is_real(oracle.bernstein(len(mp) - 1, mpf(float(x))), mp, kind) != inside, (x, found)


@pytest.mark.slow
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_circles_of_one_sphere_are_imaginary_where_fifty_digits_say_so(degree):
    random, seen = np.random.default_rng(degree), 0
    for _ in range(25):
        objects = on_a_sphere(random, degree + 1)
        if all(o == objects[0] for o in objects):
            continue
        found = gaps_of(objects, "circle")
        seen += len(found.row)
        if found.imaginary.all():
            assert_gaps(objects, "circle", found, places=9)
    assert seen > 3


@pytest.mark.slow
@pytest.mark.parametrize("degree", [2, 3, 5])
def test_point_pairs_are_imaginary_where_fifty_digits_say_so(degree):
    random, seen = np.random.default_rng(degree), 0
    for trial in range(400):
        objects = [tuple(map(tuple, random.normal(size=(2, 3)) + [[0, 0, 0], [1, 1, 1]])) for _ in range(degree + 1)]
        found = gaps_of(objects, "point_pair")
        seen += len(found.row)
        if len(found.row) or trial < 3:
            assert_gaps(objects, "point_pair", found, places=9)
    assert seen >= 2


def test_circles_near_a_common_sphere_have_a_gap_to_rounding_only():
    """A sphere of 65: two opposed circles have a gap; one lifted off it by 1e-9 is real, as 50 digits confirm."""
    first, second = ((0.0, 0.0, 33.0), (0.0, 0.0, 1.0), 56.0), ((0.0, 0.0, -16.0), (0.0, 0.0, -1.0), 63.0)
    gap = gaps_of([first, second], "circle")
    assert gap.imaginary.tolist() == [True]
    assert_gaps([first, second], "circle", gap)
    tilted = ((0.0, 0.0, -16.0), (1e-3, 0.0, -1.0), 63.0)
    assert not len(gaps_of([first, tilted], "circle").row)
    assert_gaps([first, tilted], "circle", gaps_of([first, tilted], "circle"))


@pytest.mark.parametrize("make", [curves.KochanekBartels, curves.Interpolating])
def test_vases_are_imaginary_where_fifty_digits_say_so(make):
    """Circles of one axis: K vanishes all along, to rounding, and the sign of S0 decides."""
    objects = [((0, 0, z), (0, 0, 1), r) for z, r in ((0, 1), (3, 0.4), (6, 0.8), (9, 0.3), (12, 0.5))]
    curve = make(objects)
    found = local_segments(curve, "circle", align=False)
    gap = imaginary_gaps.imaginary_gaps(found.parameters()[:, segments.CONTROLS], "circle")
    assert gap.imaginary.all() and len(gap.row) >= 2
    members, shares = curve.blending()
    for i in range(4):
        its = gap.row == i
        for t in np.concatenate([np.linspace(0.01, 0.99, 9), gap.low[its] - 1e-9, gap.high[its] + 1e-9]):
            inside = bool(((gap.low[its] < t) & (t < gap.high[its])).any())
            basis = oracle.bernstein(3, mpf(float(t)))
            weights = [mpmath.fsum(b * mpf(float(w)) for b, w in zip(basis, ws, strict=True)) for ws in shares[i].T]
            assert oracle.is_real(weights, [exact(objects[k]) for k in members[i]], "circle") != inside


#: Circles of one plane, as dual circles s: s0 + 2 s1 + s2 is the point where S0 has a double root, exactly.
TOUCHING = [((-1, 0, 0), (0, 0, 1), 1.0), ((0, 0.375, 0), (0, 0, 1), 0.125), ((1, 0, 0), (0, 0, 1), 1.0)]


def test_where_the_projector_is_singular_at_one_place_there_is_no_gap():
    found = gaps_of(TOUCHING, "circle")
    assert found.imaginary.tolist() == [False]
    assert found.low[0] < 0.5 < found.high[0] and found.high[0] - found.low[0] < 1e-6
    first, end, start, last, *others = asked(TOUCHING)[0, 7:15]
    assert first == 0 and last == 1 and end <= 0.5 <= start and others == [1, 0] * 2


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.integers(1, 4), st.integers(0, 10**6), st.floats(-3, 3), st.booleans())
def test_what_is_called_real_is_real(degree, seed, exponent, is_pair):
    kind = "point_pair" if is_pair else "circle"
    random = np.random.default_rng(seed)
    if is_pair:
        objects = [tuple(map(tuple, random.normal(size=(2, 3)) * 10.0**exponent)) for _ in range(degree + 1)]
    else:
        radii = 10.0 ** (exponent * random.uniform(-1, 1, degree + 1))
        objects = [(tuple(random.normal(size=3)), tuple(random.normal(size=3)), float(r)) for r in radii]
    with mpmath.workdps(50):
        assert_gaps(objects, kind, gaps_of(objects, kind), places=7)


def test_halving_keeps_the_polynomial():
    random = np.random.default_rng(2)
    p = random.normal(size=(3, 2, 6))
    halves = imaginary_gaps._subdivide(p).reshape(3, 2, 2, 6)
    for t in (0.0, 0.3, 1.0):
        basis = np.array([[float(b) for b in oracle.bernstein(5, mpf(x))] for x in (t, t / 2, t / 2 + 0.5)])
        np.testing.assert_allclose(halves[:, 0] @ basis[0], p @ basis[1], atol=1e-14)
        np.testing.assert_allclose(halves[:, 1] @ basis[0], p @ basis[2], atol=1e-14)


# -- rows and messages ---------------------------------------------------------------------------------------

OPPOSED = [((0, 0, 0), (0, 0, 1), 1.0), ((0, 0, 0), (0, 0, -1), 0.5)]


class Stub:
    def __init__(self, found, name=None):
        self.segments, self.name = found, name


def asked(curve, kind="circle", gaps=False, name=None, align=False):
    found = local_segments(curve, kind, align)
    word = "free_" if found.free else ""
    member = surface_kind(f"evolved_{kind}s_{word}{found.controls.shape[1] - 1}")
    rows = found.parameters(gaps)
    return real_intervals.with_real_intervals(member, rows, np.zeros(len(rows), int), [Stub(found, name)])


def test_an_imaginary_surface_is_named_with_its_interval_and_the_turn_that_cures_it():
    with pytest.raises(errors.SceneError) as caught:
        asked(OPPOSED, name="cup")
    text = str(caught.value)
    assert "surfaces[0] ('cup') has imaginary circles for alpha from 0.333333 to 0.666667" in text
    assert "Flip the orientation of controls[1] (align = true does)" in text and "gaps = true" in text
    assert (asked(OPPOSED, align=True)[0, 7:9] == [0, 1]).all()


def test_gaps_are_left_out_where_they_are_allowed():
    rows = asked(OPPOSED, gaps=True)
    np.testing.assert_allclose(rows[0, 7:11], [0, 1 / 3, 2 / 3, 1], atol=1e-12)
    assert rows[0, 11:15].tolist() == [1, 0, 1, 0]
    assert rows[0, 8] <= 1 / 3 and rows[0, 9] >= 2 / 3


def test_messages_use_the_curves_own_parameter():
    curve = curves.Interpolating([GOOD, *OPPOSED[1:], ((0, 0, 3), (0, 0, -1), 0.5)], [0, 2, 3], degree=1)
    expected = r"alpha from 0.66\d* to 1.33\d*.*Flip the orientation of controls\[0\]"
    with pytest.raises(errors.SceneError, match=expected):
        asked(curve)


def test_rows_that_stay_one_object_and_sizes_too_unlike_are_refused():
    linear = curves.Interpolating([GOOD, ((0, 0, 1), (0, 0, 1), 1.0), ((0, 0, 1), (0, 0, 1), 1.0)], degree=1)
    with pytest.raises(errors.SceneError, match=r"surfaces\[0\] stays one object from alpha 1 to 2"):
        asked(linear)
    with pytest.raises(errors.SceneError, match="stays one object from alpha 0 to 1"):
        asked([GOOD, ((0, 0, 0), (0, 0, -1), 1.0)])
    far = {"from": GOOD, "to": OPPOSED[1], "scale": 1e300}
    with pytest.raises(errors.SceneError, match="sizes too different"):
        asked(curves.Hermite(GOOD, far, ((0, 0, 1), (0, 0, 1), 1.0), far))
    with pytest.raises(errors.SceneError, match="not finite"):
        rows = local_segments(OPPOSED, "circle").parameters()
        rows[0, 20] = np.nan
        real_intervals.with_real_intervals(surface_kind("evolved_circles_1"), rows, np.array([0]))


def test_many_rows_are_checked_at_once():
    random = np.random.default_rng(3)
    found = [local_segments(on_a_sphere(random, 2), "circle", False) for _ in range(60)]
    found = [f for f in found if np.abs(np.abs(f.controls[0, 0]) - np.abs(f.controls[0, 1])).max() > 1e-9]
    rows = np.concatenate([f.parameters(gaps=True) for f in found])
    all_ = real_intervals.with_real_intervals(surface_kind("evolved_circles_1"), rows, np.arange(len(rows)))
    for i, f in enumerate(found):
        np.testing.assert_array_equal(all_[i], asked_row(f))
    assert (all_[:, 8] < 1).any() and (all_[:, 8] == 1).any()
    empty = real_intervals.with_real_intervals(surface_kind("evolved_circles_1"), rows[:0], np.zeros(0, int))
    assert empty.shape == (0, rows.shape[1])


def asked_row(found):
    return real_intervals.with_real_intervals(
        surface_kind("evolved_circles_1"), found.parameters(gaps=True), np.array([0])
    )[0]


def test_surfaces_follow_every_kind_of_curve():
    objects = circles(4, 11)
    for curve, degree in (
        (objects, 3), (curves.RationalBezier(objects, [1, 2, 1, 1]), 3), (curves.KochanekBartels(objects), 3),
        (curves.Interpolating(objects, degree=1), 1), (curves.Bezier(objects[:2]), 1),
    ):  # fmt: skip
        assert tracer.EvolvedCircles(curve).program_kind == f"evolved_circles_{degree}"


def test_weights_that_would_lose_roots_are_refused():
    circles = [((0.0, 0.0, z), (0.1 * z, 0.0, 1.0), 1.0) for z in (0.0, 1.0, 2.0)]
    assert tracer.EvolvedCircles(curves.RationalBezier(circles, [1e-5, 1.0, 1.0])).parameters.shape[0] == 1
    with pytest.raises(errors.SceneError, match="ends of the curve, 1e-08 and 1, are too small beside 1"):
        tracer.EvolvedCircles(curves.RationalBezier(circles, [1e-8, 1.0, 1.0]))


def test_a_band_of_a_sphere_between_two_gaps():
    """Circles of one sphere around e3, at the height z(t): real near both ends and in the middle, where |z| < 1."""
    up, down = (((0.0, 0.0, z), (0.0, 0.0, 1.0), np.sqrt(1 - z * z)) for z in (0.9, -0.9))
    rising = {"from": down, "to": up, "scale": 3.0}
    surface = tracer.EvolvedCircles(curves.Hermite(up, rising, down, rising), align=False, gaps=True)
    rng = np.random.default_rng(0)
    origins = 3 * rng.normal(size=(2000, 3))
    directions = 0.7 * rng.normal(size=(2000, 3)) - origins
    found = surface.intersect(origins, directions)
    half, square = (origins * directions).sum(axis=1), (directions**2).sum(axis=1)
    spread = half**2 - square * ((origins**2).sum(axis=1) - 1)
    reach = np.sqrt(np.maximum(spread, 0))[:, None] * (-1, 1)
    height = origins[:, 2:] + (reach - half[:, None]) / square[:, None] * directions[:, 2:]
    # every height in the middle, those near the poles once more
    want = np.where(spread[:, None] > 0, 1 + (np.abs(height) > 0.9), 0).sum(axis=1)
    assert np.bincount(want).tolist()[2:] > [1000, 100]
    np.testing.assert_array_equal(found.count, want)
    there = np.isfinite(found.t)
    np.testing.assert_allclose(np.linalg.norm(found.point[there], axis=1), 1, atol=1e-12)
