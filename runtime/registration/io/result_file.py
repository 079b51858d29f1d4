"""JSON files of registrations: the motor, its matrix and all other attributes (docs/registration/registration.md).

Modules that need pydantic are imported when a file is read or written.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...common.data_files import producer_versions
from ...common.files import as_path, write_file
from ...common.validation import as_instance
from ...core.multivector import Multivector
from ...core.registry import stock_algebra
from ...errors import InputError
from ..model.arguments import check_same_models
from ..model.model import Model
from ..model.parameters import PLURALS
from ..model.similarity import similarity
from ..result import PerItem, Registration, Step

if TYPE_CHECKING:
    from ...common.documents import Table
    from .result_schema import RegistrationTable, TwistsTable, VersorTable

Array = NDArray[Any]
FORMAT, VERSION = "bladesmith-registration", 1
#: Dimension of a twist.
TWIST = 6


# -- writing ---------------------------------------------------------------------------------------------------


def save_registration(
    path: str | os.PathLike[str], result: Registration, query: Model | None = None, reference: Model | None = None,
    **settings: Any,
) -> None:  # fmt: skip
    """Write a result as JSON, whole or not at all; `load_registration` gives the same one to the last bit.

    Parameters
    ----------
    path
    result : Registration
    query, reference : Model, optional
        Models that were registered: their names and counts are written.
    **settings
        Arguments of `register`, for readers: numbers, texts, truth values, such as ``seed=3``.

    Raises
    ------
    InputError
        If the file cannot be written, a setting has another type, or the models are not those that were registered.
    """
    as_instance(result, "the result", Registration, remedy="Give what register() returned")
    for key, value in settings.items():
        as_instance(value, f"the setting {key}", (str, bool, int, float, type(None)), "a number, a text or None")
    check_same_models(result, query, reference)
    write_file(as_path(path, "a registration is written to"), registration_text(result, query, reference, settings))


def registration_text(
    result: Registration, query: Model | None = None, reference: Model | None = None, settings: Mapping[str, Any] = {}
) -> str:
    """A result as JSON: one key a line, matrices and lists of numbers on one line each."""
    free = result.undetermined
    table_ = {
        "format": FORMAT, "version": VERSION, "made_by": producer_versions(), "settings": dict(settings),
        "query": _model_table(query), "reference": _model_table(reference), "converged": bool(result.converged),
        "message": result.message, "motor": _versor(result.motor, result.scale), "scale": float(result.scale),
        "cost": _number(result.cost), "doubt": _number(result.doubt), "threshold": _number(result.threshold),
        "center": [float(x) for x in result.center], "unit": float(result.unit),
        "matches": _per_kind(result.matches, int), "inliers": _per_kind(result.inliers, bool),
        "covariance": _twists(result.covariance), "undetermined": None if free is None else _twists(free.values),
        "ambiguous": [_versor(x, result.scale) for x in result.ambiguous],
        "history": [_step(x) for x in result.history],
    }  # fmt: skip
    lines = [f"  {json.dumps(key)}: {_format_value(value)}" for key, value in table_.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _format_value(value: Any) -> str:
    """JSON of a key's value: lists of objects have one object a line."""
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n" + ",\n".join(f"    {_dumps(x)}" for x in value) + "\n  ]"
    return _dumps(value)


