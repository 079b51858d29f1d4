"""Rays against a surface evolved between two circles: isolate, companion and sampled against 50 digits."""

import mpmath as mp
import numpy as np
import pytest
from mpmath import mpf

from bladesmith.codegen.build.extension import compiler

from ...oracles import evolved_roots as es

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

FAMILIES = ("random", "tube", "cospherical")
UP, ORIGIN = [0, 0, 1], [0, 0, 0]


@pytest.fixture(autouse=True)
def precision():
    with mp.workdps(es.DIGITS):
        yield


def isolate(surface, ray, dtype=np.float64):
    """Roots and status of one ray whose scalars are exact up to their last rounding."""
    nine, two = (es.as_floats(x, dtype) for x in (surface.ray(ray), surface.constants))
    roots, counts = es.solve("isolate", nine, two, dtype, nearness=surface.nearness)
    return [float(r) for r in roots[0]], int(counts[0])


def vectors(seed, count):
    return np.random.default_rng(seed).normal(size=(count, 3)).tolist()


def values_of(surface, given, a):
    """What the kernels make of a ray at a: f, the condition, its derivative, and what its rounding is relative to."""
    ray, values = np.array([es.as_floats(given)]), np.zeros(4)
    row = es.rows(ray, np.array([es.as_floats(surface.constants)]), [1.0], np.float64)
    es.call("values", np.float64, ray[0], row[0], float(a), values)
    return values


# -- the mathematics ---------------------------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize("seed", range(12))
def test_condition_is_the_square_of_the_meet(seed):
    """The meets give (L v C)^2, for S0 < 0 too, and the octic is the product of both branches."""
    surface, ray = es.pair("random", seed)
    given, (m0, kappa) = surface.ray(ray), surface.scalars
    nine = es.squares(given)
    for a in (mpf("0.2"), mpf("0.55"), mpf("0.9")):
        b, ab = 1 - a, a * (1 - a)
        s0 = a * a + b * b + ab * m0
        square = s0 * s0 - kappa * ab * ab
        f, direct = es.condition(given, m0, kappa, a), surface.meet_square(ray, a)
        assert (f is None) == (direct is None)
        u, x, e = (nine[i] * b * b + nine[i + 1] * ab + nine[i + 2] * a * a for i in (0, 3, 6))
        sums = s0 + mp.sqrt(square), s0 - mp.sqrt(square)
        branches = [t * (t * u - 2 * ab * x) + ab * ab * e for t in sums]
        p8 = sum(p * a**k * b ** (8 - k) for k, p in enumerate(es.octic(given, m0, kappa)))
        assert mp.almosteq(p8 * ab * ab, branches[0] * branches[1], 1e-35)
        if f is not None:
            assert mp.almosteq(f[0] / (2 * square * sums[0]), direct, 1e-35)
            rate = mp.diff(lambda z: es.condition(given, m0, kappa, z)[0], a)
            assert values_of(surface, given, a)[:3] == pytest.approx(
                [float(direct), float(f[0]), float(rate)], rel=1e-11
            )


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 4))])
def test_printed_polynomial_has_four_roots_too_many(seed):
    surface, ray = es.pair("random", seed)
    meets, two = (es.as_floats(x) for x in (surface.ray(ray), surface.constants))
    powers = np.zeros((1, 13))
    given = np.array([meets])
    es.call("printed", np.float64, 1, given, es.rows(given, np.array([two]), [1.0], np.float64), powers)
    factor = es.powers([0, 0, 1, 0, 0])  # a^2 b^2
    p8 = es.powers(es.octic([mpf(x) for x in meets], *map(mpf, two[:2])))
    want = [float(c) for c in es.convolve(p8, factor)]
    np.testing.assert_allclose(powers[0], want, rtol=0, atol=1e-12 * np.abs(want).max())


