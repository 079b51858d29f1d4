"""Torques, mass matrices and accelerations of chains against Lagrange's equations with fifty digits, and bad input."""

import pickle

import mpmath as mp
import numpy as np
import pytest

import bladesmith as bs
from bladesmith import dynamics, kinematics
from bladesmith.codegen.programs.trees import CLASSES
from bladesmith.dynamics import screw_coordinates
from bladesmith.errors import InputError, ShapeError, SingularError
from bladesmith.kinematics.serial.axes import prismatic_axis, revolute_axis
from bladesmith.kinematics.serial.chain import Chain

from ...oracles.lagrange import exact_mass_matrix, exact_torques
from ...oracles.serial_chains import DIGITS
from ...support.mechanisms.chains import ALGEBRAS, UP, arm, mixed
from ...support.mechanisms.robots import random_inertias

GRAVITY = np.array([0.3, -0.2, -9.81])
METHODS = ("inverse_dynamics", "bias_forces", "gravity_torques", "mass_matrix", "forward_dynamics")


def off(found, exact):
    """The largest error, relative to the largest number."""
    exact = np.array(exact.tolist(), float).reshape(np.shape(found))
    return np.abs(found - exact).max() / np.abs(exact).max()


def motion(seed, count, items=3):
    return np.random.default_rng(seed).uniform(-2, 2, (3, items, count))


@pytest.mark.slow
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
@pytest.mark.parametrize(("seed", "scale", "origin"), [(0, 1.0, 0.0), (1, 1.0, 0.0), (2, 1e-3, 0.0), (3, 1.0, 100.0)])
def test_lagranges_equations(algebra, seed, scale, origin):
    chain, q = mixed(algebra, seed, count=4, scale=scale, origin=origin)
    center = origin * np.array([0.6, -0.7, 0.4])
    masses, centers, tensors = random_inertias(np.random.default_rng(seed), 4, scale, center)
    chain = chain.with_inertias(masses, centers, tensors)
    x, qd, qdd = q[0], *motion(seed, 4, 1)[:2, 0]
    tolerance = 1e-13 * (1 + origin)  # the axes themselves are rounded at their distance from the origin
    with mp.workdps(DIGITS):
        screws = screw_coordinates(chain.axes)
        exact = exact_mass_matrix(screws, masses, centers, tensors, x)
        assert off(chain.mass_matrix(x), exact) < tolerance
        forces = exact_torques(screws, masses, centers, tensors, GRAVITY, x, qd, qdd)
        assert off(chain.inverse_dynamics(x, qd, qdd, GRAVITY), forces) < tolerance
        still = exact_torques(screws, masses, centers, tensors, GRAVITY, x, 0 * qd, 0 * qd)
        assert off(chain.gravity_torques(x, GRAVITY), still) < tolerance
        bias = exact_torques(screws, masses, centers, tensors, GRAVITY, x, qd, 0 * qd)
        assert off(chain.bias_forces(x, qd, GRAVITY), bias) < tolerance
        solved = mp.lu_solve(exact, mp.matrix([mp.mpf(t) for t in qdd.tolist()]) - bias)
        condition = np.linalg.cond(np.array(exact.tolist(), float))
        assert off(chain.forward_dynamics(x, qd, qdd, GRAVITY), solved) < tolerance * condition


def heavy_arm(algebra=bs.cga3d, **options):
    return arm(algebra, **options).with_inertias(*random_inertias(np.random.default_rng(7), 6, 0.2, [0.3, 0.1, 0.5]))


@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_forward_dynamics_undoes_inverse_dynamics(algebra):
    chain = heavy_arm(algebra)
    q, qd, qdd = motion(1, 6, 50)
    tau = chain.inverse_dynamics(q, qd, qdd)
    assert np.abs(chain.forward_dynamics(q, qd, tau) - qdd).max() < 1e-9
    bias, mass = chain.bias_forces(q, qd), chain.mass_matrix(q)
    assert np.abs((mass @ qdd[..., None])[..., 0] + bias - tau).max() < 1e-12 * np.abs(tau).max()
    assert np.array_equal(mass, np.swapaxes(mass, -1, -2)) and np.linalg.eigvalsh(mass).min() > 0
    assert np.array_equal(chain.gravity_torques(q), chain.inverse_dynamics(q, 0, 0))


