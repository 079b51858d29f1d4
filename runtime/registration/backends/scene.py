"""A query and a reference as arrays, and the stages of a registration on them, item by item."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.registration_layout import MOTOR, RATES, Grid, Head, Settings
from ...codegen.programs.registration.registration import DIRECTED, KINDS, in_order
from ..model.grid import grid_of
from .interface import algorithms_of
from .model_rows import MatchCriterion, ModelData, integers, reals, settings_of

Array = NDArray[Any]
#: Rows of the query and of the reference, by kind.
Matches = Mapping[str, tuple[Array, Array]]
#: A candidate has converged if the square of its motor's change is less: rounding.
MIN_SQUARED_CHANGE = 1e-28
#: Objects moved and matched that are worth another thread: about a millisecond of work, and starting one takes 0.1 ms.
MOVES = 4096
#: Samples, sets and matches that are, in the stages that go by them.
SAMPLES, SETS, MATCHES = 256, 1024, 1024
#: Steps of Algorithm 1 between two checks for an interrupt: some 100 ms.
MAX_HALF_STEPS = 1 << 17


class Scene:
    """A query and a reference with the state of their match criterion.

    Parameters
    ----------
    query, reference : ModelData
    kinds, rows : integer arrays (n,)
        Selected query objects, in this order.
    threads : int, optional
    backend : str
        A name of `interface.BACKENDS`.

    Attributes
    ----------
    n_selected : int
        Number of selected query objects.
    """

    n_selected: int

    def __init__(
        self, query: ModelData, reference: ModelData, kinds: Array, rows: Array, threads: int | None = None,
        backend: str = "c",
    ) -> None:  # fmt: skip
        self._algorithms = algorithms_of(backend, in_order(query.rows))
        self._threads = threads
        self._shared = dict(self._algorithms.keep(scene_arrays(query, reference)))
        self._shared |= self._algorithms.keep({"settings": np.zeros(Settings.size)})
        self.select_objects(kinds, rows)

    def select_objects(self, kinds: Array, rows: Array) -> None:
        """Select query objects for subsequent calls."""
        self.n_selected = len(kinds)
        self._selected = np.stack([kinds, rows], axis=-1).astype(np.int64)
        self._shared |= self._algorithms.keep({"selected": self._selected})

    def set_criterion(self, criterion: MatchCriterion) -> None:
        """Set the match criterion for subsequent calls."""
        self._shared |= self._algorithms.keep({"settings": settings_of(criterion)})

    def samples(
        self, kinds: Array, query: Array, reference: Array, signs: Array, residual: float
    ) -> tuple[Array, Array, Array, Array]:
        """Motors (n, 8), scores, hits and tested of samples, all (n, size) arrays; kind -1 leaves a pair out."""
        n = len(kinds)
        each = {"pair_kinds": integers(kinds), "query": integers(query), "reference": integers(reference)}
        each |= {"signs": reals(signs), "motor": np.empty((n, MOTOR))}
        scores, hits, tested = self._run("samples", n, SAMPLES, each, {"residual": float(residual)}, ("motor",))
        return each["motor"], scores, hits.astype(np.int32), tested.astype(np.int32)

    def conditioning(self, kinds: Array, query: Array) -> Array:
        """Conditioning of sets of query objects, (n, size) arrays: their smallest resistance to a motion."""
        each = {"set_kinds": integers(kinds), "query": integers(query)}
        return self._run("stiffness", len(kinds), SETS, each, {})[0]

    def refine(
        self, motors: Array, rounds: int, min_change: float = MIN_SQUARED_CHANGE
    ) -> tuple[Array, Array, Array, Array]:
        """Motors, scores, hits and rounds of candidates after iterative matching from the given motors (n, 8)."""
        found = np.array(motors, np.float64, order="C")
        grain = max(1, MOVES // ((rounds + 1) * max(self.n_selected, 1)))
        numbers = {"rounds": rounds, "settled": min_change}
        scores, hits, taken = self._run("refine", len(found), grain, {"motor": found}, numbers, ("motor",))
        return found, scores, hits.astype(np.int32), taken.astype(np.int32)

    def match(self, motor: Array) -> tuple[Array, Array, Array]:
        """Row of each selected object's counterpart or -1, weighted squared distance, and relative orientation."""
        each, shared = {"selected": self._selected}, {"motor": reals(motor)}
        indices, distances, signs = self._run("match", self.n_selected, MOVES, each, shared)
        return indices.astype(np.int32), distances, signs

    def rates(self, kind: str, motor: Array, query: Array, reference: Array) -> Array:
        """Cost, gradient (6) and Gauss-Newton matrix (21) by the twist, (n, 28), of matches given by their rows."""
        each = {"query": integers(query), "reference": integers(reference), "found": np.empty((len(query), RATES))}
        shared = {"kind": KINDS.index(kind), "motor": reals(motor)}
        self._run("rates", len(query), MATCHES, each, shared, ("found",))
        return each["found"]

    def descend(self, motor: Array, matches: Matches, weights: Array | None, steps: int) -> tuple[Array, Array, int]:
        """The motor of least cost over matches near a motor, their rates (n, 28) there, and steps of Gauss-Newton.

        ``matches`` are rows of the query and of the reference by kind, with ``weights`` (n,) in their order.
        """
        count, motor = sum(len(rows) for rows, _ in matches.values()), np.array(motor, np.float64)
        found = np.zeros((count, RATES))
        pair_kinds = np.repeat([KINDS.index(kind) for kind in matches], [len(rows) for rows, _ in matches.values()])
        query, reference = (_concatenate([pair[i] for pair in matches.values()]) for i in (0, 1))
        shared: dict[str, Any] = {"pair_kinds": integers(pair_kinds), "query": query, "reference": reference}
        shared |= {"motor": motor, "weights": np.ones(count) if weights is None else reals(weights), "steps": steps}
        shared |= {"found": found, "trial": np.empty_like(found)}
        (taken,) = self._run("descend", 1, 1, {}, shared, ("motor", "found", "trial"))
        return motor, found, int(taken[0])

    def residual_rates(self, motor: Array, vectors: Array, directed: int, residuals: Array) -> Array:
        """Sum of squares of residuals (n, 6, 7), which are linear forms of vectors (n, 6), its gradient (6) and its
        Gauss-Newton matrix (21) by the twist, (n, 28).
        """
        each = {"vectors": reals(vectors), "residuals": reals(residuals), "found": np.empty((len(vectors), RATES))}
        shared = {"motor": reals(motor), "directed": directed}
        self._run("residual_rates", len(vectors), MATCHES, each, shared, ("found",))
        return each["found"]

    def match_segments(self, rows: Array, motor: Array, ends: Array, others: Array) -> tuple[Array, Array]:
        """Row of the counterpart of each of some query segments by its ends or -1, and the mean square by which these
        are off. ``ends`` and ``others`` (n, 6) are those of all segments of the query and of the reference.
        """
        each, shared = {"row": integers(rows)}, {"motor": reals(motor), "kind": KINDS.index("segment")}
        shared |= {"ends": reals(ends), "reference_ends": reals(others)}
        indices, squares = self._run("match_segments", len(rows), MOVES // 4, each, shared)
        return indices.astype(np.int32), squares

    def direct(
        self, motor: Array, pairs: tuple[Array, Array, Array, Array, Array], rounds: int, tolerance: float
    ) -> tuple[Array, Array, int]:
        """Algorithm 1 from a motor: mean motor of the last round if it converged, else the last motor; the change in
        each round; and the number of steps of the last round that were not finite. Pairs, (n,) each: kinds, query and
        reference rows, partners (other pairs, or -1), signs.
        """
        motor = np.array(motor, np.float64)
        names = ("pair_kinds", "query", "reference", "partners")
        shared: dict[str, Any] = dict(zip(names, map(integers, pairs[:4]), strict=True))
        shared |= {"signs": reals(pairs[4]), "motor": motor, "mean": motor.copy(), "tolerance": tolerance}
        done, skipped, left = [np.empty(0)], 0, rounds
        while left > 0 and not (left < rounds and done[-1][-1] < tolerance):
            shared["changes"] = np.empty(min(left, max(1, MAX_HALF_STEPS // max(1, len(pairs[0])))))
            taken, last = self._run("direct", 1, 1, {}, shared, ("motor", "mean", "changes"))
            done.append(shared["changes"][: taken[0]])
            left, skipped = left - int(taken[0]), int(last[0])
        changes = np.concatenate(done)
        is_settled = len(changes) and changes[-1] < tolerance
        return shared["mean"] if is_settled else motor, changes, skipped

    def _run(
        self, stage: str, n: int, grain: int, each: Mapping[str, Array], shared: Mapping[str, Any],
        changed: tuple[str, ...] = (),
    ) -> list[Array]:  # fmt: skip
        """Run a stage on n items, of which ``grain`` are worth another thread."""
        shared = {**self._shared, **shared}
        found: list[Array] = self._algorithms.run(stage, n, each, shared, changed, self._threads, grain)
        return found


def _concatenate(rows: list[Array]) -> Array:
    return integers(rows[0] if len(rows) == 1 else np.concatenate([np.empty(0, np.int64), *rows]))


def scene_arrays(query: ModelData, reference: ModelData) -> dict[str, Array]:
    """The arrays of two models, by the names of the algorithms' parameters; see `registration_layout`."""
    heads, grids = np.zeros((len(KINDS), Head.size), np.int64), np.zeros((len(KINDS), Grid.size))
    numbers, indices = _Row(), _Row()
    for kind, rows in query.rows.items():
        number, length, begin = KINDS.index(kind), rows.shape[1], numbers.place(reals(rows))
        if kind not in reference.rows:
            heads[number, :2] = length, begin
            continue
        grid, others = grid_of(reference.elements[kind]), reference.rows[kind]
        places = numbers.place(reals(others)), numbers.place(reals(grid.elements))
        cells = indices.place(grid.starts), indices.place(grid.order)
        heads[number] = (length, begin, *places, *cells, *grid.sides, len(others))  # as `Head` declares them
        grids[number] = (*grid.corner, grid.scale, kind in DIRECTED)
    return {"heads": heads, "grids": grids, "reals": numbers.array(np.float64), "integers": indices.array(np.int64)}


class _Row:
    """Arrays one after the other."""

    def __init__(self) -> None:
        self._arrays: list[Array] = []
        self._size = 0

    def place(self, array: Array) -> int:
        """Append an array; where it begins."""
        begin = self._size
        self._arrays.append(array.reshape(-1))
        self._size += array.size
        return begin

    def array(self, dtype: Any) -> Array:
        return np.concatenate(self._arrays, dtype=dtype) if self._arrays else np.empty(0, dtype)
