"""Tasks of a mechanism file: the pose, the report, the motion along a path, slices of the workspace."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError, SingularError, suggest
from ...codegen.interrupts import keep_partial
from ...common import parallel
from ...common.deprecation import renamed_attribute, renamed_keywords
from ...common.executors import Task, fill_parts
from ...common.progress import ProgressOption, open_progress
from ...core.multivector import Multivector
from ...mechanics.units import Units
from ...status import Status
from ..delta.workspace import Workspace, WorkspaceGrid
from .joint_trajectory import Motion
from .mechanism_model import MechanismModel
from .report import AnyModel, Report, build_report
from .robot_model import ChainModel, DeltaModel, PoseBatch
from .tool_path import ToolPath

if TYPE_CHECKING:
    from ...plot.matplotlib_import import Axes3D, Figure

Array = NDArray[Any]
#: Samples along a side of the workspace of a Delta robot.
SAMPLES = 41
#: Samples along a side of the workspace of other robots.
FEW = 31
#: Slices of the workspace of other robots.
SLICES = 7
#: Positions of a workspace that are evaluated at once.
CHUNK = 500
#: Poses that are drawn of a path, at most.
MOST_POSES = 24


@dataclass(frozen=True)
class PoseQuery:
    """Requested pose: coordinates of inputs by name; position of the tool, and rotation from its orientation there."""

    joints: dict[str, float] = field(default_factory=dict)
    position: ArrayLike | None = None
    rotor: Multivector | None = None


@dataclass(frozen=True)
class WorkspaceQuery:
    """Requested workspace: see `DeltaRobot.workspace` and `delta.plots.slices`."""

    bounds: ArrayLike | None = None
    samples: int | Sequence[int] | None = None
    show: str = "condition"
    across: str = "z"
    at: Sequence[float] | None = None


@dataclass(frozen=True)
class ViewOptions:
    """Options of pictures; angles in degrees."""

    title: str = ""
    view: tuple[float, float] | None = None
    poses: int = 1
    legend: bool = True


@renamed_keywords(stand="pose_query", way="tool_path")
@dataclass(frozen=True, eq=False)
class Setup:
    """A mechanism file, or a robot's, with its tasks.

    Attributes
    ----------
    model : DeltaModel, ChainModel or MechanismModel
    pose_query : PoseQuery
    box : WorkspaceQuery, optional
    tool_path : ToolPath, optional
    look : ViewOptions
    units : Units
    name : str
        Name of the file.
    """

    model: AnyModel
    pose_query: PoseQuery = PoseQuery()
    box: WorkspaceQuery | None = None
    tool_path: ToolPath | None = None
    look: ViewOptions = ViewOptions()
    units: Units = Units()
    name: str = ""

    # -- the pose ----------------------------------------------------------------------------------------------

    def home(self) -> Array:
        """Coordinates of the inputs: those of the file, or default ones."""
        values = self.model.home.copy()
        for name, value in self.pose_query.joints.items():
            if name not in self.model.inputs:
                known = ", ".join(self.model.inputs) or "none"
                raise InputError(
                    f"{name!r} is not an actuated joint{suggest(name, self.model.inputs)}; there are: {known}.",
                    where=self.name,
                )
            values[self.model.inputs.index(name)] = value
        return values

    def solve_pose(self) -> PoseBatch:
        """The pose, as a batch of one item.

        Raises
        ------
        SingularError
            If the mechanism cannot take it.
        """
        model, values = self.model, self.home()
        if not model.inputs:
            if self.pose_query.position is not None:
                model.inverse(np.zeros((1, 3)), values)  # raises: what is missing
            return _initial_pose(model)
        if self.pose_query.position is None:
            poses = model.forward(values[None])
            request = ", ".join(f"{n} = {x:.6g}" for n, x in zip(model.inputs, values, strict=True))
        else:
            position = np.asarray(self.pose_query.position, float)
            poses = model.inverse(position[None], values, rotor=self.pose_query.rotor)
            request = f"the tool at ({', '.join(f'{x:.6g}' for x in position)})"
        if not poses.is_reached[0]:
            code = Status(int(poses.status[0])).name
            raise SingularError(f"no pose has {request}: {code}{self._unreached_arms()}.", where=self.name)
        return poses

    found = renamed_attribute("solve_pose")

    def _unreached_arms(self) -> str:
        """Text of the arms of a Delta robot that do not reach the position."""
        if not isinstance(self.model, DeltaModel) or self.pose_query.position is None:
            return ""
        codes = np.asarray(self.model.robot.arm_status(self.pose_query.position, self.model.elbow))
        bad = [str(i + 1) for i in range(3) if codes[i] != Status.OK]
        return f", arm{'s' if len(bad) > 1 else ''} {', '.join(bad)}" if bad else ""

    def report(self) -> Report:
        """Bodies, joints, mobility, free motions, redundant constraints, and the Jacobian at the pose."""
        return build_report(self.model, self.solve_pose(), self.units, self.name)

    # -- motions -----------------------------------------------------------------------------------------------

    def motion(self) -> Motion:
        """Coordinates and speeds of the inputs along the path; see `Motion`."""
        return self.motion_with_poses()[0]

    def motion_with_poses(self) -> tuple[Motion, PoseBatch]:
        """The motion along the path, and its poses."""
        tool_path, model = self.tool_path, self.model
        if tool_path is None:
            raise InputError("has no path.", where=self.name, remedy="Describe one under [path]")
        start = self.solve_pose()
        if tool_path.kind == "joints":
            for name in tool_path.numbers:
                if name not in model.inputs:
                    raise InputError(
                        f"the path drives {name!r}, which is not an actuated joint"
                        f"{suggest(name, model.inputs)}; there are: {', '.join(model.inputs) or 'none'}.",
                        where=self.name,
                    )
            values, speeds = tool_path.coordinates(model.inputs, start.coordinates[0])
            poses = model.forward(values, path=True)
            velocity = np.full((len(values), 3), np.nan)
            if model.tool:
                velocity = np.einsum("nrk,nk->nr", poses.jacobian[:, -3:], speeds)
            speeds = np.where(poses.is_reached[:, None], speeds, np.nan)
        else:
            positions, velocity = tool_path.positions(start.position[0])
            poses = model.inverse(positions, start.coordinates[0], path=True)
            velocity = np.where(poses.is_reached[:, None], velocity, np.nan)
            speeds = np.einsum("nkr,nr->nk", poses.inverse[..., -3:], velocity)
        position = poses.position if model.tool else np.full_like(velocity, np.nan)
        return Motion(
            tool_path.times, tuple(model.inputs), model.is_revolute, poses.coordinates, speeds, position, velocity,
            poses.condition, poses.status, self.units,
        ), poses  # fmt: skip

    moved = renamed_attribute("motion_with_poses")
    stand = renamed_attribute("pose_query")
    way = renamed_attribute("tool_path")

    # -- the workspace -----------------------------------------------------------------------------------------

    def workspace(
        self, progress: ProgressOption = False, executor: Executor | None = None
    ) -> Workspace | WorkspaceGrid:
        """Positions of the tool in a box: `Workspace` of a Delta robot, `WorkspaceGrid` of others.

        Parameters
        ----------
        progress : bool or callable
            True: a bar on standard error. A callable gets a `bladesmith.Progress` of positions.
        executor : concurrent.futures.Executor, optional
            Evaluates parts of the box on its workers; the results have the same bits.

        Raises
        ------
        ExecutorError
            If workers of the executor fail or end, and do so again.
        Interrupted
            On an interrupt. As that of an `ExecutorError`, its ``partial`` is a grid, not reachable and NaN where it
            was not looked at.
        """
        box = self.box or WorkspaceQuery()
        if isinstance(self.model, DeltaModel):
            samples = box.samples or SAMPLES
            return self.model.robot.workspace(
                box.bounds, samples, self.model.elbow, progress=progress, executor=executor
            )
        self.check_workspace()
        start = self.solve_pose().coordinates[0]
        axes = self._axes(box, start)
        positions = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
        flat = positions.reshape(-1, 3)
        condition = np.full(len(flat), np.nan)

        def grid() -> WorkspaceGrid:
            conditions = condition.reshape(positions.shape[:-1])
            x, y, z = axes
            return WorkspaceGrid(x, y, z, np.isfinite(conditions) | np.isposinf(conditions), conditions)

        with open_progress(progress, "workspace", "positions", len(flat)) as report, keep_partial(grid):
            task, arrays = _WorkspaceTask(self.model, start), {"condition": condition}
            function = _sample if executor is None else _sample_serially
            fill_parts(executor, task, function, (flat,), "positions", arrays, report, CHUNK)
        return grid()

    def check_workspace(self) -> None:
        """Raise for a workspace that cannot be computed, before any work."""
        box = self.box or WorkspaceQuery()
        if isinstance(self.model, DeltaModel):
            return
        if box.show != "condition":
            raise InputError(f"the measure {box.show!r} is of Delta robots; others have 'condition'.", where=self.name)
        self._bounds(box, np.zeros(len(self.model.inputs)))

    def _axes(self, box: WorkspaceQuery, start: Array) -> list[Array]:
        low, high = self._bounds(box, start)
        count: Any = box.samples
        if count is None:
            count = [SLICES if "xyz"[i] == box.across else FEW for i in range(3)]
        counts = [count] * 3 if np.ndim(count) == 0 else list(count)
        return [
            np.linspace(a, b, n) if n > 1 and b > a else np.array([(a + b) / 2])
            for a, b, n in zip(low, high, counts, strict=True)
        ]

    def _bounds(self, box: WorkspaceQuery, start: Array) -> tuple[Array, Array]:
        if box.bounds is not None:
            low, high = np.asarray(box.bounds, float).T
            if (low > high).any():
                raise InputError("a box has the least coordinate of each axis first.", where=self.name)
            return low, high
        if isinstance(self.model, ChainModel) and np.isfinite(self.model.chain.reach):
            first = self.model.chain.algebra.matrix(self.model.chain.forward(start, all=True))[0, :3, 3]
            return first - self.model.chain.reach, first + self.model.chain.reach
        raise InputError(
            "its workspace has no box.", where=self.name, remedy="Give box = [[x, x], [y, y], [z, z]] under [workspace]"
        )  # fmt: skip

    # -- pictures ----------------------------------------------------------------------------------------------

    def picture(self, path: str | PathLike[str] | None = None, moved: tuple[Motion, PoseBatch] | None = None) -> Axes3D:
        """The robot at its pose; with a motion, along its path, the last pose strongest."""
        from ..plotting import picture

        look, trace = self.look, None
        if moved is not None:
            poses, trace = moved[1], moved[1].position
            reached = np.flatnonzero(poses.is_reached)
            if not len(reached):
                raise SingularError("no pose of the path can be taken.", where=self.name)
            count = min(max(look.poses, 2), MOST_POSES)
            rows = [int(reached[i]) for i in np.unique(np.linspace(0, len(reached) - 1, count).round().astype(int))]
        else:
            poses, rows = self.solve_pose(), [0]
        if isinstance(self.model, DeltaModel):
            return self._delta_picture(poses, rows[-1], trace, path)
        return picture.picture(
            [poses.at(i) for i in rows], path, tool=self.model.tool,
            position=poses.position[rows] if self.model.tool else None, trace=trace if self.model.tool else None,
            view=look.view or (20.0, -60.0), title=look.title, legend=look.legend,
        )  # fmt: skip

    def _delta_picture(self, poses: PoseBatch, row: int, trace: Any, path: Any) -> Axes3D:
        """Picture of a Delta robot."""
        from ... import plot as drawn
        from ...plot import palette
        from ...plot.axes_setup import save
        from ...plot.style import check_suffix
        from ..delta import plots

        assert isinstance(self.model, DeltaModel)
        check_suffix(path)
        model, view = self.model, dict[str, Any]()
        if self.look.view is not None:
            view["view"] = self.look.view
        by_angles = self.pose_query.position is None and (
            trace is None or (self.tool_path is not None and self.tool_path.kind == "joints")
        )
        if by_angles:
            ax = plots.picture(model.robot, poses.coordinates[row], root=model.root, **view)
        else:
            ax = plots.picture(model.robot, y=poses.position[row], elbow=model.elbow, **view)
        if trace is not None:
            box = np.sort([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()]).T
            drawn.paths(trace, ax, palette.GREEN, plots.PATH, box)
            ax.set_zlim3d(*box[::-1, 2])  # e3 points down the page
        if path is not None:
            save(path, ax)
        return ax

    def slices(self, path: str | PathLike[str] | None = None, space: Workspace | WorkspaceGrid | None = None) -> Figure:
        """Slices of the workspace: condition numbers where the tool can be, nothing where it cannot."""
        from ...plot.axes_setup import save
        from ...plot.style import check_suffix
        from ..delta.plots import slices

        box = self.box or WorkspaceQuery()
        check_suffix(path)
        grid = self.workspace() if space is None else space
        figure = slices(grid, show=box.show, across=box.across, at=box.at)
        if isinstance(grid, WorkspaceGrid) and box.across != "z" and figure.axes[0].yaxis_inverted():
            figure.axes[0].invert_yaxis()  # z points down the page for Delta robots only
        if path is not None:
            save(path, figure)
        return figure


@dataclass(frozen=True, eq=False)
class _WorkspaceTask(Task):
    """A model, and coordinates from which its poses are searched."""

    model: AnyModel
    start: Array

    def prepare(self) -> _WorkspaceTask:
        return self


def _sample(task: _WorkspaceTask, positions: Array) -> dict[str, Array]:
    """Condition numbers at positions (n, 3), NaN where the tool cannot be."""
    poses = task.model.inverse(positions, task.start)
    return {"condition": np.where(poses.is_reached, poses.condition, np.nan)}


def _sample_serially(task: _WorkspaceTask, positions: Array) -> dict[str, Array]:
    """`_sample` on one thread, for workers, of which there are several."""
    return parallel.serially(lambda: _sample(task, positions))


def _initial_pose(model: AnyModel) -> PoseBatch:
    """Pose of a mechanism without inputs: that of its file."""
    assert isinstance(model, MechanismModel)
    position = np.zeros((1, 3)) if not model.tool else model.point[None]
    return PoseBatch(
        np.zeros((1, 0)), position, np.zeros((1, 3, 0)), np.zeros((1, 0, 3)), np.full(1, np.nan), np.zeros(1, np.uint8),
        lambda i: model.mechanism,
    )  # fmt: skip


__all__ = ["PoseQuery", "Setup", "ViewOptions", "WorkspaceGrid", "WorkspaceQuery"]
