"""Motions of the Delta robot: angles, speeds and accelerations of its motors while the platform follows a path."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, ShapeError
from ...common.callbacks import GuardedCallback
from ...common.finite_differences import Differences
from ...common.validation import finite_array, real_array
from ...status import Status
from . import evaluation as calls
from . import solutions
from .geometry import DeltaGeometry

if TYPE_CHECKING:
    from ...plot.matplotlib_import import Figure

Array = NDArray[Any]
#: Degree of the spline through sampled points: its accelerations bend smoothly.
DEGREE = 5


class Motion(NamedTuple):
    """A path at some times and the motion of the motors; NaN where the platform cannot be, or an arm is stretched.

    Attributes
    ----------
    time : array (n,)
    position, velocity, acceleration : array (n, 3)
        Of the platform.
    theta, speed, angular_acceleration : array (n, 3)
        Angles of the motors, their speeds and accelerations. The angles go on beyond pi where a motor does.
    status : uint8 array (n,)
        `Status` of each time, as of `DeltaRobot.inverse_jacobian`.
    """

    time: Array
    position: Array
    velocity: Array
    acceleration: Array
    theta: Array
    speed: Array
    angular_acceleration: Array
    status: NDArray[np.uint8]

    @property
    def is_possible(self) -> bool:
        """True if the platform can follow the path at all of its times."""
        return bool((self.status == Status.OK).all())

    def plot(self, path: str | PathLike[str] | None = None, **options: Any) -> Figure:
        """Draw angles, speeds and accelerations of the motors over time."""
        from .plots import curves

        return curves(self, path, **options)

    def __repr__(self) -> str:
        bad = int(np.count_nonzero(self.status))
        times = f"{len(self.time)} times from {self.time[0]:.6g} to {self.time[-1]:.6g}"
        return f"<Motion: {times}, {f'{bad} of them impossible' if bad else 'all possible'}>"


def trajectory(geometry: DeltaGeometry, path: Any, times: Any, elbow: Any) -> Motion:
    """Angles, speeds and accelerations of the motors: see `DeltaRobot.trajectory`."""
    t = _times(times)
    y, dy, ddy = _from_function(path, t) if callable(path) else _from_samples(path, t)
    elbows = solutions.elbow_signs(elbow)
    operands = [y, dy, ddy, geometry.parameters, elbows]
    (theta, speed, acceleration), codes = calls.evaluate("delta_rates.inverse_motion", operands)
    assert codes is not None
    return Motion(t, y, dy, ddy, _unwrap(theta), speed, acceleration, codes)


def _times(times: Any) -> Array:
    t = np.asarray(real_array(times, "times", ("n",)), np.float64)
    if not len(t):
        raise ShapeError("times is empty; at least one is needed.")
    if not np.isfinite(t).all() or (np.diff(t) <= 0).any():
        raise InputError("times are not finite and increasing.")
    return t


def _from_function(path: Callable[..., Any], t: Array) -> tuple[Array, Array, Array]:
    position_at = GuardedCallback(path, "the path", _check)
    first = position_at(float(t[0]))
    if isinstance(first, tuple):
        samples = [first, *(position_at(float(s)) for s in t[1:])]
        y, dy, ddy = (np.array([np.asarray(each[k], np.float64) for each in samples]) for k in range(3))
        return y, dy, ddy
    if len(t) == 1:
        raise InputError("the path gives positions only, and there is one time.", remedy="Return (y, dy, ddy)")

    def position(time: float) -> Array:
        return np.asarray(position_at(float(time)), np.float64)

    smooth = Differences(position, (float(t[0]), float(t[-1])))
    y, dy, ddy = (np.array(x) for x in zip(*(smooth(float(s)) for s in t), strict=True))
    return y, dy, ddy


def _check(value: Any, what: str) -> None:
    parts = value if isinstance(value, tuple) and len(value) == 3 and np.ndim(value[0]) else (value,)
    for each in parts:
        if np.shape(each) != (3,):
            raise ShapeError(f"{what} gives shape {np.shape(each)}; a position (3,), or (y, dy, ddy), is needed.")


def _from_samples(path: Any, t: Array) -> tuple[Array, Array, Array]:
    y = finite_array(path, "path", (len(t), 3))
    if len(t) <= DEGREE:
        raise InputError(f"path has {len(t)} positions; a spline needs {DEGREE + 1}.", remedy="Give a function of time")
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(t, y, k=DEGREE)
    return y, spline(t, 1), spline(t, 2)


def _unwrap(theta: Array) -> Array:
    """Angles without jumps of a full rotation, from each valid state to the next."""
    valid = np.isfinite(theta).all(-1)
    smooth = theta.copy()
    smooth[valid] = np.unwrap(theta[valid], axis=0)
    return smooth


__all__ = ["Motion", "trajectory"]
