"""Planes, spheres and discs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from .. import values
from .base import Surface

Array = NDArray[Any]


class Plane(Surface):
    """The plane normal . x = offset, or a plane of the algebra."""

    kind = "plane"

    def __init__(self, normal: Any, offset: float | None = None, *, material: Any = None) -> None:
        given = values.coefficients(normal, "plane") if offset is None else None
        if given is not None:
            self.normal, self.offset = values.read_plane(given)
        else:
            raw = values.finite(normal, "plane.normal", 3)
            self.normal = values.unit(raw, "plane.normal")
            length = float(raw @ self.normal)  # scaling the normal scales the offset
            self.offset = values.number(0.0 if offset is None else offset, "plane.offset") / length
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([[*self.normal, self.offset]])

    @property
    def flat_normal(self) -> Array:
        return self.normal


class Sphere(Surface):
    """A sphere by centre and radius, or a sphere of the algebra."""

    kind = "sphere"

    def __init__(self, center: Any, radius: float | None = None, *, material: Any = None) -> None:
        if radius is None:
            given = values.coefficients(center, "sphere")
            if given is None:
                raise SceneError("sphere has no radius.")
            self.center, self.radius = values.read_sphere(given)
        else:
            self.center = values.finite(center, "sphere.center", 3)
            self.radius = values.positive(radius, "sphere.radius")
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([[*self.center, self.radius]])


class Disc(Surface):
    """The flat inside of a circle, by centre, normal and radius, or of a circle of the algebra."""

    kind = "disc"

    def __init__(self, center: Any, normal: Any = None, radius: float | None = None, *, material: Any = None) -> None:
        value = center if normal is None and radius is None else (center, normal, radius)
        self.center, self.normal, self.radius = values.circle(value, "disc")
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([[*self.center, *self.normal, self.radius]])

    @property
    def flat_normal(self) -> Array:
        return self.normal
