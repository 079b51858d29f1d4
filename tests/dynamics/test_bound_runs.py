"""Runs that are prepared once: each call goes on where the last one ended."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d, dynamics, kinematics
from bladesmith.codegen.errors import ConstraintError, InputError, SimulationError
from bladesmith.dynamics.integration import runs

DOWN = dynamics.Gravity((0.0, 0.0, -9.81))


def body(count=1, **options):
    mass = 0.5 if count == 1 else np.full(count, 0.5)
    given = {"orientation": np.eye(3), "velocity": (0.1, 0.0, 0.2), "angular_velocity": (1.0, 2.0, -0.5), **options}
    return dynamics.RigidBody(mass, (0.02, 0.03, 0.04), (0.0, 0.0, 0.3), *given.values())


def top():
    held = body(velocity=np.cross((1.0, 2.0, -0.5), (0.0, 0.0, 0.3)))
    return dynamics.Simulation(held, [DOWN], [dynamics.Pin(cga3d.point((0.0, 0.0, -0.3)))])


def drop():
    return dynamics.Simulation(body(), [DOWN, dynamics.QuadraticDrag(0.1)], integrator="rk4")


@pytest.mark.parametrize("make", [top, drop])
def test_calls_go_on_as_one_run_does(make):
    simulation = make()
    bound = simulation.bound(0.2, times=[0.1, 0.2], step=0.01)
    whole = simulation.run(0.6, times=[0.4, 0.5, 0.6], step=0.01)
    bound()
    first, alone = bound.trajectory, simulation.run(0.2, times=[0.1, 0.2], step=0.01)
    assert np.array_equal(first.motor.values, alone.motor.values)
    assert np.array_equal(first.time, alone.time)
    bound()
    bound()
    last = bound.trajectory
    assert np.allclose(last.motor.values, whole.motor.values[1:], rtol=0, atol=1e-11)
    assert np.allclose(last.time, [0.4, 0.5, 0.6], rtol=0, atol=1e-15) and bound.time == last.time[-1]
    assert np.array_equal(first.motor.values, alone.motor.values), "what was asked for is not written to"
    bound.restart()
    bound()
    assert np.array_equal(bound.trajectory.motor.values, alone.motor.values)


def test_functions_see_time_go_on_and_their_errors_come_out():
    seen = []

    def push(time):
        seen.append(time)
        if time > 0.25:
            raise ValueError("enough")
        return dynamics.wrench((np.sin(time), 0.0, 0.0), 0)

    pushed = dynamics.Simulation(body(), [dynamics.WorldWrench(push)], integrator="rk4")
    bound = pushed.bound(0.1, step=0.01, times=[0.1])
    seen.clear()
    bound()
    bound()
    assert max(seen) == pytest.approx(0.2) and min(seen) == 0.0
    with pytest.raises(SimulationError, match="enough") as caught:
        bound()
    assert len(caught.value.trajectory.time) == 1
    seen.clear()
    bound()
    assert seen[0] == 0.0, "it begins anew"


@pytest.mark.parametrize("steps", [0, 5, 30])
def test_after_an_interrupt_states_and_time_belong_together(steps):
    """Before the first step, in between, and heard when the last one was done."""
    seen = []
    pushed = dynamics.Simulation(
        body(), [dynamics.WorldWrench(lambda time: (seen.append(time), dynamics.wrench((np.sin(time), 0, 0), 0))[1])],
        integrator="rk4",
    )  # fmt: skip
    bound, whole = (pushed.bound(0.3, step=0.01, times=[0.3]) for _ in range(2))
    bound()
    whole()
    advance, count = bound._bound, bound._run.driver.budget
    assert count >= 30

    def interrupted(begin, end):
        if steps:
            bound._run._control[runs._BUDGET] = steps
            advance(begin, end)
        raise KeyboardInterrupt

    bound._bound = interrupted
    with pytest.raises(KeyboardInterrupt):
        bound()
    bound._bound, bound._run._control[runs._BUDGET] = advance, count
    done = 1 + (steps == 30)
    seen.clear()
    bound()
    assert min(seen) == pytest.approx(0.3 * done) and bound.time == pytest.approx(0.3 * (done + 1))
    for _ in range(done):
        whole()
    assert np.array_equal(bound.trajectory.motor.values, whole.trajectory.motor.values)


def test_a_start_off_the_constraints_is_refused():
    pin = dynamics.Pin(cga3d.point((0.0, 0.0, -0.3)))
    wrong = dynamics.Simulation(body(), [DOWN], [pin], stabilization="projection")
    with pytest.raises(ConstraintError):
        wrong.bound(0.1)


def test_what_is_no_single_motion_of_poses_is_refused():
    with pytest.raises(InputError, match="one simulation"):
        dynamics.Simulation(body(3), [DOWN]).bound(0.1)
    with pytest.raises(InputError, match="times"):
        drop().bound(0.1, times=[0.2])
    hinge = kinematics.Revolute("base", "rod", cga3d.line((0, 0, 0), (0, 1, 0)), cga3d.point((0, 0, 0)))
    rod = dynamics.System({"rod": dynamics.RigidBody(1.0, (0.1, 0.1, 0.1), (0, 0, -0.5))}, [hinge])
    with pytest.raises(InputError, match="stepper"):
        dynamics.Simulation(rod, [DOWN]).bound(0.1)
    bound = dynamics.Simulation(rod, [DOWN], coordinates="maximal").bound(0.1, times=[0.1])
    bound()
    assert bound.time == 0.1
