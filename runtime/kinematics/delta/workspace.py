"""Workspace of a Delta robot, sampled in a box: reachable positions, and conditioning of the Jacobian there."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, ShapeError
from ...codegen.interrupts import keep_partial
from ...common import parallel
from ...common.executors import Task, fill_parts
from ...common.progress import ProgressOption, open_progress
from ...common.validation import as_int, finite_array
from ...status import Status
from . import solutions
from .geometry import DeltaGeometry
from .singularity import singularity

if TYPE_CHECKING:
    from ...plot.matplotlib_import import Figure

Array = NDArray[Any]
#: Positions along a side, at most.
MOST = 2001
#: Positions in all, at most: some 2 GB.
MOST_IN_ALL = 20_000_000
#: Positions that are evaluated at once: enough for all threads.
CHUNK = 1 << 16
#: Positions that are worth a call of an executor: some ten milliseconds of work.
POSITIONS_PER_CALL = 1 << 12


@dataclass(frozen=True, eq=False)
class WorkspaceGrid:
    """Positions of a tool sampled on a grid: coordinates along x, y, z, reachability, condition numbers."""

    x: Array
    y: Array
    z: Array
    reachable: NDArray[np.bool_]
    condition: Array


@dataclass(frozen=True, eq=False)
class Workspace:
    """Samples on a grid of positions.

    Attributes
    ----------
    robot : DeltaRobot
    x, y, z : array (nx,), (ny,), (nz,)
        Coordinates of the samples.
    reachable : bool array (nx, ny, nz)
    condition : array (nx, ny, nz)
        Condition number of the Jacobian, 1 at best; infinite at singular poses, NaN where none is.
    inverse : array (nx, ny, nz)
        The least sine of an arm, 0 where one is stretched or folded: see `Singularity.sines`.
    forward : array (nx, ny, nz)
        The volume of the unit forearms without its sign, 0 where the platform is not held: see `Singularity.volume`.
    arms : uint8 array (nx, ny, nz, 3)
        `Status` of each arm.
    """

    robot: DeltaGeometry
    x: Array
    y: Array
    z: Array
    reachable: NDArray[np.bool_]
    condition: Array
    inverse: Array
    forward: Array
    arms: NDArray[np.uint8]

    @property
    def positions(self) -> Array:
        """All samples, (nx, ny, nz, 3)."""
        return np.stack(np.meshgrid(self.x, self.y, self.z, indexing="ij"), -1)

    @property
    def volume(self) -> float:
        """Volume of the reachable part, each sample standing for a cell of the grid."""
        sides = [float(a[-1] - a[0]) / max(len(a) - 1, 1) for a in (self.x, self.y, self.z)]
        return float(self.reachable.sum()) * float(np.prod(sides))

    def well(self, condition: float) -> NDArray[np.bool_]:
        """Mask of the samples whose condition number is at most ``condition``."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.condition <= condition)

    def plot(self, path: str | PathLike[str] | None = None, **options: Any) -> Figure:
        """Draw slices: condition numbers where the platform can be; options as of `delta.plots.slices`."""
        from .plots import slices

        return slices(self, path, **options)

    def __repr__(self) -> str:
        fraction = float(self.reachable.mean()) if self.reachable.size else 0.0
        return f"<Workspace of {self.robot!r}: {' x '.join(map(str, self.reachable.shape))}, {fraction:.1%} reached>"


def workspace(
    robot: DeltaGeometry, bounds: Any, points: Any, elbow: Any, threads: int | None, progress: ProgressOption,
    executor: Executor | None,
) -> Workspace:  # fmt: skip
    """Sample a box: see `DeltaRobot.workspace`."""
    x, y, z = axes = _axes(robot, bounds, _counts(points))
    positions = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    n, shape = len(positions), tuple(map(len, axes))
    arrays: dict[str, Array] = {
        "reachable": np.zeros(n, bool), **{name: np.full(n, np.nan) for name in ("condition", "inverse", "forward")},
        "arms": np.full((n, 3), Status.INVALID, np.uint8),
    }  # fmt: skip
    count = parallel.thread_count(threads)
    task = _WorkspaceTask(robot, solutions.elbow_signs(elbow), count if executor is None else 1)

    def samples() -> Workspace:
        return Workspace(robot, x, y, z, **{name: a.reshape(shape + a.shape[1:]) for name, a in arrays.items()})

    with open_progress(progress, "workspace", "positions", n) as report, keep_partial(samples):
        grain = CHUNK if executor is None else POSITIONS_PER_CALL
        fill_parts(executor, task, _sample, (positions,), "positions", arrays, report, grain)
    return samples()


@dataclass(frozen=True, eq=False)
class _WorkspaceTask(Task):
    """A robot and the postures of its arms."""

    robot: DeltaGeometry
    elbows: Array
    threads: int

    def prepare(self) -> _WorkspaceTask:
        return self


def _sample(task: _WorkspaceTask, positions: Array) -> dict[str, Array]:
    """Samples at positions (n, 3)."""
    robot, elbows = task.robot, task.elbows
    operands = [positions, robot.parameters, elbows]
    jacobian, codes = solutions.jacobians("delta_rates.inverse_jacobian", operands, task.threads)
    measures = singularity(robot, solutions.inverse(robot, positions, elbows, threads=task.threads)[0], positions)
    reachable = (codes == Status.OK) | (codes == Status.SINGULAR)
    regular = codes == Status.OK
    condition = np.where(reachable, np.inf, np.nan)
    condition[regular] = np.linalg.cond(jacobian[regular]) if regular.any() else 0.0
    return {
        "reachable": reachable, "condition": condition, "inverse": np.abs(measures.sines).min(-1),
        "forward": np.abs(measures.volume), "arms": solutions.arm_codes(robot, positions, elbows),
    }  # fmt: skip


def _axes(robot: DeltaGeometry, bounds: Any, counts: tuple[int, int, int]) -> list[Array]:
    low, high = _box(robot, bounds)
    return [
        np.linspace(a, b, n) if n > 1 else np.array([(a + b) / 2]) for a, b, n in zip(low, high, counts, strict=True)
    ]


def _counts(points: Any) -> tuple[int, int, int]:
    counts = [points] * 3 if np.ndim(points) == 0 else list(points)
    if len(counts) != 3:
        raise ShapeError(f"points has {len(counts)} entries; one, or one for each of the three sides, is meant.")
    x, y, z = (as_int(n, "points", 1, MOST) for n in counts)
    if x * y * z > MOST_IN_ALL:
        raise InputError(
            f"points is {points!r}; a box has at most {MOST_IN_ALL}.", remedy="Take fewer, or parts of the box"
        )
    return x, y, z


def _box(robot: DeltaGeometry, bounds: Any) -> tuple[Array, Array]:
    if bounds is None:
        arm = robot.upper_arm + robot.forearm
        side = max(arm - abs(robot.base_radius - robot.effector_radius), 0.0)
        return np.array([-side, -side, 0.0]), np.array([side, side, arm])
    box = finite_array(bounds, "bounds", (3, 2))
    if (box[:, 0] > box[:, 1]).any():
        raise InputError("bounds are not a box: each row is a least and a greatest coordinate.")
    return box[:, 0], box[:, 1]


__all__ = ["Workspace", "workspace"]
