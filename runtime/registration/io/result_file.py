"""Registrations in files: JSON with the motor, its matrix and all that is known of it, and back (docs/chapter5.md).

What needs pydantic is imported when a file is read or written.
"""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.version import __version__
from ..errors import InputError
from ..loading import stock_algebra
from ..multivector import Multivector
from .given import check_belongs
from .model import Model
from .parameters import PLURALS
from .result import PerItem, Registration, Step
from .similarities import similarity

if TYPE_CHECKING:
    from ..tomlread import Table
    from .record_schema import RegistrationTable, TwistsTable, VersorTable

Array = NDArray[Any]
FORMAT, VERSION = "bladesmith-registration", 1
#: Numbers of a twist.
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
        Those that were registered: their names and counts are written.
    **settings
        Of `register`, for readers: numbers, texts, truth values, such as ``seed=3``.

    Raises
    ------
    InputError
        If it cannot be written, a setting is none of those, or the models are not those that were registered.
    """
    if not isinstance(result, Registration):
        raise InputError(f"a {type(result).__name__} is no registration.", remedy="Give what register() returned")
    for key, value in settings.items():
        if not isinstance(value, str | bool | int | float | None):
            raise InputError(f"the setting {key} is a {type(value).__name__}; a number, a text or None is needed.")
    check_belongs(result, query, reference)
    from .documents import write_document

    write_document(path, registration_text(result, query, reference, settings), "a registration")


def registration_text(
    result: Registration, query: Model | None = None, reference: Model | None = None, settings: Mapping[str, Any] = {}
) -> str:
    """A result as JSON: one key a line, matrices and lists of numbers on one line each."""
    made_by = {"bladesmith": __version__, "numpy": np.__version__, "python": platform.python_version()}
    free = result.undetermined
    found = {
        "format": FORMAT, "version": VERSION, "made_by": made_by, "settings": dict(settings),
        "query": _named(query), "reference": _named(reference), "converged": bool(result.converged),
        "message": result.message, "motor": _versor(result.motor, result.scale), "scale": float(result.scale),
        "cost": _number(result.cost), "doubt": _number(result.doubt), "threshold": _number(result.threshold),
        "center": [float(x) for x in result.center], "unit": float(result.unit),
        "matches": _per_kind(result.matches, int), "inliers": _per_kind(result.inliers, bool),
        "covariance": _twists(result.covariance), "undetermined": None if free is None else _twists(free.values),
        "ambiguous": [_versor(x, result.scale) for x in result.ambiguous],
        "history": [_step(x) for x in result.history],
    }  # fmt: skip
    lines = [f"  {json.dumps(key)}: {_shown(value)}" for key, value in found.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _shown(value: Any) -> str:
    """JSON of a key's value: lists of objects have one object a line."""
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n" + ",\n".join(f"    {_dumped(x)}" for x in value) + "\n  ]"
    return _dumped(value)


def _dumped(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _named(model: Model | None) -> dict[str, Any]:
    return {} if model is None else {"name": model.name, **{PLURALS[k]: n for k, n in model.counts.items()}}


def _number(x: float) -> float | None:
    """Null stands for what is no number."""
    return float(x) if math.isfinite(x) else None


def _versor(x: Multivector, size: float) -> dict[str, Any]:
    """A motor, and the matrix that lays the query on the reference: scaled by the size first, then moved."""
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
        If it cannot be read, is no JSON or no registration: with path and key.
    """
    from .documents import read_document
    from .record_schema import RegistrationTable

    table, name = read_document(path, RegistrationTable, "a registration")
    try:
        return _registration(table)
    except InputError as error:
        raise InputError(error.what, where=name, remedy=error.remedy) from None


def _registration(table: RegistrationTable) -> Registration:
    covariance = _rows(table.covariance, "covariance")
    if covariance.shape != (TWIST, TWIST):
        raise InputError(f"covariance has {len(covariance)} rows; they are {TWIST}.")
    if len(table.center) != 3:
        raise InputError(f"center has {len(table.center)} numbers; they are 3.")
    free = None
    if table.undetermined is not None:
        algebra: Any = stock_algebra("cga3d")
        free = algebra.wrap(algebra.kind("twist"), _rows(table.undetermined, "undetermined"))
    history = [Step(s.name, _float(s.tolerance), s.candidates, s.hits, _float(s.cost)) for s in table.history]
    return Registration(
        motor=_made(table.motor, "motor"), matches=_items(table.matches, np.int64), inliers=_items(table.inliers, bool),
        cost=table.cost, history=history, converged=table.converged, covariance=covariance,
        ambiguous=[_made(x, f"ambiguous[{i}]") for i, x in enumerate(table.ambiguous)], undetermined=free,
        scale=table.scale, doubt=math.inf if table.doubt is None else table.doubt, threshold=table.threshold,
        center=np.array(table.center), unit=table.unit, message=table.message,
    )  # fmt: skip


def _made(table: VersorTable, key: str) -> Multivector:
    """Of the kind that has these blades: a motor, or the rotor of a similarity."""
    algebra: Any = stock_algebra("cga3d")
    for name in ("motor", "rotor_conformal"):
        kind = algebra.kind(name)
        if table.blades == _blades(name):
            if len(table.coefficients) != kind.size:
                raise InputError(f"{key}.coefficients has {len(table.coefficients)} numbers; they are {kind.size}.")
            made: Multivector = algebra.wrap(kind, np.array(table.coefficients))
            return made
    raise InputError(f"{key}.blades are those of no motor: {', '.join(table.blades)}.")


def _items(table: Table, dtype: Any) -> PerItem:
    given: Iterable[tuple[str, str]] = PLURALS.items()
    return PerItem({kind: np.array(getattr(table, key), dtype) for kind, key in given if key in table.model_fields_set})


def _rows(table: TwistsTable, key: str) -> Array:
    blades = _blades("twist")
    if table.blades != blades:
        raise InputError(f"{key}.blades are {', '.join(table.blades)}; they are {', '.join(blades)}.")
    if any(len(row) != TWIST for row in table.rows):
        raise InputError(f"{key}.rows has a row that has not {TWIST} numbers.")
    return np.array([[_float(x) for x in row] for row in table.rows], np.float64).reshape(-1, TWIST)


def _blades(kind: str) -> list[str]:
    """Names of a kind's blades, in the order of its coefficients."""
    algebra: Any = stock_algebra("cga3d")
    found = algebra.kind(kind)
    return [str(b) for b in algebra.wrap(found, np.zeros(found.size)).blades]


def _float(x: float | None) -> float:
    return math.nan if x is None else x


__all__ = ["load_registration", "registration_text", "save_registration"]
