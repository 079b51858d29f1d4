"""Planes, spheres and discs: what they are made of, and where positions lie on them without any ray."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...calls import Numbers
from ...errors import SceneError
from .. import values
from .base import Surface

Array = NDArray[Any]


class Flat(Surface):
    """Base of the surfaces whose distance from a position is a formula."""

    #: Attributes that the formula takes after the position.
    _measures: ClassVar[tuple[str, ...]]

    def contact(self, position: Any) -> tuple[Array, Array]:
        """Distance (...) of positions (..., 3) from the surface, and the unit normals (..., 3) there, either side.

        NaN where there is no normal, at the centre of a sphere.
        """
        from ... import cga3d as cga
        from ...calls import call
        from ...euclidean import plain

        given = ((name, getattr(self, name)) for name in self._measures)
        operands = [Numbers(x, 0, name) if np.ndim(x) == 0 else cga.vector(x, name) for name, x in given]
        distance, normal = call(cga, f"rays.{self.kind}_contact", cga.vector(position, "position"), *operands).values
        return distance[..., 0], plain(normal)


class Plane(Flat):
    """The plane normal . x = offset, or a plane of the algebra."""

    kind = "plane"
    _measures = ("normal", "offset")

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


class Sphere(Flat):
    """A sphere by centre and radius, or a sphere of the algebra.

    A ray that touches it has its point twice, or none where rounding takes it past.
    """

    kind = "sphere"
    _measures = ("center", "radius")

    def __init__(self, center: Any, radius: float | None = None, *, material: Any = None) -> None:
        if radius is None:
            given = values.coefficients(center, "sphere")
            if given is None:
                raise SceneError("sphere has no radius, and what is given is no sphere of the algebra.")
            self.center, self.radius = values.read_sphere(given)
        else:
            self.center = values.finite(center, "sphere.center", 3)
            self.radius = values.positive(radius, "sphere.radius")
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([[*self.center, self.radius]])


class Disc(Flat):
    """The flat inside of a circle, rim included, by centre, normal and radius, or of a circle of the algebra.

    A ray in the disc's plane meets its rim: in two points, or in one where it touches. The normal there is that of
    the disc, either side, as for rays that come ever flatter. A ray lies in the plane to rounding of the numbers that
    ray and disc are made of: 8 units in the last place in slope, 16 in height. One that is tilted more has the one
    point where it passes through the plane.
    """

    kind = "disc"
    _measures = ("center", "normal", "radius")

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
