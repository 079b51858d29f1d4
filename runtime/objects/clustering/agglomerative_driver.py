"""The compiled merging algorithms: their state in arrays that Python owns, run in steps.

The only module that knows the layout of that state (codegen/algorithms/merging_layout.py).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.merging_layout import (
    BUILT,
    COEFFICIENTS,
    COUNTS,
    EVALUATIONS,
    FLAT_MARKS,
    LEAF_SIZE,
    LIVE,
    MERGES,
    NODE,
    SLOT,
    THRESHOLD,
    VERSION,
)  # fmt: skip
from ...common import parallel
from ...dispatch.stock_algorithms import stock_algorithm, stock_algorithm_on_gpu

Array = NDArray[Any]
#: Kinds without rounds.
FLATS = ("point", "line", "plane")
#: What looks for neighbours; merging itself is one thread of the processor.
TARGETS = ("c", "cuda")
#: Objects whose neighbours one thread looks up at a time, and merges between two looks at an interrupt.
CHUNK = 512


def _numba_text(kind: str) -> str:
    from ...codegen.programs.merging.program import merge_numba

    return merge_numba(kind)


class Greedy:
    """Objects of one kind on their way to be merged.

    Parameters
    ----------
    kind : str
        Of `codegen.programs.merging.kinds.KINDS`.
    rows : array (n, k)
        Coefficients; NaN rows take no part.
    weights : array (n,)
        What each object counts for in a mean.
    threshold : float
        The greatest cost of a pair that is merged.
    align : bool
        Whether X and -X are one.
    target : str
        Of `TARGETS`.
    """

    def __init__(
        self, kind: str, rows: Array, weights: Array, threshold: float, align: bool, target: str = "c"
    ) -> None:
        n = len(rows)
        self._kind, self._target = kind, target
        self.rows = np.array(rows, np.float64)
        alive = np.isfinite(self.rows).all(-1)
        live = int(alive.sum())
        nodes = 2 << max(0, live // LEAF_SIZE).bit_length()
        marks = FLAT_MARKS if kind in FLATS else COEFFICIENTS + self.rows.shape[1]
        self._counts = np.zeros(COUNTS, np.int64)
        self._counts[LIVE] = live
        slots = np.full((n, SLOT), -1, np.int64)
        slots[:, VERSION] = np.where(alive, 0, -1)
        limits = np.zeros(2)
        limits[THRESHOLD] = threshold
        self._pairs, self._costs = np.empty((n, 2), np.int64), np.empty(n)
        self._state = {
            "align": align, "counts": self._counts, "limits": limits, "rows": self.rows,
            "weights": np.array(weights, np.float64), "landmarks": np.empty((n, marks)), "slots": slots,
            "costs": np.empty(n), "heap": np.empty(n, np.int64), "order": np.full(n, -1, np.int64),
            "leaves": np.empty((n, marks)), "nodes": np.zeros((nodes, NODE), np.int64),
            "boxes": np.empty((nodes, 2 * marks)), "merge_costs": self._costs, "pairs": self._pairs,
        }  # fmt: skip
        self._run("begin")

    def _run(self, name: str, **numbers: int) -> Any:
        function = stock_algorithm("merge", name, self._kind, "merging is compiled at its first use", _numba_text)
        return function({**self._state, **numbers})

    def find(self, threads: int | None = None) -> None:
        """Look up each object's nearest other one, over threads, and queue the pairs."""
        found: list[int] = []
        count = int(self._counts[BUILT])

        def part(begin: int, end: int) -> None:
            found.append(self._run("find", begin=begin, end=end))

        if self._target == "cuda":
            found.append(self._find_on_gpu(np.arange(count)))
        else:
            parallel.run(part, count, threads, chunk=CHUNK)
        self._counts[EVALUATIONS] += sum(found)
        self._run("queue")

    def _find_on_gpu(self, places: NDArray[np.int64]) -> int:
        """Look up the nearest one of each, in a thread of its own; costs that were computed."""
        if not len(places):
            return 0
        function = stock_algorithm_on_gpu("merge", "find", self._kind, ("slots", "costs"))
        bound = function.over(len(places), {"begin": places, "end": places + 1}, self._state)
        bound.run(0, len(places))
        return int(bound.returned[0].sum())

    def step(self, max_merges: int = CHUNK) -> int:
        """Merge the cheapest pair, up to ``max_merges`` times; fewer if no pair within the threshold is left."""
        return int(self._run("step", most=max_merges))

    @property
    def evaluations(self) -> int:
        """Costs that were computed."""
        return int(self._counts[EVALUATIONS])

    @property
    def history(self) -> tuple[Array, Array, Array]:
        """Merges in order: the cost, the slot that stores the mean, and the slot that was freed."""
        done = self._counts[MERGES]
        kept, gone = self._pairs[:done].T.copy()
        return self._costs[:done].copy(), kept, gone
