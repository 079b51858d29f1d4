"""Point lights."""

from __future__ import annotations

from typing import Any

from . import values
from .immutable import Immutable


class Light(Immutable):
    """A point light of the same brightness at every distance.

    A light on a surface shines on both of its sides; one inside a closed surface lights its inside.

    Parameters
    ----------
    position : (3,) array
    color : (3,) array
        Linear red, green, blue; above 1 is brighter than white.
    """

    _shown = ("position", "color")

    def __init__(self, position: Any, color: Any = (1.0, 1.0, 1.0)) -> None:
        self.position = values.finite(position, "light.position", 3)
        self.color = values.color(color, "light.color")
        self._frozen = True
