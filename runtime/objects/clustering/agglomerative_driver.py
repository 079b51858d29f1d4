"""The compiled merging driver: found or compiled once, its state in arrays that Python owns, run in steps.

The only module that knows the layout of the driver's structure (templates/c/programs/merging/merge_types.h).
"""

from __future__ import annotations

from functools import cache
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.extension import load
from ...codegen.build.toolchain import REMEDY_OF_PROGRAMS, required_compiler
from ...common import parallel
from ...dispatch.installed import installed_program

Array = NDArray[Any]
#: Objects of a tree's leaf, at most, as in templates/c/programs/merging/merge_tree.h.
LEAF = 12
#: Objects whose neighbours one thread looks up at a time, and merges between two looks at an interrupt.
CHUNK = 512


@cache
def _module() -> Any:
    """The driver that the package carries, where it is up to date; else compiled now, into the cache."""
    module = installed_program("merge")
    if module is not None:
        return module
    from ...codegen.programs.merging import merge_program

    required_compiler("merging is compiled at its first use", REMEDY_OF_PROGRAMS)
    return load(merge_program().extension())


@cache
def _kind_numbers() -> dict[str, int]:
    module = _module()
    names = (module.ffi.string(module.lib.bs_merge_kind(i)).decode() for i in count())
    return {name: i for i, name in enumerate(iter(lambda: next(names), ""))}


class Greedy:
    """Objects of one kind on their way to be merged.

    Parameters
    ----------
    kind : str
        Of `codegen.programs.merging.KINDS`.
    rows : array (n, k)
        Coefficients; NaN rows take no part.
    weights : array (n,)
        What each object counts for in a mean.
    threshold : float
        The greatest cost of a pair that is merged.
    align : bool
        Whether X and -X are one.
    """

    def __init__(self, kind: str, rows: Array, weights: Array, threshold: float, align: bool) -> None:
        n = len(rows)
        self.rows = np.array(rows, np.float64)
        self.weights = np.array(weights, np.float64)
        alive = np.isfinite(self.rows).all(-1)
        self._versions = np.where(alive, 0, -1).astype(np.int32)
        levels = max(0, int(alive.sum()) // LEAF).bit_length()
        nodes = 2 << levels
        self._lib, ffi = _module().lib, _module().ffi
        self._state = state = ffi.new("bs_merge *")
        state.count, state.live, state.kind = n, int(alive.sum()), _kind_numbers()[kind]
        marks = state.marks = self._lib.bs_merge_marks(state.kind)
        state.align, state.threshold = int(align), threshold
        self._costs, self._kept, self._gone = np.empty(n), np.empty(n, np.int32), np.empty(n, np.int32)
        numbers = {
            "rows": self.rows, "weights": self.weights, "landmarks": np.empty((n, marks)),
            "leaves": np.empty((n, marks)), "costs": np.empty(n),
            "boxes": np.empty((nodes, 2 * marks)), "merged_costs": self._costs,
        }  # fmt: skip
        slots = ("nearest", "seen", "heap", "heap_place", "order", "tree_place")
        indices = {name: np.full(n, -1, np.int32) for name in slots}
        indices |= {
            "versions": self._versions, "alive": np.zeros(nodes, np.int32), "kept": self._kept, "gone": self._gone,
        }  # fmt: skip
        self._kept_alive = []
        for kind_of_number, arrays in (("double[]", numbers), ("int32_t[]", indices)):
            for name, array in arrays.items():
                buffer = ffi.from_buffer(kind_of_number, array, require_writable=True)
                self._kept_alive.append(buffer)
                setattr(state, name, buffer)
        self._lib.bs_merge_begin(state)

    def find(self, threads: int | None = None) -> None:
        """Look up each object's nearest other one, over threads, and queue the pairs."""
        found: list[int] = []

        def part(begin: int, end: int) -> None:
            found.append(self._lib.bs_merge_find(self._state, begin, end))

        parallel.run(part, self._state.built, threads, chunk=CHUNK)
        self._state.evaluations += sum(found)
        self._lib.bs_merge_queue(self._state)

    def step(self, max_merges: int = CHUNK) -> int:
        """Merge the cheapest pair, up to ``max_merges`` times; fewer if no pair within the threshold is left."""
        return int(self._lib.bs_merge_step(self._state, max_merges))

    @property
    def evaluations(self) -> int:
        """Costs that were computed."""
        return int(self._state.evaluations)

    @property
    def history(self) -> tuple[Array, Array, Array]:
        """Merges in order: the cost, the slot that stores the mean, and the slot that was freed."""
        done = self._state.merges
        return self._costs[:done].copy(), self._kept[:done].copy(), self._gone[:done].copy()

    def bound(self, first: int, second: int) -> float:
        """The least cost that the landmarks of two objects leave possible."""
        return float(self._lib.bs_merge_bound(self._state, first, second))
