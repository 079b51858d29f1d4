"""Positions and angles of Delta robots against 50-digit geometry; units, precision, targets and batches."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bladesmith as bs
from bladesmith import cga3d as cga
from bladesmith.codegen.algebra.algebra import numbers, scalar_argument
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.errors import InputError
from bladesmith.codegen.formulas.delta import delta as formulas
from bladesmith.kinematics.delta.robot import DeltaRobot

from ...oracles.delta_robots import (
    LENGTHS,
    USUAL,
    as_floats,
    centers,
    exact,
    forward_exact,
    inverse_exact,
    modes,
    poses,
)

pytestmark = pytest.mark.filterwarnings("error")


@pytest.mark.parametrize("lengths", LENGTHS)
def test_both_ways_to_50_digits(lengths):
    """Inverse and forward kinematics within 1e-13, or the error that the arguments' own rounding makes."""
    robot = DeltaRobot(*lengths)
    theta, y = poses(robot, 25)
    bend = np.abs(robot.singularity(theta).sines).min(-1)
    hold = np.abs(robot.singularity(theta).volume)
    size = robot.upper_arm + robot.forearm
    for i in range(len(theta)):
        truth = as_floats(forward_exact(robot, exact(theta[i])))
        assert np.abs(y[i] - truth).max() < 2e-14 * size / hold[i]
        angles = as_floats(inverse_exact(robot, y[i], modes(robot, theta[i], y[i])))
        words = tuple("outer" if s > 0 else "inner" for s in modes(robot, theta[i], y[i]))
        found = robot.inverse(y[i], elbow=words)
        bound = 2e-14 * size / (bend[i] * min(robot.forearm, robot.upper_arm))
        assert np.abs(np.remainder(found - angles + np.pi, 2 * np.pi) - np.pi).max() < bound


def test_outer_and_far_are_what_they_say():
    """On the e3 side, with the platform below the elbows' plane: further from the axis, and further along e3."""
    rng = np.random.default_rng(3)
    y = np.concatenate([rng.uniform(-0.3, 0.3, (500, 2)), rng.uniform(0.6, 1.2, (500, 1))], 1)
    outer, inner = (USUAL.inverse(y, elbow) for elbow in ("outer", "inner"))
    assert (np.cos(outer) > np.cos(inner)).all()
    theta = rng.uniform(-0.4, 1.0, (500, 3))
    far, near = (USUAL.forward(theta, root) for root in ("far", "near"))
    assert (far[:, 2] > near[:, 2]).all()
    assert np.allclose(USUAL.inverse(far), theta, atol=1e-13)


# -- units, precision, targets ---------------------------------------------------------------------------------


def test_units_do_not_matter():
    """The same bits in all units that are powers of two; the same digits from 1e-6 to 1e3, and 1e-60 to 1e60."""
    theta, y = poses(USUAL, 50, seed=7, spread=0.3)
    for scale in (2.0**-20, 2.0**10):
        robot = DeltaRobot(*(scale * x for x in LENGTHS[0]))
        assert (robot.inverse(scale * y) == USUAL.inverse(y)).all()
        assert (robot.forward(theta) == scale * USUAL.forward(theta)).all()
        assert (robot.forward_jacobian(theta) == scale * USUAL.forward_jacobian(theta)).all()
    for scale in (1e-60, 1e-6, 1e3, 1e60):
        robot = DeltaRobot(*(scale * x for x in LENGTHS[0]))
        assert np.abs(robot.inverse(scale * y) - USUAL.inverse(y)).max() < 1e-12
        assert np.abs(robot.forward(theta) / scale - y).max() < 1e-12
        assert np.abs(robot.inverse_jacobian(scale * y) * scale - USUAL.inverse_jacobian(y)).max() < 1e-10


