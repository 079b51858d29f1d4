"""A registration problem: normalized models, their compiled scene, and the state and history of the search."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.registration.registration import KINDS
from ...core.multivector import Algebra
from ..backends.driver import Driver
from ..backends.executor import SharedScene, share_over_executor
from ..backends.scene import Scene
from ..estimation.objective import Objective, WeightedSide
from ..model.model import Model
from ..model.normalization import criterion_within, normalize_pair
from ..result import Step
from ..verification.ranking import CandidateRanking
from ..verification.significance import estimate_background
from .state import SearchState

Array = NDArray[Any]
#: Number of query objects that verify a motor during the search.
N_VERIFIED = 512


class RegistrationProblem:
    """A registration problem with its state.

    Parameters
    ----------
    query, reference : Model
        Kinds that only one of them has take no part.
    seed, threads, backend, executor
        See `register`.
    align : bool
        True if x and -x are the same object.
    length : float
        Length that a rotation by one radian is equivalent to, in units of the models' size.
    loss : str
        A name of `objective.LOSSES`.

    Attributes
    ----------
    query, reference : NormalizedModel
    kinds, rows : int32 arrays (n,)
        Number of the kind, and row, of each query object that takes part.
    scene, driver
        Compiled stages (see `backends.scene`).
    history : list of Step
    best : SearchState
        Best state so far: the result of an interrupted search.
    progress : callable
        Function that gets a `Step` after each block of motors.
    """

    def __init__(
        self, query: Model, reference: Model, *, seed: int = 0, threads: int | None = None, backend: str = "c",
        executor: Any = None, align: bool = True, length: float = 1.0, loss: str = "linear",
    ) -> None:  # fmt: skip
        common = [k for k in KINDS if k in query.counts and k in reference.counts]
        self.driver = Driver(tuple(common), threads, backend)
        self.query, self.reference = normalize_pair(
            self.driver, *({k: model.objects[k] for k in common} for model in (query, reference))
        )
        self._models, self.loss = (query, reference), loss
        self.random = np.random.default_rng(seed)
        self.align, self.length = align, length
        counts = [self.query.objects[k].shape[0] for k in common]
        self.kinds = np.repeat(np.array([KINDS.index(k) for k in common], np.int32), counts)
        self.rows = np.concatenate([np.arange(n, dtype=np.int32) for n in counts])
        self._subset = self.random.permutation(len(self.rows))[:N_VERIFIED]
        models, selected = (self.query.data, self.reference.data), (self.kinds[self._subset], self.rows[self._subset])
        self.scene: Any = Scene(*models, *selected, threads, backend)
        if executor is not None:
            self.scene = share_over_executor(executor, self.scene, backend, models, selected, threads)
        self.history: list[Step] = []
        self.best = SearchState()
        self.progress: Callable[[Step], None] = lambda step: None

    @property
    def algebra(self) -> Algebra:
        """Algebra of the objects."""
        return next(iter(self.query.objects.values())).algebra

    def report(self, state: SearchState) -> None:
        """Record the state at this tolerance, and report it as a step."""
        if state.log_nfa < self.best.log_nfa or not len(self.best.motors):
            self.best = state
        hits = int(state.hits[0]) if len(state.hits) else 0
        self.progress(Step("search", state.tolerance, state.candidates, hits, math.nan))

    def ranking(self, size: int) -> CandidateRanking:
        """Comparison of candidates from minimal sets of so many of the selected objects."""
        background = estimate_background(self.scene, self.algebra, self.align, self.length)
        return CandidateRanking(self.scene, background, size, self.align, self.length)

    def accept_within(self, distance: float, early_exit_fraction: float = 0.0) -> None:
        """Match objects up to this distance in subsequent calls; give up motors that match a smaller fraction."""
        self.scene.set_criterion(criterion_within(distance, early_exit_fraction, self.align, self.length))

    def disable_executor(self) -> None:
        """Compute here in subsequent calls."""
        if isinstance(self.scene, SharedScene):
            self.scene = self.scene.local

    def verify_on_all(self) -> None:
        """Verify motors on all query objects, in their order."""
        self.scene.select_objects(self.kinds, self.rows)

    def verify_on_subset(self) -> None:
        """Restrict verification to the random subset used during the search."""
        self.scene.select_objects(self.kinds[self._subset], self.rows[self._subset])

    @cached_property
    def sides(self) -> tuple[WeightedSide, WeightedSide]:
        """Parameters of both models in their frames, with weights or covariances."""
        query, reference = self._models
        return WeightedSide(query, self.query), WeightedSide(reference, self.reference)

    @property
    def is_reweighted(self) -> bool:
        """True if the refinement holds weights or residuals, and has to be repeated at the refined pose."""
        return self.loss != "linear" or "segment" in self.query.objects or any(s.covariances for s in self.sides)

    def objective(self, motor: Array, indices: Array) -> Objective:
        """The cost of matches near a motor, -1 for none."""
        near = self.algebra.wrap(self.algebra.kind("motor"), motor)
        return Objective(self.scene, *self.sides, self.by_kind(indices), near, self.loss, self.align)

    def by_kind(self, indices: Array) -> dict[str, tuple[Array, Array]]:
        """Matches of all query objects, -1 for none, as rows of the query and of the reference by kind."""
        pairs = {}
        for kind in self.query.objects:
            of_kind = (indices >= 0) & (self.kinds == KINDS.index(kind))
            if of_kind.any():
                pairs[kind] = (self.rows[of_kind], indices[of_kind])
        return pairs
