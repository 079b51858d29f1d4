"""Planes, spheres and discs: their parameters, and the distance of positions from them by a formula."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...core.geometry.euclidean import plain
from ...core.registry import stock_algebra
from ...dispatch.formulas import ArrayOperand, evaluate
from ...errors import SceneError
from ..scene import object_parameters, values
from .base import Surface

Array = NDArray[Any]


class Flat(Surface):
    """Base of the surfaces whose distance from a position has a formula."""

    #: Names of the attributes that the formula takes after the position.
    _measures: ClassVar[tuple[str, ...]]

    def contact(self, position: Any) -> tuple[Array, Array]:
        """Distance (...) of positions (..., 3) from the surface, and the unit normals (..., 3) there, either side.

        NaN where there is no normal, at the center of a sphere.
        """
        cga = stock_algebra("cga3d")
        attributes = ((name, getattr(self, name)) for name in self._measures)
        operands = [ArrayOperand(x, 0, name) if np.ndim(x) == 0 else cga.spatial(x, name) for name, x in attributes]
        distance, normal = evaluate(
            cga, f"rays.{self.kind}_contact", cga.spatial(position, "position"), *operands
        ).values
        return distance[..., 0], plain(normal)


class Plane(Flat):
    """The plane normal . x = offset, or a plane of the algebra."""

    kind = "plane"
    _measures = _shown = ("normal", "offset")

    def __init__(self, normal: Any, offset: float | None = None, *, material: Any = None) -> None:
        coefficients = object_parameters.coefficients(normal, "plane") if offset is None else None
        if coefficients is not None:
            normal, offset = object_parameters.read_object(coefficients, "plane")
            self.normal, self.offset = values.unit(normal, "normal"), float(offset)
        else:
            direction = values.finite(normal, "plane.normal", 3)
            self.normal = values.unit(direction, "plane.normal")
            length = float(direction @ self.normal)  # scaling the normal scales the offset
            self.offset = values.number(0.0 if offset is None else offset, "plane.offset") / length
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([[*self.normal, self.offset]])

    @property
    def flat_normal(self) -> Array:
        return self.normal


class Sphere(Flat):
    """A sphere by center and radius, or a sphere of the algebra.

    A tangent ray has its point twice, or not at all, by rounding.
    """

    kind = "sphere"
    center: Array
    _measures = _shown = ("center", "radius")

    def __init__(self, center: Any, radius: float | None = None, *, material: Any = None) -> None:
        if radius is None:
            coefficients = object_parameters.coefficients(center, "sphere")
            if coefficients is None:
                raise SceneError("sphere has no radius, and its first argument is not a sphere of the algebra.")
            self.center, radius = object_parameters.read_object(coefficients, "sphere")
            self.radius = float(radius)
        else:
            self.center = values.finite(center, "sphere.center", 3)
            self.radius = values.positive(radius, "sphere.radius")
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([[*self.center, self.radius]])


class Disc(Flat):
    """The flat inside of a circle, rim included, by center, normal and radius, or of a circle of the algebra.

    A ray in the disc's plane meets its rim: in two points, or in one where it is tangent. The normal there is that of
    the disc, on either side, as in the limit of grazing rays. A ray counts as in the plane up to rounding of its own
    and the disc's numbers: 8 units in the last place in slope, 16 in height. A steeper ray has the one point where it
    crosses the plane.
    """

    kind = "disc"
    _measures = _shown = ("center", "normal", "radius")

    def __init__(self, center: Any, normal: Any = None, radius: float | None = None, *, material: Any = None) -> None:
        value = center if normal is None and radius is None else (center, normal, radius)
        self.center, self.normal, self.radius = object_parameters.circle_parameters(value, "disc")
        super().__init__(material)

    @property
    def parameters(self) -> Array:
        return np.array([[*self.center, *self.normal, self.radius]])

    @property
    def flat_normal(self) -> Array:
        return self.normal
