"""Drawing of objects as artists of matplotlib.

Axes store the objects drawn on them, so that lines and planes are clipped anew when the view grows.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..common.validation import as_bool, as_float, as_instance, as_int, as_pair, positive_float, real_array
from ..errors import InputError
from . import axes_setup, matplotlib_import, palette
from .glyphs import Drawable, Faces, Marks, Strokes
from .input_groups import Group, ItemGroups, group_items
from .tessellation import FARTHEST, Array, Box, all_three
from .view_box import automatic_box, extent_box

if TYPE_CHECKING:
    from .matplotlib_import import Axes3D

#: Default width of lines in points (1/72 inch).
WIDTH = 1.6
#: Default width of lines in large sets.
THIN = 0.8
#: Largest number of objects that are drawn with the wider lines.
MANY = 40
#: Diameter of points, relative to the width of lines.
MARK = 3.2
#: Largest number of objects along each segment of a curve.
MOST_SAMPLES = 100_000
#: Drawing order: points over lines over surfaces.
ORDER = {Faces: 1, Strokes: 2, Marks: 3}
#: Attribute of axes: the state of the picture.
_KEY = "_bladesmith_picture"


@dataclass
class DrawnGroup:
    """A drawn group: its artists, and some of their positions."""

    drawable: Drawable
    width: float
    artists: list[Any] = field(default_factory=list)
    positions: Array = field(default_factory=lambda: np.empty((0, 3)))


@dataclass
class Picture:
    """State of a picture: everything drawn on one axes."""

    box: Box | None = None
    fixed: bool = False
    drawn: list[DrawnGroup] = field(default_factory=list)
    skipped: Counter[str] = field(default_factory=Counter)
    handles: list[Any] = field(default_factory=list)
    things: int = 0


def draw(
    *things: Any,
    ax: Axes3D | None = None,
    color: Any = None,
    label: str | list[str] | None = None,
    extent: Any = None,
    size: float | None = None,
    opacity: float = 1.0,
    orientation: bool = False,
    surface: bool = True,
    samples: int | None = None,
    view: tuple[float, float] | None = None,
) -> Axes3D:
    """Draw objects, sets of them, curves and motions.

    Points, point pairs (with their segments), lines and planes (cut by the view's box), circles, spheres, flat points,
    directions (arrows from the middle of the view), motors (frames), in batches and lists of any kinds; duals of
    spheres and planes; curves as families of their objects, those of points as polylines; arrays (..., 3) as points.

    Parameters
    ----------
    *things
        Multivectors of `cga3d` or `pga3d`, curves, arrays of positions, lists of such things.
    ax : Axes3D, optional
        Axes to draw on; new axes by default. Their limits include earlier objects.
    color
        A color for all; a list with one for each argument; for a single argument also one for each item: integers are
        classes, other numbers a parameter from green to red, rows RGB. Curves go from green to red by default.
    label : str or list of str
        Entries of the legend.
    extent : number, or (low, high)
        The view: a cube about the origin with this half side, or corners (numbers or triples). By default it contains
        all finite objects, and the points where lines and planes come nearest to these or to each other.
    size : float
        Width of lines in points; points are some three times as wide.
    opacity : float
        Opacity of everything drawn.
    orientation : bool
        Arrows for the orientation of point pairs, lines, circles, planes and spheres.
    surface : bool
        Spheres and planes as translucent surfaces, or as wires only.
    samples : int
        Objects drawn along each segment of a curve.
    view : (elevation, azimuth)
        Direction of the view, in degrees.

    Returns
    -------
    Axes3D
        Axes of matplotlib. Items without a picture (imaginary, NaN, not a blade) are counted by `count_skipped`.

    Raises
    ------
    InputError
        If there is nothing to draw, an argument is not an object, or a color is not valid.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not things:
        raise InputError("there is nothing to draw.", remedy="Give objects, curves or positions")
    size = None if size is None else positive_float(size, "size")
    samples = None if samples is None else as_int(samples, "samples", 1, MOST_SAMPLES)
    opacity = as_float(opacity, "opacity", 0, 1)
    view = None if view is None else as_pair(view, "view")
    box = None if extent is None else extent_box(extent)
    inputs = [group_items(thing, samples) for thing in things]
    ax = axes_setup.axes() if ax is None else ax
    picture = picture_of(ax)
    orientation, surface = as_bool(orientation, "orientation"), as_bool(surface, "surface")
    colors, labels = _for_each(color, len(things), "color"), _for_each(label, len(things), "label")
    first = picture.things
    for number, (part, item_color, text) in enumerate(zip(inputs, colors, labels, strict=True)):
        default = palette.SERIES[(first + number) % len(palette.SERIES)]
        by_parameter = item_color is None and part.values is not None
        rows = palette.per_item(part.values if by_parameter else item_color, part.count, default)
        rows = palette.with_opacity(rows, opacity)
        width = size or (WIDTH if part.count <= MANY else THIN)
        _add(picture, part, rows, width, orientation, surface)
        if text:
            picture.handles.append(_handle(part, rows[0] if len(rows) else default, text))
    picture.things += len(things)
    if view is not None:
        ax.view_init(*view)
    _show(ax, picture, box)
    if picture.handles:
        axes_setup.show_legend(ax, picture.handles)
    return ax


def count_skipped(ax: Axes3D) -> dict[str, int]:
    """Numbers of items without a picture, by their kind or status: "IMAGINARY", "imaginary circle", ..."""
    return dict(picture_of(ax).skipped)


def picture_of(ax: Axes3D) -> Picture:
    """State of the picture on some axes; it is created at the first call.

    Raises
    ------
    InputError
        If these are not 3D axes.
    """
    as_instance(ax, "ax", matplotlib_import.axes_class(), "an Axes3D", remedy="Use plot.axes()")
    state = vars(ax)
    if _KEY not in state:
        state[_KEY] = Picture()
    picture: Picture = state[_KEY]
    return picture


def _for_each(value: Any, count: int, name: str) -> list[Any]:
    """One value for each argument; a list holds these only if there are several arguments."""
    if name == "label" and isinstance(value, tuple):
        value = list(value)
    if count == 1 and name == "color" or not isinstance(value, list):
        return [value] + [value if name == "color" else None] * (count - 1)
    if len(value) != count:
        raise InputError(f"{name} has {len(value)} entries for {count} things.")
    return list(value)


def _handle(part: ItemGroups, color: Any, text: str) -> Any:
    """Entry of the legend: a dot for points, a line for all other objects."""
    dots = all(group.sort in ("point", "flat_point") for group in part.groups)
    style = {"marker": "o", "linestyle": "none", "markersize": 5} if dots else {}
    return matplotlib_import.line_class()([], [], color=color, label=text, **style)


def _add(
    picture: Picture, part: ItemGroups, rows: palette.Rgba, width: float, orientation: bool, surface: bool
) -> None:
    for group in part.groups:
        drawable = Drawable(group, palette.take_rows(rows, group.indices), orientation, surface)
        picture.drawn.append(DrawnGroup(drawable, width))
    picture.skipped += part.skipped


def paths(
    positions: Any, ax: Axes3D | None = None, color: Any = None, size: float | None = None, extent: Any = None
) -> Axes3D:
    """Draw polylines (trajectories, edges of a mesh, orbits) as one collection.

    Parameters
    ----------
    positions : array (n, m, 3) or (m, 3)
        Corners; a line is interrupted at NaN and at coordinates beyond 1e100.
    ax, color, size, extent
        As for `draw`; a color for all, or one for each polyline.

    Raises
    ------
    InputError
        If the positions or another argument are not valid.
    """
    corners = np.asarray(real_array(positions, "positions"), float)
    if corners.ndim not in (2, 3) or corners.shape[-1] != 3:
        raise InputError(f"positions has shape {corners.shape}; (n, m, 3) or (m, 3) is needed.")
    size = None if size is None else positive_float(size, "size")
    box = None if extent is None else extent_box(extent)
    corners = corners[None] if corners.ndim == 2 else corners
    corners = np.where(np.abs(corners) <= FARTHEST, corners, np.nan)
    ax = axes_setup.axes() if ax is None else ax
    picture = picture_of(ax)
    rows = palette.per_item(color, len(corners), palette.SERIES[picture.things % len(palette.SERIES)])
    width = size or (WIDTH if len(corners) <= MANY else THIN)
    if corners.size:
        group = Group("path", (corners,), np.arange(len(corners)))
        picture.drawn.append(DrawnGroup(Drawable(group, rows), width))
    picture.things += 1
    _show(ax, picture, box)
    return ax


# -- the view --------------------------------------------------------------------------------------------------


def _show(ax: Axes3D, picture: Picture, extent: Box | None) -> None:
    """Draw new groups; all groups again if the view has changed."""
    before = picture.box
    if extent is not None:
        picture.box, picture.fixed = extent, True
    elif not picture.fixed:
        picture.box = automatic_box([d.drawable for d in picture.drawn])
    box = picture.box
    if box is None:
        return
    changed = before is None or not np.array_equal(box, before)
    for drawn in picture.drawn:
        if changed or not drawn.artists:
            _draw_in(ax, drawn, box)
    axes_setup.show(ax, box, np.concatenate([d.positions for d in picture.drawn] or [np.empty((0, 3))]))


def _draw_in(ax: Axes3D, drawn: DrawnGroup, box: Box) -> None:
    """Replace the artists of a group by those for this view."""
    for artist in drawn.artists:
        artist.remove()
    parts = drawn.drawable.outline(box)
    drawn.artists = [a for part in parts if (a := _artist(ax, part, drawn.width)) is not None]
    positions = np.concatenate([part.positions.reshape(-1, 3) for part in parts])
    drawn.positions = axes_setup.subsample(positions[np.isfinite(positions).all(-1)])


# -- artists ---------------------------------------------------------------------------------------------------


def _artist(ax: Axes3D, part: Strokes | Faces | Marks, width: float) -> Any:
    """One collection for a whole group; None if nothing of it is in view."""
    art = matplotlib_import.collections()
    positions, colors = present(part.positions, part.colors)
    if not len(positions):
        return None
    artist: Any
    if isinstance(part, Marks):
        area = (MARK * width * part.size) ** 2
        artist = ax.scatter(*positions.T, s=area, c=colors, marker=part.marker, depthshade=False, linewidths=0)
    elif isinstance(part, Faces):
        artist = art.Poly3DCollection(positions, facecolors=colors, edgecolors="none")
    else:
        artist = art.Line3DCollection(positions, colors=colors, linewidths=width * part.width, capstyle="round")
    if not isinstance(part, Marks):
        ax.add_collection3d(artist)
    artist.set(zorder=ORDER[type(part)], clip_on=False)  # the view's box clips, not the rectangle of the axes
    return artist


def present(positions: Array, *rows: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    """Drop marks, polylines and polygons that are not in view at all, and their rows of colors and others."""
    visible = all_three(np.isfinite(positions))
    if positions.ndim > 2:
        visible = np.asarray(visible.any(-1))
    if visible.all():
        return positions, *rows
    return positions[visible], *(palette.take_rows(table, np.flatnonzero(visible)) for table in rows)