def test_shapes_broadcast_and_threads_change_nothing():
    chain = heavy_arm()
    q, qd, qdd = motion(2, 6, 12)
    whole = chain.inverse_dynamics(q.reshape(3, 4, 6), qd[0], qdd.reshape(3, 4, 6))
    assert whole.shape == (3, 4, 6)
    assert np.array_equal(whole[1, 2], chain.inverse_dynamics(q[6], qd[0], qdd[6]))
    assert np.array_equal(chain.inverse_dynamics(q[0], qd, 0)[5], chain.inverse_dynamics(q[0], qd[5]))
    assert chain.mass_matrix(q.reshape(3, 4, 6)).shape == (3, 4, 6, 6) and chain.mass_matrix(q[0]).shape == (6, 6)
    assert chain.inverse_dynamics(q[:0]).shape == (0, 6) and chain.mass_matrix(q[:0]).shape == (0, 6, 6)
    many = [np.tile(x, (4000, 1)) for x in (q, qd, qdd)]
    assert np.array_equal(chain.forward_dynamics(*many, threads=2), chain.forward_dynamics(*many, threads=1))


def test_inertias_are_in_the_frames_of_links():
    chain = heavy_arm()
    rng = np.random.default_rng(3)
    masses, centers, tensors = random_inertias(rng, 6, 0.2)
    frames = bs.cga3d.translator(rng.normal(size=(6, 3))) * bs.cga3d.rotor(rng.normal(size=(6, 3)), rng.normal(size=6))
    inside = Chain(chain.axes, chain.tool, frames=frames).with_inertias(masses, centers, tensors)
    poses = bs.cga3d.matrix(frames)
    turns = poses[:, :3, :3]
    outside = chain.with_inertias(
        masses, np.einsum("nij,nj->ni", turns, centers) + poses[:, :3, 3], turns @ tensors @ np.swapaxes(turns, 1, 2)
    )
    objects = [dynamics.Inertia(m, t, bs.cga3d.translator(c)) for m, c, t in zip(masses, centers, tensors, strict=True)]
    q, qd, qdd = motion(4, 6)
    expected = inside.inverse_dynamics(q, qd, qdd)
    for other in (outside, Chain(chain.axes, chain.tool, frames=frames).with_inertias(objects)):
        assert np.abs(other.inverse_dynamics(q, qd, qdd) - expected).max() < 1e-12 * np.abs(expected).max()
    moments = chain.with_inertias(masses, centers, np.arange(18.0, 36.0).reshape(6, 3))
    assert moments.mass_matrix(q).shape == (3, 6, 6)


@pytest.mark.compiles
def test_motion_agrees_with_the_simulation():
    """The last link of a robot that begins to fall, from the accelerations of its joints."""
    robot = kinematics.load_urdf(kinematics.urdf_example("arm"))
    q, zero, time = np.array([0.3, -0.5, 0.8, 0.2, 0.4, -0.3]), np.zeros(6), 2e-3
    system = robot.system(q)
    run = dynamics.Simulation(system, [dynamics.Gravity((0, 0, -9.81))], integrator="adaptive").run(time, times=[time])
    name = robot.joints[robot.joint_names[-1]].child
    start = np.asarray(system.bodies[name].position)
    found = (run.bodies[name].position[-1] - start) * 2 / time**2
    twist = robot.chain(name).acceleration(q, zero, robot.forward_dynamics(q, zero, zero))
    w, v = np.split(screw_coordinates(twist), 2)
    assert np.abs(found - (v + np.cross(w, start))).max() < 1e-4 * np.abs(found).max()


@pytest.mark.parametrize("count", [2, CLASSES[0] + 1, 300, CLASSES[-1]])
def test_any_length(count):
    """A rope of rods that hangs straight: what it takes to hold it level at the first joint is known."""
    places = np.zeros((count, 3))
    places[:, 0] = np.arange(count)
    chain = Chain(revolute_axis(places, (0, 1, 0)), bs.cga3d.translator([count, 0, 0])).with_inertias(
        np.ones(count), places + [0.5, 0, 0], np.tile(np.eye(3) / 12, (count, 1, 1))
    )
    zero = np.zeros(count)
    torque = chain.gravity_torques(zero)
    assert np.allclose(torque, -9.81 * (count - np.arange(count)) ** 2 / 2, rtol=1e-13)
    if count <= 300:
        q, qd, qdd = motion(5, count, 1)[:, 0]
        tau = chain.inverse_dynamics(q, qd, qdd)
        found = chain.forward_dynamics(q, qd, tau)
        back = chain.inverse_dynamics(q, qd, found)
        assert np.abs(back - tau).max() < 1e-11 * np.abs(tau).max()


