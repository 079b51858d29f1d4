"""The compiled dynamics driver: an assembly and a method, ready to run, and the work of each thread."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.dynamics.records import FINE, Constraint
from ...codegen.execute.in_place import InPlace, Kept
from ..assembly.data import Assembly
from .integrators import Method
from .program import program_for

if TYPE_CHECKING:
    from ..sensitivity.parameters import Directions

Array = NDArray[Any]
#: Steps of a simulation between two checks of interrupts and progress.
STEPS = 16384
#: The same if it calls users' functions.
STEPS_OF_FUNCTIONS = 256
#: As `FINE`, for a first projection: far off the constraints, redundant equations differ by the error of the pose.
COARSE = 1e-3
#: Bodies beyond which there are fewer steps between two checks: the work of a step grows as their cube.
MANY = 50
#: Largest workspace, in bytes, that is reused by the next call.
REUSED_WORKSPACE = 1 << 22
#: Simulations from which on several run at once, in a program that is compiled for that; and numbers of each up to
#: which they do: a thread's stack holds those of eight, and so must a core's second cache.
WIDE_BATCH, WIDE_NUMBERS = 64, 13000
#: An argument that a program does not look at.
_NOTHING = np.zeros((1, 1))
#: A stop that never comes.
_NEVER = np.zeros(1, np.int64)


def aligned_zeros(size: int) -> Array:
    """Zeros that begin where a wide vector may."""
    found = np.zeros(size + 3)
    return found[-(found.ctypes.data // 8) % 4 :][:size]


class Workspace:
    """What a thread brings along: numbers and integers of its work, and arguments of runs that work on them."""

    def __init__(self, w: Array, p: Array, kept: dict[str, Kept]) -> None:
        self.w, self.p, self._kept = w, p, kept
        self._runs: dict[InPlace, InPlace] = {}

    def holding(self, run: InPlace) -> InPlace:
        """An algorithm of runs on what this thread brings along."""
        found = self._runs.get(run)
        if found is None:
            found = self._runs[run] = run.holding(self._kept)
        return found


class Driver:
    """An assembly and a method, ready to run.

    Attributes
    ----------
    size, bodies, tangents, equations : int
        Simulations; bodies, directions of sensitivities and equations of constraints of each.
    memory : int
        Numbers that a simulation keeps.
    workspace_bytes : int
        Of what each thread brings along.
    budget : int
        Steps of a simulation between two checks of interrupts and progress.
    """

    def __init__(
        self, assembly: Assembly, method: Method, chart: str, project: bool, baumgarte: float,
        part: slice = slice(None), directions: Directions | None = None, target: str = "c",
    ) -> None:  # fmt: skip
        self.assembly, self.method, self.part, self.directions = assembly, method, part, directions
        self.tangents = 0 if directions is None else directions.count
        functions = len(assembly.callbacks.functions) if self.tangents or method.driver == "implicit" else 0
        needs = replace(assembly.needs(method.driver, chart), tangents=self.tangents, functions=functions)
        self.program = program_for(needs, target)
        self.size, self.bodies = len(range(assembly.size)[part]), len(assembly.bodies)
        self.equations = assembly.equation_count
        self.state = 12 * self.bodies * (1 + self.program.needs.columns)  # numbers of a state of a chart
        self.stage_rows = method.scheme.kept_rows if method.driver in ("chart", "adaptive", "implicit") else 0
        self.memory = self.program.kept.size + self.stage_rows * self.state
        self.workspace_bytes = self.program.workspace_bytes
        self.reuses_workspaces = self.workspace_bytes <= REUSED_WORKSPACE
        self.budget = self._budget()
        self._numbers = assembly.parameters[part]
        self._workspaces: list[Workspace] = []
        self._handle, self._functions = self.program.hold_functions(assembly.callbacks)
        self._constants = self._new_constants(project, baumgarte)
        self._kept = self._new_kept()

    def _budget(self) -> int:
        steps = STEPS_OF_FUNCTIONS if self.assembly.callbacks.functions else STEPS
        return max(1, int(min(16, 16 * (MANY / self.bodies) ** 3)), steps // self.bodies**2)

    def _new_constants(self, project: bool, baumgarte: float) -> tuple[dict[str, float], dict[str, Any]]:
        """What the work of each thread says about all simulations, by field."""
        assembly, method, scheme = self.assembly, self.method, self.method.scheme
        numbers = {
            "baumgarte": baumgarte, "longest_step": method.step, "rtol": method.rtol,
            "atol": method.atol,
        }  # fmt: skip
        integers: dict[str, Any] = {
            "project": int(project), "handle": self._handle, "stride": self._numbers.shape[1],
            "spring_offset": assembly.spring_offset, "springs": len(assembly.springs),
            "couplings": len(assembly.couplings),
            "constraints": len(assembly.driver_constraints), "loads": len(assembly.user_loads),
            "stages": scheme.stages, "all_stages": scheme.all_stages, "dense_rows": scheme.dense_rows,
            "method_order": scheme.order,
        }  # fmt: skip
        rows = [(c.body, int(c.power)) for c in assembly.driver_constraints for _ in range(c.equations)]
        if rows:
            integers["bodies"], integers["powers"] = np.transpose(rows)
        return numbers, integers

    def arrays(self) -> tuple[dict[str, Array], dict[str, Array]]:
        """Arrays that the simulations of all runs share, and those of which each has its own."""
        assembly = self.assembly
        constraints = Constraint.zeros(max(1, len(assembly.driver_constraints)))
        for row, packed in zip(constraints, assembly.driver_constraints, strict=False):
            row.layout = -1 if packed.power else assembly.layouts.index(packed.layout)
            row.body, row.other, row.rows, row.user = packed.body, packed.other, packed.equations, packed.callback
            row.v, row.h, row.a = packed.object_offset, packed.target_offset, packed.matrix_offset
            row.unknown = packed.error_offset
        shared = {
            "springs": np.array([*assembly.springs, *assembly.couplings] or [(0, 0)], np.int64),
            "user_loads": np.array(assembly.user_loads or [(0, False, 0)], np.int64),
            "constraints": np.asarray(constraints), "scheme": self.method.numbers,
        }  # fmt: skip
        own = {"numbers": self._numbers, "bodies": self._numbers}
        if self.directions is not None:
            own["directions"] = self._new_directions(self.directions.scaled[0][self.part])
        return shared, own

    def _new_directions(self, directions: Array) -> Array:
        """Directions one after the other; behind them, if several are computed at once, in groups side by side."""
        needs = self.program.needs
        n, count, stride = directions.shape
        if needs.lanes == 1:
            return np.ascontiguousarray(directions)
        both = aligned_zeros(2 * n * needs.columns * stride).reshape(n, 2, needs.columns, stride)
        both[:, 0, :count] = directions
        groups = both[:, 0].reshape(n, -1, needs.lanes, stride)
        both[:, 1] = groups.swapaxes(2, 3).reshape(n, needs.columns, stride)
        return both.reshape(n, 2 * needs.columns, stride)

    def _new_kept(self) -> dict[str, Kept]:
        """Arguments of all runs."""
        keep, (shared, own) = self.program.keep, self.arrays()
        nothing = [] if self.stage_rows else ["stages"]
        if self.directions is None:
            nothing += ["directions", "tangents"]
        owned = keep(own, self.size)
        owned["bodies"] = owned["bodies"]._replace(rows=self.bodies)  # a row begins with them
        return {**keep(dict.fromkeys(nothing, _NOTHING)), **keep(shared), **owned}

    def run_for(self, states: int) -> InPlace:
        """The algorithm of runs for so many numbers of states of each simulation."""
        program = self.program
        wide = program.wide if self.size >= WIDE_BATCH else None
        if wide is None or states + wide.numbers + self.memory + 2 * self._numbers.shape[1] > WIDE_NUMBERS:
            return program["run"]
        return program.wide_run

    def workspace(self) -> Workspace:
        """Work of one thread, to be returned by `release`."""
        try:
            return self._workspaces.pop()
        except IndexError:
            program = self.program
            whole = aligned_zeros(self.workspace_bytes // 8)  # vectors of series do not cross lines of the cache
            w, p = whole[: program.work.size], whole[program.work.size :].view(np.int64)[: program.integers.size]
            numbers, integers = self._constants
            for name, value in numbers.items():
                w[program.work.offsets[name]] = value
            for name, value in integers.items():
                first = program.integers.offsets[name]
                p[first : first + np.size(value)] = value
            own = {"w": w, "p": p}
            if program.is_on_gpu:
                kept = program.keep({name: np.tile(array, (self.size, 1)) for name, array in own.items()}, self.size)
            else:
                kept = program.keep(own)
            return Workspace(w, p, {**self._kept, **kept})

    def release(self, workspace: Workspace) -> None:
        """Keep work for the next call, unless it is large: a finished simulation does not hold memory."""
        if self.reuses_workspaces:
            self._workspaces.append(workspace)

    def _call(self, name: str, item: int, **arguments: Any) -> Any:
        """Run an algorithm on a state of one simulation, and return what it returns."""
        workspace, numbers = self.workspace(), self._numbers[item]
        own = {"numbers": numbers, "bodies": numbers, "w": workspace.w, "p": workspace.p, "stop": _NEVER}
        result = self.program[name]({**self._kept, **own, **arguments})
        self.release(workspace)
        self.raise_error()
        return result

    def evaluate(self, t: float, motors: Array, twists: Array, item: int = 0) -> dict[str, Any]:
        """Evaluate the dynamics of a simulation at one state, motors (bodies, 8) and twists (bodies, 6).

        Returns
        -------
        dict
            Accelerations and reactions; matrix, right sides, errors, rates and rank of the constraints.
        """
        rows = max(1, self.program.needs.rows)
        size = 6 * self.bodies
        values = {
            "accelerations": np.empty((self.bodies, 6)), "reactions": np.empty((self.bodies, 6)),
            "matrix": np.zeros((rows, size)), "right": np.zeros(rows), "errors": np.zeros(rows),
            "rates": np.zeros(rows),
        }  # fmt: skip
        state = {"motors": np.ascontiguousarray(motors, np.float64), "twists": np.ascontiguousarray(twists, np.float64)}
        rank = self._call("evaluate", item, t=t, **state, **values)
        return {**values, "rank": rank}

    def project(self, t: float, motors: Array, twists: Array) -> tuple[Array, Array]:
        """Nearest state of the first simulation that obeys the constraints."""
        projected = {"motors": np.array(motors, np.float64), "twists": np.array(twists, np.float64)}
        for tolerance in (COARSE, FINE) if self.assembly.mode == "constrained" else ():
            self._call("project", 0, t=t, tolerance=tolerance, **projected)
        return projected["motors"], projected["twists"]

    def raise_error(self) -> None:
        """Raise the error of a user's function."""
        error, self.assembly.callbacks.error = self.assembly.callbacks.error, None
        if error is not None:
            raise error
