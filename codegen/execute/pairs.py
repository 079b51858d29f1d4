"""Kernels of two operands on all pairs of rows: (n, m) results, or for each row the nearest of others.

Compiled kernels run in one loop over pairs (see kernels.cdef of templates), all others on blocks of pairs written out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ..errors import InputError, ShapeError
from .arrays import Array, Binding, floating
from .bound_kernels import PLAN_OUTPUTS, BoundKernel
from .ranges import Splitter

#: Pairs that are written out at a time where no compiled loop makes them.
BLOCK_PAIRS = 32768
Part = Callable[[int, int], None]


def all_pairs(kernel: Binding, first: Any, second: Any, split: Splitter | None = None) -> Any:
    """Results of a kernel for each row of ``first`` with each row of ``second``.

    Parameters
    ----------
    kernel : Binding
        Of two operands.
    first, second : arrays (n, size), (m, size)
        Or (n,), (m,) for plain numbers.
    split : callable, optional
        Shares the rows of ``first`` over threads; default: one call.

    Returns
    -------
    array (n, m, size), or (n, m) for a status
        A tuple of them where the kernel has several results.

    Raises
    ------
    ShapeError, InputError
        If the kernel does not take two operands, or these are no rows for it.
    """
    a, b = _rows(kernel, first, second)
    lead = (len(a), len(b))
    results = kernel.empty_results(lead, a.dtype)
    if math.prod(lead):
        make = _compiled_pairs if _is_compiled(kernel, a) else _written_pairs
        (split or _whole)(make(kernel, a, b, results), len(a))
    return results[0] if len(results) == 1 and not kernel.outputs[0].is_status else tuple(results)


def nearest(kernel: Binding, first: Any, second: Any, split: Splitter | None = None) -> tuple[Array, Array]:
    """For each row of ``first`` the row of ``second`` with the least value of a kernel of one number.

    Parameters
    ----------
    kernel, first, second, split
        As for `all_pairs`.

    Returns
    -------
    index : array (n,) of int64
        NaN never wins, the first of equal values does; -1 where there is nothing but NaN and infinity.
    least : array (n,)
        The value, infinity there.

    Raises
    ------
    ShapeError, InputError
        As `all_pairs`, and if the kernel's result is not one number.
    """
    if len(kernel.outputs) != 1 or kernel.outputs[0].is_status or kernel.outputs[0].size > 1:
        raise InputError(f"{kernel.symbol} has not one number as its result, so none of its values is the least.")
    a, b = _rows(kernel, first, second)
    index, least = np.full(len(a), -1, np.int64), np.full(len(a), np.inf, a.dtype)
    if len(a) and len(b):
        make = _compiled_nearest if _is_compiled(kernel, a) else _written_nearest
        (split or _whole)(make(kernel, a, b, index, least), len(a))
    return index, least


def _rows(kernel: Binding, first: Any, second: Any) -> tuple[Array, Array]:
    """Both operands as contiguous rows of one floating type."""
    if len(kernel.inputs) != 2:
        raise InputError(f"{kernel.symbol} takes {len(kernel.inputs)} arrays; pairs are of two.")
    if len(kernel.outputs) > PLAN_OUTPUTS:
        raise InputError(f"{kernel.symbol} has {len(kernel.outputs)} results; pairs have {PLAN_OUTPUTS} at most.")
    rows = [floating(x, item.name) for x, item in zip((first, second), kernel.inputs, strict=True)]
    for array, item in zip(rows, kernel.inputs, strict=True):
        if array.ndim != (2 if item.size else 1) or (item.size and array.shape[-1] != item.size):
            wanted = f"(n, {item.size})" if item.size else "(n,)"
            raise ShapeError(f"{kernel.symbol}: {item.name} has shape {array.shape}; rows {wanted} are needed.")
    dtype = rows[0].dtype if rows[0].dtype == rows[1].dtype else np.dtype(np.float64)
    a, b = (np.ascontiguousarray(x, dtype) for x in rows)
    return a, b


def _is_compiled(kernel: Binding, a: Array) -> bool:
    return isinstance(kernel, BoundKernel) and kernel.provide(a.dtype == np.float32)


def _whole(part: Part, n: int) -> None:
    part(0, n)


# -- compiled ----------------------------------------------------------------------------------------------


def _compiled_pairs(kernel: Any, a: Array, b: Array, results: Sequence[Array]) -> Part:
    ffi, run = kernel.library.ffi, kernel.library.lib.bs_run_pairs
    outs = ffi.new("void *[]", [ffi.from_buffer(r) for r in results])
    widths = [r.itemsize * max(o.size, 1) for r, o in zip(results, kernel.outputs, strict=True)]
    sizes = ffi.new("ptrdiff_t[]", widths)
    one, two, single = ffi.from_buffer(a), ffi.from_buffer(b), int(a.dtype == np.float32)

    def part(begin: int, end: int) -> None:
        run(kernel.index, single, begin, end, len(b), len(widths), outs, sizes, one, a.strides[0], two)

    return part


def _compiled_nearest(kernel: Any, a: Array, b: Array, index: Array, least: Array) -> Part:
    ffi, run = kernel.library.ffi, kernel.library.lib.bs_run_nearest
    labels, values = ffi.cast("int64_t *", ffi.from_buffer(index)), ffi.from_buffer(least)
    one, two, single = ffi.from_buffer(a), ffi.from_buffer(b), int(a.dtype == np.float32)

    def part(begin: int, end: int) -> None:
        run(kernel.index, single, begin, end, len(b), labels, values, one, a.strides[0], two, b.strides[0])

    return part


# -- written out -------------------------------------------------------------------------------------------


def _blocks(begin: int, end: int, m: int) -> Iterator[slice]:
    """Some rows at a time, so that their pairs with m others are at most `BLOCK_PAIRS`, where that can be."""
    step = max(1, BLOCK_PAIRS // m)
    for first in range(begin, end, step):
        yield slice(first, min(first + step, end))


def _written_pairs(kernel: Binding, a: Array, b: Array, results: Sequence[Array]) -> Part:
    def part(begin: int, end: int) -> None:
        for rows in _blocks(begin, end, len(b)):
            left = np.repeat(a[rows], len(b), axis=0)
            right = np.concatenate([b] * (rows.stop - rows.start))
            flat = [r[rows].reshape(len(left), *r.shape[2:]) for r in results]  # views: their rows are whole
            kernel.run([left, right], flat, len(left))

    return part


def _written_nearest(kernel: Binding, a: Array, b: Array, index: Array, least: Array) -> Part:
    def part(begin: int, end: int) -> None:
        for rows in _blocks(begin, end, len(b)):
            values = np.empty((rows.stop - rows.start, len(b), 1), a.dtype)
            _written_pairs(kernel, a[rows], b, [values])(0, len(values))
            found = np.where(np.isnan(values), np.inf, values)[..., 0]
            best = found.argmin(1)
            least[rows] = found[np.arange(len(found)), best]
            index[rows] = np.where(least[rows] < np.inf, best, -1)

    return part
