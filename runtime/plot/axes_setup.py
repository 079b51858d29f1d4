"""3D axes with equal units in all directions, page layout and saving. Without pyplot: no global state changes."""

from __future__ import annotations

from functools import partial
from io import BytesIO
from os import PathLike
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..common.files import as_path, failures_named, replacing_by_suffix
from ..common.validation import as_bool, as_instance, as_int, as_pair, positive_float, short_repr
from ..errors import InputError
from . import matplotlib_import, palette
from .tessellation import CORNERS, Array, Box

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .matplotlib_import import Axes3D

Picture = TypeVar("Picture")
#: Default elevation and azimuth of the view, in degrees.
VIEW = (22.0, -58.0)
#: Default size of a page in inches.
PAGE = (8.0, 6.0)
#: Default resolution of a saved picture: 800 x 600 pixels.
DOTS_PER_INCH = 100
#: Margin around the box with coordinates, as a fraction of the page.
LABELLED_MARGIN = 0.075
#: Margin around the box without coordinates.
BARE_MARGIN = 0.04
#: Largest number of panels along a side of a page.
MOST_PANELS = 100
#: Largest number of ticks along an axis.
MOST_TICKS = 5
#: Iterations of the zoom: the perspective of the box depends on it.
ROUNDS = 4
#: Largest number of positions that determine the extent of a drawing on the page.
ENOUGH = 20_000
#: Attribute of axes: their rectangle on the page.
_HOME = "_bladesmith_home"
#: Attribute of axes: positions of drawn objects.
_SHOWN = "_bladesmith_shown"


def axes(view: tuple[float, float] = VIEW, size: tuple[float, float] = PAGE, frame: bool = True) -> Axes3D:
    """Create empty 3D axes on a figure of their own.

    Parameters
    ----------
    view : (elevation, azimuth)
        Direction of the view, in degrees.
    size : (width, height)
        Size of the figure, in inches.
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
    """Create several empty 3D axes on one figure, row by row; arguments as for `axes`.

    Raises
    ------
    InputError
        If a number of panels, the view or the size is not valid.
    MissingExtraError
    """
    rows, columns = (
        as_int(n, f"{side} of panels", 1, MOST_PANELS) for n, side in ((rows, "rows"), (columns, "columns"))
    )
    width, height = as_pair(size, "size")
    size = positive_float(width, "size[0]"), positive_float(height, "size[1]")
    matplotlib_import.axes_class()  # makes the projection known
    figure = new_figure(figsize=size, dpi=DOTS_PER_INCH)
    rectangles = [(j / columns, 1 - (i + 1) / rows, 1 / columns, 1 / rows) for i in range(rows) for j in range(columns)]
    all_axes = [figure.add_axes(rectangle, projection="3d") for rectangle in rectangles]
    for ax, rectangle in zip(all_axes, rectangles, strict=True):
        vars(ax)[_HOME] = rectangle
        _style_axes(_shown_in_notebooks(ax), view, frame)
    return all_axes


def new_figure(**options: Any) -> Figure:
    """A figure without pyplot, which notebooks show all the same; options of matplotlib's `Figure`."""
    dpi = positive_float(options.pop("dpi", DOTS_PER_INCH), "dpi")
    return _shown_in_notebooks(matplotlib_import.figure_class()(dpi=dpi, **options))


def _shown_in_notebooks(picture: Picture) -> Picture:
    vars(picture)["_repr_png_"] = partial(_png, picture)
    return picture


def _png(picture: Axes3D | Figure) -> bytes:
    file = BytesIO()
    save(file, picture)  # type: ignore[arg-type]
    return file.getvalue()


def _style_axes(ax: Axes3D, view: tuple[float, float], frame: bool) -> None:
    ax.view_init(*as_pair(view, "view"))
    ax.computed_zorder = False  # surfaces first, then lines, then points, each in the order in which they are drawn
    ax.patch.set_visible(False)  # it would cover adjacent axes
    if not as_bool(frame, "frame"):
        ax.set_axis_off()
        return
    axis: Any
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_pane_color(matplotlib_import.colors().to_rgba(palette.PALE, 0.35))
        axis.line.set_color(palette.GREY)
        axis._axinfo["grid"].update(color="#d5dbe0", linewidth=0.6)
        axis.set_major_locator(matplotlib_import.load_module("matplotlib.ticker").MaxNLocator(MOST_TICKS, prune="both"))
        axis.set_tick_params(labelsize=8, labelcolor=palette.GREY, color=palette.GREY)


