"""A formula of two objects on every pair of two batches: its (n, m) values, or for each object the nearest of others.

The compiled loops take rows of the first batch, and `parallel` shares these over threads; results are the same bits
for any number of threads.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.algebra import Kind
from ...codegen.execute.arrays import Binding
from ...codegen.execute.pairs import all_pairs
from ...codegen.execute.pairs import nearest as nearest_rows
from ...codegen.execute.ranges import Splitter
from ...codegen.trace.result_kinds import belongs
from ...common import parallel
from ...common.dtypes import common_precision
from ...core.multivector import Multivector
from ...dispatch.coefficients import embed
from ...dispatch.formulas import TieredKernel, resolve_kernel

#: Pairs between two looks at an interrupt: some 100 ms.
MOST_PAIRS = 1 << 22


def pair_values(formula: str, x: Multivector, y: Multivector, threads: int | None = None) -> NDArray[Any]:
    """The number that ``formula`` gives for each of n objects with each of m, shape (n, m).

    Parameters
    ----------
    formula : str
        ``module.function`` of `codegen.formulas`, of two multivectors.
    x, y : Multivector, shapes (n,) and (m,)
    threads : int, optional
        Default: the package's (`bladesmith.set_threads`).
    """
    run, a, b = _bound(formula, x, y)
    values = all_pairs(run, a, b, over_rows(len(b), threads))
    return np.asarray(values).reshape(len(a), len(b))


def nearest(
    formula: str, x: Multivector, y: Multivector, threads: int | None = None
) -> tuple[NDArray[np.int64], NDArray[Any]]:
    """For each of n objects the index of that of m others for which ``formula`` is least, and the value.

    NaN never wins and the first of equal values does; -1 and infinity where there is no value at all.
    """
    run, a, b = _bound(formula, x, y)
    return nearest_rows(run, a, b, over_rows(len(b), threads))


def over_rows(m: int, threads: int | None = None) -> Splitter:
    """Shares rows of m pairs each over threads, in chunks that are worth it."""
    count = parallel.thread_count(threads)
    least, most = (max(1, pairs // max(m, 1)) for pairs in (parallel.GRAIN, MOST_PAIRS))

    def split(part: parallel.Part, n: int, first: int | None = None, unit: int = 1) -> None:
        if n < 2 * least:
            part(0, n)
        elif count == 1:
            parallel.run(part, n, count, chunk=most)
        else:
            share = -(-n // (count * parallel.CHUNKS_PER_THREAD))
            parallel.run(part, n, count, chunk=min(max(least, share), most))

    return split


def _bound(formula: str, x: Multivector, y: Multivector) -> tuple[Binding, NDArray[Any], NDArray[Any]]:
    """Kernel of the formula, and its rows of operands."""
    wide = max(x.kind, y.kind, key=lambda kind: kind.size)  # lines and circles: all are of the kind of circles
    both = (wide, wide) if belongs(x.kind, wide) and belongs(y.kind, wide) else (x.kind, y.kind)
    found = resolve_kernel(x.algebra, formula, both)
    dtype = common_precision(x._data, y._data)
    a, b = (
        (embed(item, key) if isinstance(key, Kind) else item._data).astype(dtype, copy=False)
        for item, key in zip((x, y), found.inputs, strict=True)
    )
    run = found.run.ready(len(a) * len(b), (a, b)) if isinstance(found.run, TieredKernel) else found.run
    return cast(Binding, run), a, b
