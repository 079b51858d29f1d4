"""Poses of two bodies on one joint, by the coordinates of the joint."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bladesmith import Status
from bladesmith import cga3d as cga

from ...support.kinematics import AXIS, turn, twist
from ...support.mechanisms.poses import held_by, moved

pytestmark = pytest.mark.filterwarnings("error")


def test_a_ball_turns_by_rotation_vectors():
    m, place = held_by("spherical"), np.array([1.0, 2, 3])
    vectors = np.random.default_rng(3).normal(size=(20, 3))
    vectors *= np.minimum(1, 3 / np.linalg.norm(vectors, axis=-1, keepdims=True))
    want = Rotation.from_rotvec(vectors).apply([1, 0, 0]) + place
    for poses in (
        m.solve_pose({"j": vectors}),
        m.solve_pose({"j": vectors}, path=True),
        m.solve_pose({"j": vectors}, start=m.solve_pose({"j": vectors[::-1]})),
    ):
        assert not poses.status.any()
        np.testing.assert_allclose(moved(poses, "x", place + [1, 0, 0]), want, atol=1e-12)
        np.testing.assert_allclose(moved(poses, "x", place), np.broadcast_to(place, (20, 3)), atol=1e-12)
        np.testing.assert_allclose(poses.coordinates("j"), vectors, atol=1e-11)


@pytest.mark.parametrize("kind", ["planar", "cylindrical"])
def test_coordinates_come_back(kind):
    m = held_by(kind)
    count = len(m.jacobian("x", "j", strict=False))
    values = np.random.default_rng(4).uniform(-2, 2, (10, count))
    for poses in (
        m.solve_pose({"j": values}),
        m.solve_pose({"j": values}, path=True),
        m.solve_pose({"j": values}, start=m.solve_pose({"j": values[::-1]})),
    ):
        assert not poses.status.any()
        np.testing.assert_allclose(poses.coordinates("j"), values, atol=1e-11)
        place = moved(poses, "x", [1, 2, 3])
        if kind == "planar":
            np.testing.assert_allclose(place[:, 2], 3, atol=1e-12)
        else:
            np.testing.assert_allclose(place, [1, 2, 3] + values[:, 1:] * AXIS, atol=1e-12)


def test_a_universal_joint_reaches_what_it_can():
    """Turned about x of the first body, then about y of the second: R = R_x(a) R_y(b), and nothing else."""
    m, place = held_by("universal"), np.array([1.0, 2, 3])
    angles = np.random.default_rng(5).uniform(-1, 1, (6, 2))
    turns = Rotation.from_euler("XY", angles).as_matrix()
    matrices = np.zeros((6, 4, 4))
    matrices[:, :3, :3], matrices[:, 3, 3] = turns, 1
    matrices[:, :3, 3] = place - turns @ place
    targets = cga.motor_from_matrix(matrices)
    poses = m.solve_pose(targets={"x": targets})
    assert not poses.status.any()
    np.testing.assert_allclose(moved(poses, "x", [0, 0, 0]), matrices[:, :3, 3], atol=1e-12)
    twisted = m.solve_pose(targets={"x": (-0.25 * twist(cga, turn(AXIS, place))).exp()})
    assert twisted.status == Status.NOT_CONVERGED and twisted.residual > 0.05


@pytest.mark.compiles
@pytest.mark.parametrize("kind", ["on a plane", "on a plane, the other way"])
def test_a_point_stays_on_a_plane(kind):
    m, rng = held_by(kind), np.random.default_rng(6)
    on = rng.normal(size=(5, 3)) * [1, 1, 0] + [1, 2, 3]
    poses = m.solve_pose(targets={"x": ([1.0, 2, 3], on)})
    assert not poses.status.any()
    np.testing.assert_allclose(moved(poses, "x", [1, 2, 3]), on, atol=1e-12)
    if kind == "on a plane":
        away = m.solve_pose(targets={"x": ([1.0, 2, 3], on + AXIS)})
        assert (away.status == Status.NOT_CONVERGED).all()
    else:  # the plane leans, and its point is where it likes
        point, normal = moved(poses, "x", [1, 2, 3]), moved(poses, "x", [1, 2, 4]) - moved(poses, "x", [1, 2, 3])
        np.testing.assert_allclose(((point - [1, 2, 3]) * normal).sum(-1), 0, atol=1e-12)
