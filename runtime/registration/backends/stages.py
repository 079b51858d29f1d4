"""The stages of a scene that are computed item by item, for every backend. Inputs and outputs of a stage are declared
here once; a backend computes its items.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.registration.registration import KINDS
from .model_rows import ELEMENT, CenterRule, MatchCriterion

Array = NDArray[Any]
#: Number of coefficients of a motor.
MOTOR = 8
#: Number of coefficients of a twist.
TWIST = 6
#: A candidate has converged if the square of its motor's change is less: rounding.
MIN_SQUARED_CHANGE = 1e-28
#: Numbers of a match's rates: cost, gradient, upper half of a matrix.
RATES = 28
#: Objects moved and matched that are worth another thread: about a millisecond of work, and starting one takes 0.1 ms.
MOVES = 4096
#: Pairs, samples, sets and matches that are, in the stages that go by them.
PAIRS, SAMPLES, SETS, MATCHES = 8192, 256, 1024, 1024


class Functions:
    """Functions of a driver that need no scene."""

    def elements(self, kind: str, rows: Array) -> Array:
        """Positions, directions and radii (n, 7) of unit objects."""
        return self._call("elements", kind, [rows], (len(rows), ELEMENT))

    def to_frame(self, kind: str, rows: Array, origin: Array) -> Array:
        """Coefficients (n, k) of objects in a frame at an origin (3,)."""
        return self._call("to_frame", kind, [rows, origin], rows.shape)

    def motors_to_world(self, motors: Array, to: Array, back: Array) -> Array:
        """Motors (n, 8) of the world, from motors of a frame at ``back`` to a frame at ``to``."""
        return self._call("motors_to_world", None, [motors, to, back], (len(motors), MOTOR))

    def twists_to_world(self, twists: Array, origin: Array) -> Array:
        """Twists (n, 6) of the world, from twists of a frame at an origin."""
        return self._call("twists_to_world", None, [twists, origin], (len(twists), TWIST))

    def step(self, motor: Array, twist: Array) -> Array:
        """The motor next to (1 + twist) motor."""
        return self._call("step", None, [motor, twist], (MOTOR,))

    def robust_center(self, kinds: Array, elements: Array, rule: CenterRule) -> Array:
        """Center (3,) of least squared distances from all objects except outliers, by their kinds and elements."""
        raise NotImplementedError

    def invariants(self, kinds: tuple[str, str], rows: tuple[Array, Array], indices: tuple[Array, Array]) -> Array:
        """Invariants (n, 4) of pairs of objects, by their indices in rows; kinds in the order of `KINDS`."""
        raise NotImplementedError

    def _call(self, name: str, kind: str | None, inputs: Sequence[Array], shape: tuple[int, ...]) -> Array:
        """Compute an array of this shape from arrays of numbers; of several items if it has two dimensions."""
        raise NotImplementedError


def set_criterion(state: Any, criterion: MatchCriterion) -> None:
    """Write a match criterion into the structure of a scene."""
    state.weights, state.limit = criterion.weights, criterion.limit
    state.least, state.align = criterion.early_exit_fraction, int(criterion.align)


class Stages:
    """Stages of a query and a reference.

    Attributes
    ----------
    n_selected : int
        Number of selected query objects.
    """

    n_selected: int

    def samples(
        self, kinds: Array, query: Array, reference: Array, signs: Array, residual: float
    ) -> tuple[Array, Array, Array, Array]:
        """Motors (n, 8), scores, hits and tested of samples, all (n, size) arrays; kind -1 leaves a pair out."""
        n = len(kinds)
        inputs = {"kinds": integers(kinds), "query": integers(query), "reference": integers(reference)}
        outputs = {"motors": np.empty((n, MOTOR)), "scores": np.empty(n)}
        outputs |= {name: np.empty(n, np.int32) for name in ("hits", "tested")}
        numbers = {"size": kinds.shape[1], "residual": float(residual)}
        self._run("samples", n, SAMPLES, numbers, inputs | {"signs": reals(signs)}, outputs)
        return outputs["motors"], outputs["scores"], outputs["hits"], outputs["tested"]

    def conditioning(self, kinds: Array, query: Array) -> Array:
        """Conditioning of sets of query objects, (n, size) arrays: their smallest resistance to a motion."""
        inputs, outputs = {"kinds": integers(kinds), "query": integers(query)}, {"stiffness": np.empty(len(kinds))}
        self._run("stiffness", len(kinds), SETS, {"size": kinds.shape[1]}, inputs, outputs)
        return outputs["stiffness"]

    def refine(
        self, motors: Array, rounds: int, min_change: float = MIN_SQUARED_CHANGE
    ) -> tuple[Array, Array, Array, Array]:
        """Motors, scores, hits and rounds of candidates after iterative matching from the given motors (n, 8)."""
        n = len(motors)
        outputs = {"motors": np.array(motors, np.float64, order="C"), "scores": np.empty(n)}
        outputs |= {name: np.empty(n, np.int32) for name in ("hits", "taken")}
        grain = max(1, MOVES // ((rounds + 1) * max(self.n_selected, 1)))
        self._run("refine", n, grain, {"rounds": rounds, "settled": min_change}, {}, outputs)
        return outputs["motors"], outputs["scores"], outputs["hits"], outputs["taken"]

    def match(self, motor: Array) -> tuple[Array, Array, Array]:
        """Row of each selected object's counterpart or -1, weighted squared distance, and relative orientation."""
        n = self.n_selected
        outputs: dict[str, Array] = {"indices": np.empty(n, np.int32), "distances": np.empty(n), "signs": np.empty(n)}
        self._run("match", n, MOVES, {}, {"motor": reals(motor)}, outputs)
        return outputs["indices"], outputs["distances"], outputs["signs"]

    def rates(self, kind: str, motor: Array, query: Array, reference: Array) -> Array:
        """Cost, gradient (6) and Gauss-Newton matrix (21) by the twist, (n, 28), of matches given by their rows."""
        inputs = {"query": integers(query), "reference": integers(reference), "motor": reals(motor)}
        outputs = {"rates": np.empty((len(query), RATES))}
        self._run("rates", len(query), MATCHES, {"kind": KINDS.index(kind)}, inputs, outputs)
        return outputs["rates"]

    def _run(
        self, stage: str, n: int, grain: int, numbers: Mapping[str, float], inputs: Mapping[str, Array],
        outputs: Mapping[str, Array],
    ) -> None:  # fmt: skip
        """Compute n items of a stage into the output arrays; ``grain`` items are worth another thread.

        Names and their order are those of the stage's structure (reform_types.h of templates), numbers first.
        """
        raise NotImplementedError


def integers(array: Array) -> Array:
    """Array as drivers read indices."""
    return np.ascontiguousarray(array, np.int32)


def reals(array: Array) -> Array:
    """Array as drivers read numbers."""
    return np.ascontiguousarray(array, np.float64)
