"""Pictures of a Delta robot: drawn at poses, slices of its workspace, motions. matplotlib comes with the first one."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ... import plot as drawn
from ...codegen.errors import InputError, SingularError
from ...common.validation import as_choice, check_shape, finite_array
from ...plot import axes_setup, matplotlib_import, palette
from ...plot.style import add_plate, check_suffix, dress_panel, show_curve_names, uniform_rows
from ...plot.view_box import surrounding_box

if TYPE_CHECKING:
    from ...plot.matplotlib_import import Axes3D, Figure
    from .geometry import Pose

Array = NDArray[Any]
#: Width of upper arms, in points.
ARM = 4.0
#: Width of rods, in points.
ROD = 1.5
#: Width of the edges of plates, in points.
EDGE = 1.2
#: Width of a path of the platform, in points.
PATH = 1.2
#: Opacity of plates.
PLATE = 0.35
#: Opacity of poses other than the last.
FAINT = 0.3
#: Size of a picture, in inches.
PAGE = (7.2, 6.4)
#: Size of a panel, in inches.
PANEL = (3.9, 3.5)
#: Measures of slices: label, logarithmic scale, and values at both ends of the colors.
MEASURES = {
    "condition": ("condition number of the Jacobian", True, (1.0, 100.0)),
    "inverse": ("least sine of an arm", False, (0.0, 1.0)),
    "forward": ("volume of the unit forearms", False, (0.0, 1.0)),
}
#: Panels of a page of slices, at most.
MOST_SLICES = 24
#: Margin around a robot, as a fraction of the longest side.
MARGIN = 0.06


class Robot(Protocol):
    """What is drawn of a `DeltaRobot`, which draws itself."""

    def pose(self, theta: Any, root: str = ...) -> Pose: ...
    def pose_at(self, y: Any, elbow: Any = ...) -> Pose: ...


class Grid(Protocol):
    """What is drawn of a `Workspace`."""

    @property
    def x(self) -> Array: ...
    @property
    def y(self) -> Array: ...
    @property
    def z(self) -> Array: ...
    @property
    def reachable(self) -> Array: ...


class Curves(Protocol):
    """What is drawn of a `Motion`."""

    @property
    def time(self) -> Array: ...
    @property
    def theta(self) -> Array: ...
    @property
    def speed(self) -> Array: ...
    @property
    def angular_acceleration(self) -> Array: ...


def picture(
    robot: Robot,
    theta: Any = None,
    path: str | PathLike[str] | None = None,
    *,
    y: Any = None,
    elbow: Any = "outer",
    root: str = "far",
    view: tuple[float, float] = (14.0, -62.0),
    size: tuple[float, float] = PAGE,
    frame: bool = True,
    dpi: float = axes_setup.DOTS_PER_INCH,
) -> Axes3D:
    """The robot at one pose, or at several: the last one strongest, with the path of the platform through all.

    Parameters
    ----------
    robot : DeltaRobot
    theta : array (3,) or (n, 3)
        Angles; or give ``y``.
    path : optional
        File to save it to; the suffix is the format.
    y : array (3,) or (n, 3), optional
        Positions of the platform.
    elbow, root
        As in `DeltaRobot.inverse` and `forward`.
    view : (elevation, azimuth)
        Degrees. e3 points down the page.
    size : (width, height)
        Inches.
    frame : bool
        Draw the box of coordinates.
    dpi : float

    Returns
    -------
    Axes3D
        Axes of matplotlib.

    Raises
    ------
    InputError
        If there are both angles and positions or neither, or the picture cannot be saved under this name.
    SingularError
        If none of the poses can be taken.
    MissingExtraError
        If matplotlib is not installed (extra `plot`).
    """
    if (theta is None) == (y is None):
        raise InputError("a picture is of angles or of positions.", remedy="Give theta, or y=")
    check_suffix(path)
    pose = robot.pose(theta, root) if y is None else robot.pose_at(y, elbow)
    rows = [np.reshape(x, (-1, *x.shape[pose.position.ndim - 1 :])) for x in pose]
    valid = [i for i in range(len(rows[0])) if all(np.isfinite(x[i]).all() for x in rows)]
    if not valid:
        raise SingularError("the robot cannot take any of these poses.")
    ax = drawn.axes(view, size, frame)
    base = -2 * rows[2][valid[-1]][[2, 0, 1]]  # a triangle whose sides have the motors in their middles
    box = surrounding_box(
        np.concatenate([x.reshape(-1, 3) for x in (base, *(x[valid] for x in rows[2:]))]), MARGIN, 0.0
    )
    add_plate(ax, base, palette.GREY, PLATE, 1.0, EDGE, box)
    for i in valid:
        _draw(ax, type(pose)(*(x[i] for x in rows)), 1.0 if i == valid[-1] else FAINT, box)
    if len(rows[0]) > 1:
        drawn.paths(rows[0], ax, palette.GREEN, PATH, box)
    low, high = box
    ax.set_zlim3d(float(high[2]), float(low[2]))
    axes_setup.fill_page(ax)
    if path is not None:
        axes_setup.save(path, ax, dpi)
    return ax


def _draw(ax: Any, pose: Pose, opacity: float, box: tuple[Array, Array]) -> None:
    """Platform, arms and rods of one pose."""
    add_plate(ax, pose.corners, palette.BLUE, PLATE * opacity, opacity, EDGE, box)
    elbow_rods = np.stack([pose.tops[::2], pose.tops[1::2]], 1)
    upper = np.stack([pose.shoulders, pose.elbows], 1)
    drawn.paths(elbow_rods, ax, uniform_rows(palette.AMBER, 3, opacity), EDGE, box)
    drawn.paths(upper, ax, uniform_rows(palette.RED, 3, opacity), ARM, box)
    drawn.paths(np.stack([pose.tops, pose.bottoms], 1), ax, uniform_rows(palette.INK, 6, opacity), ROD, box)
    drawn.draw(
        np.concatenate([pose.tops, pose.corners]), ax=ax, color=palette.INK, size=EDGE, opacity=opacity, extent=box
    )


def slices(
    workspace: Grid,
    path: str | PathLike[str] | None = None,
    *,
    show: str = "condition",
    across: str = "z",
    at: Sequence[float] | None = None,
    dpi: float = axes_setup.DOTS_PER_INCH,
) -> Figure:
    """Slices of a workspace: a measure where the platform can be, nothing where it cannot.

    Parameters
    ----------
    workspace : Workspace
    path : optional
        Where to save it.
    show : "condition", "inverse" or "forward"
        Measure: see `Workspace`. Colors end at a condition number of 100.
    across : "x", "y" or "z"
        The coordinate that is constant in a slice.
    at : sequence of float, optional
        Its values, rounded to the nearest samples; default: six within the reachable range.
    dpi : float

    Returns
    -------
    Figure
        Of matplotlib.

    Raises
    ------
    InputError
        If nothing is reachable, or an argument is not valid.
    MissingExtraError
        If matplotlib is not installed (extra `plot`).
    """
    words, logarithmic, ends = MEASURES[as_choice(show, "show", tuple(MEASURES))]
    axis = "xyz".index(as_choice(across, "across", ("x", "y", "z")))
    check_suffix(path)
    numbers = _slice_numbers(workspace, axis, at)
    columns = min(len(numbers), 3)
    rows = -(-len(numbers) // columns)
    figure = axes_setup.new_figure(figsize=(columns * PANEL[0], rows * PANEL[1]), dpi=dpi, layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    colors = matplotlib_import.load_module("matplotlib.colors")
    names = palette.RAMP if show == "condition" else palette.RAMP[::-1]
    ramp = colors.LinearSegmentedColormap.from_list("ramp", names)
    scale = (colors.LogNorm if logarithmic else colors.Normalize)(*ends)
    values = np.where(workspace.reachable, getattr(workspace, show), np.nan)
    images = [
        _slice(ax, workspace, values.take(number, axis), axis, number, ramp, scale)
        for ax, number in zip(panels, numbers, strict=False)
    ]
    for ax in panels[len(numbers) :]:
        ax.set_visible(False)
    bar = figure.colorbar(images[-1], ax=list(panels), extend="max" if logarithmic else "neither", shrink=0.8, pad=0.01)
    bar.set_label(words, color=palette.INK, fontsize=9)
    bar.ax.tick_params(labelsize=8, colors=palette.GREY)
    bar.outline.set_visible(False)
    if path is not None:
        axes_setup.save(path, figure, dpi)
    return figure


def _slice_numbers(workspace: Grid, axis: int, at: Sequence[float] | None) -> list[int]:
    """Indices of the samples along an axis that are drawn."""
    samples = (workspace.x, workspace.y, workspace.z)[axis]
    others = tuple(i for i in range(3) if i != axis)
    reached = np.flatnonzero(workspace.reachable.any(others))
    if not len(reached):
        raise InputError("nothing of this workspace is reached.", remedy="Sample another box: bounds=")
    if at is None:
        return sorted({int(i) for i in np.linspace(reached[0], reached[-1], 8).round()[1:-1]})
    values = np.atleast_1d(finite_array(at, "at"))
    check_shape(values, "at", ("n",))
    if not 1 <= len(values) <= MOST_SLICES:
        raise InputError(f"at has {len(values)} numbers; from 1 to {MOST_SLICES} are needed.")
    return [int(np.abs(samples - v).argmin()) for v in values]


def _slice(ax: Any, workspace: Grid, values: Array, axis: int, number: int, ramp: Any, scale: Any) -> Any:
    """One panel."""
    samples = (workspace.x, workspace.y, workspace.z)
    first, second = (i for i in range(3) if i != axis)
    image = ax.pcolormesh(samples[first], samples[second], values.T, cmap=ramp, norm=scale, shading="nearest")
    ax.set_title(f"{'xyz'[axis]} = {samples[axis][number]:.4g}", fontsize=9.5, color=palette.INK, loc="left")
    ax.set_xlabel("xyz"[first], color=palette.GREY, fontsize=9)
    ax.set_ylabel("xyz"[second], color=palette.GREY, fontsize=9)
    ax.set_aspect("equal")
    ax.tick_params(labelsize=8, colors=palette.GREY)
    ax.set_facecolor(palette.PALE)
    if second == 2 and not ax.yaxis_inverted():  # e3 points down
        ax.invert_yaxis()
    for spine in ax.spines.values():
        spine.set_visible(False)
    return image


def curves(motion: Curves, path: str | PathLike[str] | None = None, *, dpi: float = axes_setup.DOTS_PER_INCH) -> Figure:
    """Angles, speeds and accelerations of the motors over time; a `Figure` of matplotlib.

    Raises
    ------
    InputError
        If an argument is not valid.
    SingularError
        If the robot can be at none of the times.
    """
    check_suffix(path)
    if not np.isfinite(motion.theta).all(-1).any():
        raise SingularError("the robot can be at none of these times.", remedy="Its status says why")
    panels = (
        ("angles of the motors [rad]", motion.theta),
        ("speeds [rad per time]", motion.speed),
        ("accelerations [rad per time squared]", motion.angular_acceleration),
    )
    figure = axes_setup.new_figure(figsize=(6.4, 6.6), dpi=dpi, layout="constrained")
    for ax, (title, values) in zip(figure.subplots(3, 1, sharex=True), panels, strict=True):
        for column, color, label in zip(values.T, palette.AXES, ("arm 1", "arm 2", "arm 3"), strict=True):
            ax.plot(motion.time, column, color=color, linewidth=1.1, label=label)
        dress_panel(ax, title)
    show_curve_names(figure.axes[0])
    figure.axes[-1].set_xlabel("t", color=palette.GREY, fontsize=9)
    if path is not None:
        axes_setup.save(path, figure, dpi)
    return figure


__all__ = ["MEASURES", "curves", "picture", "slices"]
