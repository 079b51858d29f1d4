"""The two precisions of coefficients."""

from __future__ import annotations

import contextlib
from typing import Any, Final

import numpy as np

from ..codegen.errors import InputError, one_line

#: Double precision.
F64: Final = np.dtype(np.float64)
#: Single precision.
F32: Final = np.dtype(np.float32)


def common_precision(*values: Any) -> np.dtype[Any]:
    """float32 if every array is; plain Python numbers do not count."""
    dtypes = {v.dtype for v in values if hasattr(v, "dtype")}
    if F64 not in dtypes:  # then the order of bytes may be another
        dtypes = {d.newbyteorder("=") if isinstance(d, np.dtype) else d for d in dtypes}
    return F32 if dtypes == {F32} else F64


def as_precision(dtype: Any) -> np.dtype[Any] | None:
    """A ``dtype=`` argument: float64, float32, or None for what the values have.

    Raises
    ------
    InputError
        If it is another type.
    """
    if dtype is None:
        return None
    found: np.dtype[Any] = np.dtype(object)
    with contextlib.suppress(TypeError, ValueError):
        found = np.dtype(dtype)
    if found != F64 and found != F32:
        raise InputError(f"dtype is {one_line(dtype)}; multivectors hold float64 or float32.")
    return found
