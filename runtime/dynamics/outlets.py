"""Where trajectories and their records go: files, pictures, films."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .record import Record
    from .sketch import Sketch
    from .trajectory import Trajectory


class Outlets:
    """Methods that trajectories and records share; each is a function of `bladesmith.dynamics` too."""

    @property
    def _states(self) -> Trajectory | Record:
        return self  # type: ignore[return-value]

    def save(self, path: str | os.PathLike[str], sketch: Sketch | None = None) -> None:
        """Write it to a ``.npz`` or ``.csv`` file; see `dynamics.save`."""
        from .files import save

        save(self._states, path, sketch)

    def plot(self, path: str | os.PathLike[str] | None = None, **options: Any) -> Any:
        """Draw curves over time; see `dynamics.plot`."""
        from .plots import plot

        return plot(self._states, path, **options)

    def picture(self, path: str | os.PathLike[str] | None = None, **options: Any) -> Any:
        """Draw the motion in space; see `dynamics.picture`."""
        from .pictures import picture

        return picture(self._states, path, **options)

    def animate(self, path: str | os.PathLike[str], **options: Any) -> None:
        """Write a film, or a page to turn and to play; see `dynamics.animate`."""
        from .animation import animate

        animate(self._states, path, **options)
