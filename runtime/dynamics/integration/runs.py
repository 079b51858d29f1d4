"""States of simulations at times, computed step by step by a driver, over threads."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.dynamics.records import Code, Control, Progress, Reached, state_record
from ...codegen.execute.in_place import Bound
from ...codegen.ir.loops.records import Record
from ...common import parallel
from ...common.memory import filled
from .driver import MANY, Driver, Workspace

Array = NDArray[Any]
#: Status of a simulation.
OK, NOT_FINITE, UNDERFLOW, RANK_CHANGED, USER_FAILED, STOPPED, EVENT, NOT_SOLVED, VIOLATED, _, STALLED, MEETING = (
    int(code) for code in Code
)
#: Where fields of `Control` are.
_STOP, _LAST, _BUDGET, _PROJECTS = (Control.offsets[name] for name in ("stop", "last", "budget", "projects"))
#: Fields of states that bodies have, and their numbers of each.
_OF_BODIES = {"motors": 8, "twists": 6, "reactions": 6}
#: Tangents in no direction.
_NONE = np.zeros(0)


@cache
def _places(record: Record) -> dict[str, Any]:
    """Where the fields are in rows of a record."""
    found = {}
    for name in record.offsets:
        first, count = record.extent(name)
        found[name] = slice(first, first + count) if record.shapes[name] else first
    return found


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
    event_tangents : array (directions,)
        Tangents of the time of the event that ended a single simulation.
    start, start_rows : array (simulations, 2)
        Largest errors of poses and of rates at the start, as fractions of their terms, and the rows.
    off : array (simulations, 2)
        Error of the constraints that remains after projection of the last state, and its row.
    singular : array (simulations, 2)
        Least fraction of a constraint that was independent of the others at the end of a step, and when.
    """

    motors: Array
    twists: Array
    reactions: Array
    violations: Array
    number: Array
    status: Array
    reached: Array
    steps: Array
    stored: Array
    start: Array
    start_rows: Array
    off: Array
    singular: Array
    #: Rows of states, progress and what was reached, by their records.
    _layouts: tuple[tuple[Record, Array], ...]

    def __init__(
        self, driver: Driver, times: Array, motors: Array, twists: Array, threads: int | None = 1,
        project: bool = False, tangents: Array | None = None,
    ) -> None:  # fmt: skip
        self._allocate(driver, times)
        n, program = driver.size, driver.program
        self._threads = threads
        self._control = np.zeros(Control.size, np.int64)
        self._control[_PROJECTS], self._control[_BUDGET] = project, driver.budget
        kept = np.zeros((n, program.kept.size))
        start = {"motors": (motors, 8 * driver.bodies), "twists": (twists, 6 * driver.bodies)}
        if driver.directions is not None:
            given = driver.directions.scaled[1][driver.part] if tangents is None else tangents
            start["tangents"] = given, 12 * driver.bodies * driver.tangents
        for name, (values, size) in start.items():
            at = program.kept.offsets[name]
            kept[:, at : at + size] = values.reshape(-1, size)
        self._each = {"kept": kept, "progress": self._progress, "reached": self._reached, "states": self._states}
        if driver.stage_rows:
            self._each["stages"] = np.zeros((n, driver.stage_rows, driver.state))
        if driver.directions is not None:
            self._each["tangents"] = self.tangents
        self._bounds: dict[Workspace, Bound] = {}
        if project or driver.assembly.driver_constraints:  # nothing else is asked about the start
            self._run_parts()

    @classmethod
    def blank(cls, driver: Driver, times: Array) -> Run:
        """Results of a run without any state yet."""
        run = cls.__new__(cls)
        run._allocate(driver, times)
        return run

    def _allocate(self, driver: Driver, times: Array) -> None:
        self.driver, self.times = driver, np.ascontiguousarray(times, np.float64)
        n, stores, bodies, record = driver.size, len(times), driver.bodies, state_record(driver.bodies)
        self._states = filled((n, stores, record.size), np.nan)
        self._progress, self._reached = np.zeros((n, Progress.size), np.int64), np.zeros((n, Reached.size))
        self._layouts = (Progress, self._progress), (Reached, self._reached), (record, self._states)
        if n > 1:
            self.number[:] = np.arange(n)
        self.reached[:] = self.times[0]
        if driver.directions is None:
            self.tangents, self.event_tangents = np.zeros((n, stores, 0, 2, bodies, 6)), _NONE
        else:
            self.tangents = filled((n, stores, driver.tangents, 2, bodies, 6), np.nan)
            self.event_tangents = np.zeros(driver.tangents)

    def __getattr__(self, name: str) -> Array:
        """A field of rows, which becomes an attribute when it is first looked at: of a short run few are."""
        for layout, rows in self.__dict__.get("_layouts", ()):
            places = _places(layout).get(name)
            if places is not None:
                found: Array = rows[..., places]
                if name in _OF_BODIES:
                    found = found.reshape(*rows.shape[:2], -1, _OF_BODIES[name])
                setattr(self, name, found)
                return found
        raise AttributeError(name)

    @property
    def time_reached(self) -> float:
        """The time that all simulations have reached."""
        return float(self.reached.item(0) if self.driver.size == 1 else self.reached.min())

    def advance(self, last: int) -> bool:
        """Compute some steps towards the first ``last`` states; True if more are left to compute."""
        self._control[_LAST] = last
        self._run_parts()
        if self.driver.size == 1:
            return bool(self.stored.item(0) < last and self.status.item(0) == OK)
        return bool(((self.stored < last) & (self.status == OK)).any())

    def run_until(self, last: int) -> None:
        """Compute the first ``last`` states."""
        while self.advance(last):
            pass

    def stop(self) -> None:
        """Mark unfinished simulations as stopped."""
        self.status[(self.stored < len(self.times)) & (self.status == OK)] = STOPPED

    def _request_stop(self) -> None:
        self._control[_STOP] = 1

    def _bind(self, workspace: Workspace) -> Bound:
        shared = {"control": self._control, "times": self.times}
        run = self.driver.run_for(self._states[0].size)
        return workspace.holding(run).over(self.driver.size, self._each, shared)

    def hold(self) -> Callable[[int, int], None]:
        """The compiled loop towards all states, with a workspace that nobody else has from now on."""
        self._control[_LAST] = len(self.times)
        return self._bind(self.driver.workspace()).run

    def rows(self, name: str) -> Array:
        """What the compiled loop works on: "kept", "progress", "reached" or "states", a row for each simulation."""
        found: Array = self._each[name]
        return found

    def copied(self) -> Run:
        """The states as they are now."""
        other = type(self).blank(self.driver, self.times.copy())
        for (_, own), (_, rows) in zip(other._layouts, self._layouts, strict=True):
            own[...] = rows
        return other

    def _run_parts(self) -> None:
        """Run parts of the simulations on threads, each with a workspace."""
        driver = self.driver

        def with_workspace(begin: int, end: int) -> None:
            workspace = driver.workspace()
            bound = self._bounds.get(workspace)
            if bound is None:
                bound = self._bind(workspace)
                if driver.reuses_workspaces:
                    self._bounds[workspace] = bound
            bound.run(begin, end)
            driver.release(workspace)

        has_functions = bool(driver.assembly.callbacks.functions)
        self._split(with_workspace, driver.program.is_on_gpu, driver.bodies > MANY and not has_functions, has_functions)

    def _split(self, part: Callable[[int, int], None], is_whole: bool, is_long: bool, is_serial: bool) -> None:
        """Run parts of the simulations on threads.

        Parameters
        ----------
        part : callable
        is_whole : bool
            Whether it takes all simulations at once, as a GPU does.
        is_long : bool
            Whether a step of one simulation takes so long that an interrupt shall not wait for it.
        is_serial : bool
            Whether it is to run in one thread.
        """
        size, threads = self.driver.size, 1 if is_serial else self._threads
        try:
            if is_whole or (size == 1 and not is_long):  # a pool would cost more than a short run
                if threads is not None:
                    parallel.thread_count(threads)
                part(0, size)
            else:
                waits = not is_serial and (is_long or parallel.thread_count(threads) > 1)
                parallel.run(part, size, threads, stop=self._request_stop if waits else None)
        except BaseException:
            self._request_stop()
            raise
