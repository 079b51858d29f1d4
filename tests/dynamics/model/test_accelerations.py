"""Accelerations and reactions of held bodies against Newton and Euler in plain three-vectors (`newton_euler`).

Random states of random bodies for each constraint, in CGA and PGA, in the null space of pins and with multipliers: a
thousand of each under BLADESMITH_FULL_BARS=1. Errors are shares of the acceleration, and of the reaction, themselves.
"""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics

from ...oracles import newton_euler as ne
from ...oracles.newton_euler import REST, dot, times
from ...support.dynamics.conditions import pins, pins_at, surfaces, wrench
from ...support.dynamics.states import (
    ALGEBRAS,
    BAR,
    GRAVITY,
    OBJECTS,
    STATES,
    Looked,
    alike,
    body_of,
    compared,
    pose,
    settled,
    states,
    worst,
)
from ...support.effort import FULL
from ...support.vectors import unit


def named(groups):
    """Names with the algebras that have them: the second group is of CGA alone."""
    return [(name, algebra) for algebra in ALGEBRAS for group in groups[: 1 + (algebra == "cga")] for name in group]


CASES, SURFACES = (named(make(np.random.default_rng(0))) for make in (pins, surfaces))


# -- pins that never move --------------------------------------------------------------------------------------


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS)
@pytest.mark.parametrize("noise", [0.0, 1e-16])
def test_pins_at_special_places(noise, algebra):
    """Through the centre of mass and along axes, where coefficients are zero, or what rounding left of zero."""
    rng = np.random.default_rng(2)
    zero, *axes = np.concatenate([np.zeros((1, 3)), np.eye(3)]) + noise * rng.normal(size=(4, 3))
    for p, q in ((zero, axes[0]), (axes[1], axes[0])):
        both, rounds = pins_at(p, q, axes[2], axes[0], 1.0, noise)
        for name, case in (both | rounds if algebra == "cga" else both).items():
            s, rows = settled(states(5, 3), case.rows)
            for null_space in (True, False):
                given = [dynamics.Pin(x) for x in case.objects(ALGEBRAS[algebra])]
                found, error = compared(s, rows, ALGEBRAS[algebra], given, null_space, rng)
                assert error < BAR, (name, found.mode, error)
                free = found.frame.allowed.sum() if null_space else 6 - found.rank
                assert (free == case.free).all(), (name, found.mode)


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


# -- loads -----------------------------------------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
@pytest.mark.parametrize("held", [None, "null space", "multipliers"])
def test_springs_dampers_and_functions_of_time_and_state(algebra, held):
    for k in range(OBJECTS):
        rng = np.random.default_rng(500 + k)
        p, anchor, f, tau, own_f, own_tau, c = rng.normal(size=(7, 3))
        stiff, rest, damping, drag, spin_drag, square_drag, square_spin_drag = rng.uniform(0.5, 3.0, 7)
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
            dynamics.QuadraticDrag(square_spin_drag, square_drag),
            dynamics.WorldWrench(lambda t, f=f: wrench(algebra, (1 + t) * f, REST)),
            dynamics.BodyWrench(lambda t, own=(own_f, own_tau): wrench(algebra, *own)),
            dynamics.WorldWrench(by_state),
        ]
        gap = anchor - s.x - s.arm(p)
        long = np.linalg.norm(gap, axis=1)
        pull = stiff * (long - rest) + damping * dot(gap / long[:, None], -s.velocity(p))
        spring = pull[:, None] * gap / long[:, None]
        own = np.cross(s.w, s.v) + s.x
        speed, pace = (np.linalg.norm(x.astype(float), axis=1)[:, None] for x in (s.v, s.w))
        force = s.mass[:, None] * GRAVITY + spring - (drag + square_drag * speed) * s.v + f + times(s.turn, own_f) + own
        moment = np.cross(s.arm(p), spring) - np.cross(s.x, f) + times(s.turn, own_tau)
        moment = moment - (spin_drag + square_spin_drag * pace) * s.w
        moment = moment + times(s.turn, tau) - np.cross(s.x, own)
        given = [dynamics.Pin(algebra.point(c), algebra.point(place))] if held else []
        found = Looked(s, algebra, acting, given, held == "null space", True)
        assert worst(found, *ne.motion(s, force, moment, rows), s) < BAR


@pytest.mark.compiles
@pytest.mark.parametrize(("name", "algebra"), CASES if FULL else [("circle", "cga"), ("two points", "pga")])
def test_programs_of_their_own_agree(name, algebra):
    """The reactions that a run stores, from the program that has just what the simulation needs.

    A reaction is what loads leave when accelerations are taken from them, so the condition number of its computation is
    size of the loads / size of the reaction: infinite for pinned directions of a body at rest, 6e8 for a slow rotation.
    The error is at most BAR, or 32 rounding errors times the condition number; it is written without the quotient.
    """
    algebra = ALGEBRAS[algebra]
    both, rounds = pins(np.random.default_rng(1))
    case = (both | rounds)[name]
    s, rows = settled(states(STATES, 7), case.rows)
    *_, force, moment = ne.motion(s, s.mass[:, None] * GRAVITY, np.zeros((STATES, 3)), rows)
    theirs = np.concatenate([force, moment + np.cross(s.x, force)], 1).astype(float)
    weight = s.mass * np.linalg.norm(GRAVITY)
    gyroscopic = np.linalg.norm(np.cross(s.w, times(s.inertia.astype(float), s.w)), axis=1)
    sizes = weight * (1 + np.linalg.norm(s.x, axis=1)) + gyroscopic
    bound = np.maximum(BAR * np.linalg.norm(theirs, axis=1), 32 * np.finfo(float).eps * sizes)
    for how in ("null-space", "projection"):
        given = [dynamics.Pin(x) for x in case.objects(algebra)]
        held = dynamics.Simulation(body_of(s, algebra), [dynamics.Gravity(GRAVITY)], given, stabilization=how)
        mine = dynamics.screw_coordinates(held.run(1e-3, times=[0.0]).reaction)[:, 0]
        assert (np.linalg.norm(mine - theirs, axis=1) <= bound).all()
