"""Torques and accelerations of mechanisms with loops, beside simulations of the same bodies, chains, and energies."""

from __future__ import annotations

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.errors import InputError, SingularError, UndeterminedError
from bladesmith.mechanics.twists import screw_vectors

GRAVITY = np.array([0.3, -9.81, 0.2])
UP = np.array([0.0, 0, 1])


def body_between(p, q, mass, algebra, rng):
    """A body around two points, with axes of inertia of its own."""
    length = np.linalg.norm(np.subtract(q, p))
    turn = algebra.rotor(rng.normal(size=3), 1.0)
    return dynamics.RigidBody(
        mass, mass * length**2 * np.array([0.05, 0.08, 0.1]), position=(np.add(p, q) + 0.1 * rng.normal(size=3)) / 2,
        orientation=turn, algebra=algebra,
    )  # fmt: skip


def four_bar(algebra, far=0.0):
    """A planar loop: of its constraints three are there twice."""
    at = np.array([[0, 0, 0], [0, 1, 0], [3, 2.5, 0], [3.5, 0, 0]]) + far
    ends = [("frame", "crank"), ("crank", "coupler"), ("coupler", "rocker"), ("frame", "rocker")]
    joints = [
        kinematics.Revolute(a, b, algebra.line(x, UP), algebra.point(x)) for (a, b), x in zip(ends, at, strict=True)
    ]
    return joints, [("crank", at[0], at[1]), ("coupler", at[1], at[2]), ("rocker", at[2], at[3])]


def slider_crank(algebra, far=0.0):
    """A spatial loop of a hinge, a universal joint, a ball and a slide."""
    a, b, c = np.array([[0, 0, 0], [0.3, 0.9, 0.2], [2.5, 0.4, 0.7]]) + far
    axis = np.array([0.2, 0.1, 1.0])
    first = np.array([0.5, -0.3, 1.0])
    second = np.cross(first, [1.0, 0.4, 0.1])
    if algebra is bs.cga3d:
        joint = kinematics.Universal("crank", "rod", *(algebra.circle(b, n, 0.1) for n in (first, second)))
    else:
        joint = kinematics.Spherical("crank", "rod", algebra.point(b))
    slide = algebra.line(c, [1.0, 0.1, -0.2]), algebra.direction(np.cross([1.0, 0.1, -0.2], UP))
    joints = [
        kinematics.Revolute("frame", "crank", algebra.line(a, axis), algebra.point(a)), joint,
        kinematics.Spherical("rod", "slider", algebra.point(c)), kinematics.Prismatic("frame", "slider", *slide),
    ]  # fmt: skip
    return joints, [("crank", a, b), ("rod", b, c), ("slider", c, c + [0.3, 0, 0])]


def made(build, algebra, far=0.0, seed=0):
    rng = np.random.default_rng(seed)
    joints, parts = build(algebra, far)
    bodies = {name: body_between(p, q, 0.5 + i, algebra, rng) for i, (name, p, q) in enumerate(parts)}
    mechanism = kinematics.Mechanism(["frame", *bodies], "frame", joints)
    return mechanism.with_inertias(bodies), joints, bodies


def moving(mechanism, bodies, twists):
    """The bodies with velocities of twists in the world."""
    found = {}
    for name, body in bodies.items():
        w, v = screw_vectors(mechanism.algebra, twists[name].values)
        own = np.asarray(body.rotation).T @ w
        found[name] = dynamics.RigidBody(
            body.mass, body.axes @ np.diag(body.moments) @ body.axes.T, position=body.position,
            orientation=np.asarray(body.rotation), velocity=v + np.cross(w, body.position), angular_velocity=own,
            algebra=mechanism.algebra,
        )  # fmt: skip
    return found


@pytest.mark.compiles
@pytest.mark.parametrize("far", [0.0, 50.0])
@pytest.mark.parametrize(
    ("build", "algebra"), [(four_bar, bs.cga3d), (four_bar, bs.pga3d), (slider_crank, bs.cga3d)],
    ids=lambda x: getattr(x, "name", getattr(x, "__name__", x)),
)  # fmt: skip
def test_accelerations_are_those_of_a_simulation(build, algebra, far):
    """The crank's, from the force and moment that the simulation finds on it at the start."""
    mechanism, joints, bodies = made(build, algebra, far)
    speed = 1.7
    twists = mechanism.solve({joints[0]: speed})
    started = moving(mechanism, bodies, twists)
    system = dynamics.System(started, joints, "frame")
    trajectory = dynamics.Simulation(system, loads=[dynamics.Gravity(GRAVITY)]).run(1e-3, times=[1e-3])
    found = mechanism.forward_dynamics(joints[0], [speed], [0.0], GRAVITY)
    body, state = started["crank"], trajectory.bodies["crank"]
    force, moment = wrench_vectors(state.reaction[0])
    moment = moment - np.cross(body.position, force)  # about the center of mass
    turn = np.asarray(body.rotation)
    tensor = turn @ body.axes @ np.diag(body.moments) @ (turn @ body.axes).T
    w, _ = screw_vectors(algebra, twists["crank"].values)
    rate = np.linalg.solve(tensor, moment - np.cross(w, tensor @ w))
    expected = rate @ w / (w @ w) * speed  # the axis is fixed
    assert abs(found[0] - expected) < 1e-11 * max(abs(expected), 1.0) * (1 + far)


def wrench_vectors(x):
    screws = x.algebra.wrap(x.kind, x.values)
    return screw_vectors(x.algebra, screws.as_kind("twist").values)


