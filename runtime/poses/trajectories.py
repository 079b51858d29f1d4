"""Trajectories in the text format of the TUM benchmark: a line for each pose, `timestamp tx ty tz qx qy qz qw`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..common.files import as_path, write_file
from ..common.validation import finite_array, short_repr
from ..core.multivector import Multivector
from .arguments import as_pose
from .matrices import from_matrix
from .motions import position
from .quaternions import from_quaternion, to_quaternion

Array = NDArray[np.float64]
#: First line of a file.
HEADER = "# timestamp tx ty tz qx qy qz qw"
#: Numbers of a line.
COLUMNS = 8
#: Rounded quaternions are taken up to this difference of their length from 1.
LENGTH_TOLERANCE = 0.01


def save_tum(path: str | os.PathLike[str], times: Any, x: Multivector | Sequence[Multivector]) -> None:
    """Write poses with their times, whole or not at all; `load_tum` reads them to rounding.

    Parameters
    ----------
    path : path
    times : array (n,)
        In seconds.
    x : Multivector (n,), or list of n
        Poses, or motors of cga3d, as registrations and simulations give them.

    Raises
    ------
    InputError
        If there is not one finite pose for each time, or the file cannot be written.
    """
    file = as_path(path, "a trajectory is written to")
    motors = _poses(x)
    stamps = finite_array(times, "times", ("n",)).astype(np.float64)
    if motors.shape != stamps.shape:
        what = f"there are {len(stamps)} times and poses of shape {motors.shape}"
        raise InputError(f"{what}; one pose for each is needed.")
    rows = np.concatenate([stamps[:, None], position(motors), to_quaternion(motors, "xyzw", canonical=True)], 1)
    bad = ~np.isfinite(rows).all(1)
    if bad.any():
        raise InputError(f"the pose {int(bad.argmax())} is not finite.", remedy="Leave out what was not found")
    lines = (" ".join(map(repr, row)) for row in rows.tolist())
    write_file(file, "\n".join([HEADER, *lines]) + "\n")


def _poses(x: Any) -> Multivector:
    """Motors of pga3d, of a batch or a list of motors of either algebra."""
    if isinstance(x, list | tuple):
        return (
            from_matrix(np.stack([as_pose(each, f"x[{i}]").to_matrix() for i, each in enumerate(x)])) if x else _none()
        )
    return as_pose(x)


def _none() -> Multivector:
    return from_matrix(np.empty((0, 4, 4)))


def load_tum(path: str | os.PathLike[str]) -> tuple[Array, Multivector]:
    """Times (n,) and poses (n,) of a file of a trajectory; quaternions are divided by their length.

    Raises
    ------
    InputError
        If the file cannot be read, or a line has not eight finite numbers, or a quaternion that is not unit to 1 %:
        with the line.
    """
    file = as_path(path, "a trajectory is read from")
    try:
        lines = file.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise InputError(f"the file cannot be read ({error.strerror})", where=str(file)) from None
    numbered = [(i, words) for i, line in enumerate(lines, 1) if (words := line.split("#", 1)[0].split())]
    rows = np.array([_numbers(words, f"{file}, line {i}") for i, words in numbered], np.float64).reshape(-1, COLUMNS)
    lengths = np.linalg.norm(rows[:, 4:], axis=1)
    bad = ~(np.abs(lengths - 1) <= LENGTH_TOLERANCE)
    if bad.any():
        i = int(bad.argmax())
        raise InputError(f"the quaternion {rows[i, 4:].tolist()} has length {lengths[i]:.6g}; that of a rotation is 1.",
                         where=f"{file}, line {numbered[i][0]}")  # fmt: skip
    return rows[:, 0], from_quaternion(rows[:, 4:], rows[:, 1:4], "xyzw", normalize=True)


def _numbers(words: list[str], where: str) -> list[float]:
    try:
        found = [float(word) for word in words]
    except ValueError:
        found = []
    if len(found) != COLUMNS or not np.isfinite(found).all():
        what = f"{short_repr(' '.join(words))} is not a pose"
        raise InputError(f"{what}; eight finite numbers are needed: timestamp tx ty tz qx qy qz qw.", where=where)
    return found
