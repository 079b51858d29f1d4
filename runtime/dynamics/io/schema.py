"""Schema of simulation files (docs/motion/simulations.md). Imported when one is read: pydantic is slow to import.

Errors that need the algebra, or more than one key, are found later by `reader`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...common.documents import Table
from ...mechanics.io.fields import (
    Direction,
    Label,
    Name,
    NotNegative,
    Place,
    Positive,
    Vector,
    at_most_one,
    exactly_one,
    present_keys,
)
from ...mechanics.io.geometry import OrientationTable, UnitsTable
from ...mechanics.io.joints import AnyJoint
from .fields import Chart, Color, Integrator, Stabilization
from .schema_parts import AnyConstraint, AnyLoad, OnBodyTable

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
    """Cylinder about an axis through its center of mass."""

    kind: Literal["cylinder"]
    radius: Positive
    height: Positive
    axis: Direction = (0.0, 0.0, 1.0)


class ConeTable(Table):
    """The axis points to its tip, 3/4 of the height from the center of mass."""

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
        exactly_one(self, "mass", "density")
        at_most_one(self, "moments", "tensor")
        if not present_keys(self, "moments", "tensor", "shape"):
            raise ValueError("has neither moments nor tensor nor shape; one of them gives its inertia")
        if self.density is not None and (self.shape is None or present_keys(self, "moments", "tensor")):
            raise ValueError("a density goes with a shape alone; moments and tensors include the mass")
        return self


# -- the run and what is drawn ---------------------------------------------------------------------------------


class SimulationTable(Table):
    """Duration, integrator and stored states."""

    duration: Positive
    step: Positive | None = None
    rtol: Positive | None = None
    atol: Positive | None = None
    interval: Positive | None = None
    times: Annotated[list[NotNegative], Field(min_length=1)] | None = None
    integrator: Integrator = "auto"
    map: Chart = "exponential"
    stabilization: Stabilization | None = None
    stabilisation: Stabilization | None = None
    baumgarte: Positive | None = None
    project: bool = False
    algebra: Literal["cga3d", "pga3d"] = "cga3d"

    @model_validator(mode="after")
    def _once(self) -> SimulationTable:
        at_most_one(self, "interval", "times")
        at_most_one(self, "stabilization", "stabilisation")
        if self.baumgarte is not None and "baumgarte" not in (self.stabilization, self.stabilisation):
            raise ValueError('the rate baumgarte goes with stabilization = "baumgarte"')
        return self


class TraceTable(OnBodyTable):
    """A point of a body whose path is drawn and written."""

    point: Place
    label: Label | None = None
    color: Color | None = None


class PictureTable(Table):
    """Appearance of pictures; angles in degrees."""

    title: Name | None = None
    elevation: Annotated[float, Field(ge=-90.0, le=90.0)] = 20.0
    azimuth: Annotated[float, Field(ge=-360.0, le=360.0)] = -60.0
    shown: list[NotNegative] | None = None
    objects: bool = True


class FileTable(Table):
    """A simulation file."""

    body: BodyTable | None = None
    bodies: list[BodyTable] = []
    loads: list[AnyLoad] = []
    constraints: list[AnyConstraint] = []
    joints: list[AnyJoint] = []
    simulation: SimulationTable
    traces: list[TraceTable] = []
    picture: PictureTable = PictureTable()
    units: UnitsTable = UnitsTable()
