"""What users may get wrong in dynamics: every bad input is an error that says what, where and the remedy.

Simulations here are few, and share their compiled programs.
"""

from __future__ import annotations

import inspect
import os
import warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from bladesmith import cga2d, cga3d, dynamics, pga3d
from bladesmith.cli import main
from bladesmith.common import memory
from bladesmith.errors import (
    AlgebraMismatchError,
    BladesmithError,
    ConstraintError,
    ExecutorError,
    GradeError,
    InputError,
    ShapeError,
    SimulationError,
)

TIP = cga3d.point([0.0, 0, 0.5])
PLANE = cga3d.plane([0.0, 0, 1], 0.5)
WRENCH = dynamics.wrench([0.0, 0, 1], [0.1, 0, 0])
GRAVITY = dynamics.Gravity([0.0, 0, -9.81])
SHORT = 0.01


def ball(**options: Any) -> Any:
    return dynamics.RigidBody(1.0, [1.0, 2.0, 2.5], **options)


def simulation(*acting: Any, **options: Any) -> Any:
    return dynamics.Simulation(ball(), *acting, **options)


def refused(make: Any, says: str, kind: type[BladesmithError] = BladesmithError) -> BladesmithError:
    """The error, of one line, without a warning on the way."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(kind) as error:
            make()
    assert says in str(error.value) and "\n" not in str(error.value)
    return error.value


# -- what is accepted ------------------------------------------------------------------------------------------


@pytest.mark.compiles
def test_one_is_as_good_as_a_list_of_one() -> None:
    def half(time: float, motor: Any, twist: Any) -> float:
        return time - SHORT / 2

    event = dynamics.Event(half)
    pinned = simulation(GRAVITY, dynamics.Pin(TIP))
    assert pinned.loads == (GRAVITY,) and len(pinned.constraints) == 1
    assert simulation(None, None).loads == ()
    free = simulation(GRAVITY)
    ends = [free.run(SHORT, events=given).time[-1] for given in ([event], event, [half], half)]
    assert ends == [ends[0]] * 4 and abs(ends[0] - SHORT / 2) < 1e-12
    assert free.run(SHORT, events=None).ending == "ok"
    named = free.run(SHORT, sensitivities="mass")
    assert set(named.sensitivities) == {"mass"} and free.run(SHORT, sensitivities=None).ending == "ok"
    assert set(free.run(SHORT, sensitivities=["mass", "mass"]).sensitivities) == {"mass"}
    assert list(dynamics.System(ball()).bodies) == ["body_1"]
    assert simulation(dynamics.BodyWrench(0 * WRENCH)).run(SHORT).ending == "ok"  # a load that may be zero


def test_bodies_and_loads_keep_their_numbers() -> None:
    arrays = {"mass": np.ones(2), "inertia": np.tile([1.0, 2, 2.5], (2, 1)), "position": np.zeros((2, 3)),
              "velocity": np.ones((2, 3)), "angular_velocity": np.ones((2, 3))}  # fmt: skip
    body = dynamics.RigidBody(**arrays)
    point = np.array([1.0, 0, 0])
    spring, gravity = dynamics.Spring(point, point, 1.0), dynamics.Gravity(point)
    wrenches = [WRENCH]
    power = dynamics.VirtualPower(wrenches)
    for array in (*arrays.values(), point):
        array[:] = 7.0
    wrenches.clear()
    assert (body.mass == 1).all() and (body.moments == [1, 2, 2.5]).all() and (body.position == 0).all()
    assert (body.velocity == 1).all() and (body.angular_velocity == 1).all()
    assert spring.point[0] == spring.anchor[0] == gravity.acceleration[0] == 1 and len(power.wrenches) == 1
    for kept in (body.mass, body.moments, body.axes, body.position, body.velocity, spring.stiffness, spring.point):
        with pytest.raises(ValueError, match="read-only"):
            kept[...] = 2.0


# -- bodies ----------------------------------------------------------------------------------------------------

BODIES: list[tuple[dict[str, Any], str]] = [
    ({"mass": "heavy"}, "the mass is 'heavy'; real numbers are needed"),
    ({"mass": [1.0, -2.0]}, "the mass[1] is -2.0; a positive number is needed"),
    ({"inertia": [1.0, 2.0]}, "the inertia has shape (2,)"),
    ({"position": [0.0, np.nan, 0.0]}, "position[1] is nan; a finite number is needed"),
    ({"velocity": [1.0, 2.0]}, "velocity has shape (2,); (..., 3) is needed"),
    ({"velocity": np.zeros((2, 2, 3))}, "bodies have shape (2, 2); one, or a batch (n,), is meant"),
    ({"velocity": np.zeros((3, 3)), "position": np.zeros((2, 3))}, "pose (2,), velocity (3,)"),
    ({"angular_velocity": None}, "angular_velocity is None; real numbers are needed"),
    ({"orientation": 2 * np.eye(3)}, "the orientation is not a rotation: its transpose times itself differs from 1"),
    ({"orientation": np.stack([np.eye(3), -np.eye(3)])}, "the orientation[1] is not a rotation: its determinant"),
    ({"orientation": np.zeros((3, 3))}, "differs from 1 by 1. Give a rotation matrix, or a motor"),
    (
        {"orientation": np.tile(np.eye(3), (2, 1, 1)), "position": np.zeros((3, 3))},
        "orientations (2,), positions",
    ),
    ({"orientation": TIP}, "the orientation is not a motor"),
    ({"orientation": 2 * cga3d.rotor([0, 0, 1], 0.3)}, "the orientation is not a motor"),
    ({"orientation": pga3d.rotor([0, 0, 1], 0.3)}, "the orientation belongs to pga3d, the body to cga3d"),
    ({"algebra": "pga"}, "algebra is 'pga'; bladesmith.cga3d or pga3d is needed"),
    ({"algebra": cga2d}, "cga2d has no screws of space"),
]


@pytest.mark.parametrize(("options", "says"), BODIES, ids=[says[:40] for _, says in BODIES])
def test_bodies(options: dict[str, Any], says: str) -> None:
    refused(lambda: dynamics.RigidBody(**{"mass": 1.0, "inertia": [1.0, 2.0, 2.5], **options}), says)


SYSTEMS = [
    (lambda: dynamics.System(3), "the bodies are 3; a list of them is needed"),
    (lambda: dynamics.System({3: ball()}), "a body's name is 3; a word is needed"),
    (lambda: dynamics.System([None]), "body_1 is None; a dynamics.RigidBody is needed"),
    (lambda: dynamics.System([ball()], 3), "the joints are 3"),
    (lambda: dynamics.System([ball()], [None]), "a joint is None"),
    (lambda: dynamics.System([ball()], fixed=[]), "fixed is []; a word is needed"),
    (lambda: dynamics.Simulation(ball), "the body is a function; a RigidBody or a System is needed"),
]


@pytest.mark.parametrize(("make", "says"), SYSTEMS, ids=[says[:40] for _, says in SYSTEMS])
def test_systems(make: Any, says: str) -> None:
    refused(make, says, InputError)


# -- loads -----------------------------------------------------------------------------------------------------

LOADS = [
    (lambda: dynamics.BodyWrench(WRENCH, body=None), "the body of the body wrench is None; the name or the number"),
    (lambda: dynamics.Damper(1.0, 1.0, body=None), "the damper's body is None"),
    (lambda: dynamics.Damper(1.0, 1.0, body=True), "the damper's body is True"),
    (lambda: dynamics.Spring(0, 0, 1.0, body=None), "the spring's body is None"),
    (lambda: dynamics.Spring(0, 0, 1.0, other=0.5), "the spring's other body is 0.5; the name or the number of a body"),
    (lambda: dynamics.Spring(0, 0, 1.0, other=0), "loads[0] (Spring) is between two points of one body: it moves"),
    (lambda: dynamics.Spring(0, 0, 1.0, other="body"), "Name another body with other=, or leave it out for the world"),
    (lambda: dynamics.Spring(0, [0, 0], 1.0), "the spring's anchor has shape (2,)"),
    (lambda: dynamics.Damper(-1.0), "the angular damping is -1.0; a number of at least 0 is needed"),
    (lambda: dynamics.Damper(1.0, body=7), "loads[0] (Damper): there is no body 7; there are 1, from 0"),
    (lambda: dynamics.Damper(1.0, body="boddy"), "there is no body 'boddy'; there are: body. (did you mean 'body'?)"),
    (lambda: 3, "loads[0] is 3; a Gravity, BodyWrench, WorldWrench, Spring or Damper is needed"),
    (lambda: dynamics.Gravity, "loads[0] is the class Gravity; a Gravity"),
    (lambda: dynamics.Pin(TIP), "loads[0] is a Pin; a Gravity"),
    (
        lambda: dynamics.BodyWrench(np.zeros(6)),
        "the body wrench is array([0., 0...., 0., 0., 0.]); a multivector or a function of time",
    ),
    (lambda: dynamics.WorldWrench(np.nan * WRENCH), "the world wrench is not finite: its coefficient of e12 is nan"),
    (lambda: dynamics.WorldWrench(lambda t, motor: WRENCH), "the world wrench takes (t, motor); a function of time"),
]


@pytest.mark.parametrize(("make", "says"), LOADS, ids=[says[:40] for _, says in LOADS])
def test_loads(make: Any, says: str) -> None:
    refused(lambda: simulation([make()]), says)


@pytest.mark.parametrize("word", ["gravity", 3, {"a": GRAVITY}, dynamics.Gravity])
def test_what_is_no_list(word: Any) -> None:
    refused(lambda: simulation(word), "the loads are ", InputError)
    refused(lambda: simulation([], word), "the constraints are ", InputError)


# -- constraints -----------------------------------------------------------------------------------------------

CONSTRAINTS = [
    (lambda: dynamics.Pin(np.zeros(5)), "the body's object is array([0., 0., 0., 0., 0.]); a multivector is needed"),
    (lambda: dynamics.Pin(cga3d.scalar(2.0)), "the body's object is a scalar that no motion moves: it pins nothing"),
    (lambda: dynamics.Pin(cga3d.ni), "that no motion moves"),
    (lambda: dynamics.Pin(pga3d.scalar(2.0)), "that no motion moves"),
    (lambda: dynamics.Pin(TIP, PLANE), "the body's object is a point, the world's a plane: no motion makes them one"),
    (lambda: dynamics.Pin(TIP, pga3d.point([0.0, 0, 0.5])), "belongs to cga3d, the world's to pga3d"),
    (lambda: dynamics.Pin(TIP, body=None), "the body of Pin is None"),
    (lambda: dynamics.PinPath(TIP, lambda t, motor, twist: TIP), "the world's object takes (t, motor, twist)"),
    (lambda: dynamics.PinPath(lambda: TIP, TIP), "the body's object takes ()"),
    (lambda: dynamics.PinPath(TIP, cga3d.scalar(1.0)), "that no motion moves"),
    (lambda: dynamics.PinLinear(PLANE, PLANE), "the linear function is a Multivector; a function is needed"),
    (lambda: dynamics.PinLinear(lambda: PLANE, PLANE), "the linear function takes (); a function of one multivector"),
    (lambda: dynamics.PinLinear(abs, PLANE, np.zeros(3)), "the target has shape (3,); a multivector or one"),
    (lambda: dynamics.PinLinear(abs, PLANE, None), "the target is None"),
    (lambda: dynamics.PinLinear(abs, PLANE, np.nan), "the target is nan; a finite number is needed"),
    (lambda: dynamics.PinLinear(abs, PLANE, lambda t, u: 0), "the target takes (t, u); a value or a function of time"),
    (lambda: dynamics.Incidence(PLANE, PLANE), "the body's point is a plane; a point is needed"),
    (lambda: dynamics.Incidence(TIP, cga3d.scalar(1.0)), "that no motion moves"),
    (lambda: dynamics.VirtualPower(None), "the wrench is None; a multivector is needed"),
    (lambda: dynamics.VirtualPower([WRENCH, None]), "wrench 1 is None"),
    (lambda: dynamics.VirtualPower(()), "VirtualPower has no wrenches"),
    (lambda: dynamics.VirtualPower(WRENCH.reshape(1, 1)), "the wrenches have shape (1, 1)"),
    (lambda: dynamics.VirtualPower(lambda t, motor: WRENCH), "the function of the wrenches takes (t, motor)"),
    (lambda: dynamics.Pin(TIP, other=0), "constraints[0] (Pin) is between a body and itself"),
    (lambda: dynamics.Pin(TIP, other="arm"), "constraints[0] (Pin): there is no body 'arm'; there are: body"),
    (lambda: GRAVITY, "constraints[0] is a Gravity; a Pin, PinPath"),
]


@pytest.mark.parametrize(("make", "says"), CONSTRAINTS, ids=[says[:40] for _, says in CONSTRAINTS])
def test_constraints(make: Any, says: str) -> None:
    refused(lambda: simulation([], [make()]), says)


def failing(*given: Any) -> Any:
    raise ZeroDivisionError("oh")


#: What is known when functions of users are asked for the first time.
ASKED = [
    (dynamics.PinPath(TIP, failing), "the world's object failed at time 0: ZeroDivisionError: oh"),
    (dynamics.PinPath(TIP, lambda t: None), "the world's object is None where its function should give a multivector"),
    (dynamics.PinPath(TIP, lambda t: (TIP, TIP)), "gives a tuple of 2; a value alone, or a tuple of 3"),
    (dynamics.PinPath(TIP, lambda t: ()), "gives a tuple of 0"),
    (dynamics.PinPath(TIP, lambda t: np.nan * TIP), "the world's object is not finite: its coefficient of e1 is nan"),
    (dynamics.PinPath(TIP, dict), "the world's object failed at time 0: TypeError"),
    (dynamics.PinLinear(lambda x: 0 * x, PLANE), "the function of PinLinear is zero for every plane: it holds nothing"),
    (dynamics.PinLinear(lambda x: PLANE ^ x, PLANE), "is zero for every plane"),
    (dynamics.PinLinear(lambda x: x * x * x, PLANE), "the function of PinLinear is not linear"),
    (dynamics.PinLinear(lambda x: x + PLANE, PLANE), "is not linear"),
    (dynamics.PinLinear(lambda x: 0.0, PLANE), "is 0.0; a multivector is needed"),
    (dynamics.PinLinear(lambda x: np.nan * x, PLANE), "the function of PinLinear is not finite"),
    (dynamics.PinLinear(lambda x: cga3d.point(np.eye(3)) ^ x, PLANE), "has shape (3,); one item is needed"),
    (dynamics.PinLinear(lambda x: pga3d.scalar(1.0), PLANE), "belongs to pga3d"),
    (dynamics.PinLinear(failing, PLANE), "the function of PinLinear failed: ZeroDivisionError: oh"),
    (dynamics.PinLinear(lambda x: TIP ^ x, PLANE, failing), "the target failed at time 0: ZeroDivisionError: oh"),
    (dynamics.PinLinear(lambda x: TIP ^ x, PLANE, lambda t: np.ones(3)), "the target has shape (3,)"),
    (dynamics.PinLinear(lambda x: TIP ^ x, PLANE, lambda t: (0, 0)), "gives a tuple of 2"),
    (
        dynamics.Incidence(TIP, lambda t: np.zeros(5)),
        "the world's object is array([0., 0., 0., 0., 0.]) where its function should give",
    ),
    (dynamics.VirtualPower(failing), "the wrenches failed at time 0: ZeroDivisionError: oh"),
    (
        dynamics.VirtualPower(lambda t: [WRENCH]),
        "the wrenches are [twist of cga3...e12 - 0.1 e2ni] where their function should give",
    ),
    (dynamics.VirtualPower(lambda t: (WRENCH,)), "gives a tuple of 1; a value alone, or a tuple of 2"),
]


@pytest.mark.parametrize(("constraint", "says"), ASKED, ids=[says[:40] for _, says in ASKED])
def test_functions_of_constraints(constraint: Any, says: str) -> None:
    error = refused(lambda: simulation([], constraint).run(SHORT, project=True), says)
    assert error.where == f"constraint 0 ({type(constraint).__name__})"
    refused(lambda: dynamics.allowed_twists(constraint, ball()), says)


@pytest.mark.compiles
def test_functions_of_loads_and_paths_that_fail_later() -> None:
    def wrench(time: float) -> Any:
        return None if time > SHORT / 2 else WRENCH

    free = simulation(dynamics.BodyWrench(wrench))
    error = refused(lambda: free.run(SHORT, strict=True), "the body wrench failed at time 0.00", SimulationError)
    assert "the body wrench is None; a multivector of cga3d is needed" in error.what and "Error:" not in error.what
    assert len(error.trajectory) >= 1  # type: ignore[attr-defined]


@pytest.mark.compiles
def test_allowed_twists() -> None:
    depends = dynamics.VirtualPower(lambda t, motor, twist: (WRENCH, 0 * WRENCH))
    says = "VirtualPower depends on the state, and no body is given. Give one, as in body=RigidBody"
    refused(lambda: dynamics.allowed_twists(depends), says, InputError)
    for known in ((depends, ball()), ([depends, dynamics.VirtualPower(WRENCH)],)):
        assert dynamics.allowed_twists(*known).shape == (5,)
    refused(lambda: dynamics.allowed_twists(None), "the constraint is None")
    refused(lambda: dynamics.allowed_twists([None]), "constraints[0] is None; a Pin")
    refused(lambda: dynamics.allowed_twists(dynamics.Pin), "the constraints are the class Pin")
    refused(lambda: dynamics.allowed_twists(dynamics.Pin(TIP), 3), "the body is 3; a RigidBody is needed")
    two = dynamics.RigidBody([1.0, 2.0], [1.0, 1.0, 1.0])
    refused(lambda: dynamics.allowed_twists(dynamics.Pin(TIP), two), "there are 2 bodies; the twists of one")


# -- simulations and runs --------------------------------------------------------------------------------------

OPTIONS: list[tuple[dict[str, Any], str]] = [
    ({"integrator": "rk5"}, "integrator is 'rk5' (did you mean 'rk4'?); one of auto, rk4"),
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
    ({"rtol": 2.0}, "rtol is 2; it is a relative error, below 1"),
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
    ({"sensitivities": "mass", "project": True}, "sensitivities cannot be combined with project: "),
    ({"sensitivities": "mass", "events": lambda t, motor, twist: t}, "Leave out events="),
    ({"sensitivities": "mass", "project": True, "executor": ThreadPoolExecutor(1)}, "with project and executor"),
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


# -- files -----------------------------------------------------------------------------------------------------

BODY = "[body]\nmass = 2.0\nmoments = [1.0, 2.0, 2.5]\npoints = { tip = [0.0, 0.0, 0.5] }\n"
ON = '[[constraints]]\nkind = "incidence"\npoint = "tip"\non = { kind = "sphere", center = [0, 0, 0], radius = 1 }\n'
RUN = "[simulation]\nduration = 0.01\n"
FILES = [
    (BODY + RUN + "times = []", "line 7: simulation.times is []; it has 0 items where 1 are the least"),
    (BODY + RUN + "times = [nan]", "line 7: simulation.times[0] is nan; numbers are finite"),
    (BODY + RUN + "times = 3", "line 7: simulation.times is 3; an array is needed"),
    (BODY + RUN + "rtol = inf", "line 7: simulation.rtol is inf; numbers are finite"),
    (BODY + RUN + "rtol = 2", "rtol is 2; it is a relative error, below 1"),
    (BODY + RUN + "baumgarte = 3", 'the rate baumgarte goes with stabilization = "baumgarte"'),
    (BODY + RUN + "project = 1", "line 7: simulation.project is 1; true or false is needed"),
    (BODY + RUN + "step = 1e-30", "the step is 1e-30, which is rounded away"),
    (BODY + RUN + "hurry = true", "line 7: simulation.hurry is not a known key; known keys: duration"),
    ("body = 3\n" + RUN, "line 1: body is 3; a table is needed"),
    ("\0", "line 1, column 1: invalid statement"),
    (BODY + ON + RUN, "Give simulation.project = true, and the start is moved"),
    (BODY + ON + RUN + 'project = true\nintegrator = "strang"', 'Use simulation.integrator = "adaptive", or another'),
    (
        BODY + ON + RUN + 'project = true\nstabilization = "null-space"',
        'simulation.stabilization = "null-space" is for',
    ),
]


@pytest.mark.compiles
@pytest.mark.parametrize(("text", "says"), FILES, ids=[says[:40] for _, says in FILES])
def test_files(text: str, says: str, tmp_path: Any) -> None:
    path = tmp_path / "body.toml"
    path.write_text(text)
    error = refused(lambda: dynamics.load_simulation(path).run(), says, InputError)
    assert str(error).startswith(str(path))


@pytest.mark.compiles
def test_failures_of_files_speak_of_keys_and_keep_the_trajectory(tmp_path: Any) -> None:
    path = tmp_path / "body.toml"
    stiff = '[[loads]]\nkind = "spring"\npoint = [0, 0, 0]\nanchor = [1, 0, 0]\nstiffness = 1e300\n'
    path.write_text(BODY + stiff.replace("1e300", "1e60") + RUN)
    error = refused(lambda: dynamics.load_simulation(path).run(strict=True), "no longer finite", SimulationError)
    assert error.remedy is not None and 'simulation.integrator = "adaptive"' in error.remedy
    assert len(error.trajectory) >= 1  # type: ignore[attr-defined]


def test_places_that_are_no_files(tmp_path: Any, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    refused(lambda: dynamics.load_simulation(tmp_path), "cannot be read: Is a directory", InputError)
    refused(lambda: dynamics.load_simulation(np.eye(3)), "array([[1., 0...[0., 0., 1.]]) names none", InputError)
    refused(lambda: dynamics.load_trajectory(None), "a trajectory is read from a file, and None names none", InputError)
    path = tmp_path / "body.toml"
    path.write_text(BODY + RUN)
    monkeypatch.setattr("os.access", lambda place, mode: mode != os.W_OK)
    assert main.run(["simulate", str(path), "-o", str(tmp_path / "a.npz")]) == 2
    assert "a.npz: cannot be written: no permission." in capsys.readouterr().err


# -- at random -------------------------------------------------------------------------------------------------


class Contrary:
    """No array, and no number."""

    def __array__(self, *given: Any, **named: Any) -> Any:
        raise TypeError("no")


JUNK: list[Any] = [
    None, "", "x", b"x", True, np.nan, np.inf, -1, 0, 1, 1e308, 5e-324, 10**400, 1j, [], [[]], {}, (), object(),
    Contrary(), int, np.zeros(0), np.zeros((0, 3)), np.ones((2, 3)), np.ones((2, 2, 3)), np.array(1.0),
    np.array([None, 1, 2]), np.array(["a"]), np.ma.masked_array([1.0, 2, 3], [0, 1, 0]), [1, 2, 3], [[1], [2, 3]],
    np.eye(3), np.full(3, np.nan), np.full(3, 1e200), np.datetime64("2020"), {1, 2}, range(3), len, failing,
    lambda *given: None, lambda t: TIP, lambda t, motor, twist: (WRENCH, WRENCH), cga3d, TIP, PLANE, WRENCH, 0 * TIP,
    np.nan * TIP, 1e200 * TIP, cga3d.scalar(1.0), cga3d.point(np.eye(3)), pga3d.point([0.0, 0, 1]),
    cga3d.point(np.zeros((0, 3))), cga3d.translator([1.0, 0, 0]),
]  # fmt: skip
GOOD: dict[Any, dict[str, Any]] = {
    dynamics.RigidBody: {"mass": 1.0, "inertia": [1.0, 2.0, 2.5]},
    dynamics.Gravity: {"acceleration": [0.0, 0, -9.81]},
    dynamics.BodyWrench: {"wrench": WRENCH},
    dynamics.WorldWrench: {"wrench": WRENCH},
    dynamics.Spring: {"point": 0, "anchor": [0.0, 0, 1], "stiffness": 1.0},
    dynamics.Damper: {},
    dynamics.Pin: {"body_object": TIP},
    dynamics.PinPath: {"body_object": TIP, "world_object": TIP},
    dynamics.PinLinear: {"function": lambda x: TIP ^ x, "world_object": PLANE},
    dynamics.Incidence: {"body_point": TIP, "world_object": PLANE},
    dynamics.VirtualPower: {"wrenches": WRENCH},
    dynamics.Event: {"function": lambda t, motor, twist: t},
    dynamics.System: {"bodies": [ball()]},
    dynamics.Simulation: {"body": ball()},
    dynamics.Sketch: {},
    dynamics.Trace: {"point": 0},
    dynamics.box: {"size": [1.0, 2, 3]},
    dynamics.cone: {"radius": 1.0, "height": 1.0},
    dynamics.sphere: {"radius": 1.0},
    dynamics.Inertia: {"mass": 1.0, "moments": [1.0, 2.0, 2.5]},
}


@pytest.mark.parametrize("make", GOOD, ids=lambda make: make.__name__)
def test_any_argument_is_taken_or_refused(make: Any) -> None:
    """Each argument in turn is something else: the package's error in one line, or an object; no warning."""
    make(**GOOD[make])
    taken = 0
    for name in inspect.signature(make).parameters:
        for value in JUNK:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    make(**{**GOOD[make], name: value})
                    taken += 1
                except BladesmithError as error:
                    assert "\n" not in str(error), (name, error)
    assert taken < len(JUNK) * len(inspect.signature(make).parameters)


