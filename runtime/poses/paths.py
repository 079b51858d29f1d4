"""Poses between two poses, and means."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..codegen.errors import InputError
from ..common.validation import as_axis, as_choice, finite_array
from ..core.geometry.euclidean import plain
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand, evaluate
from ..dispatch.item_statuses import invalidate_nonfinite
from ..status import Status
from .arguments import Array, algebra, as_pose, as_poses, call, with_strict

#: How poses go from one to another.
PATHS = ("screw", "straight")
#: Columns of a motor that are its rotor.
ROTATION = [0, 4, 5, 6]
#: Steps of a mean: each leaves about the cube of the spread.
STEPS = 64
#: Steps of a mean below this, in radians and relative to the largest position, that hardly become less are rounding.
SMALL, HARDLY = 1e-3, 0.9


def interpolate(x: Multivector, y: Multivector, t: Any, path: str = "screw", strict: bool = False) -> Multivector:
    """Poses on the shortest way from x (t = 0) to y (t = 1).

    Parameters
    ----------
    x, y : Multivector, shapes broadcasting to (...)
    t : array (...)
        Also outside [0, 1]: the motion goes on.
    path : "screw" or "straight"
        The geodesic of the group: the screw motion with a constant twist, log(x^-1 y) in the body's frame. Or the same
        rotation, while the origin of the body's frame goes straight on.
    strict : bool
        Raise `SingularError` for the first item without an answer.

    Returns
    -------
    Multivector, shape (...)
        `NOT_UNIQUE`: the poses are half a turn apart to rounding, so that there are two ways.
    """
    name = as_choice(path, "path", PATHS)
    for each, which in ((x, "x"), (y, "y")):
        if isinstance(each, Multivector) and 0 not in each.grades:
            raise InputError(
                f"{which} is a {each.kind.name.replace('_', ' ')}, and no pose.",
                remedy="Between objects use objects.interpolate(x, y, alpha=..)",
            )
    poses = as_pose(x), as_pose(y, "y")
    operands = (*poses, ArrayOperand(t, 0, "t"))
    return with_strict(as_poses(call(f"pose_paths.{name}_path", *operands), *poses), strict, "interpolate")


def mean(x: Multivector, weights: Any = None, axis: int = 0, strict: bool = False) -> Multivector:
    """Means of poses along an axis: the m for which the mean of log(m^-1 x) is zero.

    It does not depend on the frames: the mean of a x b is that of x, between a and b. Of two poses it is the one half
    way. There is one where rotations differ from it by less than half a turn, of far less than that only one.

    Parameters
    ----------
    x : Multivector
    weights : array (n,), or broadcasting to the shape of x
        Not negative. Default: all the same.
    axis : int
    strict : bool
        Raise `SingularError` for the first item without an answer.

    Returns
    -------
    Multivector
        `NOT_CONVERGED` and NaN where 64 steps do not lead there. `NOT_UNIQUE`: to rounding, the poses have two
        rotations, half a turn apart, or others are as near to them, as three are a third of a turn apart around an
        axis.
    """
    pose = as_pose(x)
    place = as_axis(axis, pose.shape, "x has the")
    count = pose.shape[place]
    if not count:
        raise InputError(f"x has no items along axis {axis}; a mean needs one at least.")
    fraction = _fractions(weights, pose.shape, place).astype(pose.dtype)
    rows = np.moveaxis(pose._data, place, 0)
    home = algebra()
    items = home.wrap(home.kind("motor"), np.ascontiguousarray(rows))
    with np.errstate(all="ignore"):
        m, before, open_ = _start(items, fraction), np.inf, np.ones(rows.shape[1:-1], bool)
        far = np.abs(call("poses.position", items).value._data).max((0, -1))
        for _ in range(STEPS):
            result = call("pose_paths.relative_twist", m, items)
            step = (fraction[..., None] * result.value).sum(0)
            moved = as_poses(call("pose_paths.moved_by", m, ArrayOperand(step, 6, "the step")))
            m = home.wrap(m.kind, np.where(open_[..., None], moved._data, m._data))  # an item alone takes no more steps
            size = np.fmax(np.abs(step[..., :3]).max(-1), np.abs(step[..., 3:]).max(-1) / far)
            open_ = open_ & ((size >= SMALL) | ((size > 0) & (size <= HARDLY * before)))
            if not open_.any():
                break
            before = size
    m = invalidate_nonfinite(m)
    several = _has_several(items, fraction) if count > 1 else np.zeros_like(open_)
    if open_.any() or several.any():
        status = np.zeros(m.shape, np.uint8) if m._status is None else m._status.copy()
        status[several & (status == Status.OK)] = Status.NOT_UNIQUE
        status[open_] = Status.NOT_CONVERGED
        m = Multivector._make(m._type, np.where(open_[..., None], m.dtype.type(np.nan), m._data), m.shape, status)
    return with_strict(m, strict, "mean")


def _has_several(items: Multivector, fraction: Array) -> Any:
    """Whether the weighted spread of the rotations says nothing of where their mean is: quaternions at right angles."""
    q = items._data[..., ROTATION]
    spread = np.einsum("n...,n...i,n...j->...ij", fraction, q, q)
    largest = np.linalg.eigvalsh(np.where(np.isfinite(spread), spread, 0.0))[..., 2:]
    near = 16 * np.finfo(q.dtype).eps
    several = largest[..., 1] - largest[..., 0] <= near
    return several | _are_half_a_turn_apart(q, fraction > 0, near)


def _are_half_a_turn_apart(q: Array, counts: Any, near: float) -> Any:
    """Whether quaternions (n, ..., 4), those that count, are of two rotations that are half a turn apart."""
    first = np.take_along_axis(q, np.argmax(counts, 0)[None, ..., None], 0)
    from_first = np.abs((q * first).sum(-1))
    others = counts & (from_first <= near)
    second = np.take_along_axis(q, np.argmax(others, 0)[None, ..., None], 0)
    is_one = (from_first >= 1 - near) | (others & (np.abs((q * second).sum(-1)) >= 1 - near))
    return others.any(0) & (is_one | ~counts).all(0)


def _start(items: Multivector, fraction: Array) -> Multivector:
    """The normalized sum of the motors, of signs like that of the first."""
    first = (items._data[:1] * items._data)[..., ROTATION].sum(-1)
    sign = np.where(first < 0, -1.0, 1.0).astype(items.dtype)
    total = ((fraction * sign)[..., None] * items._data).sum(0)
    home = algebra()
    result = evaluate(home, "versors.normalise_flat", home.wrap(home.layout("motor"), total))
    return home.wrap(home.kind("motor"), plain(result.value))


def _fractions(weights: Any, shape: tuple[int, ...], place: int) -> Array:
    """Weights (n, ...) that add up to one."""
    if weights is None:
        weights = np.ones(shape[place])
    w = finite_array(weights, "weights")
    w = w / max(1.0, float(np.abs(w).max(initial=0.0)))  # so that their sum is finite
    if w.ndim == 1 and len(shape) > 1 and w.shape[0] == shape[place]:
        w = w.reshape([-1 if i == place else 1 for i in range(len(shape))])
    try:
        full = np.moveaxis(np.broadcast_to(w, shape), place, 0)
    except ValueError:
        raise InputError(f"weights have shape {w.shape}, which does not broadcast to {shape}.") from None
    total = full.sum(0)
    if (full < 0).any() or not (total > 0).all():
        raise InputError("weights are negative, or all zero for a mean.", remedy="Give weights of 0 and more")
    return np.asarray(full / total)
