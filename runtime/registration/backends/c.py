"""The compiled registration driver of some kinds of object: arrays in, arrays out, over threads.

The only module that knows the layout of the driver's structures (templates/c/reform_types.h).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.build import load
from ..codegen.programs.reform import KINDS, in_order, reform_program
from ..installed import installed_program
from .grids import Grid, grid_of
from .sides import ELEMENT, POSITION, Closeness, MiddleRule, Side
from .stages import MOTOR, PAIRS, TWIST, Stages, integers, reals, share

Array = NDArray[Any]
INTEGER = np.dtype(np.int32)
#: Structures of stages by items.
STRUCTURES = {
    "samples": "bs_samples", "stiffness": "bs_sets", "refine": "bs_refined", "match": "bs_matching",
    "rates": "bs_rates",
}  # fmt: skip
#: Steps of Algorithm 1 between two looks at an interrupt: some 100 ms.
MOST_HALF_STEPS = 1 << 17


@cache
def driver(kinds: tuple[str, ...]) -> Any:
    """The compiled driver for these kinds: that of all kinds where it was installed; else from the cache, or new."""
    module = installed_program("reform")
    return load(reform_program(in_order(kinds)).extension()) if module is None else module


class Driver:
    """What the driver computes of objects alone."""

    def __init__(self, kinds: tuple[str, ...], threads: int | None = None) -> None:
        self._module = driver(kinds)
        self._threads = threads

    def elements(self, kind: str, rows: Array) -> Array:
        """Positions, directions and radii (n, 7) of unit objects."""
        rows, found = np.ascontiguousarray(rows, np.float64), np.empty((len(rows), ELEMENT))
        self._module.lib.bs_reform_elements(KINDS.index(kind), *self._numbers(rows, found), len(rows))
        return found

    def seen(self, kind: str, rows: Array, origin: Array) -> Array:
        """Objects, (n, k) rows, as they are seen from an origin (3,)."""
        rows, found = np.ascontiguousarray(rows, np.float64), np.empty(rows.shape)
        self._module.lib.bs_reform_seen(KINDS.index(kind), *self._numbers(rows, origin, found), len(rows))
        return found

    def apart(self, kind: str, a: Array, b: Array, given: Closeness, signs: Array | None = None) -> Array:
        """Weighted squares (..) of how far elements (.., 7) are apart; they broadcast. ``signs`` says which are turned
        round; where it is not given, that x and -x are one, or not, does.
        """
        if signs is not None:
            a = a.copy()
            a[..., POSITION : 2 * POSITION] *= np.asarray(signs)[..., None]
        a, b = (np.ascontiguousarray(x, np.float64) for x in np.broadcast_arrays(a, b))
        found, weights = np.empty(a.shape[:-1]), np.array(given.weights)
        other = -1.0 if given.align and signs is None else 1.0
        x, y, w, to = self._numbers(a, b, weights, found)
        run = self._module.lib.bs_reform_apart
        share(lambda i, j: run(KINDS.index(kind), x, y, w, other, to, i, j), found.size, self._threads, PAIRS)
        return found

    def middle(self, kinds: Array, elements: Array, rule: MiddleRule) -> Array:
        """The point (3,) nearest to all objects together but for a few far ones, by their kinds and elements."""
        ffi, n, found = self._module.ffi, len(elements), np.empty(POSITION)
        squares, ordered, near = np.empty(n), np.empty(n), np.empty(n, np.int32)
        job = ffi.new("bs_middle *")
        job.count, job.rounds, job.place, job.far, job.rounding, job.loose = n, *rule
        numbers = np.ascontiguousarray(kinds, np.int32)
        job.kinds, job.near = ffi.from_buffer("int32_t[]", numbers), ffi.from_buffer("int32_t[]", near)
        job.elements, job.point, job.squares, job.ordered = self._numbers(elements, found, squares, ordered)
        self._module.lib.bs_reform_middle(job)
        return found

    def unseen(self, motors: Array, to: Array, back: Array) -> Array:
        """Motors (n, 8) from a frame about the position ``back`` to one about ``to`` as motors of the world."""
        found = np.empty((len(motors), MOTOR))
        self._module.lib.bs_reform_unseen(*self._numbers(motors, to, back, found), len(motors))
        return found

    def unseen_twists(self, twists: Array, origin: Array) -> Array:
        """Twists (n, 6) of a frame about an origin as twists of the world."""
        found = np.empty((len(twists), TWIST))
        self._module.lib.bs_reform_unseen_twists(*self._numbers(twists, origin, found), len(twists))
        return found

    def _numbers(self, *arrays: Array) -> list[Any]:
        return [self._module.ffi.from_buffer("double[]", np.ascontiguousarray(a, np.float64)) for a in arrays]

    def invariants(self, kinds: tuple[str, str], rows: tuple[Array, Array], places: tuple[Array, Array]) -> Array:
        """Four numbers of pairs of objects (n, 4), by their places in rows; kinds in the order of `KINDS`."""
        ffi, run = self._module.ffi, self._module.lib.bs_reform_invariants
        found = np.empty((len(places[0]), 4))
        given = [np.ascontiguousarray(r, np.float64) for r in rows]
        index = [np.ascontiguousarray(p, np.int32) for p in places]
        (a, b), (i, j) = ([ffi.from_buffer(t, x) for x in xs] for t, xs in (("double[]", given), ("int32_t[]", index)))
        to = ffi.from_buffer("double[]", found)
        one, two = (KINDS.index(k) for k in kinds)

        def part(begin: int, end: int) -> None:
            run(one, a, i, two, b, j, to, begin, end)

        share(part, len(found), self._threads, PAIRS)
        return found

    def step(self, motor: Array, twist: Array) -> Array:
        """The motor next to (1 + twist) motor."""
        found = np.empty(MOTOR)
        self._module.lib.bs_reform_step(*self._numbers(motor, twist, found))
        return found


class Scene(Stages):
    """A query and a reference, ready to be laid over each other.

    Parameters
    ----------
    query, reference : Side
    asked_kinds, asked_rows : int32 arrays (n,)
        Query objects that are looked at, in this order.
    threads : int, optional
    """

    def __init__(
        self, query: Side, reference: Side, asked_kinds: Array, asked_rows: Array, threads: int | None = None
    ) -> None:
        module = driver(tuple(sorted(query.rows)))
        self._lib, self._ffi = module.lib, module.ffi
        self._threads = threads
        self._state = self._ffi.new("bs_reform *")
        self._models: list[Any] = []
        for name, side in (("query", query), ("reference", reference)):
            model = getattr(self._state, name)
            for kind in side.rows:
                place = KINDS.index(kind)
                model.counts[place] = len(side.rows[kind])
                model.rows[place] = self._held(reals(side.rows[kind]))
        for kind, elements in reference.elements.items():
            self._grid(self._state.grids[KINDS.index(kind)], grid_of(elements))
        self.ask(asked_kinds, asked_rows)

    def ask(self, kinds: Array, rows: Array) -> None:
        """Look at other query objects."""
        self._state.asked = self.asked = len(kinds)
        self._asked = tuple(self._pointer(integers(x)) for x in (kinds, rows))  # those before it are let go
        self._state.asked_kinds, self._state.asked_rows = self._asked

    def closeness(self, given: Closeness) -> None:
        """From now on."""
        self._state.weights = given.weights
        self._state.limit, self._state.least, self._state.align = given.limit, given.least, int(given.align)

    def direct(
        self, motor: Array, pairs: tuple[Array, Array, Array, Array, Array], rounds: int, tolerance: float
    ) -> tuple[Array, Array, int]:
        """Algorithm 1 from a motor: the middle of those of the last round, or where that ends if it has not settled;
        how far each round moved it; and the steps of the last one that were not finite. Pairs, (n,) each: kinds, query
        and reference rows, partners (other pairs, or -1), signs.
        """
        motor, given = np.array(motor, np.float64), [np.ascontiguousarray(a, np.int32) for a in pairs[:4]]
        mean = motor.copy()
        signs = np.ascontiguousarray(pairs[4], np.float64)
        job = self._ffi.new("bs_direct *")
        job.count, job.tolerance, job.signs = len(signs), tolerance, self._ffi.from_buffer("double[]", signs)
        job.kinds, job.query, job.reference, job.partners = (self._ffi.from_buffer("int32_t[]", a) for a in given)
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
        to.starts, to.order = self._held(integers(grid.starts)), self._held(integers(grid.order))
        to.elements = self._held(reals(grid.elements))

    def _run(
        self, stage: str, n: int, grain: int, numbers: Mapping[str, float], given: Mapping[str, Array],
        found: Mapping[str, Array],
    ) -> None:  # fmt: skip
        pointers = {name: self._pointer(array) for name, array in (*given.items(), *found.items())}
        job = self._ffi.new(f"{STRUCTURES[stage]} *", {**numbers, **pointers})
        run = getattr(self._lib, f"bs_reform_{stage}")

        def part(begin: int, end: int) -> None:
            run(self._state, job, begin, end)

        share(part, n, self._threads, grain)

    def _pointer(self, array: Array) -> Any:
        """The numbers of an array that is contiguous, and lives as long."""
        return self._ffi.from_buffer("int32_t[]" if array.dtype == INTEGER else "double[]", array)

    def _held(self, array: Array) -> Any:
        """The same for as long as the scene lives."""
        self._models.append(self._pointer(array))
        return self._models[-1]
