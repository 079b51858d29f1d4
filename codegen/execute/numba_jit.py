"""Printed numba modules, loaded and run on arrays. Light: NumPy, and numba where it is installed.

A text is loaded once per precision. Compiled, its batch functions run over rows; without numba its kernels
run on whole columns, an operation at a time, and give the same bits. Nothing is generated here.
"""

from __future__ import annotations

import hashlib
import linecache
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from threading import RLock
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from ..errors import MissingExtraError
from ..ir.argument import Argument
from .arrays import Array, Binding
from .ranges import parallel_for

#: What makes compiled code give the bits of plain Python: no division raises, and nothing is reassociated.
#: A kernel is inlined into its loop, which LLVM then vectorises.
OPTIONS = {"error_model": "numpy", "fastmath": False, "nogil": True, "forceinline": True}
#: Items at a time without numba: temporaries that stay in the second-level cache.
CHUNK = 4096


def load(source: str, dtype: Any = np.float64, compiled: bool = True) -> ModuleType:
    """Module of a printed text, for one precision.

    Its lines are registered with `linecache`, so that tracebacks and debuggers show them.

    Parameters
    ----------
    source : str
        As printed by `numba_source`.
    dtype : float64 or float32
        Type of the constants; arguments are of the same type.
    compiled : bool
        Wrap every function for numba; each is compiled when it is first called.

    Raises
    ------
    MissingExtraError
        If ``compiled`` and numba is not installed.
    """
    digest = hashlib.sha256(source.encode()).hexdigest()[:12]
    module = ModuleType(f"bladesmith_numba_{digest}")
    filename = f"<bladesmith numba {digest}>"
    linecache.cache[filename] = (len(source), None, source.splitlines(keepends=True), filename)
    exec(compile(source, filename, "exec"), vars(module))
    vars(module)["K"] = np.dtype(dtype).type
    if compiled:
        for name, value in list(vars(module).items()):
            if isinstance(value, FunctionType):
                own = value.__globals__ is vars(module)
                vars(module)[name] = _jit(value) if own else getattr(support(value.__module__), name)
    return module


@cache
def support(module: str) -> Any:
    """Functions of a module that printed texts import, wrapped for numba."""
    return import_module(module).compiled(_jit)


def _jit(function: Callable[..., Any]) -> Any:
    return numba().njit(**OPTIONS)(function)


@cache
def numba() -> Any:
    """The package numba, where it is installed."""
    try:
        return import_module("numba")
    except ImportError:
        raise MissingExtraError("numba", "Compiling kernels without a C compiler") from None


class NumbaLibrary:
    """A printed text and its modules, one per precision, loaded when they are first needed.

    Parameters
    ----------
    source : str
        As printed by `numba_source`.
    compiled : bool
        False: run on columns, with NumPy alone.

    Raises
    ------
    MissingExtraError
        If ``compiled`` and numba is not installed.
    """

    def __init__(self, source: str, compiled: bool = True) -> None:
        self.source = source
        self.compiled = compiled
        self._modules: dict[np.dtype[Any], ModuleType] = {}
        self._lock = RLock()
        if compiled:
            numba()

    def module(self, dtype: np.dtype[Any]) -> ModuleType:
        """The module of one precision."""
        with self._lock:
            if dtype not in self._modules:
                self._modules[dtype] = load(self.source, dtype, self.compiled)
            return self._modules[dtype]

    def batch(self, symbol: str, dtype: np.dtype[Any], inputs: int, outputs: Sequence[Argument]) -> Any:
        """The compiled loop of one kernel; its only signature takes writable and read-only inputs alike."""
        types = numba().types
        scalar = types.float64 if dtype == np.float64 else types.float32
        row = types.Array(scalar, 2, "C", readonly=True)
        outs = [types.Array(types.uint8 if o.is_status else scalar, 2, "C") for o in outputs]
        with self._lock:
            batch = getattr(self.module(dtype), f"{symbol}_batch")
            if not batch.signatures:
                batch.compile(types.void(types.intp, types.intp, *outs, *([row, types.intp] * inputs)))
                batch.disable_compile()
            return batch


class NumbaKernel(Binding):
    """One kernel of a printed text, as a function of arrays.

    Parameters
    ----------
    library : NumbaLibrary
    symbol : str
        Name in the text.
    inputs, outputs : sequences of Argument
    """

    def __init__(
        self, library: NumbaLibrary, symbol: str, inputs: Sequence[Argument], outputs: Sequence[Argument]
    ) -> None:
        super().__init__(symbol, inputs, outputs)
        self.library = library
        self._batches: dict[np.dtype[Any], Any] = {}

    def run(self, arrays: Sequence[Array], results: Sequence[Array], n: int) -> None:
        """Compute ``n`` items: compiled over rows, or with NumPy on columns."""
        if n == 0:
            return
        dtype = arrays[0].dtype if arrays else np.dtype(np.float64)
        outs = [r.reshape(n, -1) for r in results]
        ins = [a.reshape(-1, max(item.size, 1)) for a, item in zip(arrays, self.inputs, strict=True)]
        steps = [int(stride > 0) for stride in self.strides(arrays)]
        if not self.library.compiled:
            parallel_for(self._on_columns(dtype, ins, outs, steps), n)
            return
        batch = self._batches.get(dtype)
        if batch is None:
            batch = self.library.batch(self.symbol, dtype, len(self.inputs), self.outputs)
            self._batches[dtype] = batch
        aligned = [a if a.flags.aligned else a.copy() for a in ins]  # as the signature has it
        operands = [*outs, *(value for pair in zip(aligned, steps, strict=True) for value in pair)]
        parallel_for(lambda begin, end: batch(begin, end, *operands), n)

    def _on_columns(
        self, dtype: np.dtype[Any], ins: Sequence[Array], outs: Sequence[Array], steps: Sequence[int]
    ) -> Callable[[int, int], None]:
        kernel = getattr(self.library.module(dtype), self.symbol)

        def chunk(items: slice) -> None:
            columns: list[Any] = []
            for array, step in zip(ins, steps, strict=True):
                columns.extend(np.ascontiguousarray(array[items].T) if step else array[0])
            returned = kernel(*columns)
            for out, values in zip(outs, (returned,) if len(outs) == 1 else returned, strict=True):
                for j, value in enumerate(values):
                    out[items, j] = value

        def part(begin: int, end: int) -> None:
            with np.errstate(all="ignore"):  # of a selection, both branches are computed
                for first in range(begin, end, CHUNK):
                    chunk(slice(first, min(first + CHUNK, end)))

        return part
