"""Simulations in trouble: constraints that part on the way, functions that fail, bodies far along a line or in fast
flight; and none that is told where there is none."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import dynamics
from bladesmith import pga3d as pga
from bladesmith.calls import Numbers, call
from bladesmith.errors import SimulationError

GRAVITY = dynamics.Gravity([0.0, 0.0, -9.81])
MOMENTS = np.array([0.1, 0.2, 0.25])
#: Radius of gyration of bodies with these moments and unit mass: what is told is a share of it.
REACH = 0.5
PLACE = np.array([0.3, 0.4, 0.5])


def body(size=1.0, position=(0.0, 0.0, 0.0), algebra=cga, **given):
    """One whose lengths are `size` times as long."""
    return dynamics.RigidBody(size**3, MOMENTS * size**5, position, algebra=algebra, **given)


# -- constraints that part -------------------------------------------------------------------------------------


def two_paths(algebra, size, far, rate, spin, integrator):
    """Two points of a body on paths that turn together, and part as time's cube."""
    origin, axis = far * np.array([1.0, 2.0, 3.0]), np.array([0.6, 0.0, 0.8])

    def turned(t):
        across = np.cross(axis, PLACE)
        return axis * (axis @ PLACE) * (1 - np.cos(spin * t)) + PLACE * np.cos(spin * t) + across * np.sin(spin * t)

    def path(t):
        return algebra.point(origin + size * (1 + rate * t**3) * turned(t))

    held = [
        dynamics.Pin(algebra.point((0, 0, 0)), algebra.point(origin)),
        dynamics.PinPath(algebra.point(size * PLACE), path),
    ]
    made = body(size, origin, algebra, angular_velocity=spin * axis)
    return dynamics.Simulation(made, [GRAVITY], held, integrator)


CASES = {
    "a metre": (cga, 1.0, 0.0, "adaptive"),
    "far away": (cga, 1.0, 1e3, "adaptive"),
    "a micrometre": (cga, 1e-6, 0.0, "adaptive"),
    "PGA, fixed steps": (pga, 1.0, 1e3, "rk4"),
}


@pytest.mark.parametrize("name", CASES)
def test_constraints_that_part_are_told(name):
    """Which, when and by how much: the way apart, as a share of the body's size. What was until then is there."""
    algebra, size, far, integrator = CASES[name]
    sim = two_paths(algebra, size, far, 1e-3, 0.0, integrator)
    with pytest.raises(SimulationError, match=r"contradict each other: constraint 1 \(PinPath\)") as caught:
        sim.run(1.0, step=0.01)
    share, time = map(float, re.search(r"by (\S+) of the body's size.* at time (\S+)\.", str(caught.value)).groups())
    apart = 1e-3 * time**3 * np.linalg.norm(PLACE) / REACH
    assert 0.3 * apart <= share <= 1.01 * apart  # along a row, or along the way between the points
    assert 0.08 <= time <= 0.14  # 1e-6 of the size are passed at 0.11 to 0.13, and steps are 0.01
    found = caught.value.trajectory
    assert len(found) >= 8 and found.time[-1] < time and found.status == "constraints violated"
    assert found.violation.max() <= 1e-6 * size
    quiet = sim.run(1.0, step=0.01, strict=False)
    assert quiet.status == "constraints violated" and quiet.message == str(caught.value).partition(". Mend")[0]


@pytest.mark.parametrize("name", CASES)
def test_constraints_that_agree_are_let_be(name):
    algebra, size, far, integrator = CASES[name]
    found = two_paths(algebra, size, far, 0.0, 2.0, integrator).run(1.0, step=0.01)
    assert found.status == "ok" and found.message == ""
    # coefficients of points in CGA hold squares of the distance
    assert found.violation.max() <= 1e-12 * max(1.0, far ** (2 if algebra is cga else 1))


def on_sphere_and_path():
    point = dynamics.Incidence(cga.point((0, 0, 0)), cga.sphere((0, 0, 0), 1.0))
    path = dynamics.PinPath(cga.point((0, 0, 0)), lambda t: cga.point((1 + t**3, 0, 0)))
    return body(position=(1.0, 0, 0)), [point, path]


def growing_sphere():
    return body(), [dynamics.PinPath(cga.sphere((0, 0, 0), 1.0), lambda t: cga.sphere((0, 0, 0), 1 + t**4))]


def path_against_power():
    lift = dynamics.wrench((0, 0, 1.0), (0, 0, 0))
    return body(), [
        dynamics.PinPath(cga.point((0, 0, 0)), lambda t: cga.point((0, 0, t**3))),
        dynamics.VirtualPower(lift),
    ]


@pytest.mark.parametrize("case", [on_sphere_and_path, growing_sphere, path_against_power])
def test_other_contradictions_are_told(case):
    """A point that leaves its sphere, a size that no motion changes, a velocity that is forbidden."""
    made, held = case()
    with pytest.raises(SimulationError, match=r"contradict each other: .*constraint \d .* at time 0\.") as caught:
        dynamics.Simulation(made, [], held).run(0.5, step=0.01)
    assert len(caught.value.trajectory) >= 1


# -- far along a line ------------------------------------------------------------------------------------------


def test_a_bead_falls_far_along_a_line():
    """4905 km: rows of which nothing but rounding is left are no new ones."""
    line = dynamics.Incidence(cga.point((0, 0, 0)), cga.line((0, 0, 0), (0, 0, 1)))
    made = body(angular_velocity=(0.3, 0.1, 1.0))
    found = dynamics.Simulation(made, [GRAVITY], [line]).run(1000.0, times=[30.0, 1000.0])
    np.testing.assert_allclose(found.position[:, 2], -9.81 / 2 * found.time**2, rtol=1e-12)
    assert (np.abs(found.position[1:, :2]) <= 1e-14 * np.abs(found.position[1:, 2:])).all()


