"""Formulas of registration against geometry at 50 digits: objects are built from points and products, motors are moved
by, differences are taken; and the compiled driver's stages against NumPy.
"""

from __future__ import annotations

from functools import cache
from itertools import combinations_with_replacement

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import objects
from bladesmith.calls import Numbers, call
from bladesmith.codegen.build import compiler
from bladesmith.codegen.formulas import costs, estimation, registration
from bladesmith.codegen.formulas.blades import project_to_blade
from bladesmith.codegen.multivector import Multivector, from_values
from bladesmith.codegen.programs.reform import DIRECTED, KINDS
from bladesmith.codegen.rings import PrecisionRing
from bladesmith.reform.engine import Closeness, Driver, Scene, Side

from .formula_support import series_exp, stock

RING = PrecisionRing(50)
MP = RING.context
ALGEBRA = stock("cga3d")
TINY = MP.mpf(10) ** -40
PAIRS = list(combinations_with_replacement(KINDS, 2))


# -- 50 digits: parameters, objects, motors ----------------------------------------------------------------


def vector(values) -> Multivector:
    return from_values(ALGEBRA, RING, [1, 2, 4], [MP.mpf(v) for v in values])


def up(p) -> Multivector:
    """The point at some coordinates."""
    square = sum((MP.mpf(v) ** 2 for v in p), MP.mpf(0))
    ni, no = (vector((0, 0, 0)).basis(n) for n in ("ni", "no"))
    return vector(p) + no + ni * from_values(ALGEBRA, RING, [0], [square / 2])


def number(value) -> Multivector:
    return from_values(ALGEBRA, RING, [0], [MP.mpf(value)])


def scalar(x: Multivector):
    return x.terms.get(0, MP.mpf(0))


def largest(x: Multivector):
    return max((abs(c) for c in x.terms.values()), default=MP.mpf(0))


def plus(p, *scaled):
    return [MP.mpf(a) + sum(MP.mpf(s) * MP.mpf(v[i]) for s, v in scaled) for i, a in enumerate(p)]


class Thing:
    """An object at 50 digits: place, unit direction and radius, and what it is as a multivector of points."""

    def __init__(self, kind: str, seed: int) -> None:
        random = np.random.default_rng([seed, KINDS.index(kind)])
        self.kind = kind
        self.place = [MP.mpf(v) for v in random.uniform(-1, 1, 3)]
        along = [MP.mpf(v) for v in random.normal(size=3)]
        size = MP.sqrt(sum(v * v for v in along))
        self.along = [v / size for v in along]
        self.radius = MP.mpf(random.uniform(0.2, 0.6))
        one = self._across(random.normal(size=3))
        n = self.along
        other = [n[1] * one[2] - n[2] * one[1], n[2] * one[0] - n[0] * one[2], n[0] * one[1] - n[1] * one[0]]
        p, r, ni = self.place, self.radius, up((0, 0, 0)).basis("ni")
        a, b = plus(p, (r, one)), plus(p, (r, other))
        x = {
            "point": lambda: up(p),
            "point_pair": lambda: up(plus(p, (-r, n))) ^ up(plus(p, (r, n))),
            "line": lambda: up(p) ^ up(plus(p, (1, n))) ^ ni,
            "circle": lambda: up(a) ^ up(b) ^ up(plus(p, (-r, one))),
            "plane": lambda: up(p) ^ up(plus(p, (1, one))) ^ up(plus(p, (1, other))) ^ ni,
            "sphere": lambda: up(a) ^ up(b) ^ up(plus(p, (-r, one))) ^ up(plus(p, (r, n))),
        }[kind]()
        if kind != "point":
            x = x * number(1 / MP.sqrt(abs(scalar(x * x))))
        self.x = -x if self._agreement(x) < 0 else x
        self.element = self._expected()

    def _across(self, v):
        v = [MP.mpf(a) for a in v]
        dot = sum(a * b for a, b in zip(v, self.along, strict=True))
        v = plus(v, (-dot, self.along))
        size = MP.sqrt(sum(a * a for a in v))
        return [a / size for a in v]

    def _agreement(self, x: Multivector) -> float:
        """Whether it is turned as the constructor of its kind turns it."""
        p, n, r = (np.array(v, float) for v in (self.place, self.along, self.radius))
        made = {
            "point": lambda: cga.point(p),
            "point_pair": lambda: cga.point_pair(p - r * n, p + r * n),
            "line": lambda: cga.line(p, n),
            "circle": lambda: cga.circle(p, n, r),
            "plane": lambda: cga.plane(n, p @ n),
            "sphere": lambda: cga.sphere(p, r),
        }[self.kind]()
        row = np.array([float(x.terms.get(b, 0)) for b in ALGEBRA.kind(self.kind).blades])
        sign = float(np.sign(row @ made._data))
        np.testing.assert_allclose(sign * row, made._data, atol=1e-13)
        return sign

    def _expected(self):
        dot = sum(a * b for a, b in zip(self.place, self.along, strict=True))
        place = {
            "line": lambda: plus(self.place, (-dot, self.along)),
            "plane": lambda: [dot * v for v in self.along],
        }.get(self.kind, lambda: self.place)()
        along = self.along if self.kind in DIRECTED else [MP.mpf(0)] * 3
        return [*place, *along, self.radius if self.kind in ("point_pair", "circle", "sphere") else MP.mpf(0)]

    def row(self) -> np.ndarray:
        return np.array([float(self.x.terms.get(b, 0)) for b in ALGEBRA.kind(self.kind).blades])


