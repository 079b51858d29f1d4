"""Motions of a mechanism's tool and its driven joints over time, as CSV and NPZ: whole files or none."""

from __future__ import annotations

import csv
import io
import json
import os
import platform
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.version import __version__
from ..dynamics.given import output_file
from ..dynamics.sketch import Units
from ..files import failures_named, write_atomically
from ..status import Status

Array = NDArray[Any]
#: Formats, by the end of the name.
FORMATS = (".npz", ".csv")
VERSION = 1
#: Arrays of an NPZ file.
ARRAYS = ("time", "coordinates", "speeds", "position", "velocity", "condition", "status")
#: Name of the array that holds the header.
HEADER = "bladesmith"


@dataclass(frozen=True, eq=False)
class Motion:
    """What the driven joints do while the tool follows a path, or the tool while joints are driven.

    Attributes
    ----------
    time : array (n,)
    inputs : tuple of str
    turning : bool array (k,)
        Whether an input is an angle.
    coordinates, speeds : array (n, k)
        Of the inputs; NaN where there is no pose, speeds also where it is singular.
    position, velocity : array (n, 3)
        Of the tool.
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
    def reached(self) -> NDArray[np.bool_]:
        """Where there is a pose."""
        return np.asarray(np.isfinite(self.coordinates).all(-1))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it, whole or not at all.

        Parameters
        ----------
        path
            ``.npz``: arrays by the names above, and ``bladesmith``, a header as JSON; ``.csv``: a table with a header
            and units.

        Raises
        ------
        InputError
            If the name ends in neither, or the file cannot be written.
        """
        file = checked_name(path)
        with failures_named(file):
            write_atomically(file, self.table() if file.suffix.lower() == ".csv" else self.archive())

    def archive(self) -> bytes:
        """The bytes of an NPZ file."""
        header = {
            "format": "motion", "version": VERSION, "inputs": list(self.inputs), "turning": self.turning.tolist(),
            "units": {"length": self.units.length, "time": self.units.time},
            "made_by": {"bladesmith": __version__, "numpy": np.__version__, "python": platform.python_version()},
        }  # fmt: skip
        buffer = io.BytesIO()
        stored = {name: getattr(self, name) for name in ARRAYS}
        stored[HEADER] = np.frombuffer(json.dumps(header).encode(), np.uint8)
        np.savez_compressed(buffer, **stored)
        return buffer.getvalue()

    def table(self) -> str:
        """The text of a CSV file: numbers read back to the last bit."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        length, time = self.units.length, self.units.time
        own = ["rad" if turns else length for turns in self.turning]
        columns = [
            f"t [{time}]", *(f"{n} [{u}]" for n, u in zip(self.inputs, own, strict=True)),
            *(f"speed of {n} [{u}/{time}]" for n, u in zip(self.inputs, own, strict=True)),
            *(f"{c} [{length}]" for c in "xyz"), *(f"v{c} [{self.units.velocity}]" for c in "xyz"),
            "condition", "status",
        ]  # fmt: skip
        writer.writerow(columns)
        arrays = [getattr(self, name) for name in ARRAYS[:-1]]
        numbers = np.concatenate([x.reshape(len(self.time), -1) for x in arrays], 1)
        for row, code in zip(numbers.tolist(), self.status, strict=True):
            writer.writerow([*map(repr, row), Status(int(code)).name])
        return text.getvalue()


def checked_name(path: Any) -> Path:
    """A path that a motion can be written to.

    Raises
    ------
    InputError
        If it is none, or ends in no known format.
    """
    return output_file(path, "a motion", "motions", FORMATS)


__all__ = ["FORMATS", "Motion", "checked_name"]
