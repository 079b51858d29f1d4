"""Formulas of the Delta robot on whole batches: arguments checked, threads, statuses; no mathematics comes in here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import arrays, parallel
from ..calls import Warming, target
from ..codegen.binding import Binding
from ..codegen.errors import InputError, ShapeError, suggest
from ..loading import stock_algebra

Array = NDArray[Any]


def length(value: Any, name: str) -> float:
    """One of the robot's lengths.

    Raises
    ------
    InputError
        If it is no positive number.
    """
    found = np.asarray(arrays.real(value, name), np.float64)
    if found.ndim:
        raise ShapeError(f"{name} has shape {found.shape}; a robot has one.")
    if not (math.isfinite(found) and found > 0):
        raise InputError(f"{name} is {float(found)!r}; a length is positive and finite.")
    return float(found)


def signs(value: Any, choices: Sequence[str], name: str) -> Array:
    """+1 or -1 of each arm, by words: one for all arms, or three.

    Raises
    ------
    InputError
        If there is no such word.
    """
    words = [value] * 3 if isinstance(value, str) else list(value) if isinstance(value, list | tuple) else [value]
    if len(words) == 3 and all(isinstance(word, str) and word in choices for word in words):
        return np.array([1.0 if word == choices[0] else -1.0 for word in words])
    bad = next((w for w in words if not (isinstance(w, str) and w in choices)), value)
    near = suggest(bad, choices) if isinstance(bad, str) else ""
    raise InputError(f"{name} is {bad!r}{near}; it is one of {', '.join(choices)}, or three of them, one for each arm.")


def rows(value: Any, name: str) -> Array:
    """Positions or angles, (..., 3).

    Raises
    ------
    InputError, ShapeError
        If they are no real numbers, or their last axis is not of length 3.
    """
    return arrays.rows(value, 3, name)


def evaluate(formula: str, given: Sequence[Array], threads: int | None = None) -> tuple[list[Array], Array | None]:
    """Results and codes of a formula ``module.function`` for a batch; in float32 if the first array is.

    ``threads`` None shares the batch as `bladesmith.set_threads` says.
    """
    dtype = arrays.precision(given[0])
    prepared = [np.asarray(a, dtype, order="C") for a in given]  # numbers stay numbers
    keys = tuple(a.shape[-1] if a.ndim else 0 for a in prepared)
    found = target(stock_algebra("cga3d"), formula, keys)
    if threads is not None:
        threads = parallel.thread_count(threads)
    items = math.prod(np.broadcast_shapes(*(a.shape[:-1] for a in prepared)))
    run: Any = found.run.ready(items, prepared) if isinstance(found.run, Warming) else found.run
    results = _shared(run, prepared, threads) if threads and threads > 1 else run(*prepared)
    results = results if isinstance(results, tuple) else (results,)
    values = [v for v, o in zip(results, found.outputs, strict=True) if not o.is_status]
    codes = next((v for v, o in zip(results, found.outputs, strict=True) if o.is_status), None)
    return values, codes


def _shared(run: Binding, given: Sequence[Array], threads: int) -> tuple[Array, ...]:
    """One compiled loop over ranges of items, some of them at the same time."""
    prepared, lead = run.prepare(given)
    n = math.prod(lead)
    flat = [a.reshape((-1, item.size) if item.size else -1) for a, item in zip(prepared, run.inputs, strict=True)]
    shapes = [(n, o.size) if o.size else (n,) for o in run.outputs]
    dtypes = [np.uint8 if o.is_status else prepared[0].dtype for o in run.outputs]
    results = [np.empty(shape, dtype) for shape, dtype in zip(shapes, dtypes, strict=True)]

    def part(begin: int, end: int) -> None:
        chunk = [a[begin:end] if len(a) == n else a for a in flat]
        run.run(chunk, [r[begin:end] for r in results], end - begin)

    parallel.split(part, n, threads)
    return tuple(r.reshape(lead + r.shape[1:]) for r in results)


__all__ = ["evaluate", "length", "rows", "signs"]
