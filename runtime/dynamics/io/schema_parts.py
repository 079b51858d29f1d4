"""Schema of loads and constraints in simulation files (docs/simulations.md)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...common.documents import Table
from ...mechanics.io.fields import Name, NotNegative, Place, Vector, present_keys
from ...mechanics.io.geometry import AnyObject, CircleTable, LineTable, PlaneTable, SphereTable

# -- loads -----------------------------------------------------------------------------------------------------


class OnBodyTable(Table):
    """Part of a body, by its name; a single body needs none."""

    body: Name | None = None


class WrenchTable(Table):
    """A force that passes through a point, a couple, or both."""

    force: Vector | None = None
    point: Place | None = None
    couple: Vector | None = None

    @model_validator(mode="after")
    def _something(self) -> WrenchTable:
        if not present_keys(self, "force", "couple"):
            raise ValueError("has neither force nor couple; one is needed")
        if self.point is not None and self.force is None:
            raise ValueError("a point goes with a force")
        return self


class GravityTable(Table):
    """Gravity on all bodies."""

    kind: Literal["gravity"]
    acceleration: Vector = (0.0, 0.0, -9.81)


class WorldWrenchTable(OnBodyTable, WrenchTable):
    """Wrench that is constant in the world."""

    kind: Literal["world_wrench"]


class BodyWrenchTable(OnBodyTable, WrenchTable):
    """Wrench that moves with the body."""

    kind: Literal["body_wrench"]


class SpringTable(OnBodyTable):
    """Spring from a point of the body to one of the world, or of another body."""

    kind: Literal["spring"]
    point: Place
    anchor: Place
    stiffness: NotNegative
    length: NotNegative = 0.0
    damping: NotNegative = 0.0
    other: Name | None = None


class DamperTable(OnBodyTable):
    """Drag in proportion to velocities."""

    kind: Literal["damper"]
    angular: NotNegative = 0.0
    linear: NotNegative = 0.0


AnyLoad = Annotated[
    GravityTable | WorldWrenchTable | BodyWrenchTable | SpringTable | DamperTable, Field(discriminator="kind")
]


# -- constraints -----------------------------------------------------------------------------------------------


Carrier = Annotated[LineTable | CircleTable | PlaneTable | SphereTable, Field(discriminator="kind")]


class BodyConstraintTable(OnBodyTable):
    """A constraint between a body and the world, or another body."""

    other: Name | None = None


class PinTable(BodyConstraintTable):
    """An object of the body that stays where an object of the world is: where it is at the start, by default."""

    kind: Literal["pin"]
    object: AnyObject
    world: AnyObject | None = None


class IncidenceTable(BodyConstraintTable):
    """A point of the body that stays on an object of the world."""

    kind: Literal["incidence"]
    point: Place
    on: Carrier


class VirtualPowerTable(BodyConstraintTable):
    """Wrenches of the world without power."""

    kind: Literal["virtual_power"]
    wrenches: Annotated[list[WrenchTable], Field(min_length=1, max_length=6)]


AnyConstraint = Annotated[PinTable | IncidenceTable | VirtualPowerTable, Field(discriminator="kind")]
