"""Planes, spheres, lines and circles as the models of a RANSAC: through a few points, fitted to many, and distances.

They have the two methods that scikit-image's `ransac` calls.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .. import objects
from ..calls import Numbers, call
from ..loading import stock_algebra
from ..multivector import Multivector
from ..status import Status

Array = NDArray[np.float64]
#: Rounds larger than this many times the cloud are flat.
LARGEST_RADIUS = 2.0


class Shape:
    """An object among points whose coordinates are about one."""

    kind: ClassVar[str]
    #: Points that determine it.
    needs: ClassVar[int]
    #: Whether it is filled with points in two dimensions, or in one.
    is_surface: ClassVar[bool]
    #: How many times more points than a shape of less freedom it must have.
    handicap: ClassVar[float] = 1.0

    def __init__(self, x: Multivector) -> None:
        self.object = x
        self.row = np.concatenate([np.atleast_1d(v) for v in x.parameters()])

    @classmethod
    def from_estimate(cls, points: Array) -> Shape | None:
        """The object through just enough points, or next to more; None where there is none."""
        x = cls.through(points) if len(points) == cls.needs else cls.fitted(points)
        if x._status is not None and x._status != Status.OK:
            return None
        shape = cls(x)
        is_round = cls.kind in ("sphere", "circle")
        return None if is_round and shape.row[-1] > LARGEST_RADIUS else shape

    @staticmethod
    def through(points: Array) -> Multivector:
        """The object through ``needs`` points."""
        raise NotImplementedError

    @staticmethod
    def fitted(points: Array) -> Multivector:
        """The object at the least sum of squared distances."""
        raise NotImplementedError

    def residuals(self, points: Array) -> Array:
        """Distances (n,), not negative."""
        raise NotImplementedError


class PlaneShape(Shape):
    """A plane."""

    kind, needs, is_surface = "plane", 3, True

    @staticmethod
    def through(points: Array) -> Multivector:
        return _cga().plane_through(*points)  # type: ignore[no-any-return]

    @staticmethod
    def fitted(points: Array) -> Multivector:
        return objects.fit_plane(points)  # type: ignore[no-any-return]

    def residuals(self, points: Array) -> Array:
        return _distances(self.object, points)


class SphereShape(Shape):
    """A sphere."""

    kind, needs, is_surface, handicap = "sphere", 4, True, 1.2

    @staticmethod
    def through(points: Array) -> Multivector:
        return _cga().sphere_through(*points)  # type: ignore[no-any-return]

    @staticmethod
    def fitted(points: Array) -> Multivector:
        return objects.fit_sphere(points)  # type: ignore[no-any-return]

    def residuals(self, points: Array) -> Array:
        return _distances(self.object, points)


class LineShape(Shape):
    """A line."""

    kind, needs, is_surface = "line", 2, False

    @staticmethod
    def through(points: Array) -> Multivector:
        return _cga().line_through(*points)  # type: ignore[no-any-return]

    @staticmethod
    def fitted(points: Array) -> Multivector:
        return objects.fit_line(points)  # type: ignore[no-any-return]

    def residuals(self, points: Array) -> Array:
        return np.asarray((_cga().point(points) ^ self.object).norm())


class CircleShape(Shape):
    """A circle."""

    kind, needs, is_surface, handicap = "circle", 3, False, 1.2

    @staticmethod
    def through(points: Array) -> Multivector:
        return _cga().circle_through(*points)  # type: ignore[no-any-return]

    @staticmethod
    def fitted(points: Array) -> Multivector:
        return objects.fit_circle(points)  # type: ignore[no-any-return]

    def residuals(self, points: Array) -> Array:
        center, normal, radius = self.row[:3], self.row[3:6], self.row[6]
        sphere, plane = _cga().sphere(center, radius).dual(), _cga().plane(normal, normal @ center).dual()
        pair = call(_cga(), "fits.circle_distances", sphere, plane, _positions(points)).values[0]
        return np.asarray(np.hypot(pair[:, 0], pair[:, 1]))


SHAPES: dict[str, type[Shape]] = {s.kind: s for s in (PlaneShape, SphereShape, LineShape, CircleShape)}


def _distances(x: Multivector, points: Array) -> Array:
    """Distances from a plane or a sphere: one formula serves every curvature."""
    return np.asarray(np.abs(call(_cga(), "fits.sphere_distance", x.dual(), _positions(points)).values[0][:, 0]))


def _positions(points: Array) -> Numbers:
    return Numbers(points, _cga().kind("euclidean"), "the points")


def _cga() -> Any:
    return stock_algebra("cga3d")
