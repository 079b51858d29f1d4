"""Implicit steps: against SciPy in coordinates where nothing turns, exact decays, and other integrators."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bladesmith as bs
from bladesmith import dynamics, kinematics

CGA, PGA = bs.cga3d, bs.pga3d
G = 9.81
GRAVITY = dynamics.Gravity((0, 0, -G))
pytestmark = pytest.mark.compiles


def ball(mass=1.0, position=(0, 0, 0), **options):
    return dynamics.RigidBody(mass, 0.1 * mass * np.ones(3), position, **options)


def radial(stiffness, damping, start, duration):
    """A mass on a spring in the plane, in polar coordinates: distance, angle from straight down, and their rates."""

    def rates(_, y):
        r, angle, dr, turning = y
        pull = stiffness * (r - 1.0) + damping * dr
        return [dr, turning, r * turning**2 + G * np.cos(angle) - pull, -(G * np.sin(angle) + 2 * dr * turning) / r]

    found = solve_ivp(rates, (0, duration), start, method="Radau", rtol=1e-12, atol=1e-14)
    r, angle, *_ = found.y[:, -1]
    return r * np.array([np.sin(angle), 0.0, -np.cos(angle)])


@pytest.mark.parametrize("algebra", [CGA, PGA], ids=["cga", "pga"])
@pytest.mark.parametrize(("stiffness", "ratio"), [(1e10, 1e4), (1e6, 1e2), (1e3, 1.0)])
def test_a_pendulum_on_a_stiff_spring(algebra, stiffness, ratio):
    """Stretched at the start, it relaxes slowly, along a direction that turns."""
    damping, angle = 2 * ratio * np.sqrt(stiffness), 1.1
    expected = radial(stiffness, damping, [1.05, angle, 0.0, 0.4], 1.0)
    outward, along = np.array([np.sin(angle), 0, -np.cos(angle)]), np.array([np.cos(angle), 0, np.sin(angle)])
    body = ball(position=1.05 * outward, velocity=0.42 * along, algebra=algebra)
    spring = dynamics.Spring(0, 0, stiffness, 1.0, damping)
    simulation = dynamics.Simulation(body, [GRAVITY, spring], integrator="implicit")
    for rtol, bar, steps in ((1e-5, 1e-5, 400), (1e-7, 1e-6, 400), (1e-12, 1e-9, 400)):
        found = simulation.run(1.0, times=[1.0], rtol=rtol)
        assert not found.message and found.steps <= steps
        assert np.abs(found.position[-1] - expected).max() < bar, rtol


def test_states_between_are_as_good():
    body = ball(position=(0.8, 0.0, -0.7))
    loads = [GRAVITY, dynamics.Spring((0.1, 0.2, 0), 0, 1e8, 1.0, 1e6), dynamics.Damper(0.3, 0.1)]
    simulation = dynamics.Simulation(body, loads, integrator="implicit")
    times = np.linspace(0.01, 1.0, 150)
    dense = simulation.run(1.0, times=times)
    for i in (3, 40, 99):
        single = simulation.run(times[i], times=[times[i]], rtol=1e-13)
        for what in ("position", "velocity", "orientation", "angular_velocity"):
            assert np.abs(getattr(dense, what)[i + 1] - getattr(single, what)[-1]).max() < 1e-9, what


def top(algebra, **options):
    body = dynamics.RigidBody(
        1.0, (0.1, 0.12, 0.02), (0, 0, 1), angular_velocity=(0.1, 0, 6.0), velocity=(0, -0.1, 0), algebra=algebra
    )
    return dynamics.Simulation(body, [GRAVITY], [dynamics.Pin(algebra.point((0, 0, -1)))], **options)


def chain(algebra, **options):
    bodies = {
        "upper": dynamics.RigidBody(1.0, (0.15, 0.2, 0.3), (0, 0.5, 0), algebra=algebra),
        "lower": dynamics.RigidBody(2.0, (0.3, 0.2, 0.25), (0, 1.4, 0.2), algebra=algebra),
    }
    joints = [
        kinematics.Spherical("base", "upper", algebra.point((0, 0, 0))),
        kinematics.Spherical("upper", "lower", algebra.point((0, 1, 0))),
    ]
    loads = [GRAVITY, dynamics.Damper(0.3, 0.0, "upper", "lower")]
    return dynamics.Simulation(dynamics.System(bodies, joints), loads, **options)


@pytest.mark.parametrize("make", [top, chain])
@pytest.mark.parametrize("options", [{}, {"stabilization": "projection", "map": "cayley"}], ids=["auto", "projection"])
def test_what_is_not_stiff_is_as_others_have_it(make, options):
    expected = make(CGA, integrator="adaptive", **options).run(1.0, times=[0.4, 1.0])
    found = make(CGA, integrator="implicit", **options).run(1.0, times=[0.4, 1.0])
    for name, body in expected.bodies.items():
        assert np.abs(found[name].position - body.position).max() < 1e-9
        assert np.abs(found[name].angular_velocity - body.angular_velocity).max() < 1e-8
    assert found.violation.max() < 1e-12 and found.steps < 200


def test_an_overdamped_chain_with_joints_comes_to_rest_in_few_steps():
    bodies = {f"link_{i}": ball(1.0, (0.3 * i + 0.15, 0, 0)) for i in range(4)}
    names = ["base", *bodies]
    joints = [kinematics.Spherical(names[i], names[i + 1], CGA.point((0.3 * i, 0, 0))) for i in range(4)]
    dampers = [dynamics.Damper(1e6, 0.0, a, b) for a, b in zip(names[1:], names[2:], strict=False)]
    loads = [GRAVITY, *dampers, dynamics.Damper(1e6, 1e6, "link_0")]
    simulation = dynamics.Simulation(dynamics.System(bodies, joints), loads, integrator="implicit")
    found = simulation.run(10.0, times=[5.0, 10.0], rtol=1e-8)
    assert not found.message and found.steps < 100 and found.violation.max() < 1e-12
    # a beam so stiff that it hardly bends: all weight turns it about the base, against the dampers
    assert 0 < -found["link_3"].position[-1, 2] < 1e-3


def test_masses_of_twelve_orders_on_one_rope():
    """Hanging still in the end: each spring bears what hangs below it."""
    masses, stiffness = {"light": 1e-6, "one": 1.0, "heavy": 1e6}, 1e10
    bodies = {name: ball(m, (0, 0, -1.0 - i)) for i, (name, m) in enumerate(masses.items())}
    names = [None, *masses]
    springs = [
        dynamics.Spring(0, 0, stiffness, 1.0, 2e4 * np.sqrt(stiffness * masses[b]), b, a)
        for a, b in zip(names, names[1:], strict=False)
    ]
    simulation = dynamics.Simulation(dynamics.System(bodies), [GRAVITY, *springs], integrator="implicit")
    found = simulation.run(1e4, times=[1e4], rtol=1e-6)
    assert not found.message and found.steps < 1000
    borne, place = sum(masses.values()), 0.0
    for name, mass in masses.items():
        place -= 1.0 + borne * G / stiffness
        borne -= mass
        assert abs(found[name].position[-1, 2] - place) < 1e-6
        assert np.abs(found[name].velocity[-1]).max() < 1e-8


def test_decays_are_exact_and_come_to_an_end():
    """A grain in honey: it goes m v/c far, and turns I w/c; what is left of its rates counts as none."""
    grain = ball(1e-6, velocity=(1, 2, 3), angular_velocity=(0, 0, 5))
    for loads in ([dynamics.Damper(1e-3, 1e3)], [dynamics.Damper(1e-3, 1e3), GRAVITY]):
        found = dynamics.Simulation(grain, loads, integrator="implicit").run(1000.0, times=[1000.0])
        fall = 1000.0 * G * 1e-9 * (len(loads) > 1)
        assert not found.message and found.steps < 400
        expected = 1e-9 * np.array([1.0, 2, 3]) - [0, 0, fall]
        assert np.abs(found.position[-1] - expected).max() < 1e-11
        turned = np.arctan2(found.orientation[-1][1, 0], found.orientation[-1][0, 0])
        assert abs(turned - 5 * 1e-7 / 1e-3) < 1e-9


@pytest.mark.parametrize("loads", [[], [GRAVITY], [dynamics.QuadraticDrag(1e3, 1e3)]], ids=["free", "falls", "drag"])
def test_what_has_nothing_stiff(loads):
    still = dynamics.Simulation(ball(), loads, integrator="implicit").run(2.0, times=[2.0])
    fall = 2.0 * G * (GRAVITY in loads)
    assert not still.message and np.abs(still.position[-1] + [0, 0, fall]).max() < 1e-12
    moving = ball(velocity=(1, 2, 3), angular_velocity=(1, 20, 0.1))
    found = dynamics.Simulation(moving, loads, integrator="implicit").run(2.0, times=[2.0])
    other = dynamics.Simulation(moving, loads, integrator="adaptive").run(2.0, times=[2.0])
    assert not found.message and np.abs(found.position[-1] - other.position[-1]).max() < 1e-9


def test_functions_of_users_are_called_and_taken_as_not_stiff():
    def brake(_, motor, twist):
        return dynamics.wrench(-0.5 * CGA.matrix(motor)[:3, 3], (0, 0, 0)) + 0 * twist

    loads = [dynamics.WorldWrench(brake), dynamics.Damper(1e4, 1e4)]
    body = ball(position=(1.0, 0, 0))
    found = dynamics.Simulation(body, loads, integrator="implicit").run(1e4, times=[1e4], rtol=1e-8)
    assert not found.message and abs(found.position[-1, 0] - np.exp(-0.5 * 1e4 / 1e4)) < 1e-6


def test_batches_have_the_bits_of_their_items():
    bodies = dynamics.RigidBody(np.array([0.5, 1.0, 2.0]), (1, 1, 1), (0.3, 0, -1.1))
    loads = [GRAVITY, dynamics.Spring(0, 0, 1e6, 1.0, 1e5)]
    whole = dynamics.Simulation(bodies, loads, integrator="implicit").run(1.0, times=[0.5, 1.0], threads=2)
    for i, mass in enumerate((0.5, 1.0, 2.0)):
        body = dynamics.RigidBody(mass, (1, 1, 1), (0.3, 0, -1.1))
        single = dynamics.Simulation(body, loads, integrator="implicit").run(1.0, times=[0.5, 1.0])
        assert single.position.tobytes() == whole.position[i].tobytes() and single.steps == whole.steps[i]


def test_auto_is_implicit_where_loads_damp_fast():
    """By the rates of decay and the length of the run: nothing else takes it; sensitivities do too."""
    spring, drag = dynamics.Spring(0, 0, 1e8, 1.0, 1e6), dynamics.Damper(1e6, 0.0)
    pair = dynamics.System({"a": ball(), "b": ball(position=(1.0, 0, 0))})
    between = dynamics.Damper(0.0, 1e6, "a", "b")
    for subject, load in ((ball(position=(0, 0, -1)), spring), (ball(), drag), (pair, between)):
        found = dynamics.Simulation(subject, [GRAVITY, load]).run(1.0, times=[1.0])
        assert found.integrator == "implicit" and not found.message
    for load in (dynamics.Spring(0, 0, 1e3, 1.0, 1.0), dynamics.Damper(1.0, 1.0)):
        found = dynamics.Simulation(ball(position=(0, 0, -1)), [GRAVITY, load]).run(1.0, times=[1.0])
        assert found.integrator == "taylor"
    short = dynamics.Simulation(ball(), [GRAVITY, drag]).run(1e-4, times=[1e-4])
    assert short.integrator == "taylor"
    run = dynamics.Simulation(ball(), [GRAVITY, drag]).run(0.02, times=[0.02], sensitivities=["mass"], rtol=1e-4)
    assert run.integrator == "implicit"


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["blanes-moan", "yoshida6"])
def test_the_energy_of_a_heavy_top_stays_for_a_million_steps(integrator):
    """Bounded, and no drift but rounding: a line through its errors rises by less than 1e-18 a step."""
    lean, spin, steps = 0.4, 60.0, 1_000_000
    axis = np.array([np.sin(lean), 0, np.cos(lean)])
    rotation = np.stack([[np.cos(lean), 0, -np.sin(lean)], [0, 1, 0], axis], 1)
    body = dynamics.RigidBody(1.0, (0.1, 0.1, 0.02), axis, rotation, angular_velocity=(0, 0, spin), algebra=PGA)
    pin = dynamics.Pin(PGA.point((0, 0, -1.0)), PGA.point((0, 0, 0)))
    step = 2 * np.pi * 1.1 / (0.02 * spin) / 1000  # a thousandth of a nutation
    top_run = dynamics.Simulation(body, [GRAVITY], [pin], integrator=integrator).run(
        steps * step, step=step, times=np.linspace(0, steps * step, 401)[1:]
    )
    error = top_run.energy / top_run.energy[0] - 1
    assert np.abs(error).max() < 1e-11
    assert abs(np.polyfit(np.linspace(0, steps, len(error)), error, 1)[0]) < 1e-18
