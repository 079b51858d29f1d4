"""What pictures of dynamics, kinematics and registrations share: shaded faces, panels of curves, whole files.

matplotlib is imported by the first picture.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..files import failures_named, replacing_by_suffix
from . import backend, drawing, pages, palette
from .outlines import LIGHT, SHADE

Array = NDArray[Any]

# -- files -----------------------------------------------------------------------------------------------------


def check_suffix(path: str | PathLike[str]) -> None:
    """Refuse a name that no picture can be saved under, before there is one.

    Raises
    ------
    InputError
        If matplotlib does not know the suffix.
    MissingExtraError
        If matplotlib is not installed.
    """
    known = backend.figure_class()().canvas.get_supported_filetypes()
    suffix = Path(path).suffix.removeprefix(".").lower()
    if suffix not in known:
        what = (
            f"{suffix!r} is no format of pictures" if suffix else "a picture's format is its suffix, and there is none"
        )
        raise InputError(f"{what}.", where=str(path), remedy=f"Use one of {', '.join(sorted(known))}")


def write(path: str | PathLike[str], figure: Any, dpi: float = pages.DOTS_PER_INCH) -> None:
    """Write a picture, whole or not at all.

    Raises
    ------
    InputError
        If matplotlib does not know the suffix.
    OSError
        If it cannot be written.
    """
    with replacing_by_suffix(Path(path)) as temporary:
        pages.save(temporary, figure, dpi)


def save(path: str | PathLike[str], figure: Any, dpi: float = pages.DOTS_PER_INCH) -> None:
    """Write a picture, whole or not at all.

    Raises
    ------
    InputError
        If matplotlib does not know the suffix, or it cannot be written.
    """
    with failures_named(path):
        write(path, figure, dpi)


# -- parts of pictures -----------------------------------------------------------------------------------------


def plain(text: str) -> str:
    """A text that matplotlib takes for no formula."""
    return text.replace("$", r"\$")


def show_title(ax: Any, title: str) -> None:
    """A title in the upper right corner of the page."""
    ax.figure.text(0.98, 0.965, plain(title), ha="right", fontsize=10, color=palette.INK)


def faded(color: str, count: int, opacity: float) -> Array:
    """Rows of one colour."""
    return np.tile(palette.faded(palette.per_item(color, 1, color), opacity), (count, 1))


def surface(triangles: Array, color: str, opacity: float) -> Any:
    """A collection of shaded triangles (f, 3, 3)."""
    made = backend.collections().Poly3DCollection(triangles, edgecolors="none", linewidths=0)
    made.set_facecolor(shaded(triangles, color, opacity))
    return made


def shaded(triangles: Array, color: str, opacity: float) -> Array:
    """A colour for each triangle: what faces the light is brighter."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, sizes, out=np.zeros_like(normals), where=sizes > 0)
    bright = SHADE + (1 - SHADE) * (1 + normals @ LIGHT) / 2
    rows = faded(color, len(triangles), 1.0)
    rows[:, :3] *= bright[:, None]
    rows[:, 3] = opacity
    return rows


def add_surface(ax: Any, triangles: Array, color: str, opacity: float) -> None:
    """Shaded triangles (f, 3, 3) on axes."""
    faces = surface(triangles, color, opacity)
    ax.add_collection3d(faces)
    faces.set(clip_on=False)


def add_plate(ax: Any, corners: Array, color: str, inside: float, edges: float, width: float, box: Any) -> None:
    """A convex polygon with corners (n, 3): a face of opacity ``inside`` within edges of opacity ``edges``."""
    middle = np.broadcast_to(corners.mean(0), corners.shape)
    add_surface(ax, np.stack([middle, corners, np.roll(corners, -1, 0)], 1), color, inside)
    drawing.paths(np.concatenate([corners, corners[:1]]), ax, faded(color, 1, edges), width, box)


# -- curves over time ------------------------------------------------------------------------------------------


def dress_panel(ax: Any, title: str) -> None:
    """A panel of curves: a title on the left, a grid behind, axes on two sides."""
    ax.set_title(title, fontsize=9.5, color=palette.INK, loc="left")
    ax.tick_params(which="both", labelsize=8, colors=palette.GREY)
    ax.grid(color=palette.PALE, linewidth=0.8)
    ax.set_axisbelow(True)
    ax.margins(x=0.01)
    for name, spine in ax.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(palette.GREY)


def show_curve_names(ax: Any) -> None:
    """A legend in one row, above the panel on the right."""
    ax.legend(fontsize=8, ncols=3, frameon=False, loc="lower right", bbox_to_anchor=(1.0, 0.98), borderaxespad=0,
              handlelength=1.2, columnspacing=1.0, labelcolor=palette.INK)  # fmt: skip


__all__ = [
    "add_plate",
    "add_surface",
    "check_suffix",
    "dress_panel",
    "faded",
    "plain",
    "save",
    "shaded",
    "show_curve_names",
    "show_title",
    "surface",
    "write",
]
