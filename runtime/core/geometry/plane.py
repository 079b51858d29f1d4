"""Motions of the plane: rotations about a point by an angle, the same in CGA and in PGA."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...common.validation import as_bool, real_array
from ...dispatch.formulas import ArrayOperand
from ...dispatch.item_statuses import invalidate, raise_first
from ...status import Status
from ..multivector import Multivector
from .euclidean import EuclideanAlgebra, is_origin
from .parameters import Parameters, parameters_class

PlaneRotor = parameters_class("Rotor", "angle", "point")


class PlaneMotions(EuclideanAlgebra):
    """An algebra whose versors move the Euclidean plane."""

    def rotor(self, angle: Any, point: Any = 0, strict: bool = False) -> Multivector:  # type: ignore[override]
        """Rotation by ``angle`` radians about a point, counter-clockwise."""
        at = np.zeros(2) if is_origin(point) else point
        operands = ArrayOperand(angle, 0, "angle"), self.spatial(at, "point")
        return self.construct("motions.planar_rotor", *operands, strict=strict)

    def motor_from_matrix(self, matrix: Any, strict: bool = False) -> Multivector:
        """Unit motor from homogeneous matrices (..., 3, 3).

        INVALID: the matrix is no rigid motion (to 1e-3; the rotation is made orthonormal within that).
        """
        m = real_array(matrix, "the matrix", (..., 3, 3)).astype(float)
        turned = self.rotor(np.arctan2(m[..., 1, 0], m[..., 0, 0]))
        moved = self.translator(np.ascontiguousarray(m[..., :2, 2])) * turned
        columns = m[..., :2, :2]
        defect = np.abs(np.swapaxes(columns, -1, -2) @ columns - np.eye(2)).max((-1, -2))
        turns = columns[..., 0, 0] * columns[..., 1, 1] - columns[..., 0, 1] * columns[..., 1, 0] > 0
        bad = ~((defect <= 1e-3) & turns & (m[..., 2, :] == [0, 0, 1]).all(-1))
        x = invalidate(moved.normalized(), bad)
        if as_bool(strict, "strict"):
            raise_first(x._status, "motor_from_matrix")
        return x

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
