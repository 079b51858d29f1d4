"""Records: trajectories as plain arrays, with the methods that draw and write them."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields

from .exports import TrajectoryExports
from .results.figure_spec import Sketch
from .results.trajectory_data import TrajectoryData, TrajectorySource, data_of
from .results.trajectory_files import read_trajectory


@dataclass(frozen=True, eq=False, repr=False)
class Record(TrajectoryData, TrajectoryExports):
    """A trajectory that was stored: the attributes of `Trajectory`, without the simulation that gave it.

    Of several bodies ``record["name"]`` is that of one, as of a trajectory; of a batch ``record[0]`` is one simulation.

    Attributes
    ----------
    time : array (stores,)
    motor, momentum, reaction : Multivector (stores,)
    position, velocity, angular_velocity : array (stores, 3)
    orientation : array (stores, 3, 3)
    energy, violation : array (stores,)
    bodies : dict of Record
        All bodies by name.
    sketch : Sketch
        Shapes, traces and units that were stored with it.
    integrator, message : str
    ending, status, converged, steps
        As of `Trajectory`.
    """


def as_record(trajectory: TrajectorySource, sketch: Sketch | None = None) -> Record:
    """Arrays of a trajectory.

    Parameters
    ----------
    trajectory : Trajectory or Record
    sketch : Sketch, optional
        Replaces its own.

    Raises
    ------
    InputError
        If it is neither, or the sketch names a body that is not there.
    """
    data = data_of(trajectory, sketch)
    return data if isinstance(data, Record) else Record(**{f.name: getattr(data, f.name) for f in fields(data)})


def load_trajectory(path: str | os.PathLike[str]) -> Record:
    """Read a trajectory that was saved as NPZ: the same arrays to the last bit.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or holds something else.
    """
    return read_trajectory(path, Record)


__all__ = ["Record", "load_trajectory", "as_record"]
