"""Validation of arguments: typed checks, one form of message. No algebra comes in here.

A check takes a value and its name in messages, and returns the value converted: once, at the border of the package.
Messages say the name, the value, what is required, and where there is one a remedy:

    radius is -1.0; a positive number is needed.
    points[3, 0] is nan; a finite number is needed.
    method is 'direkt' (did you mean 'direct'?); one of direct, rotor is needed.

What is not valid raises ``error``, the class of the package; shapes raise `ShapeError` where no class is given.
"""

from __future__ import annotations

import contextlib
import math
import sys
from collections.abc import Callable, Iterable, Mapping
from numbers import Real
from operator import index
from reprlib import repr as shortened
from types import EllipsisType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import BladesmithError, InputError, ShapeError, one_line, suggest
from ..codegen.execute.arrays import native_array
from .dtypes import F32, F64

Array = NDArray[np.float64]
T = TypeVar("T")
#: Axes of an array: a length, the letter of any length, `...` for any number of axes in front.
Axes = tuple[int | str | EllipsisType, ...]
#: Characters of an invalid value in a message.
MAX_REPR = 60
#: Numbers of which bytes are searched faster than NumPy calls a reduction.
FEW = 4096
#: Items of a batch: numbers beyond are mistakes.
MAX_ITEMS = 2**48
#: Range of finite numbers.
MAX_FLOAT = sys.float_info.max

_LITERALS = (str, bytes, int, float, complex, list, tuple, dict, set, frozenset, np.ndarray, type(None))


