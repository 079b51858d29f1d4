"""Serial chains with 50 digits: what studies of them compare against. Products of exponentials, and their differences.

No kernels, no floats: matrices of turns by Rodrigues's formula, written out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .delta_exact import added, context, dot, scaled

Array = NDArray[Any]
#: A turn (3 rows) and a place.
Place = tuple[list[Any], list[Any]]
#: Half the step of differences: with 50 digits they are good to 30.
STEP_DIGITS = 16


class ExactArm:
    """A chain of turns about lines.

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
        self.axes = [scaled(d, 1 / mp.sqrt(dot(d, d))) for d in found]

    def turn(self, i: int, angle: Any) -> Place:
        """Of all that comes after a joint."""
        a, p, s, c = self.axes[i], self.positions[i], self.mp.sin(angle), self.mp.cos(angle)
        hat = [[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]]
        matrix = [
            [(c if k == j else 0) + s * hat[k][j] + (1 - c) * a[k] * a[j] for j in range(3)] for k in range(3)
        ]  # fmt: skip
        return matrix, [x - y for x, y in zip(p, times(matrix, p), strict=True)]

    def pose(self, q: Array) -> Place:
        """Of the tool."""
        place: Place = self._one, [self.mp.mpf(0)] * 3
        for i, angle in enumerate(q):
            place = after(place, self.turn(i, self.mp.mpf(float(angle))))
        return place[0], after(place, (self._one, self.tool))[1]

    def jacobian(self, q: Array) -> Array:
        """(6, n): the tool's angular velocity and its origin's velocity, by central differences of poses.

        A pose is linear in each joint's matrix, so that only that is taken at two angles.
        """
        mp, n = self.mp, len(q)
        step, angles = mp.mpf(10) ** -STEP_DIGITS, [mp.mpf(float(x)) for x in q]
        behind: list[Place] = [(self._one, self.tool)]
        for i in reversed(range(n)):
            behind.append(after(self.turn(i, angles[i]), behind[-1]))
        whole, made = behind[-1], np.zeros((6, n))
        place: Place = self._one, [mp.mpf(0)] * 3
        for i in range(n):
            ends = [after(after(place, self.turn(i, angles[i] + x)), behind[n - 1 - i]) for x in (step, -step)]
            rate = [
                [(x - y) / (2 * step) for x, y in zip(u, v, strict=True)]
                for u, v in zip(ends[0][0], ends[1][0], strict=True)
            ]
            spin = [[dot(rate[k], whole[0][j]) for j in range(3)] for k in range(3)]  # dR R^T
            turning = [(spin[2][1] - spin[1][2]) / 2, (spin[0][2] - spin[2][0]) / 2, (spin[1][0] - spin[0][1]) / 2]
            moving = [(x - y) / (2 * step) for x, y in zip(ends[0][1], ends[1][1], strict=True)]
            made[:, i] = [float(x) for x in (*turning, *moving)]
            place = after(place, self.turn(i, angles[i]))
        return made

    def matrix(self, q: Array) -> Array:
        """The pose (3, 4), rounded."""
        turn, at = self.pose(q)
        return np.array([[float(x) for x in (*row, p)] for row, p in zip(turn, at, strict=True)])

    @property
    def _one(self) -> list[Any]:
        return [[self.mp.mpf(int(i == j)) for j in range(3)] for i in range(3)]


def times(matrix: list[Any], vector: list[Any]) -> list[Any]:
    return [dot(row, vector) for row in matrix]


def after(first: Place, second: Place) -> Place:
    """The second seen from where the first leads."""
    columns = [list(column) for column in zip(*second[0], strict=True)]
    turn = [[dot(row, column) for column in columns] for row in first[0]]
    return turn, added(times(first[0], second[1]), first[1])


__all__ = ["ExactArm"]
