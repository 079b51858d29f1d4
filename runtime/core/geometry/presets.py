"""Algebras that are made at first use: vectors of the plane and of space, spacetime, algebras of quadrics."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...dispatch.formulas import ArrayOperand
from ...dispatch.item_statuses import merge_statuses
from ...status import Status
from ..multivector import Multivector
from .euclidean import EuclideanAlgebra, Rotor, plane_vector
from .parameters import Parameters, parameters_class

PlaneAngle = parameters_class("Rotor", "angle")


class PlaneVectors(EuclideanAlgebra):
    """Vectors of the plane, Cl(2,0,0) on e1 e2: rotations about the origin."""

    readers = {"rotor": "rotor_parameters"}

    def rotor(self, angle: Any, strict: bool = False) -> Multivector:  # type: ignore[override]
        """Rotation by ``angle`` radians, counter-clockwise from e1 to e2."""
        return self.construct("motions.turn", ArrayOperand(angle, 0, "angle"), strict=strict)

    def rotor_parameters(self, x: Multivector) -> Parameters:
        """Angle in (-2 pi, 2 pi]; a full turn is -1."""
        angle = 2 * np.arctan2(-x["e12"], x["1"])
        return self.named_tuple(PlaneAngle, (angle,), x)


class SpaceVectors(EuclideanAlgebra):
    """Vectors of space, Cl(3,0,0) on e1 e2 e3: rotations about the origin."""

    readers = {"rotor": "rotor_parameters"}

    def rotor_parameters(self, x: Multivector) -> Parameters:
        """Unit axis and angle in [0, 2 pi); the point is the origin. The identity (NOT_UNIQUE) has the axis e3."""
        logarithm = x.log()
        plane = plane_vector(logarithm, self.space)
        half = np.linalg.norm(plane, axis=-1)
        with np.errstate(all="ignore"):
            axis = np.where((half > 0)[..., None], plane / half[..., None], np.eye(3, dtype=x.dtype)[-1])
        status = merge_statuses(logarithm._status, np.where(half > 0, np.uint8(Status.OK), np.uint8(Status.NOT_UNIQUE)))
        return self.named_tuple(Rotor, (axis + 0.0, 2 * half, np.zeros_like(axis)), x, status)  # no -0.0


class Spacetime(EuclideanAlgebra):
    """Spacetime, Cl(1,3,0) on e0 (time) e1 e2 e3, where the speed of light is 1."""

    def event(self, time: Any, position: Any, strict: bool = False) -> Multivector:
        """t e0 + x."""
        operands = ArrayOperand(time, 0, "time"), self.spatial(position, "position")
        return self.construct("spacetime.event", *operands, strict=strict)

    def velocity(self, v: Any, strict: bool = False) -> Multivector:
        """(e0 + v)/sqrt(1 - v^2), unit along the motion. INVALID: not slower than light."""
        return self.construct("spacetime.velocity", self.spatial(v, "v"), strict=strict)

    def boost(self, v: Any, strict: bool = False) -> Multivector:
        """The rotor that takes e0 to the velocity of v. INVALID: not slower than light."""
        return self.construct("spacetime.boost", self.spatial(v, "v"), strict=strict)

    def rotor(self, axis: Any, angle: Any, strict: bool = False) -> Multivector:  # type: ignore[override]
        """Rotation of space by ``angle`` radians, counter-clockwise about ``axis``. INVALID: the axis is zero."""
        operands = self.spatial(axis, "axis"), ArrayOperand(angle, 0, "angle")
        return self.construct("spacetime.rotor", *operands, strict=strict)


class QuadricAlgebra(EuclideanAlgebra):
    """Quadrics of space, Cl(9,6,0): points on nine vectors and their products in pairs."""

    def point(self, xyz: Any, strict: bool = False) -> Multivector:
        """The point of a position; ``point | quadric`` is the quadric's polynomial there."""
        return self.construct("quadrics.point", self.spatial(xyz, "xyz"), strict=strict)

    def quadric(self, squares: Any, mixed: Any, linear: Any, constant: Any, strict: bool = False) -> Multivector:
        """a x^2 + b y^2 + c z^2 + d x y + e x z + f y z + g x + h y + i z + j = 0.

        From (a, b, c), (d, e, f), (g, h, i) and j.
        """
        operands = [self.spatial(v, n) for v, n in ((squares, "squares"), (mixed, "mixed"), (linear, "linear"))]
        return self.construct("quadrics.quadric", *operands, ArrayOperand(constant, 0, "constant"), strict=strict)


class DoubleConformalAlgebra(EuclideanAlgebra):
    """Two copies of conformal geometry, Cl(8,2,0): points are bivectors, quartic surfaces as well."""

    def point(self, xyz: Any, strict: bool = False) -> Multivector:
        """The outer product of the two copies' points."""
        return self.construct("quadrics.double_point", self.spatial(xyz, "xyz"), strict=strict)


#: Class of each algebra that has a spec and no generated kernels.
CLASSES: dict[str, type[EuclideanAlgebra]] = {
    "vga2d": PlaneVectors,
    "vga3d": SpaceVectors,
    "sta": Spacetime,
    "qcga": QuadricAlgebra,
    "dcga": DoubleConformalAlgebra,
}
