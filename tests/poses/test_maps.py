"""Exponential, logarithm, adjoint and Jacobians of poses, against power series at 50 digits."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import Status, dynamics, pga3d, poses

from ..oracles.motions import poses as oracle

TURN = 2 * np.pi


def twists(count: int, seed: int) -> np.ndarray:
    """Twists by angles of 1e-16 to 2 pi - 1e-8, near pi too, about any axes, and translations of 1e-9 to 1e9."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(count):
        near_pi = np.pi + rng.choice([-1, 1]) * 10 ** rng.uniform(-16, 0)
        angles = (10 ** rng.uniform(-16, 0.7), rng.uniform(0, TURN), TURN - 10 ** rng.uniform(-8, 0), near_pi)
        axis = rng.normal(size=3)
        axis[rng.integers(3)] *= rng.choice([1, 1e-9, 0])
        axis /= np.linalg.norm(axis)
        direction = rng.normal(size=3) * rng.choice([1, 1e-9]) + axis * rng.choice([0, 1])
        size = 10 ** rng.uniform(-9, 9)
        rows.append([*axis * min(rng.choice(angles), TURN - 1e-8), *direction / np.linalg.norm(direction) * size])
    return np.array(rows)


#: The ends of the ranges, about an axis and about none in particular, along it and across.
EDGES = np.array(
    [
        [*(angle * np.array(axis)), *(size * np.array(direction))]
        for angle in (0.0, 1e-16, 1e-8, 1.5e-8, 1e-4, np.pi, TURN - 1e-8)
        for axis in ((0.0, 0.0, 1.0), (0.36, 0.48, -0.8))
        for size in (1e-9, 1e9)
        for direction in ((0.0, 0.0, 1.0), (0.6, 0.8, 0.0))
    ]
)


def check_exp_and_log(rows: np.ndarray) -> None:
    x = poses.exp(rows)
    numbers = poses.to_dual_quaternion(x)
    back, status = poses.log(x, status=True)
    assert (np.asarray(x.status) == Status.OK).all() and (status == Status.OK).all()
    worst = max(oracle.exp_roundings(t, q) for t, q in zip(rows, numbers, strict=True))
    assert worst <= 4, worst
    worst = max(oracle.log_roundings(q, t) for q, t in zip(numbers, back, strict=True))
    assert worst <= 4, worst


def test_exp_and_log_to_four_roundings() -> None:
    check_exp_and_log(np.concatenate([EDGES[1::9], twists(6, 0)]))


@pytest.mark.slow
def test_exp_and_log_of_many_twists_to_four_roundings() -> None:
    check_exp_and_log(np.concatenate([EDGES, twists(100, 1)]))


def test_the_exponential_is_that_of_the_matrix() -> None:
    """To see the conventions: counter-clockwise about the axis, then along."""
    found = poses.to_matrix(poses.exp([0, 0, np.pi / 2, 1, 0, 0]))
    np.testing.assert_allclose(found[:3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
    np.testing.assert_allclose(found[:3, 3], [2 / np.pi, 2 / np.pi, 0], atol=1e-15)


@pytest.mark.parametrize("options", [{}, {"algebra": pga3d}])
def test_twists_are_those_of_the_dynamics(options) -> None:
    rows = twists(5, 2)
    made = dynamics.twist(rows[:, :3], rows[:, 3:], **options)
    np.testing.assert_array_equal(poses.exp(made).values, poses.exp(rows).values)
    np.testing.assert_array_equal(poses.left_jacobian(made), poses.left_jacobian(rows))


def test_the_shortest_logarithm() -> None:
    x = poses.exp([0, 0, 4.0, 1, 2, 3])
    np.testing.assert_allclose(poses.log(x)[2], 4.0)
    short = poses.log(x, shortest=True)
    np.testing.assert_allclose(short[2], 4.0 - TURN)
    np.testing.assert_allclose(poses.to_matrix(poses.exp(short)), poses.to_matrix(x), atol=1e-14)


def test_a_full_turn_has_any_axis() -> None:
    found, status = poses.log(poses.exp([[0, 0, TURN, 0, 0, 0], [0, 0, 1, 0, 0, 0]]), status=True)
    assert status.tolist() == [Status.NOT_UNIQUE, Status.OK]
    np.testing.assert_allclose(np.linalg.norm(found[0]), TURN)
    assert not poses.log(-poses.identity(), shortest=True).any()


# -- Jacobians ---------------------------------------------------------------------------------------------

JACOBIANS = {
    "left_jacobian": (poses.left_jacobian, poses.inverse_left_jacobian, 1),
    "right_jacobian": (poses.right_jacobian, poses.inverse_right_jacobian, -1),
}


@pytest.mark.parametrize("name", JACOBIANS)
def test_jacobians_against_differences_at_fifty_digits(name) -> None:
    jacobian, inverse, side = JACOBIANS[name]
    rows = np.concatenate([EDGES[[0, 9, 43, 50]], twists(2, 3)])
    made, back = jacobian(rows), inverse(rows)
    for row, found, found_back in zip(rows, made, back, strict=True):
        expected = oracle.left_jacobian([side * x for x in oracle.exact(row)])
        inverted = oracle.MP.inverse(expected)
        for matrix, exact in ((found, expected), (found_back, inverted)):
            exact = np.array(exact.tolist(), float)
            for i, j in ((0, 0), (3, 0), (3, 3)):  # blocks: their sizes differ by that of the translation
                block = (slice(i, i + 3), slice(j, j + 3))
                angle = np.linalg.norm(row[:3])
                worse = 1 + 20 * angle**2 / (TURN - angle) ** 2  # condition of the inverse, next to a full turn
                size = np.abs(exact[block]).max()
                assert np.abs(matrix[block] - exact[block]).max() <= 2e-15 * worse * size
            assert not matrix[:3, 3:].any()


def test_inverse_jacobians_at_a_full_turn_are_singular() -> None:
    rows = [[0, 0, TURN, 1, 2, 3], [0, 0, 1, 1, 2, 3]]
    assert np.isfinite(poses.left_jacobian(rows)).all()
    for function in (poses.inverse_left_jacobian, poses.inverse_right_jacobian):
        found, status = function(rows, status=True)
        assert status.tolist() == [Status.SINGULAR, Status.OK] and np.isnan(found[0]).any()


def test_the_adjoint_takes_twists_of_the_body_to_the_world() -> None:
    x, rows = poses.exp(twists(4, 4) % 3), twists(4, 5) % 2
    moved = poses.compose(x, poses.exp(rows), poses.inverse(x))
    np.testing.assert_allclose(np.einsum("nij,nj->ni", poses.adjoint(x), rows), poses.log(moved), atol=1e-12)
    p, matrix = poses.position(x), poses.to_matrix(x)
    for i in range(4):
        np.testing.assert_allclose(
            poses.adjoint(x)[i, 3:, :3], np.cross(np.eye(3), p[i]) @ matrix[i, :3, :3], atol=1e-13
        )
