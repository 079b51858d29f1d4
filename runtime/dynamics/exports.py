"""Methods that write and draw trajectories: files, plots, pictures, films."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..common.rich_display import Displayed
from ..dispatch.multivector_data import Statuses, statuses
from ..status import Status
from .results.figure_spec import Sketch
from .results.trajectory_data import TrajectorySource

if TYPE_CHECKING:
    from ..plot.matplotlib_import import Axes3D, Figure


#: Endings of a simulation, by the driver's number (integration/runs.py), each with its status.
ENDINGS = {
    "ok": Status.OK, "not finite": Status.INVALID, "step underflow": Status.NOT_CONVERGED,
    "rank changed": Status.SINGULAR, "function failed": Status.INVALID, "stopped": Status.NOT_CONVERGED,
    "event": Status.OK, "not solved": Status.NOT_CONVERGED, "constraints violated": Status.NOT_CONVERGED,
    "paused": Status.NOT_CONVERGED, "stalled": Status.NOT_CONVERGED, "spring ends meet": Status.NOT_CONVERGED,
}  # fmt: skip


class TrajectoryExports(TrajectorySource, Displayed):
    """Base of trajectories and records: status, and methods that are functions of `bladesmith.dynamics` too."""

    @property
    def status(self) -> Statuses:
        """`Status` of each simulation, by its ``ending``."""
        endings: Any = self.ending  # type: ignore[attr-defined]
        codes = np.array([ENDINGS[each] for each in np.ravel(endings)], np.uint8)
        return statuses(codes.reshape(np.shape(endings)), np.shape(endings))

    @property
    def converged(self) -> np.bool_ | NDArray[np.bool_]:
        """True where a simulation came to its end, or to an event."""
        return np.equal(self.status, Status.OK)

    def save(self, path: str | os.PathLike[str], sketch: Sketch | None = None) -> None:
        """Write it to a ``.npz`` or ``.csv`` file; see `dynamics.save`."""
        from .results.trajectory_files import save

        save(path, self, sketch)

    def plot(self, path: str | os.PathLike[str] | None = None, **options: Any) -> Figure:
        """Draw curves over time; see `dynamics.plot`."""
        from .plotting.curves import plot

        return plot(self, path, **options)

    def picture(self, path: str | os.PathLike[str] | None = None, **options: Any) -> Axes3D:
        """Draw the motion in space; see `dynamics.picture`."""
        from .plotting.scene import picture

        return picture(self, path, **options)

    def animate(self, path: str | os.PathLike[str], **options: Any) -> None:
        """Write a film, or a page to rotate and to play; see `dynamics.animate`."""
        from .plotting.animation import animate

        animate(path, self, **options)


__all__ = ["TrajectoryExports"]
