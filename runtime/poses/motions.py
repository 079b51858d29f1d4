"""What poses do: products, inverses, images of points, and the maps between poses and twists."""

from __future__ import annotations

from functools import reduce
from typing import Any, Literal, overload

from ..core.geometry.euclidean import plain
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand
from ..dispatch.item_statuses import array_result, invalidate_nonfinite, merge_statuses
from ..dispatch.multivector_data import Statuses
from .angles import short_way
from .arguments import Array, algebra, as_pose, as_poses, as_twist, call, vector, with_strict


def identity() -> Multivector:
    """The pose that moves nothing."""
    return algebra().translator((0.0, 0.0, 0.0)).as_kind("motor")


def compose(x: Multivector, *others: Multivector, strict: bool = False) -> Multivector:
    """Product x y ... of poses (...): the last one acts first; x takes the frame of y to the world.

    An item of which one factor has no answer is NaN, with its status.
    """
    poses = [as_pose(y, "x" if i == 0 else f"pose {i + 1}") for i, y in enumerate((x, *others))]
    return with_strict(reduce(_product, poses), strict, "compose")


def _product(x: Multivector, y: Multivector) -> Multivector:
    return as_poses(call("poses.composed", x, y), x, y)


def inverse(x: Multivector, strict: bool = False) -> Multivector:
    """Inverse poses (...): from the world's coordinates to those of the body."""
    pose = as_pose(x)
    back = ~pose
    back._status = pose._status
    return with_strict(invalidate_nonfinite(back), strict, "inverse")


@overload
def position(x: Multivector, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def position(x: Multivector, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def position(x: Multivector, *, status: bool = False, strict: bool = False) -> Array | tuple[Array, Statuses]:
    """Positions (..., 3) of poses: images of the origin; options as of `act`."""
    pose = as_pose(x)
    return _vectors("position", "poses.position", pose, None, status, strict)


@overload
def act(x: Multivector, points: Any, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def act(x: Multivector, points: Any, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def act(x: Multivector, points: Any, *, status: bool = False, strict: bool = False) -> Array | tuple[Array, Statuses]:
    """Images (..., 3) of points under poses, item by item.

    Parameters
    ----------
    x : Multivector, shape (...)
        All poses on all points: ``act(x[:, None], points)``.
    points : array (..., 3)
    status : bool
        Return (values, status): `bladesmith.Status` (...), `INVALID` where an operand or the result is not finite.
    strict : bool
        Raise `SingularError` for the first such item.
    """
    pose = as_pose(x)
    operand = vector(points, "points", pose.dtype)
    return _vectors("act", "poses.moved", pose, operand, status, strict)


@overload
def rotate(x: Multivector, vectors: Any, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def rotate(x: Multivector, vectors: Any, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def rotate(
    x: Multivector, vectors: Any, *, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Images (..., 3) of vectors, such as velocities and normals, which have no position; options as of `act`."""
    pose = as_pose(x)
    operand = vector(vectors, "vectors", pose.dtype)
    return _vectors("rotate", "poses.rotated", pose, operand, status, strict)


def _vectors(
    name: str, formula: str, pose: Multivector, operand: ArrayOperand | None, status: bool, strict: bool
) -> Array | tuple[Array, Statuses]:
    operands = [pose] if operand is None else [pose, operand]
    values = plain(call(formula, *operands).value)
    return array_result(values, pose._status, name, status, strict, 1)


# -- exponential and logarithm -----------------------------------------------------------------------------


def exp(twist: Any, strict: bool = False) -> Multivector:
    """Poses that a body reaches in a unit of time from the identity, moving with constant twists.

    Parameters
    ----------
    twist : array (..., 6), or Multivector
        Rows (w, v): angular velocity, and the velocity of the point at the origin; or multivectors as
        `dynamics.twist` makes them, of cga3d too.
    strict : bool
        Raise `SingularError` for the first item that is not finite, instead of `INVALID` and NaN.

    Returns
    -------
    Multivector, shape (...)
        As a matrix the exponential of [[w x, v], [0, 0]]. The motor has the sign of the way: beyond half a turn its
        real part is negative, and `log` gives the same twist back up to a full turn.
    """
    operand = as_twist(twist)
    return with_strict(as_poses(call("pose_maps.exp_pose", operand)), strict, "exp")


@overload
def log(x: Multivector, *, shortest: bool = ..., status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def log(
    x: Multivector, *, shortest: bool = ..., status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...
def log(
    x: Multivector, *, shortest: bool = False, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Twists (..., 6) with exp(twist) = x: rows (w, v).

    Parameters
    ----------
    x : Multivector, shape (...)
    shortest : bool
        True: of x and -x, one pose, that whose angle ``|w|`` is at most pi. False: the angle is in [0, 2 pi), as
        the sign of the motor says; `exp` is undone. A full turn has its axis through the origin along its translation,
        or along e3: `NOT_UNIQUE`.
    status, strict : bool
        As of `act`.
    """
    pose = short_way(as_pose(x), shortest)
    result = call("pose_maps.log_pose", pose)
    codes = merge_statuses(pose._status, result.status)
    return array_result(result.value, codes, "log", status, strict, 1)
