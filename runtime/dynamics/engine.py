"""The compiled dynamics driver: arrays in, arrays out, over threads.

The only module that knows the layout of the driver's structures (templates/c/dynamics_types.h).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import parallel
from ..codegen.build import load
from ..codegen.programs.dynamics import Needs, dynamics_program
from .assembly import Assembly
from .functions import Called
from .methods import NUMBERS, Method

Array = NDArray[Any]
#: Status of a simulation, as in templates/c/dynamics_rates.j2.
OK, NOT_FINITE, UNDERFLOW, RANK_CHANGED, USER_FAILED, STOPPED, EVENT, NOT_SOLVED = range(8)
#: A row of which less than this share is new, by energy, is redundant. Rows of a pose that is off differ by about as
#: much as it is: far from the constraints more is left out at first.
TOLERANCE, COARSE = 1e-7, 1e-3


@cache
def driver(needs: Needs) -> Any:
    """The compiled driver of simulations that have just this."""
    module = load(dynamics_program(needs).extension())
    if needs.callbacks:

        @module.ffi.def_extern(name="bs_dynamics_user")  # type: ignore[misc]
        def called(handle: Any, which: int, item: int, t: float, state: Any, out: Any) -> int:
            functions: Called = module.ffi.from_handle(handle)
            given = np.frombuffer(module.ffi.buffer(state, 14 * 8), np.float64)
            value = functions.call(which, item, t, given)
            if value is None:
                return 1
            values = np.ascontiguousarray(value, np.float64).ravel()
            module.ffi.memmove(out, module.ffi.from_buffer(values), values.nbytes)
            return 0

    return module


class Driver:
    """An assembly and a method, ready to run."""

    def __init__(self, made: Assembly, method: Method, chart: str, project: bool, baumgarte: float) -> None:
        self.made, self.method = made, method
        module = driver(made.needs(method.driver, chart))
        self._lib, self._ffi = module.lib, module.ffi
        self._kept: list[Any] = []
        self._model = self._new_model(project, baumgarte)
        self._method = self._new_method()
        self.size, self.bodies = made.size, len(made.bodies)

    def _doubles(self, values: Any) -> Any:
        array = np.ascontiguousarray(values, np.float64)
        buffer = self._ffi.from_buffer("double[]", array if array.size else np.zeros(1))
        self._kept.append(buffer)
        return buffer

    def _new_model(self, project: bool, baumgarte: float) -> Any:
        made, model = self.made, self._ffi.new("bs_dynamics *")
        numbers = made.numbers
        model.numbers, model.stride = self._doubles(numbers), numbers.shape[1] if made.size > 1 else 0
        model.bodies, model.springs = 0, made.spring_place
        model.spring_count, model.constraint_count = len(made.springs), len(made.rows)
        model.load_count = len(made.user_loads)
        springs = np.array(made.springs or [(0, 0)], np.int32)
        rows = self._ffi.new("bs_constraint[]", max(1, len(made.rows)))
        for to, row in zip(rows, made.rows, strict=False):
            to.layout = -1 if row.power else made.layouts.index(row.layout)
            to.body, to.other, to.rows, to.user = row.body, row.other, row.rows, row.user
            to.v, to.h, to.a = row.v, row.h, row.a
        loads = self._ffi.new("bs_user_load[]", max(1, len(made.user_loads)))
        for at, (body, world, which) in zip(loads, made.user_loads, strict=False):
            at.body, at.world, at.user = body, int(world), which
        model.spring_bodies = self._ffi.from_buffer("int32_t[]", springs)
        model.constraints, model.loads = rows, loads
        model.tolerance, model.baumgarte, model.project = TOLERANCE, baumgarte, int(project)
        handle = self._ffi.new_handle(made.called)
        model.handle = handle
        self._kept += [springs, rows, loads, handle]
        return model

    def _new_method(self) -> Any:
        given, made = self.method, self._ffi.new("bs_method *")
        scheme = given.scheme
        made.method, made.order = NUMBERS[given.driver], scheme.order
        made.stages, made.all_stages = len(scheme.b), len(scheme.c)
        made.a, made.b, made.c = self._doubles(scheme.a), self._doubles(scheme.b), self._doubles(scheme.c)
        made.errors, made.dense = self._doubles(scheme.errors), self._doubles(scheme.dense)
        made.dense_rows = len(scheme.dense)
        made.composition, made.parts = self._doubles(given.composition), len(given.composition)
        made.step, made.rtol, made.atol = given.step, given.rtol, given.atol
        return made

    def look(self, t: float, motors: Array, twists: Array) -> dict[str, Any]:
        """Accelerations, reactions (rows), and of the constraints matrix, right sides, errors, rates and rank, for the
        first simulation at one state: motors (bodies, 8) and twists (bodies, 6).
        """
        rows = max(1, sum(row.rows for row in self.made.rows))
        size = 6 * self.bodies
        found = {
            "accelerations": np.empty((self.bodies, 6)), "reactions": np.empty((self.bodies, 6)),
            "matrix": np.zeros((rows, size)), "right": np.zeros(rows), "errors": np.zeros(rows), "rates": np.zeros(rows),
        }  # fmt: skip
        given = [self._ffi.from_buffer("double[]", np.ascontiguousarray(x, np.float64)) for x in (motors, twists)]
        to = [self._ffi.from_buffer("double[]", x) for x in found.values()]
        rank = self._lib.bs_dynamics_look(self._model, t, *given, *to)
        self._raise()
        return {**found, "rank": rank}

    def project(self, t: float, motors: Array, twists: Array) -> tuple[Array, Array]:
        """The state next to one that obeys the constraints, of the first simulation."""
        moved = [np.array(x, np.float64) for x in (motors, twists)]
        for tolerance in (COARSE, TOLERANCE):
            given = (self._ffi.from_buffer("double[]", x) for x in moved)
            self._lib.bs_dynamics_project(self._model, t, tolerance, *given)
            self._raise()
        return moved[0], moved[1]

    def _raise(self) -> None:
        error, self.made.called.error = self.made.called.error, None
        if error is not None:
            raise error


class Run:
    """A run under way: states at times, from one to another."""

    def __init__(self, driver: Driver, times: Array, motors: Array, twists: Array, threads: int | None) -> None:
        self.driver, self.times, self._threads = driver, np.ascontiguousarray(times, np.float64), threads
        ffi, n, stores, bodies = driver._ffi, driver.size, len(times), driver.bodies
        self.motors, self.twists = np.full((n, stores, bodies, 8), np.nan), np.full((n, stores, bodies, 6), np.nan)
        self.reactions, self.violations = np.full((n, stores, bodies, 6), np.nan), np.full((n, stores), np.nan)
        self.status, self.reached = np.zeros(n, np.int32), np.full(n, self.times[0])
        self.steps, self.stored = np.zeros(n, np.int64), np.zeros(n, np.int64)
        self._stop = np.zeros(1, np.int32)
        memory = np.zeros((n, driver._lib.bs_dynamics_memory(driver._method)))
        self._run = run = ffi.new("bs_run *")
        self._kept = [memory]
        for name, array in (
            ("times", self.times), ("memory", memory), ("motors", self.motors), ("twists", self.twists),
            ("reactions", self.reactions), ("violations", self.violations), ("reached", self.reached),
        ):  # fmt: skip
            setattr(run, name, ffi.from_buffer("double[]", array))
        run.status, run.stop = ffi.from_buffer("int32_t[]", self.status), ffi.from_buffer("int32_t[]", self._stop)
        run.steps, run.stored = ffi.from_buffer("int64_t[]", self.steps), ffi.from_buffer("int64_t[]", self.stored)
        run.stores = stores
        start = [np.ascontiguousarray(np.broadcast_to(x, (n, bodies, x.shape[-1]))) for x in (motors, twists)]
        given = [ffi.from_buffer("double[]", x) for x in start]
        self._share(lambda a, b: driver._lib.bs_dynamics_start(driver._model, driver._method, run, *given, a, b))

    def to(self, first: int, last: int) -> None:
        """Compute the states at these times, which follow those computed before."""
        driver, run = self.driver, self._run
        run.first, run.last = first, last
        self._share(lambda a, b: driver._lib.bs_dynamics_run(driver._model, driver._method, run, a, b))

    def _share(self, part: Callable[[int, int], None]) -> None:
        threads = 1 if self.driver.made.called.functions else self._threads
        try:
            parallel.run(part, self.driver.size, threads)
        except BaseException:
            self._stop[0] = 1
            raise
