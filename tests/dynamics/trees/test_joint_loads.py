"""Loads of joints and steps of control loops: against equations of motion by SciPy, energy, Pinocchio; bad input."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.errors import InputError, ShapeError, SimulationError

from ...support.mechanisms.robots import real_robots

CGA = bs.cga3d
DOWN = dynamics.Gravity((0.0, 0.0, -9.81))
MASS, MOMENT, HALF, START = 1.5, 0.4, 0.5, 0.3


def pendulum(is_reversed: bool = False, mass: Any = MASS) -> dynamics.System:
    """A rod at rest below a hinge about y, whose coordinate is told from 0.3 on."""
    body = dynamics.RigidBody(mass, (MOMENT, MOMENT, MOMENT), (0, 0, -HALF))
    names = ("rod", "base") if is_reversed else ("base", "rod")
    hinge = kinematics.Revolute(*names, CGA.line((0, 0, 0), (0, 1, 0)), CGA.point((0, 0, 0)))
    return dynamics.System({"rod": body}, [hinge], joint_names=["hinge"], joint_coordinates=[START])


def slider() -> dynamics.System:
    """A block on a slide along z, in front of a rod on a cylindrical joint along x."""
    block = dynamics.RigidBody(2.0, (1, 1, 1))
    rod = dynamics.RigidBody(MASS, (MOMENT, MOMENT, MOMENT), (0, 0, -HALF))
    joints = [
        kinematics.Prismatic("base", "block", CGA.line((0, 0, 0), (0, 0, 1)), CGA.direction((1, 0, 0))),
        kinematics.Cylindrical("rod", "block", CGA.line((0, 0, 0), (1, 0, 0))),
    ]
    return dynamics.System({"block": block, "rod": rod}, joints, joint_names=["slide", "cylinder"])


LAWS = {
    "torque": ([dynamics.JointTorque("hinge", 2.0), dynamics.JointTorque(0, 1.0)], lambda x, v: 3.0),
    "spring": (
        [dynamics.JointSpring("hinge", 5.0, 0.2, 0.3), dynamics.JointSpring("hinge", 7.0, -0.4)],
        lambda x, v: -5.0 * (x - 0.2) - 7.0 * (x + 0.4) - 0.3 * v,
    ),
    "damper": ([dynamics.JointDamper("hinge", 0.7)], lambda x, v: -0.7 * v),
    "friction": ([dynamics.JointFriction("hinge", 0.5, 0.05)], lambda x, v: -0.5 * v / np.hypot(v, 0.05)),
    "limits": (
        [dynamics.JointLimit("hinge", 0.1, 0.5, 500.0, 2.0)],
        lambda x, v: -500 * max(x - 0.5, 0) - 500 * min(x - 0.1, 0) - (2 * v if x > 0.5 or x < 0.1 else 0.0),
    ),
}


@pytest.mark.parametrize("is_reversed", [False, True])
@pytest.mark.parametrize("name", LAWS)
def test_laws_of_joints(name: str, is_reversed: bool) -> None:
    """A pendulum under each, beside its equation of motion."""
    loads, law = LAWS[name]
    sign = -1.0 if is_reversed else 1.0  # the coordinate is that of the second body against the first
    pull = dynamics.Gravity((4.0, 0.0, -9.81))
    found = dynamics.Simulation(pendulum(is_reversed), [pull, *loads]).run(1.0, times=[0.5, 1.0])

    def rates(_: float, y: Any) -> Any:
        angle = sign * (y[0] - START)
        gravity = sign * MASS * HALF * (-4.0 * np.cos(angle) - 9.81 * np.sin(angle))
        return [y[1], (gravity + law(*y)) / (MOMENT + MASS * HALF**2)]

    exact = solve_ivp(rates, (0, 1.0), [START, 0.0], method="DOP853", rtol=1e-13, atol=1e-14, t_eval=[0, 0.5, 1.0]).y
    assert np.abs(found.coordinates("hinge") - exact[0]).max() < 1e-9
    assert np.abs(found.rates("hinge") - exact[1]).max() < 1e-8
    force, moment = dynamics.wrench_parts(found.reactions("hinge"))
    assert np.abs(moment[:, 1]).max() < 1e-11 * np.abs(force).max()  # forces along joints are no reactions


def test_forces_of_joints_with_several_freedoms() -> None:
    """Along the second joint's translation and rotation, of which the rod is the first body; energy is kept."""
    spring = [dynamics.JointSpring("cylinder", 30.0, 0.1), dynamics.JointSpring("cylinder", 20.0, 0.5, freedom=1)]
    limit = dynamics.JointLimit("slide", -0.05, np.inf, 4000.0)
    found = dynamics.Simulation(slider(), [DOWN, limit, *spring]).run(1.0, times=np.linspace(0, 1, 21))
    assert np.ptp(found.energy) < 1e-9 and np.ptp(found.coordinates("cylinder"), 0).min() > 0.1
    assert -0.3 < found.coordinates("slide").min() < -0.06
    other = dynamics.Simulation(slider(), [dynamics.JointTorque("cylinder", 0.5, freedom=1)]).run(0.1, times=[0.1])
    assert found.coordinates("cylinder")[1, 1] * other.rates("cylinder")[-1, 1] > 0.0