def test_a_chain_pickles():
    chain = heavy_arm()
    q, qd, qdd = motion(6, 6)
    expected = chain.inverse_dynamics(q, qd, qdd)
    assert np.array_equal(pickle.loads(pickle.dumps(chain)).inverse_dynamics(q, qd, qdd), expected)


# -- derivatives, and one motion at a time -------------------------------------------------------------------


@pytest.mark.compiles
@pytest.mark.parametrize("algebra", ALGEBRAS, ids=lambda a: a.name)
def test_derivatives_are_slopes(algebra):
    """Against differences over steps that shrink, along one coordinate after the other (Richardson)."""
    chain, q = mixed(algebra, 5, count=4)
    chain = chain.with_inertias(*random_inertias(np.random.default_rng(5), 4))
    motions = [q[:2], *motion(5, 4, 2)[:2]]
    for name, field in (("inverse_dynamics", "qdd"), ("forward_dynamics", "tau")):
        of, found = getattr(chain, name), getattr(chain, f"{name}_derivatives")(*motions, GRAVITY)
        assert found._fields == ("q", "qd", field)
        for k, matrices in enumerate(found):
            assert matrices.shape == (2, 4, 4)
            for j in range(4):
                slopes = []
                for h in (1e-3, 5e-4, 2.5e-4):
                    ahead, behind = ([m.copy() for m in motions] for _ in range(2))
                    ahead[k][:, j] += h
                    behind[k][:, j] -= h
                    slopes.append((of(*ahead, GRAVITY) - of(*behind, GRAVITY)) / (2 * h))
                finer = [(4 * slopes[i + 1] - slopes[i]) / 3 for i in range(2)]
                expected = (16 * finer[1] - finer[0]) / 15
                assert np.abs(matrices[:, :, j] - expected).max() < 1e-8 * max(1, np.abs(expected).max())


@pytest.mark.compiles
def test_derivatives_belong_together():
    """Of accelerations they are those of torques, divided by the mass matrix."""
    chain = heavy_arm()
    q, qd, qdd = motion(9, 6, 7)
    torques = chain.inverse_dynamics_derivatives(q, qd, qdd)
    found = chain.forward_dynamics_derivatives(q, qd, chain.inverse_dynamics(q, qd, qdd))
    mass = chain.mass_matrix(q)
    assert np.array_equal(torques.qdd, mass)
    for matrix, expected in ((found.tau, np.eye(6)), (found.q, -torques.q), (found.qd, -torques.qd)):
        assert np.abs(mass @ matrix - expected).max() < 1e-9 * np.abs(expected).max()
    one = chain.inverse_dynamics_derivatives(q[2], qd[2], qdd[2])
    assert one.q.shape == (6, 6) and np.array_equal(one.q, torques.q[2])
    assert chain.inverse_dynamics_derivatives(q.reshape(7, 1, 6)).q.shape == (7, 1, 6, 6)


@pytest.mark.compiles
def test_one_motion_at_a_time_has_the_same_bits():
    chain = heavy_arm()
    bound = chain.bound(GRAVITY)
    for q, qd, qdd in zip(*motion(10, 6, 3), strict=True):
        assert np.array_equal(bound.inverse_dynamics(q, qd, qdd), chain.inverse_dynamics(q, qd, qdd, GRAVITY))
        assert np.array_equal(bound.forward_dynamics(q, qd, qdd), chain.forward_dynamics(q, qd, qdd, GRAVITY))
        assert np.array_equal(bound.bias_forces(q, qd), chain.bias_forces(q, qd, GRAVITY))
        assert np.array_equal(bound.gravity_torques(q.tolist()), chain.gravity_torques(q, GRAVITY))
        assert np.array_equal(bound.mass_matrix(q), chain.mass_matrix(q))
    first = bound.mass_matrix(np.zeros(6))
    assert bound.mass_matrix(np.ones(6)) is first  # the object's own
    for wrong in (np.zeros(5), np.zeros((1, 6)), 0.0):
        with pytest.raises(ShapeError, match="qd .*needed"):
            bound.inverse_dynamics(np.zeros(6), wrong, np.zeros(6))
        with pytest.raises(ShapeError, match="q .*needed"):
            bound.mass_matrix(wrong)
    with pytest.raises(InputError, match="inertias"):
        arm().bound()


# -- without an answer ---------------------------------------------------------------------------------------


