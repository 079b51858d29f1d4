"""Adjoints of poses, and Jacobians of the exponential and the logarithm, as matrices on twists (w, v)."""

from __future__ import annotations

from typing import Any, Literal, overload

from ..core.multivector import Multivector
from ..dispatch.item_statuses import array_result
from ..dispatch.multivector_data import Statuses
from .arguments import Array, as_pose, as_twist, call


@overload
def adjoint(x: Multivector, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def adjoint(x: Multivector, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def adjoint(x: Multivector, *, status: bool = False, strict: bool = False) -> Array | tuple[Array, Statuses]:
    """Matrices (..., 6, 6) from twists (w, v) of the body's frame to those of the world: [[R, 0], [p x R, R]].

    Options as of `act`.
    """
    pose = as_pose(x)
    return _matrices("adjoint", call("pose_maps.adjoint_matrix", pose).value, pose._status, status, strict)


def _matrices(name: str, entries: Array, codes: Any, status: bool, strict: bool) -> Array | tuple[Array, Statuses]:
    return array_result(entries.reshape(*entries.shape[:-1], 6, 6), codes, name, status, strict, 2)


@overload
def left_jacobian(twist: Any, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def left_jacobian(twist: Any, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def left_jacobian(twist: Any, *, status: bool = False, strict: bool = False) -> Array | tuple[Array, Statuses]:
    """Matrices J (..., 6, 6) of the exponential's derivative: exp(twist + d) = exp(J d) exp(twist) + O(d^2).

    Parameters
    ----------
    twist : array (..., 6), or Multivector
        As of `exp`.
    status, strict : bool
        As of `act`.
    """
    return _jacobian("left_jacobian", twist, status, strict)


@overload
def right_jacobian(twist: Any, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def right_jacobian(twist: Any, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def right_jacobian(twist: Any, *, status: bool = False, strict: bool = False) -> Array | tuple[Array, Statuses]:
    """The same in the body's frame: exp(twist + d) = exp(twist) exp(J d) + O(d^2)."""
    return _jacobian("right_jacobian", twist, status, strict)


@overload
def inverse_left_jacobian(twist: Any, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def inverse_left_jacobian(twist: Any, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def inverse_left_jacobian(twist: Any, *, status: bool = False, strict: bool = False) -> Array | tuple[Array, Statuses]:
    """Inverses of `left_jacobian`: log(exp(d) exp(twist)) = twist + J^-1 d + O(d^2). `SINGULAR`: full turns.

    Options as of `left_jacobian`.
    """
    return _jacobian("inverse_left_jacobian", twist, status, strict)


@overload
def inverse_right_jacobian(twist: Any, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
@overload
def inverse_right_jacobian(twist: Any, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
def inverse_right_jacobian(twist: Any, *, status: bool = False, strict: bool = False) -> Array | tuple[Array, Statuses]:
    """Inverses of `right_jacobian`: log(exp(twist) exp(d)) = twist + J^-1 d + O(d^2). `SINGULAR`: full turns."""
    return _jacobian("inverse_right_jacobian", twist, status, strict)


def _jacobian(name: str, twist: Any, status: bool, strict: bool) -> Array | tuple[Array, Statuses]:
    result = call(f"pose_jacobians.{name}_matrix", as_twist(twist))
    return _matrices(name, result.value, result.status, status, strict)