def test_a_ball_is_damped() -> None:
    """Alike about all axes: a body that spins about its center of mass."""
    spin = np.array([1.0, -2.0, 0.5])
    body = dynamics.RigidBody(1.0, (2.0, 2.0, 2.0), angular_velocity=spin)
    system = dynamics.System({"a": body}, [kinematics.Spherical("base", "a", CGA.point((0, 0, 0)))])
    found = dynamics.Simulation(system, [dynamics.JointDamper(0, 0.8)]).run(1.0, times=[1.0])
    assert np.abs(found.rates(0)[-1] - spin * np.exp(-0.4)).max() < 1e-12
    with pytest.raises(InputError, match="turns about a point.*JointDamper"):
        dynamics.Simulation(system, [dynamics.JointSpring(0, 1.0)])


def test_batches_of_loads() -> None:
    stiffness = np.array([3.0, 8.0])
    together = dynamics.Simulation(pendulum(), [DOWN, dynamics.JointSpring("hinge", stiffness, 1.0)])
    found = together.run(0.3, times=[0.3])
    assert found.energy.shape == (2, 2) and np.ptp(found.energy, -1).max() < 1e-12
    kinetic = (MOMENT + MASS * HALF**2) * found.rates("hinge") ** 2 / 2
    twisted = stiffness[:, None] * (found.coordinates("hinge") - 1.0) ** 2 / 2
    assert np.abs(found.kinetic_energy - kinetic).max() < 1e-12
    assert np.abs(found.potential_energy - MASS * 9.81 * found.position[..., 2] - twisted).max() < 1e-12
    for i, k in enumerate(stiffness):
        single = dynamics.Simulation(pendulum(), [DOWN, dynamics.JointSpring("hinge", k, 1.0)]).run(0.3, times=[0.3])
        assert np.array_equal(found.coordinates(0)[i], single.coordinates(0))


def test_what_loads_of_joints_refuse() -> None:
    system, spring = pendulum(), dynamics.JointSpring("hinge", 1.0)
    rod = system.bodies["rod"]
    for load, options, reason in (
        (dynamics.JointSpring("elbow", 1.0), {}, r"loads\[0\] \(JointSpring\).*no joint 'elbow'"),
        (dynamics.JointSpring(3, 1.0), {}, "3 is no joint"),
        (dynamics.JointSpring("hinge", 1.0, freedom=1), {}, "has 1 freedoms"),
        (spring, {"coordinates": "maximal"}, "coordinates of joints"),
        (
            spring,
            {"integrator": "taylor"},
            'loads of joints are for systems .*: integrator \'taylor\'.*integrator = "auto", "adaptive", "implicit", '
            '"rk4", "rkmk4" or "rkmk5"',
        ),
        (spring, {"constraints": [dynamics.Pin(CGA.point((0, 0, HALF)))]}, "constraints besides the joints"),
    ):
        with pytest.raises(InputError, match=reason):
            dynamics.Simulation(system, [load], **options)
    with pytest.raises(InputError, match="simulation of one body"):
        dynamics.Simulation(rod, [spring])
    with pytest.raises(InputError, match="second one of its freedom"):
        dynamics.Simulation(system, [dynamics.JointFriction(0, 1.0), dynamics.JointFriction("hinge", 1.0)])
    for make in (
        lambda: dynamics.JointSpring(0, -1.0),
        lambda: dynamics.JointTorque(0, np.nan),
        lambda: dynamics.JointFriction(0, 1.0, 0.0),
        lambda: dynamics.JointLimit(0, 1.0, 0.0, 5.0),
        lambda: dynamics.JointLimit(0, np.nan, 0.0, 5.0),
        lambda: dynamics.JointDamper(0, 1.0, -1),
    ):
        with pytest.raises(InputError):
            make()


