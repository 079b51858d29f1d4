"""What users hand to dynamics, checked once: vectors, numbers, objects of the simulation's algebra."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from reprlib import repr as shortened
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import arrays
from ..codegen.errors import AlgebraMismatchError, GradeError, InputError, ShapeError, suggest
from ..multivector import Multivector

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]
#: Larger numbers have squares and cubes that are none; so have lengths that are shorter.
LARGEST, SHORTEST = 1e60, 1e-60
#: Coefficients of objects beyond this have no squares.
LARGEST_COEFFICIENT = 1e100
#: How far a matrix may be from what it should be: they are often read from text.
MATRIX_TOLERANCE = 1e-6


def finite(value: Any, name: str) -> Array:
    """Numbers, all of them finite.

    Raises
    ------
    InputError
        If one is not: which.
    """
    if isinstance(value, str | bytes | Mapping | None):
        raise InputError(f"{name} is {shown(value)}; real numbers are needed.")
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


def number(value: Any, name: str, zero: bool = False) -> float:
    """One number above zero.

    Raises
    ------
    InputError, ShapeError
        If it is something else, or a list.
    """
    found = finite(value, name)
    if found.ndim:
        raise ShapeError(f"{name} has shape {found.shape}; one number is needed.")
    return float(positive(found, name, zero))


def length(value: Any, name: str) -> float:
    """A length whose powers are numbers.

    Raises
    ------
    InputError, ShapeError
        If it is none, too long or too short.
    """
    found = number(value, name)
    if not SHORTEST <= found <= LARGEST:
        raise InputError(f"{name} is {found:.3g}; lengths are from {SHORTEST:g} to {LARGEST:g}.")
    return found


def kept(values: Array) -> Array:
    """A copy that does not change when the caller's array does, nor by mistake."""
    own = np.array(values, np.float64)
    own.setflags(write=False)
    return own


def several(value: Any, single: type[Any] | tuple[type[Any], ...], what: str) -> tuple[Any, ...]:
    """What may be one thing or many: a tuple of them; None is none.

    Raises
    ------
    InputError
        If it is neither.
    """
    if value is None:
        return ()
    if isinstance(value, single):
        return (value,)
    if isinstance(value, str | bytes | Mapping | type) or not isinstance(value, Iterable):
        raise InputError(f"{what} are {shown(value)}; a list of them is needed.")
    try:
        return tuple(value)
    except TypeError:  # an array without axes says that it can be gone through, and cannot
        raise InputError(f"{what} are {shown(value)}; a list of them is needed.") from None


def shown(value: Any) -> str:
    """A wrong value as messages repeat it: what it is, shortened, on one line."""
    if isinstance(value, str | int | float | None):
        return " ".join(shortened(value).split())
    if isinstance(value, type):
        return f"the class {value.__name__}"
    name = type(value).__name__
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"


def output_file(path: Any, one: str, many: str, formats: Sequence[str]) -> Path:
    """A path that something can be written to.

    Parameters
    ----------
    one, many : str
        What is written, such as "a trajectory" and "trajectories".
    formats : sequence of str
        Endings of names.

    Raises
    ------
    InputError
        If it is none, or ends in no known format.
    """
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise InputError(f"{one} is written to a file, and {shown(path)} names none.") from None
    if "\0" in str(file):
        raise InputError(f"the name {str(file)!r} has a null character.")
    if file.suffix.lower() not in formats:
        raise InputError(f"{many} are written as {' or '.join(formats)}.", where=str(file))
    return file


def check_body(value: Any, what: str, world: bool = False) -> None:
    """Check the name or number of a body; None is the world, where that is allowed.

    Raises
    ------
    InputError
        If it is something else.
    """
    if value is None and world:
        return
    if isinstance(value, bool | np.bool_) or not isinstance(value, str | int | np.integer):
        more = ", or None for the world" if world else ""
        raise InputError(f"{what} is {shown(value)}; the name or the number of a body is needed{more}.")


def body_number(value: Any, names: Sequence[str], what: str) -> int:
    """The number of a body by its name or number; -1 for the world.

    Raises
    ------
    InputError
        If there is none.
    """
    check_body(value, f"the body of {what}", world=True)
    if value is None:
        return -1
    if isinstance(value, str):
        if value not in names:
            known = ", ".join(names)
            raise InputError(f"{what}: there is no body {value!r}; there are: {known}.{suggest(value, names)}")
        return list(names).index(value)
    if not 0 <= value < len(names):
        raise InputError(f"{what}: there is no body {value}; there are {len(names)}, from 0.")
    return int(value)


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
    check_coefficients(x, name)
    return x


def check_coefficients(x: Multivector, name: str) -> None:
    """Check that a multivector is finite.

    Raises
    ------
    InputError
        If it is not: which coefficient, of which item.
    """
    if np.isfinite(x.values).all():
        return
    *item, i = np.argwhere(~np.isfinite(x.values))[0]
    value, blade = x.values[(*item, i)], x.algebra.blade_name(x.kind.blades[i])
    of_item = f" of item {', '.join(map(str, item))}" if item else ""
    raise InputError(f"{name} is not finite: its coefficient of {blade}{of_item} is {value}.")


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
            raise GradeError(f"{name} has {x.algebra.blade_name(blade)}; the blades of a {kind} are: {names}.")
    return found
