"""Compiled algorithms as functions of arrays: one item after another, leading axes broadcast."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import _cffi_backend
import numpy as np
from numpy import empty

from ..errors import InputError, ShapeError
from ..ir.loops.types import BOOL, INT, REAL, ArrayType, Parameter, Scalar
from .arrays import Array, broadcast_leads, floating
from .ranges import parallel_for

if TYPE_CHECKING:
    from ..ir.loops.nodes import Function

from_buffer = _cffi_backend.FFI().from_buffer

#: Integers are less than this.
_LIMIT = 1 << 63
#: Numbers of arrays by `ArrayType.storage`, and of scalars by their type.
STORED = {"Real": np.float64, "Int": np.int64, "Bool": np.int64, "Int32": np.int32, "Int8": np.uint8}
#: Runs items [begin, end).
Run = Callable[[int, int], None]


class Loop(ABC):
    """The compiled loop of an algorithm over items.

    Attributes
    ----------
    hold : callable
        Takes an array without gaps, for calls as long as it lives.
    """

    hold: Callable[[Array], Any]
    #: Whether all items are one run, not shared out to threads.
    runs_whole = False

    @abstractmethod
    def bind(self, arrays: Sequence[Any], strides: Any, counts: Any) -> Run:
        """Bind arrays, numbers from item to item, and rows of open arrays, all as `hold` and `integers` made them.

        What is bound lives as long as what is returned.
        """

    @abstractmethod
    def integers(self, values: Sequence[int]) -> Any:
        """Strides or counts, for any number of calls."""

    def number(self, value: Any, type: str) -> Any:
        """Hold one number, "Real" or an integer, as an array of one."""
        return self.hold(np.array((value,), np.float64 if type == "Real" else np.int64))

    def work(self, size: int, dtype: Any) -> Any:
        """An array of so many numbers of the loop's own, held: nobody reads what a call leaves there."""
        return self.hold(np.empty(size, dtype))


class ItemFunction:
    """An algorithm for one choice of sizes, on one target and precision.

    Parameters
    ----------
    function : Function
    loop : Loop
    dtype : float64 or float32
    """

    def __init__(self, function: Function, loop: Loop, dtype: Any) -> None:
        self.function = function
        self.loop = loop
        self.dtypes = {REAL: np.dtype(dtype), INT: np.dtype(np.int64), BOOL: np.dtype(np.int64)}

    def _dtype(self, type: ArrayType) -> Any:
        return self.dtypes[REAL] if type.scalar == REAL else np.dtype(STORED[type.storage])

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
            loop = self.loop
            held = [loop.hold(a) for a in flat]
            run = loop.bind(held, loop.integers(strides), loop.integers(counts))
            if loop.runs_whole:
                run(0, n)
            else:
                parallel_for(run, n)
        found = [
            *results,
            *(r.astype(bool) if t == BOOL else r for r, t in zip(returned, function.results, strict=True)),
        ]
        found = [r if r.ndim else r[()] for r in found]
        return found[0] if len(found) == 1 else tuple(found)

    def _input(self, parameter: Parameter, value: Any) -> Array:
        if isinstance(parameter.type, ArrayType):
            return array_argument(self.function.name, parameter, value, self._dtype(parameter.type))
        assert isinstance(parameter.type, Scalar)
        return number_argument(self.function.name, parameter, value, self.dtypes[parameter.type])

    def _result(self, type: ArrayType, given: Array | None, lead: tuple[int, ...]) -> Array:
        """A new array, with the values of what is changed."""
        if given is None:
            return np.zeros((*lead, *(n or 0 for n in type.sizes)), self._dtype(type))
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
    is_truth = parameter.type == BOOL
    if not (is_truth and array.dtype.kind == "b"):
        array = integers(name, parameter, value)
    return (array != 0).astype(dtype) if is_truth else array


def integers(name: str, parameter: Parameter, value: Any) -> Array:
    """The value as integers of 64 bits."""
    array = np.asarray(value)
    if array.dtype.kind not in "iu":
        raise InputError(f"{name}: {parameter.name} has type {array.dtype}; integers are needed.")
    if array.dtype.kind == "u" and array.size and int(array.max()) >= _LIMIT:
        raise InputError(f"{name}: {parameter.name} has an integer of more than 64 bits with a sign.")
    return array.astype(np.int64)


