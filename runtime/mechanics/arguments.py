"""Arguments of mechanics, kinematics and dynamics, checked: numbers, vectors, names of bodies, multivectors, files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.mismatch import algebra_mismatch
from ..codegen.errors import GradeError, InputError, suggest
from ..common.validation import (
    as_float,
    as_instance,
    check_shape,
    finite_array,
    invalid,
    positive_float,
)
from ..core.multivector import Multivector

if TYPE_CHECKING:
    from ..core.multivector import Algebra

Array = NDArray[Any]
#: The Earth's, where the third axis points up: m/s^2.
GRAVITY = (0.0, 0.0, -9.81)
#: Largest number: squares and cubes of larger ones overflow.
LARGEST = 1e60
#: Shortest length: squares and cubes of shorter ones underflow.
SHORTEST = 1e-60
#: Largest coefficient of an object: squares of larger ones overflow.
LARGEST_COEFFICIENT = 1e100
#: Tolerance for symmetric and orthogonal matrices, which are often read from text.
MATRIX_TOLERANCE = 1e-6


def vectors(value: Any, name: str, remedy: str | None = None) -> Array:
    """Vectors (..., 3); 0 is the zero vector."""
    array = finite_array(value, name)
    if array.ndim == 0 and array == 0:
        return np.zeros(3)
    check_shape(array, name, (..., 3), remedy=remedy)
    return array


def positive_length(value: Any, name: str) -> float:
    """A length whose powers neither overflow nor underflow.

    Raises
    ------
    InputError, ShapeError
        If it is not a positive number, too long or too short.
    """
    return as_float(positive_float(value, name), name, SHORTEST, LARGEST)


def frozen_copy(values: Array) -> Array:
    """Read-only float64 copy of an array."""
    copy = np.array(values, np.float64)
    copy.setflags(write=False)
    return copy


def check_body(value: Any, what: str, world: bool = False) -> None:
    """Check the name or index of a body; None is the world, where ``world`` allows it.

    Raises
    ------
    InputError
        If it is neither.
    """
    if value is None and world:
        return
    if isinstance(value, bool | np.bool_) or not isinstance(value, str | int | np.integer):
        more = ", or None for the world" if world else ""
        raise invalid(value, what, f"the name or the number of a body{more}")


def body_number(value: Any, names: Sequence[str], what: str) -> int:
    """Index of a body by its name or index; -1 for the world.

    Raises
    ------
    InputError
        If there is no such body.
    """
    check_body(value, f"the body of {what}", world=True)
    if value is None:
        return -1
    if isinstance(value, str):
        if value not in names:
            listed = ", ".join(names)
            raise InputError(f"{what}: there is no body {value!r}; there are: {listed}.{suggest(value, names)}")
        return list(names).index(value)
    if not 0 <= value < len(names):
        raise InputError(f"{what}: there is no body {value}; there are {len(names)}, from 0.")
    return int(value)


def multivector_of(x: Any, algebra: Algebra, name: str) -> Multivector:
    """A finite multivector of an algebra, one or a batch.

    Raises
    ------
    InputError, AlgebraMismatchError
        If it is not a multivector, not finite, or of another algebra.
    """
    multivector = as_instance(x, name, Multivector, f"a multivector of {algebra.name}")
    if multivector.algebra is not algebra:
        what = f"{name} belongs to {multivector.algebra.name}, the body to {algebra.name}."
        raise algebra_mismatch(what, multivector, algebra)
    check_coefficients(multivector, name)
    return multivector


def check_coefficients(x: Multivector, name: str) -> None:
    """Check that a multivector is finite.

    Raises
    ------
    InputError
        If a coefficient is not finite: which, of which item.
    """
    finite = np.isfinite(x.values)
    if finite.all():
        return
    *item, i = np.argwhere(~finite)[0]
    value, blade = x.values[(*item, i)], x.algebra.blade_name(x.kind.blades[i])
    item_text = f" of item {', '.join(map(str, item))}" if item else ""
    raise InputError(f"{name} is not finite: its coefficient of {blade}{item_text} is {value}.")


def coefficients(x: Multivector, kind: str, name: str) -> Array:
    """Coefficients (..., k) on the blades of a kind.

    Raises
    ------
    GradeError
        If x has other blades.
    """
    target, values = x.algebra.kind(kind), np.asarray(x.values, np.float64)
    result = np.zeros((*x.shape, target.size))
    for i, blade in enumerate(x.kind.blades):
        if blade in target.blades:
            result[..., target.blades.index(blade)] = values[..., i]
        elif np.any(values[..., i]):
            names = ", ".join(map(x.algebra.blade_name, target.blades))
            raise GradeError(f"{name} has {x.algebra.blade_name(blade)}; the blades of a {kind} are: {names}.")
    return result
