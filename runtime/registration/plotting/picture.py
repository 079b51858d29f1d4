"""Pictures of registrations: the query where it stood and laid over the reference, and what was matched (figures 5.1
to 5.6). matplotlib is imported by the first picture.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import plot
from ..errors import InputError
from ..multivector import Multivector
from ..plot import backend, drawing, figures, pages, palette
from ..plot.outlines import Faces, Marks, Strokes
from .given import check_belongs
from .model import Model
from .parameters import PLURALS
from .result import Registration
from .similarities import similarity
from .sketch import Sketch

if TYPE_CHECKING:
    from ..plot.backend import Axes3D

Array = NDArray[Any]
BLACK, RED, BLUE, GREEN = palette.INK, palette.RED, palette.BLUE, palette.GREEN
PANELS = ("before", "after")
#: Inches of a page with one panel, and with two.
PAGES = {1: (8.0, 6.0), 2: (13.0, 6.2)}
#: Part of the page below the panels, for the title.
FOOT = 0.06
#: Widths of lines in points, for few objects and for many; matched ones, under the query, and the query, over that.
WIDTHS, FEW, MANY, WIDER, NARROWER = (1.5, 0.5), 40, 600, 2.6, 0.5
#: More objects of a model than this are not drawn: what is, is every so-manieth.
MOST = 3000
#: A query that stands further from the reference than so many times the size of both is drawn nearer.
FARTHEST, NEARER = 4.0, 2.0


def picture(
    result: Registration,
    query: Model,
    reference: Model,
    path: str | PathLike[str] | None = None,
    *,
    show: str | Sequence[str] = PANELS,
    title: str | None = None,
    view: tuple[float, float] = pages.VIEW,
    dpi: float = pages.DOTS_PER_INCH,
) -> Any:
    """Draw a registration.

    Parameters
    ----------
    result : Registration
    query, reference : Model
        As they were registered.
    path : optional
        Where to save it; the suffix says the format.
    show : "before", "after", or both
        "before": the reference in black, the query where it stood in red. "after": the query moved (of a similarity,
        scaled too) in blue, over the reference, whose matched objects are green and the others black.
    title : str, optional
        Default: how many were matched, and whether it converged.
    view : (elevation, azimuth)
        Where the eye is, in degrees.
    dpi : float

    Returns
    -------
    Figure
        Of matplotlib.

    Raises
    ------
    InputError
        If models and result do not belong together, or it cannot be saved under this name.
    OSError
        If it cannot be written.
    MissingExtraError
        If matplotlib is not installed (extra `plot`).
    """
    shown = _panels(show)
    if path is not None:
        figures.check_suffix(path)
    for name, value in (("query", query), ("reference", reference)):
        if value is None:
            raise InputError(f"the {name} is None; a reform.Model is needed.")
    check_belongs(result, query, reference)
    if not len(query) or not len(reference):
        raise InputError("an empty model has no picture.")
    stages = plot.panels(1, len(shown), view, PAGES[len(shown)])
    for ax, name in zip(stages, shown, strict=True):
        x, y, across, high = vars(ax)[pages._HOME]
        vars(ax)[pages._HOME] = (x, y + FOOT, across, high - FOOT)
        {"before": _before, "after": _after}[name](ax, result, query, reference)
    figure: Any = stages[0].figure
    text = _title(result, query) if title is None else title
    figure.text(0.5, 0.02, text, ha="center", fontsize=11, color=palette.INK)
    if path is not None:
        figures.write(path, figure, dpi)
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
        Where to draw; new axes by default.
    color
        A colour for all, or a mapping of kinds (plural) to a colour or a list with one for each object.
    label : str, optional
        An entry of the legend.
    motor : Multivector, optional
        Moves the model. What is drawn of lines and planes does not depend on it.
    width : float, optional
        Of lines, in points.

    Returns
    -------
    Axes3D

    Raises
    ------
    InputError
        If it is no model.
    """
    if not isinstance(model, Model):
        raise InputError(f"the model is a {type(model).__name__}; a reform.Model is needed.")
    ax = plot.axes() if ax is None else ax
    if not len(model):
        return ax
    return _drawn(ax, Sketch(model), color, label, _motion(motor), width)


# -- panels ----------------------------------------------------------------------------------------------------


def _before(ax: Axes3D, result: Registration, query: Model, reference: Model) -> None:
    here, there = Sketch(query), Sketch(reference)
    size = there.box.size + here.box.size
    gap = here.box.center - there.box.center
    distance = float(np.linalg.norm(gap))
    shift, far = np.zeros(3), ""
    if distance > FARTHEST * size:
        shift, far = gap * (NEARER * size / distance - 1), f", {distance:.4g} away, drawn nearer"
    _drawn(ax, there, BLACK, f"reference ({len(reference)})")
    _drawn(ax, here, RED, f"query where it stood ({len(query)}){far}", (np.eye(3), shift))


