"""`draw`: objects to artists. Axes keep what was drawn on them, so that lines and planes fit the view as it grows."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..errors import InputError
from . import backend, checks, pages, palette
from .outlines import Drawable, Faces, Marks, Strokes
from .shapes import Array, Box
from .things import Group, Sorted, sorted_out
from .views import automatic_box, given_box

if TYPE_CHECKING:
    from .backend import Axes3D

#: Width of lines in points (1/72 inch); of those in large sets; and diameters of points over it.
WIDTH, THIN, MANY, MARK = 1.6, 0.8, 40, 3.2
#: Objects along each segment of a curve.
MOST_SAMPLES = 100_000
#: Points are drawn over lines, and those over surfaces.
ORDER = {Faces: 1, Strokes: 2, Marks: 3}
#: Where the state of a picture is kept on its axes.
_KEY = "_bladesmith_picture"


@dataclass
class Drawn:
    """A group on the page: its artists, and where some of their positions are."""

    drawable: Drawable
    width: float
    artists: list[Any] = field(default_factory=list)
    positions: Array = field(default_factory=lambda: np.empty((0, 3)))


@dataclass
class Picture:
    """What stands on one axes."""

    box: Box | None = None
    fixed: bool = False
    drawn: list[Drawn] = field(default_factory=list)
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
        Where to draw; new axes by default. Limits then hold what was drawn before, too.
    color
        A colour for all; a list with one per thing; for a single thing also one per item: integers are classes,
        other numbers a parameter from green to red, rows RGB. Curves go from green to red by default.
    label : str or list of str
        Entries of the legend.
    extent : number, or (low, high)
        The view: a cube about the origin with this half side, or corners (numbers or triples). By default it holds
        everything finite, and where lines and planes come nearest to that, or to each other.
    size : float
        Width of lines in points; points are some three times as wide.
    opacity : float
        Of everything drawn.
    orientation : bool
        Arrows for the orientation of point pairs, lines, circles, planes and spheres.
    surface : bool
        Spheres and planes as translucent surfaces, or as wires only.
    samples : int
        Objects drawn along each segment of a curve.
    view : (elevation, azimuth)
        Where the eye is, in degrees.

    Returns
    -------
    Axes3D
        Of matplotlib, to go on with. What had no picture (imaginary, NaN, no blade) is counted by `skipped`.

    Raises
    ------
    InputError
        If there is nothing to draw, a thing is no object, or a colour does not fit.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not things:
        raise InputError("there is nothing to draw.", remedy="Give objects, curves or positions")
    size = None if size is None else checks.positive(size, "size")
    samples = None if samples is None else checks.whole(samples, "samples", 1, MOST_SAMPLES)
    opacity = checks.fraction(opacity, "opacity")
    view = None if view is None else checks.pair(view, "view")
    box = None if extent is None else given_box(extent)
    found = [sorted_out(thing, samples) for thing in things]
    ax = pages.axes() if ax is None else ax
    picture = picture_of(ax)
    orientation, surface = truth(orientation, "orientation"), truth(surface, "surface")
    colors, labels = _for_each(color, len(things), "color"), _for_each(label, len(things), "label")
    first = picture.things
    for number, (part, own, text) in enumerate(zip(found, colors, labels, strict=True)):
        default = palette.SERIES[(first + number) % len(palette.SERIES)]
        rows = palette.per_item(part.values if own is None and part.values is not None else own, part.count, default)
        rows = palette.faded(rows, opacity)
        width = size or (WIDTH if part.count <= MANY else THIN)
        _add(picture, part, rows, width, orientation, surface)
        if text:
            picture.handles.append(_handle(part, rows[0] if len(rows) else default, text))
    picture.things += len(things)
    if view is not None:
        ax.view_init(*view)
    _show(ax, picture, box)
    if picture.handles:
        pages.show_legend(ax, picture.handles)
    return ax


def skipped(ax: Axes3D) -> dict[str, int]:
    """How many items that were to be drawn have no picture, by what they are: "IMAGINARY", "imaginary circle", ..."""
    return dict(picture_of(ax).skipped)


def picture_of(ax: Axes3D) -> Picture:
    """The state of a picture; limits that its owner set before the first object stay in view.

    Raises
    ------
    InputError
        If these are no 3D axes.
    """
    if not isinstance(ax, backend.axes_class()):
        raise InputError(f"ax is a {type(ax).__name__}; 3D axes are needed.", remedy="Use plot.axes()")
    state = vars(ax)
    if _KEY not in state:
        state[_KEY] = Picture()
    picture: Picture = state[_KEY]
    return picture


def _for_each(value: Any, count: int, name: str) -> list[Any]:
    """One value per thing; a list is that only where there are several things."""
    if name == "label" and isinstance(value, tuple):
        value = list(value)
    if count == 1 and name == "color" or not isinstance(value, list):
        return [value] + [value if name == "color" else None] * (count - 1)
    if len(value) != count:
        raise InputError(f"{name} has {len(value)} entries for {count} things.")
    return list(value)


def _handle(part: Sorted, color: Any, text: str) -> Any:
    """An entry of the legend: a dot for points, a line for all else."""
    dots = all(group.sort in ("point", "flat_point") for group in part.groups)
    style = {"marker": "o", "linestyle": "none", "markersize": 5} if dots else {}
    return backend.line_class()([], [], color=color, label=text, **style)


def _add(picture: Picture, part: Sorted, rows: palette.Rgba, width: float, orientation: bool, surface: bool) -> None:
    for group in part.groups:
        drawable = Drawable(group, palette.chosen(rows, group.places), orientation, surface)
        picture.drawn.append(Drawn(drawable, width))
    picture.skipped += part.skipped


def paths(
    positions: Any, ax: Axes3D | None = None, color: Any = None, size: float | None = None, extent: Any = None
) -> Axes3D:
    """Draw polylines: trajectories, edges of a mesh, orbits; all of them as one collection.

    Parameters
    ----------
    positions : array (n, m, 3) or (m, 3)
        Corners; a NaN breaks the line, and so does what is further away than 1e100.
    ax, color, size, extent
        As for `draw`; a colour for all or one per polyline.

    Raises
    ------
    InputError
        If these are no positions, or another argument is none of its kind.
    """
    corners = checks.numbers(positions, "positions")
    if corners.ndim not in (2, 3) or corners.shape[-1] != 3:
        raise InputError(f"an array of shape {corners.shape} holds no polylines: those are (n, m, 3) or (m, 3).")
    size = None if size is None else checks.positive(size, "size")
    box = None if extent is None else given_box(extent)
    corners = corners[None] if corners.ndim == 2 else corners
    corners = np.where(np.abs(corners) <= checks.FARTHEST, corners, np.nan)
    ax = pages.axes() if ax is None else ax
    picture = picture_of(ax)
    rows = palette.per_item(color, len(corners), palette.SERIES[picture.things % len(palette.SERIES)])
    width = size or (WIDTH if len(corners) <= MANY else THIN)
    if corners.size:
        group = Group("path", (corners,), np.arange(len(corners)))
        picture.drawn.append(Drawn(Drawable(group, rows), width))
    picture.things += 1
    _show(ax, picture, box)
    return ax


# -- the view --------------------------------------------------------------------------------------------------


def _show(ax: Axes3D, picture: Picture, given: Box | None) -> None:
    """Draw what is new; all of it again if the view has changed."""
    before = picture.box
    if given is not None:
        picture.box, picture.fixed = given, True
    elif not picture.fixed:
        picture.box = automatic_box([d.drawable for d in picture.drawn])
    box = picture.box
    if box is None:
        return
    changed = before is None or not np.array_equal(box, before)
    for drawn in picture.drawn:
        if changed or not drawn.artists:
            _draw_in(ax, drawn, box)
    pages.show(ax, box, np.concatenate([d.positions for d in picture.drawn] or [np.empty((0, 3))]))


def _draw_in(ax: Axes3D, drawn: Drawn, box: Box) -> None:
    """Make the artists of a group for this view, in the place of those that it had."""
    for artist in drawn.artists:
        artist.remove()
    parts = drawn.drawable.outline(box)
    drawn.artists = [a for part in parts if (a := _artist(ax, part, drawn.width)) is not None]
    found = np.concatenate([part.positions.reshape(-1, 3) for part in parts])
    drawn.positions = pages.some(found[np.isfinite(found).all(-1)])


# -- artists ---------------------------------------------------------------------------------------------------


def _artist(ax: Axes3D, part: Strokes | Faces | Marks, width: float) -> Any:
    """One collection for a whole group; None where nothing of it is in view."""
    art = backend.collections()
    positions, colors = _present(part.positions, part.colors)
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
    artist.set(zorder=ORDER[type(part)], clip_on=False)  # the view's box cuts, not the square that the axes are
    return artist


def _present(positions: Array, colors: palette.Rgba) -> tuple[Array, NDArray[Any]]:
    """Without the marks, polylines and polygons that are not in view at all."""
    seen = np.isfinite(positions).all(-1)
    if positions.ndim > 2:
        seen = seen.any(-1)
    return (positions, colors) if seen.all() else (positions[seen], palette.chosen(colors, np.flatnonzero(seen)))
