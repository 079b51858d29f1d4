"""Rays against surfaces between point pairs: the condition, its roots against the oracle, single precision."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest

from bladesmith.codegen.build.extension import compiler
from bladesmith.codegen.formulas.curves import ribbon_constants, ribbons

from ...oracles import ribbons as rs
from ...oracles.sequences import dot
from ...support.tracer.ribbons import LINEAR, on_a_circle, random_pairs, rays_near, surface_of

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")
#: Surfaces and rays of each for the oracle, which is slow, by degree.
EFFORT = {1: (4, 5), 2: (1, 7), 3: (1, 4)}


def towards(random, oracle, count, direction):
    """Rays through points of the surface: direction(normal, along, across) of each."""
    origins, directions = np.empty((2, count, 3))
    for i in range(count):
        t, place = random.uniform(0.02, 0.98), random.uniform(-0.95, 0.95)
        here, there = (np.array([float(x) for x in oracle.place(s, place)]) for s in (t, t + 1e-6))
        along = np.array([float(x) for x in oracle.shape(t)[1]])
        across = (there - here) / np.linalg.norm(there - here)
        normal = np.cross(along, across) / np.linalg.norm(np.cross(along, across))
        offset, directions[i] = direction(normal, along, across)
        origins[i] = here + offset - random.uniform(1, 3) * directions[i]
    return origins, directions


def case(family, degree, seed, count):
    """A surface, its oracle and rays of one family of input."""
    random = np.random.default_rng(1000 * degree + seed)
    pairs, shift = random_pairs(random, degree), np.zeros(3)
    if family == "cocircular":
        chords, _ = on_a_circle(random, degree)
        pairs = [(a + 10.0 ** random.uniform(-16, -6) * random.normal(size=3), b) for a, b in chords]
    if family == "far":
        shift = random.normal(size=3) * 1e6
        pairs = [(a + shift, b + shift) for a, b in pairs]
    surface, oracle = surface_of(pairs)
    if family == "tangent":

        def grazing(normal, along, across):
            return normal * random.choice([-1, 1]) * 10.0 ** random.uniform(-10, -8), across + random.normal() * along

        return surface, oracle, towards(random, oracle, count, grazing)
    if family == "parallel":

        def nearly(_normal, along, _across):
            return 0.0, along + 10.0 ** random.uniform(-6, -1) * random.normal(size=3)

        return surface, oracle, towards(random, oracle, count, nearly)
    return surface, oracle, rays_near(random, count, shift)


# -- the mathematics ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("free", [False, True])
def test_condition_is_the_meet_and_the_polynomial_both_branches(degree, free):
    random, mp = np.random.default_rng(degree), rs.MP
    oracle = rs.Oracle([[p.tolist() for p in pair] for pair in random_pairs(random, degree)])
    numbers = tuple(rs.number(c.terms.get(b, 0)) for c in oracle.controls for b in rs.BLADES)
    make = ribbon_constants.ribbon_free_constants if free else ribbon_constants.ribbon_constants
    norm, kappa, controls, products, near = (part.values for part in make(numbers))
    origin, direction = (rs.vector(random.normal(size=3)) for _ in range(2))
    meets = ribbons.ribbon_ray(origin, direction, controls, products, near[4:])[0].values
    line = rs.point(origin) ^ direction ^ origin.basis("ni")
    bernstein = ribbons.ribbon_polynomial(meets, norm, kappa).values
    powers = ribbons.ribbon_published_polynomial(meets, norm, kappa).values
    assert len(bernstein) == 6 * degree + (1 if free else -1) and len(powers) == 6 * degree + 1
    for t in map(mp.mpf, ("0.1", "0.45", "0.93")):
        a, b = rs.number(1 - t), rs.number(t)
        direct = (line & oracle.pair(t)).grade(0).scalar()
        assert mp.almosteq(ribbons.ribbon_meet(meets, norm, kappa, a, b).value.scalar(), direct, 1e-40)
        n = len(bernstein) - 1
        p = sum(c.scalar() * comb(n, k) * t**k * (1 - t) ** (n - k) for k, c in enumerate(bernstein))
        printed = sum(c.scalar() * t**k for k, c in enumerate(powers))
        assert mp.almosteq(printed, p * (1 if free else t * (1 - t)), 1e-35)
        raw, s0, other, s2 = oracle._parts(t)
        branches = [(s0 + s) * (line & raw).grade(0).scalar() for s in (mp.sqrt(s2), -mp.sqrt(s2))]
        expected = [x - (line & other).grade(0).scalar() for x in branches]
        assert mp.almosteq(expected[0] * expected[1], printed, 1e-35)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_normals_are_those_of_differences_at_50_digits(degree):
    random, mp = np.random.default_rng(20 + degree), rs.MP
    oracle = rs.Oracle([[p.tolist() for p in pair] for pair in random_pairs(random, degree)])
    numbers = tuple(rs.number(c.terms.get(b, 0)) for c in oracle.controls for b in rs.BLADES)
    constants = [part.values for part in ribbon_constants.ribbon_constants(numbers)[:4]]
    step = mp.mpf(10) ** -15
    for t, place in ((mp.mpf("0.2"), mp.mpf("0.7")), (mp.mpf("0.85"), mp.mpf("-0.4"))):
        moved = [(t + step, place), (t - step, place), (t, place + step), (t, place - step)]
        p = [oracle.place(*at) for at in moved]
        u, v = ([x - y for x, y in zip(p[i], p[i + 1], strict=True)] for i in (0, 2))
        normal = [u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2] for i in range(3)]
        position, a, b = rs.vector(oracle.place(t, place)), rs.number(1 - t), rs.number(t)
        got = rs.coordinates(ribbons.ribbon_normal(position, *constants[:2], a, b, *constants[2:]))
        assert 1 - abs(dot(got, normal)) / mp.sqrt(dot(normal, normal)) < mp.mpf(10) ** -25


# -- against the oracle ------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("family", ["random", "tangent", "far", "cocircular", "parallel"])
def test_every_root_is_found_and_no_other(family, degree):
    surfaces, rays = EFFORT[degree]
    hits = 0
    for seed in range(surfaces):
        surface, oracle, (origins, directions) = case(family, degree, seed, rays)
        found = surface.intersect(origins, directions)
        total, lost, false, worst = rs.compare(oracle, found, origins, directions, 1e-8)
        assert (lost, false) == (0, 0), (family, degree, seed)
        assert worst < (1e-8 if family in ("tangent", "parallel") else 1e-11)
        units = directions / np.linalg.norm(directions, axis=1)[:, None]
        points = origins[:, None] + found.t[..., None] * units[:, None]
        np.testing.assert_allclose(found.point, points, atol=1e-12 * (1e6 if family == "far" else 1e2))
        hits += total
    assert hits > 0


@pytest.mark.slow
@pytest.mark.parametrize(("family", "degree"), [("random", 1), ("far", 1), ("cocircular", 1), ("random", 2)])
def test_single_precision(family, degree):
    hits = wrong = 0
    for seed in range(4 if degree == 1 else 1):
        surface, oracle, (origins, directions) = case("random" if family == "far" else family, degree, seed, 8)
        rays = [x.astype(np.float32) for x in (origins, directions)]
        found = surface.intersect(*rays)
        assert found.t.dtype == np.float32
        total, lost, false, _ = rs.compare(oracle, found, *rays, 1e-3)
        hits, wrong = hits + total, wrong + lost + false
    assert hits > 1 and wrong == 0


def test_printed_methods_find_what_they_can():
    """Rays through the surface: the companion's filter and the samples lose some, and invent none."""
    random = np.random.default_rng(5)
    surface, _ = surface_of(LINEAR)
    origins, directions = rays_near(random, 2000)
    sure = surface.intersect(origins, directions)
    companion = surface.intersect(origins, directions, method="companion")
    sampled = surface.intersect(origins, directions, method="sampled", samples=500)
    assert np.mean(companion.count == sure.count) > 0.99 and np.mean(sampled.count == sure.count) > 0.99
    same = (companion.count == sure.count) & (sampled.count == sure.count)
    width = min(x.alpha.shape[1] for x in (sure, companion, sampled))
    np.testing.assert_allclose(companion.alpha[same, :width], sure.alpha[same, :width], atol=1e-6)
    np.testing.assert_allclose(sampled.alpha[same, :width], sure.alpha[same, :width], atol=1e-6)
