"""Batches of trees on the workers of an executor: the same bits."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from ...common.executors import Task
from ...common.progress import Report
from ...mechanics.system import System
from ..integration.executor import fill_run
from ..integration.time_grid import Settings
from .driver import TreeRun
from .problem import TreeProblem, tree_problem

Array = NDArray[Any]
#: Arrays of a run that workers return.
RESULTS = (
    "motors", "twists", "reactions", "coordinates", "violations", "status", "reached", "steps", "stored", "singular",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class TreeTask(Task):
    """A batch of trees, stored at some times: what `tree_problem` makes a problem of."""

    system: System
    loads: tuple[Any, ...]
    integrator: str
    target: str
    times: Array
    settings: Settings

    def prepare(self) -> tuple[Any, ...]:
        """The task, and its problem in this process."""
        return self, tree_problem(self.system, self.loads, self.integrator, self.target)


def run_part(state: tuple[Any, ...], begin: int, end: int) -> dict[str, Array]:
    """Run simulations begin to end - 1 of a batch."""
    task, problem = state
    assert isinstance(problem, TreeProblem)
    run = TreeRun(problem.part(begin, end).driver(task.settings), task.times, 1)
    run.run_until(len(task.times))
    return {name: getattr(run, name) for name in RESULTS}


def run_on_executor(run: TreeRun, task: TreeTask, executor: Executor, report: Report) -> None:
    """Fill a blank run; see `fill_run`."""
    fill_run(run, task, run_part, RESULTS, task.settings[0], executor, report)
