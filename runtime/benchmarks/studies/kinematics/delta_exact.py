"""The Delta robot with 50 digits, reference of the studies of its kinematics. No kernels, no floats.

From distances alone: a forearm's ends stay as far apart as it is long.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ....codegen.rings.protocol import PrecisionRing
from ....kinematics.delta.robot import DeltaRobot
from ...harness.study import Array
from ...harness.vectors import add, cross, dot, scale, subtract

Vector = list[Any]
DIGITS = 50


def context() -> Any:
    """The numbers of `mpmath`, with so many digits."""
    return PrecisionRing(DIGITS).context


class ExactDelta:
    """Its outer elbows and far position.

    Parameters
    ----------
    robot : DeltaRobot
        Its lengths are taken as they are, digit by digit.
    """

    def __init__(self, robot: DeltaRobot) -> None:
        self.mp = mp = context()
        lengths = (robot.base_radius, robot.effector_radius, robot.upper_arm, robot.forearm)
        base, effector, self.upper, self.fore = (mp.mpf(x) for x in lengths)
        self.offset = base - effector
        angles = [2 * mp.pi * i / 3 for i in range(3)]
        self.outwards = [[mp.cos(a), mp.sin(a), mp.mpf(0)] for a in angles]

    def numbers(self, row: Sequence[float]) -> Vector:
        """A row of floats, exactly."""
        return [self.mp.mpf(float(x)) for x in row]

    def centers(self, theta: Vector) -> list[Vector]:
        """Elbows, moved inwards by the platform's radius: the position is a forearm from each."""
        centers = []
        for t, s in zip(theta, self.outwards, strict=True):
            out = self.offset + self.upper * self.mp.cos(t)
            centers.append([out * s[0], out * s[1], self.upper * self.mp.sin(t)])
        return centers

    def forward(self, theta: Vector) -> Vector | None:
        """Position for angles; None where the forearms do not meet."""
        a, b, c = self.centers(theta)
        u, v = subtract(b, a), subtract(c, a)
        normal = cross(u, v)
        size = dot(normal, normal)
        if not size:
            return None
        # the point of their plane that is as far from all three
        direction = cross(subtract(scale(v, dot(u, u)), scale(u, dot(v, v))), normal)
        middle = scale(direction, 1 / (2 * size))
        height = self.fore**2 - dot(middle, middle)  # squared
        return None if height < 0 else add(a, add(middle, scale(normal, self.mp.sqrt(height / size))))

    def inverse(self, y: Vector) -> Vector | None:
        """Angles for a position, by the law of cosines in each arm's plane; None where an arm does not reach."""
        angles = []
        for s in self.outwards:
            from_axis = subtract(y, scale(s, self.offset))
            out, across = dot(from_axis, s), from_axis[0] * s[1] - from_axis[1] * s[0]
            apart = self.mp.hypot(out, y[2])
            cosine = (self.upper**2 + apart**2 - self.fore**2 + across**2) / (2 * self.upper * apart)
            if abs(cosine) > 1:
                return None
            angle = self.mp.atan2(y[2], out) - self.mp.acos(cosine)
            angles.append(angle + 2 * self.mp.pi if angle <= -self.mp.pi else angle)
        return angles

    def matrices(self, theta: Vector, y: Vector) -> tuple[list[Vector], Vector]:
        """Rows F and numbers d with F dy = d dtheta: a forearm keeps its length."""
        rows, speeds = [], []
        for t, s, a in zip(theta, self.outwards, self.centers(theta), strict=True):
            along = subtract(y, a)
            path = [-self.mp.sin(t) * s[0], -self.mp.sin(t) * s[1], self.mp.cos(t)]
            rows.append(along)
            speeds.append(self.upper * dot(along, path))
        return rows, speeds

    def forward_jacobian(self, theta: Vector) -> list[Vector] | None:
        """J (3, 3) for angles."""
        y = self.forward(theta)
        if y is None:
            return None
        (f, g, h), speeds = self.matrices(theta, y)
        columns = [cross(g, h), cross(h, f), cross(f, g)]
        volume = dot(f, columns[0])
        return None if not volume else [
            [columns[j][i] * speeds[j] / volume for j in range(3)] for i in range(3)
        ]  # fmt: skip

    def inverse_jacobian(self, y: Vector) -> list[Vector] | None:
        """J* (3, 3) for a position."""
        theta = self.inverse(y)
        if theta is None:
            return None
        rows, speeds = self.matrices(theta, y)
        return None if not all(speeds) else [scale(f, 1 / d) for f, d in zip(rows, speeds, strict=True)]


def differences(mp: Any, function: Callable[[Vector], Vector], x: Vector, step: Any) -> list[Vector]:
    """Jacobian by central differences: with 50 digits and a step of 1e-16 good to 30 of them."""
    columns = []
    for j in range(len(x)):
        ends = [function([v + sign * step if i == j else v for i, v in enumerate(x)]) for sign in (1, -1)]
        columns.append([(p - q) / (2 * step) for p, q in zip(*ends, strict=True)])
    return [[column[i] for column in columns] for i in range(len(columns[0]))]


def floats(rows: Any, shape: tuple[int, ...]) -> Array:
    """Rounded; NaN where there is nothing."""
    if rows is None:
        return np.full(shape, np.nan)
    return np.array([[float(x) for x in row] for row in rows]) if len(shape) > 1 else np.array([float(x) for x in rows])
