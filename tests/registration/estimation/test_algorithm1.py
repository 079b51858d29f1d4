"""Costs of pairs with their rates, and the steps of Algorithm 1, against differences and geometry at 50 digits."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import objects
from bladesmith.codegen.algebra.multivector import Multivector, from_values
from bladesmith.codegen.formulas.objects import costs
from bladesmith.codegen.formulas.objects.blades import project_to_blade
from bladesmith.codegen.formulas.registration import estimation, registration
from bladesmith.codegen.programs.registration.registration import DIRECTED

from ...oracles.registration import (
    ALGEBRA,
    MP,
    RING,
    TINY,
    coefficients,
    largest,
    magnitude,
    motor,
    moved,
    near,
    number,
    plus,
    scalar,
    thing,
    twists,
    up,
    values,
    vector,
)
from ...support.formulas import series_exp
from ...support.registration import KINDS

# -- costs and their rates ---------------------------------------------------------------------------------


def close_pair(kind: str, seed: int) -> tuple[Multivector, Multivector]:
    """An object and one like it, a quarter of a motion away: some rotors dilate."""
    x, other = thing(kind, seed), thing(kind, seed + 1)
    r = registration.near_motor(number(3) + motor(seed))
    if kind in ("point", "line", "plane"):
        return x.x, moved(r, x.x)
    if kind == "sphere":
        return x.x, costs.align(moved(r, other.x), x.x)
    mixed = x.x + moved(r, other.x) * number(MP.mpf("0.1"))
    return x.x, costs.align(project_to_blade(mixed).grade(*x.x.grades), x.x)


def rotor_error(x: Multivector, y: Multivector) -> list:
    """Coefficients of R - 1 and of R . e_+, on the orthonormal basis."""
    r = costs.any_rotor(x, y)
    return coefficients(r - 1) + coefficients(costs.parallel(r))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_rates_of_the_positive_cost(kind):
    x, y = close_pair(kind, 2)
    h = MP.mpf(10) ** -17
    cost, gradient, matrix = (values(r) for r in registration.cost_rates(x, y))
    error = rotor_error(x, y)
    assert abs(cost[0] - sum(e * e for e in error)) < TINY
    rates = []
    for b in twists():
        ahead, back = (rotor_error(moved(near(number(1), b, s), x), y) for s in (h, -h))
        rates.append([(p - q) / (2 * h) for p, q in zip(ahead, back, strict=True)])
    scale = 1 + max(abs(v) for v in gradient)
    for g, d in zip(gradient, rates, strict=True):
        assert abs(g - 2 * sum(a * b for a, b in zip(error, d, strict=True))) < scale * MP.mpf(10) ** -28
    upper = [(i, j) for i in range(6) for j in range(i, 6)]
    for m, (i, j) in zip(matrix, upper, strict=True):
        expected = 2 * sum(a * b for a, b in zip(rates[i], rates[j], strict=True))
        assert abs(m - expected) < (1 + abs(expected)) * MP.mpf(10) ** -28
    if kind != "point":  # turned round it is the same object
        for a, b in zip((cost, gradient), registration.cost_rates(x, -y)[:2], strict=True):
            assert max(abs(p - q) for p, q in zip(a, values(b), strict=True)) < TINY
    r = motor(4)
    for a, b in zip(registration.moved_rates(r, moved(~r, x), y), (cost, gradient, matrix), strict=True):
        assert max(abs(p - q) for p, q in zip(values(a), b, strict=True)) < TINY * scale
    blades = ALGEBRA.kind(kind).blades
    one, two = (cga.wrap(cga.kind(kind), np.array([float(z.terms.get(b, 0)) for b in blades])) for z in (x, y))
    np.testing.assert_allclose(objects.rotor_cost(objects.rotor_between(one, two)), float(cost[0]), rtol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_rates_of_the_printed_cost(kind):
    x, y = close_pair(kind, 4)
    h, r = MP.mpf(10) ** -17, motor(6)
    x = moved(~r, x)

    def cost(motion):
        return scalar(costs.rotor_cost_thesis(costs.any_rotor(moved(motion, x), y)))

    found, gradient = (values(part) for part in estimation.printed_rates(r, x, y))
    assert abs(found[0] - cost(r)) < TINY
    for g, b in zip(gradient, twists(), strict=True):
        expected = (cost(near(r, b, h)) - cost(near(r, b, -h))) / (2 * h)
        assert abs(g - expected) < (1 + abs(expected)) * MP.mpf(10) ** -28


@pytest.mark.parametrize("size", ["0", "1e-30", "0.7", "2.9"])
def test_rates_of_an_exponential(size):
    random, h = np.random.default_rng(5), MP.mpf(10) ** -17
    b = from_values(
        ALGEBRA, RING, ALGEBRA.kind("twist").blades, [MP.mpf(v) * MP.mpf(size) for v in random.normal(size=6)]
    )
    motor_, rates = estimation.motor_rates(b)
    assert largest(motor_ - series_exp(b)) < TINY
    rows = values(rates)
    for i, e in enumerate(twists()):
        slope = (series_exp(b + e * number(h)) - series_exp(b - e * number(h))) * number(1 / (2 * h))
        twist = from_values(ALGEBRA, RING, list(b.terms), rows[6 * i : 6 * i + 6])
        assert largest(slope - twist * motor_) < MP.mpf(10) ** -28


# -- steps of Algorithm 1 ----------------------------------------------------------------------------------


def carried(x: Multivector, kind: str) -> list[Multivector]:
    """An object, or the centre and axis of a round, by their parameters."""
    if kind in ("point", "line", "plane"):
        return [x]
    e = values(registration.element(x))
    place = up(e[:3])
    return [place] if kind == "sphere" else [place, (place ^ vector(e[3:6]) ^ place.basis("ni")).grade(3)]


@pytest.mark.parametrize("kind", KINDS)
def test_a_half_step_made_twice_is_the_whole_way(kind):
    r = motor(1)
    x, y = moved(~r, thing(kind, 1).x), thing(kind, 2).x
    step = estimation.half_step(r, x, y, number(1))
    assert largest(step * ~step - 1) < TINY
    stays = estimation.half_step(r, x, moved(r, x), number(1))
    assert largest(stays - r) < TINY
    half = step * ~r
    for p, q in zip(carried(moved(r, x), kind), carried(y, kind), strict=True):
        if kind in ("circle", "point_pair") and p.grades == (1,):  # the centre goes first, half of its way
            a, b = (values(registration.element(z))[:3] for z in (moved(r, x), y))
            first = 1 - vector([(v - u) / 2 for u, v in zip(a, b, strict=True)]) * p.basis("ni") / 2
            half = half * ~first
        else:
            first = number(1) if kind not in ("circle", "point_pair") else first
            assert largest(moved(half * half, moved(first, p)) - q) < TINY
    if kind in DIRECTED:
        other = estimation.half_step(r, x, -y, number(-1))
        assert largest(other - step) < TINY


@pytest.mark.parametrize("kind", ["point", "sphere"])
def test_a_half_step_of_two_turns_towards_the_other_one(kind):
    x, x2, y, y2 = (thing(kind, s) for s in (1, 2, 3, 4))
    step = estimation.half_step_of_two(number(1), x.x, y.x, x2.x, y2.x)
    assert largest(step * ~step - 1) < TINY

    def angle(a, b, c, d):
        u, v = (plus(q, (-1, p)) for p, q in ((a, b), (c, d)))
        dot, sizes = sum(s * t for s, t in zip(u, v, strict=True)), [sum(s * s for s in w) for w in (u, v)]
        return MP.acos(dot / MP.sqrt(sizes[0] * sizes[1]))

    ends = [[values(registration.element(moved(step, t.x)))[:3] for t in (x, x2)][i] for i in (0, 1)]
    before = angle(x.place, x2.place, y.place, y2.place)
    assert abs(angle(*ends, y.place, y2.place) - before / 2) < TINY
    r = motor(3)
    same = estimation.half_step_of_two(r, x.x, moved(r, x.x), x2.x, moved(r, x2.x))
    assert largest(same - r) < TINY
    lost = estimation.half_step_of_two(number(1), x.x, y.x, x.x, y.x)
    assert any(MP.isnan(c) for c in lost.terms.values())


def test_objects_that_face_each_other_have_no_half_step():
    x = thing("line", 1).x
    lost = estimation.half_step(number(1), x, x, number(-1))
    assert any(MP.isnan(c) for c in lost.terms.values())


def test_the_change_of_a_motor_does_not_see_its_sign():
    a, b = motor(1), motor(2)
    step = a * ~b
    expected = MP.sqrt(min(magnitude(step - 1), magnitude(step + 1)))
    for one, two in ((a, b), (-a, b), (a, -b)):
        assert abs(values(estimation.change(one, two))[0] - expected) < TINY
    assert values(estimation.change(a, -a))[0] < MP.mpf(10) ** -20
