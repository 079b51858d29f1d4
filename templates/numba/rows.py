"""Rows of (n, k) arrays to columns of a block and back, and selection: what every generated numba module imports.

Plain Python. bladesmith compiles these functions together with the kernels; run as they are, they do the same.
"""

from __future__ import annotations

from typing import Any

import numpy as np

#: Items per block: columns short enough to stay in the first-level cache, long enough for vector loops.
BLOCK = 64


def load(columns: Any, rows: Any, begin: int, count: int, step: int) -> None:
    """Transpose ``count`` rows into columns; ``step`` 0 repeats the first row."""
    for i in range(count):
        for j in range(columns.shape[0]):
            columns[j, i] = rows[(begin + i) * step, j]


def store(rows: Any, columns: Any, begin: int, count: int) -> None:
    """Transpose columns into ``count`` rows."""
    for i in range(count):
        for j in range(columns.shape[0]):
            rows[begin + i, j] = columns[j, i]


def select(mask: Any, a: Any, b: Any) -> Any:
    """``a`` where ``mask``, else ``b``; both were computed. For numbers and for columns."""
    return np.where(mask, a, b)[()]


def select_number(mask: bool, a: float, b: float) -> float:
    """`select` as it is compiled: a branch that the compiler makes a blend of."""
    return a if mask else b
