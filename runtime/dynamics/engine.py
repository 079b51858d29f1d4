"""The compiled dynamics driver: arrays in, arrays out, over threads.

The only module that knows the layout of the driver's structures (templates/c/dynamics_types.h).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import parallel
from ..codegen.build import load
from ..codegen.programs.dynamics import Needs, dynamics_program
from .assembly import Assembly
from .functions import Called
from .methods import NUMBERS, Method

if TYPE_CHECKING:
    from .parameters import Directions

Array = NDArray[Any]
#: Status of a simulation, as in templates/c/dynamics_rates.j2.
OK, NOT_FINITE, UNDERFLOW, RANK_CHANGED, USER_FAILED, STOPPED, EVENT, NOT_SOLVED, VIOLATED = range(9)
#: Steps of a simulation between two looks at interrupts and progress; of user's functions fewer are asked at once.
STEPS, STEPS_OF_FUNCTIONS = 16384, 256
#: A row of which less than this share is new, by energy, is redundant. Rows of a pose that is off differ by about as
#: much as it is: far from the constraints more is left out at first.
TOLERANCE, COARSE = 1e-7, 1e-3


@cache
def driver(needs: Needs) -> Any:
    """The compiled driver of simulations that have just this."""
    module = load(dynamics_program(needs).extension())
    if needs.callbacks:

        def lost(_: Any, error: BaseException, traceback: Any) -> None:
            # An interrupt may come before the first line of what is called, or between two of them.
            module.ffi.from_handle(traceback.tb_frame.f_locals["handle"]).keep(error)

        @module.ffi.def_extern(name="bs_dynamics_user", error=1, onerror=lost)  # type: ignore[untyped-decorator, unused-ignore]
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

    def __init__(
        self, made: Assembly, method: Method, chart: str, project: bool, baumgarte: float, part: slice = slice(None),
        directions: Directions | None = None,
    ) -> None:  # fmt: skip
        self.made, self.method, self.part, self.directions = made, method, part, directions
        self.tangents = 0 if directions is None else directions.count
        module = driver(replace(made.needs(method.driver, chart), tangents=self.tangents))
        self._lib, self._ffi = module.lib, module.ffi
        self._kept: list[Any] = []
        self._model = self._new_model(project, baumgarte)
        self._method = self._new_method()
        self.size, self.bodies = len(range(made.size)[part]), len(made.bodies)

    def _doubles(self, values: Any) -> Any:
        array = np.ascontiguousarray(values, np.float64)
        buffer = self._ffi.from_buffer("double[]", array if array.size else np.zeros(1))
        self._kept.append(buffer)
        return buffer

    def _new_model(self, project: bool, baumgarte: float) -> Any:
        made, model = self.made, self._ffi.new("bs_dynamics *")
        numbers = made.numbers[self.part]
        model.numbers, model.stride = self._doubles(numbers), numbers.shape[1]
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
        if self.directions is not None:
            model.directions = self._doubles(self.directions.scaled[0][self.part])
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
            "matrix": np.zeros((rows, size)), "right": np.zeros(rows), "errors": np.zeros(rows),
            "rates": np.zeros(rows),
        }  # fmt: skip
        given = [self._ffi.from_buffer("double[]", np.ascontiguousarray(x, np.float64)) for x in (motors, twists)]
        to = [self._ffi.from_buffer("double[]", x) for x in found.values()]
        rank = self._lib.bs_dynamics_look(self._model, t, *given, *to)
        self.raise_error()
        return {**found, "rank": rank}

    def project(self, t: float, motors: Array, twists: Array) -> tuple[Array, Array]:
        """The state next to one that obeys the constraints, of the first simulation."""
        moved = [np.array(x, np.float64) for x in (motors, twists)]
        for tolerance in (COARSE, TOLERANCE):
            given = (self._ffi.from_buffer("double[]", x) for x in moved)
            self._lib.bs_dynamics_project(self._model, t, tolerance, *given)
            self.raise_error()
        return moved[0], moved[1]

    def raise_error(self) -> None:
        """Raise what a user's function raised."""
        error, self.made.called.error = self.made.called.error, None
        if error is not None:
            raise error


