"""Shared style of the pictures of dynamics, kinematics and registration: shaded faces, panels of curves, files.

matplotlib is imported by the first picture.
"""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.files import as_path
from ..errors import InputError
from . import axes_setup, drawing, matplotlib_import, palette
from .glyphs import LIGHT, SHADE

Array = NDArray[Any]

# -- files -----------------------------------------------------------------------------------------------------


def check_suffix(path: str | PathLike[str] | None) -> None:
    """Check before drawing that the suffix of a path, if there is one, is a format of pictures.

    Raises
    ------
    InputError
        If matplotlib does not know the suffix.
    MissingExtraError
        If matplotlib is not installed.
    """
    if path is None:
        return
    formats = matplotlib_import.figure_class()().canvas.get_supported_filetypes()
    suffix = as_path(path, "a picture is written to").suffix.removeprefix(".").lower()
    if suffix not in formats:
        what = (
            f"{suffix!r} is not a format of pictures"
            if suffix
            else "the path has no suffix, which is the picture's format"
        )
        raise InputError(f"{what}.", where=str(path), remedy=f"Use one of {', '.join(sorted(formats))}")


# -- parts of pictures -----------------------------------------------------------------------------------------


def plain(text: str) -> str:
    """Escape a text so that matplotlib does not parse it as a formula."""
    return text.replace("$", r"\$")


def show_title(ax: Any, title: str) -> None:
    """Show a title in the upper right corner of the page."""
    ax.figure.text(0.98, 0.965, plain(title), ha="right", fontsize=10, color=palette.INK)


def finish_picture(
    ax: Any, names: Iterable[tuple[str, str]], title: str, path: str | PathLike[str] | None, dpi: float,
    linewidth: float | None = None,
) -> None:  # fmt: skip
    """Add a legend, of names with colors and what was drawn with a label, and a title; save the picture to a path."""
    new, handles = matplotlib_import.line_class(), drawing.picture_of(ax).handles
    handles.extend(new([], [], color=color, linewidth=linewidth, label=plain(name)) for name, color in names)
    if handles:
        axes_setup.show_legend(ax, handles)
    if title:
        show_title(ax, title)
    if path is not None:
        axes_setup.save(path, ax, dpi)


def uniform_rows(color: str, count: int, opacity: float) -> Array:
    """Repeat one color as rows of RGBA."""
    return np.tile(palette.with_opacity(palette.per_item(color, 1, color), opacity), (count, 1))


def surface(triangles: Array, color: str, opacity: float) -> Any:
    """Make a collection of shaded triangles (f, 3, 3)."""
    collection = matplotlib_import.collections().Poly3DCollection(triangles, edgecolors="none", linewidths=0)
    collection.set_facecolor(shade_triangles(triangles, color, opacity))
    return collection


def shade_triangles(triangles: Array, color: str, opacity: float) -> Array:
    """Color of each triangle: brighter where it faces the light."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, sizes, out=np.zeros_like(normals), where=sizes > 0)
    bright = SHADE + (1 - SHADE) * (1 + normals @ LIGHT) / 2
    rows = uniform_rows(color, len(triangles), 1.0)
    rows[:, :3] *= bright[:, None]
    rows[:, 3] = opacity
    return rows


def add_surface(ax: Any, triangles: Array, color: str, opacity: float) -> None:
    """Add shaded triangles (f, 3, 3) to axes."""
    faces = surface(triangles, color, opacity)
    ax.add_collection3d(faces)
    faces.set(clip_on=False)


def add_plate(ax: Any, corners: Array, color: str, inside: float, edges: float, width: float, box: Any) -> None:
    """Add a convex polygon with corners (n, 3): a face of opacity ``inside`` within edges of opacity ``edges``."""
    middle = np.broadcast_to(corners.mean(0), corners.shape)
    add_surface(ax, np.stack([middle, corners, np.roll(corners, -1, 0)], 1), color, inside)
    drawing.paths(np.concatenate([corners, corners[:1]]), ax, uniform_rows(color, 1, edges), width, box)


# -- curves over time ------------------------------------------------------------------------------------------


def dress_panel(ax: Any, title: str) -> None:
    """Style a panel of curves: title on the left, grid behind, axes on two sides."""
    ax.set_title(title, fontsize=9.5, color=palette.INK, loc="left")
    ax.tick_params(which="both", labelsize=8, colors=palette.GREY)
    ax.grid(color=palette.PALE, linewidth=0.8)
    ax.set_axisbelow(True)
    ax.margins(x=0.01)
    for name, spine in ax.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(palette.GREY)


def show_curve_names(ax: Any) -> None:
    """Show a legend in one row, above the panel on the right."""
    ax.legend(fontsize=8, ncols=3, frameon=False, loc="lower right", bbox_to_anchor=(1.0, 0.98), borderaxespad=0,
              handlelength=1.2, columnspacing=1.0, labelcolor=palette.INK)  # fmt: skip
