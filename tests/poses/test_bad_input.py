"""What is not a pose: errors with the value, its place and a remedy, or statuses where they are requested."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from bladesmith import Status, cga2d, cga3d, pga3d, poses
from bladesmith.errors import AlgebraMismatchError, GradeError, InputError, KindError, ShapeError, SingularError

TURN = poses.to_matrix(poses.from_euler("zyx", [0.1, 0.2, 0.3], (1, 2, 3)))
SHEAR = np.eye(4) + np.diag([0.5, 0, 0], 1)
NAN = np.nan

#: A call, the error, and what its message says.
CALLS = {
    "not unit": (lambda: poses.from_quaternion([1, 1, 0, 0]), InputError, r"q has length 1\.414.*normalize=True"),
    "its place": (lambda: poses.from_quaternion([[1, 0, 0, 0], [2, 0, 0, 0]]), InputError, r"q\[1\] has length 2;"),
    "zero": (lambda: poses.from_quaternion(np.eye(5, 4)), InputError, r"q\[4\] is zero, .*w = 1"),
    "zero, any length": (lambda: poses.from_quaternion([0, 0, 0, 0], normalize=True), InputError, "q is zero"),
    "NaN": (lambda: poses.from_quaternion([[1, 0, NAN, 0]]), InputError, r"q\[0, 2\] is nan; a finite number"),
    "NaN in the position": (
        lambda: poses.from_quaternion([1, 0, 0, 0], [0, NAN, 0]), InputError, r"position\[1\] is nan; a finite",
    ),
    "length beyond squares": (lambda: poses.from_quaternion([1e200, 0, 0, 0]), InputError, r"q has length .*e\+"),
    "times of a spline": (
        lambda: poses.Spline(poses.exp(np.eye(3, 6)), [0, 1e-320, 1]), InputError, "another unit of time",
    ),
    "three numbers": (lambda: poses.from_quaternion([1, 0, 0]), ShapeError, r"q has shape \(3,\); \(..., 4\)"),
    "order": (lambda: poses.from_quaternion([1, 0, 0, 0], order="xwyz"), InputError, "did you mean 'xyzw'"),
    "text": (lambda: poses.from_quaternion("abcd"), InputError, "q is 'abcd'; real numbers"),
    "dual": (lambda: poses.from_dual_quaternion([1, 0, 0, 0, 1, 0, 0, 0]), InputError, "have the product 1; .* is 0"),
    "dual, length": (lambda: poses.from_dual_quaternion([2, 0, 0, 0, 0, 0, 0, 0]), InputError, "q has length 2;"),
    "reflection": (lambda: poses.from_matrix(np.diag([1, 1, -1.0])), InputError, "determinant -1: it is a reflection"),
    "flat": (lambda: poses.from_matrix(np.diag([1, 1, 0.0])), InputError, "determinant 0: it is singular"),
    "reflection, nearest": (lambda: poses.from_matrix(np.diag([1, 1, -1.0]), 0.9), InputError, "it is a reflection"),
    "shear": (lambda: poses.from_matrix([np.eye(4), SHEAR]), InputError, r"of matrix\[1\] .* off by 0\.5\..*shears"),
    "scale": (lambda: poses.from_matrix(2 * np.eye(3)), InputError, "2 times a rotation"),
    "six digits": (lambda: poses.from_matrix(TURN.round(6)), InputError, r"not orthonormal.*Pass tolerance=1e-0[56]"),
    "too far": (lambda: poses.from_matrix(SHEAR, 0.01), InputError, r"off by 0\.5"),
    "transposed": (lambda: poses.from_matrix(TURN.T), InputError, r"last row of matrix.*np\.swapaxes"),
    "matrix, NaN": (lambda: poses.from_matrix(TURN * [1, NAN, 1, 1]), InputError, r"matrix\[0, 1\] is nan"),
    "2 x 2": (lambda: poses.from_matrix(np.eye(2)), ShapeError, r"\(4, 4\), \(3, 4\) or \(3, 3\)"),
    "sequence": (lambda: poses.from_euler("xYz", [1, 2, 3]), InputError, "'xYz', which names no Euler angles"),
    "twice an axis": (lambda: poses.to_euler(poses.identity(), "xxy"), InputError, "no two equal side by side"),
    "two axes": (lambda: poses.to_euler(poses.identity(), "xy"), InputError, "three axes are needed"),
    "two angles": (lambda: poses.from_euler("xyz", [1, 2]), ShapeError, r"angles has shape \(2,\)"),
    "angle": (lambda: poses.from_euler("xyz", [1, 2, np.inf]), InputError, r"angles\[2\] is inf"),
    "overflow": (lambda: poses.from_rotation_vector([1e200, 0, 0]), InputError, "r is too large"),
    "array": (lambda: poses.act(np.eye(4), (0, 0, 0)), InputError, "of pga3d or cga3d, is needed.*from_matrix"),
    "conformal dilator": (lambda: poses.log(cga3d.dilator(2.0)), KindError, "motor"),
    "conformal, not unit": (lambda: poses.log(2 * cga3d.translator((1, 0, 0))), KindError, "motor"),
    "of the plane": (lambda: poses.log(cga2d.translator((1, 0))), AlgebraMismatchError, "cga2d; a motor of pga3d"),
    "a plane": (lambda: poses.act(pga3d.plane((1, 0, 0), 1), (0, 0, 0)), KindError, "motor"),
    "no unit motor": (lambda: poses.inverse(2 * poses.identity()), KindError, "normalized"),
    "second factor": (lambda: poses.compose(poses.identity(), np.eye(4)), InputError, "pose 2 is"),
    "points": (lambda: poses.act(poses.identity(), (1, 2)), ShapeError, "points has shape"),
    "twist": (lambda: poses.exp([1, 2, 3]), ShapeError, r"twist has shape \(3,\)"),
    "no twist": (lambda: poses.exp(poses.identity()), GradeError, "screws are bivectors"),
    "twist, NaN": (lambda: poses.exp([[0] * 6, [NAN] * 6], strict=True), SingularError, "exp: item 1 is INVALID"),
    "batches": (lambda: poses.from_quaternion(np.eye(4)[[0, 0]], np.eye(3)), ShapeError, "do not broadcast"),
}  # fmt: skip


@pytest.mark.parametrize("name", CALLS)
def test_errors_say_what_where_and_what_to_do(name) -> None:
    function, error, text = CALLS[name]
    with pytest.raises(error, match=text):
        function()


def test_statuses_instead_of_errors() -> None:
    x = poses.from_quaternion([[1, 0, 0, 0], [1, 1, 0, 0], [NAN, 0, 0, 0]], strict=False)
    assert x.status.tolist() == [Status.OK, Status.INVALID, Status.INVALID]
    assert np.isnan(x.values[1:]).all() and not np.isnan(x.values[0]).any()
    assert poses.from_quaternion([0, 0, 0, 0], normalize=True, strict=False).status is Status.SINGULAR
    assert poses.from_matrix([np.eye(4), SHEAR], strict=False).status.tolist() == [Status.OK, Status.INVALID]
    assert poses.exp([NAN] * 6).status is Status.INVALID and poses.exp([1e300] * 6).status is Status.INVALID


def test_poses_without_an_answer_stay_so() -> None:
    x = poses.from_quaternion([[1, 0, 0, 0], [1, 1, 0, 0]], strict=False)
    for y in (poses.compose(x, x[0]), poses.compose(x[0], x), poses.inverse(x)):
        assert y.status.tolist() == [Status.OK, Status.INVALID] and np.isnan(y.values[1]).all()
    for function in (poses.to_quaternion, poses.to_matrix, poses.log, poses.adjoint, poses.position,
                     poses.to_dual_quaternion, poses.to_rotation_vector, lambda y, **o: poses.act(y, (1, 2, 3), **o),
                     lambda y, **o: poses.to_euler(y, "xyz", **o)):  # fmt: skip
        values, status = function(x, status=True)
        assert status.tolist() == [Status.OK, Status.INVALID]
        assert np.isfinite(values[0]).all() and np.isnan(values[1]).any()
        with pytest.raises(SingularError, match="item 1 is INVALID"):
            function(x, strict=True)
    values, status = poses.act(x[0], [[1, 2, 3], [NAN, 0, 0]], status=True)
    assert status.tolist() == [Status.OK, Status.INVALID]


def test_quaternions_that_look_like_the_other_order_give_a_hint() -> None:
    nearly_still = np.random.default_rng(0).normal(size=(5, 4)) * 0.03 + (0, 0, 0, 1)
    with pytest.warns(UserWarning, match=r"pass order='xyzw'.*check_order=False"):
        poses.from_quaternion(nearly_still, normalize=True)
    with pytest.warns(UserWarning, match="real part"):
        poses.from_quaternion([0, 0, 0, 1])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        poses.from_quaternion(nearly_still, order="xyzw", normalize=True)
        poses.from_quaternion([0, 0, 0, 1], check_order=False)
        poses.from_quaternion([[0, 0, 0, 1], [1, 0, 0, 0]])
