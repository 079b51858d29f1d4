"""Pictures of trajectories: curves over time, and the motion in space (thesis, figures 6.3 to 6.5). matplotlib is
imported by the first picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import plot as drawn
from ..errors import InputError
from ..files import replacing
from ..plot import backend, drawing, pages, palette
from .record import Record, recorded
from .screws import moment_about, wrench_parts
from .shapes import Shape
from .sketch import Sketch

if TYPE_CHECKING:
    from ..plot.backend import Axes3D
    from .trajectory import Trajectory

Array = NDArray[Any]
#: Curves over time, in the order of a page.
PANELS = ("position", "velocity", "angular velocity", "energy", "force", "moment", "violation")
#: What only constraints have.
HELD = ("force", "moment", "violation")
#: Inches of one panel, and columns of a page with so many panels.
PANEL, COLUMNS = (5.4, 2.3), {1: 1, 2: 1, 3: 1}
#: More states than this are not drawn: what is, is every so-manieth.
MOST = 20_000
#: Bodies: opacity of the surface, for the last state and for the others; of the edges.
SOLID, FAINT, EDGE = 0.55, 0.22, 0.8
#: Widths in points: of traces, of edges, of objects that hold a body.
TRACE, THIN, OBJECT = 1.6, 0.7, 1.0
#: The least of a logarithmic curve that is shown, as a share of its greatest value.
DECADES = 1e-6
#: Inches of a page with one picture.
PAGE = (7.2, 6.0)


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
            return Curve(f"force of the constraints{of}", units.force, wrench_parts(own.reaction).force, ("x", "y", "z"))
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
    ax.set_title(curve.title + unit, fontsize=9.5, color=palette.INK, loc="left")
    ax.tick_params(labelsize=8, colors=palette.GREY)
    ax.grid(color=palette.PALE, linewidth=0.8)
    ax.set_axisbelow(True)
    ax.margins(x=0.01)
    for name, spine in ax.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(palette.GREY)
    if len(curve.labels) > 1:
        ax.legend(fontsize=8, ncols=3, frameon=False, loc="lower right", bbox_to_anchor=(1.0, 0.98), borderaxespad=0,
                  handlelength=1.2, columnspacing=1.0, labelcolor=palette.INK)  # fmt: skip


# -- in space --------------------------------------------------------------------------------------------------


def picture(
    trajectory: Trajectory | Record,
    path: str | PathLike[str] | None = None,
    *,
    sketch: Sketch | None = None,
    shown: Sequence[float] | None = None,
    view: tuple[float, float] | None = None,
    size: tuple[float, float] = PAGE,
    frame: bool = True,
    dpi: float = pages.DOTS_PER_INCH,
) -> Any:
    """The motion in space: paths of points, bodies at some times, and what holds them.

    Parameters
    ----------
    trajectory : Trajectory or Record
    path : optional
        Where to save it; the suffix says the format.
    sketch : Sketch, optional
        What is shown; default: what was stored with the trajectory. Without traces it is the centre of mass; a body
        without a shape is the frame of its axes.
    shown : sequence of float, optional
        Times at which bodies are drawn, the last one strongest; default: the sketch's, else first and last.
    view : (elevation, azimuth), optional
        Degrees; default: the sketch's.
    size : (width, height)
        Inches.
    frame : bool
        Draw the box of coordinates.
    dpi : float

    Returns
    -------
    Axes3D
        Of matplotlib, to go on with.

    Raises
    ------
    InputError
        If it is a batch, or the picture cannot be saved under this name.
    MissingExtraError
        If matplotlib is not installed (extra `plot`).
    """
    record = single(recorded(trajectory, sketch))
    if path is not None:
        check_suffix(path)
    if not len(record):
        raise InputError("a trajectory without states has no picture.")
    ax = drawn.axes(record.sketch.view if view is None else view, size, frame)
    box = room(record)
    times = record.sketch.shown if shown is None else shown
    for i, number in enumerate(states_at(record, times)):
        last = i == len(states_at(record, times)) - 1
        for name, own in record.bodies.items():
            _draw_body(ax, own, name, number, SOLID if last else FAINT)
    if record.sketch.objects:
        drawn.draw(*record.sketch.objects, ax=ax, color=palette.GREY, size=OBJECT)
    for i, (label, color, points) in enumerate(paths(record)):
        drawn.paths(points[:: max(1, -(-len(points) // MOST))], ax, color, TRACE, None if i else box)
        if label:
            drawing.picture_of(ax).handles.append(backend.line_class()([], [], color=color, label=plain(label)))
    if drawing.picture_of(ax).handles:
        pages.show_legend(ax, drawing.picture_of(ax).handles)
    if record.sketch.title:
        figure: Any = ax.figure
        figure.text(0.98, 0.965, plain(record.sketch.title), ha="right", fontsize=10, color=palette.INK)
    if path is not None:
        save(path, ax, dpi)
    return ax


def paths(record: Record) -> list[tuple[str, str, Array]]:
    """Label, colour and positions (stores, 3) of every trace; without any, of the centres of mass."""
    sketch, bodies = record.sketch, record.bodies
    if not sketch.traces:
        several = len(bodies) > 1
        colors = [body_color(record, name) for name in bodies]
        return [
            (name if several else "centre of mass", color, own.position)
            for (name, own), color in zip(bodies.items(), colors, strict=True)
        ]
    return [
        (t.label, sketch.color_of(i), bodies[t.body or record.name].path(t.point)) for i, t in enumerate(sketch.traces)
    ]


def body_color(record: Record, name: str) -> str:
    """Of a body's surface."""
    number = list(record.rows).index(name)
    given = record.sketch.colors.get(name)
    return palette.SERIES[number % len(palette.SERIES)] if given is None else given