class CLoop(Loop):
    """The loop of a compiled program.

    Parameters
    ----------
    library : module
        With ``ffi`` and ``lib``.
    tag : str
        Of its instance, such as "f64".
    name : str
        Of the loop.

    Attributes
    ----------
    run : callable
        The compiled loop: of pointers, strides, counts, and the range of items.
    """

    def __init__(self, library: Any, tag: str, name: str = "bs_loop") -> None:
        ffi = library.ffi
        self.hold, self._new, self._pointers = ffi.from_buffer, ffi.new, ffi.typeof("void *[]")
        self.run, self._null = getattr(library.lib, f"{name}_{tag}"), ffi.NULL
        self._address = int(ffi.cast("uintptr_t", ffi.addressof(library.lib, f"{name}_{tag}")))

    def bind(self, arrays: Sequence[Any], strides: Any, counts: Any) -> Run:
        run = partial(self.run, self._new(self._pointers, arrays), strides, counts)
        run.__dict__["arrays"] = arrays  # of which the pointers know nothing
        return run

    def item_call(self, shared: Sequence[Any], strides: Any, counts: Any, shape: tuple[int, ...]) -> ItemCall:
        """The loop for single items that share all arrays but the last one, a row, and the result; see `ItemCall`."""
        return ItemCall(self._address, shared, strides, counts, shape)

    def pointers(self, arrays: Sequence[Any]) -> Any:
        """Pointers to arrays as `hold` made them, which who calls keeps; null in place of those that calls set."""
        return self._new(self._pointers, [self._null if a is None else a for a in arrays])

    def integers(self, values: Sequence[int]) -> Any:
        return self._new("ptrdiff_t[]", list(values))

    def number(self, value: Any, type: str) -> Any:
        return self._new("double *", value) if type == "Real" else self._new("ptrdiff_t *", int(value))


class ItemCall:
    """A compiled loop as a function of a row of numbers, for calls of single items in control loops.

    Calls share nothing that they write, also where another thread, or a handler of a signal, calls meanwhile.

    Parameters
    ----------
    loop : int
        Address of the compiled loop.
    shared : sequence
        Arrays before the row and the result, as `Loop.hold` made them: at most 14.
    strides, counts : as `Loop.integers` makes them
    shape : tuple of int
        Of the result.

    Raises
    ------
    CompilerMissingError
        As by `calls_extension`.
    """

    def __init__(self, loop: int, shared: Sequence[Any], strides: Any, counts: Any, shape: tuple[int, ...]) -> None:
        from ..build.calls import calls_extension

        module = calls_extension()
        ffi = module.ffi
        self._run, self._kept = module.lib.bs_call_row, (*shared, strides, counts)
        self._shape, self._size = None if len(shape) == 1 else shape, math.prod(shape)
        call = self._call = ffi.new("bs_row_call *")
        call.loop, call.shared, call.size = ffi.cast("void *", loop), len(shared), self._size
        call.arrays[0 : len(shared)] = [ffi.cast("void *", a) for a in shared]
        call.strides, call.counts = (ffi.cast("ptrdiff_t *", a) for a in (strides, counts))

    def __call__(self, row: Array) -> Array | None:
        """The result, for a row without gaps in double precision; None where it is not finite."""
        result = empty(self._size)
        if not self._run(self._call, from_buffer(row), from_buffer(result)):
            return None
        return result if self._shape is None else result.reshape(self._shape)


class CompiledLoop(Loop):
    """A loop that numba has compiled."""

    def __init__(self, compiled: Callable[..., None]) -> None:
        self.hold, self._run = flat, compiled

    def bind(self, arrays: Sequence[Any], strides: Any, counts: Any) -> Run:
        run = self._run
        return lambda begin, end: run(begin, end, strides, counts, *arrays)

    def integers(self, values: Sequence[int]) -> Any:
        return np.array(values, np.int64)


class NumbaLoop(CompiledLoop):
    """The loop of a printed Python text, compiled by numba, from the cache where it was compiled before.

    Parameters
    ----------
    name : str
    text : str
    function : Function
    """

    def __init__(self, name: str, text: str, function: Function) -> None:
        from .numba_cache import CachedModule

        scalars = [p.type.storage if isinstance(p.type, ArrayType) else p.type for p in function.parameters]
        signature = numba_signature([str(s) for s in (*scalars, *function.results)])
        super().__init__(CachedModule(name, text, {"loop_over_items_": signature})["loop_over_items_"])


def numba_signature(scalars: Sequence[str]) -> Any:
    """Types of a loop over flat arrays of such numbers, by the keys of `STORED`."""
    from .numba_jit import numba

    types = numba().types
    of = {name: getattr(types, np.dtype(stored).name) for name, stored in STORED.items()}
    row = types.Array(types.int64, 1, "C")
    return types.void(types.intp, types.intp, row, row, *(types.Array(of[s], 1, "C") for s in scalars))


def flat(array: Array) -> Array:
    """As the signature of compiled functions has it."""
    flat = array.reshape(-1)
    return flat if flat.flags.writeable and flat.flags.aligned else flat.copy()