@pytest.mark.parametrize(("dtype", "accuracy"), [(np.float64, 1e-7), (np.float32, 2e-2)])
def test_companion_roots_are_those_of_numpy(dtype, accuracy):
    """Backward stable: the found roots' polynomial is the given one."""
    rng = np.random.default_rng(8)
    for trial in range(200):
        powers = (rng.normal(size=13) * 10.0 ** rng.uniform(-2, 2, 13)).astype(dtype)
        if trial % 5 == 0:
            powers[-1 - trial % 3 :] = 0  # highest powers missing
        re, im = np.zeros(12, dtype), np.zeros(12, dtype)
        count = es.call("eigenvalues", dtype, 12, powers, re, im)
        degree = int(np.flatnonzero(powers)[-1])
        assert count == degree
        found = sorted(re[:count].astype(complex) + 1j * im[:count], key=abs)
        for root in np.roots(powers[degree::-1].astype(float)):
            nearest = min(found, key=lambda z: abs(z - root))
            assert abs(nearest - root) <= accuracy * max(1, abs(root)), (powers, root, nearest)


# -- against the reference ---------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_isolate_finds_every_root_and_no_other(family):
    for seed in range(80):
        surface, ray = es.pair(family, seed)
        got, count = isolate(surface, ray)
        want = es.reference(surface.ray(ray), *surface.scalars)
        assert es.matched(want, got, 1e-10)[:2] == (0, 0) and count == len(want), (family, seed, want, got)
        assert got == sorted(got)


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_isolate_in_single_precision(family):
    """Against the reference of the rounded scalars. An M4 that is nothing but rounding is taken for zero."""
    for seed in range(60):
        surface, ray = es.pair(family, seed)
        nine, two = (es.as_floats(x, np.float32) for x in (surface.ray(ray), surface.constants))
        if abs(two[1]) < (32 * 6e-8 * max(1, abs(two[0]))) ** 2:
            continue
        roots, _ = es.solve("isolate", nine, two, np.float32, nearness=surface.nearness)
        want = es.reference([mpf(x) for x in nine], *map(mpf, two[:2]))
        assert es.matched(want, roots[0], 1e-4)[:2] == (0, 0), (family, seed, want, roots[0])


def test_printed_methods_find_what_they_can():
    pairs = [es.pair("random", seed) for seed in range(60)]
    rays = [es.as_floats(surface.ray(ray)) for surface, ray in pairs]
    surfaces = [es.as_floats(surface.constants) for surface, _ in pairs]
    truth, _ = es.solve("isolate", rays, surfaces)
    total = sum(map(len, truth))
    for method, samples, reach, losses in (("companion", 0, 1e-5, 0.1), ("sampled", 512, 1e-3, 0.05)):
        found, _ = es.solve(method, rays, surfaces, samples=samples)
        results = [es.matched(w, g, reach) for w, g in zip(truth, found, strict=True)]
        assert sum(r[0] for r in results) <= losses * total
        assert sum(r[1] for r in results) == 0
    assert total > 40


# -- the edges ---------------------------------------------------------------------------------------------


def tangent(surface, ray, a):
    """Meets of the ray, h of both circles' changed so that f and its derivative vanish at a; None where imaginary."""
    given, two = surface.ray(ray), surface.scalars
    if any(es.condition(given, *two, z) is None for z in (a - mpf("0.01"), a, a + mpf("0.01"))):
        return None
    moved = lambda p, q: [*given[:2], given[2] + p, *given[3:5], given[5] + q, *given[6:]]  # noqa: E731
    whole = lambda z: es.condition(given, *two, z)[0]  # noqa: E731
    part = [lambda z, x=x: es.condition(moved(*x), *two, z)[0] - whole(z) for x in ((1, 0), (0, 1))]  # f is linear in h
    matrix = mp.matrix([[p(a) for p in part], [mp.diff(p, a) for p in part]])
    return moved(*mp.lu_solve(matrix, mp.matrix([-whole(a), -mp.diff(whole, a)])))


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("place", ["0.5", "0.3141"])
def test_tangent_rays(family, place):
    """Two roots as far as arithmetic tells, one within rounding of tangency, then none."""
    seen, a = 0, mpf(place)
    for seed in range(5):
        surface, ray = es.pair(family, seed)
        touching = tangent(surface, ray, a)
        if touching is None:
            continue
        two = es.as_floats(surface.constants)
        for shift in (0, *(s * 10.0**-k for k in (3, 6, 12, 13, 14, 15, 16) for s in (1, -1))):
            nine = es.as_floats([*touching[:4], touching[4] * (1 + mpf(shift)), *touching[5:]])
            given = [mpf(x) for x in nine]
            near, bound = es.condition(given, *map(mpf, two[:2]), a)[0], values_of(surface, given, a)[3]
            want = es.reference(given, *map(mpf, two[:2]))
            roots, _ = es.solve("isolate", nine, two, nearness=surface.nearness)
            got = list(roots[0])
            lost, false, _ = es.matched(want, got, 1e-6)
            if abs(near) > 64 * 2.0**-53 * bound:
                assert (lost, false) == (0, 0), (family, seed, shift, want, got)
            else:
                assert abs(len(want) - len(got)) <= 2
                assert shift or any(abs(r - float(a)) < 1e-7 for r in got)
                others = [r for r in got if all(abs(r - w) > 1e-6 for w in want)]
                assert all(abs(r - float(a)) < 1e-6 for r in others)
            seen += 1
    assert seen >= 30