def states_at(record: Record, times: Sequence[float] | None) -> list[int]:
    """Numbers of the stored states nearest to some times."""
    if times is None:
        return sorted({0, len(record) - 1})
    return [int(np.abs(record.time - t).argmin()) for t in times]


def room(record: Record) -> tuple[Array, Array]:
    """Corners of a box around everything that moves, and around what is finite of that which does not."""
    found = [points for _, _, points in paths(record)]
    for name, own in record.bodies.items():
        shape = record.sketch.shape_of(name, len(record.rows) == 1)
        reach = 0.0 if shape is None else float(np.linalg.norm(shape.vertices, axis=1).max(initial=0.0))
        found += [own.position - reach, own.position + reach] if shape is None else [_swept(own, shape)]
    points = np.concatenate([x.reshape(-1, 3) for x in found])
    points = points[np.isfinite(points).all(1)]
    for held in record.sketch.objects:
        points = np.concatenate([points, _bounds(held)])
    low, high = points.min(0), points.max(0)
    least = max(float((high - low).max()) * LEAST_SIDE, 1e-9 * float(np.abs(points).max(initial=0)), 1e-12)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, least / 2) * MARGIN
    return middle - half, middle + half


#: The shortest side of a view as a share of the longest; and how much larger than its contents a view is.
LEAST_SIDE, MARGIN = 0.25, 1.03
#: States at which it is looked how much room a body takes.
LOOKED_AT = 200


def _swept(own: Record, shape: Shape) -> Array:
    """Least and greatest corners (m, 2, 3) of a body at some states."""
    chosen = np.unique(np.linspace(0, len(own) - 1, LOOKED_AT).astype(int))
    turns, places = own.orientation[chosen], own.position[chosen]
    corners = np.einsum("nij,vj->nvi", turns, shape.vertices) + places[:, None]
    return np.stack([corners.min(1), corners.max(1)], 1)


def _bounds(held: Any) -> Array:
    """Positions that bound an object that is finite."""
    from ..plot.outlines import Drawable
    from ..plot.things import sorted_out

    groups = sorted_out(held, None).groups
    found = [Drawable(group, np.zeros((1, 4))).reach() for group in groups]
    return np.concatenate([np.empty((0, 3)), *(x.reshape(-1, 3) for x in found)])


def _draw_body(ax: Axes3D, own: Record, name: str, number: int, opacity: float) -> None:
    shape = own.sketch.shape_of(name, len(own.rows) == 1)
    if shape is None:
        drawn.draw(own.motor[number], ax=ax, opacity=opacity)
        return
    vertices = placed(own, shape, number)
    color = body_color(own, name)
    faces = surface(vertices[shape.faces], color, opacity)
    ax.add_collection3d(faces)
    faces.set(zorder=drawing.ORDER[drawing.Faces], clip_on=False)
    if len(shape.edges):
        rows = np.tile(palette.faded(palette.per_item(color, 1, color), EDGE * opacity / SOLID), (len(shape.edges), 1))
        drawn.paths(vertices[shape.edges], ax, rows, THIN)


def surface(triangles: Array, color: str, opacity: float) -> Any:
    """A collection of shaded triangles (f, 3, 3)."""
    made = backend.collections().Poly3DCollection(triangles, edgecolors="none", linewidths=0)
    made.set_facecolor(shaded(triangles, color, opacity))
    return made


def shaded(triangles: Array, color: str, opacity: float) -> Array:
    """A colour for each triangle: what faces the light is brighter."""
    from ..plot.outlines import LIGHT, SHADE

    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, sizes, out=np.zeros_like(normals), where=sizes > 0)
    bright = SHADE + (1 - SHADE) * (1 + normals @ LIGHT) / 2
    rows = np.tile(palette.per_item(color, 1, color), (len(triangles), 1))
    rows[:, :3] *= bright[:, None]
    rows[:, 3] = opacity
    return rows


def placed(own: Record, shape: Shape, number: int) -> Array:
    """Vertices of a body at a state."""
    return np.asarray(shape.vertices @ own.orientation[number].T + own.position[number])


# -- files -----------------------------------------------------------------------------------------------------


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


def plain(text: str) -> str:
    """A text that matplotlib takes for no formula."""
    return text.replace("$", r"\$")


def check_suffix(path: str | PathLike[str]) -> None:
    """Refuse a name that no picture can be saved under, before there is one.

    Raises
    ------
    InputError
        If matplotlib does not know the suffix.
    MissingExtraError
        If matplotlib is not installed.
    """
    from ..reform.picture import check_suffix as known

    known(path)


def save(path: str | PathLike[str], figure: Any, dpi: float = pages.DOTS_PER_INCH) -> None:
    """Write a picture, whole or not at all."""
    place = Path(path)
    try:
        with replacing(place) as temporary:
            named = temporary.with_name(temporary.name + place.suffix)  # matplotlib goes by the suffix
            try:
                drawn.save(named, figure, dpi)
                named.replace(temporary)
            finally:
                named.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}.", where=str(place)) from None


__all__ = ["PANELS", "check_suffix", "picture", "plot", "save"]
