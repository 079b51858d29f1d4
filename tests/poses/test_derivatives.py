"""Directional derivatives of functions of poses, against differences, and of exp against those at 50 digits."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import poses
from bladesmith.errors import InputError, ShapeError, SingularError
from bladesmith.poses.derivatives import RULES

from ..oracles.motions import poses as oracle

STEP = 1e-6
CASES = {
    "ordinary": lambda rng: rng.normal(size=6) * 0.9,
    "identity": lambda rng: np.zeros(6),
    "next to the identity": lambda rng: rng.normal(size=6) * 1e-9,
    "half a turn": lambda rng: np.array([0, 0, np.pi, *rng.normal(size=3)]),
    "far away": lambda rng: np.array([*rng.normal(size=3), *(1e3 * rng.normal(size=3))]),
}


def operands(function, case, rng):
    """Arguments and directions."""
    values, along = [], []
    for kind in RULES[function].arguments:
        twist = CASES[case](rng)
        if kind == "twist":
            values.append(twist)
        elif kind == "pose":
            values.append(poses.exp(twist))
        elif kind == "vector":
            values.append(twist[:3] if function is poses.from_rotation_vector and not values else rng.normal(size=3))
        elif kind == 0:
            values.append(0.3)
        else:
            numbers = poses.to_dual_quaternion(poses.exp(twist))
            values.append(numbers[:kind])
        size = {"twist": 6, "pose": 6, "vector": 3}.get(kind, kind)
        along.append(rng.normal(size=size) if size else rng.normal())
    return values, along


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("function", RULES, ids=lambda f: f.__name__)
def test_derivatives_against_differences(function, case) -> None:
    rng = np.random.default_rng(len(case))
    values, along = operands(function, case, rng)
    kinds = RULES[function].arguments
    options = {
        poses.from_quaternion: {"normalize": True, "check_order": False},
        poses.from_dual_quaternion: {"normalize": True},
    }.get(function, {})

    def at(s):
        moved = [
            poses.compose(poses.exp(s * d), v) if kind == "pose" else v + s * d
            for kind, v, d in zip(kinds, values, along, strict=True)
        ]
        return function(*moved, **options)

    after, before = at(STEP), at(-STEP)
    if isinstance(after, np.ndarray):
        expected = (after - before) / (2 * STEP)
    else:
        expected = poses.log(poses.compose(after, poses.inverse(before)), shortest=True) / (2 * STEP)
    found = poses.derivative(function, *values, along=tuple(along))
    scale = max(1.0, np.abs(expected).max())
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, atol=3e-9 * scale * (100 if case == "far away" else 1))


@pytest.mark.parametrize("case", CASES)
def test_the_derivative_of_the_exponential_at_fifty_digits(case) -> None:
    rng = np.random.default_rng(3)
    twist, d = CASES[case](rng), rng.normal(size=6)
    exact = oracle.left_jacobian(oracle.exact(twist)) * oracle.MP.matrix(oracle.exact(d))
    expected = np.array([float(v) for v in exact])
    found = poses.derivative(poses.exp, twist, along=d)
    assert np.abs(found[:3] - expected[:3]).max() <= 1e-15 * np.abs(d).max() * 3
    assert np.abs(found[3:] - expected[3:]).max() <= 3e-15 * max(np.abs(expected[3:]).max(), 1)
    back = poses.derivative(poses.log, poses.exp(twist), along=found)
    np.testing.assert_allclose(back, d, atol=1e-12 * max(1, np.abs(twist).max()))


def test_arguments_that_do_not_vary_and_batches() -> None:
    x, p = poses.exp(np.random.default_rng(0).normal(size=(5, 6))), np.array([1.0, 2.0, 3.0])
    velocity = poses.derivative(poses.act, x, p, along=([0, 0, 1, 0, 0, 0], None))
    np.testing.assert_allclose(velocity, np.cross([0, 0, 1], poses.act(x, p)), atol=1e-15)
    np.testing.assert_array_equal(poses.derivative(poses.act, x, p, along=([0, 0, 1, 0, 0, 0],)), velocity)
    assert poses.derivative(poses.to_matrix, x, along=np.ones(6)).shape == (5, 4, 4)
    still = poses.derivative(poses.from_quaternion, [1.0, 0, 0, 0], along=([0, 1.0, 0, 0],))
    np.testing.assert_allclose(still, [2, 0, 0, 0, 0, 0])


def test_derivatives_of_bad_input() -> None:
    x = poses.identity()
    for call, error, text in (
        (lambda: poses.derivative(poses.mean, x, along=np.ones(6)), InputError, "'mean' has no derivative here; exp, "),
        (lambda: poses.derivative("exp", x, along=np.ones(6)), InputError, "'exp' has no derivative"),
        (lambda: poses.derivative(poses.log, x, x, along=np.ones(6)), InputError, "has 1 arguments"),
        (lambda: poses.derivative(poses.log, x, along=(1, 2)), InputError, "2 directions for the 1 arguments"),
        (lambda: poses.derivative(poses.log, x, along=np.ones(5)), ShapeError, r"along\[0\] has shape"),
        (lambda: poses.derivative(poses.log, np.eye(4), along=np.ones(6)), InputError, "a motor of pga3d"),
    ):
        with pytest.raises(error, match=text):
            call()
    full = poses.exp([0, 0, 2 * np.pi, 0, 0, 0])
    assert np.isnan(poses.derivative(poses.log, full, along=np.ones(6))).all()
    with pytest.raises(SingularError, match="derivative of log: it is SINGULAR"):
        poses.derivative(poses.log, full, along=np.ones(6), strict=True)
