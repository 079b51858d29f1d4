"""Batches of simulations on the workers of an executor: threads, processes, a cluster; the same bits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.executors import Task, fill_rows, ranges
from ...common.progress import Report
from . import runs
from .initial_conditions import check_start
from .problem import Problem
from .time_grid import Settings

Array = NDArray[Any]
#: Arrays of a run that workers return.
RESULTS = (
    "motors", "twists", "reactions", "violations", "status", "reached", "steps", "stored", "start", "start_rows", "off",
    "singular",
    "tangents",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class SimulationTask(Task):
    """A batch of simulations, stored at some times."""

    problem: Problem
    times: Array
    settings: Settings
    project: bool
    sensitivities: tuple[str, ...]

    def prepare(self) -> tuple[Any, ...]:
        """The task, assembled for a driver of this process, with its starts."""
        return self, self.problem.assembled(self.settings, self.project, self.sensitivities)


def run_part(state: tuple[Any, ...], begin: int, end: int) -> dict[str, Array]:
    """Run simulations begin to end - 1 of a batch."""
    task, found = state
    driver = task.problem.driver(found.assembly, found.method, slice(begin, end), found.directions)
    run = runs.Run(driver, task.times, found.motors[begin:end], found.twists[begin:end], 1, task.project)
    run.run_until(len(task.times))
    driver.raise_error()
    return {name: getattr(run, name) for name in RESULTS}


def run_on_executor(run: runs.Run, task: SimulationTask, executor: Executor, report: Report) -> None:
    """Fill a blank run with results from the workers of an executor; see `fill_run`."""
    fill_run(run, task, run_part, RESULTS, task.settings[0], executor, report)
    check_start(run, task.project)


def fill_run(
    run: runs.Run, task: Task, part: Callable[[Any, int, int], dict[str, Array]], results: Sequence[str],
    duration: float, executor: Executor, report: Report,
) -> None:  # fmt: skip
    """Fill a blank run with results from the workers of an executor.

    Parameters
    ----------
    run : runs.Run
    task : Task
    part : callable
        Runs a part of the simulations, as `run_part`.
    results : sequence of str
        Arrays that it gives.
    duration : float
    executor : concurrent.futures.Executor
    report : callable

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
    run.status[:] = runs.STOPPED

    def done(begin: int, end: int, count: int) -> None:
        report(duration * count / run.driver.size)

    arrays = {name: getattr(run, name) for name in results}
    fill_rows(executor, task, part, pieces, "simulations", arrays, done)