def _dumps(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _model_table(model: Model | None) -> dict[str, Any]:
    return {} if model is None else {"name": model.name, **{PLURALS[k]: n for k, n in model.counts.items()}}


def _number(x: float) -> float | None:
    """A number, or null for one that is not finite."""
    return float(x) if math.isfinite(x) else None


def _versor(x: Multivector, size: float) -> dict[str, Any]:
    """A motor, and the matrix from the query to the reference: scaling by the size first, then the motor."""
    scale, rotation, translation = similarity(x)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = scale * size * rotation, translation
    return {"blades": [str(b) for b in x.blades], "coefficients": x.values.tolist(), "matrix": matrix.tolist()}


def _per_kind(values: PerItem, of: type) -> dict[str, list[Any]]:
    return {key: [of(x) for x in values[key].tolist()] for key in values.keys()}  # noqa: SIM118 (no mapping)


def _twists(rows: Array) -> dict[str, Any]:
    return {"blades": _blades("twist"), "rows": [[_number(x) for x in row] for row in rows.tolist()]}


def _step(step: Step) -> dict[str, Any]:
    return {"name": step.name, "tolerance": _number(step.tolerance), "candidates": int(step.candidates),
            "hits": int(step.hits), "cost": _number(step.cost)}  # fmt: skip


# -- reading ---------------------------------------------------------------------------------------------------


def load_registration(path: str | os.PathLike[str]) -> Registration:
    """Read a result that `save_registration` wrote.

    Raises
    ------
    InputError
        If the file cannot be read or is not a JSON file of a registration: with path and key.
    """
    from ...common.documents import JsonDocument, read_document
    from .result_schema import RegistrationTable

    file = as_path(path, "a registration is read from")
    document = read_document(file, RegistrationTable, kind=JsonDocument)
    return document.build((), partial(_registration, document.contents))


def _registration(table: RegistrationTable) -> Registration:
    covariance = _rows(table.covariance, "covariance")
    if covariance.shape != (TWIST, TWIST):
        raise InputError(f"covariance has {len(covariance)} rows; {TWIST} are needed.")
    if len(table.center) != 3:
        raise InputError(f"center has {len(table.center)} numbers; 3 are needed.")
    free = None
    if table.undetermined is not None:
        algebra: Any = stock_algebra("cga3d")
        free = algebra.wrap(algebra.kind("twist"), _rows(table.undetermined, "undetermined"))
    history = [Step(s.name, _float(s.tolerance), s.candidates, s.hits, _float(s.cost)) for s in table.history]
    return Registration(
        motor=_read_versor(table.motor, "motor"),
        matches=_items(table.matches, np.int64), inliers=_items(table.inliers, bool),
        cost=table.cost, history=history, converged=table.converged, covariance=covariance,
        ambiguous=[_read_versor(x, f"ambiguous[{i}]") for i, x in enumerate(table.ambiguous)], undetermined=free,
        scale=table.scale, doubt=math.inf if table.doubt is None else table.doubt, threshold=table.threshold,
        center=np.array(table.center), unit=table.unit, message=table.message,
    )  # fmt: skip


def _read_versor(table: VersorTable, key: str) -> Multivector:
    """Multivector of the kind that has these blades: a motor, or the rotor of a similarity."""
    algebra: Any = stock_algebra("cga3d")
    for name in ("motor", "rotor_conformal"):
        kind = algebra.kind(name)
        if table.blades == _blades(name):
            if len(table.coefficients) != kind.size:
                raise InputError(f"{key}.coefficients has {len(table.coefficients)} numbers; {kind.size} are needed.")
            motor_: Multivector = algebra.wrap(kind, np.array(table.coefficients))
            return motor_
    raise InputError(f"{key}.blades are not those of a motor: {', '.join(table.blades)}.")


def _items(table: Table, dtype: Any) -> PerItem:
    given: Iterable[tuple[str, str]] = PLURALS.items()
    return PerItem({kind: np.array(getattr(table, key), dtype) for kind, key in given if key in table.model_fields_set})


def _rows(table: TwistsTable, key: str) -> Array:
    blades = _blades("twist")
    if table.blades != blades:
        raise InputError(f"{key}.blades are {', '.join(table.blades)}; expected {', '.join(blades)}.")
    for i, row in enumerate(table.rows):
        if len(row) != TWIST:
            raise InputError(f"{key}.rows[{i}] has {len(row)} numbers; {TWIST} are needed.")
    return np.array([[_float(x) for x in row] for row in table.rows], np.float64).reshape(-1, TWIST)


def _blades(kind: str) -> list[str]:
    """Names of a kind's blades, in the order of its coefficients."""
    algebra: Any = stock_algebra("cga3d")
    kind_ = algebra.kind(kind)
    return [str(b) for b in algebra.wrap(kind_, np.zeros(kind_.size)).blades]


def _float(x: float | None) -> float:
    return math.nan if x is None else x
