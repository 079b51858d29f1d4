"""Motors of cga3d, those of pga3d and matrices stand for each other, wherever poses are taken."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import Status, cga3d, codegen, pga3d, poses, reform
from bladesmith.core.geometry.motors import motors_from
from bladesmith.errors import AlgebraMismatchError, InputError, KindError, ShapeError

from ..support.kinematics import FourBar, four_bar
from ..support.mechanisms.chains import arm
from ..support.registration import POSE, apart, lines_and_planes

BOTH = pytest.mark.parametrize(("home", "other"), [(cga3d, pga3d), (pga3d, cga3d)], ids=["from cga3d", "from pga3d"])
DYADIC = np.random.default_rng(3).integers(-8, 8, (20, 3)) / 4


@BOTH
def test_motors_of_the_other_algebra_are_exact(home, other) -> None:
    t, u = DYADIC[:10], DYADIC[10:]
    for axis in np.eye(3):
        for make in (
            lambda a, axis=axis: a.translator(t) * a.rotor(axis, np.pi) * a.translator(u),
            lambda a: a.translator(t),
            lambda a, axis=axis: a.rotor(axis, 0.7),
            lambda a, axis=axis: a.rotor(axis, -2.0).astype(np.float32),
        ):
            given, expected = make(home), make(other).as_kind("motor")
            found = motors_from(given, other, "x")
            assert found.algebra is other and found.kind == other.kind("motor") and found.dtype == given.dtype
            np.testing.assert_allclose(found.values, expected.values, rtol=1e-15, atol=1e-15)  # of products
            assert motors_from(expected, other, "x") is expected


@BOTH
def test_motors_move_points_as_before(home, other) -> None:
    rng = np.random.default_rng(5)
    x = (
        home.translator(rng.normal(size=(9, 3)) * 1e3) * home.rotor(rng.normal(size=(9, 3)), rng.uniform(-6, 6, 9))
    ).as_kind("motor")
    y = motors_from(x, other, "x")
    back = motors_from(y, home, "x")
    np.testing.assert_array_equal(back.values, x.values)
    np.testing.assert_allclose(y.to_matrix(), x.to_matrix(), rtol=0, atol=1e-12 * 1e3)
    np.testing.assert_array_equal(np.sort(np.abs(x.values)), np.sort(np.abs(y.values)))  # the same numbers


def test_statuses_go_along_and_what_is_no_motor_is_refused() -> None:
    found = motors_from(np.stack([np.eye(4), 2 * np.eye(4)]), cga3d, "x")
    assert found.status.tolist() == [Status.OK, Status.INVALID]
    assert motors_from(found, pga3d, "x").status.tolist() == [Status.OK, Status.INVALID]
    for bad, error in ((cga3d.dilator(2.0), KindError), (2 * cga3d.translator((1, 0, 0)), KindError),
                       (np.eye(3), ShapeError), (None, InputError), ("x", InputError)):  # fmt: skip
        with pytest.raises(error, match=r"motor|the pose"):
            motors_from(bad, pga3d, "the pose")


def test_poses_take_what_kinematics_returns() -> None:
    motor = arm(cga3d).forward(np.linspace(-1, 1, 12).reshape(2, 6))
    m = motor.to_matrix()
    np.testing.assert_allclose(poses.position(motor), m[..., :3, 3], atol=1e-14)
    np.testing.assert_allclose(
        poses.from_quaternion(poses.to_quaternion(motor)).to_matrix()[..., :3, :3], m[..., :3, :3], atol=1e-14
    )
    both = poses.compose(motor, poses.inverse(motor), motor)
    assert both.algebra is pga3d and np.allclose(both.to_matrix(), m, atol=1e-13)


@pytest.mark.parametrize("algebra", [cga3d, pga3d], ids=["cga3d", "pga3d"])
def test_chains_take_poses_of_either_algebra_and_matrices(algebra) -> None:
    chain, q = arm(algebra), np.array([[0.3, -0.8, 1.1, 0.4, 0.9, -0.2], [0.1, -0.4, 0.7, -0.4, 0.5, 1.2]])
    own = chain.forward(q)
    pose = poses.from_matrix(own.to_matrix())
    conformal = motors_from(pose, cga3d, "x")
    for target in (pose, conformal, own.to_matrix(), own.to_matrix().tolist()):
        found = chain.inverse(target, q + 0.01)
        assert not found.status.any() and np.abs(found.q - q).max() < 1e-9
        every = chain.all_solutions(target)
        assert every.q.shape == chain.all_solutions(own).q.shape
    bent = own.to_matrix()
    bent[1, 0, 0] = 3
    assert np.asarray(chain.inverse(bent, q).status).tolist() == [Status.OK, Status.INVALID]


@pytest.mark.compiles
def test_mechanisms_take_poses_of_either_algebra_and_matrices() -> None:
    m = four_bar(FourBar().places(0.8), pga3d)
    wanted = m.solve_pose({"a": 0.2})["rocker"]
    own = m.solve_pose(targets={"rocker": wanted})
    for target in (motors_from(wanted, cga3d, "x"), wanted.to_matrix()):
        found = m.solve_pose(targets={"rocker": target})
        assert found.status == Status.OK and np.allclose(found.own, own.own, atol=1e-12)
        assert np.allclose(m.solve_pose({"a": 0.2}, start={"rocker": target}).own, own.own, atol=1e-9)


def test_registrations_start_from_poses_and_matrices() -> None:
    reference = lines_and_planes()
    query = reference.transformed(~POSE)
    pose = poses.from_matrix(POSE.to_matrix())
    for start in (POSE, pose, POSE.to_matrix(), POSE.to_matrix().tolist()):
        assert apart(reform.register(query, reference, start=start).motor, POSE) < 1e-9
        assert apart(reform.iterate(query, reference, start).motor, POSE) < 1e-9
        assert apart(reform.estimate_rotor(query, reference, start=start), POSE) < 1e-9
    np.testing.assert_allclose(poses.position(POSE), POSE.to_matrix()[:3, 3], atol=1e-15)
    for start in (2 * np.eye(4), np.full((4, 4), np.nan)):
        with pytest.raises(InputError, match="start is not finite, or no rigid motion"):
            reform.register(query, reference, start=start)


@BOTH
def test_products_and_kernels_of_two_algebras_say_how_a_motor_is_converted(home, other) -> None:
    short = {"cga3d": "cga", "pga3d": "pga"}[other.name]
    says = rf"Convert the motor: {short}\.motor_from_matrix\(poses\.to_matrix\(x\)\)"
    motor = (home.translator((1, 2, 3)) * home.rotor((0, 0, 1), 0.3)).as_kind("motor")
    point = other.point((1, 0, 0))
    move = codegen.kernel(other.kind("motor"), other.kind("point"), name="move")(lambda m, x: m >> x)
    for call in (lambda: motor >> point, lambda: move(motor, point), lambda: motor * point):
        with pytest.raises(AlgebraMismatchError, match=says):
            call()
    with pytest.raises(InputError, match=f"the matrix is a motor of {home.name}. {says}"):
        other.motor_from_matrix(motor)
    converted = other.motor_from_matrix(poses.to_matrix(motor))  # as the message says
    assert (converted >> point).isclose(motors_from(motor, other, "x") >> point)
    with pytest.raises(AlgebraMismatchError, match="Convert one first: "):
        home.point((0, 0, 0)) + point


def test_models_are_moved_by_motors_of_both_algebras_and_by_matrices() -> None:
    rng = np.random.default_rng(2)
    model = reform.Model(points=rng.normal(size=(4, 3)), lines=rng.normal(size=(3, 2, 3)))
    pose = poses.from_rotation_vector((0.3, -0.2, 2.0), position=(1e3, 2, -1e-3))
    matrix = poses.to_matrix(pose)
    for given in (pose, matrix, matrix.tolist(), cga3d.motor_from_matrix(matrix)):
        moved = model.transformed(given)
        np.testing.assert_allclose(
            moved.parameters["point"], model.parameters["point"] @ matrix[:3, :3].T + matrix[:3, 3], rtol=0, atol=1e-11
        )
        expected = model.transformed(cga3d.motor_from_matrix(matrix)).parameters["line"]
        np.testing.assert_allclose(moved.parameters["line"], expected, rtol=0, atol=1e-11)
    for bad, error, says in ((np.diag([1, 1, 2, 1.0]), InputError, "no rigid motion"), (np.eye(3), ShapeError, "4, 4"),
                             (np.stack([matrix, matrix]), InputError, "moved by one rotor"), (3, InputError, "R is 3"),
                             (pga3d.point((1, 2, 3)), KindError, "motor of pga3d")):  # fmt: skip
        with pytest.raises(error, match=says):
            model.transformed(bad)
