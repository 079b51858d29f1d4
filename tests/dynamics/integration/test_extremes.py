"""A million steps; bodies that are far away, tiny, heavy; and batches, which are single runs side by side."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bladesmith import cga3d as cga
from bladesmith import dynamics, kinematics
from bladesmith import pga3d as pga
from bladesmith.dispatch.formulas import ArrayOperand, evaluate

from ...oracles.tops import TOPS
from ...support.dynamics.states import ALGEBRAS, MOMENTS, sized_body
from ...support.effort import FULL
from ...support.vectors import unit
from .test_references import simulation

EACH_ALGEBRA = pytest.mark.parametrize("algebra", ALGEBRAS.values(), ids=ALGEBRAS)
GRAVITY = dynamics.Gravity([0.0, 0.0, -9.81])

# -- a million steps -------------------------------------------------------------------------------------------


def stores(duration, count=101):
    return np.linspace(0, duration, count)


def drift(values):
    """Largest departure from the start, as a share of the start's size."""
    return np.abs(values - values[0]).max() / np.abs(values[0]).max()


TOPS_OF_ALGEBRAS = [("cuboid", pga), ("heavy top", cga), ("lopsided top", pga)]


STEPPED = TOPS_OF_ALGEBRAS if FULL else TOPS_OF_ALGEBRAS[1:2]  # a million steps take two seconds


@pytest.mark.compiles
@pytest.mark.parametrize(
    ("name", "algebra", "integrator"),
    [*((*top, "auto") for top in TOPS_OF_ALGEBRAS), *((*top, "blanes-moan") for top in STEPPED)],
)
def test_energy_stays_over_a_million_steps(name, algebra, integrator):
    """1000 s: at the default settings, and in steps of 1 ms."""
    found = simulation(TOPS[name], algebra, integrator=integrator).run(1000.0, times=stores(1000.0))
    assert integrator == "auto" or found.steps == 1_000_000
    assert drift(found.energy) <= 1e-8
    assert found.violation.max() <= 1e-12
    momentum = dynamics.screw_coordinates(found.momentum)
    kept = 1e-10 if integrator == "auto" else 1e-11  # compositions keep it but for rounding
    if name == "cuboid":
        assert drift(momentum) <= kept
    else:  # about the vertical through the pin
        vertical = np.array(TOPS[name].gravity) / np.linalg.norm(TOPS[name].gravity)
        assert drift(momentum[:, 3:] @ vertical) <= kept


HELD = {
    "line": (cga, lambda a: [a.line([0.3, 0.0, 0.5], [0.6, 0.0, 0.8])], "rk4"),
    "circle": (cga, lambda a: [a.circle([0.3, 0.0, 0.5], [0.6, 0.0, 0.8], 0.7)], "rk4"),
    "point": (pga, lambda a: [a.point([0.3, 0.0, 0.5])], "rkmk4"),
    "plane": (pga, lambda a: [a.plane([0.6, 0.0, 0.8], 0.4)], "rk4"),
    "two points": (pga, lambda a: [a.point([0.3, 0.0, 0.5]), a.point([0.1, 0.4, 0.5])], "cf4"),
    "point pair": (cga, lambda a: [a.point_pair([0.3, 0.0, 0.5], [0.1, 0.4, 0.5])], "midpoint"),
    "sphere": (cga, lambda a: [a.sphere([0.3, 0.0, 0.5], 0.7)], "blanes-moan"),
}


@pytest.mark.compiles
@pytest.mark.parametrize("name", HELD if FULL else ["two points"])
def test_pins_hold_over_a_million_steps(name):
    """Steps of 0.1 ms, so that integrators without a memory keep their energy too; a plane lets the body fall."""
    algebra, objects, integrator = HELD[name]
    steps = 1_000_000 if FULL else 200_000
    turn = Rotation.from_rotvec([0.5, 1.0, 0.3]).as_matrix()
    body = dynamics.RigidBody(2.0, [1.0, 2.0, 2.5], [1.0, 2.0, 3.0], turn, algebra=algebra)
    pins = [dynamics.Pin(x) for x in objects(algebra)]
    found = dynamics.Simulation(body, [GRAVITY], pins, integrator).run(
        steps * 1e-4, step=1e-4, times=stores(steps * 1e-4)
    )
    place = max(1.0, np.abs(found.position).max())  # coefficients grow with the way
    assert found.violation.max() <= 1e-12 * place
    parts = np.abs(found.energy[0]) + 2.0 * 9.81 * np.ptp(found.position[:, 2])  # along a line the body falls far
    assert np.abs(found.energy - found.energy[0]).max() <= (1e-6 if integrator == "midpoint" else 1e-9) * parts


# -- sizes and places ------------------------------------------------------------------------------------------
#
# The same motion, of a body whose lengths are s times as long, whose mass is m times as much, and that is elsewhere:
# places differ by s and the way, forces by s m, moments by s^2 m. Errors are shares of the body's own size.

