"""Splines through poses, whose twists are continuous, and by default the rates of their twists too."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import solve_banded

from ..codegen.errors import InputError
from ..common.validation import as_choice, check_shape, finite_array, real_array
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand
from ..dispatch.item_statuses import array_result
from ..status import Status
from .arguments import Array, as_pose, as_poses, as_twist, call
from .jacobians import adjoint

#: What a spline does at its ends: no rate of the twist, or no twist.
ENDS = ("natural", "rest")
#: A parameter outside the times by less than this many rounding units is an end.
ROUNDING = 4
#: Frames of twists.
FRAMES = ("body", "world")


class Spline:
    """A path through poses at times.

    Between two poses it is x exp(xi(t)) with a polynomial xi, of degree 5, or 3 for ``continuity=1``, so that at each
    pose the twist of the body and its rate are the same from both sides. It does not depend on the frames of the world
    or of the body. Positions alone give the cubic spline; equal twists from pose to pose one screw motion.

    Parameters
    ----------
    x : Multivector (n,)
        At least two poses. From each to the next it goes by the smaller angle.
    times : array (n,)
        Increasing.
    velocities : array (n, 6), or Multivector (n,), optional
        Twists (w, v) of the body's frame at the poses. Default: those of a cubic spline of the logarithms.
    continuity : 1 or 2
        Derivatives that are continuous.
    ends : "natural" or "rest"
        Without ``velocities``: no rate of the twist at both ends, or no twist.

    Raises
    ------
    InputError, ShapeError
        Also if neighbours are half a turn apart, so that there are two ways.
    """

    def __init__(
        self, x: Multivector, times: Any, velocities: Any = None, continuity: int = 2, ends: str = "natural"
    ) -> None:
        poses = as_pose(x).astype(np.float64)
        check_shape(poses, "x", ("n",))
        if poses.size < 2:
            raise InputError(f"x has {poses.size} poses; a spline needs two at least.")
        self._poses, self._times = poses, _increasing(times, poses.size)
        if continuity not in (1, 2) or isinstance(continuity, bool):
            raise InputError(f"continuity is {continuity!r}; 1 or 2 is needed.")
        self._length = np.diff(self._times)
        self._twists = _differences(poses)
        end = as_choice(ends, "ends", ENDS)
        with np.errstate(all="ignore"):
            if velocities is None:
                self._velocities = _velocities(self._twists, self._length, end == "rest")
            else:
                operand = as_twist(velocities, "velocities")
                self._velocities = finite_array(operand.rows(), "velocities", (poses.size, 6))
            self._coefficients = self._pieces(continuity)
        if not np.isfinite(self._coefficients).all():
            raise InputError("the times lie too close to each other, or too far: rates between them leave the numbers.",
                             remedy="Choose another unit of time")  # fmt: skip

    @property
    def poses(self) -> Multivector:
        """Poses (n,) that it goes through."""
        return self._poses

    @property
    def times(self) -> Array:
        """Times (n,), read-only."""
        return self._times

    @property
    def velocities(self) -> Array:
        """Twists (n, 6) of the body's frame at the poses."""
        return self._velocities.copy()

    def __call__(self, t: Any) -> Multivector:
        """Poses at times t (...)."""
        index, u = self._places(t)
        return as_poses(call("pose_paths.piece_pose", self._poses[:-1][index], *self._operands(index, u)))

    def velocity(self, t: Any, frame: str = "body") -> Array:
        """Twists (..., 6) at times t (...), of the body's frame, or of the world."""
        return self._derivative("piece_twist", t, frame)

    def acceleration(self, t: Any, frame: str = "body") -> Array:
        """Rates (..., 6) of the twists at times t (...)."""
        return self._derivative("piece_twist_rate", t, frame)

    def _derivative(self, formula: str, t: Any, frame: str) -> Array:
        of_world = as_choice(frame, "frame", FRAMES) == "world"
        index, u = self._places(t)
        length = ArrayOperand(self._length[index], 0, "the step")
        result = call(f"pose_paths.{formula}", *self._operands(index, u), length)
        rows = array_result(result.value, result.status, formula, False, True, 1)
        assert not isinstance(rows, tuple)
        return (adjoint(self(t)) @ rows[..., None])[..., 0] if of_world else rows

    def _operands(self, index: Array, u: Array) -> tuple[ArrayOperand, ArrayOperand]:
        return ArrayOperand(self._coefficients[index], 30, "the piece"), ArrayOperand(u, 0, "t")

    def _places(self, t: Any) -> tuple[Array, Array]:
        """Pieces, and where in them, from 0 to 1."""
        at = np.asarray(real_array(t, "t"), np.float64)
        first, last = self._times[0], self._times[-1]
        room = ROUNDING * np.finfo(float).eps * max(abs(first), abs(last))
        outside = ~((at >= first - room) & (at <= last + room))
        if outside.any():
            raise InputError(f"t is {at[outside].flat[0]}; the spline runs from {first} to {last}.")
        index = np.clip(np.searchsorted(self._times, at, side="right") - 1, 0, len(self._length) - 1)
        return index, np.clip((at - self._times[index]) / self._length[index], 0.0, 1.0)

    def _pieces(self, continuity: int) -> Array:
        """Coefficients (n - 1, 30) of pieces, in their own unit of time."""
        h, d = self._length[:, None], self._twists
        v0, v1 = self._velocities[:-1] * h, self._velocities[1:] * h
        zero = np.zeros_like(d)
        rate1 = _call("end_rates", d, v1, zero)[0]
        cubic2, cubic3 = 3 * d - 2 * v0 - rate1, -2 * d + v0 + rate1
        if continuity == 1:
            return np.concatenate([v0, cubic2, cubic3, zero, zero], -1)
        before = _call("end_acceleration", d, v1, 2 * cubic2 + 6 * cubic3)[0] / h**2
        after = 2 * cubic2 / h**2
        a = np.concatenate([after[:1], (before[:-1] + after[1:]) / 2, before[-1:]])
        rate1, second1 = _call("end_rates", d, v1, a[1:] * h**2)
        c1, c2 = v0, a[:-1] * h**2 / 2
        rest, slope, curve = d - c1 - c2, rate1 - c1 - 2 * c2, second1 - 2 * c2
        c3, c4, c5 = 10 * rest - 4 * slope + curve / 2, -15 * rest + 7 * slope - curve, 6 * rest - 3 * slope + curve / 2
        return np.concatenate([c1, c2, c3, c4, c5], -1)