def test_steps() -> None:
    """Equal to a run of the same steps, from any state, and again from the start."""
    simulation = dynamics.Simulation(slider(), [DOWN, dynamics.JointTorque("slide", 30.0)])
    stepper = simulation.stepper(2e-3, substeps=2)
    assert stepper.names == ("slide", "cylinder", "cylinder") and stepper.start.q.tolist() == [0, 0, 0]
    torques = np.array([2.0, 1.0, -0.5])
    ends = []
    for _ in range(2):
        state = stepper.start
        for _ in range(50):
            state = stepper(state, torques)
        ends.append(state)
    assert np.array_equal(ends[0].q, ends[1].q) and abs(state.time - 0.1) < 1e-12
    held = [dynamics.JointTorque("slide", 32.0), dynamics.JointTorque("cylinder", 1.0)]
    held.append(dynamics.JointTorque("cylinder", -0.5, freedom=1))
    exact = dynamics.Simulation(slider(), [DOWN, *held]).run(0.1, times=[0.1])
    assert abs(state.q[0] - exact.coordinates("slide")[-1]) < 1e-9
    assert np.abs(state.q[1:] - exact.coordinates("cylinder")[-1]).max() < 1e-9
    assert np.abs(state.qd[1:] - exact.rates("cylinder")[-1]).max() < 1e-9
    there = stepper(stepper.state([0.1, 0.2, 0.3], 0.5), [0, 0, 0])
    assert np.abs(there.q - [0.101, 0.201, 0.301]).max() < 1e-4
    again = pickle.loads(pickle.dumps(simulation)).stepper(2e-3, substeps=2)
    assert np.array_equal(again(again.start, torques).q, stepper(stepper.start, torques).q)


def floating(algebra: Any = CGA) -> dynamics.System:
    """A body that floats, one that turns about a point of it, and a hinge on that."""
    turned = Rotation.from_rotvec([0.3, -0.4, 0.2]).as_matrix()
    places = (0.1, 0.2, 0.3), (0.6, 0.2, 0.3), (1.2, 0.4, 0.3)
    own = {"velocity": (0.1, 0.2, -0.3), "algebra": algebra}
    bodies = {
        "trunk": dynamics.RigidBody(5.0, (0.3, 0.2, 0.4), places[0], turned, **own),
        "thigh": dynamics.RigidBody(2.0, (0.1, 0.2, 0.15), places[1], turned.T, **own),
        "shank": dynamics.RigidBody(1.0, (0.05, 0.1, 0.1), places[2], **own),
    }
    knee = algebra.line((0.9, 0.3, 0.3), (0, 1.0, 0.2)), algebra.point((0.9, 0.3, 0.3))
    joints = [
        kinematics.Revolute("shank", "thigh", *knee),
        kinematics.Spherical("trunk", "thigh", algebra.point((0.35, 0.2, 0.3))),
    ]
    return dynamics.System(bodies, joints, joint_names=["knee", "hip"])


@pytest.mark.parametrize("algebra", [CGA, bs.pga3d], ids=["cga", "pga"])
def test_steps_of_what_floats_and_turns_about_points(algebra: Any) -> None:
    """Equal to a run under the same loads, whether states are handed back or made anew from their numbers."""
    push = dynamics.JointTorque("knee", 0.7)
    exact = dynamics.Simulation(floating(algebra), [DOWN, push]).run(1.0, times=[1.0])
    stepper = dynamics.Simulation(floating(algebra), [DOWN]).stepper(1e-3)
    assert stepper.names == ("trunk",) * 6 + ("knee",) + ("hip",) * 3
    pushed = 0.7 * (np.arange(10) == 6)
    state = other = stepper.start
    for _ in range(1000):
        state = stepper(state, pushed)
        other = stepper(stepper.state(other.q, other.qd, other.time), pushed)
    assert np.abs(other.q - state.q).max() < 1e-12
    trunk, body = exact["trunk"], floating().bodies["trunk"]
    turned = Rotation.from_matrix(trunk.orientation[-1] @ body.rotation.T).as_rotvec()
    joints = [np.atleast_1d(exact.coordinates(name)[-1]) for name in ("knee", "hip")]
    assert np.abs(state.q - np.concatenate([trunk.position[-1] - body.position, turned, *joints])).max() < 1e-9
    assert np.abs(state.qd[:3] - trunk.velocity[-1]).max() < 1e-9
    rates = np.concatenate([np.atleast_1d(exact.rates(name)[-1]) for name in ("knee", "hip")])
    assert np.abs(state.qd[6:] - rates).max() < 1e-9 and np.abs(rates).min() > 0.1


