"""Implicit steps in the coordinates of joints: against Lagrange's equations by SciPy, exact decays, explicit steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.errors import SimulationError

from ...oracles.motions.double_pendulum import MASS, MOMENT, double_pendulum
from .test_trees import loads, mixed

CGA, PGA = bs.cga3d, bs.pga3d
PULL = (6.0, 0.0, -9.81)
pytestmark = pytest.mark.compiles


def rods(algebra: Any = CGA, axis: Any = (0, 1, 0), mass: Any = MASS) -> dynamics.System:
    """Two of them, hinged below each other."""
    bodies = {
        name: dynamics.RigidBody(m, (0.3, i, 0.3), (0, 0, -0.5 - k), algebra=algebra)
        for k, (name, m, i) in enumerate(zip("ab", mass, MOMENT, strict=True))
    }
    hinges = [(algebra.line((0, 0, -k), axis), algebra.point((0, 0, -k))) for k in range(2)]
    joints = [kinematics.Revolute("base", "a", *hinges[0]), kinematics.Revolute("a", "b", *hinges[1])]
    return dynamics.System(bodies, joints, joint_names=["shoulder", "elbow"])


def stiff(joint: int, stiffness: float, rest: float, damping: float) -> tuple[Any, Callable[[Any, Any], Any]]:
    """A spring of a joint, and the torques of both."""
    own = np.arange(2) == joint
    return dynamics.JointSpring(
        joint, stiffness, rest, damping
    ), lambda x, v: own * (-stiffness * (x - rest) - damping * v)


LAWS = {
    "a damper": stiff(1, 0.0, 0.0, 1e4),
    "a spring, damping ratio 1e4": stiff(1, 1e10, 0.02, 2e4 * np.sqrt(1e10)),
    "a spring at the shoulder": stiff(0, 1e10, -0.05, 2e4 * np.sqrt(1e10)),
    "dry friction": (
        dynamics.JointFriction(1, 30.0, 1e-4),
        lambda x, v: np.array([0.0, -30.0 * v[1] / np.hypot(v[1], 1e-4)]),
    ),
    "a limit": (
        dynamics.JointLimit(1, -0.05, 0.05, 1e8),
        lambda x, v: np.array([0.0, -1e8 * (max(x[1] - 0.05, 0.0) + min(x[1] + 0.05, 0.0))]),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "algebra"), [*((name, CGA) for name in LAWS), ("a limit", PGA)])
def test_a_double_pendulum(name: str, algebra: Any) -> None:
    """Errors follow the tolerance, in some dozens of steps; states between are as good."""
    load, torques = LAWS[name]
    times = [0.137, 0.5]
    exact = solve_ivp(
        double_pendulum(PULL, torques), (0, times[-1]), np.zeros(4), method="Radau", rtol=1e-12, atol=1e-14,
        t_eval=times, max_step=1e-2,
    ).y  # fmt: skip
    simulation = dynamics.Simulation(rods(algebra), [dynamics.Gravity(PULL), load], integrator="implicit")
    for rtol, bar in ((1e-5, 1e-4), (1e-7, 1e-6), (1e-12, 2e-10)):
        found = simulation.run(times[-1], times=times, rtol=rtol)
        assert not found.message and found.steps < 400 and found.integrator == "implicit"
        for k, (joint, before) in enumerate([(1, 0), (0, None)]):
            of = 1 - k
            angle, rate = (exact[of + 2 * d] - (0 if before is None else exact[before + 2 * d]) for d in (0, 1))
            assert np.abs(found.coordinates(joint)[1:] - angle).max() < bar
            assert np.abs(found.rates(joint)[1:] - rate).max() < 10 * bar


def landing(damping: float) -> Any:
    """A rod that falls from rest against a limit, piece by piece: angle and speed (2,) at the end; how often it did."""
    moment = MOMENT[0] + MASS[0] * 0.25

    def rates(_: float, y: Any, is_pressed: bool) -> Any:
        torque = MASS[0] * 0.5 * (-PULL[0] * np.cos(y[0]) + PULL[2] * np.sin(y[0]))
        stop = -STOP * (y[0] - LIMIT) - damping * y[1] if is_pressed else 0.0
        return [y[1], (torque + stop) / moment]

    def passes(_: float, y: Any, is_pressed: bool) -> Any:
        return y[0] - LIMIT

    passes.terminal = True  # type: ignore[attr-defined]
    t, y, is_pressed, count = 0.0, np.zeros(2), False, 0
    while t < DURATION:
        passes.direction = 1 if is_pressed else -1  # type: ignore[attr-defined]
        part = solve_ivp(rates, (t, DURATION), y, "Radau", events=passes, args=(is_pressed,), rtol=1e-12, atol=1e-15)
        t, y = part.t[-1], part.y[:, -1]
        is_pressed, count = not is_pressed, count + 1
    return y, count // 2


#: Stiffness of a limit, where it is, and how long the rod is watched.
STOP, LIMIT, DURATION = 1e8, -0.3, 0.4


@pytest.mark.slow
@pytest.mark.parametrize("damping", [0.0, 1e2, 1e4])
def test_an_arm_that_meets_a_limit(damping: float) -> None:
    """The damping begins with a jump of the torque, at a time that no step meets."""
    exact, count = landing(damping)
    body = dynamics.RigidBody(MASS[0], (0.3, MOMENT[0], 0.3), (0, 0, -0.5))
    hinge = kinematics.Revolute("base", "rod", CGA.line((0, 0, 0), (0, 1, 0)), CGA.point((0, 0, 0)))
    limit = dynamics.JointLimit(0, LIMIT, np.inf, STOP, damping)
    simulation = dynamics.Simulation(
        dynamics.System({"rod": body}, [hinge]), [dynamics.Gravity(PULL), limit], integrator="implicit"
    )
    assert count >= 1
    for rtol, bar in ((1e-7, 1e-5), (1e-12, 1e-9)):
        found = simulation.run(DURATION, times=[DURATION], rtol=rtol)
        assert not found.message and found.steps < 1000 * DURATION
        assert abs(found.coordinates(0)[-1] - exact[0]) < bar
        assert abs(found.rates(0)[-1] - exact[1]) < 10 * bar
    if damping == 1e4:  # ever smaller jumps, then rest
        found = simulation.run(1.0, times=[1.0], rtol=1e-9)
        torque = MASS[0] * 0.5 * (-PULL[0] * np.cos(LIMIT) + PULL[2] * np.sin(LIMIT))
        assert not found.message and found.steps < 1000
        assert abs(found.coordinates(0)[-1] - LIMIT - torque / STOP) < 1e-12 and abs(found.rates(0)[-1]) < 1e-9


def test_a_damped_ball() -> None:
    """A body on a ball sinks slowly, turned by its weight: Euler's equations by SciPy."""
    moments, center, mass, damping = np.array([0.4, 0.5, 0.3]), np.array([0.3, 0.2, 0.4]), 1.5, 2e3
    square = np.eye(3) * (center @ center) - np.outer(center, center)
    tensor = np.diag(moments) + mass * square

    def rates(_: float, y: Any) -> Any:
        turn, w = y[:9].reshape(3, 3), y[9:]
        spin = np.cross(np.eye(3), w)
        weight = np.cross(center, mass * turn.T @ np.array(PULL))
        slowing = np.linalg.solve(tensor, weight - np.cross(w, tensor @ w) - damping * w)
        return np.append((turn @ spin).ravel(), slowing)

    start = np.append(np.eye(3).ravel(), [0.5, -2.0, 3.0])
    exact = solve_ivp(rates, (0, 50.0), start, "Radau", rtol=1e-9, atol=1e-12).y[:, -1]
    spin = start[9:]
    body = dynamics.RigidBody(mass, moments, center, velocity=np.cross(spin, center), angular_velocity=spin)
    ball = kinematics.Spherical("base", "a", CGA.point((0, 0, 0)))
    loads = [dynamics.Gravity(PULL), dynamics.JointDamper(0, damping)]
    simulation = dynamics.Simulation(dynamics.System({"a": body}, [ball]), loads, integrator="implicit")
    for rtol, bar in ((1e-6, 1e-5), (1e-12, 1e-7)):
        found = simulation.run(50.0, times=[50.0], rtol=rtol)
        assert not found.message and found.steps < 100
        assert np.abs(found["a"].orientation[-1] - exact[:9].reshape(3, 3)).max() < bar
        assert np.abs(found.rates(0)[-1] - exact[9:]).max() < bar


