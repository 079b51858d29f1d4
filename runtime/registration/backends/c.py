"""The C backend: the compiled registration driver of some kinds of object, called with arrays, over threads.

This module alone knows the layout of the driver's structures (templates/c/programs/registration/reform_types.h).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.extension import load
from ...codegen.build.toolchain import REMEDY_OF_PROGRAMS, required_compiler
from ...codegen.programs.registration.registration import KINDS, in_order, reform_program
from ...common import parallel
from ...dispatch.installed import installed_program
from ..model.grid import Grid, grid_of
from .model_rows import POSITION, CenterRule, MatchCriterion, ModelData
from .stages import PAIRS, Functions, Stages, integers, reals, set_criterion

Array = NDArray[Any]
INTEGER = np.dtype(np.int32)
#: Names of the structures of stages.
STRUCTURES = {
    "samples": "bs_samples", "stiffness": "bs_sets", "refine": "bs_refined", "match": "bs_matching",
    "rates": "bs_rates",
}  # fmt: skip
#: Steps of Algorithm 1 between two checks for an interrupt: some 100 ms.
MOST_HALF_STEPS = 1 << 17


@cache
def driver(kinds: tuple[str, ...]) -> Any:
    """Compiled driver for these kinds: the installed one of all kinds, or one from the cache, or a new one."""
    module = installed_program("reform")
    if module is not None:
        return module
    required_compiler("registration is compiled at its first use", REMEDY_OF_PROGRAMS)
    return load(reform_program(in_order(kinds)).extension())


class Driver(Functions):
    """Functions of the compiled driver."""

    def __init__(self, kinds: tuple[str, ...], threads: int | None = None) -> None:
        self._module = driver(kinds)
        self._threads = threads

    def _call(self, name: str, kind: str | None, inputs: Sequence[Array], shape: tuple[int, ...]) -> Array:
        outputs = np.empty(shape)
        number, count = ([] if kind is None else [KINDS.index(kind)]), shape[:-1]
        getattr(self._module.lib, f"bs_reform_{name}")(*number, *self._numbers(*inputs, outputs), *count)
        return outputs

    def squared_distances(
        self, kind: str, a: Array, b: Array, criterion: MatchCriterion, signs: Array | None = None
    ) -> Array:
        """Weighted squared distances (..) of elements (.., 7), which broadcast. ``signs`` are relative orientations;
        without them, the criterion decides if both are allowed.
        """
        if signs is not None:
            a = a.copy()
            a[..., POSITION : 2 * POSITION] *= np.asarray(signs)[..., None]
        a, b = (np.ascontiguousarray(x, np.float64) for x in np.broadcast_arrays(a, b))
        outputs, weights = np.empty(a.shape[:-1]), np.array(criterion.weights)
        other = -1.0 if criterion.align and signs is None else 1.0
        x, y, w, to = self._numbers(a, b, weights, outputs)
        run = self._module.lib.bs_reform_squared_distances
        parallel.run(
            lambda i, j: run(KINDS.index(kind), x, y, w, other, to, i, j), outputs.size, self._threads, grain=PAIRS
        )
        return outputs

    def robust_center(self, kinds: Array, elements: Array, rule: CenterRule) -> Array:
        ffi, n, outputs = self._module.ffi, len(elements), np.empty(POSITION)
        squares, ordered, near = np.empty(n), np.empty(n), np.empty(n, np.int32)
        job = ffi.new("bs_center *")
        job.count, job.rounds, job.place, job.far, job.rounding, job.rank_tolerance = n, *rule
        numbers = np.ascontiguousarray(kinds, np.int32)
        job.kinds, job.near = ffi.from_buffer("int32_t[]", numbers), ffi.from_buffer("int32_t[]", near)
        job.elements, job.point, job.squares, job.ordered = self._numbers(elements, outputs, squares, ordered)
        self._module.lib.bs_reform_robust_center(job)
        return outputs

    def _numbers(self, *arrays: Array) -> list[Any]:
        return [self._module.ffi.from_buffer("double[]", np.ascontiguousarray(a, np.float64)) for a in arrays]

    def invariants(self, kinds: tuple[str, str], rows: tuple[Array, Array], indices: tuple[Array, Array]) -> Array:
        ffi, run = self._module.ffi, self._module.lib.bs_reform_invariants
        outputs = np.empty((len(indices[0]), 4))
        inputs = [np.ascontiguousarray(r, np.float64) for r in rows]
        index = [np.ascontiguousarray(p, np.int32) for p in indices]
        (a, b), (i, j) = ([ffi.from_buffer(t, x) for x in xs] for t, xs in (("double[]", inputs), ("int32_t[]", index)))
        to = ffi.from_buffer("double[]", outputs)
        one, two = (KINDS.index(k) for k in kinds)

        def part(begin: int, end: int) -> None:
            run(one, a, i, two, b, j, to, begin, end)

        parallel.run(part, len(outputs), self._threads, grain=PAIRS)
        return outputs


class Scene(Stages):
    """A query and a reference with the state of their match criterion.

    Parameters
    ----------
    query, reference : ModelData
    kinds, rows : int32 arrays (n,)
        Selected query objects, in this order.
    threads : int, optional
    """

    def __init__(
        self, query: ModelData, reference: ModelData, kinds: Array, rows: Array, threads: int | None = None
    ) -> None:
        module = driver(tuple(sorted(query.rows)))
        self._lib, self._ffi = module.lib, module.ffi
        self._threads = threads
        self._state = self._ffi.new("bs_reform *")
        self._models: list[Any] = []
        for name, side in (("query", query), ("reference", reference)):
            model = getattr(self._state, name)
            for kind in side.rows:
                index = KINDS.index(kind)
                model.counts[index] = len(side.rows[kind])
                model.rows[index] = self._keep_alive(reals(side.rows[kind]))
        for kind, elements in reference.elements.items():
            self._grid(self._state.grids[KINDS.index(kind)], grid_of(elements))
        self.select_objects(kinds, rows)

    def select_objects(self, kinds: Array, rows: Array) -> None:
        """Select query objects for subsequent calls."""
        self._state.asked = self.n_selected = len(kinds)
        self._selected = tuple(self._pointer(integers(x)) for x in (kinds, rows))  # the previous buffers are released
        self._state.asked_kinds, self._state.asked_rows = self._selected

    def set_criterion(self, criterion: MatchCriterion) -> None:
        """Set the match criterion for subsequent calls."""
        set_criterion(self._state, criterion)

    def direct(
        self, motor: Array, pairs: tuple[Array, Array, Array, Array, Array], rounds: int, tolerance: float
    ) -> tuple[Array, Array, int]:
        """Algorithm 1 from a motor: mean motor of the last round if it converged, else the last motor; the change in
        each round; and the number of steps of the last round that were not finite. Pairs, (n,) each: kinds, query and
        reference rows, partners (other pairs, or -1), signs.
        """
        motor, inputs = np.array(motor, np.float64), [np.ascontiguousarray(a, np.int32) for a in pairs[:4]]
        mean = motor.copy()
        signs = np.ascontiguousarray(pairs[4], np.float64)
        job = self._ffi.new("bs_direct *")
        job.count, job.tolerance, job.signs = len(signs), tolerance, self._ffi.from_buffer("double[]", signs)
        job.kinds, job.query, job.reference, job.partners = (self._ffi.from_buffer("int32_t[]", a) for a in inputs)
        job.motor, job.mean = (self._ffi.from_buffer("double[]", a) for a in (motor, mean))
        done: list[Array] = []
        while (left := rounds - sum(map(len, done))) > 0 and not (done and done[-1][-1] < tolerance):
            changes = np.empty(min(left, max(1, MOST_HALF_STEPS // max(1, len(signs)))))
            job.rounds, job.changes = len(changes), self._ffi.from_buffer("double[]", changes)
            self._lib.bs_reform_direct(self._state, job)
            done.append(changes[: job.taken])
        changes = np.concatenate(done) if done else np.empty(0)
        settled = len(changes) and changes[-1] < tolerance
        return mean if settled else motor, changes, int(job.skipped)

    def _grid(self, to: Any, grid: Grid) -> None:
        to.corner, to.scale, to.sides = list(grid.corner), grid.scale, grid.sides
        to.starts, to.order = self._keep_alive(integers(grid.starts)), self._keep_alive(integers(grid.order))
        to.elements = self._keep_alive(reals(grid.elements))

    def _run(
        self, stage: str, n: int, grain: int, numbers: Mapping[str, float], inputs: Mapping[str, Array],
        outputs: Mapping[str, Array],
    ) -> None:  # fmt: skip
        pointers = {name: self._pointer(array) for name, array in (*inputs.items(), *outputs.items())}
        job = self._ffi.new(f"{STRUCTURES[stage]} *", {**numbers, **pointers})
        run = getattr(self._lib, f"bs_reform_{stage}")

        def part(begin: int, end: int) -> None:
            run(self._state, job, begin, end)

        parallel.run(part, n, self._threads, grain=grain)

    def _pointer(self, array: Array) -> Any:
        """Pointer to a contiguous array, which must live as long."""
        return self._ffi.from_buffer("int32_t[]" if array.dtype == INTEGER else "double[]", array)

    def _keep_alive(self, array: Array) -> Any:
        """Pointer to an array that lives as long as the scene."""
        self._models.append(self._pointer(array))
        return self._models[-1]
