"""One registration under way: models in their frames, what computes with them, and what has been done."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebras import Algebra
from ..codegen.programs.reform import KINDS
from ..multivector import Multivector
from .backends import backend_of
from .distributed import SharedScene, shared
from .frames import local_pair
from .result import Step
from .search import VERIFIED, Found

Array = NDArray[Any]


class Job:
    """One registration.

    Parameters
    ----------
    query, reference : mapping of kind to Multivector (n,)
        Unit objects. Kinds that only one of them has take no part.
    seed, threads, backend, executor
        As of `register`.
    align : bool
        x and -x are one.
    length : float
        What a radian counts as, in units of the models' size.

    Attributes
    ----------
    query, reference : Local
        In their frames.
    kinds, rows : int32 arrays (n,)
        Of all query objects that take part: number of the kind, and row.
    scene, driver
        What computes (see `engine`).
    history : list of Step
    found : Found
        The best so far, for a search that is interrupted.
    progress : callable
        Is told of each block of motors, by a `Step`.
    """

    def __init__(
        self,
        query: Mapping[str, Multivector],
        reference: Mapping[str, Multivector],
        *,
        seed: int = 0,
        threads: int | None = None,
        backend: str = "c",
        executor: Any = None,
        align: bool = True,
        length: float = 1.0,
    ) -> None:
        common = [k for k in KINDS if k in query and k in reference]
        made = backend_of(backend)
        self.driver = made.driver(tuple(common), threads)
        self.query, self.reference = local_pair(
            self.driver, {k: query[k] for k in common}, {k: reference[k] for k in common}
        )
        self.random = np.random.default_rng(seed)
        self.align, self.length = align, length
        counts = [self.query.objects[k].shape[0] for k in common]
        self.kinds = np.repeat(np.array([KINDS.index(k) for k in common], np.int32), counts)
        self.rows = np.concatenate([np.arange(n, dtype=np.int32) for n in counts])
        self._some = self.random.permutation(len(self.rows))[:VERIFIED]
        asked, sides = (self.kinds[self._some], self.rows[self._some]), (self.query.side, self.reference.side)
        self.scene = made.scene(*sides, *asked, threads)
        if executor is not None:
            self.scene = shared(executor, self.scene, backend, sides, asked, threads)
        self.history: list[Step] = []
        self.found = Found()
        self.progress: Callable[[Step], None] = lambda step: None

    @property
    def algebra(self) -> Algebra:
        """That of the objects."""
        return next(iter(self.query.objects.values())).algebra

    def tell(self, found: Found) -> None:
        """For searches: what there is at this tolerance, after each block of motors."""
        if found.doubt < self.found.doubt or not len(self.found.motors):
            self.found = found
        hits = int(found.hits[0]) if len(found.hits) else 0
        self.progress(Step("search", found.tolerance, found.candidates, hits, math.nan))

    def alone(self) -> None:
        """Without an executor from now on."""
        if isinstance(self.scene, SharedScene):
            self.scene = self.scene.local

    def everything(self) -> None:
        """Look at all query objects from now on, in their order."""
        self.scene.ask(self.kinds, self.rows)

    def some(self) -> None:
        """Look again at those that verify a motor while searching."""
        self.scene.ask(self.kinds[self._some], self.rows[self._some])

    def by_kind(self, indices: Array) -> dict[str, tuple[Array, Array]]:
        """Matches of all query objects, -1 for none, as rows of the query and of the reference of each kind."""
        pairs = {}
        for kind in self.query.objects:
            own = (indices >= 0) & (self.kinds == KINDS.index(kind))
            if own.any():
                pairs[kind] = (self.rows[own], indices[own])
        return pairs
