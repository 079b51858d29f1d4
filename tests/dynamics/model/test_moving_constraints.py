"""Constraints that move, and conditions on velocities, against Newton and Euler in plain three-vectors."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics

from ...oracles import newton_euler as ne
from ...oracles.newton_euler import REST, dot, times
from ...support.dynamics.conditions import line_of, moving, path_of, plane_of, product, sphere_of, turning, wrench
from ...support.dynamics.states import ALGEBRAS, BAR, OBJECTS, STATES, alike, compared, pose, settled, states
from ...support.vectors import unit

EACH_ALGEBRA = pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
EACH_SEED = pytest.mark.parametrize("seed", range(OBJECTS))


def chosen(made, i):
    """Item i of batches, which may stand in tuples of tuples."""
    return tuple(chosen(x, i) for x in made) if isinstance(made, tuple) else None if made is None else made[i]


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


@pytest.mark.compiles
@EACH_ALGEBRA
@EACH_SEED
def test_a_point_pinned_to_a_place_that_moves(algebra, seed):
    test = Moving(algebra, seed)
    c = moving(test.rng, test.s.x + test.s.arm(test.p))
    test.check(
        lambda s: ne.point_held(s, test.p, c),
        dynamics.PinPath(algebra.point(test.p), lambda t: test.now),
        lambda: path_of(algebra.point, c), 3,
    )  # fmt: skip


@EACH_ALGEBRA
@EACH_SEED
def test_a_place_of_the_body_that_slides_within_it(algebra, seed):
    test = Moving(algebra, seed)
    c = moving(test.rng, test.s.x + test.s.arm(test.p))
    slid = moving(test.rng, np.broadcast_to(test.p, c[0].shape))
    test.check(
        lambda s: ne.point_held(s, test.p, c, slid[1:]),
        dynamics.PinPath(lambda t: test.now[0], lambda t: test.now[1]),
        lambda: (path_of(algebra.point, slid), path_of(algebra.point, c)), 3,
    )  # fmt: skip


@EACH_ALGEBRA
@EACH_SEED
def test_a_line_pinned_to_one_that_moves(algebra, seed):
    test = Moving(algebra, seed)
    m = turning(test.rng, times(test.s.turn, test.m))
    c = moving(test.rng, test.s.x + test.s.arm(test.p) + test.rng.normal(size=(STATES, 1)) * m[0])
    test.check(
        lambda s: ne.direction_held(s, test.m, (None, m[1], m[2])) + ne.on_line(s, test.p, m, c),
        dynamics.PinPath(line_of(algebra, test.p, test.m), lambda t: test.now),
        lambda: path_of(lambda x, d: line_of(algebra, x, d), c, m), 4,
    )  # fmt: skip


@EACH_ALGEBRA
@EACH_SEED
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


@EACH_ALGEBRA
@EACH_SEED
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


@EACH_SEED
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


@EACH_SEED
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


@EACH_ALGEBRA
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


@EACH_ALGEBRA
@EACH_SEED
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


@EACH_SEED
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


@pytest.mark.compiles
def test_a_crank_of_two_turns_a_second():
    w = 4 * np.pi  # half a second is a period: steps of one and of half a second see a path that stands still

    def crank(t):
        if not 0 <= t <= 1:
            raise ValueError("outside of the table")
        return cga.point((np.cos(w * t), np.sin(w * t), 0))

    body = dynamics.RigidBody(1.3, [0.1, 0.2, 0.25], (1, 0, 0), velocity=(0, w, 0))
    found = dynamics.Simulation(body, (), dynamics.PinPath(cga.point((0, 0, 0)), crank)).run(1.0, times=[0.3, 1.0])
    angle = w * found.time
    assert np.allclose(found.velocity, w * np.stack([-np.sin(angle), np.cos(angle), 0 * angle], -1), atol=1e-7 * w)
    force, _ = dynamics.wrench_parts(found.reaction)
    towards = -1.3 * w**2 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    assert np.abs(force - towards).max() < 1e-8 * 1.3 * w**2
