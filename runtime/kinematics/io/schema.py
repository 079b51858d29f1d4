"""The schema of mechanism files (docs/mechanisms.md). Imported when one is read: pydantic is slow to import.

What needs the algebra, or more than one key, is found later by `document`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ..dynamics.schema import OrientationTable, UnitsTable
from ..dynamics.schema_parts import AnyObject
from ..dynamics.schema_values import (
    Direction,
    Name,
    Number,
    Place,
    Positive,
    Vector,
    exactly_one,
    given,
    one_at_most,
)  # fmt: skip
from ..tomlread import Table
from .delta_space import MOST

#: Samples of a path, at most.
MOST_SAMPLES = 1_000_000

# -- what a file describes -------------------------------------------------------------------------------------

Elbow = Literal["outer", "inner"]


class DeltaTable(Table):
    """A Delta robot by its lengths."""

    base_radius: Positive
    effector_radius: Positive
    upper_arm: Positive
    forearm: Positive
    elbow: Elbow | tuple[Elbow, Elbow, Elbow] = "outer"
    root: Literal["far", "near"] = "far"


class UrdfTable(Table):
    """A robot of a URDF file, whose path is from the file's folder; or one that comes with the package."""

    path: str | None = None
    example: Literal["arm", "scara"] | None = None
    tip: Name | None = None
    root: Name | None = None
    mimic: Literal["error", "free"] = "error"
    ignore: list[Name] = []

    @model_validator(mode="after")
    def _one_file(self) -> UrdfTable:
        exactly_one(self, "path", "example")
        return self


class ToolTable(Table):
    """A point that goes with a body: what a mechanism is there to move."""

    body: Name
    point: Place = (0.0, 0.0, 0.0)


class MechanismTable(Table):
    """Bodies by name, and which joints are driven, between which coordinates."""

    bodies: Annotated[list[Name], Field(min_length=2)]
    fixed: Name | None = None
    inputs: list[Name] = []
    limits: dict[Name, tuple[Number, Number]] = {}
    tool: ToolTable | None = None
    algebra: Literal["cga3d", "pga3d"] = "cga3d"


# -- joints ----------------------------------------------------------------------------------------------------


class JointTable(Table):
    """A joint between two bodies, where they are at the start: by places and directions, or by shared objects."""

    a: Name
    b: Name
    name: Name | None = None
    objects: list[AnyObject] | None = None

    @model_validator(mode="after")
    def _one_way(self) -> JointTable:
        own = [key for key in type(self).model_fields if key not in (*JointTable.model_fields, "kind", "product")]
        own, needed = given(self, *own), self.needed()
        if self.objects is not None and own:
            raise ValueError(f"objects and {' and '.join(own)} say the same thing; give one of them")
        if self.objects is None:
            for key in needed:
                if key == "objects":
                    raise ValueError("has no objects; it is between two")
                if getattr(self, key) is None:
                    raise ValueError(f"has neither {key} nor objects; one is needed")
        return self

    def needed(self) -> tuple[str, ...]:
        """Keys that are there where objects are not."""
        return tuple(key for key in ("point", "axis", "normal", "axis_a", "axis_b") if key in type(self).model_fields)


class SphericalTable(JointTable):
    """Turning about a point; or a sphere."""

    kind: Literal["spherical"]
    point: Place | None = None


class RevoluteTable(JointTable):
    """Turning about an axis; or a circle, a point pair, a line and a point."""

    kind: Literal["revolute"]
    point: Place | None = None
    axis: Direction | None = None


class CylindricalTable(JointTable):
    """Turning about an axis and sliding along it; or a line."""

    kind: Literal["cylindrical"]
    point: Place | None = None
    axis: Direction | None = None


class PrismaticTable(JointTable):
    """Sliding along an axis; or two objects."""

    kind: Literal["prismatic"]
    point: Place | None = None
    axis: Direction | None = None

    def needed(self) -> tuple[str, ...]:
        return ("axis",)


class PlanarTable(JointTable):
    """Sliding in a plane and turning about its normal; or a plane."""

    kind: Literal["planar"]
    point: Place | None = None
    normal: Direction | None = None