def show(ax: Axes3D, box: Box, positions: Array) -> None:
    """Set the limits to a box, with equal units; fill the page with the box, or with the positions if it is hidden."""
    for setter, low, high in zip((ax.set_xlim3d, ax.set_ylim3d, ax.set_zlim3d), box.low, box.high, strict=True):
        setter(float(low), float(high))
    vars(ax)[_SHOWN] = subsample(positions)
    fill_page(ax)


def subsample(positions: Array) -> Array:
    """Subsample positions; the rest suffices for the extent on the page."""
    return positions[:: max(1, len(positions) // ENOUGH)]


def fill_page(ax: Axes3D) -> None:
    """Scale the visible content to the rectangle of the axes; center it on axes created here."""
    figure: Any = ax.get_figure()
    home = vars(ax).get(_HOME)
    limits = np.array([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()])
    sides = limits[:, 1] - limits[:, 0]
    framed = bool(getattr(ax, "_axis3don", True))
    content = limits[:, 0] + CORNERS * sides
    if not framed and len(vars(ax).get(_SHOWN, ())):
        content = vars(ax)[_SHOWN]
    rectangle = home if home is not None else ax.get_position(original=True).bounds
    page = np.array([figure.bbox.width, figure.bbox.height])
    available = page * rectangle[2:] * (1 - 2 * (LABELLED_MARGIN if framed else BARE_MARGIN))
    if home is not None:
        ax.set_position(home)
    zoom, project = 1.0, matplotlib_import.load_module("mpl_toolkits.mplot3d.proj3d").proj_transform
    for _ in range(ROUNDS):
        ax.set_box_aspect(tuple(np.abs(sides) / np.abs(sides).max()), zoom=zoom)
        ax.apply_aspect()
        x, y, _ = project(*content.T, ax.get_proj())
        pixels = ax.transData.transform(np.stack([x, y], -1))
        zoom *= float((available / np.maximum(np.ptp(pixels, axis=0), 1)).min())
    if home is not None:
        aside = (np.array(rectangle[:2]) + np.array(rectangle[2:]) / 2) - (pixels.max(0) + pixels.min(0)) / 2 / page
        ax.set_position((rectangle[0] + float(aside[0]), rectangle[1] + float(aside[1]), *rectangle[2:]))


def show_legend(ax: Axes3D, handles: list[Any]) -> None:
    """Show a legend in the upper left corner of the page, or of axes that share it."""
    figure: Any = ax.get_figure()
    x, y, _, height = vars(ax).get(_HOME, ax.get_position(original=True).bounds)
    corner = {"bbox_to_anchor": (x + 0.01, y + height - 0.01), "bbox_transform": figure.transSubfigure}
    ax.legend(handles=handles, loc="upper left", frameon=False, labelcolor=palette.INK, **corner)


def save(path: str | PathLike[str], picture: Axes3D | Figure, dpi: float = DOTS_PER_INCH) -> None:
    """Write a picture, whole or not at all; the format is the file's suffix.

    Parameters
    ----------
    path
        Name of the file, as ``"interpolation.png"``; its folder must exist.
    picture
        Axes, or a figure.
    dpi : float
        Dots per inch of the figure's size.

    Raises
    ------
    InputError
        If the picture is not valid, ``dpi`` is not positive, matplotlib does not know the suffix, or the file cannot
        be written.
    """
    figure: Any = getattr(picture, "figure", picture)
    remedy = "Give the axes that draw() returned"
    as_instance(figure, "picture", matplotlib_import.figure_class(), "one of axes or a figure", remedy=remedy)
    file = None if hasattr(path, "write") else as_path(path, "a picture is written to")
    if file is not None and not file.name:
        raise InputError(f"path is {short_repr(path)}; the name of a file is needed.")
    dpi = positive_float(dpi, "dpi")
    for ax in figure.axes:
        if _HOME in vars(ax):
            fill_page(ax)  # its view may have changed
    try:
        if file is None:
            figure.savefig(path, dpi=dpi)
            return
        if not file.suffix:
            file = file.with_name(f"{file.name}.{figure.canvas.get_default_filetype()}")
        with failures_named(file), replacing_by_suffix(file) as temporary:
            figure.savefig(temporary, dpi=dpi)
    except ValueError as error:
        raise error if isinstance(error, InputError) else InputError(f"{error}.", where=str(path)) from None
