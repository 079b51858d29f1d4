"""The registration driver through numba: what `engine` does through C, with the same bits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.programs.reform import DIRECTED, KINDS
from ..codegen.programs.reform_numba import reform_numba
from ..codegen.targets.numba_kept import KeptModule
from ..codegen.targets.numba_run import numba
from .grids import Grid, grid_of
from .sides import ELEMENT, POSITION, Closeness, MiddleRule, Side
from .stages import MOTOR, PAIRS, TWIST, Stages, integers, reals, share

Array = NDArray[Any]
#: Heads of a scene's arrays, as in templates/numba/reform.py.j2: of each kind among the integers; limits and grids.
HEAD, LIMITS, GRID = 10, 6, 5
#: Among a kind's numbers: where its rows, its elements, and its cells and their order begin; what follows.
QUERY, REFERENCE, ELEMENTS, STARTS, ORDER, SIDES = range(6)


@cache
def numba_driver(kinds: tuple[str, ...]) -> KeptModule:
    """The driver for these kinds, its functions from the cache or compiled as they are needed."""
    return KeptModule("reform_" + "_".join(kinds), reform_numba(kinds), _signatures())


def _signatures() -> dict[str, Any]:
    """Read-only arrays in, so that writable ones serve as well; results are arrays that are written."""
    types = numba().types
    reals, integers, longs = (types.Array(t, 1, "C", readonly=True) for t in (types.f8, types.i4, types.i8))
    found, counts = types.Array(types.f8, 1, "C"), types.Array(types.i4, 1, "C")
    n, number = types.intp, types.f8
    scene = types.Tuple((reals, longs, longs))
    arguments = {
        "elements": (n, reals, found, n),
        "seen": (n, reals, reals, found, n),
        "middle": (n, integers, reals, n, n, number, number, number, found, found, found, counts),
        "unseen": (reals, reals, reals, found, n),
        "unseen_twists": (reals, reals, found, n),
        "invariants": (n, n, n, n, reals, integers, n, n, reals, integers, found),
        "step": (reals, reals, found),
        "rates": (n, n, scene, n, integers, integers, reals, found),
        "samples": (
            n, n, scene, n, number, integers, integers, integers, reals, found, found, counts, counts,
        ),
        "stiffness": (n, n, scene, n, integers, integers, found),
        "refine": (n, n, scene, n, number, found, found, counts, counts),
        "match": (n, n, scene, reals, counts, found, found),
    }  # fmt: skip
    return {name: types.void(*given) for name, given in arguments.items()}


class NumbaDriver:
    """As `engine.Driver`."""

    def __init__(self, kinds: tuple[str, ...], threads: int | None = None) -> None:
        self._module = numba_driver(kinds)
        self._threads = threads

    def elements(self, kind: str, rows: Array) -> Array:
        """Positions, directions and radii (n, 7) of unit objects."""
        found = np.empty((len(rows), ELEMENT))
        self._module["elements"](KINDS.index(kind), _reals(rows), found.reshape(-1), len(rows))
        return found

    def seen(self, kind: str, rows: Array, origin: Array) -> Array:
        """Objects, (n, k) rows, as they are seen from an origin (3,)."""
        found = np.empty(rows.shape)
        self._module["seen"](KINDS.index(kind), _reals(rows), _reals(origin), found.reshape(-1), len(rows))
        return found

    def middle(self, kinds: Array, elements: Array, rule: MiddleRule) -> Array:
        """The point (3,) nearest to all objects together but for a few far ones, by their kinds and elements."""
        n, found = len(elements), np.empty(POSITION)
        room = (np.empty(n), np.empty(n), np.empty(n, np.int32))
        self._module["middle"](n, _integers(kinds), _reals(elements), *rule, found, *room)
        return found

    def unseen(self, motors: Array, to: Array, back: Array) -> Array:
        """Motors (n, 8) from a frame about the position ``back`` to one about ``to`` as motors of the world."""
        found = np.empty((len(motors), MOTOR))
        self._module["unseen"](_reals(motors), _reals(to), _reals(back), found.reshape(-1), len(motors))
        return found

    def unseen_twists(self, twists: Array, origin: Array) -> Array:
        """Twists (n, 6) of a frame about an origin as twists of the world."""
        found = np.empty((len(twists), TWIST))
        self._module["unseen_twists"](_reals(twists), _reals(origin), found.reshape(-1), len(twists))
        return found

    def invariants(self, kinds: tuple[str, str], rows: tuple[Array, Array], places: tuple[Array, Array]) -> Array:
        """Four numbers of pairs of objects (n, 4), by their places in rows; kinds in the order of `KINDS`."""
        run, found = self._module["invariants"], np.empty((len(places[0]), 4))
        given: list[Any] = []
        for kind, x, index in zip(kinds, rows, places, strict=True):
            given += [KINDS.index(kind), x.shape[1], _reals(x), _integers(index)]
        share(lambda begin, end: run(begin, end, *given, found.reshape(-1)), len(found), self._threads, PAIRS)
        return found

    def step(self, motor: Array, twist: Array) -> Array:
        """The motor next to (1 + twist) motor."""
        found = np.empty(MOTOR)
        self._module["step"](_reals(motor), _reals(twist), found)
        return found


class NumbaScene(Stages):
    """As `engine.Scene`."""

    def __init__(
        self, query: Side, reference: Side, asked_kinds: Array, asked_rows: Array, threads: int | None = None
    ) -> None:
        self._module = numba_driver(tuple(k for k in KINDS if k in query.rows))
        self._threads = threads
        self._heads, self._reals = np.zeros((len(KINDS), HEAD), np.int64), [np.zeros(LIMITS + GRID * len(KINDS))]
        self._longs = [self._heads.reshape(-1)]
        for kind, rows in query.rows.items():
            self._place(kind, rows, reference.rows[kind], grid_of(reference.elements[kind]))
        self._scene = (np.concatenate(self._reals), np.concatenate(self._longs))
        self.ask(asked_kinds, asked_rows)

    def _place(self, kind: str, query: Array, reference: Array, grid: Grid) -> None:
        """One kind's arrays behind what there is, and where they begin."""
        number = KINDS.index(kind)
        head = self._heads[number]
        for place, array in ((QUERY, query), (REFERENCE, reference), (ELEMENTS, grid.elements)):
            head[place] = sum(map(len, self._reals))
            self._reals.append(_reals(array))
        for place, array in ((STARTS, grid.starts), (ORDER, grid.order)):
            head[place] = sum(map(len, self._longs))
            self._longs.append(array.astype(np.int64))
        head[SIDES:] = (*grid.sides, len(reference), query.shape[1])
        self._reals[0][LIMITS + GRID * number :][:GRID] = (*grid.corner, grid.scale, kind in DIRECTED)

    def ask(self, kinds: Array, rows: Array) -> None:
        """Look at other query objects."""
        self.asked = len(kinds)
        self._asked = np.concatenate([kinds, rows]).astype(np.int64)

    def closeness(self, given: Closeness) -> None:
        """From now on."""
        place, turn, size = given.weights
        other = -1.0 if given.align else 1.0
        self._scene[0][:LIMITS] = (place, 2 * turn, size, given.limit, given.least, other)

    def _run(
        self, stage: str, n: int, grain: int, numbers: Mapping[str, float], given: Mapping[str, Array],
        found: Mapping[str, Array],
    ) -> None:  # fmt: skip
        run: Callable[..., None] = self._module[stage]
        scene = (*self._scene, self._asked)
        arguments = (*numbers.values(), *(x.reshape(-1) for x in (*given.values(), *found.values())))
        share(lambda begin, end: run(begin, end, scene, *arguments), n, self._threads, grain)


def _reals(array: Array) -> Array:
    return reals(array).reshape(-1)


def _integers(array: Array) -> Array:
    return integers(array).reshape(-1)
