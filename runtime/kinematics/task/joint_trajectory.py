"""Trajectories of a mechanism's tool and its actuated joints, written as CSV and NPZ: whole files or none."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.data_files import FORMATS, csv_text, npz_bytes, producer_versions, read_npz
from ...common.deprecation import renamed_attribute
from ...common.files import output_path, write_file
from ...mechanics.units import Units
from ...status import Status

Array = NDArray[Any]
VERSION = 1
#: Arrays of an NPZ file.
ARRAYS = ("time", "coordinates", "speeds", "position", "velocity", "condition", "status")


@dataclass(frozen=True, eq=False)
class Motion:
    """Coordinates of the actuated joints while the tool follows a path, or positions of the tool while they are driven.

    Attributes
    ----------
    time : array (n,)
    inputs : tuple of str
    turning : bool array (k,)
        True for inputs that are angles.
    coordinates, speeds : array (n, k)
        Coordinates and speeds of the inputs; NaN where there is no pose, speeds also at singular poses.
    position, velocity : array (n, 3)
        Position and velocity of the tool.
    condition : array (n,)
        Condition number of the Jacobian.
    status : array (n,)
        Codes of `Status`.
    units : Units
    """

    time: Array
    inputs: tuple[str, ...]
    turning: NDArray[np.bool_]
    coordinates: Array
    speeds: Array
    position: Array
    velocity: Array
    condition: Array
    status: NDArray[np.uint8]
    units: Units = Units()

    @property
    def is_reached(self) -> NDArray[np.bool_]:
        """Mask (n,) of the times that have a pose."""
        return np.asarray(np.isfinite(self.coordinates).all(-1))

    reached = renamed_attribute("is_reached")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the trajectory, whole or not at all.

        Parameters
        ----------
        path
            ``.npz``, which `load_motion` reads: arrays by the names above, and ``bladesmith``, a header as JSON;
            ``.csv``: a table with a header and units.

        Raises
        ------
        InputError
            If the name ends in neither, or the file cannot be written.
        """
        file = checked_name(path)
        write_file(file, self.table() if file.suffix.lower() == ".csv" else self.archive())

    def archive(self) -> bytes:
        """The bytes of an NPZ file."""
        header = {
            "format": "motion", "version": VERSION, "inputs": list(self.inputs), "turning": self.turning.tolist(),
            "units": {"length": self.units.length, "time": self.units.time},
            "made_by": producer_versions(),
        }  # fmt: skip
        return npz_bytes({name: getattr(self, name) for name in ARRAYS}, header)

    def table(self) -> str:
        """The text of a CSV file: numbers read back to the last bit."""
        length, time, speed = self.units.length, self.units.time, self.units.velocity
        inputs = [(n, "rad" if turns else length) for n, turns in zip(self.inputs, self.turning, strict=True)]
        columns = [
            ("t", time), *inputs, *((f"speed of {n}", f"{unit}/{time}") for n, unit in inputs),
            *((c, length) for c in "xyz"), *((f"v{c}", speed) for c in "xyz"), ("condition", ""), ("status", ""),
        ]  # fmt: skip
        numbers = np.concatenate([getattr(self, name).reshape(len(self.time), -1) for name in ARRAYS[:-1]], 1)
        names = [Status(int(code)).name for code in self.status]
        return csv_text(columns, ([*row, name] for row, name in zip(numbers.tolist(), names, strict=True)))


def load_motion(path: str | os.PathLike[str]) -> Motion:
    """Read a motion that was saved as NPZ: the same arrays to the last bit.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or holds something else.
    """
    return read_npz(path, "a motion", "motion.save", {"format": "motion", "version": VERSION}, _motion)


def _motion(header: dict[str, Any], arrays: dict[str, Array]) -> Motion:
    inputs = tuple(str(name) for name in header["inputs"])
    turning = np.array(header["turning"], bool)
    if turning.shape != (len(inputs),):
        raise ValueError("its header is damaged")
    count = len(arrays["time"])
    shapes = {"coordinates": (count, len(inputs)), "speeds": (count, len(inputs))}
    shapes |= {"position": (count, 3), "velocity": (count, 3)}
    for name in ARRAYS:
        dtype, shape = (np.uint8 if name == "status" else np.float64), shapes.get(name, (count,))
        if arrays[name].dtype != dtype or arrays[name].shape != shape:
            raise ValueError(f"{name} has another type or shape")
    units = Units(str(header["units"]["length"]), time=str(header["units"]["time"]))
    return Motion(inputs=inputs, turning=turning, units=units, **{name: arrays[name] for name in ARRAYS})


def checked_name(path: Any) -> Path:
    """A path that a motion can be written to.

    Raises
    ------
    InputError
        If it is not a path, or its suffix is not a known format.
    """
    return output_path(path, "a motion", "motions", FORMATS)


__all__ = ["Motion", "checked_name", "load_motion"]
