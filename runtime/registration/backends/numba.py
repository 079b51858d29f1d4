"""The numba backend: the registration driver compiled by numba, with the same bits as that of `c`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.execute.numba_cache import CachedModule
from ...codegen.execute.numba_jit import numba
from ...codegen.programs.registration.registration import DIRECTED, KINDS
from ...codegen.programs.registration.registration_numba import reform_numba
from ...common import parallel
from ..model.grid import Grid, grid_of
from .model_rows import POSITION, CenterRule, MatchCriterion, ModelData
from .stages import PAIRS, Functions, Stages, integers, reals

Array = NDArray[Any]
#: Heads of a scene's arrays, as in templates/numba/reform.py.j2: of each kind among the integers; limits and grids.
HEAD, LIMITS, GRID = 10, 6, 5
#: Among a kind's numbers: where its rows, its elements, and its cells and their order begin; what follows.
QUERY, REFERENCE, ELEMENTS, STARTS, ORDER, SIDES = range(6)


@cache
def numba_driver(kinds: tuple[str, ...]) -> CachedModule:
    """Driver for these kinds, with functions from the cache or compiled at first use."""
    return CachedModule("reform_" + "_".join(kinds), reform_numba(kinds), _signatures())


def _signatures() -> dict[str, Any]:
    """Types of arguments: inputs are read-only arrays, so that writable ones are accepted too; outputs are writable."""
    types = numba().types
    reals, integers, longs = (types.Array(t, 1, "C", readonly=True) for t in (types.f8, types.i4, types.i8))
    outputs, counts = types.Array(types.f8, 1, "C"), types.Array(types.i4, 1, "C")
    n, number = types.intp, types.f8
    scene = types.Tuple((reals, longs, longs))
    arguments = {
        "elements": (n, reals, outputs, n),
        "to_frame": (n, reals, reals, outputs, n),
        "robust_center": (n, integers, reals, n, n, number, number, number, outputs, outputs, outputs, counts),
        "motors_to_world": (reals, reals, reals, outputs, n),
        "twists_to_world": (reals, reals, outputs, n),
        "invariants": (n, n, n, n, reals, integers, n, n, reals, integers, outputs),
        "step": (reals, reals, outputs),
        "rates": (n, n, scene, n, integers, integers, reals, outputs),
        "samples": (
            n, n, scene, n, number, integers, integers, integers, reals, outputs, outputs, counts, counts,
        ),
        "stiffness": (n, n, scene, n, integers, integers, outputs),
        "refine": (n, n, scene, n, number, outputs, outputs, counts, counts),
        "match": (n, n, scene, reals, counts, outputs, outputs),
    }  # fmt: skip
    return {name: types.void(*inputs) for name, inputs in arguments.items()}


class NumbaDriver(Functions):
    """See `c.Driver`."""

    def __init__(self, kinds: tuple[str, ...], threads: int | None = None) -> None:
        self._module = numba_driver(kinds)
        self._threads = threads

    def _call(self, name: str, kind: str | None, inputs: Sequence[Array], shape: tuple[int, ...]) -> Array:
        outputs = np.empty(shape)
        number, count = ([] if kind is None else [KINDS.index(kind)]), shape[:-1]
        self._module[name](*number, *map(_reals, inputs), outputs.reshape(-1), *count)
        return outputs

    def robust_center(self, kinds: Array, elements: Array, rule: CenterRule) -> Array:
        n, outputs = len(elements), np.empty(POSITION)
        workspace = (np.empty(n), np.empty(n), np.empty(n, np.int32))
        self._module["robust_center"](n, _integers(kinds), _reals(elements), *rule, outputs, *workspace)
        return outputs

    def invariants(self, kinds: tuple[str, str], rows: tuple[Array, Array], indices: tuple[Array, Array]) -> Array:
        run, outputs = self._module["invariants"], np.empty((len(indices[0]), 4))
        inputs: list[Any] = []
        for kind, x, index in zip(kinds, rows, indices, strict=True):
            inputs += [KINDS.index(kind), x.shape[1], _reals(x), _integers(index)]
        parallel.run(
            lambda begin, end: run(begin, end, *inputs, outputs.reshape(-1)), len(outputs), self._threads, grain=PAIRS
        )
        return outputs


class NumbaScene(Stages):
    """See `c.Scene`."""

    def __init__(
        self, query: ModelData, reference: ModelData, kinds: Array, rows: Array, threads: int | None = None
    ) -> None:
        self._module = numba_driver(tuple(k for k in KINDS if k in query.rows))
        self._threads = threads
        self._heads, self._reals = np.zeros((len(KINDS), HEAD), np.int64), [np.zeros(LIMITS + GRID * len(KINDS))]
        self._longs = [self._heads.reshape(-1)]
        for kind, objects in query.rows.items():
            self._append_kind(kind, objects, reference.rows[kind], grid_of(reference.elements[kind]))
        self._scene = (np.concatenate(self._reals), np.concatenate(self._longs))
        self.select_objects(kinds, rows)

    def _append_kind(self, kind: str, query: Array, reference: Array, grid: Grid) -> None:
        """Append the arrays of a kind, and record their offsets."""
        number = KINDS.index(kind)
        head = self._heads[number]
        for index, array in ((QUERY, query), (REFERENCE, reference), (ELEMENTS, grid.elements)):
            head[index] = sum(map(len, self._reals))
            self._reals.append(_reals(array))
        for index, array in ((STARTS, grid.starts), (ORDER, grid.order)):
            head[index] = sum(map(len, self._longs))
            self._longs.append(array.astype(np.int64))
        head[SIDES:] = (*grid.sides, len(reference), query.shape[1])
        self._reals[0][LIMITS + GRID * number :][:GRID] = (*grid.corner, grid.scale, kind in DIRECTED)

    def select_objects(self, kinds: Array, rows: Array) -> None:
        """Select query objects for subsequent calls."""
        self.n_selected = len(kinds)
        self._selected = np.concatenate([kinds, rows]).astype(np.int64)

    def set_criterion(self, criterion: MatchCriterion) -> None:
        """Set the match criterion for subsequent calls."""
        position, direction, size = criterion.weights
        other = -1.0 if criterion.align else 1.0
        self._scene[0][:LIMITS] = (position, 2 * direction, size, criterion.limit, criterion.early_exit_fraction, other)

    def _run(
        self, stage: str, n: int, grain: int, numbers: Mapping[str, float], inputs: Mapping[str, Array],
        outputs: Mapping[str, Array],
    ) -> None:  # fmt: skip
        run: Callable[..., None] = self._module[stage]
        scene = (*self._scene, self._selected)
        arguments = (*numbers.values(), *(x.reshape(-1) for x in (*inputs.values(), *outputs.values())))
        parallel.run(lambda begin, end: run(begin, end, scene, *arguments), n, self._threads, grain=grain)


def _reals(array: Array) -> Array:
    return reals(array).reshape(-1)


def _integers(array: Array) -> Array:
    return integers(array).reshape(-1)
