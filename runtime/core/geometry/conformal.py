"""Conformal geometry: `bladesmith.cga3d` and the plane's `bladesmith.cga2d` as makers and readers of objects.

Objects are direct and normalised: X^2 = +1 for point pairs, lines and circles, -1 for planes and spheres, and
X . n_inf = -1 for points. A bad value in one item (a radius that is not positive, NaN) gives that item, single
ones too, `Status.INVALID` and NaN; ``strict=True`` raises instead.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dispatch.formulas import ArrayOperand
from ..multivector import Multivector
from . import classification
from .euclidean import EuclideanAlgebra, Rotor, is_origin
from .parameters import parameters_class
from .plane import PlaneMotions

Point = parameters_class("Point", "xyz")
FlatPoint = parameters_class("FlatPoint", "xyz")
Direction = parameters_class("Direction", "v")
PointPair = parameters_class("PointPair", "a", "b")
Line = parameters_class("Line", "point", "direction")
Circle = parameters_class("Circle", "center", "normal", "radius")
PlaneCircle = parameters_class("Circle", "center", "radius")
Plane = parameters_class("Plane", "normal", "offset")
Sphere = parameters_class("Sphere", "center", "radius")
Dilator = parameters_class("Dilator", "scale", "center")
Transversor = parameters_class("Transversor", "t")


class Conformal(EuclideanAlgebra):
    """Conformal geometry of any dimension. Positions and directions are arrays (..., d)."""

    def point(self, xyz: Any, strict: bool = False) -> Multivector:
        """X = x^2/2 n_inf + x + n0."""
        return self.construct("conformal.point", self.spatial(xyz, "xyz"), strict=strict)

    def point_pair(self, a: Any, b: Any, strict: bool = False) -> Multivector:
        """A ^ B, normalised; from a to b. SINGULAR: a = b."""
        return self.construct("conformal.point_pair", self.spatial(a, "a"), self.spatial(b, "b"), strict=strict)

    def flat_point(self, xyz: Any, strict: bool = False) -> Multivector:
        """(x + n0) ^ n_inf."""
        return self.construct("conformal.flat_point", self.spatial(xyz, "xyz"), strict=strict)

    def direction(self, v: Any, strict: bool = False) -> Multivector:
        """v ^ n_inf, not normalised."""
        return self.construct("conformal.direction", self.spatial(v, "v"), strict=strict)

    def line(self, point: Any, direction: Any, strict: bool = False) -> Multivector:
        """Line through a point along a direction. INVALID: the direction is zero."""
        operands = self.spatial(point, "point"), self.spatial(direction, "direction")
        return self.construct("conformal.line", *operands, strict=strict)

    def line_through(self, a: Any, b: Any, strict: bool = False) -> Multivector:
        """A ^ B ^ n_inf, normalised: from a to b. SINGULAR: a = b."""
        return self.construct("conformal.line_through", self.spatial(a, "a"), self.spatial(b, "b"), strict=strict)

    def circle_through(self, a: Any, b: Any, c: Any, strict: bool = False) -> Multivector:
        """A ^ B ^ C, normalised, in the orientation of the points. SINGULAR: they are on a line."""
        return self._through("circle_through", (a, b, c), strict)

    def _through(self, name: str, points: tuple[Any, ...], strict: bool) -> Multivector:
        operands = [self.spatial(p, label) for p, label in zip(points, "abcd", strict=False)]
        return self.construct(f"conformal.{name}", *operands, strict=strict)

    def dilator(self, scale: Any, center: Any = 0, strict: bool = False) -> Multivector:
        """Scaling about a center. INVALID: the scale is not positive."""
        number = ArrayOperand(scale, 0, "scale")
        if is_origin(center):
            return self.construct("conformal.dilator", number, strict=strict)
        return self.construct("conformal.homothety", number, self.spatial(center, "center"), strict=strict)

    def transversor(self, t: Any, strict: bool = False) -> Multivector:
        """1 - t n0: inversion, translation by t, inversion."""
        return self.construct("conformal.transversor", self.spatial(t, "t"), strict=strict)

    def classify(self, x: Multivector) -> str | NDArray[np.str_]:
        """Names of the items: "circle", "line", ..., "imaginary sphere", "not a blade"; a str, or an array of them."""
        return classification.conformal(self, x)

    # -- readers -------------------------------------------------------------------------------------------

    def _read_point(self, x: Multivector) -> Any:
        return self.read(Point, "conformal.point_parameters", x)

    def _read_flat_point(self, x: Multivector) -> Any:
        return self.read(FlatPoint, "conformal.flat_point_parameters", x)

    def _read_direction(self, x: Multivector) -> Any:
        return self.read(Direction, "conformal.direction_parameters", x)

    def _read_point_pair(self, x: Multivector) -> Any:
        return self.read(PointPair, "conformal.point_pair_parameters", x)

    def _read_dilator(self, x: Multivector) -> Any:
        return self.read(Dilator, "conformal.dilator_parameters", x)

    def _read_transversor(self, x: Multivector) -> Any:
        return self.read(Transversor, "conformal.transversor_parameters", x)


class ConformalAlgebra(Conformal):
    """Conformal geometry of space, Cl(4,1,0) on e1 e2 e3 n0 n_inf."""

    readers = {
        "point": "_read_point", "flat_point": "_read_flat_point", "direction": "_read_direction",
        "point_pair": "_read_point_pair", "line": "_read_line", "circle": "_read_circle", "plane": "_read_plane",
        "sphere": "_read_sphere", "translator": "translator_parameters", "rotor": "rotor_parameters",
        "motor": "motor_parameters", "dilator": "_read_dilator", "homothety": "_read_dilator",
        "transversor": "_read_transversor",
    }  # fmt: skip

    def circle(self, center: Any, normal: Any, radius: Any, strict: bool = False) -> Multivector:
        """Circle, counter-clockwise about its normal. INVALID: the normal is zero, or the radius not positive."""
        operands = self.spatial(center, "center"), self.spatial(normal, "normal"), ArrayOperand(radius, 0, "radius")
        return self.construct("conformal.circle", *operands, strict=strict)

    def plane(self, normal: Any, offset: Any, strict: bool = False) -> Multivector:
        """Plane normal . x = offset; the normal need not be unit. INVALID: it is zero."""
        operands = self.spatial(normal, "normal"), ArrayOperand(offset, 0, "offset")
        return self.construct("conformal.plane", *operands, strict=strict)

    def plane_through(self, a: Any, b: Any, c: Any, strict: bool = False) -> Multivector:
        """A ^ B ^ C ^ n_inf, normalised, in the orientation of the points. SINGULAR: they are on a line."""
        return self._through("plane_through", (a, b, c), strict)

    def sphere(self, center: Any, radius: Any, strict: bool = False) -> Multivector:
        """Outward sphere. INVALID: the radius is not positive."""
        operands = self.spatial(center, "center"), ArrayOperand(radius, 0, "radius")
        return self.construct("conformal.sphere", *operands, strict=strict)

    def sphere_through(self, a: Any, b: Any, c: Any, d: Any, strict: bool = False) -> Multivector:
        """A ^ B ^ C ^ D, normalised, in the orientation of the points. SINGULAR: they are on a circle."""
        return self._through("sphere_through", (a, b, c, d), strict)

    def _read_line(self, x: Multivector) -> Any:
        return self.read(Line, "conformal.line_parameters", x)

    def _read_circle(self, x: Multivector) -> Any:
        return self.read(Circle, "conformal.circle_parameters", x)

    def _read_plane(self, x: Multivector) -> Any:
        return self.read(Plane, "conformal.plane_parameters", x)

    def _read_sphere(self, x: Multivector) -> Any:
        return self.read(Sphere, "conformal.sphere_parameters", x, orientation=2)


class ConformalPlane(PlaneMotions, Conformal):
    """Conformal geometry of the plane, Cl(3,1,0) on e1 e2 n0 n_inf."""

    readers = {
        "point": "_read_point", "point_pair": "_read_point_pair", "circle": "_read_circle", "motor": "motor_parameters",
    }  # fmt: skip

    def circle(self, center: Any, radius: Any, strict: bool = False) -> Multivector:
        """Circle, counter-clockwise. INVALID: the radius is not positive."""
        operands = self.spatial(center, "center"), ArrayOperand(radius, 0, "radius")
        return self.construct("conformal.sphere", *operands, strict=strict)

    def _read_circle(self, x: Multivector) -> Any:
        return self.read(PlaneCircle, "conformal.sphere_parameters", x, orientation=2)


__all__ = ["Conformal", "ConformalAlgebra", "ConformalPlane", "Rotor"]
