"""Worker side of a registration on an executor: evaluation of hypotheses and stages of a scene, on cached models."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

from numpy.typing import NDArray

from ...codegen.programs.registration.registration import in_order
from ...common.executors import Task
from ..search.hypotheses import HypothesisGenerator, TableSelection
from .algorithms import program_of
from .driver import Driver
from .model_rows import MatchCriterion, ModelData
from .scene import Scene

Array = NDArray[Any]
#: Name of the stage of `HypothesisGenerator`; other stages are those of scenes.
EVALUATE = "evaluate"


@dataclass(frozen=True, eq=False)
class RegistrationTask(Task):
    """Serializable registration task: two models as arrays, and the selection of objects.

    Attributes
    ----------
    backend : str
    threads : int
        Threads of each worker.
    query, reference : ModelData
    kinds, rows : int32 arrays (n,)
        Selected query objects.
    selection : TableSelection, optional
        Reference objects in tables, for a search.
    """

    backend: str
    threads: int
    query: ModelData
    reference: ModelData
    kinds: Array
    rows: Array
    selection: TableSelection | None = None
    #: Scenes have a state, which threads do not share.
    per_thread: ClassVar[bool] = True

    def prepare(self) -> CachedTask:
        """Scene of the models on this machine."""
        return CachedTask(self)

    def source(self) -> str:
        """Text of the formulas of an installation."""
        return program_of(in_order(self.query.rows)).source


class CachedTask:
    """A task with its scene and its generator of hypotheses."""

    def __init__(self, task: RegistrationTask) -> None:
        self._task = task
        self.scene = Scene(task.query, task.reference, task.kinds, task.rows, task.threads, task.backend)

    @cached_property
    def hypotheses(self) -> HypothesisGenerator:
        """Generator of hypotheses for a search."""
        task = self._task
        assert task.selection is not None
        driver = Driver(tuple(task.query.rows), task.threads, task.backend)
        return HypothesisGenerator(self.scene, driver, task.query.rows, task.reference.rows, task.selection)


def run_stage(cached: CachedTask, criterion: MatchCriterion, stage: str, arguments: tuple[Any, ...]) -> Any:
    """Run a stage of a scene on some of its items, or evaluate batches."""
    cached.scene.set_criterion(criterion)
    return getattr(cached.hypotheses if stage == EVALUATE else cached.scene, stage)(*arguments)
