"""Evaluation of the Delta robot's formulas on batches: arguments, threads, statuses; no mathematics comes in here."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.execute.arrays import Binding
from ...common import parallel
from ...common.dtypes import common_precision
from ...common.validation import unknown
from ...core.registry import stock_algebra
from ...dispatch.formulas import TieredKernel, evaluate_item, item_plan, resolve_kernel
from ...dispatch.item_plans import is_plain
from ...dispatch.multivector_data import from_buffer

Array = NDArray[Any]


def fixed(numbers: Sequence[float]) -> Array:
    """An array that nobody writes to."""
    array = np.array(numbers)
    array.flags.writeable = False
    return array




#: Signs of arms that are all the second choice, or all the first.
ALIKE = (fixed((-1.0, -1.0, -1.0)), fixed((1.0, 1.0, 1.0)))
#: The shape of an item's angles, and of its position.
ROW = (3,)


def signs(value: Any, choices: Sequence[str], name: str) -> Array:
    """Sign +1 or -1 of each arm, by words: one for all arms, or three.

    Raises
    ------
    InputError
        If a word is not among the choices.
    """
    if isinstance(value, str) and value in choices:
        return ALIKE[value == choices[0]]
    words = [value] * 3 if isinstance(value, str) else list(value) if isinstance(value, list | tuple) else [value]
    if len(words) == 3 and all(isinstance(word, str) and word in choices for word in words):
        return np.array([1.0 if word == choices[0] else -1.0 for word in words])
    bad = next((w for w in words if not (isinstance(w, str) and w in choices)), value)
    raise unknown(bad, name, choices, remedy="Give one of them, or three of them, one for each arm")


class BoundPlans(dict[tuple[str, str], tuple[Any, tuple[Any, ...]]]):
    """Formulas for single rows of one robot, by formula and choice: plans, and pointers to what all calls share.

    Another process makes its own.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        return BoundPlans, ()


def item(
    bound: BoundPlans, formula: str, row: Any, parameters: Array, choice: Any, choices: Mapping[str, Array]
) -> Any:
    """The result of a formula for one row (3,), finite and OK; None where anything is not as usual."""
    if choice.__class__ is not str or not is_plain(row, ROW):
        return None
    known = bound.get((formula, choice))
    if known is None:
        if choice not in choices:
            return None
        constants = parameters, choices[choice]
        plan, pointers = item_plan(stock_algebra("cga3d"), formula, (row, *constants))
        known = bound[formula, choice] = plan, tuple(pointers[1:])
    values = known[0].values((from_buffer(row), *known[1]))
    return None if values is None else values[0]


def evaluate(formula: str, operands: Sequence[Array], threads: int | None = None) -> tuple[list[Array], Array | None]:
    """Results and codes of a formula ``module.function`` for a batch; in float32 if the first array is."""
    if threads is None and operands[0].ndim == 1:
        usual = evaluate_item(stock_algebra("cga3d"), formula, operands)
        if usual is not None:
            return list(usual.values), usual.status
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


__all__ = ["BoundPlans", "evaluate", "fixed", "item", "signs"]
