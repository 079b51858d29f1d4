"""Planes, spheres, lines and circles as models of a RANSAC: minimal and least-squares fits, and residuals.

They implement the two methods that scikit-image's `ransac` calls.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ... import objects
from ...core.multivector import Multivector
from ...core.registry import stock_algebra
from ...dispatch.formulas import ArrayOperand, evaluate
from ...status import Status

Array = NDArray[np.float64]
#: Rounds of a larger radius, in sizes of the cloud, count as flat.
MAX_RADIUS = 2.0


class Shape:
    """An object fitted to points whose coordinates are about one."""

    kind: ClassVar[str]
    #: Number of points that determine it.
    n_points: ClassVar[int]
    #: True for surfaces, False for curves.
    is_surface: ClassVar[bool]
    #: Required number of points, relative to a shape with fewer parameters.
    point_factor: ClassVar[float] = 1.0

    def __init__(self, x: Multivector) -> None:
        self.object = x
        self.row = np.concatenate([np.atleast_1d(v) for v in x.parameters()])

    @classmethod
    def from_estimate(cls, points: Array) -> Shape | None:
        """Object through a minimal number of points, or fitted to more; None if there is none."""
        x = cls.through(points) if len(points) == cls.n_points else cls.fit(points)
        if x._status is not None and x._status != Status.OK:
            return None
        shape = cls(x)
        is_round = cls.kind in ("sphere", "circle")
        return None if is_round and shape.row[-1] > MAX_RADIUS else shape

    @classmethod
    def through(cls, points: Array) -> Multivector:
        """The object through ``n_points`` points."""
        return getattr(_cga(), f"{cls.kind}_through")(*points)  # type: ignore[no-any-return]

    @classmethod
    def fit(cls, points: Array) -> Multivector:
        """The object of the least sum of squared distances."""
        return getattr(objects, f"fit_{cls.kind}")(points)  # type: ignore[no-any-return]

    def residuals(self, points: Array) -> Array:
        """Distances (n,), not negative; from a plane or a sphere, one formula for every curvature."""
        outcome = evaluate(_cga(), "fits.sphere_distance", self.object.dual(), _as_operand(points))
        return np.asarray(np.abs(outcome.values[0][:, 0]))


class PlaneShape(Shape):
    """A plane."""

    kind, n_points, is_surface = "plane", 3, True


class SphereShape(Shape):
    """A sphere."""

    kind, n_points, is_surface, point_factor = "sphere", 4, True, 1.2


class LineShape(Shape):
    """A line."""

    kind, n_points, is_surface = "line", 2, False

    def residuals(self, points: Array) -> Array:
        return np.asarray((_cga().point(points) ^ self.object).norm())


class CircleShape(Shape):
    """A circle."""

    kind, n_points, is_surface, point_factor = "circle", 3, False, 1.2

    def residuals(self, points: Array) -> Array:
        center, normal, radius = self.row[:3], self.row[3:6], self.row[6]
        sphere, plane = _cga().sphere(center, radius).dual(), _cga().plane(normal, normal @ center).dual()
        pair = evaluate(_cga(), "fits.circle_distances", sphere, plane, _as_operand(points)).values[0]
        return np.asarray(np.hypot(pair[:, 0], pair[:, 1]))


SHAPES: dict[str, type[Shape]] = {s.kind: s for s in (PlaneShape, SphereShape, LineShape, CircleShape)}


def _as_operand(points: Array) -> ArrayOperand:
    return ArrayOperand(points, _cga().kind("euclidean"), "the points")


def _cga() -> Any:
    return stock_algebra("cga3d")