def _call(formula: str, *rows: Array) -> tuple[Array, ...]:
    return call(f"pose_paths.{formula}", *(ArrayOperand(x, 6, "a twist") for x in rows)).values


def _increasing(times: Any, count: int) -> Array:
    t: Array = finite_array(times, "times", (count,)).copy()
    if not (np.diff(t) > 0).all():
        place = int(np.argmin(np.diff(t) > 0)) + 1
        raise InputError(f"times[{place}] is {t[place]}, after {t[place - 1]}; increasing times are needed.")
    t.flags.writeable = False
    return t


def _differences(poses: Multivector) -> Array:
    """Twists (n - 1, 6) from each pose to the next."""
    result = call("pose_paths.relative_twist", poses[:-1], poses[1:])
    bad = np.zeros(0, np.uint8) if result.status is None else result.status
    if bad.any():
        place = int(np.argmax(bad != Status.OK))
        if bad[place] == Status.NOT_UNIQUE:
            text = f"x[{place + 1}] is half a turn from x[{place}]: there are two ways."
            raise InputError(text, remedy="Put a pose between them")
        raise InputError(f"x[{place}] or x[{place + 1}] is not finite.")
    twists: Array = result.value
    return twists


def _velocities(twists: Array, length: Array, rest: bool) -> Array:
    """Twists at the poses: those of a cubic spline through sums of the differences."""
    h = length[:, None]
    n = len(length) + 1
    matrix, right = np.zeros((3, n)), np.zeros((n, 6))
    inverse, slope = 1 / length, twists / h**2
    matrix[1, :-1] += 2 * inverse
    matrix[1, 1:] += 2 * inverse
    matrix[0, 1:] = matrix[2, :-1] = inverse
    right[:-1] += 3 * slope
    right[1:] += 3 * slope
    if rest:
        matrix[1, [0, -1]], matrix[0, 1], matrix[2, -2] = 1, 0, 0
        right[[0, -1]] = 0
    return np.asarray(solve_banded((1, 1), matrix, right, check_finite=False))
