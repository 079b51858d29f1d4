"""The compiled motion of trees: simulations in the coordinates of joints, step by step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.dynamics.records import Control, Progress, Reached
from ...codegen.algorithms.trees.motion_records import KeptMotion, LinkWork, Options, RowWork, Settings
from ...codegen.algorithms.trees.stage_systems import numbers_of_stages
from ...codegen.programs.chains import identity_rotor
from ...common.memory import filled
from ..assembly.data import Assembly
from ..integration.driver import STEPS
from ..integration.integrators import Method
from ..integration.program import tree_loops
from ..integration.runs import Run
from .parameters import TreeParameters
from .spanning_tree import SpanningTree

Array = NDArray[Any]
#: Bodies beyond which a single simulation runs in another thread, for interrupts.
MANY = 50


class TreeDriver:
    """A tree and a method, ready to run.

    Attributes
    ----------
    size, bodies : int
        Simulations, and bodies of each.
    memory : int
        Numbers that a simulation keeps.
    budget : int
        Steps of a simulation between two checks of interrupts and progress.
    """

    tangents = equations = workspace_bytes = 0

    def __init__(
        self, tree: SpanningTree, assembly: Assembly, parameters: TreeParameters, method: Method, target: str
    ) -> None:
        self.tree, self.assembly, self.parameters, self.method = tree, assembly, parameters, method
        self.is_implicit = method.driver == "implicit"
        self.loops, self.is_on_gpu = tree_loops(assembly.algebra.name, target, self.is_implicit)
        self.size, self.bodies, n = len(parameters.start), len(assembly.bodies), tree.count
        scheme = method.scheme
        # tangents of the work are behind it
        self.copies = 2 if self.is_implicit else 1
        self.stage_numbers = numbers_of_stages(scheme.stages, 2 * n) if self.is_implicit else 2 * n * scheme.kept_rows
        work = n * LinkWork.size + 6 * self.bodies + 2 * len(parameters.rows) ** 2
        self.memory = self.stage_numbers + self.copies * work + 8 * n
        # derivatives by all freedoms take a step of all bodies each, for some stages
        self.budget = max(1, STEPS // max(1, 16 * n * n if self.is_implicit else n))
        self.settings, self.options = Settings.zeros(), Options.zeros()
        self.settings.rtol, self.settings.atol = method.rtol, method.atol
        self.settings.longest_step, self.settings.length = method.step, parameters.length
        for name, value in parameters.options.items():
            setattr(self.options, name, value)
        self.options.adapts = int(method.driver in ("adaptive", "implicit"))
        for name in ("stages", "all_stages", "dense_rows"):
            setattr(self.options, name, getattr(scheme, name))
        self.options.method_order = scheme.order

    def own_memory(self) -> dict[str, Array]:
        """What each simulation changes, at the start."""
        n, size, balls = self.tree.count, self.size, int((self.tree.balls >= 0).sum())
        rows, copies = len(self.parameters.rows), self.copies
        references = np.tile(identity_rotor(self.assembly.algebra.name), (size, max(1, balls), 1))
        arrays = {name: np.zeros((size, 2 * n)) for name in ("x", "end", "fresh")}
        return {
            **arrays, "state": self.parameters.start.copy(), "references": references.reshape(size, -1),
            "old_references": references.reshape(size, -1).copy(), "stages": np.zeros((size, self.stage_numbers)),
            "work": np.zeros((size, copies * n, LinkWork.size)), "acting": np.zeros((size, copies * self.bodies, 6)),
            "kept": np.zeros((size, KeptMotion.size)), "row_work": np.zeros((size, copies * rows, RowWork.size)),
            "matrix": np.zeros((size, copies * 2 * rows * rows)),
        }  # fmt: skip

    def shared(self) -> dict[str, Array]:
        """What all simulations share."""
        rows = {"settings": self.settings, "options": self.options}
        return {
            **self.parameters.shared, **{name: np.asarray(row) for name, row in rows.items()},
            "rows": self.parameters.rows, "scheme": self.method.numbers,
        }  # fmt: skip


class TreeRun(Run):
    """States of trees at times, computed step by step: see `integration.runs.Run`.

    Attributes
    ----------
    coordinates : array (simulations, stores, 2, n)
        Coordinates of all freedoms and their speeds; those of balls are not told by these alone.
    """

    driver: Any

    def __init__(self, driver: TreeDriver, times: Array, threads: int | None = 1) -> None:
        self._allocate_states(driver, times)
        self._threads = threads
        self._control = np.zeros(Control.size, np.int64)
        self._control[Control.offsets["budget"]] = driver.budget
        size, n = driver.size, driver.tree.count
        stored = {
            "motors": self.motors.reshape(size, -1, 8), "twists": self.twists.reshape(size, -1, 6),
            "reactions": self.reactions.reshape(size, -1, 6), "coordinates": self.coordinates.reshape(size, -1),
            "violations": self.violations,
        }  # fmt: skip
        each = {
            **driver.parameters.each, **driver.own_memory(), **stored, "progress": self._progress,
            "reached": self._reached,
        }  # fmt: skip
        shared = {**driver.shared(), "control": self._control, "times": self.times}
        self._bound = driver.loops["run"].over(size, each, shared)
        self._arrays = each, shared, n  # alive while the loop runs
        self._run_parts()

    @classmethod
    def blank(cls, driver: Any, times: Array) -> TreeRun:
        """Results of a run without any state yet."""
        run = cls.__new__(cls)
        run._allocate_states(driver, times)
        return run

    def _allocate_states(self, driver: TreeDriver, times: Array) -> None:
        self.driver, self.times = driver, np.ascontiguousarray(times, np.float64)
        shape = driver.size, len(times)
        self.motors, self.twists, self.reactions = (
            filled((*shape, driver.bodies, k), np.nan) for k in (8, 6, 6)
        )
        self.coordinates = filled((*shape, 2, driver.tree.count), np.nan)
        self.violations = np.zeros(shape)
        self._progress = np.zeros((shape[0], Progress.size), np.int64)
        self._reached = np.zeros((shape[0], Reached.size))
        self._layouts = (Progress, self._progress), (Reached, self._reached)
        self.number[:] = np.arange(shape[0])
        self.reached[:] = self.times[0]
        self.tangents = np.zeros((*shape, 0, 2, driver.bodies, 6))

    def _run_parts(self) -> None:
        self._split(self._bound.run, self.driver.is_on_gpu, self.driver.tree.count > MANY, False)

    def of_joint(self, index: int, which: int) -> Array | None:
        """Coordinates (0) or speeds (1) (simulations, stores, k) of a joint; None where they are not coordinates."""
        joint = self.driver.tree.of_joint(index)
        if joint is None or joint.freedoms.is_ball:
            return None
        values: Array = self.coordinates[:, :, which, joint.first : joint.first + len(joint.freedoms.axes)]
        return values[..., ::-1] if joint.is_reversed else values
