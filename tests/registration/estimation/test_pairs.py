"""What one pair of objects says of a motor, and what no motor changes, against geometry at 50 digits."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith.codegen.algebra.multivector import from_values
from bladesmith.codegen.formulas.registration import registration
from bladesmith.codegen.programs.registration.registration import DIRECTED
from bladesmith.dispatch.formulas import evaluate

from ...oracles.registration import (
    ALGEBRA,
    MP,
    PAIRS,
    RING,
    TINY,
    largest,
    magnitude,
    motor,
    moved,
    near,
    number,
    stabiliser,
    thing,
    twists,
    up,
    values,
    vector,
)
from ...support.registration import KINDS

# -- what a motor sees -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_elements_are_parameters(kind):
    for seed in range(3):
        t = thing(kind, seed)
        found = values(registration.element(t.x))
        assert max(abs(a - b) for a, b in zip(found, t.element, strict=True)) < TINY
        r = motor(seed)
        there = values(registration.moved_element(r, t.x))
        again = values(registration.element(moved(r, t.x)))
        assert max(abs(a - b) for a, b in zip(there, again, strict=True)) < TINY
        if kind in DIRECTED:  # a moved direction is the turned one
            turned = moved(r.grade(0, 2).new({b: c for b, c in r.terms.items() if b < 8}), vector(t.along))
            assert largest(vector(there[3:6]) - turned) < TINY
        if kind not in ("line", "plane"):
            assert largest(up(there[:3]) - moved(r, up(t.place))) < TINY


@pytest.mark.parametrize("kind", KINDS)
def test_carriers_move_with_the_object_and_leave_nothing_but_its_symmetry(kind):
    t, r = thing(kind, 1), motor(2)
    own = registration.carriers(t.x, number(1))
    for a, b in zip(own, registration.carriers(moved(r, t.x), number(1)), strict=True):
        assert largest(moved(r, a) - b) < TINY
    turned = registration.carriers(-t.x, number(-1)) if kind in DIRECTED else own
    for a, b in zip(own, turned, strict=True):
        assert largest(a - b) < TINY
    free_of_all = stabiliser(*own)
    expected = {"point": 3, "sphere": 3, "line": 2, "plane": 3, "circle": 1, "point_pair": 1}[kind]
    assert free_of_all.shape[1] == stabiliser(t.x).shape[1] == expected


@pytest.mark.parametrize("kind", KINDS)
def test_motor_form_is_the_square_of_what_is_left(kind):
    x, y = thing(kind, 1).x, thing(kind, 2).x
    random = np.random.default_rng(3)
    order = registration.motor_blades(ALGEBRA)
    for sign in (1, -1):
        form = values(registration.motor_form(x, y, number(sign)))
        left, right = registration.carriers(x, number(1)), registration.carriers(y, number(sign))
        for _ in range(2):  # any numbers: it is a form on all of them
            c = [MP.mpf(v) for v in random.normal(size=8)]
            r = from_values(ALGEBRA, RING, order, c)
            found = sum(
                (1 if i == j else 2) * a * c[i] * c[j]
                for a, (i, j) in zip(form, [(i, j) for i in range(8) for j in range(i, 8)], strict=True)
            )
            expected = sum(magnitude(r * a - b * r) for a, b in zip(left, right, strict=True))
            assert abs(found - expected) < TINY * (1 + expected)
        r = motor(5)
        c = [r.terms.get(b, MP.mpf(0)) for b in order]
        target = number(sign) * moved(r, x) if kind in DIRECTED else moved(r, x)
        form = values(registration.motor_form(x, target, number(sign)))
        pairs = [(i, j) for i in range(8) for j in range(i, 8)]
        zero = sum((1 if i == j else 2) * a * c[i] * c[j] for a, (i, j) in zip(form, pairs, strict=True))
        assert abs(zero) < TINY


def test_the_nearest_motor_is_a_motor_and_steps_are_exponentials_to_first_order():
    random, order = np.random.default_rng(1), registration.motor_blades(ALGEBRA)
    for seed in range(3):
        raw = from_values(ALGEBRA, RING, order, [MP.mpf(v) for v in random.normal(size=8)])
        unit = registration.near_motor(raw)
        assert largest(unit * ~unit - 1) < TINY
        assert largest((unit * ~raw).grade(2)) < TINY  # raw is it times a scalar and a pseudoscalar: nothing turned
        r = motor(seed)
        assert largest(registration.near_motor(r * number(3)) - r) < TINY
        h = MP.mpf(10) ** -18
        for b in twists():
            assert largest(registration.step_motor(r, b * number(h)) - near(r, b, h)) < 10 * h * h


# -- invariants --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("first", "second"), PAIRS, ids=lambda kind: kind)
def test_no_motion_changes_the_invariants_of_a_pair(first, second):
    x, y = thing(first, 1).x, thing(second, 2).x
    before = values(registration.pair_invariants(x, y))
    after = values(registration.pair_invariants(*(moved(motor(7), z) for z in (x, y))))
    assert max(abs(a - b) for a, b in zip(before, after, strict=True)) < TINY
    turned = values(registration.pair_invariants(-x if first in DIRECTED else x, y))
    assert max(abs(a - b) for i, (a, b) in enumerate(zip(before, turned, strict=True)) if i != 1) < TINY
    both_directed = {first, second} <= DIRECTED
    assert abs(turned[1] + (before[1] if both_directed else -before[1])) < TINY


@pytest.mark.slow
@pytest.mark.parametrize(("first", "second"), PAIRS, ids=lambda kind: kind)
def test_invariants_say_as_much_as_there_is(first, second):
    """Of six relative motions those count that neither object swallows; the invariants tell as many, no more."""
    a, b = thing(first, 3), thing(second, 4)
    swallowed = np.linalg.matrix_rank(np.hstack([stabiliser(a.x), stabiliser(b.x)]), tol=1e-9)
    h = MP.mpf(10) ** -20
    rates = []
    for twist in twists():
        ahead, back = (
            values(registration.pair_invariants(moved(near(number(1), twist, s), a.x), b.x)) for s in (h, -h)
        )
        rates.append([float((p - q) / (2 * h)) for p, q in zip(ahead, back, strict=True)])
    told = np.linalg.matrix_rank(np.array(rates), tol=1e-9)
    assert told == 6 - swallowed


def test_invariants_are_the_distances_and_angles_that_they_are_said_to_be():
    def found(first, second):
        a, b = thing(first, 1), thing(second, 2)
        return [float(v) for v in values(registration.pair_invariants(a.x, b.x))], a, b

    def parts(t):
        return (np.array(v, float) for v in (t.place, t.along))

    for first, second in (("point", "sphere"), ("circle", "circle"), ("point_pair", "circle")):
        numbers, a, b = found(first, second)
        (p, m), (q, n) = parts(a), parts(b)
        along = [abs((q - p) @ d) if t.kind in DIRECTED else 0 for d, t in ((m, a), (n, b))]
        cosine = m @ n if {first, second} <= DIRECTED else 0
        np.testing.assert_allclose(numbers, [np.linalg.norm(q - p), cosine, *along], atol=1e-14)
    numbers, a, b = found("point", "line")
    (p, _), (q, n) = parts(a), parts(b)
    assert abs(numbers[0] - np.linalg.norm(np.cross(p - q, n))) < 1e-14
    numbers, a, b = found("sphere", "plane") if ("sphere", "plane") in PAIRS else found("plane", "sphere")
    plane, other = (a, b) if a.kind == "plane" else (b, a)
    (q, n), (p, _) = parts(plane), parts(other)
    assert abs(numbers[0] - abs((p - q) @ n)) < 1e-14
    numbers, a, b = found("line", "line")
    (p, m), (q, n) = parts(a), parts(b)
    assert abs(abs(numbers[0]) - abs((q - p) @ np.cross(m, n))) < 1e-14 and abs(numbers[1] - m @ n) < 1e-14
    numbers, a, b = found("line", "plane")
    assert (
        numbers[0] == 0 and abs(numbers[1] - sum(float(u * v) for u, v in zip(a.along, b.along, strict=True))) < 1e-14
    )


# -- rounds and lines ------------------------------------------------------------------------------------------


def about_a_line(kind, across, turn, lean=0.9, far=0.8):
    """The invariants of the line along e3 and a round whose centre is ``far`` along e1, and whose axis leans by one
    angle from the line and is turned by another about it: by the public constructors, in the order of `KINDS`."""
    axis = np.array([np.sin(lean) * np.cos(turn), np.sin(lean) * np.sin(turn), np.cos(lean)])
    line, middle = cga.line((0, 0, 0.4), (0, 0, 1)), np.array([far, 0, -0.3])
    if kind == "circle":
        pair = line, cga.circle(middle, axis, 0.7)
    else:
        pair = cga.point_pair(middle - 0.5 * axis, middle + 0.5 * axis), line
    pair = [(across >> x).as_kind(x.kind.name) for x in pair]
    return evaluate(cga, "registration.pair_invariants", *pair).values[0]


@pytest.mark.parametrize("kind", ["circle", "point_pair"])
def test_rounds_that_lean_alike_over_a_line_are_told_apart(kind):
    """Distance and angle are the same for all turns; the twist is that of two lines, by the triple product."""
    random, far, lean = np.random.default_rng(4), 0.8, 0.9
    turns = np.linspace(0.1, 2 * np.pi + 0.1, 12, endpoint=False)
    found = []
    for turn in turns:
        motion = cga.translator(random.normal(size=3)) * cga.rotor(random.normal(size=3), random.uniform(0, 6))
        found.append(about_a_line(kind, motion, turn))
    found = np.array(found)
    np.testing.assert_allclose(found[:, :2], [[far, np.cos(lean)]] * len(turns), atol=1e-13)
    np.testing.assert_allclose(np.abs(found[:, 2]), far * np.sin(lean) * np.abs(np.sin(turns)), atol=1e-13)
    for i, one in enumerate(turns):
        for j, two in enumerate(turns):  # half a turn about e1 takes the one pair to the other, reversed
            same = abs(np.sin(one) - np.sin(two)) < 1e-9
            assert (np.abs(found[i] - found[j]).max() < 1e-12) == same


@pytest.mark.parametrize("kind", ["circle", "point_pair"])
def test_a_mirror_image_of_a_round_and_a_line_is_told_by_the_sign(kind):
    still = cga.rotor((0, 0, 1), 0.0)
    one, other = about_a_line(kind, still, 0.7), about_a_line(kind, still, -0.7)
    np.testing.assert_allclose(one, other * (1, 1, -1, 1), atol=1e-14)
    assert abs(one[2]) > 0.3


def test_a_right_handed_screw_has_a_positive_twist():
    """Between lines, and between the axis of a circle and a line; whichever of the two is turned round."""
    for sign in (1, -1):
        low = cga.line((0, 0, 0), (1, 0, 0))
        along = np.array([np.cos(0.5), np.sin(0.5), 0]) * sign  # half a unit up, and by half a radian to the left
        high = cga.line((0, 0, 0.5), along)
        wanted = 0.5 * np.sin(0.5)
        circle = cga.circle((3 * np.cos(0.5), 3 * np.sin(0.5), 0.5), along, 1)
        for pair, place in (((low, high), 0), ((low, circle), 2)):
            found = evaluate(cga, "registration.pair_invariants", *pair).values[0]
            assert found[place] == pytest.approx(wanted, abs=1e-14)
