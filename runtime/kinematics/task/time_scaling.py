"""Paths of joints in the least time that limits of speeds and accelerations allow.

Along q(s), with x = s'^2 and u = s'' constant from one point of a grid to the next, limits are linear: a pass
backwards finds the largest x from which the end can still be reached at rest, a pass forwards takes the largest u that
stays below (reachability analysis: H. Pham and Q.-C. Pham, IEEE Transactions on Robotics 34(3), 2018).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError, ShapeError
from ...common.validation import as_int, finite_array, positive_array, real_array

Array = NDArray[Any]
#: Of longer paths there are no squares.
MAX_LENGTH = 1e150
#: Points of the grid for each point of the path at least, and in all.
BETWEEN, GRID = 40, 400
#: Samples of each interval of the grid by which limits are checked.
CHECKS = 8
#: Largest number of joints.
MOST = 4096


@dataclass(frozen=True, eq=False)
class TimedPath:
    """A path of joints over time, at rest at both ends. A call gives coordinates (..., k) at times (...).

    Attributes
    ----------
    duration : float
    times : array (m,)
        Of the grid.
    curve : scipy.interpolate.BSpline
        Coordinates by length along the path.
    lengths, rates : array (m,)
        Length s along the path and ds/dt on the grid; from one point to the next the second derivative is constant.
    """

    duration: float
    times: Array
    curve: Callable[..., Array]
    lengths: Array
    rates: Array

    def __call__(self, t: ArrayLike) -> Array:
        """Coordinates (..., k) at times (...); before and behind the motion those of its ends."""
        return np.asarray(self.curve(self._along(t)[0]))

    def speeds(self, t: ArrayLike) -> Array:
        """Speeds (..., k)."""
        s, rate, _ = self._along(t)
        return np.asarray(self.curve(s, 1) * rate[..., None])

    def accelerations(self, t: ArrayLike) -> Array:
        """Accelerations (..., k), which jump from one value within the limits to another."""
        s, rate, push = self._along(t)
        return np.asarray(self.curve(s, 2) * (rate**2)[..., None] + self.curve(s, 1) * push[..., None])

    def _along(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Length, its rate and second derivative at times."""
        times = np.asarray(real_array(t, "t"), np.float64)
        if not np.isfinite(times).all():
            raise InputError("the times are not finite.")
        inside = (times >= 0) & (times <= self.duration)
        clipped = np.clip(times, 0.0, self.duration)
        i = np.clip(np.searchsorted(self.times, clipped, "right") - 1, 0, len(self.times) - 2)
        push = np.diff(self.rates) / np.diff(self.times)
        ahead = clipped - self.times[i]
        rate = self.rates[i] + push[i] * ahead
        s = self.lengths[i] + (self.rates[i] + push[i] * ahead / 2) * ahead
        return s, np.where(inside, rate, 0.0), np.where(inside, push[i], 0.0)


def time_optimal(
    points: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike, *, samples: int | None = None
) -> TimedPath:
    """The fastest motion along a path of joints, from rest to rest, within limits of speeds and accelerations.

    The path is the cubic spline through the points (a straight line through two), by the length between them: it is in
    general not straight from point to point. Jerk is not limited.

    Parameters
    ----------
    points : array (n, k)
        Coordinates of k joints; n is 2 or more.
    speeds, accelerations : array (k,) or float
        Largest absolute values, positive.
    samples : int, optional
        Intervals of the grid, about; default: 400, or 40 for each point. Limits are kept to 1e-4 at all times: where
        they would not be between points of the grid, all is slower by that.

    Returns
    -------
    TimedPath

    Raises
    ------
    InputError, ShapeError
        If there are fewer than two points, two in a row are equal, numbers are not finite, or limits are not positive.

    Notes
    -----
    Where a joint stands still along the path, limits are on its second derivative alone; at such points and elsewhere
    the grid's linear constraints hold at both ends of each interval, as in Pham and Pham's collocation.
    """
    from scipy.interpolate import make_interp_spline

    q = finite_array(points, "points")
    if q.ndim != 2 or len(q) < 2 or not 0 < q.shape[1] <= MOST:
        raise ShapeError(f"points have shape {q.shape}; two or more (k,) are needed.")
    fast, hard = _bounds(speeds, "speeds", q.shape[1]), _bounds(accelerations, "accelerations", q.shape[1])
    with np.errstate(over="ignore"):
        legs = np.linalg.norm(np.diff(q, axis=0), axis=1)
    if not (legs > 0).all():
        i = int(np.argmin(legs))
        raise InputError(f"points {i} and {i + 1} are equal.", remedy="Leave one of them out, or make two paths")
    knots = np.concatenate([[0.0], np.cumsum(legs)])
    if not knots[-1] < MAX_LENGTH:
        raise InputError("the path is longer than numbers are.", remedy="Give angles in radians, and lengths in meters")
    curve = make_interp_spline(knots, q, k=min(3, len(q) - 1))
    count = max(GRID, BETWEEN * len(q)) if samples is None else as_int(samples, "samples", low=2, high=1_000_000)
    parts = np.maximum(np.round(count * legs / knots[-1]), 2).astype(int)  # points of the path are on the grid
    grid = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(knots, knots[1:], parts, strict=False)]
    lengths = np.concatenate([*grid, knots[-1:]])
    whole = knots[-1]  # by the length as a unit: short paths and long ones are alike
    steps = np.diff(lengths) / whole
    squares = _profile(curve(lengths, 1), whole * curve(lengths, 2), fast / whole, hard / whole, steps)
    rates = whole * np.sqrt(squares)
    times = np.concatenate([[0.0], np.cumsum(2 * np.diff(lengths) / (rates[1:] + rates[:-1]))])
    timed = TimedPath(float(times[-1]), times, curve, lengths, rates)
    slower = _excess(timed, fast, hard)
    return TimedPath(float(times[-1] * slower), times * slower, curve, lengths, rates / slower)


