"""Arguments and results of functions of poses: motors of pga3d, twists as rows, statuses and errors."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..common.dtypes import common_precision
from ..common.validation import as_bool, as_instance, check_items, real_array
from ..core.geometry.euclidean import is_origin
from ..core.geometry.motors import motors_from
from ..core.geometry.projective import ProjectiveAlgebra
from ..core.multivector import Multivector
from ..core.registry import stock_algebra
from ..dispatch.formulas import ArrayOperand, FormulaResult, evaluate
from ..dispatch.item_statuses import merge_statuses, raise_first
from ..dispatch.types import Type
from ..status import Status

Array = NDArray[Any]
#: What makes poses, for messages.
MAKERS = "Make it with poses.from_matrix, from_quaternion or another poses.from_.."


def algebra() -> ProjectiveAlgebra:
    """pga3d, whose motors are poses."""
    return cast(ProjectiveAlgebra, stock_algebra("pga3d"))


@cache
def _motor_type(dtype: np.dtype[Any]) -> Type:
    home = algebra()
    return home.type_of(home.kind("motor"), dtype)


def as_pose(x: Any, name: str = "x") -> Multivector:
    """Unit motors of pga3d, from those of cga3d as well.

    Raises
    ------
    InputError, AlgebraMismatchError, GradeError, KindError
        If it is an array, belongs to an algebra without motors of space, or is not a unit motor.
    """
    if isinstance(x, Multivector) and x._type is _motor_type(x._type.dtype):
        return x
    return motors_from(
        as_instance(x, name, Multivector, "a pose, a motor of pga3d or cga3d,", remedy=MAKERS), algebra(), name
    ).as_kind("motor")


def vector(value: Any, name: str, dtype: Any) -> ArrayOperand:
    """Operand of vectors of space (..., 3); 0 is the zero vector."""
    return ArrayOperand(np.zeros(3, dtype) if is_origin(value) else value, algebra().kind("euclidean"), name)


def vectors(*values: tuple[Any, str]) -> list[ArrayOperand]:
    """Operands of vectors in the precision of those that are not 0."""
    dtype = common_precision(*(v for v, _ in values if not is_origin(v)))
    return [vector(v, name, dtype) for v, name in values]


def as_twist(value: Any, name: str = "twist") -> ArrayOperand:
    """Operand of twists (w, v): rows (..., 6), or multivectors as `dynamics.twist` makes them."""
    if isinstance(value, Multivector):
        from ..mechanics.screws import as_screw

        screw = as_screw(value, f"the {name}")
        value = evaluate(screw.algebra, "twists.screw_row", screw).value
    return ArrayOperand(value, 6, name)


def call(formula: str, *operands: Multivector | ArrayOperand) -> FormulaResult:
    """Results of a formula of poses."""
    return evaluate(algebra(), formula, *operands)


def as_poses(result: FormulaResult, *operands: Multivector | ArrayOperand) -> Multivector:
    """Motors that a formula made, unit by mathematics; statuses of operands that are poses come first."""
    value: Multivector = result.value
    known = [x._status for x in operands if isinstance(x, Multivector) and x._status is not None]
    status = merge_statuses(*known, result.status) if known else result.status
    if status is not None and status.shape != value.shape:
        status = np.broadcast_to(status, value.shape).copy()
    return Multivector._make(_motor_type(value.dtype), value._data, value.shape, status)


def with_strict(x: Multivector, strict: bool, name: str) -> Multivector:
    """x, or an error for its first item without an answer."""
    if as_bool(strict, "strict"):
        raise_first(x._status, name)
    return x


def checked_items(
    x: Multivector, strict: bool, arrays: dict[str, Array], explain: Callable[[tuple[int, ...]], InputError]
) -> Multivector:
    """Poses made of user's numbers; with ``strict`` an `InputError` for the first item that is not a pose.

    Parameters
    ----------
    arrays : dict
        The numbers, by the names of arguments: what is not finite is reported with its index.
    explain : callable
        Makes the error for the index of an item that is finite.
    """
    if not as_bool(strict, "strict") or x._status is None or not x._status.any():
        return x
    for name, array in arrays.items():
        check_items(np.isfinite(array), array, name, "a finite number")
    bad = (x._status != Status.OK) & (x._status != Status.NOT_UNIQUE)
    if bad.any():
        raise explain(tuple(int(i) for i in np.argwhere(bad)[0]) if bad.ndim else ())
    return x


def item(name: str, index: tuple[int, ...]) -> str:
    """Name of an item of an argument, as in ``q[3]``."""
    return f"{name}[{', '.join(map(str, index))}]" if index else name


def row_of(array: Array, index: tuple[int, ...], ndim: int, lead: tuple[int, ...]) -> Array:
    """The numbers of an item of an array that broadcast to a shape."""
    return np.asarray(np.broadcast_to(array, (*lead, *array.shape[array.ndim - ndim :]))[index])


def rows(operand: ArrayOperand) -> Array:
    """The checked array of an operand."""
    return real_array(operand.rows(), operand.name)