SCALES = {
    "far away": (1.0, 1.0, [6e3, -7e3, 4e3]),
    "a micrometre": (1e-6, 1.0, [0.0, 0.0, 0.0]),
    "a micrometre of a picogram": (1e-6, 1e-15, [1e-5, 0.0, 2e-5]),
    "ten tons of a millimetre": (1e-3, 1e4, [0.0, 0.0, 0.0]),
    "a planet": (1e6, 1e20, [0.0, 0.0, 0.0]),
}
P, Q = np.array([0.2, 0.1, 0.6]), np.array([-0.3, 0.4, 0.5])
AXIS = unit(np.array([1.0, 2.0, 2.0]))
TURN = Rotation.from_rotvec([0.5, 1.0, 0.3]).as_matrix()


def free(a, s, at):
    return [], np.array([0.3, -0.2, 0.1]), np.array([0.5, 2.0, -1.0])


def on_point(a, s, at):
    spin = np.array([0.5, 2.0, -1.0])
    return [dynamics.Pin(a.point(s * P))], -TURN @ np.cross(spin, P), spin


def on_line(a, s, at):
    return [dynamics.Pin(a.line(s * P, AXIS))], -TURN @ np.cross(2 * AXIS, P), 2 * AXIS


def on_two_points(a, s, at):
    axis = unit(Q - P)
    pins = [dynamics.Pin(a.point(s * P)), dynamics.Pin(a.point(s * Q))]
    return pins, -TURN @ np.cross(2 * axis, P), 2 * axis


def on_sphere(a, s, at):
    """A point of the body on a sphere about a place beside it; both velocities zero."""
    center = TURN @ P + np.array([0.0, 0.6, 0.8])
    return [dynamics.Incidence(a.point(s * P), a.sphere(at + s * center, s * 1.0))], np.zeros(3), np.zeros(3)


def on_plane(a, s, at):
    normal = unit(np.array([1.0, 0.0, 2.0]))
    spin = np.array([0.5, 2.0, -1.0])
    rate = TURN @ np.cross(spin, P)
    plane = a.plane(normal, normal @ (at + s * TURN @ P))
    return [dynamics.Incidence(a.point(s * P), plane)], -normal * (normal @ rate), spin


def on_a_path(a, s, at):
    """A point that is shaken."""
    pin = TURN @ P
    spin = np.array([0.5, 2.0, -1.0])
    shake = np.array([0.1, 0.05, 0.2])

    def path(t):
        return a.point(at + s * (pin + shake * np.sin(3 * t)))

    return [dynamics.PinPath(a.point(s * P), path)], 3 * shake - TURN @ np.cross(spin, P), spin


def motion(algebra, held, s, m, at):
    """Turns, places of the centre of mass as shares of the size, forces and moments about it in units of the body."""
    at = np.asarray(at)
    pins, velocity, spin = held(algebra, s, at)
    body = dynamics.RigidBody(
        2.0 * m, m * s**2 * np.array([1.0, 1.5, 2.0]), at, TURN, s * velocity, spin, algebra=algebra
    )
    found = dynamics.Simulation(body, [dynamics.Gravity([0.0, 0.0, -9.81 * s])], pins).run(1.0, times=[0.0, 0.5, 1.0])
    reaction = dynamics.screw_coordinates(found.reaction)
    away = (found.position - at) / s
    moment = reaction[:, 3:] - np.cross(found.position, reaction[:, :3])
    return found.orientation, away, reaction[:, :3] / (m * s), moment / (m * s * s)


CASES = [
    ("free", free, pga), ("point", on_point, cga), ("line", on_line, cga), ("two points", on_two_points, pga),
    ("sphere", on_sphere, cga), ("plane", on_plane, pga), ("path", on_a_path, pga),
]  # fmt: skip


@pytest.mark.compiles
@pytest.mark.parametrize(("name", "held", "algebra"), CASES, ids=[c[0] for c in CASES])
def test_size_mass_and_place_change_nothing(name, held, algebra):
    turn, place, force, moment = motion(algebra, held, 1.0, 1.0, np.zeros(3))
    for what, (s, m, at) in SCALES.items():
        shifted = np.abs(at).max() / s
        found = motion(algebra, held, s, m, at)
        digits = 1e-9 + 4e-16 * shifted  # what a place that far away can say of the body at all
        if name == "sphere":  # one coefficient is the square of the distance less that of the radius
            digits += 1e-15 * shifted**2
        assert np.abs(found[0] - turn).max() < digits, what
        assert np.abs(found[1] - place).max() < digits, what
        assert np.abs(found[2] - force).max() < 100 * digits, what
        assert np.abs(found[3] - moment).max() < 100 * digits * (1 + shifted * np.abs(force).max()), what


# -- batches ---------------------------------------------------------------------------------------------------


def batch(n, algebra):
    rng = np.random.default_rng(5)
    turns = Rotation.random(n, random_state=5).as_matrix()
    return {
        "mass": rng.uniform(1, 2, n), "inertia": rng.uniform(1.0, 1.9, (n, 3)), "position": rng.normal(size=(n, 3)),
        "orientation": turns, "angular_velocity": rng.normal(size=(n, 3)),
    }  # fmt: skip