def _bounds(x: ArrayLike, name: str, count: int) -> Array:
    values = np.asarray(positive_array(x, name), np.float64)
    if values.shape not in ((), (count,)):
        raise ShapeError(f"{name} have shape {values.shape}; one number is needed, or {count}.")
    return np.broadcast_to(values, (count,))


def _profile(first: Array, second: Array, speeds: Array, accelerations: Array, steps: Array) -> Array:
    """Squares x (m,) of ds/dt on a grid, from the derivatives (m, k) of the path by s."""
    m = len(first)
    with np.errstate(divide="ignore"):
        most = ((speeds / np.abs(first)) ** 2).min(-1)
    most[[0, -1]] = 0.0
    # a u + b x <= c of both ends of an interval, for both signs; the far end has x + 2 step u
    far = first[1:] + 2 * steps[:, None] * second[1:]
    a = np.concatenate([first[:-1], -first[:-1], far, -far], -1)
    b = np.concatenate([second[:-1], -second[:-1], second[1:], -second[1:]], -1)
    c = np.tile(accelerations, 4)
    largest = np.zeros(m)
    for i in range(m - 2, -1, -1):
        largest[i] = min(most[i], _largest(a[i], b[i], c, steps[i], largest[i + 1]))
    x = np.zeros(m)
    for i in range(m - 1):
        left = c - b[i] * x[i]
        forward = a[i] > 0
        push = (left[forward] / a[i][forward]).min(initial=np.inf)
        x[i + 1] = min(max(x[i] + 2 * steps[i] * push, 0.0), largest[i + 1])
    return x


def _largest(a: Array, b: Array, c: Array, step: float, following: float) -> float:
    """The largest x for which some u obeys a u + b x <= c, and 0 <= x + 2 step u <= following.

    All allow x = u = 0, so that the constraints on u from above and from below cut off large x only.
    """
    size = 2 * step
    a, b, c = np.append(a, [size, -size]), np.append(b, [1.0, -1.0]), np.append(c, [following, 0.0])
    flat = np.abs(a) <= 1e-12 * np.abs(a).max()
    above, below, alone = (a > 0) & ~flat, (a < 0) & ~flat, flat & (b > 0)
    most = float((c[alone] / b[alone]).min(initial=np.inf))
    slope_above, slope_below = b[above] / a[above], b[below] / a[below]
    slope = slope_above[:, None] - slope_below  # of what must not exceed the room
    room = (c[above] / a[above])[:, None] - c[below] / a[below]
    cuts = slope > 0
    return min(most, float((room[cuts] / slope[cuts]).min(initial=np.inf)))


def _excess(timed: TimedPath, speeds: Array, accelerations: Array) -> float:
    """Factor by which time is to be stretched, so that limits are kept between points of the grid, too."""
    parts = np.linspace(0.0, 1.0, CHECKS, endpoint=False)
    t = (timed.times[:-1, None] + np.diff(timed.times)[:, None] * parts).ravel()
    ends = np.nextafter(timed.times[1:], 0.0)  # accelerations before they jump
    t = np.clip(np.concatenate([t, ends]), 0.0, timed.duration)
    fast = (np.abs(timed.speeds(t)) / speeds).max()
    hard = (np.abs(timed.accelerations(t)) / accelerations).max()
    return float(max(fast, np.sqrt(hard)))


__all__ = ["TimedPath", "time_optimal"]
