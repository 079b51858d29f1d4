"""Rows of (n, k) arrays to columns of a block and back, and selection: what generated numba modules import.

Plain Python, compiled together with the kernels; run as it is, it does the same.
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
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


def _select_number(mask: bool, a: float, b: float) -> float:
    return a if mask else b  # compilers make a blend of it


def compiled(decorate: Callable[[Callable[..., Any]], Any]) -> SimpleNamespace:
    """The functions for numbers, each put through ``decorate``: `numba.njit` with options."""
    return SimpleNamespace(load=decorate(load), store=decorate(store), select=decorate(_select_number))
