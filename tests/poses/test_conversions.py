"""Poses from and to quaternions, matrices, rotation vectors and Euler angles, against 50 digits and scipy."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bladesmith import Status, cga3d, poses

from ..oracles.motions import poses as oracle
from .test_maps import EDGES, twists

RNG = np.random.default_rng(0)
ROWS = np.concatenate([EDGES[::4], twists(20, 7)])
X = poses.exp(ROWS)
NUMBERS = poses.to_dual_quaternion(X)
Q, P = poses.to_quaternion(X), poses.position(X)
#: All sequences of three axes, of the world and turned along.
SEQUENCES = [
    text
    for axes in product("xyz", repeat=3)
    if axes[0] != axes[1] != axes[2]
    for text in ("".join(axes), "".join(axes).upper())
]


def close(found, expected, units=8.0) -> None:
    """Rows agree to some units of the last place of their largest number."""
    scale = np.abs(expected).max(-1, keepdims=True)
    assert (np.abs(found - expected) <= units * 2.0**-53 * scale).all()


# -- quaternions -------------------------------------------------------------------------------------------


def test_quaternions_and_positions_come_back() -> None:
    x = poses.from_quaternion(Q, P)
    np.testing.assert_array_equal(poses.to_quaternion(x), Q)
    close(poses.position(x), P)
    exact = [[float(v) for v in oracle.position(oracle.exact(row))] for row in NUMBERS]
    close(P, np.array(exact))


def test_the_real_part_is_first_unless_it_is_said() -> None:
    turn = poses.from_quaternion([np.cos(0.1), 0, 0, np.sin(0.1)])
    np.testing.assert_allclose(poses.to_euler(turn, "xyz"), [0, 0, 0.2])
    last = poses.to_quaternion(turn, "xyzw")
    np.testing.assert_array_equal(last, [0, 0, np.sin(0.1), np.cos(0.1)])
    np.testing.assert_array_equal(poses.from_quaternion(last, order="xyzw").values, turn.values)
    np.testing.assert_allclose(poses.to_matrix(turn)[:3, :3], Rotation.from_quat(last).as_matrix(), atol=1e-15)


def test_signs_are_kept_and_canonical_ones_are_positive() -> None:
    np.testing.assert_array_equal(poses.to_quaternion(poses.from_quaternion(-Q)), -Q)
    rotations = Rotation.from_quat(np.roll(Q, -1, -1))
    found = poses.to_quaternion(poses.from_quaternion(-Q), canonical=True)
    np.testing.assert_allclose(found, np.roll(rotations.as_quat(canonical=True), 1, -1), atol=1e-15)
    half_turns = [[0, -1.0, 0, 0], [0, 0, -0.6, 0.8]]
    np.testing.assert_array_equal(
        poses.to_quaternion(poses.from_quaternion(half_turns), canonical=True), -np.array(half_turns)
    )


@pytest.mark.parametrize("size", [1e-200, 1e-3, 7.0, 1e200])
def test_quaternions_of_any_length(size) -> None:
    close(poses.to_quaternion(poses.from_quaternion(size * Q, P, normalize=True)), Q)
    close(poses.position(poses.from_quaternion(size * Q, P, normalize=True)), P)


def test_quaternions_that_are_unit_to_rounding_are_made_unit() -> None:
    x = poses.from_quaternion(Q * (1 + 4e-13))
    assert np.abs(np.linalg.norm(poses.to_quaternion(x), axis=-1) - 1).max() <= 4e-16


@pytest.mark.parametrize("order", ["wxyz", "xyzw"])
def test_dual_quaternions(order) -> None:
    numbers = poses.to_dual_quaternion(X, order)
    if order == "xyzw":
        numbers_first = np.roll(numbers.reshape(-1, 2, 4), 1, -1).reshape(-1, 8)
        np.testing.assert_array_equal(numbers_first, NUMBERS)
    back = poses.from_dual_quaternion(numbers, order)
    close(poses.to_dual_quaternion(back)[:, :4], NUMBERS[:, :4])
    close(poses.to_dual_quaternion(back)[:, 4:], NUMBERS[:, 4:])
    scaled = poses.from_dual_quaternion(5 * numbers, order, normalize=True)
    np.testing.assert_allclose(poses.to_matrix(scaled), poses.to_matrix(X), rtol=1e-14, atol=1e-14 * np.abs(P).max())


# -- matrices ----------------------------------------------------------------------------------------------


def test_matrices_against_fifty_digits() -> None:
    expected = np.array([[[float(v) for v in line] for line in oracle.matrix(oracle.exact(row))] for row in NUMBERS])
    found = poses.to_matrix(X)
    assert np.abs(found[:, :3, :3] - expected[:, :3, :3]).max() <= 4 * 2.0**-53
    close(found[:, :3, 3], expected[:, :3, 3])
    np.testing.assert_array_equal(found[:, 3], np.broadcast_to([0, 0, 0, 1], (len(found), 4)))


def test_matrices_come_back() -> None:
    matrices = poses.to_matrix(X)
    for given in (matrices, matrices[:, :3]):
        x = poses.from_matrix(given)
        assert (poses.to_quaternion(x)[:, 0] >= 0).all()
        sign = np.where((poses.to_quaternion(x) * Q).sum(-1) < 0, -1, 1)[:, None]
        close(sign * poses.to_quaternion(x), Q)
        np.testing.assert_array_equal(poses.position(poses.from_matrix(given[0])), given[0, :3, 3])
    assert not poses.position(poses.from_matrix(matrices[:, :3, :3])).any()


def test_the_nearest_rotation_and_how_far_it_was() -> None:
    """The orthogonal factor of the polar decomposition, as singular values have it."""
    matrices = poses.to_matrix(X[:8])
    matrices[:, :3, 3] = RNG.normal(size=(8, 3))
    noisy = matrices.copy()
    noisy[:, :3, :3] += (
        RNG.normal(size=(8, 3, 3)) * np.array([1e-9, 1e-6, 1e-3, 0.01, 0.03, 0.1, 0.2, 0.3])[:, None, None]
    )
    u, _, v = np.linalg.svd(noisy[:, :3, :3])
    x = poses.from_matrix(noisy, tolerance=0.99)
    np.testing.assert_allclose(poses.to_matrix(x)[:, :3, :3], u @ v, atol=3e-15)
    np.testing.assert_allclose(x.deviation, np.abs(u @ v - noisy[:, :3, :3]).max((-1, -2)), atol=1e-14)
    limited = poses.from_matrix(noisy, tolerance=1e-2, strict=False)
    np.testing.assert_array_equal(limited.status == Status.OK, x.deviation <= 1e-2)
    assert np.isnan(limited.values[-1]).all()


def test_the_nearest_rotation_is_far_away_where_it_may_be() -> None:
    """Stretched by 4 along one axis, and by 1/4 along another."""
    q, _ = np.linalg.qr(RNG.normal(size=(3, 3)))
    q *= np.linalg.det(q)
    x = poses.from_matrix(q @ np.diag([4.0, 1.0, 0.25]), tolerance=0.999, strict=False)
    assert x.status == Status.INVALID and x.deviation > 0.9
    np.testing.assert_allclose(x.deviation, np.abs(q @ np.diag([3.0, 0, 0.75])).max(), rtol=1e-12)


# -- rotation vectors --------------------------------------------------------------------------------------


def test_rotation_vectors_come_back() -> None:
    x = poses.from_rotation_vector(ROWS[:, :3], P)
    close(poses.to_rotation_vector(x), ROWS[:, :3], 32)
    np.testing.assert_array_equal(poses.to_rotation_vector(X), poses.log(X)[:, :3])


def test_rotation_vectors_are_those_of_scipy() -> None:
    rotations = Rotation.from_rotvec(ROWS[:, :3])
    x = poses.from_rotation_vector(ROWS[:, :3])
    np.testing.assert_allclose(poses.to_matrix(x)[:, :3, :3], rotations.as_matrix(), atol=2e-15)
    usual = np.linalg.norm(ROWS[:, :3], axis=-1) < 3
    found = poses.to_rotation_vector(x, shortest=True)
    np.testing.assert_allclose(found[usual], rotations.as_rotvec()[usual], atol=1e-15)
    assert (np.linalg.norm(found, axis=-1) <= np.pi + 1e-15).all()


# -- Euler angles ------------------------------------------------------------------------------------------

ANGLES = RNG.uniform(-np.pi, np.pi, (40, 3))


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_are_those_of_scipy(sequence) -> None:
    x = poses.from_euler(sequence, ANGLES, P[0])
    rotations = Rotation.from_euler(sequence, ANGLES)
    np.testing.assert_allclose(poses.to_matrix(x)[:, :3, :3], rotations.as_matrix(), atol=2e-15)
    found = poses.to_euler(x, sequence)
    np.testing.assert_allclose(found, rotations.as_euler(sequence), atol=1e-12)
    np.testing.assert_allclose(poses.to_euler(x, sequence, degrees=True), np.rad2deg(found))
    again = poses.from_euler(sequence, np.rad2deg(found), degrees=True)
    np.testing.assert_allclose(poses.to_matrix(again)[:, :3, :3], rotations.as_matrix(), atol=4e-15)


@pytest.mark.parametrize("sequence", SEQUENCES)
@pytest.mark.parametrize("off", [0.0, 1e-16, 1e-13, 1e-8])
def test_euler_angles_at_and_next_to_gimbal_lock_make_the_rotation(sequence, off) -> None:
    locks = (0, np.pi) if sequence[0] == sequence[2] else (np.pi / 2, -np.pi / 2)
    for lock in locks:
        x = poses.from_euler(sequence, [0.3, lock + off, 0.5])
        angles, status = poses.to_euler(x, sequence, status=True)
        made = poses.from_euler(sequence, angles)
        assert np.abs(poses.to_matrix(made) - poses.to_matrix(x)).max() <= 1e-15
        if off <= 1e-16:
            assert status == Status.NOT_UNIQUE and angles[2] == 0
        elif off == 1e-8:
            assert status == Status.OK


@pytest.mark.parametrize("sequence", ["x", "Z", "yz", "XY"])
def test_one_or_two_axes(sequence) -> None:
    angles = ANGLES[:, : len(sequence)]
    expected = Rotation.from_euler(sequence, angles).as_matrix()
    np.testing.assert_allclose(poses.to_matrix(poses.from_euler(sequence, angles))[:, :3, :3], expected, atol=2e-15)
    if len(sequence) == 1:
        one = poses.from_euler(sequence, angles[:, 0])
        np.testing.assert_allclose(poses.to_matrix(one)[:, :3, :3], expected, atol=2e-15)


def test_small_euler_angles_keep_their_digits() -> None:
    angles = np.array([3e-16, -2e-13, 5e-15])
    np.testing.assert_allclose(poses.to_euler(poses.from_euler("xyz", angles), "xyz"), angles, rtol=1e-14)


# -- what poses do -----------------------------------------------------------------------------------------


def test_products_inverses_and_images() -> None:
    x, y = poses.exp(twists(6, 8) % 3), poses.exp(twists(6, 9) % 3)
    a, b = poses.to_matrix(x), poses.to_matrix(y)
    np.testing.assert_allclose(poses.to_matrix(poses.compose(x, y)), a @ b, atol=1e-14)
    np.testing.assert_allclose(poses.to_matrix(poses.compose(x, y, x)), a @ b @ a, atol=4e-14)
    np.testing.assert_allclose(poses.to_matrix(poses.inverse(x)), np.linalg.inv(a), atol=4e-15)
    points = RNG.normal(size=(6, 3))
    expected = np.einsum("nij,nj->ni", a[:, :3, :3], points)
    np.testing.assert_allclose(poses.rotate(x, points), expected, atol=4e-15)
    np.testing.assert_allclose(poses.act(x, points), expected + a[:, :3, 3], atol=4e-15)
    assert poses.act(x[0], points).shape == (6, 3) and poses.act(x[:, None], points).shape == (6, 6, 3)
    np.testing.assert_array_equal(poses.to_matrix(poses.identity()), np.eye(4))


def test_batches_broadcast_and_single_precision_stays() -> None:
    q = Q[:6].reshape(2, 3, 4)
    x = poses.from_quaternion(q, np.zeros(3))
    assert x.shape == (2, 3) and poses.to_matrix(x).shape == (2, 3, 4, 4)
    single = poses.from_quaternion(np.float32([1, 0, 0, 0]), np.float32([1, 2, 3]))
    assert single.dtype == np.float32 and poses.to_matrix(single).dtype == np.float32
    assert poses.exp(np.zeros((0, 6))).shape == (0,) and poses.log(poses.exp(np.zeros((0, 6)))).shape == (0, 6)


def test_motors_of_every_kind_are_poses() -> None:
    from bladesmith import pga3d

    np.testing.assert_allclose(poses.position(pga3d.translator((1, 2, 3))), (1, 2, 3))
    np.testing.assert_allclose(poses.to_quaternion(pga3d.rotor((0, 0, 1), 0.4)), [np.cos(0.2), 0, 0, np.sin(0.2)])
    conformal = cga3d.translator((1, 2, 3)) * cga3d.rotor((0, 0, 1), 0.4)
    np.testing.assert_allclose(poses.position(poses.from_matrix(conformal.to_matrix())), (1, 2, 3))
