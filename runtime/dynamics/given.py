"""What users hand to dynamics, checked once: vectors, numbers, objects of the simulation's algebra."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import arrays
from ..codegen.errors import AlgebraMismatchError, GradeError, InputError, ShapeError
from ..multivector import Multivector

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]
#: How far a matrix may be from what it should be: they are often read from text.
MATRIX_TOLERANCE = 1e-6


def finite(value: Any, name: str) -> Array:
    """Numbers, all of them finite.

    Raises
    ------
    InputError
        If one is not: which.
    """
    found = np.asarray(arrays.real(value, name), np.float64)
    if np.isfinite(found).all():
        return found
    bad = np.argwhere(~np.isfinite(found))
    if len(bad):
        place = "" if found.ndim == 0 else f"[{', '.join(map(str, bad[0]))}]"
        raise InputError(f"{name}{place} is {found[tuple(bad[0])]}; a finite number is needed.")
    return found


def vectors(value: Any, name: str) -> Array:
    """Vectors (..., 3); 0 is the zero vector."""
    found = finite(value, name)
    if found.ndim == 0 and found == 0:
        return np.zeros(3)
    if found.shape[-1:] != (3,):
        raise ShapeError(f"{name} has shape {found.shape}; it ends in 3.")
    return found


def positive(value: Any, name: str, zero: bool = False) -> Array:
    """Numbers above zero."""
    found = finite(value, name)
    if (found < 0).any() or not (zero or found.all()):
        bad = np.argwhere(found < 0 if zero else found <= 0)
        place = "" if found.ndim == 0 else f"[{', '.join(map(str, bad[0]))}]"
        least = "zero or more" if zero else "a positive number"
        raise InputError(f"{name}{place} is {found[tuple(bad[0])]}; {least} is needed.")
    return found


def of_algebra(x: Any, algebra: Algebra, name: str) -> Multivector:
    """A multivector of the simulation's algebra, finite, one or a batch.

    Raises
    ------
    InputError, AlgebraMismatchError
        If it is something else.
    """
    if not isinstance(x, Multivector):
        raise InputError(f"{name} is a {type(x).__name__}; a multivector of {algebra.name} is needed.")
    if x.algebra is not algebra:
        raise AlgebraMismatchError(f"{name} belongs to {x.algebra.name}, the body to {algebra.name}.")
    finite(x.values, f"the coefficients of {name}")
    return x


def coefficients(x: Multivector, kind: str, name: str) -> Array:
    """Coefficients (..., k) on the blades of a kind.

    Raises
    ------
    GradeError
        If x has others.
    """
    wanted, values = x.algebra.kind(kind), np.asarray(x.values, np.float64)
    found = np.zeros((*x.shape, wanted.size))
    for i, blade in enumerate(x.kind.blades):
        if blade in wanted.blades:
            found[..., wanted.blades.index(blade)] = values[..., i]
        elif np.any(values[..., i]):
            names = ", ".join(map(x.algebra.blade_name, wanted.blades))
            raise GradeError(f"{name} has {x.algebra.blade_name(blade)}; a {kind} has: {names}.")
    return found
