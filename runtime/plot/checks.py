"""Arguments of pictures that are no objects: numbers, counts, positions. What does not fit is named."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import arrays
from ..errors import InputError
from ..multivector import Multivector
from .shapes import Array

#: Positions further away, and larger views, are not drawn: squares of coordinates are numbers, with room to spare.
FARTHEST = 1e100


def numbers(value: Any, name: str) -> Array:
    """Real numbers as an array of float64.

    Raises
    ------
    InputError
    """
    if isinstance(value, Multivector):
        raise InputError(f"{name} holds a {value.kind.name}; real numbers are needed.")
    return np.asarray(arrays.real(value, name), float)


def positive(value: Any, name: str) -> float:
    """One finite number above zero.

    Raises
    ------
    InputError
    """
    x = numbers(value, name)
    if x.ndim or not (np.isfinite(x) and x > 0):
        raise InputError(f"{name} is {value}; one positive number is needed.")
    return float(x)


def fraction(value: Any, name: str) -> float:
    """A number from 0 to 1.

    Raises
    ------
    InputError
    """
    x = numbers(value, name)
    if x.ndim or not (x >= 0 and x <= 1):
        raise InputError(f"{name} is {value}; a number from 0 to 1 is needed.")
    return float(x)


def whole(value: Any, name: str, low: int, high: int) -> int:
    """A whole number in a range.

    Raises
    ------
    InputError
    """
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or not low <= value <= high:
        raise InputError(f"{name} is {value}; a whole number from {low} to {high} is needed.")
    return int(value)


def pair(value: Any, name: str) -> tuple[float, float]:
    """Two finite numbers.

    Raises
    ------
    InputError
    """
    x = numbers(value, name)
    if x.shape != (2,) or not np.isfinite(x).all():
        raise InputError(f"{name} is {value}; two numbers are needed.")
    return float(x[0]), float(x[1])
