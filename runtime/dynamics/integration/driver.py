"""The compiled dynamics driver: arrays in, arrays out, over threads.

The only module that knows the layout of the driver's structures (templates/c/programs/dynamics/dynamics_types.h).
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.extension import load, required_compiler
from ...codegen.interrupts import deferred_interrupts
from ...codegen.programs.dynamics.config import DynamicsConfig
from ...codegen.programs.dynamics.dynamics import dynamics_program
from ...common import parallel
from ..assembly.callbacks import CallbackRegistry
from ..assembly.data import Assembly
from .integrators import NUMBERS, Method

if TYPE_CHECKING:
    from ..sensitivity.parameters import Directions

Array = NDArray[Any]
#: Status of a simulation, as in templates/c/programs/dynamics/dynamics_rates.j2.
OK, NOT_FINITE, UNDERFLOW, RANK_CHANGED, USER_FAILED, STOPPED, EVENT, NOT_SOLVED, VIOLATED = range(9)
STALLED = 10
#: Steps of a simulation between two checks of interrupts and progress.
STEPS = 16384
#: The same if it calls users' functions.
STEPS_OF_FUNCTIONS = 256
#: Fraction of a constraint equation, by energy, that must be independent of the others; below it, it is redundant.
TOLERANCE = 1e-7
#: The same for a first projection: far from the constraints, redundant equations differ by about the error of the pose.
COARSE = 1e-3
#: Bodies beyond which there are fewer steps between two checks: the work of a step grows as their cube.
MANY = 50
#: Largest workspace, in bytes, that is reused by the next call.
REUSED_WORKSPACE = 1 << 22


@cache
def driver(needs: DynamicsConfig) -> Any:
    """Compiled driver of simulations with these needs."""
    # before the program is generated, which takes longer
    required_compiler("simulations are compiled when they first run")
    module = load(dynamics_program(needs).extension())
    if needs.callbacks:

        def on_error(_: Any, error: BaseException, traceback: Any) -> None:
            # An interrupt may come before the first line of `call_function`, or between two of them.
            module.ffi.from_handle(traceback.tb_frame.f_locals["handle"]).keep(error)

        @module.ffi.def_extern(name="bs_dynamics_user", error=1, onerror=on_error)  # type: ignore[untyped-decorator, unused-ignore]
        def call_function(handle: Any, which: int, item: int, t: float, state: Any, out: Any) -> int:
            functions: CallbackRegistry = module.ffi.from_handle(handle)
            values = np.frombuffer(module.ffi.buffer(state, 14 * 8), np.float64)
            value = functions.call(which, item, t, values)
            if value is None:
                return 1
            result = np.ascontiguousarray(value, np.float64).ravel()
            module.ffi.memmove(out, module.ffi.from_buffer(result), result.nbytes)
            return 0

    return module


class Driver:
    """An assembly and a method, ready to run."""

    def __init__(
        self, assembly: Assembly, method: Method, chart: str, project: bool, baumgarte: float,
        part: slice = slice(None), directions: Directions | None = None,
    ) -> None:  # fmt: skip
        self.assembly, self.method, self.part, self.directions = assembly, method, part, directions
        self.tangents = 0 if directions is None else directions.count
        module = driver(replace(assembly.needs(method.driver, chart), tangents=self.tangents))
        self._lib, self._ffi = module.lib, module.ffi
        self._alive: list[Any] = []
        self._workspaces: list[Any] = []
        self._model = self._new_model(project, baumgarte)
        self._method = self._new_method()
        self.size, self.bodies = len(range(assembly.size)[part]), len(assembly.bodies)
        self.equations = assembly.equation_count
        self.memory = int(self._lib.bs_dynamics_memory(self._method))  # numbers that a simulation keeps between calls
        self.workspace_bytes = int(self._lib.bs_dynamics_workspace())

    def _doubles(self, values: Any) -> Any:
        array = np.ascontiguousarray(values, np.float64)
        buffer = self._ffi.from_buffer("double[]", array if array.size else np.zeros(1))
        self._alive.append(buffer)
        return buffer

    def _new_model(self, project: bool, baumgarte: float) -> Any:
        assembly, model = self.assembly, self._ffi.new("bs_dynamics *")
        numbers = assembly.parameters[self.part]
        model.numbers, model.stride = self._doubles(numbers), numbers.shape[1]
        model.bodies, model.springs = 0, assembly.spring_offset
        model.spring_count, model.constraint_count = len(assembly.springs), len(assembly.driver_constraints)
        model.load_count = len(assembly.user_loads)
        springs = np.array(assembly.springs or [(0, 0)], np.int32)
        constraints = self._ffi.new("bs_constraint[]", max(1, len(assembly.driver_constraints)))
        for struct, packed in zip(constraints, assembly.driver_constraints, strict=False):
            struct.layout = -1 if packed.power else assembly.layouts.index(packed.layout)
            struct.body, struct.other = packed.body, packed.other
            struct.rows, struct.user = packed.equations, packed.callback
            struct.v, struct.h, struct.a = packed.object_offset, packed.target_offset, packed.matrix_offset
            struct.unknown = packed.radius_error
        loads = self._ffi.new("bs_user_load[]", max(1, len(assembly.user_loads)))
        for struct, (body, world, which) in zip(loads, assembly.user_loads, strict=False):
            struct.body, struct.world, struct.user = body, int(world), which
        model.spring_bodies = self._ffi.from_buffer("int32_t[]", springs)
        model.constraints, model.loads = constraints, loads
        model.tolerance, model.baumgarte, model.project = TOLERANCE, baumgarte, int(project)
        if self.directions is not None:
            model.directions = self._doubles(self.directions.scaled[0][self.part])
        handle = self._ffi.new_handle(assembly.callbacks)
        model.handle = handle
        self._alive += [springs, constraints, loads, handle]
        return model

    def _new_method(self) -> Any:
        method, struct = self.method, self._ffi.new("bs_method *")
        scheme = method.scheme
        struct.method, struct.order = NUMBERS[method.driver], scheme.order
        struct.stages, struct.all_stages = len(scheme.b), len(scheme.c)
        struct.a, struct.b, struct.c = self._doubles(scheme.a), self._doubles(scheme.b), self._doubles(scheme.c)
        struct.errors, struct.dense = self._doubles(scheme.errors), self._doubles(scheme.dense)
        struct.dense_rows = len(scheme.dense)
        struct.composition, struct.parts = self._doubles(method.composition), len(method.composition)
        struct.step, struct.rtol, struct.atol = method.step, method.rtol, method.atol
        return struct

    def workspace(self) -> Any:
        """Workspace for one thread, to be returned by `release`."""
        try:
            return self._workspaces.pop()
        except IndexError:
            return self._ffi.from_buffer(np.empty(self.workspace_bytes // 8 + 1))

    def release(self, workspace: Any) -> None:
        """Keep a workspace for the next call, unless it is large: a finished simulation does not hold memory."""
        if self.workspace_bytes <= REUSED_WORKSPACE:
            self._workspaces.append(workspace)

    def evaluate(self, t: float, motors: Array, twists: Array) -> dict[str, Any]:
        """Evaluate the dynamics of the first simulation at one state, motors (bodies, 8) and twists (bodies, 6).

        Returns
        -------
        dict
            Accelerations and reactions; matrix, right sides, errors, rates and rank of the constraints.
        """
        rows = max(1, self.assembly.equation_count)
        size = 6 * self.bodies
        values = {
            "accelerations": np.empty((self.bodies, 6)), "reactions": np.empty((self.bodies, 6)),
            "matrix": np.zeros((rows, size)), "right": np.zeros(rows), "errors": np.zeros(rows),
            "rates": np.zeros(rows),
        }  # fmt: skip
        state = [self._ffi.from_buffer("double[]", np.ascontiguousarray(x, np.float64)) for x in (motors, twists)]
        results = [self._ffi.from_buffer("double[]", x) for x in values.values()]
        workspace = self.workspace()
        rank = self._lib.bs_dynamics_evaluate(self._model, t, *state, *results, workspace)
        self.release(workspace)
        self.raise_error()
        return {**values, "rank": rank}

    def project(self, t: float, motors: Array, twists: Array) -> tuple[Array, Array]:
        """Nearest state of the first simulation that obeys the constraints."""
        projected = [np.array(x, np.float64) for x in (motors, twists)]
        for tolerance in (COARSE, TOLERANCE):
            state = (self._ffi.from_buffer("double[]", x) for x in projected)
            workspace = self.workspace()
            self._lib.bs_dynamics_project(self._model, t, tolerance, *state, workspace)
            self.release(workspace)
            self.raise_error()
        return projected[0], projected[1]

    def raise_error(self) -> None:
        """Raise the error of a user's function."""
        error, self.assembly.callbacks.error = self.assembly.callbacks.error, None
        if error is not None:
            raise error