def test_items_that_are_not_finite():
    chain = heavy_arm()
    q, qd, qdd = motion(8, 6, 5)
    q[2, 1] = np.nan
    qd[3, 0] = np.inf
    for name, motions in (
        ("inverse_dynamics", (q, qd, qdd)), ("bias_forces", (q, qd)), ("gravity_torques", (q,)), ("mass_matrix", (q,)),
        ("forward_dynamics", (q, qd, qdd)),
    ):  # fmt: skip
        with np.errstate(all="ignore"):
            values, status = getattr(chain, name)(*motions, status=True)
        bad = [2] if name in ("gravity_torques", "mass_matrix") else [2, 3]
        assert np.flatnonzero(status).tolist() == bad and (status[bad] == bs.Status.INVALID).all()
        assert np.isnan(values[2]).any() and np.isfinite(np.delete(values, bad, 0)).all()
        with pytest.raises(SingularError, match=name):
            getattr(chain, name)(*motions, strict=True)


def test_a_joint_that_moves_no_mass_is_singular():
    chain = arm().with_inertias([1, 1, 1, 1, 1, 0], np.zeros((6, 3)), np.zeros((6, 3, 3)))
    q = np.zeros(6)
    acceleration, status = chain.forward_dynamics(q, q, q, status=True)
    assert status == bs.Status.SINGULAR and np.isnan(acceleration).all()


def test_bad_input():
    plain = arm()
    chain = heavy_arm()
    q = np.zeros(6)
    for name in METHODS:
        count = {"inverse_dynamics": 3, "bias_forces": 2, "forward_dynamics": 3}.get(name, 1)
        with pytest.raises(InputError, match=r"no inertias.*with_inertias"):
            getattr(plain, name)(*[q] * count)
        with pytest.raises(ShapeError, match=r"q has shape \(5,\)"):
            getattr(chain, name)(np.zeros(5), *[q] * (count - 1))
    with pytest.raises(ShapeError, match="do not broadcast"):
        chain.inverse_dynamics(np.zeros((2, 6)), np.zeros((3, 6)))
    with pytest.raises(ShapeError, match="gravity"):
        chain.inverse_dynamics(q, gravity=(0, 0))
    with pytest.raises(InputError, match="gravity.*finite"):
        chain.inverse_dynamics(q, gravity=(0, 0, np.nan))
    with pytest.raises(InputError, match="q"):
        chain.inverse_dynamics("up")


def test_impossible_inertias():
    masses, centers, tensors = random_inertias(np.random.default_rng(0), 6)
    chain = arm()
    for change, match in (
        (lambda m, c, t: m.__setitem__(2, -1.0), "mass of the link of joint_3 is -1"),
        (lambda m, c, t: m.__setitem__(2, 0.0), "link of joint_3 has moments of inertia, and no mass"),
        (lambda m, c, t: m.__setitem__(1, np.nan), "the masses.*finite"),
        (lambda m, c, t: t.__setitem__(4, np.diag([1.0, 1.0, 3.0])), "link of joint_5.*exceeds the sum.*'keep'"),
        (lambda m, c, t: t.__setitem__(4, np.diag([1.0, 1.0, -1.0])), "link of joint_5.*moment of inertia is -1"),
        (lambda m, c, t: t.__setitem__((4, 0, 1), 5.0), "link of joint_5.*not symmetric"),
    ):
        given = masses.copy(), centers.copy(), tensors.copy()
        change(*given)
        with pytest.raises(InputError, match=match):
            chain.with_inertias(*given)
    odd = tensors.copy()
    odd[4] = np.diag([1.0, 1.0, 3.0])
    kept = chain.with_inertias(masses, centers, odd, impossible="keep")
    assert np.isfinite(kept.mass_matrix(np.zeros(6))).all()
    with pytest.raises(InputError, match="its center of mass and its tensor"):
        chain.with_inertias(masses)
    with pytest.raises(ShapeError, match="centers"):
        chain.with_inertias(masses, centers[:5], tensors)
    with pytest.raises(InputError, match="5 inertias for 6 links"):
        chain.with_inertias([dynamics.Inertia(1, np.ones(3))] * 5)
    with pytest.raises(InputError, match="impossible"):
        chain.with_inertias(masses, centers, tensors, impossible="maybe")


def test_slides_fall():
    """A translation that falls freely, and one that is level."""
    axes = [prismatic_axis(UP), prismatic_axis((1, 0, 0))]
    chain = Chain(axes).with_inertias([1.0, 2.0], np.zeros((2, 3)), np.zeros((2, 3, 3)))
    assert np.allclose(chain.gravity_torques([0, 0]), [3 * 9.81, 0])
    assert np.allclose(chain.forward_dynamics([0, 0], [0, 0], [0, 1]), [-9.81, 0.5])
    assert np.allclose(chain.mass_matrix([5, 6]), [[3, 0], [0, 2]])
