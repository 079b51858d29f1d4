"""The schema of simulation files (docs/simulations.md). Imported when one is read: pydantic is slow to import.

What needs the algebra, or more than one key, is found later by `document`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from ..tomlread import Table
from .methods import INTEGRATORS, MAPS, STABILIZATIONS
from .sketch import COLORS

#: Larger numbers have squares and cubes that are none.
LARGEST = 1e60
#: Letters of a name, of a label and of a unit.
MOST_LETTERS, MOST_OF_UNIT = 60, 12

Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Field(gt=0.0, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Vector = tuple[Number, Number, Number]


def _nonzero(v: Vector) -> Vector:
    if not any(v):
        raise ValueError("a direction is not zero")
    return v


def _place(value: Any) -> Any:
    """Three numbers, or the name of a body's point."""
    if isinstance(value, str):
        return value
    if isinstance(value, list) and len(value) == 3 and all(_is_number(x) for x in value):
        return tuple(float(x) for x in value)
    raise ValueError("three numbers, or the name of one of the body's points, are needed")


def _is_number(x: Any) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool) and abs(x) <= LARGEST


def _name(text: str) -> str:
    if not text or len(text) > MOST_LETTERS or not text[0].isalnum() or not text.isprintable():
        raise ValueError(f"it begins with a letter or digit, and has {MOST_LETTERS} printable letters at most")
    return text


def _unit(text: str) -> str:
    if len(text) > MOST_OF_UNIT or not all(c.isalnum() or c in " /^.*%-" for c in text):
        raise ValueError(f"a unit has {MOST_OF_UNIT} letters, digits and / ^ . * % - at most")
    return text


def _color(text: str) -> str:
    hexadecimal = len(text) == 7 and text[0] == "#" and all(c in "0123456789abcdefABCDEF" for c in text[1:])
    return text if hexadecimal else _one_of(text, [*COLORS, "#rrggbb"])


def _one_of(text: str, known: Sequence[str]) -> str:
    if text not in known or text == "#rrggbb":
        raise PydanticCustomError("literal_error", "unknown", {"expected": ", ".join(f"'{x}'" for x in known)})
    return text


Direction = Annotated[Vector, AfterValidator(_nonzero)]
Place = Annotated[Any, AfterValidator(_place)]
Name = Annotated[str, AfterValidator(_name)]
Unit = Annotated[str, AfterValidator(_unit)]
Color = Annotated[str, AfterValidator(_color)]
Integrator = Annotated[str, AfterValidator(lambda x: _one_of(x, ("auto", *INTEGRATORS)))]
Chart = Annotated[str, AfterValidator(lambda x: _one_of(x, MAPS))]
Stabilization = Annotated[str, AfterValidator(lambda x: _one_of(x, STABILIZATIONS))]


def given(table: Table, *keys: str) -> list[str]:
    """Those of the keys that a table has."""
    return [key for key in keys if getattr(table, key) is not None]


def _exactly_one(table: Table, *keys: str) -> None:
    found = given(table, *keys)
    if not found:
        raise ValueError(f"has neither {' nor '.join(keys)}; one is needed")
    _one_at_most(table, *keys)


def _one_at_most(table: Table, *keys: str) -> None:
    found = given(table, *keys)
    if len(found) > 1:
        raise ValueError(f"{' and '.join(found)} say the same thing; give one of them")


# -- bodies ----------------------------------------------------------------------------------------------------


class BoxTable(Table):
    """Sides along the body's axes."""

    kind: Literal["box"]
    size: tuple[Positive, Positive, Positive]


class SphereShapeTable(Table):
    """A ball."""

    kind: Literal["sphere"]
    radius: Positive


class CylinderTable(Table):
    """About an axis through its centre of mass."""

    kind: Literal["cylinder"]
    radius: Positive
    height: Positive
    axis: Direction = (0.0, 0.0, 1.0)


class ConeTable(Table):
    """The axis points to its tip, 3/4 of the height from the centre of mass."""

    kind: Literal["cone"]
    radius: Positive
    height: Positive
    axis: Direction = (0.0, 0.0, 1.0)