def short_repr(value: Any) -> str:
    """Invalid value as messages repeat it, shortened and on one line; of other classes their names."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, _LITERALS):
        with contextlib.suppress(Exception):  # numbers of thousands of digits, items that raise anything
            line = " ".join(shortened(value).split())
            return line if len(line) <= MAX_REPR else f"{line[:MAX_REPR]}.."
    if isinstance(value, type):
        return f"the class {value.__name__}"
    name = type(value).__name__
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"


def invalid(
    value: Any, name: str, needed: str, error: type[BladesmithError] = InputError, remedy: str | None = None
) -> BladesmithError:
    """Error to raise for a value: what it is, and what is needed instead."""
    return error(f"{name} is {short_repr(value)}; {needed} is needed.", remedy=remedy)


# -- options -------------------------------------------------------------------------------------------------------


def as_bool(value: Any, name: str, error: type[BladesmithError] = InputError) -> bool:
    """True or False, and nothing that merely counts as one of them."""
    if value is True or value is False:
        return value
    if isinstance(value, np.bool_) or (isinstance(value, np.ndarray) and value.dtype == bool and not value.ndim):
        return bool(value)
    raise invalid(value, name, "True or False", error)


def as_text(value: Any, name: str, error: type[BladesmithError] = InputError) -> str:
    return as_instance(value, name, str, "a text", error)


def as_word(value: Any, name: str, error: type[BladesmithError] = InputError) -> str:
    """Text that is not empty."""
    if isinstance(value, str) and value:
        return value
    raise invalid(value, name, "a word", error)


def as_choice(value: Any, name: str, choices: Iterable[str], error: type[BladesmithError] = InputError) -> str:
    """One of some words."""
    if isinstance(value, str) and value in choices:
        return value
    raise unknown(value, name, choices, error)


def unknown(
    value: Any,
    name: str,
    choices: Iterable[str],
    error: type[BladesmithError] = InputError,
    remedy: str | None = None,
) -> BladesmithError:
    """Error to raise for a word that is not among some, with the one that is most like it."""
    listed = list(choices)
    near = suggest(value, listed) if isinstance(value, str) else ""
    return error(
        f"{name} is {short_repr(value)}{near}; one of {', '.join(listed) or 'no names'} is needed.", remedy=remedy
    )


def as_instance(
    value: Any,
    name: str,
    kind: type[T] | tuple[type[T], ...],
    needed: str = "",
    error: type[BladesmithError] = InputError,
    remedy: str | None = None,
) -> T:
    """Value of a class; ``needed`` describes it."""
    if isinstance(value, kind):
        return value
    kinds = kind if isinstance(kind, tuple) else (kind,)
    raise invalid(value, name, needed or f"a {' or a '.join(k.__name__ for k in kinds)}", error, remedy)


def as_function(
    value: Any, name: str, needed: str = "a function", error: type[BladesmithError] = InputError
) -> Callable[..., Any]:
    """Function or other callable; a class is none, since what it makes is meant."""
    if callable(value) and not isinstance(value, type):
        return value  # type: ignore[no-any-return]
    raise invalid(value, name, needed, error)


def as_tuple(
    value: Any, name: str, single: type[Any] | tuple[type[Any], ...] = (), error: type[BladesmithError] = InputError
) -> tuple[Any, ...]:
    """Tuple of one value of the types ``single``, or of several; None gives an empty one."""
    if value is None or (type(value) is tuple and not value):
        return ()
    if single and isinstance(value, single):
        return (value,)
    if not isinstance(value, str | bytes | Mapping | type):
        try:
            return tuple(value)
        except TypeError:
            pass
    raise error(f"{name} are {short_repr(value)}; a list of them is needed.")


# -- numbers -------------------------------------------------------------------------------------------------------


def as_float(
    value: Any,
    name: str,
    low: float = -MAX_FLOAT,
    high: float = MAX_FLOAT,
    above: float = -math.inf,
    below: float = math.inf,
    error: type[BladesmithError] = InputError,
) -> float:
    """One number from ``low`` to ``high``, greater than ``above``, and less than ``below``.

    It is finite, unless a limit is infinite.
    """
    x = value if type(value) is float else _single(value, name, error)
    if low <= x <= high and (x > above or above == -math.inf) and (x < below or below == math.inf):
        return x
    text = _range_text(low, high, above, below)
    is_infinite = isinstance(value, float) and not math.isfinite(value)
    raise invalid(value, name, f"a {'finite ' * (is_infinite or text == 'number')}{text}", error)


def positive_float(value: Any, name: str, high: float = MAX_FLOAT, error: type[BladesmithError] = InputError) -> float:
    return as_float(value, name, high=high, above=0.0, error=error)


def as_pair(value: Any, name: str, error: type[BladesmithError] = InputError) -> tuple[float, float]:
    first, second = finite_array(value, name, (2,), error).tolist()
    return first, second


def _single(value: Any, name: str, error: type[BladesmithError]) -> float:
    """One number; NaN where the value is none."""
    if isinstance(value, Real) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            return math.nan
    if hasattr(value, "as_kind"):  # a multivector, which is an array for NumPy
        return math.nan
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        return math.nan
    if array.ndim and array.dtype.kind in "iuf":
        raise (ShapeError if error is InputError else error)(f"{name} has shape {array.shape}; one number is needed.")
    is_number = array.dtype.kind in "iuf" and not np.ma.is_masked(value)
    return float(array) if is_number else math.nan


def _range_text(low: float, high: float, above: float, below: float) -> str:
    if low > -MAX_FLOAT and high < MAX_FLOAT:
        return f"number from {low:g} to {high:g}"
    if above == 0 and below == math.inf and high >= MAX_FLOAT:
        return "positive number"
    limits = [
        f"greater than {above:g}" if above > -math.inf else f"of at least {low:g}" if low > -MAX_FLOAT else "",
        f"less than {below:g}" if below < math.inf else f"of at most {high:g}" if high < MAX_FLOAT else "",
    ]
    return f"number {' and '.join(filter(None, limits))}".rstrip()


def as_int(
    value: Any, name: str, low: int = 1, high: int | None = None, error: type[BladesmithError] = InputError
) -> int:
    """Whole number of at least ``low``, and at most ``high`` where it is given; truth values are none."""
    try:
        count = None if isinstance(value, bool | np.bool_) else index(value)
    except TypeError:
        count = None
    if count is not None and count >= low and (high is None or count <= high):
        return count
    limits = f"from {low} to {high}" if high is not None else f"of at least {low}"
    needed = "a positive whole number" if low == 1 and high is None else f"a whole number {limits}"
    raise invalid(value, name, needed, error)


def as_shape(value: Any, name: str, error: type[BladesmithError] = ShapeError) -> tuple[int, ...]:
    """The shape of a batch: a number of items, or a tuple of such numbers."""
    entries = value if isinstance(value, tuple | list) else (value,)
    return tuple(as_int(n, name, 0, MAX_ITEMS, error) for n in entries)


def as_axis(value: Any, shape: tuple[int, ...], what: str, error: type[BladesmithError] = ShapeError) -> int:
    """Axis of a batch of a shape, counted from 0; ``what`` names the batch."""
    try:
        axis = None if isinstance(value, bool | np.bool_) else index(value)
    except TypeError:
        axis = None
    if axis is None:
        raise invalid(value, "axis", "a whole number")
    if not -len(shape) <= axis < len(shape):
        raise error(f"{what} shape {shape}, without an axis {short_repr(axis)}.")
    return axis % len(shape)


# -- arrays --------------------------------------------------------------------------------------------------------


def as_array(value: Any, name: str, error: type[BladesmithError] = InputError) -> NDArray[Any]:
    """Array of any items, in the memory of what has a buffer, ``__array__`` or ``__dlpack__`` on the host."""
    first = value
    while isinstance(first, list | tuple) and len(first):
        first = first[0]
    if hasattr(first, "as_kind"):
        raise error(f"{name}: a multivector is not an array; its coefficients are x.values.")
    try:
        if hasattr(value, "__dlpack__") and not hasattr(value, "__array__"):
            return np.from_dlpack(value)
        return np.asarray(value)
    except ValueError:
        raise error(f"{name} is ragged; all its rows have one length.") from None
    except (TypeError, OverflowError) as problem:
        raise error(f"{name}: {problem}") from None
    except (BufferError, RuntimeError) as problem:
        text = one_line(problem)
        remedy = "Copy it to the host as float64 or float32, and detach it from a gradient, first"
        raise error(f"{name} is not readable as an array of NumPy ({text})", remedy=remedy) from None


def real_array(
    value: Any, name: str, shape: Axes | None = None, error: type[BladesmithError] = InputError
) -> NDArray[Any]:
    """Array of float64 or float32 in memory as C needs it, of a shape.

    Masked and complex numbers and truth values are not valid.
    """
    if type(value) is np.ndarray:
        array = value
    else:
        if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
            raise error(f"{name} masks some of its numbers; fill them first: x.filled(value).")
        array = as_array(value, name, error)
    if not (array.dtype.isnative and array.flags.aligned):
        array = native_array(array)
    if array.dtype != F64 and array.dtype != F32:
        if array.dtype.kind not in "iuf" and (array.dtype.kind != "b" or array.size):
            if array.ndim == 0:
                raise error(f"{name} is {short_repr(value)}; real numbers are needed.")
            held = "truth values" if array.dtype.kind == "b" else array.dtype
            raise error(f"{name} holds {held}; real numbers are needed.")
        array = array.astype(F64)
    if shape and shape[0] is ... and array.shape[-1:] == shape[1:]:
        return array  # most are rows
    if shape is not None:
        check_shape(array, name, shape, error)
    return array


def all_finite(array: NDArray[Any]) -> bool:
    """Whether all numbers of an array are finite; of few at a third of the time of NumPy's reduction."""
    found = np.isfinite(array)
    return b"\0" not in found.tobytes() if array.size < FEW else bool(found.all())