junk = st.sampled_from(JUNK)
SPRING = st.sampled_from(["point", "anchor", "stiffness", "length", "damping"])
OPTION = st.sampled_from(["times", "rtol", "atol", "threads", "strict", "progress"])


@pytest.mark.slow
@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.dictionaries(SPRING, junk, max_size=2), st.dictionaries(OPTION, junk, max_size=1))
def test_runs_of_any_springs_are_finite_or_say_why(spring: dict[str, Any], options: dict[str, Any]) -> None:
    """Whatever was taken: states are finite, or the simulation does not call itself "ok"."""
    assume(not callable(options.get("progress")))  # what it raises is the user's own
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            load = dynamics.Spring(**{**GOOD[dynamics.Spring], **spring})
            found = simulation(load).run(SHORT, **options)
        except BladesmithError as error:
            assert "\n" not in str(error)
            return
    ok = np.atleast_1d(found.ending) == "ok"
    position = found.position.reshape(len(ok), -1, 3)
    assert np.isfinite(position[ok]).all()


@pytest.mark.compiles
def test_starts_off_their_constraints_say_how_far() -> None:
    lower = cga3d.plane([0.0, 0, 1], 0.25)
    says = "constraint 0 (Incidence) is violated at the start, by "
    error = refused(lambda: simulation([], dynamics.Incidence(TIP, lower)).run(SHORT), says, ConstraintError)
    assert error.remedy is not None and "project=True" in error.remedy


def test_objects_of_another_algebra_are_told() -> None:
    refused(lambda: simulation([], dynamics.Pin(pga3d.point([0.0, 0, 1]))).run(SHORT), "pga3d", AlgebraMismatchError)
    refused(lambda: simulation(dynamics.BodyWrench(TIP)).run(SHORT), "the blades of a twist are", GradeError)
