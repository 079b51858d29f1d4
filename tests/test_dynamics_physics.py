"""Accelerations and reactions of held bodies against Newton and Euler in plain three-vectors (`newton_euler`).

A thousand random states of random bodies for each constraint, in CGA and PGA, in the null space of pins and with
multipliers; errors are shares of the acceleration, and of the reaction, themselves.
"""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics

from . import newton_euler as ne
from .dynamics_conditions import (
    line_of, moving, path_of, pins, plane_of, product, sphere_of, surfaces, turning, unit, wrench,
)  # fmt: skip
from .dynamics_support import ALGEBRAS, FULL, Looked, body_of, screws, states
from .newton_euler import REST, dot, times

#: Share of an acceleration or a reaction that may be wrong.
BAR = 1e-10
#: Objects drawn for each constraint, and states of each.
OBJECTS, STATES = 5, 200 if FULL else 40
GRAVITY = np.array([0.3, -0.7, -9.81])


def named(groups):
    """Names with the algebras that have them: the second group is of CGA alone."""
    return [(name, algebra) for algebra in ALGEBRAS for group in groups[: 1 + (algebra == "cga")] for name in group]


CASES, SURFACES = (named(make(np.random.default_rng(0))) for make in (pins, surfaces))


def worst(found, a, dw, force, moment, s):
    """Largest share that is wrong; turns and moments are brought to lengths by the radius of gyration."""
    reach = np.sqrt(np.trace(s.tensor, axis1=1, axis2=2) / s.mass)[:, None]
    shares = []
    for mine, theirs in (
        ((found.acceleration, reach * found.spin_rate), (a, reach * dw)),
        ((found.force, found.moment / reach), (force, moment / reach)),
    ):
        error = np.linalg.norm(np.concatenate([x - y for x, y in zip(mine, theirs, strict=True)], 1), axis=1)
        size = np.linalg.norm(np.concatenate(theirs, 1), axis=1)
        shares.append(float(np.divide(error, size, out=error.copy(), where=size > 1e-3).max()))
    return max(shares)


def loads(algebra, rng):
    """Gravity, and a wrench of each sort; and what they are, for a state, about the centre of mass."""
    force, moment, own_force, own_moment = rng.normal(size=(4, 3))
    acting = [
        dynamics.Gravity(GRAVITY),
        dynamics.WorldWrench(wrench(algebra, force, moment)),
        dynamics.BodyWrench(wrench(algebra, own_force, own_moment)),
    ]

    def about_center(s):
        total = s.mass[:, None] * GRAVITY + force + times(s.turn, own_force)
        return total, moment - np.cross(s.x, force) + times(s.turn, own_moment)

    return acting, about_center


def chosen(made, i):
    """Item i of batches, which may stand in tuples of tuples."""
    return tuple(chosen(x, i) for x in made) if isinstance(made, tuple) else None if made is None else made[i]


def settled(s, build):
    """The state next to s that obeys the rows, and they there."""
    s = ne.admissible(s, build(s))
    return s, build(s)


def compared(s, rows, algebra, constraints, null_space, rng, alone=False, before=None):
    """What the driver finds, and how wrong it is."""
    acting, about_center = loads(algebra, rng)
    found = Looked(s, algebra, acting, constraints, null_space, alone, before)
    return found, worst(found, *ne.motion(s, *about_center(s), rows), s)


# -- pins that never move --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "algebra"), CASES)
def test_pins_hold_with_the_forces_of_newton_and_euler(name, algebra):
    algebra = ALGEBRAS[algebra]
    for k in range(OBJECTS):
        rng = np.random.default_rng(100 + k)
        both, rounds = pins(rng)
        case = (both | rounds)[name]
        s, rows = settled(states(STATES, 10 * k), case.rows)
        for null_space in (True, False):
            given = [dynamics.Pin(x) for x in case.objects(algebra)]
            found, error = compared(s, rows, algebra, given, null_space, np.random.default_rng(k))
            assert found.mode == ("subspace" if null_space else "constrained")
            assert error < BAR, (name, found.mode, error)
            free = found.frame.allowed.sum() if null_space else 6 - found.rank
            assert (free == case.free).all()


@pytest.mark.parametrize(("name", "algebra"), SURFACES)
def test_points_stay_on_objects_of_the_world(name, algebra):
    algebra = ALGEBRAS[algebra]
    for k in range(OBJECTS):
        rng = np.random.default_rng(200 + k)
        both, rounds = surfaces(rng)
        p, places, make, build, free = (both | rounds)[name]
        s = states(STATES, 10 * k)
        s.x = places(STATES) - s.arm(p)
        s, rows = settled(s, build)
        given = [dynamics.Incidence(algebra.point(p), make(algebra))]
        found, error = compared(s, rows, algebra, given, True, rng)
        assert error < BAR, (name, error)
        assert (6 - found.rank == free).all()


