"""Import of matplotlib at the first picture; without it, an error that names the extra."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ..errors import MissingExtraError

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Figure
    from mpl_toolkits.mplot3d.axes3d import Axes3D as Axes3D  # type: ignore[import-untyped]


def load_module(name: str) -> Any:
    """Import a module of matplotlib.

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
    """Module `matplotlib.colors`."""
    return load_module("matplotlib.colors")


def collections() -> Any:
    """Collections of lines and polygons in space."""
    return load_module("mpl_toolkits.mplot3d.art3d")


def axes_class() -> Any:
    """Class `Axes3D`."""
    return load_module("mpl_toolkits.mplot3d.axes3d").Axes3D


def figure_class() -> type[Figure]:
    """Class `Figure`, which needs neither pyplot nor a window."""
    figure: type[Figure] = load_module("matplotlib.figure").Figure
    return figure


def line_class() -> Any:
    """Class `Line2D`, for legends."""
    return load_module("matplotlib.lines").Line2D