class UniversalTable(JointTable):
    """Two axes at right angles, one of each body; or two circles."""

    kind: Literal["universal"]
    point: Place | None = None
    axis_a: Direction | None = None
    axis_b: Direction | None = None


class RigidTable(JointTable):
    """Two bodies as one."""

    kind: Literal["rigid"]
    point: Place | None = None

    def needed(self) -> tuple[str, ...]:
        if self.objects is not None:
            raise ValueError("a rigid joint has no objects; its point says where the bodies meet")
        return ()


class BilinearTable(JointTable):
    """A product of two objects, one of each body, that stays zero."""

    kind: Literal["bilinear"]
    product: Literal["outer", "inner", "meet", "anticommutator"] = "outer"

    def needed(self) -> tuple[str, ...]:
        return ("objects",)


AnyJoint = Annotated[
    SphericalTable | RevoluteTable | CylindricalTable | PrismaticTable | PlanarTable | UniversalTable | RigidTable
    | BilinearTable,
    Field(discriminator="kind"),
]  # fmt: skip


# -- what is asked of it ---------------------------------------------------------------------------------------


class PoseTable(Table):
    """Where it stands: joints, or the tool. With both, the tool's is looked for from these joints."""

    joints: dict[Name, Number] = {}
    degrees: bool = False
    position: Place | None = None
    orientation: OrientationTable | None = None


class WorkspaceTable(Table):
    """A box of positions of the tool, sampled; slices of it are drawn."""

    box: tuple[tuple[Number, Number], tuple[Number, Number], tuple[Number, Number]] | None = None
    samples: int | tuple[int, int, int] | None = None
    show: Literal["condition", "inverse", "forward"] = "condition"
    across: Literal["x", "y", "z"] = "z"
    at: Annotated[list[Number], Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _counts(self) -> WorkspaceTable:
        counts = () if self.samples is None else self.samples if isinstance(self.samples, tuple) else (self.samples,)
        if any(not 1 <= n <= MOST for n in counts):
            raise ValueError(f"samples are from 1 to {MOST} along a side")
        return self


class LineTable(Table):
    """Straight on; from where the tool is, unless said."""

    start: Place | None = None
    end: Place


class CircleTable(Table):
    """About an axis, counter-clockwise; it begins where the circle is nearest to the tool."""

    center: Place
    normal: Direction
    radius: Positive
    turns: Number = 1.0


class PathTable(Table):
    """A motion: the tool along a line, on a circle, through points, or joints from one coordinate to another."""

    line: LineTable | None = None
    circle: CircleTable | None = None
    points: Annotated[list[Place], Field(min_length=2)] | None = None
    joints: dict[Name, tuple[Number, Number]] | None = None
    degrees: bool = False
    duration: Positive = 1.0
    samples: Annotated[int, Field(ge=2, le=MOST_SAMPLES)] = 101
    timing: Literal["smooth", "uniform"] = "smooth"

    @model_validator(mode="after")
    def _one_way(self) -> PathTable:
        exactly_one(self, "line", "circle", "points", "joints")
        return self


class PictureTable(Table):
    """How pictures look; degrees."""

    title: Name | None = None
    elevation: Annotated[float, Field(ge=-90.0, le=90.0)] | None = None
    azimuth: Annotated[float, Field(ge=-360.0, le=360.0)] | None = None
    poses: Annotated[int, Field(ge=1, le=24)] = 1
    legend: bool = True


class FileTable(Table):
    """A mechanism file."""

    delta: DeltaTable | None = None
    urdf: UrdfTable | None = None
    mechanism: MechanismTable | None = None
    joints: list[AnyJoint] = []
    points: dict[Name, Vector] = {}
    pose: PoseTable = PoseTable()
    workspace: WorkspaceTable | None = None
    path: PathTable | None = None
    picture: PictureTable = PictureTable()
    units: UnitsTable = UnitsTable()


__all__ = ["FileTable", "PathTable", "PoseTable", "WorkspaceTable", "given", "one_at_most"]