@cache
def thing(kind: str, seed: int) -> Thing:
    return Thing(kind, seed)


@cache
def motor(seed: int) -> Multivector:
    """A rotation about an axis through the origin, then a translation."""
    random = np.random.default_rng(seed)
    axis, angle, shift = random.normal(size=3), random.uniform(0.3, 3), random.uniform(-1, 1, 3)
    plane = vector(axis) * (vector((1, 0, 0)) * vector((0, 1, 0)) * vector((0, 0, 1)))
    plane = plane * number(1 / MP.sqrt(abs(scalar(plane * plane))))
    ni = plane.basis("ni")
    turn = number(MP.cos(angle / 2)) - number(MP.sin(angle / 2)) * plane
    return ((number(1) - vector(shift) * ni / 2) * turn).grade(0, 2, 4)


def moved(r: Multivector, x: Multivector) -> Multivector:
    return (r * x * ~r).grade(*x.grades)


def values(result) -> list:
    """A row of a formula's result."""
    return [scalar(v) for v in result.values]


def twists() -> list[Multivector]:
    return [from_values(ALGEBRA, RING, [b], [MP.mpf(1)]) for b in ALGEBRA.kind("twist").blades]


def near(r: Multivector, b: Multivector, h) -> Multivector:
    """exp(h b) r."""
    return series_exp(b * number(h)) * r


