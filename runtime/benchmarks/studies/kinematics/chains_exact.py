"""Serial chains with 50 digits, reference of the studies: products of exponentials, and their differences.

No kernels, no floats: rotation matrices by Rodrigues's formula, written out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...harness.study import Array
from ...harness.vectors import add, dot, scale, subtract
from .delta_exact import context

#: A rotation (3 rows) and a position.
Pose = tuple[list[Any], list[Any]]
#: Half the step of differences: with 50 digits they are good to 30.
STEP_DIGITS = 16


class ExactArm:
    """A chain of revolute joints.

    Parameters
    ----------
    positions, directions : array (n, 3)
        Points of the axes, and vectors along them, in the world where all angles are zero.
    tool : array (3,)
        Origin of the tool's frame there, which is along the world's axes.
    """

    def __init__(self, positions: Array, directions: Array, tool: Array) -> None:
        self.mp = mp = context()
        self.positions, found, (self.tool,) = (
            [[mp.mpf(float(x)) for x in row] for row in rows] for rows in (positions, directions, [tool])
        )
        self.axes = [scale(d, 1 / mp.sqrt(dot(d, d))) for d in found]

    def rotation(self, i: int, angle: Any) -> Pose:
        """Motion of all that comes after a joint."""
        a, p, s, c = self.axes[i], self.positions[i], self.mp.sin(angle), self.mp.cos(angle)
        hat = [[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]]
        matrix = [
            [(c if k == j else 0) + s * hat[k][j] + (1 - c) * a[k] * a[j] for j in range(3)] for k in range(3)
        ]  # fmt: skip
        return matrix, subtract(p, times(matrix, p))

    def pose(self, q: Array) -> Pose:
        """Pose of the tool."""
        pose: Pose = self._one, [self.mp.mpf(0)] * 3
        for i, angle in enumerate(q):
            pose = after(pose, self.rotation(i, self.mp.mpf(float(angle))))
        return pose[0], after(pose, (self._one, self.tool))[1]

    def jacobian(self, q: Array) -> Array:
        """(6, n): the tool's angular velocity and its origin's velocity, by central differences of poses.

        A pose is linear in each joint's matrix, so that only that is taken at two angles.
        """
        mp, n = self.mp, len(q)
        step, angles = mp.mpf(10) ** -STEP_DIGITS, [mp.mpf(float(x)) for x in q]
        after_joint: list[Pose] = [(self._one, self.tool)]
        for i in reversed(range(n)):
            after_joint.append(after(self.rotation(i, angles[i]), after_joint[-1]))
        whole, jacobian = after_joint[-1], np.zeros((6, n))
        pose: Pose = self._one, [mp.mpf(0)] * 3
        for i in range(n):
            ends = [after(after(pose, self.rotation(i, angles[i] + x)), after_joint[n - 1 - i]) for x in (step, -step)]
            rate = [scale(subtract(u, v), 1 / (2 * step)) for u, v in zip(ends[0][0], ends[1][0], strict=True)]
            spin = [[dot(rate[k], whole[0][j]) for j in range(3)] for k in range(3)]  # dR R^T
            angular = [(spin[2][1] - spin[1][2]) / 2, (spin[0][2] - spin[2][0]) / 2, (spin[1][0] - spin[0][1]) / 2]
            linear = scale(subtract(ends[0][1], ends[1][1]), 1 / (2 * step))
            jacobian[:, i] = [float(x) for x in (*angular, *linear)]
            pose = after(pose, self.rotation(i, angles[i]))
        return jacobian

    def matrix(self, q: Array) -> Array:
        """The pose (3, 4), rounded."""
        rotation, position = self.pose(q)
        return np.array([[float(x) for x in (*row, p)] for row, p in zip(rotation, position, strict=True)])

    @property
    def _one(self) -> list[Any]:
        return [[self.mp.mpf(int(i == j)) for j in range(3)] for i in range(3)]


def times(matrix: list[Any], vector: list[Any]) -> list[Any]:
    return [dot(row, vector) for row in matrix]


def after(first: Pose, second: Pose) -> Pose:
    """The second seen from where the first leads."""
    columns = [list(column) for column in zip(*second[0], strict=True)]
    rotation = [[dot(row, column) for column in columns] for row in first[0]]
    return rotation, add(times(first[0], second[1]), first[1])
