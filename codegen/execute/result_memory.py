"""Memory of large results, used again when the last array on it is gone. Light: NumPy alone.

Fresh memory is cleared page by page when it is first written, which takes as long as a kernel of 10 ns per item. Blocks
below `LEAST` the C library itself uses again.

No function of Python runs when an array goes: an interrupt that came while a kernel ran would be raised there, and be
lost, as all that is raised while objects are destroyed.
"""

from __future__ import annotations

import math
import os
import weakref
from collections import deque
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
    """What arrays on a block's memory hold. With the last of them it goes, and its loan is over."""

    __slots__ = ("loan", "__array_interface__", "__weakref__")

    def __init__(self, memory: Array, free: deque[_Loan], shape: tuple[int, ...], dtype: np.dtype[Any]) -> None:
        self.loan = _Loan(self, free.append)  # held here, so that it lives until `free` has it
        self.loan.memory = memory
        address = memory.__array_interface__["data"][0]
        self.__array_interface__ = {"data": (address, False), "shape": shape, "typestr": dtype.str, "version": 3}


class _Loan(weakref.ref[_Block]):
    """Memory that a block has. The interpreter itself appends it to those that are free when the block goes."""

    __slots__ = ("memory",)
    memory: Array


class ResultMemory:
    """Blocks of memory that are not in use, up to a number of bytes.

    Of each size up to the half, a quarter, an eighth of that number one block is kept, of the smallest two. Any thread
    may take and give, also while objects are collected: there is no lock, each step is one of Python's own.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        classes = max(0, (most // LEAST).bit_length() - 2)  # the largest holds blocks of up to most / 2
        self._free: list[deque[_Loan]] = [deque(maxlen=1 if k else 2) for k in range(classes)]

    @property
    def kept(self) -> int:
        """Bytes of blocks that are not in use."""
        return sum(loan.memory.nbytes for free in self._free for loan in tuple(free))

    def empty(self, shape: tuple[int, ...], dtype: Any) -> Array:
        """An array of any values."""
        kind = np.dtype(dtype)
        size = math.prod(shape) * kind.itemsize
        place = (size // LEAST).bit_length() - 1  # of blocks of LEAST to 2 LEAST, to 4 LEAST, ...
        if not 0 <= place < len(self._free):
            return np.empty(shape, kind)
        free = self._free[place]
        return np.asarray(_Block(_take(free, size), free, shape, kind))


def _take(free: deque[_Loan], size: int) -> Array:
    for _ in range(len(free)):
        try:
            loan = free.popleft()
        except IndexError:  # another thread was faster
            break
        if FILLED * loan.memory.nbytes <= size <= loan.memory.nbytes:
            return loan.memory
        free.append(loan)
    return np.empty(size, np.uint8)


def _limit() -> int:
    value = os.environ.get(LIMIT_VARIABLE, "")
    return int(value) << 20 if value.isdecimal() else MOST


STORE = ResultMemory(_limit())
