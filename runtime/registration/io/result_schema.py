"""The schema of result files (docs/registration/registration.md). Imported when one is read: pydantic is slow."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import create_model

from ...common.documents import Table
from ..model.parameters import PLURALS


class VersorTable(Table):
    """A motor, or the versor of a similarity: coefficients on blades; and the matrix that takes homogeneous coordinates
    of the query to those of the reference: of a similarity with its scale, which is no part of the motor."""

    blades: list[str]
    coefficients: list[float]
    matrix: list[list[float]]


class StepTable(Table):
    """A `Step`; null stands for a number that is not finite."""

    name: str
    tolerance: float | None
    candidates: int
    hits: int
    cost: float | None


class TwistsTable(Table):
    """Rows of coefficients on the blades of a twist; null stands for a number that is not finite."""

    blades: list[str]
    rows: list[list[float | None]]


def _per_kind(name: str, item: type) -> Any:
    fields: Any = {key: (list[item], []) for key in PLURALS.values()}  # type: ignore[valid-type]
    return create_model(name, __base__=Table, **fields)


#: Row of the counterpart of each query object, by kind; -1 for none.
MatchesTable: Any = _per_kind("MatchesTable", int)
#: True for each query object that has a counterpart, by kind.
InliersTable: Any = _per_kind("InliersTable", bool)


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