def test_torques_of_balls_are_along_the_axes_of_their_speeds() -> None:
    """A damper in the loop is a damper among the loads."""
    push = dynamics.JointTorque("knee", 2.0)
    damped = dynamics.Simulation(floating(), [push, dynamics.JointDamper("hip", 0.5)]).run(0.5, times=[0.5])
    stepper = dynamics.Simulation(floating(), [push]).stepper(2e-4)
    state = stepper.start
    for _ in range(2500):
        state = stepper(state, np.concatenate([np.zeros(7), -0.5 * state.qd[7:]]))
    free = dynamics.Simulation(floating(), [push]).run(0.5, times=[0.5])
    ends = [run.coordinates("hip")[-1] for run in (damped, free)]
    assert np.abs(state.q[7:] - ends[0]).max() < 1e-3 * np.abs(ends[1] - ends[0]).max()


@pytest.mark.parametrize("integrator", ["auto", pytest.param("implicit", marks=pytest.mark.slow)])
def test_many_substeps_are_taken_in_parts(integrator: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between which interrupts are heard; the state is the same."""
    simulation = dynamics.Simulation(pendulum(), [DOWN], integrator=integrator)
    whole = simulation.stepper(1e-2, substeps=10)
    monkeypatch.setattr("bladesmith.dynamics.trees.stepper.MOST_STEPS", 3)
    parts = simulation.stepper(1e-2, substeps=10)
    found, expected = (stepper(stepper.start, np.ones(1)) for stepper in (parts, whole))
    assert np.array_equal(found.q, expected.q) and np.array_equal(found.qd, expected.qd)
    with pytest.raises(SimulationError, match="no longer finite|too small"):
        parts(parts.start, np.array([np.nan]))


def test_what_steppers_refuse() -> None:
    stepper = dynamics.Simulation(pendulum(), [DOWN]).stepper(1e-3)
    for q, reason in ((np.inf, "q is inf"), ([1.0, 2.0], "does not broadcast")):
        with pytest.raises(InputError, match=reason):
            stepper.state(q)
    with pytest.raises(InputError, match="state"):
        stepper((stepper.start.q, stepper.start.qd), [0.0])  # type: ignore[arg-type]
    assert stepper.start.q.tolist() == [START]
    with pytest.raises(ShapeError, match="torques"):
        stepper(stepper.start, np.zeros(2))
    for torques in (np.array([1j]), np.array(["a"])):
        with pytest.raises(InputError, match="torques holds .*real numbers"):
            stepper(stepper.start, torques)
    assert stepper(stepper.start, np.array([2])).q == stepper(stepper.start, np.array([2.0])).q
    with pytest.raises(SimulationError, match="no longer finite, at time 0.001"):
        stepper(stepper.start, np.array([np.nan]))
    assert np.isfinite(stepper(stepper.start, np.zeros(1)).q).all()
    body = dynamics.RigidBody(1.0, (1, 1, 1))
    ball = dynamics.System({"a": body}, [kinematics.Spherical("a", "base", CGA.point((0, 0, 0)))])
    for simulation, reason in (
        (dynamics.Simulation(ball), "names them the other way round"),
        (dynamics.Simulation(pendulum(mass=np.ones(2))), "not of a batch"),
        (dynamics.Simulation(body), "a stepper is for systems .*: there are no joints"),
    ):
        with pytest.raises(InputError, match=reason):
            simulation.stepper(1e-3)
    for arguments in ((0.0,), (1e-3, 0), (np.inf,)):
        with pytest.raises(InputError):
            dynamics.Simulation(pendulum()).stepper(*arguments)


@pytest.mark.peers
@pytest.mark.slow
def test_an_arm_under_computed_torques() -> None:
    """From its maker's file: torques of each step are those of Pinocchio, and it comes to its goal."""
    pin, robots = pytest.importorskip("pinocchio"), real_robots()
    if not robots:
        pytest.skip("no package example-robot-data")
    path = robots["ur/ur5_robot"]
    robot, model = kinematics.load_urdf(path), pin.buildModelFromUrdf(str(path))
    memory, goal = model.createData(), np.array([0.5, -0.5, 0.6, 0.5, 0.4, 0.3])
    stepper = dynamics.Simulation(robot.system(np.array([0.1, -1.0, 1.0, 0.3, 0.2, 0.1])), [DOWN]).stepper(1e-3)
    assert stepper.names == robot.joint_names == tuple(model.names)[1:]
    model_of, state = robot.bound(), stepper.start
    for _ in range(2000):
        wanted = 100 * (goal - state.q) - 20 * state.qd
        torques = model_of.inverse_dynamics(state.q, state.qd, wanted)
        assert np.abs(torques - pin.rnea(model, memory, state.q, state.qd, wanted)).max() < 1e-11
        state = stepper(state, torques)
    assert np.abs(state.q - goal).max() < 1e-6
