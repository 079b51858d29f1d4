"""Pictures of trajectories in space: paths, bodies at some times, objects of constraints (thesis, figures 6.3 to 6.5).

matplotlib is imported by the first picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ... import plot as drawn
from ...errors import InputError
from ...mechanics.shapes import Shape
from ...plot import axes_setup, drawing, palette
from ...plot.glyphs import Drawable, Faces
from ...plot.input_groups import group_items
from ...plot.style import check_suffix, finish_picture, surface, uniform_rows
from ...plot.tessellation import Box
from ...plot.view_box import surrounding_box
from ..results.figure_spec import Sketch
from ..results.trajectory_data import TrajectoryData, TrajectorySource, data_of
from .curves import MAX_STATES, single

if TYPE_CHECKING:
    from ...plot.matplotlib_import import Axes3D

Array = NDArray[Any]
#: Opacity of a body's surface in the last state.
SOLID = 0.55
#: Opacity of its surface in the other states.
FAINT = 0.22
#: Opacity of its edges.
EDGE = 0.8
#: Width of traces, in points.
TRACE = 1.6
#: Width of edges.
THIN = 0.7
#: Width of objects of constraints.
OBJECT = 1.0
#: Inches of a page with one picture.
PAGE = (7.2, 6.0)
#: Shortest side of a view and its margin, as fractions of the longest side.
MIN_SIDE, MARGIN = 0.25, 0.015
#: Smallest view, relative to the distance from the origin.
LEAST_VIEW = 4e-9
#: States from which the bounds of a body are computed.
SAMPLED_STATES = 200


def picture(
    trajectory: TrajectorySource,
    path: str | PathLike[str] | None = None,
    *,
    sketch: Sketch | None = None,
    shown: Sequence[float] | None = None,
    view: tuple[float, float] | None = None,
    size: tuple[float, float] = PAGE,
    frame: bool = True,
    dpi: float = axes_setup.DOTS_PER_INCH,
) -> Axes3D:
    """The motion in space: paths of points, bodies at some times, and objects of constraints.

    Parameters
    ----------
    trajectory : Trajectory or Record
    path : optional
        Where to save it; the suffix says the format.
    sketch : Sketch, optional
        Contents; default: those stored with the trajectory. Without traces the path is that of the center of mass; a
        body without a shape is drawn as the frame of its axes.
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
        Axes of matplotlib, for further drawing.

    Raises
    ------
    InputError
        If it is a batch, or the picture cannot be saved under this name.
    MissingExtraError
        If matplotlib is not installed (extra `plot`).
    """
    record = single(data_of(trajectory, sketch))
    check_suffix(path)
    if not len(record):
        raise InputError("a trajectory without states has no picture.")
    ax = drawn.axes(record.sketch.view if view is None else view, size, frame)
    box = view_bounds(record)
    times = record.sketch.shown if shown is None else shown
    for i, number in enumerate(states_at(record, times)):
        last = i == len(states_at(record, times)) - 1
        for name, body in record.bodies.items():
            _draw_body(ax, body, name, number, SOLID if last else FAINT)
    if record.sketch.objects:
        drawn.draw(*record.sketch.objects, ax=ax, color=palette.GREY, size=OBJECT)
    traces = paths(record)
    for i, (_, color, points) in enumerate(traces):
        drawn.paths(points[:: max(1, -(-len(points) // MAX_STATES))], ax, color, TRACE, None if i else box)
        drawn.draw(points[-1:], ax=ax, color=color, size=TRACE)
    finish_picture(ax, [(label, color) for label, color, _ in traces if label], record.sketch.title, path, dpi)
    return ax


def paths(record: TrajectoryData) -> list[tuple[str, str, Array]]:
    """Label, color and positions (stores, 3) of every trace; without any, of the centers of mass."""
    sketch, bodies = record.sketch, record.bodies
    if not sketch.traces:
        several = len(bodies) > 1
        colors = [body_color(record, name) for name in bodies]
        return [
            (name if several else "center of mass", color, body.position)
            for (name, body), color in zip(bodies.items(), colors, strict=True)
        ]
    return [(t.label, sketch.color_of(i), record.path_of(t)) for i, t in enumerate(sketch.traces)]


def body_color(record: TrajectoryData, name: str) -> str:
    """Color of a body's surface."""
    number = list(record.rows).index(name)
    color = record.sketch.colors.get(name)
    return palette.SERIES[number % len(palette.SERIES)] if color is None else color


def states_at(record: TrajectoryData, times: Sequence[float] | None) -> list[int]:
    """Indices of the stored states nearest to some times."""
    if times is None:
        return sorted({0, len(record) - 1})
    return [int(np.abs(record.time - t).argmin()) for t in times]


def view_bounds(record: TrajectoryData) -> Box:
    """Box around all bodies and paths, and around the finite objects of constraints."""
    parts = [points for _, _, points in paths(record)]
    for name, body in record.bodies.items():
        shape = record.sketch.shape_of(name, len(record.rows) == 1)
        reach = 0.0 if shape is None else float(np.linalg.norm(shape.vertices, axis=1).max(initial=0.0))
        parts += [body.position - reach, body.position + reach] if shape is None else [_swept_bounds(body, shape)]
    points = np.concatenate([x.reshape(-1, 3) for x in parts])
    points = points[np.isfinite(points).all(1)]
    for drawn_object in record.sketch.objects:
        points = np.concatenate([points, _object_bounds(drawn_object)])
    least = max(LEAST_VIEW * float(np.abs(points).max(initial=0)), 1e-3 * LEAST_VIEW)
    return surrounding_box(points, MARGIN, MIN_SIDE, least)


def _swept_bounds(body: TrajectoryData, shape: Shape) -> Array:
    """Corners (m, 2, 3) of the bounding boxes of a body at some states."""
    indices = np.unique(np.linspace(0, len(body) - 1, SAMPLED_STATES).astype(int))
    rotations, positions = body.orientation[indices], body.position[indices]
    corners = np.einsum("nij,vj->nvi", rotations, shape.vertices) + positions[:, None]
    return np.stack([corners.min(1), corners.max(1)], 1)


def _object_bounds(drawn_object: Any) -> Array:
    """Positions that bound an object, if it is finite."""
    groups = group_items(drawn_object, None).groups
    reaches = [Drawable(group, np.zeros((1, 4))).bounding_points() for group in groups]
    return np.concatenate([np.empty((0, 3)), *(x.reshape(-1, 3) for x in reaches)])


def _draw_body(ax: Axes3D, body: TrajectoryData, name: str, number: int, opacity: float) -> None:
    shape = body.sketch.shape_of(name, len(body.rows) == 1)
    if shape is None:
        drawn.draw(body.motor[number], ax=ax, opacity=opacity)
        return
    vertices = vertices_at(body, shape, number)
    color = body_color(body, name)
    faces = surface(vertices[shape.faces], color, opacity)
    ax.add_collection3d(faces)
    faces.set(zorder=drawing.ORDER[Faces], clip_on=False)
    if len(shape.edges):
        drawn.paths(vertices[shape.edges], ax, uniform_rows(color, len(shape.edges), EDGE * opacity / SOLID), THIN)


def vertices_at(body: TrajectoryData, shape: Shape, number: int) -> Array:
    """Vertices of a body at a state."""
    return np.asarray(shape.vertices @ body.orientation[number].T + body.position[number])


__all__ = ["body_color", "paths", "picture", "vertices_at", "view_bounds", "states_at"]
