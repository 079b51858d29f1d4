"""A trajectory in space: paths of points, bodies at some times, what holds them (thesis, figures 6.3 to 6.5).

matplotlib is imported by the first picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import plot as drawn
from ..errors import InputError
from ..plot import backend, drawing, pages, palette
from ..plot.figures import check_suffix, faded, plain, save, show_title, surface
from ..plot.outlines import Drawable, Faces
from ..plot.things import sorted_out
from .plots import MOST, single
from .record import Record, recorded
from .shapes import Shape
from .sketch import Sketch

if TYPE_CHECKING:
    from ..plot.backend import Axes3D
    from .trajectory import Trajectory

Array = NDArray[Any]
#: Bodies: opacity of the surface, for the last state and for the others; of the edges.
SOLID, FAINT, EDGE = 0.55, 0.22, 0.8
#: Widths in points: of traces, of edges, of objects that hold a body.
TRACE, THIN, OBJECT = 1.6, 0.7, 1.0
#: Inches of a page with one picture.
PAGE = (7.2, 6.0)
#: The shortest side of a view as a share of the longest; and how much larger than its contents a view is.
LEAST_SIDE, MARGIN = 0.25, 1.03
#: States at which it is looked how much room a body takes.
LOOKED_AT = 200


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
        drawn.draw(points[-1:], ax=ax, color=color, size=TRACE)
        if label:
            drawing.picture_of(ax).handles.append(backend.line_class()([], [], color=color, label=plain(label)))
    if drawing.picture_of(ax).handles:
        pages.show_legend(ax, drawing.picture_of(ax).handles)
    if record.sketch.title:
        show_title(ax, record.sketch.title)
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


def _swept(own: Record, shape: Shape) -> Array:
    """Least and greatest corners (m, 2, 3) of a body at some states."""
    chosen = np.unique(np.linspace(0, len(own) - 1, LOOKED_AT).astype(int))
    turns, places = own.orientation[chosen], own.position[chosen]
    corners = np.einsum("nij,vj->nvi", turns, shape.vertices) + places[:, None]
    return np.stack([corners.min(1), corners.max(1)], 1)


def _bounds(held: Any) -> Array:
    """Positions that bound an object that is finite."""
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
    faces.set(zorder=drawing.ORDER[Faces], clip_on=False)
    if len(shape.edges):
        drawn.paths(vertices[shape.edges], ax, faded(color, len(shape.edges), EDGE * opacity / SOLID), THIN)


def placed(own: Record, shape: Shape, number: int) -> Array:
    """Vertices of a body at a state."""
    return np.asarray(shape.vertices @ own.orientation[number].T + own.position[number])


__all__ = ["body_color", "paths", "picture", "placed", "room", "states_at"]
