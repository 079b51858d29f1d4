"""The schema of mechanism files (docs/motion/mechanisms.md). Imported when one is read: pydantic is slow to import.

What needs the algebra, or more than one key, is found later by `document`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...common.documents import Table
from ...mechanics.io.fields import (
    Direction,
    Name,
    Number,
    Place,
    Positive,
    Vector,
    exactly_one,
)
from ...mechanics.io.geometry import OrientationTable, UnitsTable
from ...mechanics.io.joints import AnyJoint
from ..delta.workspace import MOST

#: Samples of a path, at most.
MOST_SAMPLES = 1_000_000

# -- robots -------------------------------------------------------------------------------------

Elbow = Literal["outer", "inner"]


class DeltaTable(Table):
    """A Delta robot by its lengths."""

    base_radius: Positive
    effector_radius: Positive
    upper_arm: Positive
    forearm: Positive
    elbow: Elbow | tuple[Elbow, Elbow, Elbow] = "outer"
    root: Literal["far", "near", "positive", "negative"] = "far"


class UrdfTable(Table):
    """A robot of a URDF file, whose path is from the file's folder; or one that comes with the package."""

    path: str | None = None
    example: Literal["arm", "scara"] | None = None
    tip: Name | None = None
    root: Name | None = None
    mimic: Literal["follow", "free", "error"] = "follow"
    ignore: list[Name] = []

    @model_validator(mode="after")
    def _one_file(self) -> UrdfTable:
        exactly_one(self, "path", "example")
        return self


class ToolTable(Table):
    """A point of a body: the end effector of a mechanism."""

    body: Name
    point: Place = (0.0, 0.0, 0.0)


class MechanismTable(Table):
    """Bodies by name, actuated joints and their limits."""

    bodies: Annotated[list[Name], Field(min_length=2)]
    fixed: Name | None = None
    inputs: list[Name] = []
    limits: dict[Name, tuple[Number, Number]] = {}
    tool: ToolTable | None = None
    algebra: Literal["cga3d", "pga3d"] = "cga3d"


# -- tasks ---------------------------------------------------------------------------------------


class PoseTable(Table):
    """A pose by joints, or of the tool. With both, the tool's pose is searched from these joints."""

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
    """A straight path; default start: the position of the tool."""

    start: Place | None = None
    end: Place


class CircleTable(Table):
    """A circle, counter-clockwise about its normal, from its point nearest to the tool."""

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
    def _check_one_kind(self) -> PathTable:
        exactly_one(self, "line", "circle", "points", "joints")
        return self


class PictureTable(Table):
    """Options of pictures; angles in degrees."""

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
