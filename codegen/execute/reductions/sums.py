"""Sums of a kernel's results over all items, compensated: as if each addition were made in twice the precision.

Every number is added in double precision, and the rounding error of the addition to a second sum (Ogita, Rump and
Oishi, "Accurate sum and dot product", 2005: Sum2). Blocks of items have sums of their own, in each of which items stand
side by side in lanes; both are added in pairs at the end. So the order depends on the number of items alone: threads
and targets give the same bits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...status import Status
from ..arrays import Array, Binding
from ..bound_kernels import PLAN_INPUTS, PLAN_OUTPUTS, BoundKernel
from ..ranges import parallel_for

#: Items of a block, those that are computed at once, and those that are added side by side: powers of two.
BLOCK, TILE, LANES = 1 << 14, 1 << 7, 1 << 4
#: Items that a thread takes first.
FIRST = 4 * BLOCK
Part = Callable[[int, int], None]


def run_sums(
    kernel: Binding, arrays: Sequence[Any], is_summed: Sequence[bool] | None = None
) -> tuple[list[Array], tuple[int, ...]]:
    """Sums of the results of a kernel over all items.

    Parameters
    ----------
    kernel : Binding
    arrays : sequence of array
        As for a call.
    is_summed : sequence of bool, optional
        One for each result: others are as of a call. Default: all are summed.

    Returns
    -------
    list of array (size,)
        In the type that the results have; of a status the first one with which an item has no value, else
        `NOT_UNIQUE` where there is one. Zeros for no items.
    tuple of int
        The shape of the items.

    Raises
    ------
    ShapeError, InputError
        As a call of the kernel.
    """
    prepared, lead = kernel.prepare(arrays)
    n, dtype = math.prod(lead), prepared[0].dtype
    blocks = -(-n // BLOCK)
    is_summed = is_summed or [True] * len(kernel.outputs)
    sums: list[Array] = [
        kernel.empty_result(o, lead, dtype) if not summed
        else np.zeros(blocks, np.uint8) if o.is_status else np.zeros((blocks, 2, o.size))
        for o, summed in zip(kernel.outputs, is_summed, strict=True)
    ]  # fmt: skip
    if n and not any(is_summed):
        kernel.run(prepared, sums, n)
    elif n:
        make = _compiled if _is_compiled(kernel, dtype) else _written
        part = make(kernel, prepared, n, sums, is_summed)
        parallel_for(lambda begin, end: part(begin // BLOCK, -(-end // BLOCK)), n, FIRST, BLOCK)
    results = [
        s if not summed else _first_code(s) if o.is_status else _rounded(_total(s), dtype)
        for s, o, summed in zip(sums, kernel.outputs, is_summed, strict=True)
    ]
    return results, lead


def sum_items(values: Array) -> Array:
    """The sum over the first axis of an array (n, size), in the order, precision and type of `run_sums`."""
    blocks, width = -(-len(values) // BLOCK), values.shape[1]
    total = np.empty(width)
    for begin in range(0, width, BLOCK):  # wide rows in parts, so that lanes of them stay small
        part = values[:, begin : begin + BLOCK]
        sums = np.zeros((blocks, 2, part.shape[1]))
        for block in range(blocks):
            sums[block] = _block_sum(part[block * BLOCK : (block + 1) * BLOCK])
        total[begin : begin + BLOCK] = _total(sums)
    return _rounded(total, values.dtype)


def _rounded(total: Array, dtype: Any) -> Array:
    """Sums in the type of results: infinite where they are too large for it."""
    with np.errstate(over="ignore"):
        return total.astype(dtype)


def _is_compiled(kernel: Binding, dtype: Any) -> bool:
    """Return whether the library of a kernel has the loop: that of kernels which are made at run time has."""
    is_small = len(kernel.inputs) <= PLAN_INPUTS and len(kernel.outputs) <= PLAN_OUTPUTS
    return (
        is_small
        and isinstance(kernel, BoundKernel)
        and hasattr(kernel.library.lib, "bs_run_sums")
        and kernel.provide(dtype == np.float32)
    )


def _compiled(kernel: Any, arrays: Sequence[Array], n: int, sums: Sequence[Array], is_summed: Sequence[bool]) -> Part:
    ffi, run = kernel.library.ffi, kernel.library.lib.bs_run_sums
    dtype = arrays[0].dtype
    sizes = [o.size for o in kernel.outputs]
    pointers = [ffi.new("void *[]", [ffi.from_buffer(a) for a in several]) for several in (sums, arrays)]
    counts, strides = ffi.new("ptrdiff_t[]", sizes), ffi.new("ptrdiff_t[]", kernel.strides(arrays))
    whole = zip(sums, sizes, is_summed, strict=True)
    widths = [0 if summed else s.itemsize * max(size, 1) for s, size, summed in whole]
    rows = ffi.new("ptrdiff_t[]", widths)

    def part(begin: int, end: int) -> None:
        tiles = [np.empty(TILE * s, dtype) if s else np.empty(TILE, np.uint8) for s in sizes]
        lanes = [np.empty(2 * LANES * s) for s in sizes]
        rooms = [ffi.new("void *[]", [ffi.from_buffer(a) for a in several]) for several in (tiles, lanes)]
        run(
            kernel.index, int(dtype == np.float32), begin, end, n, BLOCK, TILE, LANES, len(sizes), counts, rows,
            *rooms, pointers[0], len(arrays), pointers[1], strides,
        )  # fmt: skip

    return part


def _written(
    kernel: Binding, arrays: Sequence[Array], n: int, sums: Sequence[Array], is_summed: Sequence[bool]
) -> Part:
    """A block of items at a time, on targets whose loops do not sum."""
    columns = [a.reshape(n, -1) if step else a for a, step in zip(arrays, kernel.strides(arrays), strict=True)]

    def part(begin: int, end: int) -> None:
        for block in range(begin, end):
            first, last = block * BLOCK, min(n, (block + 1) * BLOCK)
            ins = [a[first:last] if step else a for a, step in zip(columns, kernel.strides(arrays), strict=True)]
            results = kernel.empty_results((last - first,), arrays[0].dtype)
            kernel.run(ins, results, last - first)
            for s, result, summed in zip(sums, results, is_summed, strict=True):
                if not summed:
                    s.reshape(n, *result.shape[1:])[first:last] = result
                    continue
                s[block] = _first_code(result) if result.dtype == np.uint8 else _block_sum(result)

    return part


def _first_code(codes: Array) -> Array:
    """The first status with which there is no value, else `NOT_UNIQUE` where there is one."""
    failed = codes[(codes != Status.OK) & (codes != Status.NOT_UNIQUE)]
    return np.asarray(failed[0] if len(failed) else codes.max(initial=Status.OK), np.uint8)


def _block_sum(values: Array) -> Array:
    """Sums (size,) of the rows of a block, and of their rounding errors: lanes, then pairs of lanes."""
    lanes = min(LANES, 1 << (len(values) - 1).bit_length())  # the others would be zero
    rows = np.zeros((-(-len(values) // lanes) * lanes, values.shape[1]))
    rows[: len(values)] = values
    sums = np.zeros((2, lanes, values.shape[1]))
    for row in rows.reshape(-1, lanes, values.shape[1]):
        sums = _add(sums, np.stack([row, np.zeros_like(row)]))
    return _pairs(sums)


def _add(a: Array, b: Array) -> Array:
    """Sums of two pairs of sum and error."""
    with np.errstate(all="ignore"):
        total = a[0] + b[0]
        part = total - a[0]
        error = a[1] + ((a[0] - (total - part)) + (b[0] - part))
        return np.stack([total, error + b[1]])


def _pairs(sums: Array) -> Array:
    """The sum over the second axis of (2, m, ..): halves are added to each other."""
    while sums.shape[1] > 1:
        half = (sums.shape[1] + 1) // 2
        first, second = sums[:, :half].copy(), sums[:, half:]
        first[:, : second.shape[1]] = _add(first[:, : second.shape[1]], second)
        sums = first
    return sums[:, 0]


def _total(sums: Array) -> Array:
    """The sum of blocks (blocks, 2, size), rounded once; what is infinite has no error."""
    if not len(sums):
        return np.zeros(sums.shape[2])
    total, error = _pairs(sums.transpose(1, 0, 2)) if len(sums) > 1 else sums[0]
    return np.asarray(np.where(np.isfinite(error), total + error, total))