class RodTable(Table):
    """A thin cylinder."""

    kind: Literal["rod"]
    length: Positive
    radius: Positive | None = None
    axis: Direction = (0.0, 0.0, 1.0)


class MeshTable(Table):
    """The solid inside a closed mesh; the path is from the file's folder."""

    kind: Literal["mesh"]
    path: str
    scale: Positive = 1.0


AnyShape = Annotated[
    BoxTable | SphereShapeTable | CylinderTable | ConeTable | RodTable | MeshTable, Field(discriminator="kind")
]


class OrientationTable(Table):
    """Body to world."""

    matrix: tuple[Vector, Vector, Vector] | None = None
    axis: Direction | None = None
    angle: Number | None = None
    degrees: Number | None = None

    @model_validator(mode="after")
    def _one_way(self) -> OrientationTable:
        _exactly_one(self, "matrix", "axis")
        if self.axis is not None:
            _exactly_one(self, "angle", "degrees")
        elif given(self, "angle", "degrees"):
            raise ValueError("an angle goes with an axis")
        return self

    @property
    def radians(self) -> float:
        """The angle."""
        return math.radians(self.degrees) if self.degrees is not None else self.angle or 0.0


class BodyTable(Table):
    """A body: inertia by its shape, or by numbers; points in the body's coordinates, axes of inertia anywhere."""

    name: Name = "body"
    mass: Positive | None = None
    density: Positive | None = None
    moments: tuple[Positive, Positive, Positive] | None = None
    tensor: tuple[Vector, Vector, Vector] | None = None
    shape: AnyShape | None = None
    center: Vector | None = None
    points: dict[Name, Vector] = {}
    position: Vector = (0.0, 0.0, 0.0)
    position_point: Place | None = None
    orientation: OrientationTable | None = None
    velocity: Vector = (0.0, 0.0, 0.0)
    velocity_point: Place | None = None
    angular_velocity: Vector = (0.0, 0.0, 0.0)
    color: Color | None = None

    @model_validator(mode="after")
    def _inertia(self) -> BodyTable:
        _exactly_one(self, "mass", "density")
        _one_at_most(self, "moments", "tensor")
        if not given(self, "moments", "tensor", "shape"):
            raise ValueError("has neither moments nor tensor nor shape; one of them gives its inertia")
        if self.density is not None and (self.shape is None or given(self, "moments", "tensor")):
            raise ValueError("a density goes with a shape alone; moments and tensors include the mass")
        return self


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
        _exactly_one(self, "offset", "point")
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


# -- the run and what is drawn ---------------------------------------------------------------------------------


class SimulationTable(Table):
    """How long, how, and what is stored."""

    duration: Positive
    step: Positive | None = None
    rtol: Positive | None = None
    atol: Positive | None = None
    interval: Positive | None = None
    times: list[NotNegative] | None = None
    integrator: Integrator = "auto"
    map: Chart = "exponential"
    stabilization: Stabilization | None = None
    stabilisation: Stabilization | None = None
    algebra: Literal["cga3d", "pga3d"] = "cga3d"

    @model_validator(mode="after")
    def _once(self) -> SimulationTable:
        _one_at_most(self, "interval", "times")
        _one_at_most(self, "stabilization", "stabilisation")
        return self


class TraceTable(OnBody):
    """A point of a body whose path is drawn and written."""

    point: Place
    label: Name | None = None
    color: Color | None = None


class PictureTable(Table):
    """How pictures look; degrees."""

    title: Name | None = None
    elevation: Annotated[float, Field(ge=-90.0, le=90.0)] = 20.0
    azimuth: Annotated[float, Field(ge=-360.0, le=360.0)] = -60.0
    shown: list[NotNegative] | None = None
    objects: bool = True


class UnitsTable(Table):
    """What numbers are called; nothing is converted."""

    length: Unit = "m"
    mass: Unit = "kg"
    time: Unit = "s"


class FileTable(Table):
    """A simulation file."""

    body: BodyTable | None = None
    bodies: list[BodyTable] = []
    loads: list[AnyLoad] = []
    constraints: list[AnyConstraint] = []
    simulation: SimulationTable
    traces: list[TraceTable] = []
    picture: PictureTable = PictureTable()
    units: UnitsTable = UnitsTable()
