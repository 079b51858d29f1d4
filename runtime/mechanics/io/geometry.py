"""Tables of files that mechanisms and simulations share: objects, orientations, units."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...common.documents import Table
from .fields import Direction, Number, Place, Positive, Unit, Vector, exactly_one, present_keys

#: Lengths of quaternions that are 1 but for the rounding of a file.
ROUNDED = 1e-3


class PointTable(Table):
    """A point; of a body, also by its name."""

    kind: Literal["point"]
    xyz: Place


class FlatPointTable(Table):
    """A point and infinity."""

    kind: Literal["flat_point"]
    xyz: Place


class PointPairTable(Table):
    """Two ends."""

    kind: Literal["point_pair"]
    a: Place
    b: Place


class DirectionTable(Table):
    """A direction without a place."""

    kind: Literal["direction"]
    v: Direction


class LineTable(Table):
    """A line through a point."""

    kind: Literal["line"]
    point: Place
    direction: Direction


class CircleTable(Table):
    """A circle about its normal."""

    kind: Literal["circle"]
    center: Place
    normal: Direction
    radius: Positive


class PlaneTable(Table):
    """The points with normal . x = offset, or the plane through a point."""

    kind: Literal["plane"]
    normal: Direction
    offset: Number | None = None
    point: Place | None = None

    @model_validator(mode="after")
    def _where(self) -> PlaneTable:
        exactly_one(self, "offset", "point")
        return self


class SphereTable(Table):
    """A sphere."""

    kind: Literal["sphere"]
    center: Place
    radius: Positive


AnyObject = Annotated[
    PointTable | FlatPointTable | PointPairTable | DirectionTable | LineTable | CircleTable | PlaneTable | SphereTable,
    Field(discriminator="kind"),
]


class OrientationTable(Table):
    """Body to world."""

    matrix: tuple[Vector, Vector, Vector] | None = None
    quaternion: tuple[Number, Number, Number, Number] | None = None
    axis: Direction | None = None
    angle: Number | None = None
    degrees: Number | None = None

    @model_validator(mode="after")
    def _check_one_form(self) -> OrientationTable:
        exactly_one(self, "matrix", "quaternion", "axis")
        if self.quaternion is not None and abs(math.hypot(*self.quaternion) - 1) > ROUNDED:
            raise ValueError("a quaternion w, x, y, z has the length 1")
        if self.axis is not None:
            exactly_one(self, "angle", "degrees")
        elif present_keys(self, "angle", "degrees"):
            raise ValueError("an angle goes with an axis")
        return self

    @property
    def rotation(self) -> tuple[Vector, float]:
        """Axis, of any length, and angle, where there is no matrix."""
        if self.quaternion is not None:
            w, x, y, z = self.quaternion
            axis = (x, y, z) if x or y or z else (0.0, 0.0, 1.0)
            return axis, 2 * math.atan2(math.hypot(x, y, z), w)
        assert self.axis is not None
        return self.axis, math.radians(self.degrees) if self.degrees is not None else self.angle or 0.0


class UnitsTable(Table):
    """Names of units; nothing is converted."""

    length: Unit = "m"
    mass: Unit = "kg"
    time: Unit = "s"
