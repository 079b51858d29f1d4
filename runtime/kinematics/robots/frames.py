"""Rotations of robots' files as matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def unit_vector(vector: Array) -> Array:
    """A vector (n,) of any finite length, made one long; zero stays zero."""
    largest = float(np.abs(vector).max())
    if not largest:
        return vector
    scaled = np.ldexp(vector, -int(np.frexp(largest)[1]))  # exact: squares neither overflow nor vanish
    return np.asarray(scaled / np.linalg.norm(scaled))


def rotation_of_rpy(angles: Array) -> Array:
    """Matrix (3, 3) of roll, pitch, yaw about the fixed x, y, z."""
    (si, sj, sk), (ci, cj, ck) = (f(angles) for f in (np.sin, np.cos))
    return np.array([
        [cj * ck, sj * (si * ck) - ci * sk, sj * (ci * ck) + si * sk],
        [cj * sk, sj * (si * sk) + ci * ck, sj * (ci * sk) - si * ck],
        [-sj, cj * si, cj * ci],
    ])  # fmt: skip


def rotation_of_quaternion(quaternion: Array) -> Array:
    """Matrix (3, 3) of a quaternion w, x, y, z of any length."""
    w, x, y, z = unit_vector(quaternion)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def quaternion_of_rotation(matrix: Array) -> Array:
    """Unit quaternion w, x, y, z of a rotation (3, 3); w is not negative."""
    m = matrix
    four = np.array([
        [m[0, 0] + m[1, 1] + m[2, 2], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
        [0, m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
        [0, 0, m[1, 1] - m[0, 0] - m[2, 2], m[1, 2] + m[2, 1]],
        [0, 0, 0, m[2, 2] - m[0, 0] - m[1, 1]],
    ])  # fmt: skip
    four = four + four.T - np.diag(four.diagonal())
    quaternion: Array = np.linalg.eigh(four)[1][:, -1]
    first = float(quaternion[np.flatnonzero(np.abs(quaternion) > 1e-300)[0]])
    return np.asarray(quaternion if first > 0 else -quaternion)


def rotation_about(axis: Array, angle: float) -> Array:
    """Matrix (3, 3) of a rotation by an angle about a unit vector."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + 2 * np.sin(angle / 2) ** 2 * (cross @ cross))


def rotation_to(direction: Array) -> Array:
    """Matrix (3, 3) of the smallest rotation that takes z to a direction of any length."""
    z = unit_vector(direction)
    axis = np.array([-z[1], z[0], 0.0])
    size = float(np.linalg.norm(axis))
    if size < 1e-300:
        return np.eye(3) if z[2] > 0 else np.diag([1.0, -1.0, -1.0])
    return rotation_about(axis / size, float(np.arctan2(size, z[2])))