def test_a_tiny_bead_flies_far_along_a_line():
    """Ten million times its own size."""
    line = dynamics.Incidence(cga.point((0, 0, 0)), cga.line((0, 0, 0), (0, 0, 1)))
    made = body(1e-6, velocity=(0, 0, 1.0), angular_velocity=(3.0, 1.0, 10.0))
    found = dynamics.Simulation(made, [GRAVITY], [line]).run(2.0, times=[2.0])
    assert found.position[-1, 2] == pytest.approx(2.0 - 9.81 / 2 * 4.0, rel=1e-12)
    assert np.abs(found.position[-1, :2]).max() <= 1e-14


# -- rates that are constrained --------------------------------------------------------------------------------


def rolling(integrator, stabilization):
    """A ball that rolls on a plane, pulled along it."""
    radius, spin = 0.5, np.array([0.3, -0.2, 5.0])

    def slips(t, motor, twist):
        matrix = cga.matrix(motor)
        below, axes = matrix[:3, 3] - [0, 0, radius], np.eye(3)
        velocity = matrix[:3, :3] @ dynamics.twist_parts(twist)[1]
        return dynamics.wrench(axes, np.tile(below, (3, 1))), dynamics.couple(np.cross(velocity, axes))

    made = body(position=(0, 0, radius), velocity=np.cross(spin, [0, 0, radius]), angular_velocity=spin)
    pull = dynamics.Gravity((2.0, 1.0, -9.0))
    sim = dynamics.Simulation(made, [pull], [dynamics.VirtualPower(slips)], integrator, stabilization=stabilization)
    return sim.run(2.0, step=0.05)


def test_violation_tells_of_rates():
    """Slip, as a share of what the row could be of the body's velocity, by energy."""
    found = rolling("rk4", "none")
    turn, spin = found.orientation, np.einsum("nij,nj->ni", found.orientation, found.angular_velocity)
    slip = found.velocity + np.cross(spin, [0, 0, -REACH])
    levers = np.einsum("nij,kj->nki", turn.transpose(0, 2, 1), np.cross([0, 0, -REACH], np.eye(3)))
    rows = np.sqrt(1 + (levers**2 / MOMENTS).sum(-1))
    energy = (found.velocity**2).sum(-1) + (MOMENTS * found.angular_velocity**2).sum(-1)
    least = REACH / 2.0  # a body that moves less than its size in the run stands
    expected = (np.abs(slip) / (rows * (np.sqrt(energy) + least)[:, None])).max(-1)
    assert expected.max() > 1e-4
    np.testing.assert_allclose(found.violation, expected, rtol=1e-6, atol=1e-14)
    assert rolling("rk4", "projection").violation.max() <= 1e-14


# -- functions that fail ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("integrator", "held"), [("adaptive", False), ("adaptive", True)], ids=["free", "held"])
def test_a_function_that_fails_at_once_is_told_like_later_ones(integrator, held):
    bad = dynamics.WorldWrench(lambda t: dynamics.wrench((0, 0, np.nan), (0, 0, 0)))
    plane = [dynamics.Incidence(cga.point((0, 0, 0)), cga.plane((0, 0, 1), 0))] if held else []
    sim = dynamics.Simulation(body(position=(1.0, 2.0, 0)), [bad], plane, integrator)
    with pytest.raises(
        SimulationError, match=r"world wrench failed at time 0: .*nan.*motor \[.*\] with twist"
    ) as caught:
        sim.run(0.1)
    found = caught.value.trajectory
    assert found.status == "function failed" and found.message == str(caught.value)
    assert found.position.shape == (len(found), 3) and len(found) <= 1
    quiet = sim.run(0.1, strict=False)
    assert quiet.status == "function failed" and quiet.message == found.message


def test_an_interrupt_at_once_ends_a_run():
    def interrupted(t):
        raise KeyboardInterrupt

    found = dynamics.Simulation(body(), [dynamics.WorldWrench(interrupted)], [], "adaptive").run(0.1)
    assert found.message == "interrupted" and found.status == "stopped"


def test_messages_come_from_executors_too():
    spins = np.array([[0, 0, 1.0], [1e300, 1e300, 0]])
    sim = dynamics.Simulation(body(angular_velocity=spins), [GRAVITY], [], "adaptive")
    alone = sim.run(0.1)
    with ThreadPoolExecutor(2) as executor:
        shared = sim.run(0.1, executor=executor)
    assert list(alone.status) == list(shared.status) == ["ok", "step underflow"]
    assert re.search(r"steps became too small to go on, at time .*, simulation 1", alone.message)
    assert shared.message == alone.message


# -- fast flight of small bodies -------------------------------------------------------------------------------


def test_small_bodies_in_fast_flight_turn_as_at_rest():
    """Rounding of m v x v is no torque: it made steps a thousand times shorter."""
    ends, steps = [], []
    for speed in (0.0, 10.0):
        velocity = speed * np.array([1.0, 0.3, -0.7])
        made = body(1e-6, velocity=velocity, angular_velocity=(30.0, 10.0, 100.0))
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
    psi = call(
        algebra, "mechanics.principal_momentum", Numbers(np.full(20, 2.0), 0, "the mass"),
        algebra.vector(np.tile(MOMENTS, (20, 1)), "the moments"), twist,
    ).value  # fmt: skip
    numbers = call(algebra, "mechanics.covector_of", psi).value
    given = Numbers(numbers, 6, "the momentum")
    rows = [call(algebra, f"mechanics.{f}", twist, given).value for f in ("gyroscopic", "central_gyroscopic")]
    np.testing.assert_allclose(rows[1], rows[0], atol=1e-13)
    assert np.abs(rows[1]).max() > 0.1