class Run:
    """States of simulations at times, computed step by step.

    Attributes
    ----------
    motors, twists, reactions : array (simulations, stores, bodies, 8 or 6)
    violations : array (simulations, stores)
    status, reached, steps, stored : array (simulations,)
        Status, time of the last state, number of steps taken and of states stored.
    tangents : array (simulations, stores, directions, 2, bodies, 6)
        Tangents of motors, as twists in their frames, and of twists.
    start, start_rows : array (simulations, 2)
        Largest errors of poses and of rates at the start, as fractions of their terms, and the rows.
    off : array (simulations, 2)
        Error of the constraints that remains after projection of the last state, and its row.
    """

    def __init__(
        self, driver: Driver, times: Array, motors: Array, twists: Array, threads: int | None = 1, project: bool = False
    ) -> None:
        self._allocate(driver, times)
        n, bodies = driver.size, driver.bodies
        self._threads = threads
        self._start_tangents = np.zeros((n, driver.tangents, 2, bodies, 6))
        if driver.directions is not None:
            self._start_tangents[:] = driver.directions.scaled[1][driver.part]
        self._stop = np.zeros(1, np.int32)
        self._memory = np.zeros((n, driver.memory))
        self._run = self._new_run(project)
        start = [
            x if x.shape[:-1] == (n, bodies) else np.broadcast_to(x, (n, bodies, x.shape[-1])) for x in (motors, twists)
        ]
        start = [np.ascontiguousarray(x) for x in start]
        state = [driver._ffi.from_buffer("double[]", x) for x in start]
        self._run_parts(
            lambda w, a, b: driver._lib.bs_dynamics_start(driver._model, driver._method, self._run, *state, w, a, b)
        )

    @classmethod
    def blank(cls, driver: Driver, times: Array) -> Run:
        """Results of a run without any state yet."""
        run = cls.__new__(cls)
        run._allocate(driver, times)
        return run

    def _allocate(self, driver: Driver, times: Array) -> None:
        self.driver, self.times = driver, np.ascontiguousarray(times, np.float64)
        n, stores, bodies = driver.size, len(times), driver.bodies
        self.motors, self.twists = np.full((n, stores, bodies, 8), np.nan), np.full((n, stores, bodies, 6), np.nan)
        self.reactions, self.violations = np.full((n, stores, bodies, 6), np.nan), np.full((n, stores), np.nan)
        self.status, self.reached = np.zeros(n, np.int32), np.full(n, self.times[0])
        self.steps, self.stored = np.zeros(n, np.int64), np.zeros(n, np.int64)
        self.start, self.start_rows = np.zeros((n, 2)), np.zeros((n, 2), np.int32)
        self.off = np.zeros((n, 2))
        self.tangents = np.full((n, stores, driver.tangents, 2, bodies, 6), np.nan)

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
        steps = STEPS_OF_FUNCTIONS if self.driver.assembly.callbacks.functions else STEPS
        bodies = self.driver.bodies
        run.budget = max(1, int(min(16, 16 * (MANY / bodies) ** 3)), steps // bodies**2)
        return run

    def advance(self, last: int) -> bool:
        """Compute some steps towards the first ``last`` states; True if more are left to compute."""
        driver, run = self.driver, self._run
        run.last = last
        self._run_parts(lambda w, a, b: driver._lib.bs_dynamics_run(driver._model, driver._method, run, w, a, b))
        return bool(((self.stored < last) & (self.status == OK)).any())

    def run_until(self, last: int) -> None:
        """Compute the first ``last`` states."""
        while self.advance(last):
            pass

    def stop(self) -> None:
        """Mark unfinished simulations as stopped."""
        self.status[(self.stored < len(self.times)) & (self.status == OK)] = STOPPED

    def _run_interruptibly(self, part: Callable[[int, int], None]) -> None:
        """Run a single simulation in another thread: an interrupt does not wait for a step of many bodies."""
        with deferred_interrupts() as tell, ThreadPoolExecutor(1, thread_name_prefix="bladesmith") as pool:
            future = pool.submit(part, 0, 1)
            try:
                while wait([future], timeout=parallel.POLL)[1]:
                    tell()
            except BaseException:
                self._stop[0] = 1
                raise
        future.result()

    def _run_parts(self, part: Callable[[Any, int, int], None]) -> None:
        """Run parts of the simulations on threads, each with a workspace."""

        def with_workspace(begin: int, end: int) -> None:
            workspace = self.driver.workspace()
            part(workspace, begin, end)
            self.driver.release(workspace)

        threads = 1 if self.driver.assembly.callbacks.functions else self._threads
        try:
            if self.driver.size == 1 and self.driver.bodies <= MANY:  # a pool would cost more than a short run
                parallel.thread_count(threads)
                with_workspace(0, 1)
            elif self.driver.size == 1 and not self.driver.assembly.callbacks.functions:
                parallel.thread_count(threads)
                self._run_interruptibly(with_workspace)
            else:
                parallel.run(with_workspace, self.driver.size, threads)
        except BaseException:
            self._stop[0] = 1
            raise
