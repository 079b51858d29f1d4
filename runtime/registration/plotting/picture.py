"""Pictures of registrations: the query before and after it is moved onto the reference, and the matches (figures 5.1
to 5.6). matplotlib is imported by the first picture.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ... import plot
from ...common.validation import as_instance
from ...core.multivector import Multivector
from ...errors import InputError
from ...plot import axes_setup, drawing, matplotlib_import, palette, style
from ...plot.glyphs import Faces, Marks, Strokes
from ..model.arguments import check_same_models
from ..model.model import Model
from ..model.parameters import PLURALS
from ..model.similarity import similarity
from ..result import Registration
from .glyphs import ModelSketch

if TYPE_CHECKING:
    from ...plot.matplotlib_import import Axes3D, Figure

Array = NDArray[Any]
BLACK, RED, BLUE, GREEN = palette.INK, palette.RED, palette.BLUE, palette.GREEN
PANELS = ("before", "after")
#: Sizes of pages with one panel and with two, in inches.
PAGES = {1: (8.0, 6.0), 2: (13.0, 6.2)}
#: Fraction of the page below the panels, for the title.
FOOT = 0.06
#: Widths of lines in points, for few objects and for many.
WIDTHS = (1.5, 0.5)
#: Number of objects up to which the first width is used.
FEW = 40
#: Number of objects from which the second width is used.
MANY = 600
#: Factor of the width of matched reference objects, which are under the query.
WIDER = 2.6
#: Factor of the width of the query.
NARROWER = 0.5
#: Largest number of objects of a model that are drawn; of more, every n-th is drawn.
MAX_DRAWN = 3000
#: A query further from the reference than this many sizes of both is drawn nearer.
FARTHEST = 4.0
#: Its distance in the picture, in these sizes.
NEARER = 2.0


def picture(
    result: Registration,
    query: Model,
    reference: Model,
    path: str | PathLike[str] | None = None,
    *,
    show: str | Sequence[str] = PANELS,
    title: str | None = None,
    view: tuple[float, float] = axes_setup.VIEW,
    dpi: float = axes_setup.DOTS_PER_INCH,
) -> Figure:
    """Draw a registration.

    Parameters
    ----------
    result : Registration
    query, reference : Model
        Models that were registered.
    path : optional
        File to save it to; the suffix selects the format.
    show : "before", "after", or both
        "before": the reference in black, the query where it stood in red. "after": the query moved (of a similarity,
        scaled too) in blue, over the reference, whose matched objects are green and the others black.
    title : str, optional
        Default: how many were matched, and whether it converged.
    view : (elevation, azimuth)
        Direction of the eye, in degrees.
    dpi : float

    Returns
    -------
    Figure
        Figure of matplotlib.

    Raises
    ------
    InputError
        If models and result do not belong together, or it cannot be written.
    MissingExtraError
        If matplotlib is not installed (extra `plot`).
    """
    panels = _panels(show)
    style.check_suffix(path)
    for name, value in (("query", query), ("reference", reference)):
        as_instance(value, f"the {name}", Model, "a reform.Model")
    check_same_models(result, query, reference)
    if not len(query) or not len(reference):
        raise InputError("an empty model has no picture.")
    stages = plot.panels(1, len(panels), view, PAGES[len(panels)])
    for ax, name in zip(stages, panels, strict=True):
        x, y, across, high = vars(ax)[axes_setup._HOME]
        vars(ax)[axes_setup._HOME] = (x, y + FOOT, across, high - FOOT)
        {"before": _before, "after": _after}[name](ax, result, query, reference)
    figure: Figure = stages[0].figure
    text = _title(result, query) if title is None else title
    figure.text(0.5, 0.02, text, ha="center", fontsize=11, color=palette.INK)
    if path is not None:
        axes_setup.save(path, figure, dpi)
    return figure


def draw_model(
    model: Model,
    ax: Axes3D | None = None,
    color: Any = BLACK,
    label: str | None = None,
    *,
    motor: Multivector | None = None,
    width: float | None = None,
) -> Axes3D:
    """Draw the objects of a model.

    Parameters
    ----------
    model : Model
    ax : Axes3D, optional
        Axes to draw into. Default: new axes.
    color
        A color for all, or a mapping of kinds (plural) to a color or a list with one for each object.
    label : str, optional
        An entry of the legend.
    motor : Multivector, optional
        Moves the model. What is drawn of lines and planes does not depend on it.
    width : float, optional
        Width of lines, in points.

    Returns
    -------
    Axes3D

    Raises
    ------
    InputError
        If it is not a model.
    """
    as_instance(model, "the model", Model, "a reform.Model")
    ax = plot.axes() if ax is None else ax
    if not len(model):
        return ax
    return _draw_sketch(ax, ModelSketch(model), color, label, _motion(motor), width)


# -- panels ----------------------------------------------------------------------------------------------------


def _before(ax: Axes3D, result: Registration, query: Model, reference: Model) -> None:
    here, there = ModelSketch(query), ModelSketch(reference)
    size = there.box.size + here.box.size
    gap = here.box.center - there.box.center
    distance = float(np.linalg.norm(gap))
    shift, far = np.zeros(3), ""
    if distance > FARTHEST * size:
        shift, far = gap * (NEARER * size / distance - 1), f", {distance:.4g} away, drawn nearer"
    _draw_sketch(ax, there, BLACK, f"reference ({len(reference)})")
    _draw_sketch(ax, here, RED, f"query where it stood ({len(query)}){far}", (np.eye(3), shift))


def _after(ax: Axes3D, result: Registration, query: Model, reference: Model) -> None:
    is_matched = {kind: np.zeros(n, bool) for kind, n in reference.counts.items()}
    for kind in is_matched:
        if kind in query.counts:
            rows = result.matches[kind]
            is_matched[kind][rows[rows >= 0]] = True
    matched = sum(int(x.sum()) for x in is_matched.values())
    there, width = ModelSketch(reference), _width(len(reference))
    for with_match, color, name, scale in ((False, BLACK, "without a match", 1.0), (True, GREEN, "matched", WIDER)):
        count = matched if with_match else len(reference) - matched
        if count:
            colors = {kind: _mask_colors(color, flags == with_match) for kind, flags in is_matched.items()}
            _draw_sketch(ax, there, colors, None, width=scale * width)
            _entry(ax, color, f"reference, {name} ({count})")
    here = ModelSketch(_scale_query(query, result.scale).transformed(result.motor))
    here.over(there, {kind: result.matches[kind] for kind in query.counts})
    inside = int(np.asarray(result.inliers).sum())
    moved = "moved" if result.scale == 1 else "scaled and moved"
    rest = f", {len(query) - inside} without a match" if inside < len(query) else ""
    _draw_sketch(ax, here, BLUE, f"query, {moved} ({len(query)}{rest})", None, NARROWER * width)


def _title(result: Registration, query: Model) -> str:
    count = int(np.asarray(result.inliers).sum())
    said = "converged" if result.converged else f"not converged: {result.message}" if result.message else "in doubt"
    scale = f"scale {result.scale:.6g}, " if result.scale != 1 else ""
    return f"{count} of {len(query)} objects matched, {scale}{said}"


def _scale_query(query: Model, scale: float) -> Model:
    """Query scaled by the scale of a similarity."""
    return query if scale == 1 else query.in_frame((0.0, 0.0, 0.0), 1 / scale)


# -- drawing ---------------------------------------------------------------------------------------------------


def _draw_sketch(
    ax: Axes3D, sketch: ModelSketch, color: Any, label: str | None, motion: Any = None, width: float | None = None
) -> Axes3D:
    """A sketch moved by a matrix and a shift."""
    model = sketch.model
    turn, shift = (np.eye(3), np.zeros(3)) if motion is None else motion
    width = _width(len(model)) if width is None else width
    step = max(1, -(-len(model) // MAX_DRAWN))
    colors = {}
    for kind, count in model.counts.items():
        color_of_kind = color.get(PLURALS[kind], color.get(kind, BLACK)) if isinstance(color, Mapping) else color
        colors[kind] = palette.per_item(color_of_kind, count, BLACK)
    for part in sketch.parts(colors):
        _artist(ax, part._replace(positions=part.positions @ turn.T + shift), width, step)
    if label:
        _entry(ax, next((c[0] for c in colors.values()), BLACK), label)
    return ax


def _artist(ax: Axes3D, part: Any, width: float, step: int) -> None:
    """A part that is not all transparent; of very many, some."""
    colors = np.broadcast_to(part.colors, (len(part.positions), 4))
    visible = np.flatnonzero(colors[:, 3] > 0)[::step]
    if not len(visible):
        return
    positions, colors = part.positions[visible], colors[visible]
    if isinstance(part, Strokes):
        drawing.paths(positions, ax, colors, width * part.width)
    elif isinstance(part, Marks):
        drawing.draw(positions, ax=ax, color=colors, size=width**0.5 * part.size)
    elif isinstance(part, Faces):
        polygons = matplotlib_import.collections().Poly3DCollection(positions, facecolors=colors, edgecolors="none")
        ax.add_collection3d(polygons)
        polygons.set(zorder=drawing.ORDER[Faces], clip_on=False)


def _entry(ax: Axes3D, color: Any, text: str) -> None:
    """A line of the legend."""
    axes_state = drawing.picture_of(ax)
    axes_state.handles.append(matplotlib_import.line_class()([], [], color=color, label=text))
    axes_setup.show_legend(ax, axes_state.handles)


def _width(count: int) -> float:
    """Width of lines: thinner for many objects."""
    share = (np.log(max(count, 1)) - np.log(FEW)) / (np.log(MANY) - np.log(FEW))
    return float(np.interp(share, (0, 1), WIDTHS))


def _mask_colors(color: str, flags: Array) -> Array:
    """A color for some, transparent for the others."""
    rows = np.tile(palette.per_item(color, 1, color), (len(flags), 1))
    rows[~flags, 3] = 0.0
    return rows


def _motion(motor: Multivector | None) -> tuple[Array, Array]:
    if motor is None:
        return np.eye(3), np.zeros(3)
    scale, rotation, translation = similarity(motor)
    return scale * rotation, translation


# -- arguments -------------------------------------------------------------------------------------------------


def _panels(show: Any) -> list[str]:
    names = [show] if isinstance(show, str) else list(show)
    if not names or len(names) > len(PANELS) or any(name not in PANELS for name in names):
        raise InputError(f"show is {show!r}; it is {PANELS[0]!r}, {PANELS[1]!r} or both.")
    return names
