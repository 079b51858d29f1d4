"""Poses from and to rotation vectors and Euler angles, in radians."""

from __future__ import annotations

from typing import Any, Literal, overload

import numpy as np

from ..codegen.errors import InputError
from ..common.validation import as_bool, as_text, check_shape, real_array
from ..core.geometry.euclidean import plain
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand
from ..dispatch.item_statuses import array_result, merge_statuses, unsigned_zeros
from ..dispatch.multivector_data import Statuses
from .arguments import Array, as_pose, as_poses, call, checked_items, item, vector, vectors


def from_rotation_vector(r: Any, position: Any = 0, *, strict: bool = True) -> Multivector:
    """Poses that rotate about the vectors r (..., 3) by their lengths, counter-clockwise, then move to a position.

    Of all lengths; beyond half a turn the motor is that of the long way, whose rotation vector is r again up to a
    full turn. ``strict`` as of `from_quaternion`.
    """
    operands = vectors((r, "r"), (position, "position"))
    x = as_poses(call("poses.pose_of_rotation_vector", *operands))
    return checked_items(x, strict, {v.name: v.rows() for v in operands}, lambda index: _unusable("r", index))


def _unusable(name: str, index: tuple[int, ...]) -> InputError:
    return InputError(f"{item(name, index)} is too large: its square is not finite.")


@overload
def to_rotation_vector(
    x: Multivector, *, shortest: bool = ..., status: Literal[False] = ..., strict: bool = ...
) -> Array: ...
@overload
def to_rotation_vector(
    x: Multivector, *, shortest: bool = ..., status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...
def to_rotation_vector(
    x: Multivector, *, shortest: bool = False, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Rotation vectors (..., 3) of poses: axis times angle.

    Parameters
    ----------
    x : Multivector, shape (...)
    shortest : bool
        True: the angle is at most pi. False: it is in [0, 2 pi), as the sign of the motor says; a full turn, whose axis
        is any, is one about e3, `NOT_UNIQUE`.
    status, strict : bool
        As of `act`.
    """
    pose = short_way(as_pose(x), shortest)
    result = call("poses.rotation_vector", pose)
    codes = merge_statuses(pose._status, result.status)
    return array_result(unsigned_zeros(plain(result.value)), codes, "to_rotation_vector", status, strict, 1)


def short_way(pose: Multivector, shortest: bool) -> Multivector:
    """The motor of the two of a pose whose angle is at most half a turn, if that is requested."""
    return as_poses(call("poses.shortest", pose), pose) if as_bool(shortest, "shortest") else pose


# -- Euler angles ------------------------------------------------------------------------------------------


def from_euler(
    sequence: str, angles: Any, position: Any = 0, *, degrees: bool = False, strict: bool = True
) -> Multivector:
    """Poses from Euler angles, with the conventions and names of scipy.

    Parameters
    ----------
    sequence : str
        One to three axes, no two equal ones side by side. "xyz": rotations about the axes of the world, first about x
        (extrinsic); "XYZ": about axes that are turned along (intrinsic), so that "XYZ" is "zyx" backwards.
    angles : array (..., number of axes)
        In the order of the sequence; with one axis also (...).
    position : array (..., 3), or 0
    degrees : bool
    strict : bool
        As of `from_quaternion`.
    """
    axes, intrinsic = _axes(sequence)
    values = real_array(angles, "angles")
    if len(axes) == 1 and values.shape[-1:] != (1,):
        values = values[..., None]
    check_shape(values, "angles", (..., len(axes)))
    given = np.zeros((*values.shape[:-1], 3), values.dtype)
    given[..., : len(axes)] = np.deg2rad(values) if as_bool(degrees, "degrees") else values
    three = _three(axes)
    if intrinsic:
        given, three = np.ascontiguousarray(given[..., ::-1]), three[::-1]
    where = vector(position, "position", values.dtype)
    x = as_poses(call("euler_angles.euler_pose", ArrayOperand(given, 3, "angles"), *_vectors(three, values), where))
    arrays = {"angles": values, "position": where.rows()}
    return checked_items(x, strict, arrays, lambda index: _unusable("angles", index))


@overload
def to_euler(
    x: Multivector, sequence: str, *, degrees: bool = ..., status: Literal[False] = ..., strict: bool = ...
) -> Array: ...
@overload
def to_euler(
    x: Multivector, sequence: str, *, degrees: bool = ..., status: Literal[True], strict: bool = ...
) -> tuple[Array, Statuses]: ...
def to_euler(
    x: Multivector, sequence: str, *, degrees: bool = False, status: bool = False, strict: bool = False
) -> Array | tuple[Array, Statuses]:
    """Euler angles (..., 3) of poses in a sequence of three axes, as of `from_euler`.

    The first and the third angle are in [-pi, pi], the second in [-pi/2, pi/2], or in [0, pi] where the first axis is
    the last too. At gimbal lock, where only a sum or a difference of the other two is known, the third angle is 0,
    `NOT_UNIQUE`; next to it the angles are ill-conditioned one by one, but make the rotation to rounding.

    Options as of `act`.
    """
    pose = as_pose(x)
    axes, intrinsic = _axes(sequence)
    if len(axes) != 3:
        raise InputError(f"sequence is {sequence!r}; three axes are needed.", remedy="As in 'xyz' or 'ZYX'")
    # ~R turns backwards, about the negative axes in the reverse order: the third angle of the sequence is free again
    motor = ~pose if intrinsic else pose
    result = call("euler_angles.euler_angles", motor, *_vectors(axes, pose._data, -1.0 if intrinsic else 1.0))
    angles: Array = result.value
    angles = np.rad2deg(angles) if as_bool(degrees, "degrees") else angles
    codes = merge_statuses(pose._status, result.status)
    return array_result(unsigned_zeros(angles), codes, "to_euler", status, strict, 1)


def _axes(sequence: str) -> tuple[str, bool]:
    """Axes in small letters, and whether they turn along."""
    text = as_text(sequence, "sequence")
    axes = text.lower()
    known = 1 <= len(text) <= 3 and set(axes) <= set("xyz") and text in (axes, axes.upper())
    if not known or any(a == b for a, b in zip(axes, axes[1:], strict=False)):
        remedy = "One to three of xyz (axes of the world) or of XYZ (axes that turn along), no two equal side by side"
        raise InputError(f"sequence is {text!r}, which names no Euler angles.", remedy=remedy)
    return axes, text != axes


def _three(axes: str) -> str:
    """Axes made three: those that are added turn by 0."""
    while len(axes) < 3:
        axes += next(a for a in "xyz" if a != axes[-1])
    return axes


def _vectors(axes: str, like: Array, sign: float = 1.0) -> list[ArrayOperand]:
    unit = sign * np.eye(3, dtype=like.dtype)
    return [vector(unit["xyz".index(a)], "axis", like.dtype) for a in axes]
