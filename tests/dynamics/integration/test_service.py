"""Simulations as a service: functions that misbehave, events, progress, interrupts, executors, settings that stay."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import Status, dynamics
from bladesmith.errors import ConstraintError, InputError, Interrupted, SimulationError

pytestmark = pytest.mark.service

CGA = bs.cga3d
GRAVITY = dynamics.Gravity((0, 0, -9.81))


def ball(**given):
    return dynamics.RigidBody(1.0, [0.1, 0.2, 0.25], **given)


def push(size=1.0):
    return dynamics.wrench((size, 0, 0), (0, 0, 0))


def test_functions_that_give_too_much_or_nothing_are_told():
    two = dynamics.wrench([(1.0, 0, 0), (0, 1.0, 0)], (0, 0, 0))
    for bad, said in (
        (lambda t: two, "returned 12 numbers where 6 are needed"),
        (lambda t: push(np.nan if t > 0.1 else 1.0), "time 0.[12].*finite"),
        (lambda t: 1 / 0, "ZeroDivisionError"),
        (lambda t: None, "is None; a multivector"),
    ):
        with pytest.raises((SimulationError, InputError), match=said):
            dynamics.Simulation(ball(), [dynamics.WorldWrench(bad)], integrator="rk4").run(0.3, strict=True)


def test_what_was_until_a_failure_is_kept_and_the_next_run_is_clean():
    fail = [True]

    def load(t):
        if fail[0] and t > 0.1:
            raise ValueError("no more")
        return push()

    simulation = dynamics.Simulation(ball(), [dynamics.BodyWrench(load)], integrator="rk4")
    with pytest.raises(SimulationError, match="no more") as caught:
        simulation.run(0.2, strict=True)
    assert 90 < len(caught.value.trajectory) < 105
    with pytest.warns(RuntimeWarning, match="ended early: .*no more.*strict=True raises"):
        found = simulation.run(0.2)
    assert found.ending == "function failed" and found.status == Status.INVALID and not found.converged
    fail[0] = False
    assert simulation.run(0.2).ending == "ok"


def test_defaults_of_a_function_are_its_own():
    found = dynamics.Simulation(ball(), [dynamics.WorldWrench(lambda t, a=2.0, b=0: push(a))]).run(1.0, times=[1.0])
    assert found.velocity[-1] == pytest.approx([2.0, 0, 0], abs=1e-12)


def test_events_stop_with_the_state_and_the_reaction_of_their_time():
    top = ball(position=(0, 0, 1), velocity=(0, -0.1, 0), angular_velocity=(0.1, 0, 20.0))
    simulation = dynamics.Simulation(top, [GRAVITY], [dynamics.Pin(CGA.point((0, 0, -1.0)))])
    event = dynamics.Event(lambda t, motor, twist: t - 0.33, name="now")
    found, plain = simulation.run(1.0, step=0.1, events=[event]), simulation.run(0.33, times=[0.33])
    assert found.message == "now" and found.ending == "event" and found.time[-1] == pytest.approx(0.33, abs=1e-13)
    assert np.allclose(found.reaction[-1].values, plain.reaction[-1].values, rtol=1e-9)
    falls = dynamics.Event(lambda t, motor, twist: 1.0, name="never")
    assert simulation.run(0.2, events=[falls]).ending == "ok"


def test_progress_and_interrupts():
    seen = []
    dynamics.Simulation(ball(), [GRAVITY], integrator="strang").run(40.0, times=[40.0], progress=seen.append)
    times = [p.done for p in seen]
    assert len(times) > 1 and times == sorted(times) and times[-1] == 40.0 == seen[0].total and seen[0].unit == "s"

    def stop(progress):
        raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        dynamics.Simulation(ball(), [GRAVITY], integrator="strang").run(40.0, step=0.001, progress=stop)
    found = caught.value.partial
    assert found.message == "interrupted" and found.ending == "stopped" and 0 < len(found) < 40001
    with pytest.raises(InputError, match="progress is 'yes'"):
        dynamics.Simulation(ball()).run(1.0, progress="yes")


@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_workers_give_the_same_bits(pool):
    bodies = dynamics.RigidBody(np.arange(1.0, 8), [1.0, 2, 2.5], angular_velocity=(0.1, 2, 0.1))
    simulation = dynamics.Simulation(bodies, [GRAVITY], integrator="rk4")
    here = simulation.run(0.2, times=[0.1, 0.2])
    with pool(2) as executor:
        there = simulation.run(0.2, times=[0.1, 0.2], executor=executor)
    assert (here.motor.values == there.motor.values).all() and (here.energy == there.energy).all()
    with pytest.raises(InputError, match="takes no work"):
        simulation.run(0.2, executor=executor)


def test_settings_stay_and_batches_have_a_status_each():
    simulation = dynamics.Simulation(ball(), [GRAVITY])
    with pytest.raises(InputError, match="does not change"):
        simulation.loads = ()
    spins = np.zeros((2, 3))
    spins[1] = np.inf
    with pytest.raises(InputError, match=r"angular_velocity\[1, 0\]"):
        ball(angular_velocity=spins)
    found = dynamics.Simulation(ball(velocity=[(1.0, 0, 0)])).run(1.0, times=[1.0])
    assert found.position.shape == (1, 2, 3) and list(found.ending) == ["ok"]


def test_starts_are_checked():
    pin = dynamics.Pin(CGA.point((0, 0, 1.0)), CGA.point((0, 0, 1.5)))
    with pytest.raises(ConstraintError, match=r"constraint 0 \(Pin\) is violated at the start, by .*project=True"):
        dynamics.Simulation(ball(), [GRAVITY], [pin]).run(1.0)
    assert dynamics.Simulation(ball(), [GRAVITY], [pin]).run(0.1, project=True).violation.max() < 1e-12
    other = dynamics.Pin(CGA.point((0, 0, 2.0)), CGA.point((0, 0, 3.5)))
    with pytest.raises(ConstraintError, match="contradict each other"):
        dynamics.Simulation(ball(), [GRAVITY], [pin, other]).run(0.1, project=True)
    with pytest.raises(ConstraintError, match="velocities at the start"):
        dynamics.Simulation(ball(velocity=(1, 0, 0)), [GRAVITY], [dynamics.Pin(CGA.point((0, 0, 1.0)))]).run(0.1)
    with pytest.raises(InputError, match="is zero"):
        dynamics.Pin(0 * CGA.point((0, 0, 1.0)))
    with pytest.raises(InputError, match="no wrenches"):
        dynamics.VirtualPower([])


@pytest.mark.parametrize(
    ("mass", "inertia", "said"),
    [
        (0.0, [1, 1, 1], "positive"),
        (-1.0, [1, 1, 1], "positive"),
        (1.0, [1, 1, 3], "exceeds"),
        (1.0, [1, 1, 0], "positive"),
        (1.0, [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]], "symmetric"),
        (np.nan, [1, 1, 1], "finite"),
    ],
)
def test_impossible_bodies(mass, inertia, said):
    with pytest.raises(InputError, match=said):
        dynamics.RigidBody(mass, inertia)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"duration": -1.0}, "duration"), ({"duration": 1.0, "step": 0}, "step"),
        ({"duration": 1.0, "times": [0.5, 0.2]}, "rise"), ({"duration": 1.0, "times": [2.0]}, "rise"),
        ({"duration": 1.0, "rtol": -1}, "rtol"), ({"duration": np.nan}, "finite"),
    ],
)  # fmt: skip
def test_impossible_runs(options, said):
    with pytest.raises(InputError, match=said):
        dynamics.Simulation(ball()).run(**options)


def test_names_are_checked():
    with pytest.raises(InputError, match="integrator is 'rk5'.*rk4"):
        dynamics.Simulation(ball(), integrator="rk5")
    with pytest.raises(InputError, match="map is 'expo'"):
        dynamics.Simulation(ball(), map="expo")
    with pytest.raises(InputError, match="stabilization is 'magic'"):
        dynamics.Simulation(ball(), stabilisation="magic")
    damped = dynamics.Simulation(ball(), [dynamics.Damper(1.0, 1.0)], integrator="strang")
    with pytest.raises(InputError, match="composes exact flows"):
        damped.run(1.0)
