"""Batches of simulations on the workers of an executor: threads, processes, a cluster; the same bits."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.executors import Task, fill_rows, ranges
from ...common.progress import Report
from . import driver as engine
from .initial_conditions import check_start
from .problem import Problem
from .time_grid import Settings

Array = NDArray[Any]
#: Arrays of a run that workers return.
RESULTS = (
    "motors", "twists", "reactions", "violations", "status", "reached", "steps", "stored", "start", "start_rows", "off",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class SimulationTask(Task):
    """A batch of simulations, stored at some times."""

    problem: Problem
    times: Array
    settings: Settings
    project: bool

    def prepare(self) -> tuple[Any, ...]:
        """The task, assembled for a driver of this process, with its starts."""
        assembly, method = self.problem.prepare(self.settings)
        return self, assembly, method, *self.problem.start(assembly, self.settings[0], self.project)


def run_part(state: tuple[Any, ...], begin: int, end: int) -> dict[str, Array]:
    """Run simulations begin to end - 1 of a batch."""
    task, assembly, method, motors, twists = state
    driver = task.problem.driver(assembly, method, slice(begin, end))
    run = engine.Run(driver, task.times, motors[begin:end], twists[begin:end], 1, task.project)
    run.run_until(len(task.times))
    driver.raise_error()
    return {name: getattr(run, name) for name in RESULTS}


def run_on_executor(run: engine.Run, task: SimulationTask, executor: Executor, report: Report) -> None:
    """Fill a blank run with results from the workers of an executor.

    Raises
    ------
    InputError
        If the simulation cannot be sent, or the executor takes no work.
    ExecutorError
        If workers fail or end.
    """
    if run.driver.assembly.callbacks.functions:
        raise InputError("functions of time or state stay in this process; run without an executor.")
    pieces = {part: part for part in ranges(executor, run.driver.size)}
    run.status[:] = engine.STOPPED

    def done(begin: int, end: int, count: int) -> None:
        report(task.settings[0] * count / run.driver.size)

    arrays = {name: getattr(run, name) for name in RESULTS}
    fill_rows(executor, task, run_part, pieces, "simulations", arrays, done)
    check_start(run, task.project)
