"""Compiled algorithms as functions of arrays: one item after another, leading axes broadcast."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ..errors import InputError, ShapeError
from ..ir.loops.nodes import Function
from ..ir.loops.types import BOOL, INT, REAL, ArrayType, Parameter, Scalar
from .arrays import Array, broadcast_leads, floating, parallel_for

#: Runs items [begin, end) of prepared arrays: strides in numbers, and rows of open arrays.
Loop = Callable[[int, int, Sequence[Array], Sequence[int], Sequence[int]], None]


class ItemFunction:
    """An algorithm for one choice of sizes, on one target and precision.

    Parameters
    ----------
    function : Function
    loop : callable
        See `Loop`.
    dtype : float64 or float32
    """

    def __init__(self, function: Function, loop: Loop, dtype: Any) -> None:
        self.function = function
        self.loop = loop
        self.dtypes = {REAL: np.dtype(dtype), INT: np.dtype(np.int64), BOOL: np.dtype(np.int64)}

    def __call__(self, *arguments: Any) -> Any:
        """Results for all items: arrays that it writes or changes, then what it returns; one by itself as it is."""
        function = self.function
        given = iter(arguments)
        inputs = [None if p.access == "out" else self._input(p, next(given)) for p in function.parameters]
        leads = [_lead(p, a) for p, a in zip(function.parameters, inputs, strict=True) if a is not None]
        lead = broadcast_leads(leads, function.name)
        n = math.prod(lead)
        results: list[Array] = []
        taken: list[Array] = []
        strides: list[int] = []
        counts: list[int] = []
        for p, a in zip(function.parameters, inputs, strict=True):
            is_shared = False  # by all items; its own leading axes say so, for its rows may be as many as the items
            rows = 0
            if isinstance(p.type, ArrayType):
                rows = a.shape[-len(p.type.sizes)] if a is not None else 0
                if p.access != "in":
                    a = self._result(p.type, a, lead)
                    results.append(a)
            assert a is not None
            if p.access == "in":
                own = _lead(p, a)
                is_shared = math.prod(own) == 1
                if not is_shared and own != lead:
                    a = np.broadcast_to(a, (*lead, *a.shape[len(own) :]))
            taken.append(np.require(a, requirements=("C", "A")))
            strides.append(0 if is_shared or not n else a.size // n)
            counts.append(rows)
        returned = [np.empty(lead, self.dtypes[t]) for t in function.results]
        if n:
            flat = [a.reshape(-1) for a in (*taken, *returned)]
            strides += [1] * len(returned)
            counts += [0] * len(returned)
            parallel_for(lambda begin, end: self.loop(begin, end, flat, strides, counts), n)
        found = [
            *results,
            *(r.astype(bool) if t == BOOL else r for r, t in zip(returned, function.results, strict=True)),
        ]
        found = [r if r.ndim else r[()] for r in found]
        return found[0] if len(found) == 1 else tuple(found)

    def _input(self, parameter: Parameter, value: Any) -> Array:
        if isinstance(parameter.type, ArrayType):
            return array_argument(self.function.name, parameter, value, self.dtypes[parameter.type.scalar])
        assert isinstance(parameter.type, Scalar)
        return number_argument(self.function.name, parameter, value, self.dtypes[parameter.type])

    def _result(self, type: ArrayType, given: Array | None, lead: tuple[int, ...]) -> Array:
        """A new array, with the values of what is changed."""
        if given is None:
            return np.zeros((*lead, *(n or 0 for n in type.sizes)), self.dtypes[type.scalar])
        own = given.shape[given.ndim - len(type.sizes) :]
        return np.array(np.broadcast_to(given, (*lead, *own)), order="C")


def _lead(parameter: Parameter, array: Array) -> tuple[int, ...]:
    """The leading axes of an argument: those of items."""
    axes = len(parameter.type.sizes) if isinstance(parameter.type, ArrayType) else 0
    return array.shape[: array.ndim - axes]


def array_argument(name: str, parameter: Parameter, value: Any, dtype: Any) -> Array:
    """An argument as an array whose last axes are the parameter's.

    Raises
    ------
    InputError, ShapeError
        If it holds no such numbers, or has other lengths.
    """
    declared = parameter.type
    assert isinstance(declared, ArrayType)
    is_real = declared.scalar == REAL
    array = floating(value, f"{name}: {parameter.name}") if is_real else integers(name, parameter, value)
    sizes = declared.sizes
    last = array.shape[array.ndim - len(sizes) :] if array.ndim >= len(sizes) else ()
    if len(last) != len(sizes) or any(n is not None and n != m for n, m in zip(sizes, last, strict=True)):
        expected = ", ".join("n" if n is None else str(n) for n in sizes)
        raise ShapeError(f"{name}: {parameter.name} has shape {array.shape}; its last axes must be ({expected}).")
    return array.astype(dtype, copy=False)


def number_argument(name: str, parameter: Parameter, value: Any, dtype: Any) -> Array:
    """A number for each item."""
    if parameter.type == REAL:
        return floating(value, f"{name}: {parameter.name}").astype(dtype, copy=False)
    array = np.asarray(value)
    if parameter.type == BOOL and array.dtype.kind == "b":
        return array.astype(dtype)
    return integers(name, parameter, value)


def integers(name: str, parameter: Parameter, value: Any) -> Array:
    """The value as integers of 64 bits."""
    array = np.asarray(value)
    if array.dtype.kind not in "iu":
        raise InputError(f"{name}: {parameter.name} has type {array.dtype}; integers are needed.")
    return array.astype(np.int64)


def c_loop(library: Any, name: str) -> Loop:
    """A loop of a compiled program."""
    ffi, run = library.ffi, getattr(library.lib, name)

    def loop(begin: int, end: int, arrays: Sequence[Array], strides: Sequence[int], counts: Sequence[int]) -> None:
        pointers = ffi.new("void *[]", [ffi.from_buffer(a) for a in arrays])
        run(begin, end, pointers, ffi.new("ptrdiff_t[]", list(strides)), ffi.new("ptrdiff_t[]", list(counts)))

    return loop


def numba_signature(dtypes: Iterable[Any]) -> Any:
    """Types of a loop over flat arrays of these types."""
    from .numba_jit import numba

    types = numba().types
    of = {np.dtype(np.float64): types.float64, np.dtype(np.int64): types.int64}
    row = types.Array(types.int64, 1, "C")
    return types.void(types.intp, types.intp, row, row, *(types.Array(of[np.dtype(d)], 1, "C") for d in dtypes))


def numba_loop(compiled: Callable[..., None]) -> Loop:
    """A loop that numba has compiled."""

    def loop(begin: int, end: int, arrays: Sequence[Array], strides: Sequence[int], counts: Sequence[int]) -> None:
        writable = [a if a.flags.writeable and a.flags.aligned else a.copy() for a in arrays]
        compiled(begin, end, np.array(strides, np.int64), np.array(counts, np.int64), *writable)

    return loop


def printed_loop(name: str, text: str, function: Function) -> Loop:
    """The loop of a printed Python text, compiled by numba, from the cache where it was compiled before."""
    from .numba_cache import CachedModule

    of = {REAL: np.float64, INT: np.int64, BOOL: np.int64}
    scalars = [p.type.scalar if isinstance(p.type, ArrayType) else p.type for p in function.parameters]
    signature = numba_signature(of[s] for s in (*scalars, *function.results))  # type: ignore[index]
    return numba_loop(CachedModule(name, text, {"loop_over_items_": signature})["loop_over_items_"])