def test_several_constraints_at_once_and_redundant_ones():
    """A point on a plane, another on a sphere, and the first plane said twice."""
    for k in range(OBJECTS):
        rng = np.random.default_rng(300 + k)
        p, q, c = rng.normal(size=(3, 3))
        n, s = unit(rng.normal(size=3)), states(STATES, 10 * k)
        first = s.arm(p)
        s.x = s.x - n * dot(s.x + first, n)[:, None]  # p is in the plane through the origin
        gap = s.x + s.arm(q) - c
        radius = np.linalg.norm(gap, axis=1)
        algebra = cga

        def build(s, p=p, q=q, n=n, c=c):
            return ne.on_plane(s, p, (n, REST, REST)) + ne.at_distance(s, q, (c, REST, REST))

        s, rows = settled(s, build)
        plane = algebra.plane(n, 0.0)
        given = [
            dynamics.Incidence(algebra.point(p), plane),
            dynamics.Incidence(algebra.point(q), algebra.sphere(c, radius)),
            dynamics.Incidence(algebra.point(p), 3 * plane),
        ]
        found, error = compared(s, rows, algebra, given, True, rng)
        assert error < BAR, error
        assert (found.rank == 2).all()


# -- objects that move -----------------------------------------------------------------------------------------


def alike(n, seed):
    """States of one body."""
    s = states(n, seed)
    s.mass[:], s.tensor[:] = s.mass[0], s.tensor[0]
    return s


class Moving:
    """A test of a constraint that moves: what it is made of, state by state, stands in `now`."""

    def __init__(self, algebra, seed):
        self.a, self.rng, self.now = algebra, np.random.default_rng(seed), None
        self.s = alike(STATES, 10 * seed)
        self.p, self.q = self.rng.normal(size=(2, 3))
        self.m = unit(self.rng.normal(size=3))

    def check(self, build, constraint, prepared, rank):
        """Rows, the constraint, and for a state what its functions give."""
        s, rows = settled(self.s, build)
        made = prepared()
        values = [chosen(made, i) for i in range(STATES)]
        self.now = values[0]

        def before(i):
            self.now = values[i]

        found, error = compared(s, rows, self.a, [constraint], True, self.rng, True, before)
        assert error < BAR, error
        assert (found.rank == rank).all()


@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
@pytest.mark.parametrize("seed", range(OBJECTS))
def test_a_point_pinned_to_a_place_that_moves(algebra, seed):
    test = Moving(algebra, seed)
    c = moving(test.rng, test.s.x + test.s.arm(test.p))
    test.check(
        lambda s: ne.point_held(s, test.p, c),
        dynamics.PinPath(algebra.point(test.p), lambda t: test.now),
        lambda: path_of(algebra.point, c), 3,
    )  # fmt: skip


@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
@pytest.mark.parametrize("seed", range(OBJECTS))
def test_a_place_of_the_body_that_slides_within_it(algebra, seed):
    test = Moving(algebra, seed)
    c = moving(test.rng, test.s.x + test.s.arm(test.p))
    slid = moving(test.rng, np.broadcast_to(test.p, c[0].shape))
    test.check(
        lambda s: ne.point_held(s, test.p, c, slid[1:]),
        dynamics.PinPath(lambda t: test.now[0], lambda t: test.now[1]),
        lambda: (path_of(algebra.point, slid), path_of(algebra.point, c)), 3,
    )  # fmt: skip


@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
@pytest.mark.parametrize("seed", range(OBJECTS))
def test_a_line_pinned_to_one_that_moves(algebra, seed):
    test = Moving(algebra, seed)
    m = turning(test.rng, times(test.s.turn, test.m))
    c = moving(test.rng, test.s.x + test.s.arm(test.p) + test.rng.normal(size=(STATES, 1)) * m[0])
    test.check(
        lambda s: ne.direction_held(s, test.m, (None, m[1], m[2])) + ne.on_line(s, test.p, m, c),
        dynamics.PinPath(line_of(algebra, test.p, test.m), lambda t: test.now),
        lambda: path_of(lambda x, d: line_of(algebra, x, d), c, m), 4,
    )  # fmt: skip


@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
@pytest.mark.parametrize("seed", range(OBJECTS))
def test_a_point_on_a_plane_that_moves(algebra, seed):
    test = Moving(algebra, seed)
    n = turning(test.rng, times(test.s.turn, test.m))
    place = test.s.x + test.s.arm(test.p) + np.cross(n[0], test.rng.normal(size=(STATES, 3)))
    c = moving(test.rng, place)
    test.check(
        lambda s: ne.on_plane(s, test.p, n, c),
        dynamics.Incidence(algebra.point(test.p), lambda t: test.now),
        lambda: path_of(lambda d, x: plane_of(algebra, d, x), n, c), 1,
    )  # fmt: skip


