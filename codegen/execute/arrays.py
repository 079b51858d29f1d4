"""Compiled kernels as functions from arrays to arrays. Light: NumPy only, no code generation.

A binding broadcasts leading dimensions, converts types, and calls the compiled loop once. It knows no algebra: the
number of coefficients per row is all that it is told.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, ShapeError
from ..ir.argument import Argument
from .result_memory import MANY, STORE

Array = NDArray[Any]
F64, F32 = np.dtype(np.float64), np.dtype(np.float32)
READY = 0x101  # flags of arrays that are contiguous and aligned: NPY_ARRAY_C_CONTIGUOUS | NPY_ARRAY_ALIGNED


class Binding(ABC):
    """A kernel as a function of arrays. A target says how prepared arrays are run.

    Parameters
    ----------
    symbol : str
        Name of the kernel in generated code.
    inputs, outputs : sequences of Argument
    """

    def __init__(self, symbol: str, inputs: Sequence[Argument], outputs: Sequence[Argument]) -> None:
        self.symbol = symbol
        self.inputs = tuple(inputs)
        self.outputs = tuple(outputs)
        self._sizes = [item.size for item in self.inputs]
        self._widths = [max(size, 1) for size in self._sizes]
        self._single_output = len(self.outputs) == 1 and not self.outputs[0].is_status

    def __call__(self, *arrays: Any) -> Any:
        """Results for arrays of shape (..., size), leading dimensions broadcast.

        Raises
        ------
        ShapeError, InputError
            If an array has the wrong last axis, the shapes do not broadcast, or it holds no numbers.
        """
        prepared, lead = self.prepare(arrays)
        results = self.empty_results(lead, prepared[0].dtype if prepared else F64)
        self.run(prepared, results, math.prod(lead))
        return results[0] if self._single_output else tuple(results)

    def prepare(self, arrays: Sequence[Any]) -> tuple[list[Array], tuple[int, ...]]:
        """Contiguous arrays of one floating type, each with the full leading shape or a single row."""
        if len(arrays) != len(self.inputs):
            raise InputError(f"{self.symbol} takes {len(self.inputs)} arrays, not {len(arrays)}.")
        lead = self._common_lead(arrays)
        if lead is not None:
            return list(arrays), lead
        prepared = [floating(a, item.name) for a, item in zip(arrays, self.inputs, strict=True)]
        if any(a.dtype != prepared[0].dtype for a in prepared):
            prepared = [a.astype(F64) for a in prepared]
        leads = []
        for array, item in zip(prepared, self.inputs, strict=True):
            if item.size and (array.ndim == 0 or array.shape[-1] != item.size):
                raise ShapeError(
                    f"{self.symbol}: {item.name} has shape {array.shape}; its last axis must have {item.size} entries."
                )
            leads.append(array.shape[:-1] if item.size else array.shape)
        lead = leads[0] if all(s == leads[0] for s in leads) else broadcast_leads(leads, self.symbol)
        rows = []
        for array, item, own in zip(prepared, self.inputs, leads, strict=True):
            if own != lead and math.prod(own) != 1:
                array = np.broadcast_to(array, lead + ((item.size,) if item.size else ()))
            rows.append(np.ascontiguousarray(array))
        return rows, lead

    def _common_lead(self, arrays: Sequence[Any]) -> tuple[int, ...] | None:
        """The leading shape that contiguous rows of float64 share: the short way. None where it is not so simple."""
        lead = None
        for a, size in zip(arrays, self._sizes, strict=True):
            if type(a) is not np.ndarray or a.dtype is not F64 or a.flags.num & READY != READY:
                return None
            own = a.shape
            if size:
                if own[-1:] != (size,):
                    return None
                own = own[:-1]
            if lead is not None and own != lead:
                return None
            lead = own
        return lead

    def empty_results(self, lead: tuple[int, ...], dtype: Any) -> list[Array]:
        """Arrays for the results of items of a leading shape."""
        return [self.empty_result(output, lead, dtype) for output in self.outputs]

    def empty_result(self, output: Argument, lead: tuple[int, ...], dtype: Any) -> Array:
        """The array for one of them."""
        empty = np.empty if math.prod(lead) < MANY else STORE.empty
        return empty(lead + ((output.size,) if output.size else ()), np.uint8 if output.is_status else dtype)

    @abstractmethod
    def run(self, arrays: Sequence[Array], results: Sequence[Array], n: int) -> None:
        """Compute ``n`` items of prepared arrays into contiguous results."""

    def strides(self, arrays: Sequence[Array]) -> list[int]:
        """Numbers from one item to the next in each prepared array: 0 where all items share one row."""
        return [0 if a.size == width else width for a, width in zip(arrays, self._widths, strict=True)]


def floating(value: Any, name: str) -> Array:
    """The value as an array of float64 or float32."""
    array = native_array(value, name)
    if array.dtype == F64 or array.dtype == F32:
        return array
    if array.dtype.kind not in "iuf" and not (array.dtype.kind == "b" and array.size == 0):
        raise InputError(f"{name} has type {array.dtype}; real numbers are needed.")
    return array.astype(F64)


def native_array(value: Any, name: str = "an array") -> Array:
    """The value as an array of this machine's order of bytes, and aligned: a view may begin at an odd byte.

    Raises
    ------
    InputError
        If its rows are of several lengths, or it masks some of its numbers.
    """
    if type(value) is not np.ndarray and isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise InputError(f"{name} masks some of its numbers.", remedy="Fill them first: x.filled(value)")
    try:
        array = np.asarray(value)
    except ValueError:
        raise InputError(f"{name} has rows of several lengths.") from None
    if not array.dtype.isnative:
        return array.astype(array.dtype.newbyteorder("="))
    return array if array.flags.aligned else array.copy()


def broadcast_leads(leads: Sequence[tuple[int, ...]], symbol: str) -> tuple[int, ...]:
    """The items' shape, from the leading axes of arguments."""
    try:
        return np.broadcast_shapes(*leads)
    except ValueError:
        shapes = " and ".join(str(s) for s in leads)
        what = f"shapes {shapes} of items do not broadcast; insert axes with a[:, None]. (Seen by {symbol}.)"
        raise ShapeError(what) from None
