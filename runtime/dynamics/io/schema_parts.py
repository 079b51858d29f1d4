"""Schema of loads and constraints in simulation files (docs/motion/simulations.md)."""

from __future__ import annotations

import math
from dataclasses import MISSING, fields
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, create_model, model_validator

from ...common.documents import Table
from ...mechanics.arguments import GRAVITY
from ...mechanics.io.fields import Name, NotNegative, Number, Place, Vector, present_keys
from ...mechanics.io.geometry import AnyObject, CircleTable, LineTable, PlaneTable, SphereTable
from ..model.joint_loads import JointDamper, JointFriction, JointLimit, JointLoad, JointSpring, JointTorque
from ..model.loads import BODY_LAWS, BodyLaw

# -- loads -----------------------------------------------------------------------------------------------------


class OnBodyTable(Table):
    """Part of a body, by its name; a single body needs none."""

    body: Name | None = None


class BetweenBodiesTable(OnBodyTable):
    """What is between a body and the world, or another body."""

    other: Name | None = None


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
    acceleration: Vector = GRAVITY


class WorldWrenchTable(OnBodyTable, WrenchTable):
    """Wrench that is constant in the world."""

    kind: Literal["world_wrench"]


class BodyWrenchTable(OnBodyTable, WrenchTable):
    """Wrench that moves with the body."""

    kind: Literal["body_wrench"]


class SpringTable(BetweenBodiesTable):
    """Spring from a point of the body to one of the world, or of another body."""

    kind: Literal["spring"]
    point: Place
    anchor: Place
    stiffness: NotNegative
    length: NotNegative = 0.0
    damping: NotNegative = 0.0


def _law_table(law: type[BodyLaw]) -> type[OnBodyTable]:
    """The table of a law of loads: its numbers, which are zero by default."""
    numbers: dict[str, Any] = {name: (NotNegative, 0.0) for name in law.numbers}
    name, text = f"{law.__name__}Table", (law.__doc__ or "").partition("\n")[0]
    kind: Any = Literal[law.kind]
    return create_model(name, __base__=BetweenBodiesTable, __doc__=text, kind=(kind, ...), **numbers)


#: Tables of laws of loads, and what they are of.
LAW_TABLES = {_law_table(law): law for law in BODY_LAWS}


class JointLoadTable(Table):
    """Part of a load on a joint, by the joint's name."""

    joint: Name
    freedom: Annotated[int, Field(ge=0, le=5)] = 0


def _joint_table(load: type[JointLoad]) -> type[JointLoadTable]:
    """The table of a load on a joint: its numbers and their defaults; limits that are left out are none."""
    limits = {"lower": -math.inf, "upper": math.inf}
    numbers: dict[str, Any] = {}
    for each in fields(load):  # type: ignore[arg-type]
        if each.name not in JointLoadTable.model_fields:
            default = limits.get(each.name, ... if each.default is MISSING else float(each.default))
            numbers[each.name] = (Number, default)
    name, text = f"{load.__name__}Table", (load.__doc__ or "").partition("\n")[0]
    kind: Any = Literal[f"joint_{load.__name__.removeprefix('Joint').lower()}"]
    return create_model(name, __base__=JointLoadTable, __doc__=text, kind=(kind, ...), **numbers)


#: The same of loads on joints.
JOINT_TABLES = {_joint_table(load): load for load in (JointTorque, JointSpring, JointDamper, JointFriction, JointLimit)}

if TYPE_CHECKING:
    AnyLoad = GravityTable | WorldWrenchTable | BodyWrenchTable | SpringTable | OnBodyTable | JointLoadTable
else:
    _TABLES = (GravityTable, WorldWrenchTable, BodyWrenchTable, SpringTable, *LAW_TABLES, *JOINT_TABLES)
    AnyLoad = Annotated[reduce(or_, _TABLES), Field(discriminator="kind")]


# -- constraints -----------------------------------------------------------------------------------------------


Carrier = Annotated[LineTable | CircleTable | PlaneTable | SphereTable, Field(discriminator="kind")]


class PinTable(BetweenBodiesTable):
    """An object of the body that stays where an object of the world is: where it is at the start, by default."""

    kind: Literal["pin"]
    object: AnyObject
    world: AnyObject | None = None


class IncidenceTable(BetweenBodiesTable):
    """A point of the body that stays on an object of the world."""

    kind: Literal["incidence"]
    point: Place
    on: Carrier


class VirtualPowerTable(BetweenBodiesTable):
    """Wrenches of the world without power."""

    kind: Literal["virtual_power"]
    wrenches: Annotated[list[WrenchTable], Field(min_length=1, max_length=6)]


AnyConstraint = Annotated[PinTable | IncidenceTable | VirtualPowerTable, Field(discriminator="kind")]
