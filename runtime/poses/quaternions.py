"""Poses from and to quaternions and dual quaternions. The order of numbers is w, x, y, z unless it is said."""

from __future__ import annotations

import math
import warnings
from typing import Any, Literal, overload

import numpy as np

from ..codegen.errors import InputError
from ..common.validation import as_bool, as_choice, real_array
from ..core.geometry.euclidean import plain
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand
from ..dispatch.item_statuses import array_result, unsigned_zeros
from ..dispatch.multivector_data import Statuses
from .arguments import Array, as_pose, as_poses, call, checked_items, item, row_of, vector

#: Orders of a quaternion's numbers, the real part first or last.
ORDERS = ("wxyz", "xyzw")
#: Quaternions in the other order look so: the last number of each is nearly all of its length.
NEAR_ONE = 0.99


def from_quaternion(
    q: Any,
    position: Any = 0,
    order: str = "wxyz",
    *,
    normalize: bool = False,
    check_order: bool = True,
    strict: bool = True,
) -> Multivector:
    """Poses from unit quaternions and positions.

    Parameters
    ----------
    q : array (..., 4)
        Unit quaternions w + x i + y j + z k: w = cos(angle/2), (x, y, z) = sin(angle/2) axis, counter-clockwise.
    position : array (..., 3), or 0
    order : "wxyz" or "xyzw"
        The real part is first, as here, in Eigen's constructor, MuJoCo and pytransform3d, or last, as in scipy, ROS,
        and files of TUM.
    normalize : bool
        Divide by the length.
    check_order : bool
        Warn where "wxyz" would make all items half turns about e3 to 16 degrees, and "xyzw" next to none.
    strict : bool
        True: raise `InputError` for the first item that is not a pose. False: it is NaN, with a status.

    Returns
    -------
    Multivector, shape (...)
        Motors of the signs of q, which are the same poses as their negatives. `INVALID`: not unit, or not finite;
        `SINGULAR`: zero, with ``normalize``.
    """
    last = _is_last(order)
    values = real_array(q, "q", (..., 4))
    if as_bool(check_order, "check_order") and not last:
        _warn_of_order(values)
    operand = ArrayOperand(np.roll(values, 1, -1) if last else values, 4, "q")
    where = vector(position, "position", values.dtype)
    formula = "poses.pose_of_any_quaternion" if as_bool(normalize, "normalize") else "poses.pose_of_quaternion"
    x = as_poses(call(formula, operand, where))

    def explain(index: tuple[int, ...]) -> InputError:
        return _not_unit(item("q", index), row_of(values, index, 1, x.shape), "quaternion")

    return checked_items(x, strict, {"q": values, "position": where.rows()}, explain)


def _is_last(order: str) -> bool:
    """Return whether the real part is last."""
    return as_choice(order, "order", ORDERS) == "xyzw"


def _warn_of_order(values: Array) -> None:
    if not values.size:
        return
    w, x, y, z = values.reshape(-1, 4)[0].tolist()
    if not z * z > NEAR_ONE**2 * (w * w + x * x + y * y + z * z) or not _has_last_near_one(values):
        return
    warnings.warn(
        f"the last numbers of q are {NEAR_ONE} of its length and more, as if the real part were last: pass "
        "order='xyzw' if it is, or check_order=False if these are half turns about the third axis.",
        stacklevel=3,
    )


def _has_last_near_one(values: Array) -> bool:
    with np.errstate(all="ignore"):
        return bool((np.abs(values[..., 3]) > NEAR_ONE * np.linalg.norm(values, axis=-1)).all())


def _not_unit(name: str, row: Array, what: str) -> InputError:
    size = math.hypot(*row[:4].tolist())
    if size * size == 0:
        return InputError(f"{name} is zero, which is no rotation.", remedy="Remove it, or give the identity, w = 1")
    if what == "dual quaternion" and abs(size - 1) < 1e-12:
        off = float(row[:4] @ row[4:])
        text = f"real and dual part of {name} have the product {off:.3g}; of a unit dual quaternion it is 0."
    else:
        text = f"{name} has length {size:.17g}; a unit {what} is needed."
    return InputError(text, remedy="Pass normalize=True to take the nearest unit one")


@overload
def to_quaternion(
    x: Multivector, order: str = ..., *, canonical: bool = ..., status: Literal[False] = ..., strict: bool = ...
) -> Array: ...
@overload
def to_quaternion(
    x: Multivector, order: str = ..., *, canonical: bool = ..., status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...
def to_quaternion(
    x: Multivector, order: str = "wxyz", *, canonical: bool = False, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Unit quaternions (..., 4) of the rotations of poses; `position` has the rest.

    Parameters
    ----------
    x : Multivector, shape (...)
    order : "wxyz" or "xyzw"
    canonical : bool
        Of the two quaternions of a rotation the one whose first number of w, x, y, z that is not 0 is positive; else
        that with the sign of the motor, so that `from_quaternion` is undone.
    status, strict : bool
        As of `act`.
    """
    pose = as_pose(x)
    q: Array = unsigned_zeros(call("poses.quaternion", pose).value)
    if as_bool(canonical, "canonical"):
        q = unsigned_zeros(q * plain(call("poses.sign_of_quaternion", pose).value))
    return array_result(np.roll(q, -1, -1) if _is_last(order) else q, pose._status, "to_quaternion", status, strict, 1)


def from_dual_quaternion(q: Any, order: str = "wxyz", *, normalize: bool = False, strict: bool = True) -> Multivector:
    """Poses from unit dual quaternions r + d eps.

    Parameters
    ----------
    q : array (..., 8)
        The real part, a rotation, then the dual part d = p r/2, p the position as a quaternion.
    order : "wxyz" or "xyzw"
        Order of each part.
    normalize : bool
        Take the nearest unit dual quaternion: length 1, and r . d = 0.
    strict : bool
        As of `from_quaternion`.

    Returns
    -------
    Multivector, shape (...)
        `INVALID`: not unit, or not finite; `SINGULAR`: no real part, with ``normalize``.
    """
    last = _is_last(order)
    values = real_array(q, "q", (..., 8))
    real_first = _rolled(values, 1) if last else values
    formula = "pose_of_any_dual_quaternion" if as_bool(normalize, "normalize") else "pose_of_dual_quaternion"
    x = as_poses(call(f"poses.{formula}", ArrayOperand(real_first, 8, "q")))

    def explain(index: tuple[int, ...]) -> InputError:
        return _not_unit(item("q", index), row_of(real_first, index, 1, x.shape), "dual quaternion")

    return checked_items(x, strict, {"q": values}, explain)


def _rolled(values: Array, step: int) -> Array:
    parts = values.reshape(*values.shape[:-1], 2, 4)
    return np.roll(parts, step, -1).reshape(values.shape)


@overload
def to_dual_quaternion(
    x: Multivector, order: str = ..., *, status: Literal[False] = ..., strict: bool = ...
) -> Array: ...
@overload
def to_dual_quaternion(
    x: Multivector, order: str = ..., *, status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...
def to_dual_quaternion(
    x: Multivector, order: str = "wxyz", *, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Unit dual quaternions (..., 8) of poses, as `from_dual_quaternion` takes them; options as of `act`."""
    pose = as_pose(x)
    q: Array = unsigned_zeros(call("poses.dual_quaternion", pose).value)
    return array_result(_rolled(q, -1) if _is_last(order) else q, pose._status, "to_dual_quaternion", status, strict, 1)
