"""Motions of the plane: rotations about a point by an angle, the same in CGA and in PGA."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dispatch.formulas import ArrayOperand
from ...dispatch.item_statuses import invalidate
from ...status import Status
from ..multivector import Multivector
from .euclidean import EuclideanAlgebra, is_origin
from .parameters import Parameters, parameters_class

PlaneRotor = parameters_class("Rotor", "angle", "point")


class PlaneMotions(EuclideanAlgebra):
    """An algebra whose versors move the Euclidean plane."""

    def rotor(self, angle: Any, point: Any = 0, strict: bool = False) -> Multivector:  # type: ignore[override]
        """Rotation about a point, counter-clockwise."""
        at = np.zeros(2) if is_origin(point) else point
        operands = ArrayOperand(angle, 0, "angle"), self.spatial(at, "point")
        return self.construct("motions.planar_rotor", *operands, strict=strict)

    def motor_from_matrix(self, matrix: Any, strict: bool = False) -> Multivector:
        """Unit motor from homogeneous matrices (..., 3, 3)."""
        m: NDArray[Any] = np.asarray(matrix, float)
        turned = self.rotor(np.arctan2(m[..., 1, 0], m[..., 0, 0]))
        moved = self.translator(np.ascontiguousarray(m[..., :2, 2])) * turned
        columns = m[..., :2, :2]
        defect = np.abs(np.swapaxes(columns, -1, -2) @ columns - np.eye(2)).max((-1, -2))
        bad = (defect > 1e-3) | (np.linalg.det(columns) < 0)
        return invalidate(moved.normalized(), bad)

    def motor_parameters(self, x: Multivector) -> Parameters:
        """Angle in (-pi, pi] and fixed point of a motion; for a translation the point is NaN, with `SINGULAR`."""
        matrix = self.matrix(x)
        angle = np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0])
        t = matrix[..., :2, 2]
        with np.errstate(all="ignore"):
            across = np.stack([-t[..., 1], t[..., 0]], -1) / np.tan(angle / 2)[..., None]
            point = np.where((angle != 0)[..., None], (t + across) / 2, np.nan)
        status = np.where(angle == 0, np.uint8(Status.SINGULAR), np.uint8(Status.OK))
        return self.named_tuple(PlaneRotor, (angle, point), x, status)
