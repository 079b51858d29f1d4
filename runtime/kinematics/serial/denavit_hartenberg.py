"""Axes of chains from tables of Denavit and Hartenberg's four numbers for each joint, in both conventions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, ShapeError, suggest
from ...common.validation import as_choice, finite_array

Array = NDArray[Any]
#: Standard: after the joint's rotation and advance along its z, a and alpha of the link behind it. Modified (Craig): a
#: and alpha of the link before the joint come first.
CONVENTIONS = ("standard", "modified")
ANGLES = ("radians", "degrees")
#: Numbers of a row, in their order.
COLUMNS = ("a", "alpha", "d", "theta")
KINDS = {"R": "rotates", "P": "translates"}
#: An angle in radians beyond this is one in degrees.
LARGEST = 4 * np.pi


def dh_frames(rows: Any, convention: str, angles: str, joints: str | None) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Frames of a table where all coordinates are zero.

    Parameters
    ----------
    rows, convention, angles, joints
        As of `Chain.from_dh`.

    Returns
    -------
    axes : array (n, 4, 4)
        For each joint the frame along whose z it rotates or translates.
    links : array (n, 4, 4)
        Frames of the links behind the joints.
    translates : array (n,) of bool

    Raises
    ------
    InputError, ShapeError
    """
    is_standard = as_choice(convention, "convention", CONVENTIONS) == "standard"
    table = _table(rows, as_choice(angles, "angles", ANGLES))
    translates = _kinds(joints, len(table))
    pose = np.eye(4)
    axes, links = [], []
    for a, alpha, d, theta in table:
        along_x, along_z = _screw(0, alpha, a), _screw(2, theta, d)
        before = pose if is_standard else pose @ along_x
        pose = before @ along_z @ (along_x if is_standard else np.eye(4))
        axes.append(before)
        links.append(pose)
    return np.stack(axes), np.stack(links), translates


def _table(rows: Any, angles: str) -> Array:
    """Rows (n, 4) of `COLUMNS`, angles in radians."""
    if isinstance(rows, Sequence) and any(isinstance(row, Mapping) for row in rows):
        rows = [_row(row, i) for i, row in enumerate(rows)]
    table = finite_array(rows, "the rows")
    if table.ndim != 2 or table.shape[1] != len(COLUMNS) or not len(table):
        raise ShapeError(
            f"the rows have shape {table.shape}; (n, 4) is needed, of {', '.join(COLUMNS)}.",
            remedy="Rows may be mappings with these names",
        )
    table = table.copy()
    of_angles = [COLUMNS.index("alpha"), COLUMNS.index("theta")]
    if angles == "degrees":
        table[:, of_angles] = np.deg2rad(table[:, of_angles])
    large = np.argwhere(np.abs(table[:, of_angles]) > LARGEST)
    if len(large) and angles == "radians":
        i, k = large[0]
        name = COLUMNS[of_angles[k]]
        raise InputError(
            f"{name} of row {i} is {table[i, of_angles[k]]:g} radians.",
            remedy="If these are degrees say angles='degrees'; else give the angle within two turns",
        )
    return table


def _row(row: Any, i: int) -> list[Any]:
    if not isinstance(row, Mapping):
        raise InputError(f"row {i} has no names, and others have.", remedy="Give all rows alike")
    for name in row:
        if name not in COLUMNS:
            raise InputError(f"row {i} has {name!r}{suggest(name, COLUMNS)}; a row has {', '.join(COLUMNS)}.")
    return [row.get(name, 0.0) for name in COLUMNS]


def _kinds(joints: str | None, count: int) -> NDArray[np.bool_]:
    if joints is None:
        return np.zeros(count, bool)
    if not isinstance(joints, str) or len(joints) != count or not set(joints.upper()) <= set(KINDS):
        raise InputError(
            f"joints is {joints!r}; {count} letters are needed, R for each that rotates and P for each that translates."
        )
    return np.array([letter == "P" for letter in joints.upper()])


def _screw(axis: int, angle: float, advance: float) -> Array:
    """Matrix (4, 4) of a rotation about an axis of the frame and an advance along it."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(4)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j], matrix[axis, 3] = c, -s, s, c, advance
    return matrix
