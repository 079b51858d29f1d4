"""Poses beside packages that others use: Pinocchio and pytransform3d."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import poses

pytestmark = pytest.mark.peers

RNG = np.random.default_rng(0)
ROWS = RNG.normal(size=(20, 6))
X = poses.exp(ROWS)


def linear_first(matrix: np.ndarray) -> np.ndarray:
    """Twists (v, w) in place of (w, v)."""
    return np.roll(matrix, (3, 3), (-2, -1))


def test_exponentials_and_their_jacobians_are_those_of_pinocchio() -> None:
    pinocchio = pytest.importorskip("pinocchio")
    for row, matrix, jacobian, inverse in zip(
        ROWS, poses.to_matrix(X), poses.right_jacobian(ROWS), poses.inverse_right_jacobian(ROWS), strict=True
    ):
        motion = pinocchio.Motion(row[3:], row[:3])
        there = pinocchio.exp6(motion)
        np.testing.assert_allclose(matrix, there.homogeneous, atol=1e-14)
        np.testing.assert_allclose(linear_first(jacobian), pinocchio.Jexp6(motion), atol=1e-14)
        if np.linalg.norm(row[:3]) < 3:
            back = pinocchio.log6(there)
            np.testing.assert_allclose(row, [*back.angular, *back.linear], atol=1e-12)
            np.testing.assert_allclose(linear_first(inverse), pinocchio.Jlog6(there), atol=1e-11)


def test_actions_on_twists_are_those_of_pinocchio() -> None:
    pinocchio = pytest.importorskip("pinocchio")
    for matrix, adjoint in zip(poses.to_matrix(X), poses.adjoint(X), strict=True):
        np.testing.assert_allclose(linear_first(adjoint), pinocchio.SE3(matrix).action, atol=1e-14)


def test_screw_motions_are_those_of_pinocchio() -> None:
    pinocchio = pytest.importorskip("pinocchio")
    for i in range(len(ROWS) - 1):
        there = pinocchio.SE3.Interpolate(*(pinocchio.SE3(m) for m in poses.to_matrix(X[i : i + 2])), 0.3)
        found = poses.to_matrix(poses.interpolate(X[i], X[i + 1], 0.3))
        np.testing.assert_allclose(found, there.homogeneous, atol=1e-13)


def test_dual_quaternions_and_twists_are_those_of_pytransform3d() -> None:
    transformations = pytest.importorskip("pytransform3d.transformations")
    for row, numbers, matrix in zip(ROWS, poses.to_dual_quaternion(X), poses.to_matrix(X), strict=True):
        np.testing.assert_allclose(transformations.transform_from_dual_quaternion(numbers), matrix, atol=1e-14)
        there = transformations.transform_from_exponential_coordinates(row)
        np.testing.assert_allclose(there, matrix, atol=1e-14)
        np.testing.assert_allclose(transformations.left_jacobian_SE3(row), poses.left_jacobian(row), atol=1e-13)


def test_quaternions_are_those_of_pytransform3d() -> None:
    rotations = pytest.importorskip("pytransform3d.rotations")
    for q, matrix in zip(poses.to_quaternion(X), poses.to_matrix(X), strict=True):
        np.testing.assert_allclose(rotations.matrix_from_quaternion(q), matrix[:3, :3], atol=1e-14)
