"""Evaluation of the Delta robot's formulas on batches: arguments, threads, statuses; no mathematics comes in here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.execute.arrays import Binding
from ...common import parallel
from ...common.dtypes import common_precision
from ...common.validation import unknown
from ...core.registry import stock_algebra
from ...dispatch.formulas import TieredKernel, resolve_kernel

Array = NDArray[Any]


def signs(value: Any, choices: Sequence[str], name: str) -> Array:
    """Sign +1 or -1 of each arm, by words: one for all arms, or three.

    Raises
    ------
    InputError
        If a word is not among the choices.
    """
    words = [value] * 3 if isinstance(value, str) else list(value) if isinstance(value, list | tuple) else [value]
    if len(words) == 3 and all(isinstance(word, str) and word in choices for word in words):
        return np.array([1.0 if word == choices[0] else -1.0 for word in words])
    bad = next((w for w in words if not (isinstance(w, str) and w in choices)), value)
    raise unknown(bad, name, choices, remedy="Give one of them, or three of them, one for each arm")


def evaluate(formula: str, operands: Sequence[Array], threads: int | None = None) -> tuple[list[Array], Array | None]:
    """Results and codes of a formula ``module.function`` for a batch; in float32 if the first array is."""
    dtype = common_precision(operands[0])
    prepared = [np.asarray(a, dtype, order="C") for a in operands]  # numbers stay numbers
    keys = tuple(a.shape[-1] if a.ndim else 0 for a in prepared)
    kernel = resolve_kernel(stock_algebra("cga3d"), formula, keys)
    if threads is not None:
        threads = parallel.thread_count(threads)
    leads = {a.shape[:-1] for a in prepared} - {()}  # of one pose there is none, of a batch one
    items = math.prod(leads.pop() if len(leads) == 1 else np.broadcast_shapes(*leads))
    run: Any = kernel.run.ready(items, prepared) if isinstance(kernel.run, TieredKernel) else kernel.run
    is_small = items < 2 * parallel.GRAIN
    results = run(*prepared) if is_small else _run_parallel(run, prepared, parallel.thread_count(threads))
    results = results if isinstance(results, tuple) else (results,)
    values = [v for v, o in zip(results, kernel.outputs, strict=True) if not o.is_status]
    codes = next((v for v, o in zip(results, kernel.outputs, strict=True) if o.is_status), None)
    return values, codes


def _run_parallel(run: Binding, operands: Sequence[Array], threads: int) -> tuple[Array, ...]:
    """Run a compiled loop over ranges of items in parallel."""
    prepared, lead = run.prepare(operands)
    n = math.prod(lead)
    flat = [a.reshape((-1, item.size) if item.size else -1) for a, item in zip(prepared, run.inputs, strict=True)]
    shapes = [(n, o.size) if o.size else (n,) for o in run.outputs]
    dtypes = [np.uint8 if o.is_status else prepared[0].dtype for o in run.outputs]
    results = [np.empty(shape, dtype) for shape, dtype in zip(shapes, dtypes, strict=True)]

    def part(begin: int, end: int) -> None:
        chunk = [a[begin:end] if len(a) == n else a for a in flat]
        run.run(chunk, [r[begin:end] for r in results], end - begin)

    parallel.split(part, n, threads=threads)
    return tuple(r.reshape(lead + r.shape[1:]) for r in results)


__all__ = ["evaluate", "signs"]
