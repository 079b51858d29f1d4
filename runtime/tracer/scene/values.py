"""Checks of numbers, options and lists from users; errors are `SceneError`s with the name of the value."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...common.validation import (
    MAX_FLOAT,
    as_bool,
    as_float,
    as_instance,
    as_int,
    as_text,
    as_tuple,
    finite_array,
)
from ...errors import SceneError

Array = NDArray[np.float64]
T = TypeVar("T")
#: Smallest length of a vector that has a direction.
TINY = 1e-150
#: Brightest light: its products with colors and factors are numbers in single precision too.
BRIGHTEST = 1e9


def reals(value: Any) -> NDArray[Any] | None:
    """Convert to an array of real numbers, or None: complex numbers, texts, objects and masked arrays are rejected."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        return None
    if isinstance(value, np.ma.MaskedArray):
        return None  # masked entries would become visible
    return array if array.dtype.kind in "iuf" else None


flag = partial(as_bool, error=SceneError)
text = partial(as_text, error=SceneError)
whole = partial(as_int, error=SceneError)


def finite(value: Any, name: str, size: int | None = None) -> Array:
    """Check for a finite float64 array, with ``size`` entries where a size is given."""
    array = finite_array(value, name, None if size is None else (size,), SceneError).copy()
    array.setflags(write=False)  # drivers hold copies
    return array


def number(value: Any, name: str, low: float = -MAX_FLOAT, high: float = MAX_FLOAT, above: float = -math.inf) -> float:
    """Check for one finite number in a range; an array of one is a number."""
    single = value.reshape(()) if isinstance(value, np.ndarray) and value.size == 1 else value
    return as_float(single, name, low, high, above, error=SceneError)


positive = partial(number, above=0.0)


def color(value: Any, name: str) -> Array:
    """Check for linear red, green and blue, from 0 to `BRIGHTEST`."""
    rgb = finite(value, name, 3)
    if np.any(rgb < 0):
        raise SceneError(f"{name} is {rgb.tolist()}; colors must not be negative.")
    if np.any(rgb > BRIGHTEST):
        raise SceneError(f"{name} is {rgb.tolist()}; colors go to {BRIGHTEST:g}.")
    return rgb


def members(sequence: Any, name: str, kind: type[T]) -> tuple[T, ...]:
    """Check a list whose members all belong to one class."""
    items = as_tuple(sequence, name, error=SceneError)
    return tuple(as_instance(member, f"{name}[{i}]", kind, error=SceneError) for i, member in enumerate(items))


def unit(value: Any, name: str) -> Array:
    """Check for a direction, and scale it to length 1."""
    v = finite(value, name, 3)
    largest = float(np.max(np.abs(v)))
    if largest < TINY:
        raise SceneError(f"{name} is {v.tolist()}; a direction must not be zero.")
    v = v / largest
    v = v / np.sqrt(v @ v)
    v.setflags(write=False)
    return v
