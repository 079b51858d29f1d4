"""What users may get wrong in simulations and their runs: options, times, events, executors."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from bladesmith import dynamics
from bladesmith.common import memory
from bladesmith.errors import (
    ExecutorError,
    InputError,
    ShapeError,
    SimulationError,
)

from ...support.dynamics.input import GRAVITY, SHORT, failing, refused, simulation

OPTIONS: list[tuple[dict[str, Any], str]] = [
    ({"integrator": "rk3"}, "integrator is 'rk3' (did you mean 'rk4'?); one of auto, rk4"),
    ({"integrator": np.eye(3)}, "array([[1., 0...[0., 0., 1.]]); one of auto"),
    ({"map": "caley"}, "(did you mean 'cayley'?)"),
    ({"stabilisation": ""}, "stabilization is ''; one of auto"),
    ({"stabilization": None}, "stabilization is None; one of auto"),
    ({"stabilization": "projection", "stabilisation": "none"}, "they say the same thing: give one of them"),
    ({"baumgarte": [1.0]}, "has shape (1,); one number is needed"),
    ({"baumgarte": -1.0}, "the rate of Baumgarte's terms is -1.0; a positive number is needed"),
    ({"baumgarte": 3.0}, "the rate baumgarte goes with stabilization='baumgarte'"),
]


@pytest.mark.parametrize(("options", "says"), OPTIONS, ids=[says[:40] for _, says in OPTIONS])
def test_options(options: dict[str, Any], says: str) -> None:
    refused(lambda: simulation(**options), says)


RUNS: list[tuple[dict[str, Any], str]] = [
    ({"duration": [1.0]}, "the duration has shape (1,); one number is needed"),
    ({"duration": None}, "the duration is None"),
    ({"duration": -1.0}, "the duration is -1.0; a positive number is needed"),
    ({"step": [1e-3]}, "the step has shape (1,)"),
    ({"duration": 1.0, "step": 1e-13}, "stores 1e+13 states, which take 1.56e+06 GiB; this machine has "),
    ({"duration": 1.0, "step": 1e-13}, "Say which to store, with times=[..], or take a longer step"),
    ({"step": 1e-320}, "the step is 1e-320, which is rounded away beside the duration, 0.01"),
    ({"times": []}, "times are empty; one or more are needed. Leave times out to store every step"),
    ({"times": 0.5}, "times is 0.5; (n,) is needed"),
    ({"times": [0.005, 0.001]}, "times[1] is 0.001 after 0.005; times rise from 0 to the duration, 0.01"),
    ({"times": [0.001, 0.001]}, "times[1] is 0.001 after 0.001"),
    ({"times": [0.001, 2.0]}, "times[1] is 2 after 0.001"),
    ({"times": [-1.0]}, "times[0] is -1; times rise"),
    ({"times": [np.nan]}, "times[0] is nan"),
    ({"rtol": 0}, "rtol is 0; a positive number is needed"),
    ({"rtol": [1e-9]}, "rtol has shape (1,)"),
    ({"rtol": 0.5}, "rtol is 0.5; it is a relative error, at most 0.1"),
    ({"rtol": 2.0}, "rtol is 2; it is a relative error, at most 0.1"),
    ({"atol": -1e-9}, "atol is -1e-09; a number of at least 0 is needed"),
    ({"threads": 0}, "threads is 0; a whole number from 1 to 4096 is needed"),
    ({"project": None}, "project is None; True or False is needed"),
    ({"strict": "no"}, "strict is 'no'; True or False is needed"),
    (
        {"executor": ThreadPoolExecutor},
        "executor is the class ThreadPoolExecutor; an open concurrent.futures.Executor is needed",
    ),
    ({"executor": 3}, "executor is 3"),
    ({"events": [None]}, "events[0] is None; an Event, or a function of time, motor and twist, is needed"),
    ({"events": 3}, "the events are 3"),
    ({"events": lambda t: t}, "the event's function takes (t); a function of time, motor and twist is needed"),
    ({"sensitivities": 3}, "the sensitivities are 3"),
    ({"sensitivities": [None]}, "sensitivities[0] is None; a text is needed"),
    ({"sensitivities": ["mas"]}, "'mas' is not a parameter of this simulation. (did you mean 'mass'?). There are: m"),
    ({"sensitivities": ["mass[1]"]}, "mass has one component, 0: 'mass[1]' is not among them"),
]


@pytest.mark.parametrize(("options", "says"), RUNS, ids=[says[:40] for _, says in RUNS])
def test_runs(options: dict[str, Any], says: str) -> None:
    refused(lambda: simulation(GRAVITY).run(**{"duration": SHORT, **options}), says)


def test_room_for_states(monkeypatch: pytest.MonkeyPatch) -> None:
    many = dynamics.Simulation(dynamics.RigidBody(np.ones(1000), [1.0, 2.0, 2.5]), GRAVITY)
    monkeypatch.setattr(memory, "total", lambda: 8 << 20)
    says = "1000 simulations store 101 states each, which take 0.0158 GiB; this machine has 0.00781 GiB. Store fewer"
    refused(lambda: many.run(SHORT, step=SHORT / 100), says, InputError)
    assert many.run(SHORT, times=[SHORT]).time.shape == (2,)


def test_empty_batches() -> None:
    none = dynamics.RigidBody(np.zeros(0), [1.0, 2.0, 2.5])
    refused(lambda: dynamics.Simulation(none).run(SHORT), "the batch of bodies and loads is empty", ShapeError)


EVENTS = [
    (lambda t, motor, twist: None, "event at time 0 is None; a finite number is needed"),
    (lambda t, motor, twist: np.zeros(3), "event at time 0 has shape (3,); one number is needed"),
    (lambda t, motor, twist: motor, "event at time 0 is a Multivector; a finite number is needed"),
    (lambda t, motor, twist: np.nan if t > 0 else 1.0, "event at time 0.001 is nan; a finite number is needed"),
    (failing, "event failed at time 0: ZeroDivisionError: oh"),
]


@pytest.mark.parametrize(("function", "says"), EVENTS, ids=[says for _, says in EVENTS])
def test_events_that_fail_keep_the_trajectory(function: Any, says: str) -> None:
    error = refused(lambda: simulation(GRAVITY).run(SHORT, events=function), says, SimulationError)
    assert len(error.trajectory) == 11  # type: ignore[attr-defined]


def test_events_are_checked() -> None:
    def late(time: float, motor: Any, twist: Any) -> float:
        return time

    refused(
        lambda: dynamics.Event(late, direction=np.array([1, 2])),
        "the event's direction is array([1, 2]); -1, 0 or 1 is needed",
    )
    refused(lambda: dynamics.Event(late, name=3), "the event's name is 3")
    refused(lambda: dynamics.Event(3), "the event's function is 3")
    two = dynamics.Simulation(dynamics.RigidBody(np.ones(2), [1.0, 2.0, 2.5]), GRAVITY)
    refused(lambda: two.run(SHORT, events=late), "events are for one simulation of one body; here are 2 of 1")


class Unsendable(ThreadPoolExecutor):
    """A pool whose workers fail."""

    def submit(self, function: Any, /, *given: Any, **named: Any) -> Any:
        return super().submit(failing)


def test_executors_that_fail() -> None:
    with Unsendable(1) as pool:
        says = "simulations 0 to 0 were not computed: ZeroDivisionError: oh. See the workers' own output"
        refused(lambda: simulation(GRAVITY).run(SHORT, executor=pool), says, ExecutorError)
    pool = ProcessPoolExecutor(1)
    pool.shutdown()
    refused(lambda: simulation(GRAVITY).run(SHORT, executor=pool), "the executor takes no work", InputError)
