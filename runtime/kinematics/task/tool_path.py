"""Paths of a tool, or of joint coordinates, over time: lines, circles, splines, each with its velocity."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...core.geometry.euclidean import perpendicular

Array = NDArray[Any]
#: Degree of the spline through points, if there are enough points.
DEGREE = 5
#: Distance from the axis of a circle, relative to its radius, below which no point of the circle is nearest.
ON_AXIS = 1e-12


@dataclass(frozen=True)
class ToolPath:
    """A path of the end effector or of joint coordinates, parameterized by time.

    Attributes
    ----------
    kind : {"line", "circle", "points", "joints"}
    numbers : dict
        ``start``, ``end`` of a line; ``center``, ``normal``, ``radius``, ``turns`` of a circle; ``points``; of joints
        the first and last coordinate by name.
    duration : float
    samples : int
    smooth : bool
        True: from rest to rest, with zero acceleration at both ends; False: at constant speed.
    """

    kind: str
    numbers: dict[str, Any] = field(default_factory=dict)
    duration: float = 1.0
    samples: int = 101
    smooth: bool = True

    @property
    def times(self) -> Array:
        """Times of the samples."""
        return np.linspace(0.0, self.duration, self.samples)

    def progress(self) -> tuple[Array, Array]:
        """Fraction of the path at the times, from 0 to 1, and its rate."""
        t = np.linspace(0.0, 1.0, self.samples)
        if not self.smooth:
            return t, np.full_like(t, 1 / self.duration)
        return t**3 * (10 - 15 * t + 6 * t**2), 30 * (t * (1 - t)) ** 2 / self.duration

    def positions(self, home: Array) -> tuple[Array, Array]:
        """Positions and velocities (n, 3) of a tool that is at ``home`` at first."""
        s, rate = self.progress()
        if self.kind == "line":
            start = self.numbers["start"]
            begin = np.asarray(home if start is None else start, float)
            displacement = np.asarray(self.numbers["end"], float) - begin
            return begin + s[:, None] * displacement, rate[:, None] * displacement
        if self.kind == "circle":
            return self._on_circle(home, s, rate)
        return self._on_spline(s, rate)

    def _on_circle(self, home: Array, s: Array, rate: Array) -> tuple[Array, Array]:
        center, normal = (np.asarray(self.numbers[key], float) for key in ("center", "normal"))
        normal = normal / np.linalg.norm(normal)
        away = np.asarray(home, float) - center
        away = away - normal * (normal @ away)
        if np.linalg.norm(away) <= ON_AXIS * max(self.numbers["radius"], float(np.abs(home).max())):
            away = perpendicular(normal)
        one = away / np.linalg.norm(away)
        two, radius, full = np.cross(normal, one), self.numbers["radius"], 2 * np.pi * self.numbers["turns"]
        cosine, sine = np.cos(full * s)[:, None], np.sin(full * s)[:, None]
        speed = (radius * full * rate)[:, None]
        return center + radius * (cosine * one + sine * two), speed * (cosine * two - sine * one)

    def _on_spline(self, s: Array, rate: Array) -> tuple[Array, Array]:
        from scipy.interpolate import make_interp_spline

        points = np.asarray(self.numbers["points"], float)
        legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if not (legs > 0).all():
            raise InputError(f"points {int(np.argmin(legs))} and {int(np.argmin(legs)) + 1} of the path are equal.")
        knots = np.concatenate([[0.0], np.cumsum(legs)]) / legs.sum()
        spline = make_interp_spline(knots, points, k=min(DEGREE, len(points) - 1))
        return spline(s), spline(s, 1) * rate[:, None]

    def coordinates(self, inputs: tuple[str, ...], home: Array) -> tuple[Array, Array]:
        """Coordinates and speeds (n, k) of inputs; inputs that are not named stay at ``home``."""
        s, rate = self.progress()
        ends = [self.numbers.get(name, (x, x)) for name, x in zip(inputs, home, strict=True)]
        first, last = np.array(ends, float).reshape(-1, 2).T
        return first + s[:, None] * (last - first), rate[:, None] * (last - first)


__all__ = ["ToolPath"]
