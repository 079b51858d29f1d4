"""Algorithms on several items at once, called with arrays."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from bladesmith.codegen.build import extension
from bladesmith.codegen.build.cpu_features import runs
from bladesmith.codegen.execute.items import CLoop
from bladesmith.codegen.ir.loops.types import ArrayType
from bladesmith.codegen.programs.algorithms import algorithm_extension
from bladesmith.codegen.targets.c.instances import BY_TAG, OF_KERNELS

#: Instances that this processor runs, plain numbers first.
TAGS = ["f64_scalar", *(i.tag for i in OF_KERNELS if i.bits == 64 and runs(i))]


def by_lanes(
    declared: Any, given: tuple[Any, ...], items: int, tag: str, shared: Collection[str] = (),
    still: Mapping[str, Collection[int]] | None = None,
) -> list[Any]:  # fmt: skip
    """Results as the algorithm's own call has them: arrays that are written, then what is returned."""
    function = declared.function_for(given)
    library = extension.load(algorithm_extension(function, (BY_TAG[tag],), shared, still))
    arrays, strides, counts, results = [], [], [], []
    inputs = iter(given)
    for p in function.parameters:
        if p.access == "out":
            a: Any = np.zeros((items, p.type.size), float if p.type.scalar.name == "Real" else int)
        else:
            a = next(inputs)
        is_array = isinstance(p.type, ArrayType)
        whole = np.array(a, order="C", dtype=None if is_array else (float if np.asarray(a).dtype.kind == "f" else int))
        width = p.type.size if is_array else 1
        open_rows = is_array and p.type.is_open
        count = whole.shape[0 if p.name in shared else 1] if open_rows else 0
        arrays.append(whole)
        counts.append(count)
        strides.append(0 if p.name in shared else width * (count if open_rows else 1))
        if p.access != "in":
            results.append(whole)
    for type in function.results:
        arrays.append(np.zeros(items, float if type.name == "Real" else int))
        strides.append(1)
        counts.append(0)
        results.append(arrays[-1])
    loop = CLoop(library, tag)
    loop.bind([loop.hold(a) for a in arrays], loop.integers(tuple(strides)), loop.integers(tuple(counts)))(0, items)
    return results
