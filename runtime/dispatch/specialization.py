"""Kernels for combinations of kinds that are used much: generated, compiled and stored in the cache.

Until then, and wherever there is no compiler, the general product serves.
"""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable
from typing import Any

from numpy.typing import NDArray

from ..codegen.errors import BladesmithError
from .types import Type

#: Computes n rows: (out, a, b, n); an operand has n rows or one.
Rows = Callable[[NDArray[Any], NDArray[Any], NDArray[Any], int], None]
#: Items of one combination, in batches, after which a kernel is generated and compiled for it. A generated kernel
#: saves up to 0.1 microseconds per item (dense product of CGA: 69 instead of 160 ns) and costs up to a second.
HOT_ITEMS = 10_000_000
#: Set to 0 to stay with the general product.
SPECIALISE_VARIABLE = "BLADESMITH_SPECIALISE"
#: Larger tables are not specialised: their code would be larger than the processor's cache.
MAX_SPECIAL_TERMS = 2048
_log = logging.getLogger("bladesmith")


def operation_formula(operation: str) -> Callable[..., Any]:
    """The operation in GA notation."""
    from ..codegen.formulas.products import products

    return getattr(products, operation)  # type: ignore[no-any-return]


def specialize_when_hot(rows: Rows, key: tuple[str, Type, Type], out: Type, terms: int) -> Rows:
    """Rows that are specialised once `HOT_ITEMS` items went through them."""
    if terms > MAX_SPECIAL_TERMS or os.environ.get(SPECIALISE_VARIABLE) == "0":
        return rows
    current, items = rows, 0

    def run(result: NDArray[Any], x: NDArray[Any], y: NDArray[Any], n: int) -> None:
        nonlocal current, items
        items += n
        if items > HOT_ITEMS and current is rows:
            special = compile_specialized(key, out, items)
            current = special or _forever(rows)
        current(result, x, y, n)

    return run


def _forever(rows: Rows) -> Rows:
    """Another object that does the same: it is not tried again."""
    return lambda *arguments: rows(*arguments)


def compile_specialized(key: tuple[str, Type, Type], out: Type, items: int) -> Rows | None:
    """Generate and compile one combination, or None where that is not possible."""
    operation, a, b = key
    what = f"{a.algebra.name}: {operation} of {a.kind.name} and {b.kind.name}"
    start = time.perf_counter()
    try:
        from ..codegen.compiler import compile_kernel, optimise_quickly, trace_kernel

        name = f"{operation}_{a.kind.name}_{b.kind.name}"
        traced = trace_kernel(operation_formula(operation), (a.kind, b.kind), name, out.kind, a.algebra)
        kernel = compile_kernel(optimise_quickly(traced), "f32" if out.single else "f64")
    except BladesmithError as error:
        _log.info("%s stays with the general product: %s", what, error)
        return None
    seconds = time.perf_counter() - start
    _log.info("%s specialised after %d items in %.2f s.", what, items, seconds)
    return lambda result, x, y, n: kernel.run([x, y], [result], n)