def test_touching_rays_are_reported_once():
    """A ray in the plane of one circle, where the meet vanishes; half way down is the first piece's end."""
    top, bottom = es.circle([0, 0, 1], UP, mpf(1)), es.circle([0, 0, -1], UP, mpf(1))
    for height in ("0", "0.3", "-0.75"):
        roots, count = isolate(es.Surface(top, bottom), es.line([0, mpf("0.2"), mpf(height)], [1, 0, 0]))
        assert count == 1 and roots[0] == pytest.approx((1 + float(height)) / 2, abs=1e-12)


@pytest.mark.parametrize("family", ["random", "tube", "apart"])
def test_ends_belong_to_the_surface(family):
    """Rays through points of the end circles: the root there is found, wherever it is rounded to."""
    for seed in range(12):
        points = vectors([seed, len(family)], 7)
        shared = es.circle_through(*points[:3])
        other = es.circle_through(*points[3:6]) if family == "random" else es.circle_through(
            *([x + 0.3 * y + (4 if family == "apart" else 0.5) for x, y in zip(p, q, strict=True)]
              for p, q in zip(points[:3], points[3:6], strict=True))
        )  # fmt: skip
        ray = es.line(points[0], points[6])
        for surface, end in ((es.Surface(shared, other), 1.0), (es.Surface(other, shared), 0.0)):
            for dtype in (np.float64, np.float32):
                roots, count = isolate(surface, ray, dtype)
                assert count >= 1, (seed, end)
                assert min(abs(r - end) for r in roots) < 64 * np.finfo(dtype).eps, (seed, end, roots)
                assert all(0 <= r <= 1 for r in roots)


@pytest.mark.parametrize("turn", [1, -1])
def test_circles_that_share_a_point(turn):
    """M4 is null: kappa vanishes, the octic does not. Reversed, a part of the surface may be imaginary."""
    found = 0
    for seed in range(12):
        points = vectors(seed, 7)
        c1, c2 = es.circle_through(*points[:3]), es.circle_through(points[0], *points[3:5])
        surface = es.Surface(c1 if turn == 1 else es.reverse(c1), c2)
        assert abs(surface.kappa) < 1e-40
        surface.kappa = mpf(0)
        ray = es.line(*points[5:])
        got, count = isolate(surface, ray)
        want = es.reference(surface.ray(ray), *surface.scalars)
        assert es.matched(want, got, 1e-10)[:2] == (0, 0), (seed, want, got)
        found += count
    assert found > 3


def test_identical_and_opposite_circles():
    """The same circle all the way: a ray meets it always or never. Its own reverse: nothing half way."""
    for seed in range(12):
        points = vectors(seed, 5)
        c = es.circle_through(*points[:3])
        for surface in (es.Surface(c, c), es.Surface(es.reverse(c), c)):
            for dtype in (np.float64, np.float32):
                assert isolate(surface, es.line(*points[3:]), dtype) == ([], 0)


