"""What a mechanism file asks for, done: the pose, the report, the motion along a path, slices of the workspace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, SingularError, suggest
from ..dynamics.sketch import Units
from ..status import Status
from .models import ChainModel, DeltaModel, Found
from .models_general import MechanismModel
from .paths import Way
from .record import Motion

if TYPE_CHECKING:
    from ..multivector import Multivector
    from .report import Report

Array = NDArray[Any]
Tell = Callable[[int, int], None]
AnyModel = DeltaModel | ChainModel | MechanismModel
#: Samples along a side of a workspace, of a Delta robot and of others; along the axis across the slices of these.
SAMPLES, FEW, SLICES = 41, 31, 7
#: Positions of a workspace that are looked at in one go.
CHUNK = 2000
#: Poses that are drawn of a path, at most.
MOST_POSES = 24


@dataclass(frozen=True)
class Stand:
    """A pose that is asked for: coordinates of inputs by name, and a place of the tool."""

    joints: dict[str, float] = field(default_factory=dict)
    position: Any = None
    turn: Multivector | None = None


@dataclass(frozen=True)
class Box:
    """A workspace that is asked for: see `DeltaRobot.workspace` and `delta_plots.slices`."""

    bounds: Any = None
    samples: Any = None
    show: str = "condition"
    across: str = "z"
    at: Any = None


@dataclass(frozen=True)
class Look:
    """How pictures look; degrees."""

    title: str = ""
    view: tuple[float, float] | None = None
    poses: int = 1
    legend: bool = True


@dataclass(frozen=True, eq=False)
class Space:
    """Positions of a tool sampled on a grid: x, y, z (each its own axis), what is reached, condition numbers."""

    x: Array
    y: Array
    z: Array
    reachable: NDArray[np.bool_]
    condition: Array


@dataclass(frozen=True, eq=False)
class Setup:
    """A mechanism file, or a URDF, ready to be asked.

    Attributes
    ----------
    model : DeltaModel, ChainModel or MechanismModel
    stand : Stand
    box : Box, optional
    way : Way, optional
    look : Look
    units : Units
    name : str
        Of the file.
    """

    model: AnyModel
    stand: Stand = Stand()
    box: Box | None = None
    way: Way | None = None
    look: Look = Look()
    units: Units = Units()
    name: str = ""

    # -- the pose ----------------------------------------------------------------------------------------------

    def home(self) -> Array:
        """Coordinates of the inputs, where the file says nothing else."""
        values = self.model.home.copy()
        for name, value in self.stand.joints.items():
            if name not in self.model.inputs:
                known = ", ".join(self.model.inputs) or "none"
                raise InputError(
                    f"{name!r} is no joint that is driven{suggest(name, self.model.inputs)}; there are: {known}.",
                    where=self.name,
                )
            values[self.model.inputs.index(name)] = value
        return values

    def found(self) -> Found:
        """The pose, of one item.

        Raises
        ------
        SingularError
            If the mechanism cannot take it.
        """
        model, values = self.model, self.home()
        if not model.inputs:
            if self.stand.position is not None:
                model.at_places(np.zeros((1, 3)), values)  # says what is missing
            return _as_it_is(model)
        if self.stand.position is None:
            found = model.at_joints(values[None])
            asked = ", ".join(f"{n} = {x:.6g}" for n, x in zip(model.inputs, values, strict=True))
        else:
            place = np.asarray(self.stand.position, float)
            found = model.at_places(place[None], values, turn=self.stand.turn)
            asked = f"the tool at ({', '.join(f'{x:.6g}' for x in place)})"
        if not found.known[0]:
            code = Status(int(found.status[0])).name
            raise SingularError(f"no pose has {asked}: {code}{self._why()}.", where=self.name)
        return found

    def _why(self) -> str:
        """Which arms of a Delta robot do not reach."""
        if not isinstance(self.model, DeltaModel) or self.stand.position is None:
            return ""
        codes = np.asarray(self.model.robot.arm_status(self.stand.position, self.model.elbow))
        bad = [str(i + 1) for i in range(3) if codes[i] != Status.OK]
        return f", arm{'s' if len(bad) > 1 else ''} {', '.join(bad)}" if bad else ""

    def report(self) -> Report:
        """Bodies, joints, mobility, free motions, redundant constraints, and the Jacobian at the pose."""
        from .report import reported

        return reported(self)

    # -- motions -----------------------------------------------------------------------------------------------

    def motion(self) -> Motion:
        """Coordinates and speeds of the inputs along the path; see `Motion`."""
        return self.moved()[0]

    def moved(self) -> tuple[Motion, Found]:
        """The motion, and its poses."""
        way, model = self.way, self.model
        if way is None:
            raise InputError("has no path.", where=self.name, remedy="Describe one under [path]")
        start = self.found()
        if way.kind == "joints":
            for name in way.numbers:
                if name not in model.inputs:
                    raise InputError(
                        f"the path drives {name!r}, which is no joint that is driven"
                        f"{suggest(name, model.inputs)}; there are: {', '.join(model.inputs) or 'none'}.",
                        where=self.name,
                    )
            values, speeds = way.coordinates(model.inputs, start.coordinates[0])
            found = model.at_joints(values, path=True)
            velocity = np.full((len(values), 3), np.nan)
            if model.tool:
                velocity = np.einsum("nrk,nk->nr", found.jacobian[:, -3:], speeds)
            speeds = np.where(found.known[:, None], speeds, np.nan)
        else:
            places, velocity = way.places(start.position[0])
            found = model.at_places(places, start.coordinates[0], path=True)
            velocity = np.where(found.known[:, None], velocity, np.nan)
            speeds = np.einsum("nkr,nr->nk", found.inverse[..., -3:], velocity)
        position = found.position if model.tool else np.full_like(velocity, np.nan)
        return Motion(
            way.times, tuple(model.inputs), model.turning, found.coordinates, speeds, position, velocity,
            found.condition, found.status, self.units,
        ), found  # fmt: skip

    # -- the workspace -----------------------------------------------------------------------------------------

    def workspace(self, tell: Tell | None = None) -> Any:
        """Positions of the tool in a box: `delta_space.Workspace` of a Delta robot, `Space` of others."""
        box = self.box or Box()
        if isinstance(self.model, DeltaModel):
            return self.model.robot.workspace(box.bounds, box.samples or SAMPLES, self.model.elbow, None)
        self.check_workspace()
        start = self.found().coordinates[0]
        axes = self._axes(box, start)
        places = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
        flat, conditions = places.reshape(-1, 3), []
        for first in range(0, len(flat), CHUNK):
            found = self.model.at_places(flat[first : first + CHUNK], start)
            conditions.append(np.where(found.known, found.condition, np.nan))
            if tell is not None:
                tell(min(first + CHUNK, len(flat)), len(flat))
        condition = np.concatenate(conditions).reshape(places.shape[:-1])
        x, y, z = axes
        return Space(x, y, z, np.isfinite(condition) | np.isposinf(condition), condition)

    def check_workspace(self) -> None:
        """Raise for a workspace that cannot be looked for, before any work."""
        box = self.box or Box()
        if isinstance(self.model, DeltaModel):
            return
        if box.show != "condition":
            raise InputError(f"the measure {box.show!r} is of Delta robots; others have 'condition'.", where=self.name)
        self._bounds(box, np.zeros(len(self.model.inputs)))

    def _axes(self, box: Box, start: Array) -> list[Array]:
        low, high = self._bounds(box, start)
        count: Any = box.samples
        if count is None:
            count = [SLICES if "xyz"[i] == box.across else FEW for i in range(3)]
        counts = [count] * 3 if np.ndim(count) == 0 else list(count)
        return [
            np.linspace(a, b, n) if n > 1 and b > a else np.array([(a + b) / 2])
            for a, b, n in zip(low, high, counts, strict=True)
        ]

    def _bounds(self, box: Box, start: Array) -> tuple[Array, Array]:
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

    def picture(self, path: str | PathLike[str] | None = None, moved: tuple[Motion, Found] | None = None) -> Any:
        """The robot at its pose; with a motion, along its path, the last pose strongest."""
        from . import pictures

        look, found, trace = self.look, None, None
        if moved is not None:
            found, trace = moved[1], moved[1].position
            known = np.flatnonzero(found.known)
            if not len(known):
                raise SingularError("no pose of the path can be taken.", where=self.name)
            count = min(max(look.poses, 2), MOST_POSES)
            rows = [int(known[i]) for i in np.unique(np.linspace(0, len(known) - 1, count).round().astype(int))]
        else:
            found, rows = self.found(), [0]
        if isinstance(self.model, DeltaModel):
            return self._delta_picture(found, rows[-1], trace, path)
        return pictures.picture(
            [found.at(i) for i in rows], path, tool=self.model.tool,
            place=found.position[rows] if self.model.tool else None, trace=trace if self.model.tool else None,
            view=look.view or (20.0, -60.0), title=look.title, legend=look.legend,
        )  # fmt: skip

    def _delta_picture(self, found: Found, row: int, trace: Any, path: Any) -> Any:
        """A Delta robot has a picture of its own."""
        from .. import plot as drawn
        from ..plot import palette
        from ..plot.figures import check_suffix, save
        from . import delta_plots

        assert isinstance(self.model, DeltaModel)
        if path is not None:
            check_suffix(path)
        model, view = self.model, dict[str, Any]()
        if self.look.view is not None:
            view["view"] = self.look.view
        by_angles = self.stand.position is None and (trace is None or (self.way and self.way.kind == "joints"))
        if by_angles:
            ax = delta_plots.picture(model.robot, found.coordinates[row], root=model.root, **view)
        else:
            ax = delta_plots.picture(model.robot, y=found.position[row], elbow=model.elbow, **view)
        if trace is not None:
            box = np.sort([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()]).T
            drawn.paths(trace, ax, palette.GREEN, delta_plots.PATH, box)
            ax.set_zlim3d(*box[::-1, 2])  # e3 points down the page
        if path is not None:
            save(path, ax)
        return ax

    def slices(self, path: str | PathLike[str] | None = None, space: Any = None) -> Any:
        """Slices of the workspace: condition numbers where the tool can be, nothing where it cannot."""
        from ..plot.figures import check_suffix, save
        from .delta_plots import slices

        box = self.box or Box()
        if path is not None:
            check_suffix(path)
        found = self.workspace() if space is None else space
        figure = slices(found, show=box.show, across=box.across, at=box.at)
        if isinstance(found, Space) and box.across != "z" and figure.axes[0].yaxis_inverted():
            figure.axes[0].invert_yaxis()  # z points down the page for Delta robots only
        if path is not None:
            save(path, figure)
        return figure


def _as_it_is(model: AnyModel) -> Found:
    """A mechanism that nothing drives, where its file has it."""
    assert isinstance(model, MechanismModel)
    place = np.zeros((1, 3)) if not model.tool else model.point[None]
    return Found(
        np.zeros((1, 0)), place, np.zeros((1, 3, 0)), np.zeros((1, 0, 3)), np.full(1, np.nan), np.zeros(1, np.uint8),
        lambda i: model.mechanism,
    )  # fmt: skip


__all__ = ["Box", "Look", "Setup", "Space", "Stand"]
