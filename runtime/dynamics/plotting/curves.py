"""Curves of a trajectory over time. matplotlib is imported by the first picture."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.validation import as_choice
from ...errors import InputError
from ...mechanics.screws import moment_about, wrench_parts
from ...plot import axes_setup, palette
from ...plot.style import check_suffix, dress_panel, plain, show_curve_names
from ..results.figure_spec import Sketch
from ..results.trajectory_data import TrajectoryData, TrajectorySource, data_of

if TYPE_CHECKING:
    from ...plot.matplotlib_import import Figure

Array = NDArray[Any]
#: Curves over time, in the order of a page.
PANELS = ("position", "velocity", "angular velocity", "force", "moment", "energy", "violation")
#: Curves of constraints only.
OF_CONSTRAINTS = ("force", "moment", "violation")
#: Inches of one panel.
PANEL = (5.4, 2.3)
#: Columns of a page by the number of its panels; two by default.
COLUMNS = {1: 1, 2: 1, 3: 1}
#: Largest number of states that are drawn; longer trajectories are sampled.
MAX_STATES = 20_000
#: Smallest value of a logarithmic curve that is drawn, as a fraction of its largest one.
DECADES = 1e-6


def plot(
    trajectory: TrajectorySource,
    path: str | PathLike[str] | None = None,
    *,
    show: Sequence[str] | None = None,
    sketch: Sketch | None = None,
    dpi: float = axes_setup.DOTS_PER_INCH,
) -> Figure:
    """Curves over time.

    Parameters
    ----------
    trajectory : Trajectory or Record
    path : optional
        Where to save it; the suffix says the format.
    show : sequence of str, optional
        Some of `PANELS`, with blanks or underscores; default: all, those of constraints only if there are any. Moments
        are about the center of mass; the energy is relative to its first value; the violation is the largest error of a
        constraint's coefficients.
    sketch : Sketch, optional
        Its title and units are used.
    dpi : float

    Returns
    -------
    Figure
        Figure of matplotlib.

    Raises
    ------
    InputError
        If it is a batch, there is no such panel, or the picture cannot be saved under this name.
    MissingExtraError
        If matplotlib is not installed (extra `plot`).
    """
    record = single(data_of(trajectory, sketch))
    check_suffix(path)
    names = _panels(show, record)
    curves = [curve for name in names for curve in _curves(name, record)]
    columns = COLUMNS.get(len(curves), 2)
    rows = -(-len(curves) // columns)
    figure = axes_setup.new_figure(figsize=(columns * PANEL[0], rows * PANEL[1] + 0.5), dpi=dpi, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True).ravel()
    for ax, curve in zip(axes, curves, strict=False):
        _draw_curve(ax, record, curve)
    for ax in axes[len(curves) :]:
        ax.set_visible(False)
    for ax in axes[max(0, len(curves) - columns) : len(curves)]:
        ax.set_xlabel(f"t [{record.sketch.units.time}]", color=palette.GREY, fontsize=9)
        ax.tick_params(labelbottom=True)
    if record.sketch.title:
        figure.suptitle(plain(record.sketch.title), color=palette.INK, fontsize=12)
    if path is not None:
        axes_setup.save(path, figure, dpi)
    return figure


class Curve(NamedTuple):
    """Lines of one panel."""

    title: str
    unit: str
    values: Array
    labels: tuple[str, ...]
    logarithmic: bool = False


def _panels(show: Sequence[str] | None, record: TrajectoryData) -> list[str]:
    if show is None:
        constrained = any(np.nanmax(np.abs(data.reaction.values), initial=0) > 0 for data in record.bodies.values())
        return [name for name in PANELS if constrained or name not in OF_CONSTRAINTS]
    names = [show] if isinstance(show, str) else list(show)
    names = [name.replace("_", " ") if isinstance(name, str) else name for name in names]
    for name in names:
        as_choice(name, "show", PANELS)
    if not names:
        raise InputError("show is empty.", remedy=f"Give some of {', '.join(PANELS)}")
    return names


def _curves(name: str, record: TrajectoryData) -> list[Curve]:
    """One panel, or one for each body."""
    units = record.sketch.units
    if name == "energy":
        first = float(record.energy[0])
        title = f"energy, less {first:.6g} {units.energy} at the start"
        return [Curve(title, units.energy, (record.energy - first)[:, None], ("",))]
    if name == "violation":
        return [Curve("violation of the constraints", "", record.violation[:, None], ("",), True)]
    curves_of_bodies = []
    for body, data in record.bodies.items():
        of = f" of {plain(body)}" if len(record.rows) > 1 else ""
        curves_of_bodies.append(_body_curve(name, data, of))
    return curves_of_bodies


def _body_curve(name: str, data: TrajectoryData, of: str) -> Curve:
    units = data.sketch.units
    match name:
        case "position":
            return Curve(f"center of mass{of}", units.length, data.position, ("x", "y", "z"))
        case "velocity":
            return Curve(f"velocity{of}", units.velocity, data.velocity, ("x", "y", "z"))
        case "angular velocity":
            axes = ("axis 1", "axis 2", "axis 3")
            return Curve(f"angular velocity{of}, body axes", units.angular_velocity, data.angular_velocity, axes)
        case "force":
            return Curve(
                f"force of the constraints{of}", units.force, wrench_parts(data.reaction).force, ("x", "y", "z")
            )
        case _:
            moment = moment_about(data.reaction, data.position)
            return Curve(f"their moment about the center{of}", units.moment, moment, ("x", "y", "z"))


def _draw_curve(ax: Any, record: TrajectoryData, curve: Curve) -> None:
    step = max(1, -(-len(record) // MAX_STATES))
    time, values = record.time[::step], curve.values[::step]
    colors = palette.AXES if len(curve.labels) > 1 else (palette.INK,)
    if curve.logarithmic and (values > 0).any():
        values = np.where(values > DECADES * values.max(), values, np.nan)  # exact zeros at the start have no logarithm
        ax.set_yscale("log")
    for column, label, color in zip(values.T, curve.labels, colors, strict=True):
        ax.plot(time, column, color=color, linewidth=1.1, label=label)
    unit = f" [{plain(curve.unit)}]" if curve.unit else ""
    dress_panel(ax, curve.title + unit)
    if len(curve.labels) > 1:
        show_curve_names(ax)


def single(record: TrajectoryData) -> TrajectoryData:
    """Data of one simulation.

    Raises
    ------
    InputError
        If it is a batch.
    """
    if record.batch:
        raise InputError(
            f"these are {record.batch[0]} simulations; a picture shows one.",
            remedy="Choose one: dynamics.as_record(trajectory)[0]",
        )
    return record


__all__ = ["PANELS", "plot", "single"]
