"""Mechanisms drawn at poses: bodies as sticks and plates between their joints, joints as marks with their axes.

matplotlib is imported by the first picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from ... import plot as drawn
from ...common.deprecation import renamed_keywords
from ...common.validation import as_instance
from ...core.geometry.euclidean import perpendicular
from ...errors import InputError
from ...plot import axes_setup, palette
from ...plot.style import add_plate, add_surface, check_suffix, finish_picture, uniform_rows
from ...plot.tessellation import Box
from ...plot.view_box import surrounding_box
from ..mechanism.mechanism import Mechanism
from .glyphs import Mark, Sketch, mechanism_sketch

if TYPE_CHECKING:
    from ...plot.matplotlib_import import Axes3D

Array = NDArray[Any]
#: What makes mechanisms, for messages.
MAKERS = "Draw robot.mechanism(q) of a robot, delta.mechanism(theta) of a Delta robot"
#: Width of sticks, in points.
STICK = 3.2
#: Width of the edges of plates, in points.
EDGE = 1.6
#: Width of marks, in points.
THIN = 1.1
#: Width of the tool's path, in points.
PATH = 1.3
#: Size of ball joints.
BALL = 1.7
#: Size of other points.
SPOT = 1.0
#: Opacity of plates.
PLATE = 0.3
#: Opacity of poses other than the last.
FAINT = 0.28
#: Size of a picture, in inches.
PAGE = (7.2, 6.0)
#: Radius of a ring, as a fraction of the picture's longest side.
RING = 0.022
#: Half the length of an axis, as a fraction of the picture's longest side.
AXIS = 0.045
#: Half sides of the box of a prismatic joint, across and along, in radii of rings.
SLEEVE = (0.55, 1.7)
#: Half a side of the square of a planar joint, in radii of rings.
TILE = 1.8
#: Half a side of the tile below a fixed body, in radii of rings.
GROUND = 2.5
#: Length of the world's axes in the corner, as a fraction of the longest side.
WORLD = 0.09
#: Corners of a ring.
CORNERS = 25
#: Bodies in a legend, at most.
MOST_NAMES = 12
#: Margin around a picture's contents, as a fraction of the longest side.
MARGIN = 0.07
#: Shortest side of a view, as a fraction of the longest.
LEAST_SIDE = 0.22
#: Spread of points across a line or plane, relative to the widest, below which they are in it.
FLAT = 1e-6


@renamed_keywords(place="position")
def picture(
    mechanism: Mechanism | Sequence[Mechanism],
    path: str | PathLike[str] | None = None,
    *,
    tool: str = "",
    position: Any = None,
    trace: Any = None,
    view: tuple[float, float] = (20.0, -60.0),
    size: tuple[float, float] = PAGE,
    title: str = "",
    legend: bool = True,
    frame: bool = True,
    dpi: float = axes_setup.DOTS_PER_INCH,
) -> Axes3D:
    """A mechanism at its pose, or at several: the last one strongest.

    Parameters
    ----------
    mechanism : Mechanism, or several
        The same at several poses: see `Mechanism.at`.
    path : optional
        File to save it to; the suffix is the format.
    tool : str, optional
        A body whose point ``position`` (3,), or (n, 3) for several poses, is drawn, too.
    trace : array (m, 3), optional
        The path of that point.
    view : (elevation, azimuth)
        Degrees.
    size : (width, height)
        Inches.
    title : str
    legend : bool
        Name the bodies by their colors, twelve at most.
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
        If there is no mechanism, or the picture cannot be saved under this name.
    MissingExtraError
        If matplotlib is not installed (extra `plot`).
    """
    several = [
        as_instance(each, "the mechanism", Mechanism, "a mechanism at a pose", remedy=MAKERS)
        for each in (mechanism if isinstance(mechanism, list | tuple) else [mechanism])
    ]
    if not several:
        raise InputError("a picture shows at least one pose.")
    check_suffix(path)
    positions: list[Any] = (
        [None] * len(several) if position is None else list(np.asarray(position, float).reshape(-1, 3))
    )
    poses = [mechanism_sketch(m, tool, p) for m, p in zip(several, positions, strict=True)]
    line = np.zeros((0, 3)) if trace is None else np.asarray(trace, float)
    box, span = _bounding_box(poses, line)
    ax = drawn.axes(view, size, frame)
    colors = _colors(poses[-1])
    for pose in poses:
        last = pose is poses[-1]
        _bodies(ax, pose, colors, 1.0 if last else FAINT, box)
        if last:
            _ground(ax, pose, span)
            _marks(ax, pose.marks, span, box)
    if len(line):
        drawn.paths(line, ax, palette.GREEN, PATH, box)
    if tool and position is not None:
        drawn.draw(positions[-1][None], ax=ax, color=palette.GREEN, size=SPOT, extent=box)
    drawn.paths(np.zeros((0, 2, 3)), ax, palette.INK, THIN, box)
    if frame:
        _axes(ax, box, span)
    names = colors.items() if legend and len(colors) <= MOST_NAMES else ()
    finish_picture(ax, names, title, path, dpi, STICK)
    return ax


def _colors(pose: Sketch) -> dict[str, str]:
    """Colors of bodies: grey for the fixed one, a series for the others."""
    moving = [name for name in pose.bodies if name != pose.fixed]
    series = palette.SERIES
    found = {pose.fixed: palette.GREY}
    return found | {name: series[i % len(series)] for i, name in enumerate(moving)}


def _bounding_box(poses: Sequence[Sketch], line: Array) -> tuple[Box, float]:
    """Box around all poses, and its longest side."""
    every = [points for pose in poses for points in pose.bodies.values()]
    points = np.concatenate([*every, line[np.isfinite(line).all(-1)]])
    if not len(points):
        points = np.zeros((1, 3))
    span = float(np.ptp(points, axis=0).max()) or poses[-1].span
    return surrounding_box(points, MARGIN, LEAST_SIDE, span), span


def _bodies(ax: Any, pose: Sketch, colors: dict[str, str], opacity: float, box: tuple[Array, Array]) -> None:
    for name, points in pose.bodies.items():
        corners, flat = outline(points)
        if flat:
            add_plate(ax, corners, colors[name], PLATE * opacity, opacity, EDGE, box)
        elif len(corners) > 1:
            drawn.paths(corners, ax, uniform_rows(colors[name], 1, opacity), STICK, box)


def _axes(ax: Any, box: tuple[Array, Array], span: float) -> None:
    """The directions x, y and z in the least corner of the box."""
    corner, ends = box[0], box[0] + WORLD * span * np.eye(3)
    drawn.paths(np.stack([np.broadcast_to(corner, (3, 3)), ends], 1), ax, list(palette.AXES), EDGE, box)
    for end, color, name in zip(ends + (ends - corner) / 3, palette.AXES, "xyz", strict=True):
        ax.text(*end, name, color=color, fontsize=8, ha="center", va="center")


def _ground(ax: Any, pose: Sketch, span: float) -> None:
    """A tile for a fixed body with a single joint, which has neither stick nor plate."""
    if len(outline(pose.bodies[pose.fixed])[0]) != 1:
        return
    position = pose.bodies[pose.fixed][0]
    directions = [m.axes[0] for m in pose.marks if len(m.axes) and np.array_equal(m.position, position)]
    one, two = _perpendicular_pair(directions[0] if directions else np.array([0.0, 0.0, 1.0]))
    side = GROUND * RING * span
    corners = np.array([position + side * (a * one + b * two) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))])
    add_surface(ax, np.stack([corners[[0, 1, 2]], corners[[0, 2, 3]]]), palette.GREY, PLATE)


def outline(points: Array) -> tuple[Array, bool]:
    """Corners of a body, and whether they bound a plate: two and those in a line make a stick, others their hull."""
    apart = np.ptp(points, axis=0).max(initial=0.0) if len(points) else 0.0
    kept: list[Array] = []
    for x in points:  # joints that share a place are one corner
        if all(np.abs(x - y).max() > FLAT * apart for y in kept):
            kept.append(x)
    corners = np.array(kept).reshape(-1, 3)
    if len(corners) < 3:
        return corners, False
    away = corners - corners.mean(0)
    _, sizes, directions = np.linalg.svd(away, full_matrices=False)
    if sizes[1] <= FLAT * sizes[0]:
        return corners[np.argsort(away @ directions[0])], False
    return corners[ConvexHull(away @ directions[:2].T).vertices], True


# -- marks -----------------------------------------------------------------------------------------------------


def _marks(ax: Any, marks: Sequence[Mark], span: float, box: tuple[Array, Array]) -> None:
    lines = [line for mark in marks for line in mark_lines(mark, span)]
    longest = max((len(x) for x in lines), default=0)
    if lines:
        rows = np.stack([np.concatenate([x, np.full((longest - len(x), 3), np.nan)]) for x in lines])
        drawn.paths(rows, ax, palette.INK, THIN, box)
    balls = [m.position for m in marks if m.kind in ("spherical", "universal", "bilinear")]
    if balls:
        drawn.draw(np.array(balls), ax=ax, color=palette.INK, size=BALL, extent=box)


def mark_lines(mark: Mark, span: float) -> list[Array]:
    """Polylines (m, 3) of a joint's mark."""
    ring, axis = RING * span, AXIS * span
    if not len(mark.axes) or mark.kind in ("spherical", "rigid", "bilinear"):
        return []
    direction = mark.axes[0]
    one, two = _perpendicular_pair(direction)
    turn = np.linspace(0, 2 * np.pi, CORNERS)[:, None]
    round_ = mark.position + ring * (np.cos(turn) * one + np.sin(turn) * two)
    match mark.kind:
        case "universal":
            return [mark.position + np.outer([-axis, axis], x) for x in mark.axes]
        case "planar":
            side = TILE * ring
            square = [
                mark.position + side * (a * one + b * two) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1))
            ]
            return [np.array(square), mark.position + np.outer([0, axis], direction)]
        case "prismatic":
            wide, long = SLEEVE[0] * ring, SLEEVE[1] * ring
            ends = [np.array([mark.position + s * long * direction + wide * (a * one + b * two)
                              for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1))]) for s in (-1, 1)]  # fmt: skip
            return [*ends, *(np.stack([ends[0][k], ends[1][k]]) for k in range(4))]
        case "cylindrical":
            return [round_, mark.position + np.outer([-2 * axis, 2 * axis], direction)]
        case _:
            return [round_, mark.position + np.outer([-axis, axis], direction)]


def _perpendicular_pair(direction: Array) -> tuple[Array, Array]:
    """Two unit vectors perpendicular to a third and to each other."""
    one = perpendicular(direction)
    one = one / np.linalg.norm(one)
    return one, np.cross(direction, one)


__all__ = ["mark_lines", "outline", "picture"]
