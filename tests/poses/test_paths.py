"""Poses between poses, means and splines: against 50 digits, cubic splines of scipy, and invariance."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from bladesmith import Status, poses
from bladesmith.errors import InputError, ShapeError, SingularError

from ..oracles.motions import poses as oracle
from .test_maps import twists

RNG = np.random.default_rng(0)


def some(count: int, size: float = 1.0, seed: int = 0):
    return poses.exp(size * np.random.default_rng(seed).normal(size=(count, 6)))


def distance(x, y) -> float:
    return float(np.abs(poses.to_matrix(x) - poses.to_matrix(y)).max())


def rate(at, t, step=1e-5):
    """Twist of the body by differences."""
    change = poses.compose(poses.inverse(at(t - step)), at(t + step))
    return poses.log(change, shortest=True) / (2 * step)


# -- between two poses -------------------------------------------------------------------------------------


def test_screw_motions_against_fifty_digits() -> None:
    rows = twists(20, 11)
    rows = rows[np.linalg.norm(rows[:, :3], axis=-1) < 3.1]
    times = np.linspace(0, 1, len(rows))
    found = poses.to_dual_quaternion(poses.interpolate(poses.identity(), poses.exp(rows), times))
    for row, t, numbers in zip(rows, times, found, strict=True):
        exact = np.array([float(v) for v in oracle.exp([oracle.MP.mpf(float(t)) * x for x in oracle.exact(row)])])
        condition = 1 / (np.pi - np.linalg.norm(row[:3])) + 1
        for part in (slice(0, 4), slice(4, 8)):
            error = np.linalg.norm(numbers[part] - exact[part])
            size = max(np.linalg.norm(exact[part]), np.linalg.norm(row[3:]) * (part.start > 0) * 1e-3)
            assert error <= 32 * 2.0**-53 * condition * size


def test_the_ends_and_beyond() -> None:
    x, y = some(5), some(5, seed=1)
    assert distance(poses.interpolate(x, y, 0.0), x) < 1e-15 and distance(poses.interpolate(x, y, 1.0), y) < 4e-15
    twist = poses.log(poses.compose(poses.inverse(x), y), shortest=True)
    assert distance(poses.interpolate(x, y, 1.5), poses.compose(x, poses.exp(1.5 * twist))) < 4e-15
    assert poses.interpolate(x[0], y[0], np.zeros((3, 2))).shape == (3, 2)
    assert distance(poses.interpolate(x, -y, 0.5), poses.interpolate(x, y, 0.5)) < 1e-15


def test_a_screw_motion_depends_on_no_frame() -> None:
    x, y, a, b = some(3), some(3, seed=1), some(3, seed=2), some(3, seed=3)
    found = poses.interpolate(poses.compose(a, x, b), poses.compose(a, y, b), 0.3)
    assert distance(found, poses.compose(a, poses.interpolate(x, y, 0.3), b)) < 2e-14


def test_the_straight_path() -> None:
    x, y, t = some(1)[0], some(1, seed=1)[0], np.linspace(0, 1, 5)
    found = poses.interpolate(x, y, t, path="straight")
    np.testing.assert_allclose(np.diff(poses.position(found), axis=0, n=2), 0, atol=1e-15)
    screw = poses.interpolate(x, y, t)
    np.testing.assert_allclose(poses.to_quaternion(found), poses.to_quaternion(screw), atol=1e-15)


def test_half_turns_have_two_ways() -> None:
    half = poses.from_quaternion([0, 1, 0, 0], (1, 2, 3))
    for path in ("screw", "straight"):
        x = poses.interpolate(poses.identity(), half, [0.0, 1.0], path)
        assert (x.status == Status.NOT_UNIQUE).all() and distance(x[1], half) < 1e-15
    with pytest.raises(InputError, match="path is 'stright' .did you mean 'straight'"):
        poses.interpolate(half, half, 0.5, "stright")


def test_what_is_not_finite_has_no_path() -> None:
    bad = poses.from_quaternion([[1, 0, 0, 0], [1, 1, 0, 0]], strict=False)
    assert poses.interpolate(bad, bad[0], 0.5).status.tolist() == [Status.OK, Status.INVALID]
    assert poses.interpolate(bad[0], bad[0], [0.5, np.nan]).status.tolist() == [Status.OK, Status.INVALID]
    with pytest.raises(SingularError, match="interpolate: item 1 is INVALID"):
        poses.interpolate(bad, bad[0], 0.5, strict=True)


# -- means -------------------------------------------------------------------------------------------------


def test_twists_from_a_mean_cancel() -> None:
    for spread in (1e-6, 0.6, 1.2):  # the last are turned by more than half a turn from each other
        x, weights = some(30, spread), RNG.uniform(size=30)
        m = poses.mean(x, weights)
        steps = poses.log(poses.compose(poses.inverse(m), x), shortest=True)
        assert np.abs(weights @ steps).max() < 2e-14 * max(spread, 0.01) and m.status == Status.OK


def test_a_mean_depends_on_no_frame_and_no_sign() -> None:
    x, a, b = some(20, 0.6), some(1, seed=5)[0], some(1, seed=6)[0]
    assert distance(poses.mean(poses.compose(a, x, b)), poses.compose(a, poses.mean(x), b)) < 1e-14
    signs = np.where(np.arange(20) % 3, 1.0, -1.0)
    mixed = poses.from_dual_quaternion(signs[:, None] * poses.to_dual_quaternion(x))
    assert distance(poses.mean(mixed), poses.mean(x)) < 1e-14


def test_a_mean_of_near_poses_far_away_converges() -> None:
    """The last steps are rounding of positions, not of the small twists between the poses."""
    way = poses.interpolate(poses.from_quaternion([1, 0, 0, 0], (1, 2, 0.5)), some(1)[0], np.linspace(0, 1e-3, 5))
    assert distance(poses.mean(way), way[2]) < 1e-15
    far = poses.compose(poses.from_quaternion([1, 0, 0, 0], (1e9, 0, 0)), way)
    assert poses.mean(far).status == Status.OK


def test_means_of_two_of_translations_and_of_batches() -> None:
    x = some(2)
    assert distance(poses.mean(x), poses.interpolate(x[0], x[1], 0.5)) < 2e-15
    assert distance(poses.mean(x, [3, 1]), poses.interpolate(x[0], x[1], 0.25)) < 4e-15
    p = RNG.normal(size=(7, 3)) * 1e6
    np.testing.assert_allclose(poses.position(poses.mean(poses.from_quaternion([1, 0, 0, 0], p))), p.mean(0))
    batch = some(12, 0.5).reshape(4, 3)
    for axis in (0, 1, -1):
        rows = np.moveaxis(batch.values, axis, 0)
        found = poses.mean(batch, axis=axis)
        for i in range(found.size):
            one = poses.mean(batch[:, i] if axis == 0 else batch[i])
            assert distance(found[i], one) < 2e-15 and rows.shape[1] == found.size
    weights = np.arange(12.0).reshape(4, 3) + 1
    assert distance(poses.mean(batch, weights, axis=1)[2], poses.mean(batch[2], weights[2])) < 2e-15


def test_means_that_are_not_the_only_ones_say_so() -> None:
    for dtype in (np.float64, np.float32):
        for axis in ((0, 0, 1), (1, 2, 3)):
            turns = np.asarray(axis, dtype) / np.linalg.norm(axis).astype(dtype)
            for angles, weights, status in (
                ((0, np.pi), None, Status.NOT_UNIQUE), ((0, np.pi), [1, 3], Status.NOT_UNIQUE),
                ((0, 2 * np.pi / 3, 4 * np.pi / 3), None, Status.NOT_UNIQUE), ((0, np.pi), [1, 0], Status.OK),
                ((0, 0, np.pi), None, Status.NOT_UNIQUE), ((np.pi, 0, np.pi, np.pi), None, Status.NOT_UNIQUE),
                ((0, np.pi, 1), [1e308, 1e308, 0], Status.NOT_UNIQUE), ((0.2, 0.1), [1e308, 1e308], Status.OK),
                ((0, 3.1), None, Status.OK), ((0, np.pi, 0.1), None, Status.OK), ((0.0,), None, Status.OK),
            ):  # fmt: skip
                x = poses.from_rotation_vector(np.asarray(angles, dtype)[:, None] * turns, (1, 2, 3))
                found = poses.mean(x, weights)
                assert found.status == status and np.isfinite(found.values).all()


def test_means_of_bad_input() -> None:
    x = some(3)
    assert poses.mean(poses.from_quaternion([[1, 0, 0, 0], [1, 1, 0, 0]], strict=False)).status == Status.INVALID
    for call, error, text in (
        (lambda: poses.mean(x, [1, 2]), InputError, r"weights have shape \(2,\)"),
        (lambda: poses.mean(x, [1, -1, 1]), InputError, "weights are negative"),
        (lambda: poses.mean(x, [0, 0, 0]), InputError, "all zero"),
        (lambda: poses.mean(x, [1, np.nan, 1]), InputError, r"weights\[1\] is nan"),
        (lambda: poses.mean(x, axis=1), ShapeError, "without an axis 1"),
        (lambda: poses.mean(x[:0]), InputError, "no items"),
    ):
        with pytest.raises(error, match=text):
            call()


# -- splines -----------------------------------------------------------------------------------------------

TIMES = np.array([0.0, 0.7, 2.0, 2.5, 4.0, 5.5])
INSIDE = np.linspace(0.05, 5.45, 23)


@pytest.mark.parametrize("continuity", [1, 2])
@pytest.mark.parametrize("ends", ["natural", "rest"])
def test_splines_go_through_their_poses_and_their_twists_are_their_rates(continuity, ends) -> None:
    x = some(6, 0.8)
    spline = poses.Spline(x, TIMES, continuity=continuity, ends=ends)
    assert distance(spline(TIMES), x) < 4e-15
    np.testing.assert_allclose(spline.velocity(INSIDE), rate(spline, INSIDE), atol=1e-8)
    np.testing.assert_allclose(spline.velocity(TIMES), spline.velocities, atol=1e-13)
    step = 1e-5
    slope = (spline.velocity(INSIDE + step) - spline.velocity(INSIDE - step)) / (2 * step)
    np.testing.assert_allclose(spline.acceleration(INSIDE), slope, atol=1e-7)
    world = np.einsum("nij,nj->ni", poses.adjoint(spline(INSIDE)), spline.velocity(INSIDE))
    np.testing.assert_allclose(spline.velocity(INSIDE, "world"), world, atol=1e-12)
    if ends == "rest":
        np.testing.assert_allclose(spline.velocity(TIMES[[0, -1]]), 0, atol=1e-13)


@pytest.mark.parametrize("continuity", [1, 2])
def test_twists_are_continuous_and_their_rates_too(continuity) -> None:
    spline = poses.Spline(some(6, 0.8), TIMES, continuity=continuity)
    for t in TIMES[1:-1]:
        before, after = np.nextafter(t, 0), t
        np.testing.assert_allclose(spline.velocity(before), spline.velocity(after), atol=1e-12)
        jump = np.abs(spline.acceleration(before) - spline.acceleration(after)).max()
        assert jump < 1e-11 if continuity == 2 else jump > 1e-3


@pytest.mark.parametrize("continuity", [1, 2])
def test_splines_of_positions_are_cubic(continuity) -> None:
    p = RNG.normal(size=(6, 3))
    x = poses.from_quaternion([1, 0, 0, 0], p)
    for ends, condition in (("natural", "natural"), ("rest", "clamped")):
        spline, cubic = (
            poses.Spline(x, TIMES, continuity=continuity, ends=ends),
            CubicSpline(TIMES, p, bc_type=condition),
        )
        np.testing.assert_allclose(poses.position(spline(INSIDE)), cubic(INSIDE), atol=1e-14)
        np.testing.assert_allclose(spline.velocity(INSIDE)[:, 3:], cubic(INSIDE, 1), atol=1e-13)
        np.testing.assert_allclose(spline.acceleration(INSIDE)[:, 3:], cubic(INSIDE, 2), atol=1e-12)


def test_a_screw_motion_is_its_own_spline_and_frames_do_not_matter() -> None:
    twist = np.array([0.3, -0.2, 0.4, 1.0, 2.0, -0.5])
    spline = poses.Spline(poses.exp(TIMES[:, None] * twist), TIMES)
    np.testing.assert_allclose(spline.velocity(INSIDE), np.broadcast_to(twist, (23, 6)), atol=1e-13)
    np.testing.assert_allclose(spline.acceleration(INSIDE), 0, atol=1e-12)
    x, a, b = some(6, 0.8), some(1, seed=5)[0], some(1, seed=6)[0]
    moved = poses.Spline(poses.compose(a, x, b), TIMES)(INSIDE)
    assert distance(moved, poses.compose(a, poses.Spline(x, TIMES)(INSIDE), b)) < 1e-13


def test_velocities_that_are_given_are_taken() -> None:
    x, v = some(6, 0.8), np.random.default_rng(4).normal(size=(6, 6))
    for continuity in (1, 2):
        spline = poses.Spline(x, TIMES, v, continuity)
        np.testing.assert_allclose(spline.velocity(TIMES), v, atol=1e-11)
        assert distance(spline(TIMES), x) < 2e-14


def test_a_mean_alone_has_the_bits_that_it_has_among_others() -> None:
    """One that takes few steps beside others that take many."""
    x = poses.from_rotation_vector(np.random.default_rng(4).normal(size=(5, 100, 3)))
    many = poses.mean(x)
    for i in range(100):
        np.testing.assert_array_equal(poses.to_dual_quaternion(poses.mean(x[:, i])), poses.to_dual_quaternion(many[i]))


def test_splines_of_bad_input() -> None:
    x = some(3)
    spline = poses.Spline(x, [0, 1, 2])
    assert distance(spline(2 + 1e-16), x[2]) < 1e-14
    half = poses.from_quaternion([[1, 0, 0, 0], [0, 1, 0, 0]])
    bad = poses.from_quaternion([[1, 0, 0, 0], [1, 1, 0, 0]], strict=False)
    for call, error, text in (
        (lambda: poses.Spline(x, [0, 1]), ShapeError, r"times has shape \(2,\)"),
        (lambda: poses.Spline(x, [0, 1, 1]), InputError, r"times\[2\] is 1\.0, after 1\.0; increasing"),
        (lambda: poses.Spline(x[:1], [0]), InputError, "1 poses; a spline needs two"),
        (lambda: poses.Spline(x, [0, 1, 2], continuity=3), InputError, "continuity is 3; 1 or 2"),
        (lambda: poses.Spline(x, [0, 1, 2], np.zeros((2, 6))), ShapeError, "velocities has shape"),
        (lambda: poses.Spline(half, [0, 1]), InputError, r"x\[1\] is half a turn from x\[0\].*Put a pose between"),
        (lambda: poses.Spline(bad, [0, 1]), InputError, r"x\[1\] is not finite"),
        (lambda: spline(2.1), InputError, r"t is 2\.1; the spline runs from 0\.0 to 2\.0"),
        (lambda: spline(np.nan), InputError, "t is nan"),
        (lambda: spline.velocity(1.0, "tool"), InputError, "one of body, world"),
    ):
        with pytest.raises(error, match=text):
            call()
