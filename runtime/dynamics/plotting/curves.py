"""Curves of a trajectory over time. matplotlib is imported by the first picture."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plot import backend, pages, palette
from ..plot.figures import check_suffix, dress_panel, plain, save, show_curve_names
from .record import Record, recorded
from .screws import moment_about, wrench_parts
from .sketch import Sketch

if TYPE_CHECKING:
    from .trajectory import Trajectory

Array = NDArray[Any]
#: Curves over time, in the order of a page.
PANELS = ("position", "velocity", "angular velocity", "force", "moment", "energy", "violation")
#: What only constraints have.
HELD = ("force", "moment", "violation")
#: Inches of one panel, and columns of a page with so many panels.
PANEL, COLUMNS = (5.4, 2.3), {1: 1, 2: 1, 3: 1}
#: More states than this are not drawn: what is, is every so-manieth.
MOST = 20_000
#: The least of a logarithmic curve that is shown, as a share of its greatest value.
DECADES = 1e-6


def plot(
    trajectory: Trajectory | Record,
    path: str | PathLike[str] | None = None,
    *,
    show: Sequence[str] | None = None,
    sketch: Sketch | None = None,
    dpi: float = pages.DOTS_PER_INCH,
) -> Any:
    """Curves over time.

    Parameters
    ----------
    trajectory : Trajectory or Record
    path : optional
        Where to save it; the suffix says the format.
    show : sequence of str, optional
        Of `PANELS`; default: all, those of constraints where there are any. Moments are about the centre of mass; the
        energy is less its first value; the violation is the largest error of a constraint's coefficients.
    sketch : Sketch, optional
        Its title and units are used.
    dpi : float

    Returns
    -------
    Figure
        Of matplotlib.

    Raises
    ------
    InputError
        If it is a batch, there is no such panel, or the picture cannot be saved under this name.
    MissingExtraError
        If matplotlib is not installed (extra `plot`).
    """
    record = single(recorded(trajectory, sketch))
    if path is not None:
        check_suffix(path)
    names = _panels(show, record)
    curves = [made for name in names for made in _curves(name, record)]
    columns = COLUMNS.get(len(curves), 2)
    rows = -(-len(curves) // columns)
    figure = backend.figure_class()(figsize=(columns * PANEL[0], rows * PANEL[1] + 0.5), dpi=dpi, layout="constrained")
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
        save(path, figure, dpi)
    return figure


class Curve(NamedTuple):
    """Lines of one panel."""

    title: str
    unit: str
    values: Array
    labels: tuple[str, ...]
    logarithmic: bool = False


def _panels(show: Sequence[str] | None, record: Record) -> list[str]:
    if show is None:
        held = any(np.nanmax(np.abs(own.reaction.values), initial=0) > 0 for own in record.bodies.values())
        return [name for name in PANELS if held or name not in HELD]
    names = [show] if isinstance(show, str) else list(show)
    for name in names:
        if name not in PANELS:
            raise InputError(f"show has {name!r}; there are: {', '.join(PANELS)}.")
    if not names:
        raise InputError("show is empty.", remedy=f"Give some of {', '.join(PANELS)}")
    return names


def _curves(name: str, record: Record) -> list[Curve]:
    """One panel, or one for each body."""
    units = record.sketch.units
    if name == "energy":
        first = float(record.energy[0])
        title = f"energy, less {first:.6g} {units.energy} at the start"
        return [Curve(title, units.energy, (record.energy - first)[:, None], ("",))]
    if name == "violation":
        return [Curve("violation of the constraints", "", record.violation[:, None], ("",), True)]
    made = []
    for body, own in record.bodies.items():
        of = f" of {plain(body)}" if len(record.rows) > 1 else ""
        made.append(_of_body(name, own, of))
    return made


def _of_body(name: str, own: Record, of: str) -> Curve:
    units = own.sketch.units
    match name:
        case "position":
            return Curve(f"centre of mass{of}", units.length, own.position, ("x", "y", "z"))
        case "velocity":
            return Curve(f"velocity{of}", units.velocity, own.velocity, ("x", "y", "z"))
        case "angular velocity":
            axes = ("axis 1", "axis 2", "axis 3")
            return Curve(f"angular velocity{of}, body axes", units.angular_velocity, own.angular_velocity, axes)
        case "force":
            return Curve(
                f"force of the constraints{of}", units.force, wrench_parts(own.reaction).force, ("x", "y", "z")
            )
        case _:
            moment = moment_about(own.reaction, own.position)
            return Curve(f"their moment about the centre{of}", units.moment, moment, ("x", "y", "z"))


def _draw_curve(ax: Any, record: Record, curve: Curve) -> None:
    step = max(1, -(-len(record) // MOST))
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


def single(record: Record) -> Record:
    """The record of one simulation.

    Raises
    ------
    InputError
        If there are several.
    """
    if record.batch:
        raise InputError(
            f"these are {record.batch[0]} simulations; a picture shows one.",
            remedy="Choose one: dynamics.recorded(trajectory)[0]",
        )
    return record


__all__ = ["PANELS", "plot", "single"]