@pytest.mark.compiles
def test_single_precision():
    theta, y = poses(USUAL, 50, seed=8, spread=0.4)
    found = USUAL.inverse(y.astype(np.float32))
    assert found.dtype == np.float32 and np.abs(found - USUAL.inverse(y)).max() < 1e-5
    good = np.abs(USUAL.singularity(theta).sines).min(-1) > 0.3
    exactly = USUAL.forward_jacobian(theta[good])
    assert np.abs(USUAL.forward_jacobian(theta[good].astype(np.float32)) - exactly).max() < 1e-5
    exactly = USUAL.inverse_jacobian(y[good])
    assert np.abs(USUAL.inverse_jacobian(y[good].astype(np.float32)) - exactly).max() < 1e-4
    small = DeltaRobot(*(1e-6 * x for x in LENGTHS[0])).forward(theta.astype(np.float32))
    assert small.dtype == np.float32 and np.abs(small * 1e6 - y).max() < 1e-5


@pytest.mark.compiles
@pytest.mark.parametrize("name", ["inverse", "forward"])
def test_targets_give_the_same_bits(name):
    """C on vectors, and the same text on NumPy columns."""
    theta, y = poses(USUAL, 101, seed=9)
    row = USUAL.parameters
    operands = {"inverse": [y, row, np.ones(3)], "forward": [theta, row, np.array([0.0, 1.0])]}[name]
    kinds = [numbers(cga, a.shape[-1]) if a.ndim else scalar_argument(cga) for a in operands]
    kernel = KernelFunction(getattr(formulas, name), kinds, None, name, cga)
    compiled, plain = (kernel.on(target)(*operands) for target in ("c", "numpy"))
    assert (compiled[0] == plain[0]).all() and (compiled[1] == plain[1]).all()
    found = getattr(USUAL, name)(operands[0])
    assert np.abs(found - compiled[0]).max() < 1e-13


def test_batches_of_any_shape_and_threads():
    theta, y = poses(USUAL, 60, seed=10)
    grid = y.reshape(3, 4, 5, 3)
    assert (USUAL.inverse(grid) == USUAL.inverse(y).reshape(grid.shape)).all()
    assert USUAL.forward_jacobian(theta.reshape(12, 5, 3)).shape == (12, 5, 3, 3)
    assert USUAL.inverse(np.zeros((0, 3))).shape == (0, 3)
    assert USUAL.inverse_jacobian(np.zeros((0, 3)), "screw").shape == (0, 3, 3)
    many = np.tile(y, (2000, 1))
    assert (USUAL.inverse(many, threads=2) == USUAL.inverse(many, threads=1)).all()
    assert (USUAL.inverse(many, threads=2)[-60:] == USUAL.inverse(y)).all()
    with pytest.raises(InputError, match="threads"):
        USUAL.inverse(y, threads=0)


# -- properties ------------------------------------------------------------------------------------------------

length = st.floats(0.1, 2.0)
angle = st.floats(-np.pi, np.pi)


@settings(max_examples=60, deadline=None)
@given(st.tuples(length, length, length, length), st.tuples(angle, angle, angle))
def test_forward_positions_are_a_forearm_from_all_elbows(lengths, theta):
    """And the inverse, in the posture that it is, is back at the angles: any lengths, any angles, both roots."""
    base, platform, upper, forearm = lengths
    if abs(base - platform) > 0.99 * (upper + forearm):
        return
    robot = DeltaRobot(*lengths)
    theta = np.array(theta)
    for root in ("far", "near"):
        y, status = robot.forward(theta, root, status=True)
        if status != bs.Status.OK:
            continue
        near = robot.singularity(theta, root)
        away = [np.linalg.norm(y - as_floats(a)) for a in centers(robot, exact(theta))]
        assert np.abs(np.array(away) - forearm).max() < 1e-13 / max(abs(near.volume), 1e-6)
        if np.abs(near.sines).min() < 1e-3 or abs(near.volume) < 1e-3:
            continue
        words = tuple("outer" if s > 0 else "inner" for s in modes(robot, theta, y))
        back = robot.inverse(y, words)
        turn = np.remainder(back - theta + np.pi, 2 * np.pi) - np.pi
        assert np.abs(turn).max() < 1e-8