@pytest.mark.parametrize("closes", [False, True])
def test_what_is_not_stiff_is_as_explicit_steps_have_it(closes: bool) -> None:
    """Every joint and load; a loop and a coupling."""
    system = mixed()
    if closes:
        joints = [*system.joints, kinematics.Spherical("c", "h", CGA.point((0.3, 1, -2)))]
        system = dynamics.System(system.bodies, joints, couplings=[{(1, 0): 1.0, (6, 0): -0.5}])
    runs = [
        dynamics.Simulation(system, loads(), integrator=name, coordinates="joint").run(0.5, times=[0.1, 0.43, 0.5])
        for name in ("adaptive", "implicit")
    ]
    assert not runs[1].message and runs[1].steps < 100 and runs[1].violation.max() < 1e-12
    for name, body in runs[0].bodies.items():
        assert np.abs(runs[1][name].position - body.position).max() < 1e-11
        assert np.abs(runs[1][name].angular_velocity - body.angular_velocity).max() < 1e-10


def test_a_closed_loop_with_a_stiff_joint() -> None:
    """A ring of hinged rods with an overdamped spring, and with one that explicit steps can follow."""
    corners = np.array([(0, 0, 0), (0, 0, -1), (1.2, 0, -1), (1.0, 0, 0)], float)
    bodies = {
        name: dynamics.RigidBody(1.0, (0.1, 0.1, 0.1), (corners[k] + corners[k + 1]) / 2)
        for k, name in enumerate("abc")
    }
    names = ["base", *bodies, "base"]
    joints = [
        kinematics.Revolute(names[k], names[k + 1], CGA.line(corners[k], (0, 1, 0)), CGA.point(corners[k]))
        for k in range(4)
    ]
    system = dynamics.System(bodies, joints)

    def run(damping: float, integrator: str) -> Any:
        spring = dynamics.JointSpring(0, damping, 0.1, damping)
        options = {"integrator": integrator, "coordinates": "joint"}
        return dynamics.Simulation(system, [dynamics.Gravity(PULL), spring], **options).run(0.5, times=[0.5])

    expected, found, stiffest = run(1e4, "adaptive"), run(1e4, "implicit"), run(1e7, "implicit")
    assert np.abs(expected["b"].position - found["b"].position).max() < 1e-11
    assert expected.steps > 400 and found.steps < 100 and stiffest.steps < 100
    assert found.violation.max() < 1e-12 and not stiffest.message
    # so stiff that its own relaxation is all: x = rest (1 - exp(-t))
    assert abs(stiffest.coordinates(0)[-1] - 0.1 * (1 - np.exp(-0.5))) < 1e-5


