"""The Delta robot with 50 digits: what studies of its kinematics compare against. No kernels, no floats.

From distances alone: a forearm's ends stay as far apart as it is long.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ...kinematics.delta import DeltaRobot

Array = NDArray[Any]
Vector = list[Any]
DIGITS = 50


def context() -> Any:
    """The numbers of `mpmath`, with so many digits."""
    from ...codegen.rings import PrecisionRing

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
        turns = [2 * mp.pi * i / 3 for i in range(3)]
        self.outwards = [[mp.cos(a), mp.sin(a), mp.mpf(0)] for a in turns]

    def numbers(self, row: Sequence[float]) -> Vector:
        """A row of floats, exactly."""
        return [self.mp.mpf(float(x)) for x in row]

    def centers(self, theta: Vector) -> list[Vector]:
        """Elbows, moved inwards by the platform's radius: the position is a forearm from each."""
        made = []
        for t, s in zip(theta, self.outwards, strict=True):
            out = self.offset + self.upper * self.mp.cos(t)
            made.append([out * s[0], out * s[1], self.upper * self.mp.sin(t)])
        return made

    def forward(self, theta: Vector) -> Vector | None:
        """Position for angles; None where the forearms do not meet."""
        a, b, c = self.centers(theta)
        u, v = sub(b, a), sub(c, a)
        normal = cross(u, v)
        size = dot(normal, normal)
        if not size:
            return None
        # the point of their plane that is as far from all three
        way = cross(sub(scaled(v, dot(u, u)), scaled(u, dot(v, v))), normal)
        middle = scaled(way, 1 / (2 * size))
        left = self.fore**2 - dot(middle, middle)
        return None if left < 0 else added(a, added(middle, scaled(normal, self.mp.sqrt(left / size))))

    def inverse(self, y: Vector) -> Vector | None:
        """Angles for a position, by the law of cosines in each arm's plane; None where an arm does not reach."""
        angles = []
        for s in self.outwards:
            from_axis = sub(y, scaled(s, self.offset))
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
            along = sub(y, a)
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
        return None if not all(speeds) else [scaled(f, 1 / d) for f, d in zip(rows, speeds, strict=True)]


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


def dot(a: Vector, b: Vector) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def sub(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def added(a: Vector, b: Vector) -> Vector:
    return [x + y for x, y in zip(a, b, strict=True)]


def scaled(a: Vector, factor: Any) -> Vector:
    return [factor * x for x in a]