def finite_array(value: Any, name: str, shape: Axes | None = None, error: type[BladesmithError] = InputError) -> Array:
    """Array of finite numbers as float64, of a shape."""
    array = np.asarray(real_array(value, name, shape, error), np.float64)
    return check_items(np.isfinite(array), array, name, "a finite number", error)


def positive_array(value: Any, name: str, zero: bool = False, error: type[BladesmithError] = InputError) -> Array:
    """Array of positive finite numbers; zero is valid if ``zero`` says so."""
    array = finite_array(value, name, error=error)
    valid, needed = (array >= 0, "a number of at least 0") if zero else (array > 0, "a positive number")
    return check_items(valid, array, name, needed, error)


def check_items(
    valid: Any, array: NDArray[Any], name: str, needed: str, error: type[BladesmithError] = InputError
) -> NDArray[Any]:
    """The array, if all items are valid; else the first that is not is reported with its index."""
    if valid.all():
        return array
    place = tuple(np.argwhere(~valid)[0])
    raise invalid(array[place], f"{name}[{', '.join(map(str, place))}]" if place else name, needed, error)


def check_shape(
    array: Any, name: str, shape: Axes, error: type[BladesmithError] = InputError, remedy: str | None = None
) -> None:
    """Check the shape of an array or a batch, such as ``("n", 3)`` or ``(..., 3)``."""
    sizes = shape[1:] if shape and shape[0] is ... else shape
    have = array.shape[len(array.shape) - len(sizes) :] if len(sizes) < len(shape) else array.shape
    if len(have) == len(sizes) and all(isinstance(s, str) or s == n for s, n in zip(sizes, have, strict=True)):
        return
    text = ", ".join("..." if s is ... else str(s) for s in shape)
    needed = f"({text}{',' * (len(shape) == 1)})" if shape else "one item"
    what = f"is {array}" if isinstance(array, np.ndarray) and not array.ndim else f"has shape {array.shape}"
    raise (ShapeError if error is InputError else error)(f"{name} {what}; {needed} is needed.", remedy=remedy)


def broadcast_shapes(*shapes: Mapping[str, tuple[int, ...]]) -> tuple[int, ...]:
    """Common shape of batches, each by the name of its argument."""
    by_name = {name: shape for some in shapes for name, shape in some.items()}
    try:
        return np.broadcast_shapes((), *by_name.values())
    except ValueError:
        text = ", ".join(f"{name} {shape}" for name, shape in by_name.items() if shape)
        raise ShapeError(f"these batches do not broadcast: {text}.") from None


def broadcast_to(array: NDArray[Any], shape: tuple[int, ...], name: str) -> NDArray[Any]:
    """Array repeated to a shape."""
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ShapeError(f"{name} has shape {array.shape}, which does not broadcast to {shape}.") from None
