"""Memory of large results, used again when the last array on it is gone. Light: NumPy alone.

Fresh memory is cleared page by page when it is first written, which takes as long as a kernel of 10 ns per item. Blocks
below `LEAST` the C library itself uses again.
"""

from __future__ import annotations

import contextlib
import math
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
#: Environment variable: how many megabytes are kept at most; 0 keeps nothing.
LIMIT_VARIABLE = "BLADESMITH_KEEP_MB"
#: Bytes kept at most, unless the variable says otherwise.
MOST = 256 << 20
#: Results of fewer bytes are allocated as usual.
LEAST = 16 << 20
#: Results of fewer items are smaller than that, but for matrices of hundreds of numbers.
MANY = LEAST >> 10
#: A block serves results of down to this part of its size.
FILLED = 0.75


class _Block:
    """Memory of one result: arrays on it hold it, and it goes back to its store with the last of them."""

    __slots__ = ("memory", "store", "__array_interface__")

    def __init__(self, memory: Array, store: ResultMemory, shape: tuple[int, ...], dtype: np.dtype[Any]) -> None:
        self.memory = memory
        self.store = store
        address = memory.__array_interface__["data"][0]
        self.__array_interface__ = {"data": (address, False), "shape": shape, "typestr": dtype.str, "version": 3}

    def __del__(self) -> None:
        with contextlib.suppress(Exception):  # the interpreter ends
            self.store.give(self.memory)


class ResultMemory:
    """Blocks of memory that are not in use, up to a number of bytes.

    Any thread may take and give, also while objects are collected: there is no lock, each step is one of Python's own.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self._free: dict[int, Array] = {}

    @property
    def kept(self) -> int:
        """Bytes of blocks that are not in use."""
        return sum(memory.nbytes for memory in tuple(self._free.values()))

    def empty(self, shape: tuple[int, ...], dtype: Any) -> Array:
        """An array of any values."""
        kind = np.dtype(dtype)
        size = math.prod(shape) * kind.itemsize
        if size < LEAST or size > self.most:
            return np.empty(shape, kind)
        return np.asarray(_Block(self._take(size), self, shape, kind))

    def _take(self, size: int) -> Array:
        for key, memory in tuple(self._free.items()):
            if FILLED * memory.nbytes <= size <= memory.nbytes and self._free.pop(key, None) is not None:
                return memory
        return np.empty(size, np.uint8)

    def give(self, memory: Array) -> None:
        """Keep a block; those that were kept for longest go, where there are too many bytes."""
        self._free[id(memory)] = memory
        for key in tuple(self._free):
            if self.kept <= self.most:
                return
            self._free.pop(key, None)


def _limit() -> int:
    value = os.environ.get(LIMIT_VARIABLE, "")
    return int(value) << 20 if value.isdecimal() else MOST


STORE = ResultMemory(_limit())
