"""Plane-based projective geometry: `bladesmith.pga3d`, and `pga2d` of the plane, as makers and readers of objects.

Planes are vectors n + d e0 with n . x = d; they meet by ``^`` in lines and points, and ``&`` joins. X ~X = +1 for
planes, lines and points. Bad values in items are treated as in `conformal`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dispatch.formulas import ArrayOperand
from ..multivector import Multivector
from . import classification
from .euclidean import EuclideanAlgebra
from .parameters import parameters_class
from .plane import PlaneMotions

Point = parameters_class("Point", "xyz")
Direction = parameters_class("Direction", "v")
Line = parameters_class("Line", "point", "direction")
Plane = parameters_class("Plane", "normal", "offset")
PlaneLine = parameters_class("Line", "normal", "offset")


class Projective(EuclideanAlgebra):
    """Points of plane-based geometry in space and in the plane."""

    def point(self, xyz: Any, strict: bool = False) -> Multivector:
        """(e1 + x1 e0) ^ (e2 + x2 e0) ^ ...: the meet of its coordinate planes; lines, in the plane."""
        return self.construct("projective.point", self.spatial(xyz, "xyz"), strict=strict)

    def direction(self, v: Any, strict: bool = False) -> Multivector:
        """A point at infinity: the difference of two points. Not normalised."""
        return self.construct("projective.direction", self.spatial(v, "v"), strict=strict)

    def _read_point(self, x: Multivector) -> Any:
        return self.read(Point, "projective.point_parameters", x)

    def _read_direction(self, x: Multivector) -> Any:
        return self.read(Direction, "projective.direction_parameters", x)


class ProjectiveAlgebra(Projective):
    """Plane-based geometry of space, Cl(3,0,1) on e0 e1 e2 e3."""

    readers = {
        "point": "_read_point", "direction": "_read_direction", "line": "_read_line", "plane": "_read_plane",
        "translator": "translator_parameters", "rotor": "rotor_parameters", "motor": "motor_parameters",
    }  # fmt: skip

    def line(self, point: Any, direction: Any, strict: bool = False) -> Multivector:
        """Line through a point along a direction. INVALID: the direction is zero."""
        operands = self.spatial(point, "point"), self.spatial(direction, "direction")
        return self.construct("projective.line", *operands, strict=strict)

    def line_through(self, a: Any, b: Any, strict: bool = False) -> Multivector:
        """Line from a to b, normalised. SINGULAR: a = b."""
        return self.construct("projective.line_through", self.spatial(a, "a"), self.spatial(b, "b"), strict=strict)

    def plane(self, normal: Any, offset: Any, strict: bool = False) -> Multivector:
        """Plane normal . x = offset; the normal need not be unit. INVALID: it is zero."""
        operands = self.spatial(normal, "normal"), ArrayOperand(offset, 0, "offset")
        return self.construct("projective.plane", *operands, strict=strict)

    def plane_through(self, a: Any, b: Any, c: Any, strict: bool = False) -> Multivector:
        """Plane through three points, in their orientation. SINGULAR: they are on a line."""
        operands = [self.spatial(p, label) for p, label in ((a, "a"), (b, "b"), (c, "c"))]
        return self.construct("projective.plane_through", *operands, strict=strict)

    def classify(self, x: Multivector) -> str | NDArray[np.str_]:
        """Names of the items: "point", "line", "line at infinity", ..., "not a blade"; a str, or an array of them."""
        return classification.projective(self, x)

    def _read_line(self, x: Multivector) -> Any:
        return self.read(Line, "projective.line_parameters", x)

    def _read_plane(self, x: Multivector) -> Any:
        return self.read(Plane, "projective.plane_parameters", x)


class ProjectivePlane(PlaneMotions, Projective):
    """Line-based geometry of the plane, Cl(2,0,1) on e0 e1 e2: lines are vectors n + d e0 with n . x = d."""

    readers = {
        "point": "_read_point", "direction": "_read_direction", "line": "_read_line",
        "translator": "translator_parameters", "rotor": "motor_parameters", "motor": "motor_parameters",
    }  # fmt: skip

    def line(self, normal: Any, offset: Any, strict: bool = False) -> Multivector:
        """Line normal . x = offset; the normal need not be unit. INVALID: it is zero."""
        operands = self.spatial(normal, "normal"), ArrayOperand(offset, 0, "offset")
        return self.construct("projective.plane", *operands, strict=strict)

    def line_through(self, a: Any, b: Any, strict: bool = False) -> Multivector:
        """Line from a to b, normalised. SINGULAR: a = b."""
        return self.construct("projective.line_in_plane", self.spatial(a, "a"), self.spatial(b, "b"), strict=strict)

    def _read_line(self, x: Multivector) -> Any:
        return self.read(PlaneLine, "projective.plane_parameters", x)