def test_cospherical_circles_of_every_nearness():
    """M4 from 1 down to nothing: the roots move by as much as the circles do, none comes or goes."""
    tilt = lambda size: [size, 0.3 * size, 1]  # noqa: E731
    ray = es.line([0.3, 0.1, 0.2], [1, 0.2, 0.4])
    counts = set()
    for k in (1, 2, 4, 6, 8, 10, 12, 14, 15, 16, 17, 20, 30, 40):
        shift = mpf(10) ** -k
        top, bottom = es.circle([shift, 0, 1], tilt(shift), mpf(1)), es.circle([0, shift, -1], UP, mpf(1))
        surface = es.Surface(top, bottom)
        got, count = isolate(surface, ray)
        want = es.reference(surface.ray(ray), *surface.scalars) if k < 30 else got
        assert es.matched(want, got, 1e-10)[:2] == (0, 0), (k, want, got)
        counts.add(count)
    assert counts == {2}


def test_imaginary_gap():
    """Where S0 falls below a b sqrt(kappa) nothing is found; roots on both sides of it are."""
    rng, found = np.random.default_rng(4), 0
    for trial in range(40):
        nine, two = rng.normal(size=12), [-rng.uniform(2.05, 6), rng.uniform(0, 4) if trial % 2 else 0.0]
        roots, _ = es.solve("isolate", nine, two)
        want = es.reference([mpf(x) for x in nine], *map(mpf, two))
        assert es.matched(want, roots[0], 1e-10)[:2] == (0, 0), (nine, two, want, roots)
        found += len(want)
    assert found > 20


def test_opposite_circles_on_a_sphere():
    """M4 = 0 and S0 < 0 half way: only the real parts of the surface are hit."""
    found = 0
    for seed in range(30):
        origin, direction = vectors(seed, 2)
        north = es.circle([0, 0, mpf("0.6")], UP, mpf("0.8"))
        south = es.circle([0, 0, mpf("-0.8")], UP, mpf("0.6"))
        surface, ray = es.Surface(es.reverse(north), south), es.line([0.6 * x for x in origin], direction)
        m0, u = surface.m0, es.squares(surface.ray(ray))[:3]
        sphere = mp.polyroots(es.powers(u)[::-1], maxsteps=200, extraprec=200)
        real = [mp.re(z) for z in sphere if abs(mp.im(z)) < es.SAME and 0 <= mp.re(z) <= 1]
        want = [float(a) for a in real if a * a + (1 - a) ** 2 + a * (1 - a) * m0 > 0]
        for dtype, reach in ((np.float64, 1e-10), (np.float32, 1e-4)):
            got, _ = isolate(surface, ray, dtype)
            assert es.matched(want, got, reach)[:2] == (0, 0), (seed, dtype, want, got)
        found += len(want)
    assert found >= 10


def test_ray_that_meets_every_circle():
    """f vanishes identically: in the plane of coplanar circles; all scalars zero."""
    disc = es.Surface(es.circle(ORIGIN, UP, mpf(1)), es.circle([mpf("0.3"), 0, 0], UP, mpf("0.4")))
    assert isolate(disc, es.line([0.2, 0.1, 0], [1, 2, 0])) == ([], es.VANISHES)
    assert isolate(disc, es.line([0.7, 0.1, 0], [1, 2, 3]))[1] == 1
    assert es.solve("isolate", [0] * 12, [1, -2])[1] == es.VANISHES
    assert es.solve("isolate", [0] * 12, [1, -2], nearness=0)[1] == es.VANISHES


def test_numbers_that_are_not_finite():
    for bad in (np.nan, np.inf, -np.inf):
        for place in range(14):
            values = [0.4, -1, 0.3, 0.1, 0.2, 0.3, -0.1, 0.2, -0.5, 0.3, 0.1, 0.7, 1.0, -2.0]
            values[place] = bad
            for method in es.METHODS:
                roots, count = es.solve(method, values[:12], values[12:])
                assert count[0] == es.INVALID if method == "isolate" else count[0] >= 0


def test_room_for_fewer_roots():
    surface, ray = next(
        (s, r) for s, r in (es.pair("random", k) for k in range(99)) if isolate(s, r)[1] > 1
    )  # fmt: skip
    nine, two = es.as_floats(surface.ray(ray)), es.as_floats(surface.constants)
    for method in es.METHODS:
        whole, _ = es.solve(method, nine, two, samples=256)
        first, count = es.solve(method, nine, two, samples=256, most=1)
        assert count[0] == 1
        if method == "isolate":
            assert first[0][0] == whole[0][0]