def test_batches_have_the_bits_of_their_items() -> None:
    mass = np.array([0.5, 1.0, 2.0])
    load = dynamics.JointDamper("elbow", 1e4)

    def run(masses: Any) -> Any:
        system = rods(mass=(masses, 2.0))
        simulation = dynamics.Simulation(system, [dynamics.Gravity(PULL), load], integrator="implicit")
        return simulation.run(0.3, times=[0.1, 0.3], threads=2)

    together = run(mass)
    for i, one in enumerate(mass):
        single = run(one)
        assert np.array_equal(together.coordinates(1)[i], single.coordinates(1)) and together.steps[i] == single.steps


def test_auto_is_implicit_where_joints_damp_fast() -> None:
    """By rates of decay and the length of the run; a limit counts before it is met."""
    fast = [
        dynamics.JointDamper("elbow", 1e6), dynamics.JointSpring(0, 1e6, 0.0, 1e6),
        dynamics.JointFriction(1, 30.0, 1e-5),
        dynamics.JointLimit(1, -1.0, 1.0, 1e8, 1e6), dynamics.Damper(0.0, 1e6, "b"),
    ]  # fmt: skip
    slow = [dynamics.JointDamper("elbow", 1e2), dynamics.JointSpring(0, 1e3), dynamics.JointLimit(1, -1.0, 1.0, 1e8)]
    for load in (*fast, *slow):
        found = dynamics.Simulation(rods(), [dynamics.Gravity(PULL), load], coordinates="auto").run(1.0, times=[1.0])
        assert found.integrator == ("implicit" if load in fast else "adaptive") and not found.message
    short = dynamics.Simulation(rods(), [fast[0]]).run(1e-4, times=[1e-4])
    assert short.integrator == "adaptive"


def test_explicit_steps_at_rest_are_as_long_as_the_damper_allows() -> None:
    """Torques of springs that hold weights cancel: what is rounded there is no error of a step."""
    loads = [dynamics.Gravity(PULL), *(dynamics.JointSpring(k, 1e4, 0.5, 200.0) for k in range(2))]
    for rtol in (1e-8, 1e-12):
        found = dynamics.Simulation(rods(), loads, integrator="adaptive", coordinates="joint").run(1.0, rtol=rtol)
        assert not found.message and found.steps < 2000  # 1.6 million where that rounding is not known


def test_steps_of_a_control_loop() -> None:
    """As a run; the same again, whatever was before; and an error that says why."""
    held = [dynamics.Gravity(PULL), dynamics.JointSpring(1, 1e8, 0.0, 1e6), dynamics.JointDamper(0, 1e3)]
    stepper = dynamics.Simulation(rods(), held, integrator="implicit").stepper(1e-2, substeps=2)
    torques = np.array([4.0, -3.0])
    run = dynamics.Simulation(rods(), [*held, *(dynamics.JointTorque(k, torques[k]) for k in range(2))]).run(
        0.2, times=[0.2]
    )
    ends = []
    for _ in range(2):
        state = stepper.start
        for _ in range(20):
            state = stepper(state, torques)
        ends.append(state)
    assert run.integrator == "implicit" and abs(state.time - 0.2) < 1e-12
    assert np.array_equal(ends[0].q, ends[1].q) and np.array_equal(ends[0].qd, ends[1].qd)
    for k in range(2):
        assert abs(state.q[k] - run.coordinates(k)[-1]) < 1e-8 and abs(state.qd[k] - run.rates(k)[-1]) < 1e-7
    with pytest.raises(SimulationError, match="too small to go on, at time 0.01"):
        stepper(stepper.start, np.array([np.nan, 0.0]))
