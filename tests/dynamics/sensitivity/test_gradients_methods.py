"""Gradients of every integrator against central differences at 50 digits: of its own steps, run as Python on mpmath."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.codegen.algorithms.dynamics.records import (
    Control,
    Progress,
    Reached,
    kept_record,
    state_record,
    work_records,
)  # fmt: skip
from bladesmith.codegen.programs.dynamics.dynamics import simulation_algorithms_of, simulation_parts
from bladesmith.dynamics.integration.integrators import INTEGRATORS

from ...oracles.gradients import DIGITS, STEP, TURN, everything, numbers
from ...support.effort import FULL

pytestmark = [pytest.mark.slow, pytest.mark.compiles]
#: Large steps: what is compared are the derivatives of the steps, whatever their errors.
TIMES, LENGTH = np.array([0.0, 0.05]), 0.03
START: dict[str, Any] = {
    "mass": 2.0, "inertia": np.array([1.0, 2.0, 2.5]), "position": np.array([1.0, 2.0, 3.0]),
    "velocity": np.array([0.3, -0.2, 0.5]), "angular_velocity": np.array([0.4, 1.3, -0.6]),
    "gravity": np.array([0.3, 0.2, -9.81]), "spring.stiffness": 20.0, "spring.length": 0.5,
    "spring.point": np.array([0.2, 0.1, -0.4]), "spring.anchor": np.array([0.0, 1.0, 4.0]),
    "body_wrench": np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), "world_wrench": np.array([0.3, 0.1, 0.2, 0.6, 0.4, 0.5]),
}  # fmt: skip
DAMPED = {"damper.angular": 0.1, "damper.linear": 0.2, "spring.damping": 0.3}
ARM = np.array([0.1, -0.2, 0.9])


def loaded(integrator: str) -> Any:
    splits = INTEGRATORS[integrator] == "composition"
    body = everything(bs.pga3d, {**START, **({} if splits else DAMPED)}, integrator=integrator)
    if not splits:
        return body
    loads = [load for load in body.loads if not isinstance(load, dynamics.Damper)]
    return dynamics.Simulation(body.bodies[0], loads, integrator=integrator)


def in_flight(integrator: str) -> Any:
    body = dynamics.RigidBody(
        2.0, (1, 2, 2.5), (1, 2, 3), TURN, velocity=(0.3, -0.2, 0.5), angular_velocity=(0.4, 1.3, -0.6)
    )
    return dynamics.Simulation(body, [dynamics.Gravity((0.3, 0.2, -9.81))], integrator=integrator)


def symmetric_top(integrator: str, stabilization: str = "auto") -> Any:
    """Two moments are equal, and so is nothing but noise left to turn about one axis of a split flow."""
    spin = np.array([0.5, -0.3, 12.0])
    arm = np.array([0.0, 0.0, 0.9])
    body = dynamics.RigidBody(
        1.5, (0.4, 0.4, 0.3), TURN @ arm, TURN, velocity=TURN @ np.cross(spin, arm), angular_velocity=spin
    )
    pin = dynamics.Pin(bs.cga3d.point(-arm), bs.cga3d.point((0, 0, 0)))
    return dynamics.Simulation(
        body, [dynamics.Gravity((0, 0, -9.81))], [pin], integrator=integrator, stabilization=stabilization
    )


def held_top(integrator: str) -> Any:
    return symmetric_top(integrator, "projection")


def double_pendulum(integrator: str) -> Any:
    bodies = {
        "upper": dynamics.RigidBody(1.0, (0.15, 0.2, 0.3), (0, 0.5, 0), algebra=bs.pga3d),
        "lower": dynamics.RigidBody(2.0, (0.3, 0.2, 0.25), (0, 1.4, 0.2), algebra=bs.pga3d),
    }
    joints = [
        kinematics.Spherical("base", "upper", bs.pga3d.point((0, 0, 0))),
        kinematics.Spherical("upper", "lower", bs.pga3d.point((0, 1, 0))),
    ]
    spring = dynamics.Spring((0.1, 0, 0.2), (0, 0.1, 0.1), 5.0, 0.3, 0.4, body="upper", other="lower")
    system = dynamics.System(bodies, joints)
    return dynamics.Simulation(system, [dynamics.Gravity((0, 0, -9.81)), spring], integrator=integrator)


CASES = {
    loaded: ("mass", "inertia", "position", "orientation", "velocity", "angular_velocity", "gravity", "body_wrench",
             "world_wrench", "spring.stiffness", "spring.length", "spring.point", "spring.anchor"),
    in_flight: ("mass", "inertia", "position", "orientation", "velocity", "angular_velocity", "gravity"),
    symmetric_top: ("mass", "inertia", "orientation", "angular_velocity", "gravity"),
    held_top: ("mass", "inertia", "angular_velocity", "gravity"),
    double_pendulum: ("upper.mass", "lower.inertia", "spring[0].stiffness", "lower.angular_velocity"),
}  # fmt: skip
#: Those in a chart step the equations of tangents by their own scheme instead: see the motion's own test below.
FIXED = [name for name, method in INTEGRATORS.items() if method not in ("chart", "adaptive", "implicit", "taylor")]
#: Of simulations but the first, the methods that run them: the terms of each are those of its other methods.
SOME = {
    in_flight: ("rk4", "yoshida6"), symmetric_top: ("cf4", "strang"), held_top: ("midpoint",),
    double_pendulum: ("rk4",),
}  # fmt: skip
COMBINATIONS = [
    (name, make) for make in CASES for name in FIXED
    if (FULL or name in SOME.get(make, FIXED))
    and (INTEGRATORS[name] != "composition" or make not in (held_top, double_pendulum))
]  # fmt: skip


def last_state(driver: Any, numbers: Any, motors: Any, twists: Any) -> np.ndarray:
    """Motors and twists at the last time, by the text of a run on 50 digits."""
    needs = driver.assembly.needs(driver.method.driver, "exponential")
    parts = simulation_parts(needs)
    work, kept_row, state_row = work_records(parts), kept_record(parts), state_record(driver.bodies)
    w, p, kept = np.zeros(work.numbers.size), np.zeros(work.integers.size, np.int64), np.zeros(kept_row.size, object)
    for fields, record, row in zip(driver._constants, (work.numbers, work.integers), (w, p), strict=True):
        for name, value in fields.items():
            first = record.offsets[name]
            row[first : first + np.size(value)] = 0 if name == "handle" else value
    for name, values in (("motors", motors), ("twists", twists)):
        kept[kept_row.offsets[name] :][: len(values)] = values
    control, progress = np.zeros(Control.size, np.int64), np.zeros(Progress.size, np.int64)
    control[Control.offsets["last"]], control[Control.offsets["budget"]] = len(TIMES), 1000
    shared = driver.arrays()[0]
    found = simulation_algorithms_of(needs)[0].run.reference(
        numbers, numbers, shared["springs"], shared["user_loads"], shared["constraints"], np.zeros(1),
        driver.method.numbers, w, p, control, TIMES, kept, np.zeros((max(1, driver.stage_rows), parts.state)),
        progress, np.zeros(Reached.size), np.zeros((len(TIMES), state_row.size)), np.zeros((1, 1)),
        numbers=mpmath.mp,
    )  # fmt: skip
    done = Progress.view(found[4])
    assert done.status == 0 and done.stored == len(TIMES)
    return np.asarray(found[6])[-1, : 14 * driver.bodies]


def motor_rates(algebra: Any, motors: np.ndarray, delta: np.ndarray) -> np.ndarray:
    """-R delta/2."""
    motor, twist = algebra.wrap(algebra.kind("motor"), motors), algebra.wrap(algebra.kind("twist"), delta)
    return np.asarray(-(motor * twist).as_kind("motor", check=False).values / 2)


@pytest.mark.parametrize(("name", "make"), COMBINATIONS, ids=[f"{n}-{m.__name__}" for n, m in COMBINATIONS])
def test_steps_of_every_integrator_at_50_digits(name: str, make: Any) -> None:
    run = make(name).run(TIMES[-1], step=LENGTH, times=TIMES, sensitivities=CASES[make])
    run = (run if hasattr(run, "_run") else next(iter(run.bodies.values())))._run
    driver, algebra = run.driver, run.driver.assembly.algebra
    along = np.random.default_rng(4).normal(size=driver.tangents)
    changes = along @ driver.directions.scaled[0][0]
    tangents = np.ascontiguousarray(np.tensordot(along, run.tangents[0], (0, 1)))
    rates = [motor_rates(algebra, run.motors[0, i].copy(), tangents[i, 0]) for i in (0, -1)]
    given = ((driver.assembly.parameters[0], changes), (run.motors[0, 0], rates[0]), (run.twists[0, 0], tangents[0, 1]))
    with mpmath.workdps(DIGITS):
        h, ends = mpmath.mpf(STEP), []
        for sign in (1, -1):
            moved = [[a + sign * h * b for a, b in zip(numbers(x), numbers(d), strict=True)] for x, d in given]
            ends.append(last_state(driver, *(np.array(x, object) for x in moved)))
        expected = np.array([float((a - b) / (2 * h)) for a, b in zip(*ends, strict=True)])
    count = 8 * driver.bodies
    for found, right in ((rates[1], expected[:count]), (tangents[-1, 1], expected[count:])):
        assert np.abs(found.ravel() - right).max() <= 1e-12 * np.abs(right).max()


def hinged(integrator: str) -> Any:
    """Rods on a hinge and a screw, whose axes move with both bodies, and a wrench that does no work between them."""
    algebra = bs.cga3d
    rod = [1 / 12, 1 / 13, 1e-1]
    bodies = {name: dynamics.RigidBody(1.0, rod, (x, 0, 0), TURN) for name, x in (("upper", 0.5), ("lower", 1.5))}
    hinges = [
        kinematics.Revolute("base", "upper", algebra.circle((0, 0, 0), (0, 1, 0), 1.0)),
        kinematics.Screw("upper", "lower", algebra.line((1, 0, 0), (0, 1, 0.2)), pitch=0.1),
    ]
    return dynamics.Simulation(
        dynamics.System(bodies, hinges), [dynamics.Gravity((0, 0, -9.81))], integrator=integrator
    )


@pytest.mark.parametrize(
    ("make", "names"),
    [(loaded, CASES[loaded]), (held_top, CASES[held_top]), (double_pendulum, CASES[double_pendulum]),
     (hinged, ("upper.mass", "lower.inertia", "lower.mass", "gravity"))],
)  # fmt: skip
def test_series_agree_with_steps(make: Any, names: tuple[str, ...]) -> None:
    """Tangents of series, reactions of constraints among them, and those of steps of order 8."""
    found = []
    for integrator in ("taylor", "adaptive"):
        run = make(integrator).run(0.4, times=[0.2, 0.4], sensitivities=names)
        found.append((run if hasattr(run, "_run") else next(iter(run.bodies.values())))._run.tangents[0])
    for q in range(len(found[0][0])):
        right = found[1][:, q]
        assert np.abs(found[0][:, q] - right).max() <= 1e-10 * max(np.abs(right).max(), 1e-3 * np.abs(found[1]).max())
