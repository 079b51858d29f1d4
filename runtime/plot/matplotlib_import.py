"""The one place that imports matplotlib, on the first picture; without it, an error that names the extra."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ..errors import MissingExtraError

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d.axes3d import Axes3D as Axes3D  # type: ignore[import-untyped]


def imported(name: str) -> Any:
    """A module of matplotlib.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    try:
        return import_module(name)
    except ImportError:
        raise MissingExtraError("plot", "Drawing") from None


def colors() -> Any:
    """`matplotlib.colors`."""
    return imported("matplotlib.colors")


def collections() -> Any:
    """Collections of lines and polygons in space."""
    return imported("mpl_toolkits.mplot3d.art3d")


def axes_class() -> Any:
    """`Axes3D`."""
    return imported("mpl_toolkits.mplot3d.axes3d").Axes3D


def figure_class() -> Any:
    """`Figure`, which needs neither pyplot nor a window."""
    return imported("matplotlib.figure").Figure


def line_class() -> Any:
    """`Line2D`, for legends."""
    return imported("matplotlib.lines").Line2D
