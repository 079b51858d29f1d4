"""Lamps."""

from __future__ import annotations

from typing import Any

from . import values
from .fixed import Fixed


class Light(Fixed):
    """A lamp at a point, of the same brightness at every distance.

    A lamp on a surface shines to both of its sides; one inside a closed surface lights its inside.

    Parameters
    ----------
    position : (3,) array
    color : (3,) array
        Linear red, green, blue; above 1 is brighter than white.
    """

    def __init__(self, position: Any, color: Any = (1.0, 1.0, 1.0)) -> None:
        self.position = values.finite(position, "light.position", 3)
        self.color = values.color(color, "light.color")
        self._made = True