@cache
def orthonormal() -> tuple[Multivector, ...]:
    """All 32 products of e1 e2 e3 e+ e-."""
    ni, no = (number(1).basis(n) for n in ("ni", "no"))
    axes = [vector(v) for v in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    axes += [ni / 2 - no, ni / 2 + no]
    found = [number(1)]
    for e in axes:
        found += [b * e for b in found]
    return tuple(found)


def coefficients(x: Multivector) -> list:
    """On the orthonormal basis: a blade's inverse picks its own."""
    return [scalar(x * ~b) * scalar(b * ~b) for b in orthonormal()]


def magnitude(x: Multivector):
    return sum(c * c for c in coefficients(x))


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


def stabiliser(*things: Multivector) -> np.ndarray:
    """Twists, as columns, that leave objects as they are."""
    columns = []
    for b in twists():
        rates = [x * b - b * x for x in things]
        columns.append([float(c) for d in rates for c in coefficients(d)])
    _, sizes, rows = np.linalg.svd(np.array(columns).T)
    return rows[(sizes > 1e-9).sum() :].T


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
            assert largest(registration.stepped(r, b * number(h)) - near(r, b, h)) < 10 * h * h


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


#: Of the three numbers of a round with an axis and a line, two are told: the one that is not is where its axis points
#: against the perpendicular on the line.
UNTOLD = {("point_pair", "line"), ("line", "circle")}


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
    assert told == 6 - swallowed - ((first, second) in UNTOLD)


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


# -- costs and their rates ---------------------------------------------------------------------------------


def close_pair(kind: str, seed: int) -> tuple[Multivector, Multivector]:
    """An object and one like it, a quarter of a motion away: some rotors dilate."""
    x, other = thing(kind, seed), thing(kind, seed + 1)
    r = registration.near_motor(number(3) + motor(seed))
    if kind in ("point", "line", "plane"):
        return x.x, moved(r, x.x)
    if kind == "sphere":
        return x.x, costs.aligned(moved(r, other.x), x.x)
    mixed = x.x + moved(r, other.x) * number(MP.mpf("0.1"))
    return x.x, costs.aligned(project_to_blade(mixed).grade(*x.x.grades), x.x)


def rotor_error(x: Multivector, y: Multivector) -> list:
    """Coefficients of R - 1 and of R . e_+, on the orthonormal basis."""
    r = costs.any_rotor(x, y)
    return coefficients(r - 1) + coefficients(costs.parallel(r))


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


# -- the compiled driver, against NumPy --------------------------------------------------------------------

needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler")
#: Objects of each kind of the query; the reference has two more.
COUNT = 5
WEIGHTS, LIMIT = (0.75, 0.25, 0.75), 0.5
HALVES = [(i, j) for i in range(8) for j in range(i, 8)]


def random_rows(kind: str, n: int, seed: int) -> np.ndarray:
    random = np.random.default_rng([seed, KINDS.index(kind)])
    p, d, r = random.uniform(-1, 1, (n, 3)), random.normal(size=(n, 3)), random.uniform(0.2, 0.6, n)
    made = {
        "point": lambda: cga.point(p),
        "point_pair": lambda: cga.point_pair(p, p + d),
        "line": lambda: cga.line(p, d),
        "circle": lambda: cga.circle(p, d, r),
        "plane": lambda: cga.plane(d, r),
        "sphere": lambda: cga.sphere(p, r),
    }[kind]()
    return np.ascontiguousarray(made._data)


def wrapped(kind: str, rows: np.ndarray):
    return cga.wrap(cga.kind(kind), rows)


def formula(name: str, *operands):
    """Results of a formula by NumPy, as arrays."""
    return [getattr(v, "_data", v) for v in call(cga, name, *operands).values]


class World:
    """A query, a reference with some more objects, and the motor between them, nearly."""

    def __init__(self) -> None:
        self.motor = np.array((cga.translator((0.2, -0.1, 0.1)) * cga.rotor((1, 2, 3), 0.4))._data)
        self.query = {k: random_rows(k, COUNT, 1) for k in KINDS}
        random = np.random.default_rng(5)  # each is a little off
        shifts, axes = 0.02 * random.normal(size=(COUNT, 3)), random.normal(size=(COUNT, 3))
        truth = cga.translator(shifts) * cga.rotor(axes, 0.03) * wrapped("motor", self.motor)
        self.reference = {}
        for kind, rows in self.query.items():
            images = (truth >> wrapped(kind, rows)).as_kind(kind, check=False)._data
            signs = np.where(np.arange(COUNT) % 2, -1.0, 1.0)[:, None] if kind in DIRECTED else 1.0
            self.reference[kind] = np.concatenate([random_rows(kind, 2, 9), images * signs])
        self.driver = Driver(KINDS, 1)
        sides = [Side(m, {k: self.driver.elements(k, r) for k, r in m.items()}) for m in (self.query, self.reference)]
        self.kinds = np.repeat(np.arange(6, dtype=np.int32), COUNT)
        self.rows = np.tile(np.arange(COUNT, dtype=np.int32), 6)
        self.scene = Scene(*sides, self.kinds, self.rows, 2)
        self.elements = sides[1].elements

    def moved_elements(self, motor: np.ndarray, kind: str) -> np.ndarray:
        return formula("registration.moved_element", wrapped("motor", motor), wrapped(kind, self.query[kind]))[0]

    def nearest(self, motor: np.ndarray, align: bool = True):
        """Rows of counterparts or -1, squares, signs of all, by looking at all pairs."""
        found = []
        for kind in KINDS:
            e, r = self.moved_elements(motor, kind)[:, None], self.elements[kind][None]
            cosine = (e[..., 3:6] * r[..., 3:6]).sum(-1)
            away = np.maximum((kind in DIRECTED) - (np.abs(cosine) if align else cosine), 0)
            d = WEIGHTS[0] * ((e - r)[..., :3] ** 2).sum(-1) + 2 * WEIGHTS[1] * away + WEIGHTS[2] * (e - r)[..., 6] ** 2
            best = d.argmin(1)
            least, c = d[np.arange(COUNT), best], cosine[np.arange(COUNT), best]
            near = least < LIMIT
            sign = np.where(align & (c < 0) & near, -1.0, 1.0)
            found.append((np.where(near, best, -1), np.where(near, least, LIMIT), sign))
        return [np.concatenate(part) for part in zip(*found, strict=True)]

    def form(self, kind: int, i: int, j: int, sign: float) -> np.ndarray:
        """The 8 x 8 matrix of one pair."""
        name = KINDS[kind]
        operands = (wrapped(name, self.query[name][i]), wrapped(name, self.reference[name][j]))
        return full(formula("registration.motor_form", *operands, Numbers(sign, 0, "sign"))[0])


def full(upper: np.ndarray) -> np.ndarray:
    matrix = np.zeros((8, 8))
    for value, (i, j) in zip(upper, HALVES, strict=True):
        matrix[i, j] = matrix[j, i] = value
    return matrix


def least_motor(matrix: np.ndarray) -> np.ndarray:
    """The motor of the least form: q' eliminated, the least eigenvector, the next motor."""
    inner, cross = matrix[4:, 4:], matrix[:4, 4:]
    inverse = np.linalg.pinv(inner, rcond=1e-12, hermitian=True)
    _, vectors = np.linalg.eigh(matrix[:4, :4] - cross @ inverse @ cross.T)
    q = vectors[:, 0]
    raw = np.zeros(8)
    order = [cga.kind("motor").blades.index(b) for b in registration.motor_blades(ALGEBRA)]
    raw[order] = np.concatenate([q, -inverse @ cross.T @ q])
    return unit_motor(raw)


def unit_motor(raw: np.ndarray) -> np.ndarray:
    return formula("registration.near_motor", cga.wrap(cga.layout("motor"), raw))[0]


def same_motor(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-12) -> None:
    assert min(np.abs(a - b).max(), np.abs(a + b).max()) < tolerance


@pytest.fixture(scope="module")
def world() -> World:
    made = World()
    made.scene.closeness(Closeness(WEIGHTS, LIMIT, 0.0, True))
    return made


@needs_compiler
def test_driver_elements_invariants_and_steps(world):
    for kind, rows in world.query.items():
        np.testing.assert_allclose(
            world.driver.elements(kind, rows), formula("registration.element", wrapped(kind, rows))[0], atol=1e-13
        )
    i, j = np.indices((COUNT, COUNT)).reshape(2, -1)
    for a, b in PAIRS:
        found = world.driver.invariants((a, b), (world.query[a], world.query[b]), (i, j))
        operands = wrapped(a, world.query[a][i]), wrapped(b, world.query[b][j])
        np.testing.assert_allclose(found, formula("registration.pair_invariants", *operands)[0], atol=1e-12)
    twist = np.array([0.1, -0.2, 0.05, 0.3, -0.1, 0.2])
    expected = formula("registration.stepped", wrapped("motor", world.motor), wrapped("twist", twist))[0]
    np.testing.assert_allclose(world.driver.step(world.motor, twist), expected, atol=1e-15)


@needs_compiler
@pytest.mark.parametrize("align", [True, False])
def test_driver_finds_the_nearest_of_all(world, align):
    world.scene.closeness(Closeness(WEIGHTS, LIMIT, 0.0, align))
    try:
        for found, expected in zip(world.scene.match(world.motor), world.nearest(world.motor, align), strict=True):
            np.testing.assert_allclose(found, expected, atol=1e-13)
    finally:
        world.scene.closeness(Closeness(WEIGHTS, LIMIT, 0.0, True))


@needs_compiler
def test_driver_samples_are_the_least_eigenvectors_of_their_forms(world):
    random = np.random.default_rng(2)
    members = np.array([random.choice(len(world.kinds), 3, replace=False) for _ in range(40)])
    kinds, query = world.kinds[members], world.rows[members]
    signs = np.where((query % 2 == 1) & np.isin(kinds, [KINDS.index(k) for k in DIRECTED]), -1.0, 1.0)
    motors, scores, hits, tested = world.scene.samples(kinds, query, query + 2, signs, np.inf)
    compared = 0
    for n in range(len(members)):
        matrix = sum(world.form(*pair) for pair in zip(kinds[n], query[n], query[n] + 2, signs[n], strict=True))
        sizes = np.linalg.eigvalsh(matrix[4:, 4:])
        if sizes[0] < 1e-3 * sizes[-1] or scores[n] < 0:
            continue  # a translation is nearly free
        same_motor(motors[n], least_motor(matrix), 1e-8)
        indices, squares, _ = world.nearest(motors[n])
        assert hits[n] == (indices >= 0).sum() and tested[n] == len(indices)
        np.testing.assert_allclose(scores[n], (1 - squares / LIMIT).sum(), atol=1e-10)
        compared += 1
    assert compared > 20


@needs_compiler
def test_driver_refines_by_matching_and_estimating(world):
    start = world.driver.step(world.motor, np.array([0.02, -0.01, 0.02, 0.05, -0.02, 0.03]))
    motors, scores, hits, taken = world.scene.refine(start[None], 4, 0.0)
    motor = start
    for _ in range(4):
        indices, squares, signs = world.nearest(motor)
        near = 1 - squares / LIMIT
        matrix = sum(
            near[n] ** 2 * world.form(world.kinds[n], world.rows[n], indices[n], signs[n])
            for n in np.flatnonzero(indices >= 0)
        )
        motor = least_motor(matrix)
    same_motor(motors[0], motor, 1e-11)
    indices, squares, _ = world.nearest(motor)
    assert taken[0] == 4 and hits[0] == (indices >= 0).sum()
    np.testing.assert_allclose(scores[0], (1 - squares / LIMIT).sum(), atol=1e-10)


@needs_compiler
def test_driver_stiffness_is_the_least_pivot(world):
    random = np.random.default_rng(4)
    members = np.array([random.choice(len(world.kinds), 3, replace=False) for _ in range(30)])
    found = world.scene.stiffness(world.kinds[members], world.rows[members])
    for n, one in enumerate(members):
        total = np.zeros((8, 8))
        for k, i in zip(world.kinds[one], world.rows[one], strict=True):
            x = wrapped(KINDS[k], world.query[KINDS[k]][i])
            total += full(formula("registration.motor_form", x, x, Numbers(1.0, 0, "sign"))[0])
        left, least = total[1:7, 1:7], np.inf  # without 1 and the pseudoscalar
        while len(left):
            t = int(np.diag(left).argmax())
            least = min(least, left[t, t])
            rest = [i for i in range(len(left)) if i != t]
            left = left[np.ix_(rest, rest)] - np.outer(left[rest, t], left[t, rest]) / left[t, t]
        np.testing.assert_allclose(found[n], least, rtol=1e-8, atol=1e-13)
    assert (world.scene.stiffness(np.array([[2, 2]]), np.array([[0, 0]])) < 1e-13).all()  # one line twice


@needs_compiler
@pytest.mark.parametrize("kind", KINDS)
def test_driver_rates_are_those_of_the_formula(world, kind):
    i = np.arange(COUNT)
    found = world.scene.rates(kind, world.motor, i, i + 2)
    operands = wrapped(kind, world.query[kind]), wrapped(kind, world.reference[kind][2:])
    expected = np.hstack(formula("registration.moved_rates", wrapped("motor", world.motor), *operands))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@needs_compiler
def test_driver_steps_half_way_in_turn(world):
    """Algorithm 1, against its formulas one after the other; the middle of the last round where it has settled."""
    signs = np.where((world.rows % 2 == 1) & np.isin(world.kinds, [KINDS.index(k) for k in DIRECTED]), -1.0, 1.0)
    partners = np.where(np.isin(world.kinds, [0, 5]), np.roll(np.arange(30).reshape(6, 5), -1, 1).ravel(), -1)
    pairs = (world.kinds, world.rows, world.rows + 2, partners, signs)

    def pair(n: int):
        name, i = KINDS[world.kinds[n]], world.rows[n]
        return wrapped(name, world.query[name][i]), wrapped(name, world.reference[name][i + 2])

    def once(motor: np.ndarray) -> list[np.ndarray]:
        motors = [motor]
        for n, other in enumerate(partners):
            r = wrapped("motor", motors[-1])
            if other >= 0:
                step = formula("estimation.half_step_of_two", r, *pair(n), *pair(other))
            else:
                step = formula("estimation.half_step", r, *pair(n), Numbers(signs[n], 0, "sign"))
            motors.append(step[0])
        return motors

    found, changes, skipped = world.scene.direct(np.eye(8)[0], pairs, 3, 0.0)
    motor = np.eye(8)[0]
    for change in changes:
        before, motor = motor, once(motor)[-1]
        same = formula("estimation.change", wrapped("motor", motor), wrapped("motor", before))[0]
        np.testing.assert_allclose(change, same[..., 0], rtol=1e-9, atol=1e-12)
    assert skipped == 0 and len(changes) == 3
    same_motor(found, motor)
    settled, changes, _ = world.scene.direct(np.eye(8)[0], pairs, 50, 1e-12)
    assert 2 < len(changes) < 50 and changes[-1] < 1e-12
    last = world.scene.direct(np.eye(8)[0], pairs, len(changes) - 1, 0.0)[0]
    middle = np.mean(once(last)[1:], 0)
    same_motor(settled, unit_motor(middle))
    assert np.abs(settled - last).max() > 1e-6
