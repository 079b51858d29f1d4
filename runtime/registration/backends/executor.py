"""Execution of a registration's stages on the workers of an executor: see `common.executors`."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common import parallel
from ...common.executors import Calls, Payload, check_executor, workers
from ..search.hypotheses import HypothesisBatch, SampleBatch, TableSelection
from .model_rows import MatchCriterion, ModelData
from .scene import MIN_SQUARED_CHANGE
from .worker import EVALUATE, RegistrationTask, run_stage

Array = NDArray[Any]
#: Number of samples that are worth a call: some ten milliseconds.
SAMPLES_PER_CALL = 1 << 11
#: Number of objects to be matched, over all motors, that are worth a call.
OBJECTS_PER_CALL = 1 << 17
#: Models of at most this many bytes are sent with every piece: cheaper than a second call to a worker without them.
MAX_ATTACHED_BYTES = 1 << 16
#: Batches that are sent ahead for each worker.
BATCHES_AHEAD = 2


@dataclass
class SharedScene:
    """A scene (see `scene.Scene`) whose samples and refinements are shared over an executor.

    Attributes
    ----------
    local : Scene
        Local scene, which computes work that is too little to be shared.
    task : RegistrationTask
    executor : concurrent.futures.Executor
    """

    local: Any
    task: RegistrationTask
    executor: Executor
    _criterion: MatchCriterion = field(default_factory=lambda: MatchCriterion((0.0, 0.0, 0.0), 0.0))
    _payload: Payload | None = field(default=None, repr=False)
    _evaluations: Calls | None = field(default=None, repr=False)
    _hypotheses: dict[int, HypothesisBatch] = field(default_factory=dict, repr=False)

    @property
    def n_selected(self) -> int:
        """Number of selected query objects."""
        return int(self.local.n_selected)

    def select_objects(self, kinds: Array, rows: Array) -> None:
        """Select query objects for subsequent calls."""
        self.local.select_objects(kinds, rows)
        self.task, self._payload = replace(self.task, kinds=kinds, rows=rows), None

    def set_criterion(self, criterion: MatchCriterion) -> None:
        """Set the match criterion for subsequent calls."""
        self.local.set_criterion(criterion)
        self._criterion = criterion
        if self._evaluations is not None:
            self._evaluations.drop()
            self._evaluations, self._hypotheses = None, {}

    def samples(self, kinds: Array, query: Array, reference: Array, signs: Array, residual: float) -> Any:
        """See `scene.Scene`."""
        return self._run_in_pieces("samples", (kinds, query, reference, signs), (residual,), SAMPLES_PER_CALL)

    @property
    def ahead(self) -> int:
        """Number of batches that are sent before the search requests them."""
        return BATCHES_AHEAD * workers(self.executor)

    def send(
        self, selection: TableSelection, index: int, batches: list[SampleBatch], tolerance: float, residual: float
    ) -> None:
        """Send batches to be evaluated (see `HypothesisGenerator`); a change of the criterion cancels them."""
        if self.task.selection is not selection:
            self.task, self._payload = replace(self.task, selection=selection), None
        if self._evaluations is None:
            self._evaluations = self._calls()
        arguments = self._criterion, EVALUATE, (batches, tolerance, residual)
        self._evaluations.send(index, run_stage, arguments, f"the hypotheses of batch {index}")

    def collect(self, indices: Sequence[int]) -> HypothesisBatch:
        """Hypotheses of the batches that were sent under these indices."""
        assert self._evaluations is not None
        missing = [index for index in indices if index not in self._hypotheses]
        self._evaluations.wait(missing, self._hypotheses.__setitem__)
        return HypothesisBatch.concatenate([self._hypotheses.pop(index) for index in indices])

    def refine(self, motors: Array, rounds: int, min_change: float = MIN_SQUARED_CHANGE) -> Any:
        """See `scene.Scene`."""
        grain = max(1, OBJECTS_PER_CALL // max(self.n_selected * max(rounds, 1), 1))
        return self._run_in_pieces("refine", (motors,), (rounds, min_change), grain)

    def __getattr__(self, name: str) -> Any:
        """Stages that are not shared."""
        if name.startswith("_") or name == "local":
            raise AttributeError(name)
        return getattr(self.local, name)

    def _run_in_pieces(self, stage: str, arrays: tuple[Array, ...], others: tuple[Any, ...], grain: int) -> Any:
        """Run a stage in pieces of at least ``grain`` items, and concatenate the results."""
        n = len(arrays[0])
        count = n // grain
        if count < 2:
            return getattr(self.local, stage)(*arrays, *others)
        edges = [n * i // count for i in range(count + 1)]
        calls, results = self._calls(), dict[int, tuple[Array, ...]]()
        for i, (begin, end) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
            arguments = self._criterion, stage, (*(a[begin:end] for a in arrays), *others)
            calls.send(i, run_stage, arguments, f"items {begin} to {end - 1} of the stage {stage!r}")
        calls.wait(range(count), results.__setitem__)
        return tuple(np.concatenate(parts) for parts in zip(*(results[i] for i in range(count)), strict=True))

    def _calls(self) -> Calls:
        """Calls with the models as they are now."""
        if self._payload is None:
            self._payload = Payload.of(self.task)
        return Calls(self.executor, self._payload, attached=len(self._payload.data) <= MAX_ATTACHED_BYTES)


def share_over_executor(
    executor: Any, scene: Any, backend: str, sides: tuple[ModelData, ModelData], selected: tuple[Array, Array],
    threads: int | None,
) -> SharedScene:  # fmt: skip
    """Scene of a query and a reference that shares its work over an executor.

    ``selected`` are the kinds and rows of the verified query objects; each worker has one thread unless ``threads`` is
    given.

    Raises
    ------
    InputError
        If it is not an executor.
    """
    check_executor(executor)
    count = 1 if threads is None else parallel.thread_count(threads)
    return SharedScene(scene, RegistrationTask(backend, count, *sides, *selected), executor)