class Run:
    """A run under way: states at times, from one to another.

    Attributes
    ----------
    motors, twists, reactions : array (simulations, stores, bodies, 8 or 6)
    violations : array (simulations, stores)
    status, reached, steps, stored : array (simulations,)
        How it stands, the time of the last state, steps taken and states stored.
    tangents : array (simulations, stores, directions, 2, bodies, 6)
        Of motors, as twists in their frames, and of twists.
    start, start_rows : array (simulations, 2)
        Largest errors of poses and of rates at the start, as shares of what they are made of, and the rows.
    off : array (simulations, 2)
        How far the last state stays off the constraints after it was brought back, and the row.
    """

    def __init__(
        self, driver: Driver, times: Array, motors: Array, twists: Array, threads: int | None = 1, project: bool = False
    ) -> None:
        self.driver, self.times, self._threads = driver, np.ascontiguousarray(times, np.float64), threads
        n, stores, bodies = driver.size, len(times), driver.bodies
        self.motors, self.twists = np.full((n, stores, bodies, 8), np.nan), np.full((n, stores, bodies, 6), np.nan)
        self.reactions, self.violations = np.full((n, stores, bodies, 6), np.nan), np.full((n, stores), np.nan)
        self.status, self.reached = np.zeros(n, np.int32), np.full(n, self.times[0])
        self.steps, self.stored = np.zeros(n, np.int64), np.zeros(n, np.int64)
        self.start, self.start_rows = np.zeros((n, 2)), np.zeros((n, 2), np.int32)
        self.off = np.zeros((n, 2))
        self.tangents = np.full((n, stores, driver.tangents, 2, bodies, 6), np.nan)
        self._start_tangents = np.zeros((n, driver.tangents, 2, bodies, 6))
        if driver.directions is not None:
            self._start_tangents[:] = driver.directions.scaled[1][driver.part]
        self._stop = np.zeros(1, np.int32)
        self._memory = np.zeros((n, driver._lib.bs_dynamics_memory(driver._method)))
        self._run = self._new_run(project)
        start = [
            x if x.shape[:-1] == (n, bodies) else np.broadcast_to(x, (n, bodies, x.shape[-1])) for x in (motors, twists)
        ]
        start = [np.ascontiguousarray(x) for x in start]
        given = [driver._ffi.from_buffer("double[]", x) for x in start]
        self._share(lambda a, b: driver._lib.bs_dynamics_start(driver._model, driver._method, self._run, *given, a, b))

    def _new_run(self, project: bool) -> Any:
        ffi, run = self.driver._ffi, self.driver._ffi.new("bs_run *")
        for type_, arrays in (
            ("double[]", {"times": self.times, "memory": self._memory, "motors": self.motors, "twists": self.twists,
                          "reactions": self.reactions, "violations": self.violations, "reached": self.reached,
                          "start": self.start, "off": self.off, "tangents": self.tangents,
                          "start_tangents": self._start_tangents}),
            ("int32_t[]", {"status": self.status, "stop": self._stop, "start_rows": self.start_rows}),
            ("int64_t[]", {"steps": self.steps, "stored": self.stored}),
        ):  # fmt: skip
            for name, array in arrays.items():
                setattr(run, name, ffi.from_buffer(type_, array))
        run.stores, run.project_start = len(self.times), int(project)
        steps = STEPS_OF_FUNCTIONS if self.driver.made.called.functions else STEPS
        run.budget = max(16, steps // self.driver.bodies**2)
        return run

    def go_on(self, last: int) -> bool:
        """Some steps more towards the states before the last one; whether there is more to do."""
        driver, run = self.driver, self._run
        run.last = last
        self._share(lambda a, b: driver._lib.bs_dynamics_run(driver._model, driver._method, run, a, b))
        return bool(((self.stored < last) & (self.status == OK)).any())

    def to(self, last: int) -> None:
        """All states before the last one."""
        while self.go_on(last):
            pass

    def stop(self) -> None:
        """Mark what is not done as stopped."""
        self.status[(self.stored < len(self.times)) & (self.status == OK)] = STOPPED

    def _share(self, part: Callable[[int, int], None]) -> None:
        threads = 1 if self.driver.made.called.functions else self._threads
        try:
            if self.driver.size == 1:  # what a pool costs counts beside a short run
                parallel.thread_count(threads)
                part(0, 1)
            else:
                parallel.run(part, self.driver.size, threads)
        except BaseException:
            self._stop[0] = 1
            raise