def _after(ax: Axes3D, result: Registration, query: Model, reference: Model) -> None:
    taken = {kind: np.zeros(n, bool) for kind, n in reference.counts.items()}
    for kind in taken:
        if kind in query.counts:
            rows = result.matches[kind]
            taken[kind][rows[rows >= 0]] = True
    matched = sum(int(x.sum()) for x in taken.values())
    there, width = Sketch(reference), _width(len(reference))
    for chosen, color, name, scale in ((False, BLACK, "without a match", 1.0), (True, GREEN, "matched", WIDER)):
        count = matched if chosen else len(reference) - matched
        if count:
            colors = {kind: _masked(color, flags == chosen) for kind, flags in taken.items()}
            _drawn(ax, there, colors, None, width=scale * width)
            _entry(ax, color, f"reference, {name} ({count})")
    here = Sketch(_scaled(query, result.scale).transformed(result.motor))
    here.over(there, {kind: result.matches[kind] for kind in query.counts})
    inside = int(np.asarray(result.inliers).sum())
    moved = "moved" if result.scale == 1 else "scaled and moved"
    rest = f", {len(query) - inside} without a match" if inside < len(query) else ""
    _drawn(ax, here, BLUE, f"query, {moved} ({len(query)}{rest})", None, NARROWER * width)


def _title(result: Registration, query: Model) -> str:
    count = int(np.asarray(result.inliers).sum())
    said = "converged" if result.converged else f"not converged: {result.message}" if result.message else "in doubt"
    scale = f"scale {result.scale:.6g}, " if result.scale != 1 else ""
    return f"{count} of {len(query)} objects matched, {scale}{said}"


def _scaled(query: Model, scale: float) -> Model:
    """What the motor of a similarity moves; of a motion, the query as it is."""
    return query if scale == 1 else query.in_frame((0.0, 0.0, 0.0), 1 / scale)


# -- drawing ---------------------------------------------------------------------------------------------------


def _drawn(
    ax: Axes3D, sketch: Sketch, color: Any, label: str | None, motion: Any = None, width: float | None = None
) -> Axes3D:
    """A sketch moved by a matrix and a shift."""
    model = sketch.model
    turn, shift = (np.eye(3), np.zeros(3)) if motion is None else motion
    width = _width(len(model)) if width is None else width
    step = max(1, -(-len(model) // MOST))
    colors = {}
    for kind, count in model.counts.items():
        own = color.get(PLURALS[kind], color.get(kind, BLACK)) if isinstance(color, Mapping) else color
        colors[kind] = palette.per_item(own, count, BLACK)
    for part in sketch.parts(colors):
        _artist(ax, part._replace(positions=part.positions @ turn.T + shift), width, step)
    if label:
        _entry(ax, next((c[0] for c in colors.values()), BLACK), label)
    return ax


def _artist(ax: Axes3D, part: Any, width: float, step: int) -> None:
    """A part that is not all transparent; of very many, some."""
    colors = np.broadcast_to(part.colors, (len(part.positions), 4))
    chosen = np.flatnonzero(colors[:, 3] > 0)[::step]
    if not len(chosen):
        return
    positions, colors = part.positions[chosen], colors[chosen]
    if isinstance(part, Strokes):
        drawing.paths(positions, ax, colors, width * part.width)
    elif isinstance(part, Marks):
        drawing.draw(positions, ax=ax, color=colors, size=width**0.5 * part.size)
    elif isinstance(part, Faces):
        polygons = backend.collections().Poly3DCollection(positions, facecolors=colors, edgecolors="none")
        ax.add_collection3d(polygons)
        polygons.set(zorder=drawing.ORDER[Faces], clip_on=False)


def _entry(ax: Axes3D, color: Any, text: str) -> None:
    """A line of the legend."""
    shown = drawing.picture_of(ax)
    shown.handles.append(backend.line_class()([], [], color=color, label=text))
    pages.show_legend(ax, shown.handles)


def _width(count: int) -> float:
    """Of lines: thinner where there are many."""
    share = (np.log(max(count, 1)) - np.log(FEW)) / (np.log(MANY) - np.log(FEW))
    return float(np.interp(share, (0, 1), WIDTHS))


def _masked(color: str, flags: Array) -> Array:
    """A colour for some, nothing for the others."""
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


__all__ = ["draw_model", "picture"]
