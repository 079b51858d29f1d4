"""The stages of a scene that go by items, for every backend: arrays in, arrays out. What a stage is given and what it
finds is written here once; a backend says how its items are computed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import parallel
from ..codegen.programs.reform import KINDS

Array = NDArray[Any]
#: Coefficients of a motor, and of a twist.
MOTOR, TWIST = 8, 6
#: A candidate stays where the square of its motor's change is less: rounding.
SETTLED = 1e-28
#: Numbers of a match's rates: cost, gradient, upper half of a matrix.
RATES = 28
#: Objects moved and matched that are worth another thread: about a millisecond of work, and starting one takes 0.1 ms.
MOVES = 4096
#: Pairs, samples, sets and matches that are, in the stages that go by them.
PAIRS, SAMPLES, SETS, MATCHES = 8192, 256, 1024, 1024


class Stages:
    """Stages by items of a query and a reference that are laid over each other.

    Attributes
    ----------
    asked : int
        Query objects that are looked at.
    """

    asked: int

    def samples(
        self, kinds: Array, query: Array, reference: Array, signs: Array, residual: float
    ) -> tuple[Array, Array, Array, Array]:
        """Motors (n, 8), scores, hits and tested of samples, all (n, size) arrays; kind -1 leaves a pair out."""
        n = len(kinds)
        given = {"kinds": integers(kinds), "query": integers(query), "reference": integers(reference)}
        found = {"motors": np.empty((n, MOTOR)), "scores": np.empty(n)}
        found |= {name: np.empty(n, np.int32) for name in ("hits", "tested")}
        numbers = {"size": kinds.shape[1], "residual": float(residual)}
        self._run("samples", n, SAMPLES, numbers, given | {"signs": reals(signs)}, found)
        return found["motors"], found["scores"], found["hits"], found["tested"]

    def stiffness(self, kinds: Array, query: Array) -> Array:
        """How stiff sets of query objects, (n, size) arrays, are against the motion that they hinder least."""
        given, found = {"kinds": integers(kinds), "query": integers(query)}, {"stiffness": np.empty(len(kinds))}
        self._run("stiffness", len(kinds), SETS, {"size": kinds.shape[1]}, given, found)
        return found["stiffness"]

    def refine(self, motors: Array, rounds: int, settled: float = SETTLED) -> tuple[Array, Array, Array, Array]:
        """Motors, scores, hits and rounds of candidates after iterative matching from the given motors (n, 8)."""
        n = len(motors)
        found = {"motors": np.array(motors, np.float64, order="C"), "scores": np.empty(n)}
        found |= {name: np.empty(n, np.int32) for name in ("hits", "taken")}
        grain = max(1, MOVES // ((rounds + 1) * max(self.asked, 1)))
        self._run("refine", n, grain, {"rounds": rounds, "settled": settled}, {}, found)
        return found["motors"], found["scores"], found["hits"], found["taken"]

    def match(self, motor: Array) -> tuple[Array, Array, Array]:
        """Of each asked object the row of its counterpart or -1, the weighted square, and the sign."""
        n = self.asked
        found: dict[str, Array] = {"indices": np.empty(n, np.int32), "distances": np.empty(n), "signs": np.empty(n)}
        self._run("match", n, MOVES, {}, {"motor": reals(motor)}, found)
        return found["indices"], found["distances"], found["signs"]

    def rates(self, kind: str, motor: Array, query: Array, reference: Array) -> Array:
        """Of matches, by their rows: cost, gradient (6) and Gauss-Newton matrix (21) by the twist, (n, 28)."""
        given = {"query": integers(query), "reference": integers(reference), "motor": reals(motor)}
        found = {"rates": np.empty((len(query), RATES))}
        self._run("rates", len(query), MATCHES, {"kind": KINDS.index(kind)}, given, found)
        return found["rates"]

    def _run(
        self, stage: str, n: int, grain: int, numbers: Mapping[str, float], given: Mapping[str, Array],
        found: Mapping[str, Array],
    ) -> None:  # fmt: skip
        """Compute n items of a stage into what is found; so many of them are worth another thread.

        Names and their order are those of the stage's structure (templates/c/reform_types.h), numbers first.
        """
        raise NotImplementedError


def share(part: parallel.Part, n: int, threads: int | None, grain: int) -> None:
    """A range over threads, in pieces of at least so many."""
    count = parallel.thread_count(threads)
    if n <= grain or count == 1:
        part(0, n)
    else:
        parallel.run(part, n, count, chunk=max(grain, -(-n // (8 * count))))


def integers(array: Array) -> Array:
    """As drivers read indices."""
    return np.ascontiguousarray(array, np.int32)


def reals(array: Array) -> Array:
    """As drivers read numbers."""
    return np.ascontiguousarray(array, np.float64)
