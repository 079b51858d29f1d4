"""Axes to draw on, with equal units in all directions, and files to save to. No pyplot: nothing global is touched."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import truth
from ..errors import InputError
from . import backend, checks, palette
from .shapes import CORNERS, Array, Box

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .backend import Axes3D

#: Elevation and azimuth of the eye, in degrees.
VIEW = (22.0, -58.0)
#: Inches, and dots per inch when saved: 800 x 600.
PAGE, DOTS_PER_INCH = (8.0, 6.0), 100
#: Part of the page left free around the box, with coordinates and without.
LABELLED_MARGIN, BARE_MARGIN = 0.075, 0.04
#: Panels along a side of a page.
MOST_PANELS = 100
#: Labelled steps along an axis.
MOST_TICKS = 5
#: The box is placed in rounds: nearer, its perspective changes a little.
ROUNDS = 4
#: Positions by which it is judged how large something is on the page.
ENOUGH = 20_000
#: Kept on axes: the part of the page that they were given, and positions of what is drawn.
_HOME, _SHOWN = "_bladesmith_home", "_bladesmith_shown"


def axes(view: tuple[float, float] = VIEW, size: tuple[float, float] = PAGE, frame: bool = True) -> Axes3D:
    """Empty 3D axes on a figure of their own.

    Parameters
    ----------
    view : (elevation, azimuth)
        Where the eye is, in degrees.
    size : (width, height)
        Of the figure, in inches.
    frame : bool
        Draw the box of coordinates behind the objects.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    return panels(1, 1, view, size, frame)[0]


def panels(
    rows: int,
    columns: int,
    view: tuple[float, float] = VIEW,
    size: tuple[float, float] = PAGE,
    frame: bool = True,
) -> list[Axes3D]:
    """Several empty 3D axes on one figure, row by row; arguments as for `axes`.

    Raises
    ------
    InputError
        For numbers of panels, a view or a size that are none.
    MissingExtraError
    """
    rows, columns = (
        checks.whole(n, f"{side} of panels", 1, MOST_PANELS) for n, side in ((rows, "rows"), (columns, "columns"))
    )
    size = checks.pair(size, "size")
    if not min(size) > 0:
        raise InputError(f"size is {size}; a page has a positive width and height.")
    backend.axes_class()  # makes the projection known
    figure = backend.figure_class()(figsize=size, dpi=DOTS_PER_INCH)
    places = [(j / columns, 1 - (i + 1) / rows, 1 / columns, 1 / rows) for i in range(rows) for j in range(columns)]
    made = [figure.add_axes(place, projection="3d") for place in places]
    for ax, place in zip(made, places, strict=True):
        vars(ax)[_HOME] = place
        _dress(ax, view, frame)
    return made


def _dress(ax: Axes3D, view: tuple[float, float], frame: bool) -> None:
    ax.view_init(*checks.pair(view, "view"))
    ax.computed_zorder = False  # surfaces first, then lines, then points, each in the order in which they are drawn
    ax.patch.set_visible(False)  # it would cover what its neighbours draw
    if not truth(frame, "frame"):
        ax.set_axis_off()
        return
    axis: Any
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_pane_color(backend.colors().to_rgba(palette.PALE, 0.35))
        axis.line.set_color(palette.GREY)
        axis._axinfo["grid"].update(color="#d5dbe0", linewidth=0.6)
        axis.set_major_locator(backend.imported("matplotlib.ticker").MaxNLocator(MOST_TICKS, prune="both"))
        axis.set_tick_params(labelsize=8, labelcolor=palette.GREY, color=palette.GREY)


def show(ax: Axes3D, box: Box, positions: Array) -> None:
    """Limits of a box, with equal units; the page filled with it, or with the positions where it is not drawn."""
    for setter, low, high in zip((ax.set_xlim3d, ax.set_ylim3d, ax.set_zlim3d), box.low, box.high, strict=True):
        setter(float(low), float(high))
    vars(ax)[_SHOWN] = some(positions)
    fill_page(ax)


def some(positions: Array) -> Array:
    """Enough of many positions to judge how large something is on the page."""
    return positions[:: max(1, len(positions) // ENOUGH)]


def fill_page(ax: Axes3D) -> None:
    """Scale what is seen to the part of the figure that the axes were given; and centre it on axes of our own."""
    figure: Any = ax.get_figure()
    home = vars(ax).get(_HOME)
    limits = np.array([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()])
    sides = limits[:, 1] - limits[:, 0]
    framed = bool(getattr(ax, "_axis3don", True))
    shown = limits[:, 0] + CORNERS * sides
    if not framed and len(vars(ax).get(_SHOWN, ())):
        shown = vars(ax)[_SHOWN]
    place = home if home is not None else ax.get_position(original=True).bounds
    page = np.array([figure.bbox.width, figure.bbox.height])
    room = page * place[2:] * (1 - 2 * (LABELLED_MARGIN if framed else BARE_MARGIN))
    if home is not None:
        ax.set_position(home)
    zoom, project = 1.0, backend.imported("mpl_toolkits.mplot3d.proj3d").proj_transform
    for _ in range(ROUNDS):
        ax.set_box_aspect(tuple(np.abs(sides) / np.abs(sides).max()), zoom=zoom)
        ax.apply_aspect()
        x, y, _ = project(*shown.T, ax.get_proj())
        pixels = ax.transData.transform(np.stack([x, y], -1))
        zoom *= float((room / np.maximum(np.ptp(pixels, axis=0), 1)).min())
    if home is not None:
        aside = (np.array(place[:2]) + np.array(place[2:]) / 2) - (pixels.max(0) + pixels.min(0)) / 2 / page
        ax.set_position((place[0] + float(aside[0]), place[1] + float(aside[1]), place[2], place[3]))


def show_legend(ax: Axes3D, handles: list[Any]) -> None:
    """In the upper left corner of the page, or of axes that share it."""
    figure: Any = ax.get_figure()
    x, y, _, height = vars(ax).get(_HOME, ax.get_position(original=True).bounds)
    corner = {"bbox_to_anchor": (x + 0.01, y + height - 0.01), "bbox_transform": figure.transSubfigure}
    ax.legend(handles=handles, loc="upper left", frameon=False, labelcolor=palette.INK, **corner)


def save(path: str | PathLike[str], picture: Axes3D | Figure, dpi: float = DOTS_PER_INCH) -> None:
    """Write a picture; the format is the file's suffix.

    Parameters
    ----------
    path
        Such as ``"interpolation.png"``; its folder must exist.
    picture
        Axes, or a figure.
    dpi : float
        Dots per inch of the figure's size.

    Raises
    ------
    InputError
        If the picture is none, ``dpi`` is not positive, or matplotlib does not know the suffix.
    OSError
        If the file cannot be written.
    """
    figure: Any = getattr(picture, "figure", picture)
    if not isinstance(figure, backend.figure_class()):
        raise InputError(f"a {type(picture).__name__} is no picture.", remedy="Give the axes that draw() returned")
    if not isinstance(path, str | PathLike) and not hasattr(path, "write"):
        raise InputError(f"path is a {type(path).__name__}; the name of a file is needed.")
    dpi = checks.positive(dpi, "dpi")
    for ax in figure.axes:
        if _HOME in vars(ax):
            fill_page(ax)  # it may have been turned
    try:
        figure.savefig(path, dpi=dpi)
    except ValueError as error:
        raise InputError(f"{path}: {error}.") from None
