"""The schema of files of registrations (docs/chapter5.md). Imported when one is read: pydantic is slow to import."""

from __future__ import annotations

from typing import Any, Literal

from ..tomlread import Table


class VersorTable(Table):
    """A motor, or the versor of a similarity: coefficients on blades; and the matrix that takes homogeneous coordinates
    of the query to those of the reference: of a similarity with its scale, which is no part of the motor."""

    blades: list[str]
    coefficients: list[float]
    matrix: list[list[float]]


class StepTable(Table):
    """What was done, as of `Step`; null is no number."""

    name: str
    tolerance: float | None
    candidates: int
    hits: int
    cost: float | None


class TwistsTable(Table):
    """Rows of numbers on the blades of a twist; null is no number."""

    blades: list[str]
    rows: list[list[float | None]]


class MatchesTable(Table):
    """Of each kind, for each query object the row of its counterpart, -1 for none."""

    points: list[int] = []
    point_pairs: list[int] = []
    lines: list[int] = []
    circles: list[int] = []
    planes: list[int] = []
    spheres: list[int] = []


class InliersTable(Table):
    """Of each kind, for each query object whether it has a counterpart."""

    points: list[bool] = []
    point_pairs: list[bool] = []
    lines: list[bool] = []
    circles: list[bool] = []
    planes: list[bool] = []
    spheres: list[bool] = []


class RegistrationTable(Table):
    """A whole file. A point x goes to motor (scale x), scaled about the world's origin; of a motion the scale is 1."""

    format: Literal["bladesmith-registration"]
    version: Literal[1]
    made_by: dict[str, str] = {}
    settings: dict[str, Any] = {}
    query: dict[str, Any] = {}
    reference: dict[str, Any] = {}
    converged: bool
    message: str
    motor: VersorTable
    scale: float
    cost: float
    doubt: float | None
    threshold: float
    center: list[float]
    unit: float
    matches: MatchesTable
    inliers: InliersTable
    covariance: TwistsTable
    undetermined: TwistsTable | None
    ambiguous: list[VersorTable]
    history: list[StepTable]
