"""The schema of what acts on bodies and what holds them: loads, constraints, joints (docs/simulations.md)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ..tomlread import Table
from .schema_values import Direction, Name, NotNegative, Number, Place, Positive, Vector, exactly_one, given

# -- loads -----------------------------------------------------------------------------------------------------


class OnBody(Table):
    """What belongs to a body; with a single one there is no need to name it."""

    body: Name | None = None


class Wrench(Table):
    """A force that passes through a point, a couple, or both."""

    force: Vector | None = None
    point: Place | None = None
    couple: Vector | None = None

    @model_validator(mode="after")
    def _something(self) -> Wrench:
        if not given(self, "force", "couple"):
            raise ValueError("has neither force nor couple; one is needed")
        if self.point is not None and self.force is None:
            raise ValueError("a point goes with a force")
        return self


class GravityTable(Table):
    """On all bodies."""

    kind: Literal["gravity"]
    acceleration: Vector = (0.0, 0.0, -9.81)


class WorldWrenchTable(OnBody, Wrench):
    """Constant in the world."""

    kind: Literal["world_wrench"]


class BodyWrenchTable(OnBody, Wrench):
    """Turns and moves with the body."""

    kind: Literal["body_wrench"]


class SpringTable(OnBody):
    """From a point of the body to one of the world, or of another body."""

    kind: Literal["spring"]
    point: Place
    anchor: Place
    stiffness: NotNegative
    length: NotNegative = 0.0
    damping: NotNegative = 0.0
    other: Name | None = None


class DamperTable(OnBody):
    """Drag."""

    kind: Literal["damper"]
    angular: NotNegative = 0.0
    linear: NotNegative = 0.0


AnyLoad = Annotated[
    GravityTable | WorldWrenchTable | BodyWrenchTable | SpringTable | DamperTable, Field(discriminator="kind")
]


# -- constraints -----------------------------------------------------------------------------------------------


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
Carrier = Annotated[LineTable | CircleTable | PlaneTable | SphereTable, Field(discriminator="kind")]


class Held(OnBody):
    """A constraint between a body and the world, or another body."""

    other: Name | None = None


class PinTable(Held):
    """An object of the body that stays where an object of the world is: where it is at the start, by default."""

    kind: Literal["pin"]
    object: AnyObject
    world: AnyObject | None = None


class IncidenceTable(Held):
    """A point of the body that stays on an object of the world."""

    kind: Literal["incidence"]
    point: Place
    on: Carrier


class VirtualPowerTable(Held):
    """Wrenches of the world that find no power."""

    kind: Literal["virtual_power"]
    wrenches: Annotated[list[Wrench], Field(min_length=1, max_length=6)]


AnyConstraint = Annotated[PinTable | IncidenceTable | VirtualPowerTable, Field(discriminator="kind")]


# -- joints ----------------------------------------------------------------------------------------------------


class Between(Table):
    """A joint between two bodies; places and directions are those of the world at the start."""

    a: Name
    b: Name


class SphericalTable(Between):
    """Turning about a point."""

    kind: Literal["spherical"]
    point: Vector


class RevoluteTable(Between):
    """Turning about an axis."""

    kind: Literal["revolute"]
    point: Vector
    axis: Direction


class CylindricalTable(Between):
    """Turning about an axis and sliding along it."""

    kind: Literal["cylindrical"]
    point: Vector
    axis: Direction


class PrismaticTable(Between):
    """Sliding along an axis."""

    kind: Literal["prismatic"]
    point: Vector = (0.0, 0.0, 0.0)
    axis: Direction


class PlanarTable(Between):
    """Sliding in a plane and turning about its normal."""

    kind: Literal["planar"]
    point: Vector
    normal: Direction


class UniversalTable(Between):
    """Two axes at right angles, one of each body."""

    kind: Literal["universal"]
    point: Vector
    axis_a: Direction
    axis_b: Direction


AnyJoint = Annotated[
    SphericalTable | RevoluteTable | CylindricalTable | PrismaticTable | PlanarTable | UniversalTable,
    Field(discriminator="kind"),
]
