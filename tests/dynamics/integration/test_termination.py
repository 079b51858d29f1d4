"""Runs that end early: constraints that contradict each other, functions that fail; and violations of rates."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from bladesmith import Status, dynamics
from bladesmith import cga3d as cga
from bladesmith import pga3d as pga
from bladesmith.dynamics.assembly import callbacks
from bladesmith.errors import Interrupted, SimulationError

from ...support.dynamics.states import MOMENTS, sized_body

GRAVITY = dynamics.Gravity([0.0, 0.0, -9.81])
#: Radius of gyration of bodies with these moments and unit mass: what is told is a share of it.
REACH = 0.5
PLACE = np.array([0.3, 0.4, 0.5])


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
    made = sized_body(size, origin, algebra, angular_velocity=spin * axis)
    return dynamics.Simulation(made, [GRAVITY], held, integrator)


CASES = {
    "a metre": (cga, 1.0, 0.0, "adaptive"),
    "far away": (cga, 1.0, 1e3, "adaptive"),
    "a micrometre": (cga, 1e-6, 0.0, "adaptive"),
    "PGA, fixed steps": (pga, 1.0, 1e3, "rk4"),
}


@pytest.mark.compiles
@pytest.mark.parametrize("name", CASES)
def test_constraints_that_part_are_told(name):
    """Which, when and by how much: the way apart, as a share of the body's size. What was until then is there."""
    algebra, size, far, integrator = CASES[name]
    sim = two_paths(algebra, size, far, 1e-3, 0.0, integrator)
    with pytest.raises(SimulationError, match=r"contradict each other: constraint 1 \(PinPath\)") as caught:
        sim.run(1.0, step=0.01, strict=True)
    said = re.search(r"residual of (\S+) of the body's size.* at time (\S+)\.", str(caught.value))
    assert said is not None
    share, time = map(float, said.groups())
    apart = 1e-3 * time**3 * np.linalg.norm(PLACE) / REACH
    assert 0.3 * apart <= share <= 1.01 * apart  # along a row, or along the way between the points
    assert 0.08 <= time <= 0.14  # 1e-6 of the size are passed at 0.11 to 0.13, and steps are 0.01
    found = caught.value.trajectory
    assert len(found) >= 8 and found.time[-1] < time and found.ending == "constraints violated"
    assert found.violation.max() <= 1e-6 * size
    with pytest.warns(RuntimeWarning, match="ended early"):
        quiet = sim.run(1.0, step=0.01)
    assert quiet.ending == "constraints violated" and quiet.message == str(caught.value).partition(". Check")[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_constraints_that_agree_are_let_be(name):
    algebra, size, far, integrator = CASES[name]
    found = two_paths(algebra, size, far, 0.0, 2.0, integrator).run(1.0, step=0.01)
    assert found.ending == "ok" and found.message == ""
    # coefficients of points in CGA hold squares of the distance
    assert found.violation.max() <= 1e-12 * max(1.0, far ** (2 if algebra is cga else 1))


def on_sphere_and_path():
    point = dynamics.Incidence(cga.point((0, 0, 0)), cga.sphere((0, 0, 0), 1.0))
    path = dynamics.PinPath(cga.point((0, 0, 0)), lambda t: cga.point((1 + t**3, 0, 0)))
    return sized_body(position=(1.0, 0, 0)), [point, path]


def growing_sphere():
    return sized_body(), [dynamics.PinPath(cga.sphere((0, 0, 0), 1.0), lambda t: cga.sphere((0, 0, 0), 1 + t**4))]


def path_against_power():
    lift = dynamics.wrench((0, 0, 1.0), (0, 0, 0))
    return sized_body(), [
        dynamics.PinPath(cga.point((0, 0, 0)), lambda t: cga.point((0, 0, t**3))),
        dynamics.VirtualPower(lift),
    ]


@pytest.mark.compiles
@pytest.mark.parametrize("case", [on_sphere_and_path, growing_sphere, path_against_power])
def test_other_contradictions_are_told(case):
    """A point that leaves its sphere, a size that no motion changes, a velocity that is forbidden."""
    made, held = case()
    with pytest.raises(SimulationError, match=r"contradict each other: .*constraint \d .* at time 0\.") as caught:
        dynamics.Simulation(made, [], held).run(0.5, step=0.01, strict=True)
    assert len(caught.value.trajectory) >= 1


# -- rates that are constrained --------------------------------------------------------------------------------


def rolling(integrator, stabilization):
    """A ball that rolls on a plane, pulled along it."""
    radius, spin = 0.5, np.array([0.3, -0.2, 5.0])

    def slips(t, motor, twist):
        matrix = cga.matrix(motor)
        below, axes = matrix[:3, 3] - [0, 0, radius], np.eye(3)
        velocity = matrix[:3, :3] @ dynamics.twist_parts(twist)[1]
        return dynamics.wrench(axes, np.tile(below, (3, 1))), dynamics.couple(np.cross(velocity, axes))

    made = sized_body(position=(0, 0, radius), velocity=np.cross(spin, [0, 0, radius]), angular_velocity=spin)
    pull = dynamics.Gravity((2.0, 1.0, -9.0))
    sim = dynamics.Simulation(made, [pull], [dynamics.VirtualPower(slips)], integrator, stabilization=stabilization)
    return sim.run(2.0, step=0.05)


@pytest.mark.compiles
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


@pytest.mark.compiles
@pytest.mark.parametrize(("integrator", "held"), [("adaptive", False), ("adaptive", True)], ids=["free", "held"])
def test_a_function_that_fails_at_once_is_told_like_later_ones(integrator, held):
    bad = dynamics.WorldWrench(lambda t: dynamics.wrench((0, 0, np.nan), (0, 0, 0)))
    plane = [dynamics.Incidence(cga.point((0, 0, 0)), cga.plane((0, 0, 1), 0))] if held else []
    sim = dynamics.Simulation(sized_body(position=(1.0, 2.0, 0)), [bad], plane, integrator)
    with pytest.raises(
        SimulationError, match=r"world wrench failed at time 0: .*nan.*motor \[.*\] with twist"
    ) as caught:
        sim.run(0.1, strict=True)
    found = caught.value.trajectory
    assert found.ending == "function failed" and found.message == str(caught.value)
    assert found.position.shape == (len(found), 3) and len(found) <= 1
    with pytest.warns(RuntimeWarning, match="ended early"):
        quiet = sim.run(0.1)
    assert quiet.ending == "function failed" and quiet.message == found.message


def test_an_interrupt_at_once_ends_a_run():
    def interrupted(t):
        raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        dynamics.Simulation(sized_body(), [dynamics.WorldWrench(interrupted)], [], "adaptive").run(0.1)
    found = caught.value.partial
    assert found.message == "interrupted" and found.ending == "stopped"


def test_messages_come_from_executors_too():
    spins = np.array([[0, 0, 1.0], [1e300, 1e300, 0]])
    sim = dynamics.Simulation(sized_body(angular_velocity=spins), [GRAVITY], [], "adaptive")
    alone = sim.run(0.1)
    with ThreadPoolExecutor(2) as executor:
        shared = sim.run(0.1, executor=executor)
    assert list(alone.ending) == list(shared.ending) == ["ok", "step underflow"]
    assert re.search(r"steps became too small to go on, at time .*, simulation 1", alone.message)
    assert list(alone.status) == [Status.OK, Status.NOT_CONVERGED] and list(alone.converged) == [True, False]
    with pytest.raises(SimulationError, match="too small to go on, at time .*, simulation 1"):
        sim.run(0.1, strict=True)
    assert shared.message == alone.message


def test_an_interrupt_before_the_first_line_of_a_function(monkeypatch):
    asked = []
    plain = callbacks.CallbackRegistry.call

    def interrupted(self, *given):
        asked.append(1)
        if len(asked) == 500:
            raise KeyboardInterrupt  # as it comes where nothing is caught yet
        return plain(self, *given)

    monkeypatch.setattr(callbacks.CallbackRegistry, "call", interrupted)
    push = dynamics.wrench((0, 0, 1), 0)
    body = dynamics.RigidBody(1.0, [0.1, 0.2, 0.25], angular_velocity=(1, 5, 1))
    with pytest.raises(Interrupted) as caught:
        dynamics.Simulation(body, dynamics.WorldWrench(lambda t: push), (), "rk4").run(10.0, step=0.01)
    found = caught.value.partial
    assert found.message == "interrupted" and found.ending == "stopped" and 1 < len(found) < 1001
    assert np.isfinite(found.position).all() and len(asked) == 500