@pytest.mark.parametrize("algebra", [bs.cga3d, bs.pga3d], ids=lambda a: a.name)
def test_power_is_the_rate_of_the_energy(algebra):
    """By differences of poses along a motion of the crank, found by Newton's method."""
    mechanism, joints, bodies = made(four_bar, algebra)
    speed, rate, h = 1.3, -0.7, 1e-4
    tau = mechanism.inverse_dynamics(joints[0], [speed], [rate], GRAVITY)
    energies = []
    for t in (-h, h):
        x, u = speed * t + rate * t * t / 2, speed + rate * t
        poses = mechanism.solve_pose({joints[0]: x})
        there = mechanism.at({name: poses[name] for name in mechanism.moving})
        masses = there.mass_matrix(joints[0])
        heights = [bs_center(poses[name], body) @ GRAVITY * body.mass for name, body in bodies.items()]
        energies.append(masses[0, 0] * u * u / 2 - sum(heights))
    assert tau[0] * speed == pytest.approx((energies[1] - energies[0]) / (2 * h), rel=1e-6)
    assert mechanism.mass_matrix(joints[0]).shape == (1, 1)
    batch = mechanism.inverse_dynamics(joints[0], [[speed], [0.0]], [rate], GRAVITY)
    assert np.allclose(batch, [tau, mechanism.inverse_dynamics(joints[0], 0, [rate], GRAVITY)], rtol=1e-14)
    back = mechanism.forward_dynamics(joints[0], [[speed], [0.0]], batch, GRAVITY)
    assert np.allclose(back, rate, rtol=1e-12)


def bs_center(motor, body):
    matrix = motor.algebra.matrix(motor)
    return matrix[:3, :3] @ body.position + matrix[:3, 3]


def test_an_open_mechanism_is_its_chain():
    robot = kinematics.load_urdf(kinematics.urdf_example("arm"))
    q = np.array([0.3, -0.7, 0.9, 0.2, 0.5, -0.4])
    qd, qdd = np.random.default_rng(0).uniform(-1, 1, (2, 6))
    mechanism = robot.mechanism(q).with_inertias(robot.bodies(q))
    names = list(robot.joint_names)
    expected = robot.inverse_dynamics(q, qd, qdd)
    assert np.abs(mechanism.inverse_dynamics(names, qd, qdd) - expected).max() < 1e-12 * np.abs(expected).max()
    assert np.abs(mechanism.mass_matrix(names) - robot.mass_matrix(q)).max() < 1e-12
    assert np.allclose(mechanism.forward_dynamics(names, qd, expected), qdd, atol=1e-10)


def test_coupled_joints_share_their_inertias():
    algebra, turn = bs.pga3d, [[0, 0, 0], [2, 0, 0]]
    joints = [
        kinematics.Revolute("frame", b, algebra.line(x, UP), algebra.point(x)) for b, x in zip("ab", turn, strict=True)
    ]
    gears = kinematics.Mechanism(["frame", "a", "b"], "frame", joints)
    gears.couple({joints[1]: 1.0, joints[0]: 3.0})
    wheels = [dynamics.RigidBody(2, [0.1, 0.1, 0.2], position=x, algebra=algebra) for x in turn]
    loaded = gears.with_inertias(dict(zip("ab", wheels, strict=True)))
    assert loaded.mass_matrix(joints[0]) == pytest.approx(0.2 + 9 * 0.2, rel=1e-14)
    assert np.abs(loaded.bias_forces(joints[0], [2.0])).max() < 1e-13


def test_universal_joints_at_another_pose():
    """The same mechanism made at the pose, and brought there."""
    mechanism, joints, bodies = made(slider_crank, bs.cga3d)
    poses = mechanism.solve_pose({joints[0]: 0.4})
    there = mechanism.at({name: poses[name] for name in mechanism.moving})
    speed, h = 1.1, 1e-5
    slopes = []
    for x in (0.4 - h, 0.4 + h):
        near = mechanism.solve_pose({joints[0]: x}, start=poses)
        slopes.append(mechanism.at({name: near[name] for name in mechanism.moving}).mass_matrix(joints[0])[0, 0])
    # one coordinate: h = M' u^2 / 2 without gravity
    expected = (slopes[1] - slopes[0]) / (2 * h) * speed**2 / 2
    assert there.bias_forces(joints[0], [speed], (0, 0, 0))[0] == pytest.approx(expected, rel=1e-6)


def test_bad_input():
    mechanism, joints, bodies = made(four_bar, bs.cga3d)
    plain = kinematics.Mechanism(["frame", *bodies], "frame", joints)
    with pytest.raises(InputError, match="no inertias.*with_inertias"):
        plain.mass_matrix(joints[0])
    with pytest.raises(InputError, match="no body 'wheel'"):
        plain.with_inertias({"wheel": bodies["crank"]})
    with pytest.raises(InputError, match="inputs of dynamics are joints"):
        mechanism.mass_matrix("crank")
    with pytest.raises(InputError, match="qd"):
        mechanism.bias_forces(joints[0], [np.nan])
    with pytest.raises(SingularError):
        plain.with_inertias({}).forward_dynamics(joints[0], 0, [1.0])
    spinning, parts, _ = made(slider_crank, bs.pga3d)
    with pytest.raises(UndeterminedError):  # the rod spins between its balls
        spinning.mass_matrix(parts[0])
    with pytest.raises(InputError, match="is a batch"):
        plain.with_inertias({"crank": dynamics.RigidBody([1.0, 2.0], [1, 1, 1])})


def test_inertias_go_with_a_pickle():
    import pickle

    mechanism, joints, _ = made(four_bar, bs.pga3d)
    again = pickle.loads(pickle.dumps(mechanism))
    assert np.array_equal(again.mass_matrix(again.joints[0]), mechanism.mass_matrix(joints[0]))
