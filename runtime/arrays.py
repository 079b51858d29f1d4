"""What users hand over as numbers: checked, converted once, and named in errors. No algebra comes in here."""

from __future__ import annotations

import contextlib
from reprlib import repr as shortened
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .codegen.errors import InputError, ShapeError
from .typed import F32, F64


def real(value: Any, name: str) -> NDArray[Any]:
    """An array of float64 or float32.

    Raises
    ------
    InputError
        If it does not hold real numbers, or masks some.
    """
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise InputError(f"{name} masks some of its numbers; fill them first: x.filled(value).")
    try:
        array = np.asarray(value)
    except ValueError:
        raise InputError(f"{name} is ragged; all its rows have one length.") from None
    except TypeError as error:  # a multivector, for one, says what to take instead
        raise InputError(f"{name}: {error}") from None
    if array.dtype == F64 or array.dtype == F32:
        return array
    if array.dtype.kind not in "iufb":
        raise InputError(f"{name} holds {array.dtype}; real numbers are needed.")
    if array.dtype.kind == "b" and array.size:
        raise InputError(f"{name} holds truth values; real numbers are needed.")
    return array.astype(F64)


def rows(value: Any, count: int, name: str) -> NDArray[Any]:
    """Rows of ``count`` numbers: an array of shape (..., count).

    Raises
    ------
    InputError, ShapeError
        If it holds no real numbers, or its last axis has another length.
    """
    array = real(value, name)
    if array.ndim == 0 or array.shape[-1] != count:
        raise ShapeError(f"{name} has shape {array.shape}; its last axis must have {count} entries.")
    return array


def truth(value: Any, name: str, error: type[InputError] = InputError) -> bool:
    """An option: True or False, and nothing that merely counts as one of them.

    Raises
    ------
    InputError
        Or the given subclass.
    """
    if value is True or value is False:
        return bool(value)
    if isinstance(value, np.bool_) or (isinstance(value, np.ndarray) and value.dtype == bool and not value.ndim):
        return bool(value)
    raise error(f"{name} is {' '.join(shortened(value).split())}; it is True or False.")


def precision(*values: Any) -> np.dtype[Any]:
    """float32 if every array is; plain Python numbers do not count."""
    dtypes = {v.dtype for v in values if hasattr(v, "dtype")}
    return F32 if dtypes == {F32} else F64


def given_precision(dtype: Any) -> np.dtype[Any] | None:
    """A ``dtype=`` argument: float64, float32, or None for what the values have.

    Raises
    ------
    InputError
        If it is another type.
    """
    if dtype is None:
        return None
    found: np.dtype[Any] = np.dtype(object)
    with contextlib.suppress(TypeError):
        found = np.dtype(dtype)
    if found != F64 and found != F32:
        raise InputError(f"dtype is {dtype!r}; multivectors hold float64 or float32.")
    return found
