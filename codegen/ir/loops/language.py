"""Names for the text of algorithms: types for annotations, arrays, functions. The text also runs as plain Python.

Run so, numbers are float64, float32 or numbers of mpmath, as `number_type` says; without it, float64.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import numpy as np

from ...elementary import functions as elementary
from ...elementary import machine
from .records import Record
from .types import BOOL, INT, REAL, AccessAnnotation, Annotation, ArrayAnnotation, ArrayType, Scalar, StaticType

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
#: The same, stored in 32 bits: larger ones are cut off.
Ints32: Any = Annotation(ArrayType(INT, (None,), bits=32))
#: The same from 0 to 255.
Bytes: Any = Annotation(ArrayType(INT, (None,), bits=8))
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


def zeros(*shape: Any) -> Any:
    """An array of zeros. The last size may be a record: its rows have the fields."""
    if isinstance(shape[-1], Record):
        record = shape[-1]
        sizes = (*shape[:-1], record.size)
        return record.view(zeros(*sizes) if record.scalar == REAL else int_zeros(*sizes))
    numbers = _numbers.get()
    if not _is_precise():
        return np.zeros(shape, numbers)
    array = np.empty(shape, object)
    array[...] = numbers.mpf(0)
    return array


def empty(*shape: Any) -> Any:
    """An array that is written before it is read; sizes as for `zeros`."""
    if _is_precise() or isinstance(shape[-1], Record):
        return zeros(*shape)
    return np.full(shape, np.nan, _numbers.get())


def int_zeros(*shape: int) -> Any:
    """An array of integers, zero."""
    return np.zeros(shape, np.int64)


def int_empty(*shape: int) -> Any:
    """An array of integers that is written before it is read."""
    return np.full(shape, np.iinfo(np.int64).min, np.int64)


def unrolled(*bounds: int) -> range:
    """As `range`, of static bounds: a loop that is written out if it has at most `MOST_UNROLLED` steps."""
    return range(*bounds)


MOST_UNROLLED = 16


def number(x: Any) -> Any:
    """A number of the type that is in use, from any other."""
    numbers = _numbers.get()
    return numbers.mpf(x) if _is_precise() else numbers(x)


def epsilon() -> Any:
    """The distance from 1 to the next number."""
    return +_numbers.get().eps if _is_precise() else np.finfo(_numbers.get()).eps


def largest() -> Any:
    """The largest number; of numbers without one, that of float64."""
    return _numbers.get().mpf(np.finfo(np.float64).max) if _is_precise() else np.finfo(_numbers.get()).max


def any_item(holds: Any) -> Any:
    """Whether a condition holds for any of several items that are computed at once: of a single one, whether it holds.

    All items share what it gives, and what is decided by it alone: they take the same path, and keep what lies beside
    it, where they need not. No bit of a result may depend on it.
    """
    return holds


def _function(name: str) -> Any:
    home = np if name == "sqrt" else elementary

    def call(*arguments: Any) -> Any:
        numbers = _numbers.get()
        if _is_precise():
            value = getattr(numbers, name)(*arguments)
            return numbers.mpf("nan") if isinstance(value, numbers.mpc) else value  # beyond real numbers: as compiled
        with np.errstate(all="ignore"):
            return getattr(home, name)(*(numbers(a) for a in arguments))

    call.__name__ = name
    call.__doc__ = f"The function {name} of numbers."
    return call


sqrt, sin, cos, exp, log, atan2 = (_function(name) for name in ("sqrt", "sin", "cos", "exp", "log", "atan2"))

#: Functions that the reader knows: names, what they take, and what they return.
FUNCTIONS: dict[Any, tuple[str, tuple[Scalar, ...], Scalar]] = {
    **{f: (f.__name__, (REAL,), REAL) for f in (sqrt, abs, sin, cos, exp, log)},
    atan2: ("atan2", (REAL, REAL), REAL), epsilon: ("epsilon", (), REAL), largest: ("largest", (), REAL),
    **{f: (f.__name__, (REAL,), REAL) for f in (machine.power_of_two, machine.exponent, machine.significand)},
    **{f: (f.__name__, (REAL, REAL), REAL) for f in (machine.change_sign, machine.copy_sign)},
    machine.is_odd: ("is_odd", (REAL,), BOOL), machine.any_of: ("any_of", (BOOL,), BOOL),
    machine.bits: ("bits", (REAL,), INT),
    any_item: ("any", (BOOL,), BOOL),
    machine.real: ("real", (INT,), REAL), machine.square_root: ("sqrt", (REAL,), REAL),
}  # fmt: skip
#: Functions that make arrays: what of, and whether it is zero.
ALLOCATORS: dict[Any, tuple[Any, bool]] = {
    zeros: (REAL, True),
    empty: (REAL, False),
    int_zeros: (INT, True),
    int_empty: (INT, False),
}