@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
@pytest.mark.parametrize("seed", range(OBJECTS))
def test_an_angle_that_changes(algebra, seed):
    """Of a plane of the body to one of the world: A is the product with the body's, H the cosine."""
    test = Moving(algebra, seed)
    n = turning(test.rng, unit_rows(test.rng, STATES))
    cosine = dot(times(test.s.turn, test.m), n[0])
    h = moving(test.rng, cosine)
    own = algebra.plane(test.m, 0.4)
    sign = float(own.scalar_product(own).values[0])
    test.check(
        lambda s: ne.at_angle(s, test.m, n, h[1:]),
        dynamics.PinLinear(lambda x: own.scalar_product(x), lambda t: test.now[0], lambda t: test.now[1]),
        lambda: (
            path_of(lambda d: plane_of(algebra, d, np.zeros(3)), n),
            tuple(algebra.scalar(sign * x) for x in h),
        ), 1,
    )  # fmt: skip


def unit_rows(rng, n):
    found = rng.normal(size=(n, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


@pytest.mark.parametrize("seed", range(OBJECTS))
def test_a_rod_that_grows(seed):
    """A[X] = P . X is minus half the square of the distance of a point of the body from one that moves."""
    test = Moving(cga, seed)
    c = moving(test.rng, test.s.x)
    gap = test.s.x + test.s.arm(test.p) - c[0]
    half = moving(test.rng, dot(gap, gap) / 2)
    point = cga.point(test.p)
    test.check(
        lambda s: ne.at_distance(s, test.p, c, half[1:]),
        dynamics.PinLinear(lambda x: point | x, lambda t: test.now[0], lambda t: test.now[1]),
        lambda: (path_of(cga.point, c), tuple(cga.scalar(-x) for x in half)), 1,
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(OBJECTS))
def test_a_point_on_a_sphere_and_on_a_circle_that_move_and_grow(seed):
    for ring in (False, True):
        test = Moving(cga, seed)
        point, m = test.s.x + test.s.arm(test.p), turning(test.rng, unit_rows(test.rng, STATES))
        c = moving(test.rng, point + np.cross(m[0], test.rng.normal(size=(STATES, 3))))
        square = moving(test.rng, dot(point - c[0], point - c[0]))

        def rows(s, test=test, c=c, square=square, m=m, ring=ring):
            found = ne.at_distance(s, test.p, c, (square[1] / 2, square[2] / 2))
            return found + ne.on_plane(s, test.p, m, c) if ring else found

        def prepared(c=c, square=square, m=m, ring=ring):
            ball = path_of(lambda x, r: sphere_of(cga, x, r), c, square)
            disc = path_of(lambda d, x: plane_of(cga, d, x).dual(), m, c)
            return tuple(x.undual() for x in (product(ball, disc) if ring else ball))

        test.check(rows, dynamics.Incidence(cga.point(test.p), lambda t, test=test: test.now), prepared, 1 + ring)


# -- conditions on velocities ----------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
@pytest.mark.parametrize("count", [1, 3])
def test_wrenches_that_find_no_power(algebra, count):
    for k in range(OBJECTS):
        rng = np.random.default_rng(400 + k)
        forces, moments = rng.normal(size=(2, count, 3))

        def build(s, forces=forces, moments=moments):
            found = ne.powerless(s, forces[0], moments[0])
            for f, tau in zip(forces[1:], moments[1:], strict=True):
                found = found + ne.powerless(s, f, tau)
            return found

        s, rows = settled(states(STATES, 10 * k), build)
        given = [dynamics.VirtualPower([wrench(algebra, f, tau) for f, tau in zip(forces, moments, strict=True)])]
        found, error = compared(s, rows, algebra, given, True, rng)
        assert error < BAR, error
        assert (found.rank == count).all()


def pose(motor, twist):
    """Place, turn and velocities in the world that functions of the state are given."""
    matrix = motor.algebra.matrix(motor)
    w, v = screws(motor.algebra, twist.values)
    return matrix[:3, 3], matrix[:3, :3], matrix[:3, :3] @ v, matrix[:3, :3] @ w


@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
@pytest.mark.parametrize("seed", range(OBJECTS))
def test_a_knife_edge_and_a_ball_that_rolls(algebra, seed):
    test = Moving(algebra, seed)

    def edge(t, motor, twist):
        x, turn, v, w = pose(motor, twist)
        side, arm = turn @ test.m, turn @ test.p
        place, rate = x + arm, v + np.cross(w, arm)
        bent = np.cross(w, side)
        return (
            wrench(algebra, side, np.cross(place, side)),
            wrench(algebra, bent, np.cross(rate, side) + np.cross(place, bent)),
        )

    test.check(lambda s: ne.knife_edge(s, test.p, test.m), dynamics.VirtualPower(edge), lambda: None, 1)
    normal, radius = unit(test.q), 0.7
    axes = np.eye(3)

    def ball(t, motor, twist):
        x, _, v, _ = pose(motor, twist)
        forces = np.broadcast_to(axes, (3, 3))
        return (
            wrench(algebra, forces, np.cross(x - radius * normal, axes)),
            wrench(algebra, 0 * forces, np.cross(v, axes)),
        )

    test.check(lambda s: ne.rolling(s, radius, normal), dynamics.VirtualPower(ball), lambda: None, 3)


@pytest.mark.parametrize("seed", range(OBJECTS))
def test_a_pendulum_on_a_sphere_by_virtual_power(seed):
    """6.6: T = (A ^ V ^ n_inf) I5, the line through the centre and the point, with V x Omega for V's rate."""
    test = Moving(cga, seed)
    infinity, center = cga.multivector({"ni": 1.0}), cga.point(test.q)

    def radial(t, motor, twist):
        v = motor >> cga.point(test.p)
        dv = v.commutator(motor >> twist)
        return tuple((center ^ x ^ infinity).dual() for x in (v, dv))

    test.check(
        lambda s: ne.at_distance(s, test.p, (test.q, REST, REST)), dynamics.VirtualPower(radial), lambda: None, 1
    )


# -- loads -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
@pytest.mark.parametrize("held", [None, "null space", "multipliers"])
def test_springs_dampers_and_functions_of_time_and_state(algebra, held):
    for k in range(OBJECTS):
        rng = np.random.default_rng(500 + k)
        p, anchor, f, tau, own_f, own_tau, c = rng.normal(size=(7, 3))
        stiff, rest, damping, drag, spin_drag = rng.uniform(0.5, 3.0, 5)
        s, rows, place = alike(STATES, 10 * k), None, rng.normal(size=3)
        if held:
            s.x = place - s.arm(c)
            s, rows = settled(s, lambda s, c=c: ne.point_held(s, c))

        def by_state(t, motor, twist, tau=tau):
            x, turn, v, w = pose(motor, twist)
            return wrench(algebra, np.cross(w, v) + x, turn @ tau)

        acting = [
            dynamics.Gravity(GRAVITY),
            dynamics.Spring(p, anchor, stiff, rest, damping),
            dynamics.Damper(spin_drag, drag),
            dynamics.WorldWrench(lambda t, f=f: wrench(algebra, (1 + t) * f, REST)),
            dynamics.BodyWrench(lambda t, own=(own_f, own_tau): wrench(algebra, *own)),
            dynamics.WorldWrench(by_state),
        ]
        gap = anchor - s.x - s.arm(p)
        long = np.linalg.norm(gap, axis=1)
        pull = stiff * (long - rest) + damping * dot(gap / long[:, None], -s.velocity(p))
        spring = pull[:, None] * gap / long[:, None]
        own = np.cross(s.w, s.v) + s.x
        force = s.mass[:, None] * GRAVITY + spring - drag * s.v + f + times(s.turn, own_f) + own
        moment = np.cross(s.arm(p), spring) - spin_drag * s.w - np.cross(s.x, f) + times(s.turn, own_tau)
        moment = moment + times(s.turn, tau) - np.cross(s.x, own)
        given = [dynamics.Pin(algebra.point(c), algebra.point(place))] if held else []
        found = Looked(s, algebra, acting, given, held == "null space", True)
        assert worst(found, *ne.motion(s, force, moment, rows), s) < BAR


@pytest.mark.parametrize(("name", "algebra"), CASES if FULL else [("circle", "cga"), ("two planes", "pga")])
def test_programs_of_their_own_agree(name, algebra):
    """The reactions that a run stores, from the program that has just what the simulation needs."""
    algebra = ALGEBRAS[algebra]
    both, rounds = pins(np.random.default_rng(1))
    case = (both | rounds)[name]
    s, rows = settled(states(STATES, 7), case.rows)
    *_, force, moment = ne.motion(s, s.mass[:, None] * GRAVITY, np.zeros((STATES, 3)), rows)
    theirs = np.concatenate([force, moment + np.cross(s.x, force)], 1).astype(float)
    for how in ("null-space", "projection"):
        given = [dynamics.Pin(x) for x in case.objects(algebra)]
        held = dynamics.Simulation(body_of(s, algebra), [dynamics.Gravity(GRAVITY)], given, stabilization=how)
        mine = dynamics.screw_coordinates(held.run(1e-3, times=[0.0]).reaction)[:, 0]
        error = np.linalg.norm(mine - theirs, axis=1) / np.linalg.norm(theirs, axis=1)
        assert error.max() < BAR
