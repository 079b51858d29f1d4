"""Names for the text of algorithms: types for annotations, arrays, functions. The text also runs as plain Python.

Run so, numbers are float64, float32 or numbers of mpmath, as `number_type` says; without it, float64.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import numpy as np

from ....templates.numba import elementary
from .types import BOOL, INT, REAL, AccessAnnotation, Annotation, ArrayAnnotation, ArrayType, StaticType

if TYPE_CHECKING:
    Real = Any
    Int = int
    Bool = bool
    Static = Any
else:
    #: A number in the precision of the target.
    Real = Annotation(REAL)
    #: An integer of 64 bits.
    Int = Annotation(INT)
    Bool = Annotation(BOOL)
    #: A value that is known when the text is printed: a number, a string, or a tuple of such.
    Static = Annotation(StaticType())

#: ``Vector[3]``; without a length, of any, which each call decides.
Vector: Any = ArrayAnnotation(REAL, 1)
#: ``Matrix[4, 4]``, as `Vector`.
Matrix: Any = ArrayAnnotation(REAL, 2)
#: ``IntVector[3]``: integers.
IntVector: Any = ArrayAnnotation(INT, 1)
#: ``Rows[6]``: rows of six numbers, as many as there are at run time (`len`).
Rows: Any = ArrayAnnotation(REAL, 1, is_open=True)
#: ``IntRows[2]``: the same of integers.
IntRows: Any = ArrayAnnotation(INT, 1, is_open=True)
#: Numbers, as many as there are at run time.
Reals: Any = Annotation(ArrayType(REAL, (None,)))
#: Integers, as many as there are at run time.
Ints: Any = Annotation(ArrayType(INT, (None,)))
#: ``Out[Vector[3]]``: an array that the algorithm writes. When it is called by a user, a result.
Out: Any = AccessAnnotation("out")
#: ``InOut[Vector[3]]``: an array that it changes. When it is called by a user, a copy is changed and returned.
InOut: Any = AccessAnnotation("inout")

INFINITY = float("inf")
NAN = float("nan")

#: What numbers are in plain Python: a NumPy type, or a context of mpmath.
_numbers: ContextVar[Any] = ContextVar("numbers", default=np.float64)
#: Whether a text runs as Python now, so that what it calls does so, too.
_is_python: ContextVar[bool] = ContextVar("is_python", default=False)


@contextmanager
def number_type(numbers: Any) -> Iterator[None]:
    """A context in which algorithms run as Python on numbers of this type: a NumPy type or a context of mpmath."""
    token, python = _numbers.set(numbers), _is_python.set(True)
    try:
        with np.errstate(all="ignore"):
            yield
    finally:
        _numbers.reset(token)
        _is_python.reset(python)


def runs_as_python() -> bool:
    """Whether an algorithm runs as Python now."""
    return _is_python.get()


def numbers_in_use() -> Any:
    """What numbers are: a NumPy type or a context of mpmath."""
    return _numbers.get()


def _is_precise() -> bool:
    return hasattr(_numbers.get(), "mpf")


def zeros(*shape: int) -> Any:
    """An array of zeros."""
    numbers = _numbers.get()
    if not _is_precise():
        return np.zeros(shape, numbers)
    array = np.empty(shape, object)
    array[...] = numbers.mpf(0)
    return array


def empty(*shape: int) -> Any:
    """An array that is written before it is read."""
    if _is_precise():
        return zeros(*shape)
    return np.full(shape, np.nan, _numbers.get())


def int_zeros(*shape: int) -> Any:
    """An array of integers, zero."""
    return np.zeros(shape, np.int64)


def number(x: Any) -> Any:
    """A number of the type that is in use, from any other."""
    numbers = _numbers.get()
    return numbers.mpf(x) if _is_precise() else numbers(x)


def epsilon() -> Any:
    """The distance from 1 to the next number."""
    return +_numbers.get().eps if _is_precise() else np.finfo(_numbers.get()).eps


def _function(name: str) -> Any:
    home = np if name == "sqrt" else elementary

    def call(*arguments: Any) -> Any:
        numbers = _numbers.get()
        if _is_precise():
            return getattr(numbers, name)(*arguments)
        with np.errstate(all="ignore"):
            return getattr(home, name)(*(numbers(a) for a in arguments))

    call.__name__ = name
    call.__doc__ = f"The function {name} of numbers."
    return call


sqrt, sin, cos, exp, log, atan2 = (_function(name) for name in ("sqrt", "sin", "cos", "exp", "log", "atan2"))

#: Functions that the reader knows, and how many numbers they take.
FUNCTIONS: dict[Any, tuple[str, int]] = {
    sqrt: ("sqrt", 1), abs: ("abs", 1), sin: ("sin", 1), cos: ("cos", 1), exp: ("exp", 1), log: ("log", 1),
    atan2: ("atan2", 2), epsilon: ("epsilon", 0),
}  # fmt: skip
#: Functions that make arrays: what of, and whether it is zero.
ALLOCATORS: dict[Any, tuple[Any, bool]] = {zeros: (REAL, True), empty: (REAL, False), int_zeros: (INT, True)}