def arrays(found):
    states = [x.values for x in (found.motor, found.twist, found.reaction)]
    return [*states, found.violation, found.energy, found.position]


@pytest.mark.compiles
@pytest.mark.parametrize(
    ("objects", "algebra", "integrator", "how"),
    [
        ([], pga, "auto", "auto"),
        ([], pga, "rk4", "auto"),
        (["point"], pga, "auto", "auto"),
        (["line"], cga, "auto", "auto"),
        (["point"], cga, "auto", "projection"),
        (["line"], cga, "rkmk4", "projection"),
    ],
)
def test_a_batch_is_its_single_runs_bit_for_bit(objects, algebra, integrator, how):
    n, time = 5, 0.2
    numbers = batch(n, algebra)
    if objects:  # at rest, so that every pin finds it so
        numbers["angular_velocity"] = np.zeros((n, 3))
    known = {"point": algebra.point(P), "line": algebra.line(P, AXIS)}
    pins = [dynamics.Pin(known[x]) for x in objects]

    def run(**given):
        body = dynamics.RigidBody(**given, algebra=algebra)
        spring = dynamics.Spring([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], 3.0, 0.5)
        loads = [GRAVITY] if objects else [GRAVITY, spring]  # programs of held bodies serve other tests, too
        held = dynamics.Simulation(body, loads, pins, integrator, stabilization=how)
        return [held.run(time, times=[0.0, 0.1, time], threads=threads) for threads in (1, 2)]

    one, two = (arrays(x) for x in run(**numbers))
    for a, b in zip(one, two, strict=True):
        assert np.array_equal(a, b)
    for i in range(n):
        alone, _ = run(**{key: value[i] for key, value in numbers.items()})
        for a, b in zip(one, arrays(alone), strict=True):
            assert np.array_equal(a[i], b), (i, np.abs(a[i] - b).max())


# -- small bodies in fast flight -------------------------------------------------------------------------------


def test_small_bodies_in_fast_flight_turn_as_at_rest():
    """Rounding of m v x v is no torque: it made steps a thousand times shorter."""
    ends, steps = [], []
    for speed in (0.0, 10.0):
        velocity = speed * np.array([1.0, 0.3, -0.7])
        made = sized_body(1e-6, velocity=velocity, angular_velocity=(30.0, 10.0, 100.0))
        found = dynamics.Simulation(made, [GRAVITY], [], "adaptive").run(0.1, times=[0.1])
        steps.append(found.steps)
        ends.append(found.angular_velocity[-1])
    assert steps[1] <= 2 * steps[0] + 20
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-9 * 100)


@pytest.mark.parametrize("algebra", [cga, pga], ids=["cga3d", "pga3d"])
def test_what_turning_takes_at_the_centre_of_mass(algebra):
    """All of Omega x Psi: v x m v is zero."""
    rng = np.random.default_rng(5)
    w, v = rng.normal(size=(2, 20, 3))
    twist = dynamics.twist(w, v, algebra=algebra)
    psi = evaluate(
        algebra, "mechanics.principal_momentum", ArrayOperand(np.full(20, 2.0), 0, "the mass"),
        algebra.spatial(np.tile(MOMENTS, (20, 1)), "the moments"), twist,
    ).value  # fmt: skip
    numbers = evaluate(algebra, "mechanics.covector_of", psi).value
    given = ArrayOperand(numbers, 6, "the momentum")
    rows = [evaluate(algebra, f"mechanics.{f}", twist, given).value for f in ("gyroscopic", "central_gyroscopic")]
    np.testing.assert_allclose(rows[1], rows[0], atol=1e-13)
    assert np.abs(rows[1]).max() > 0.1


# -- the least motions -----------------------------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize("speed", [1e-100, 1e-160, 1e-170, 1e-300])
def test_motions_of_any_size_are_as_exact(speed):
    """Ten swings of a body on a spring, and of a joint with one: errors' squares are zero, errors are not."""
    own, duration = np.sqrt(40.0), 10.0
    body = dynamics.RigidBody(1.0, (1, 1, 1), velocity=(speed, 0, 0))
    pull = dynamics.Spring((0, 0, 0), (0, 0, 0), 40.0)
    run = dynamics.Simulation(body, pull, integrator="adaptive").run(duration, times=[duration])
    assert run.position[-1][0] / speed == pytest.approx(np.sin(own * duration) / own, rel=1e-9)
    wheel = dynamics.RigidBody(1.0, (1, 1, 1), angular_velocity=(0, speed, 0))
    hinge = kinematics.Revolute("base", "wheel", point=(0, 0, 0), axis=(0, 1, 0))
    system = dynamics.System({"wheel": wheel}, hinge, joint_names=["hinge"])
    run = dynamics.Simulation(system, dynamics.JointSpring("hinge", 40.0), integrator="adaptive").run(duration)
    assert run.rates("hinge")[-1] / speed == pytest.approx(np.cos(own * duration), rel=1e-9)
