"""Files of models: JSON that people can read, with parameters and not coefficients (docs/registration/models.md).

Every fault of a file is one line that says path, key and remedy. pydantic is imported only when a file is read.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal, TypeVar

import numpy as np
from pydantic import create_model

from ...codegen.errors import InputError
from ...common.documents import JsonDocument, Positive, Table, Vector3, read_document
from ...common.files import as_path, write_file
from ..model.parameters import FIELDS, PLURALS, SHAPES, SIZES, Rows, columns
from ..model.uncertainty import Uncertainty

FORMAT, VERSION = "bladesmith-model", 1
T = TypeVar("T")
#: Texts of a model that are written where there are any.
TEXTS = ("name", "unit", "origin")


def _table(kind: str) -> type[Table]:
    """Schema of the objects of a kind."""
    types = {1: float, 3: Vector3}
    fields: Any = {name: (Positive if name == "radius" else types[size], ...) for name, size in FIELDS[kind]}
    fields |= {"weight": (float | None, None), "covariance": (list[list[float]] | None, None)}
    return create_model(kind, __base__=Table, **fields)


class _FileTable(Table):
    format: Literal["bladesmith-model"]
    version: Literal[1]
    name: str = ""
    unit: str = ""
    origin: str = ""


_lists: Any = {PLURALS[kind]: (list[_table(kind)], []) for kind in FIELDS}  # type: ignore[misc]
#: Schema of a whole file.
ModelTable: Any = create_model("ModelTable", __base__=_FileTable, **_lists)

# -- writing -----------------------------------------------------------------------------------------------


def model_text(rows: Mapping[str, Rows], texts: Mapping[str, str], uncertainty: Uncertainty) -> str:
    """A model as JSON: one object a line; numbers so that reading gives the same to the last bit."""
    parts = [f'"format": {json.dumps(FORMAT)}', f'"version": {VERSION}']
    parts += [f'"{key}": {json.dumps(texts[key], ensure_ascii=False)}' for key in TEXTS if texts[key]]
    for kind, rows_ in rows.items():
        objects = ",\n".join(f"    {line}" for line in _lines(kind, rows_, uncertainty))
        parts.append(f'"{PLURALS[kind]}": [\n{objects}\n  ]')
    return "{\n  " + ",\n  ".join(parts) + "\n}\n"


def _lines(kind: str, rows: Rows, uncertainty: Uncertainty) -> Iterator[str]:
    # Python writes the shortest number that reads as the same: 17 digits at most
    fields = [f'"{name}": {"%r" if size == 1 else "[%r, %r, %r]"}' for name, size in FIELDS[kind]]
    columns_ = [rows.tolist()]
    for name, values in (("weight", uncertainty.weights), ("covariance", uncertainty.covariances)):
        if kind in values:
            fields.append(f'"{name}": %r')
            columns_.append([[x] for x in values[kind].tolist()])
    template = ", ".join(fields)
    for parts in zip(*columns_, strict=True):
        yield "{" + template % tuple(x for part in parts for x in part) + "}"


def save_model(
    path: str | os.PathLike[str], rows: Mapping[str, Rows], texts: Mapping[str, str], uncertainty: Uncertainty
) -> None:
    """Write a model, whole or not at all.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    write_file(as_path(path, "a model is written to"), model_text(rows, texts, uncertainty))


# -- reading -----------------------------------------------------------------------------------------------


def load_model(path: str | os.PathLike[str], make_model: Callable[..., T]) -> T:
    """Read a file of a model.

    Parameters
    ----------
    path : path
    make_model : callable
        `Model`, or a class derived from it.

    Raises
    ------
    InputError
        If the file cannot be read, is not JSON, does not fit the schema, or has invalid values: with line and key.
    """
    file = as_path(path, "a model is read from")
    if file.suffix.lower() in (".npz", ".npy"):
        raise InputError("models are JSON files.", where=str(file),
                         remedy="Read multivectors with bladesmith.load, and make a Model of them")  # fmt: skip
    document = read_document(file, ModelTable, kind=JsonDocument)
    table = document.contents
    tables = {kind: getattr(table, PLURALS[kind]) for kind in FIELDS}
    arguments = {PLURALS[kind]: _constructor_array(kind, items) for kind, items in tables.items()}
    arguments |= {key: getattr(table, key) for key in TEXTS}
    return document.build((), lambda: make_model(**arguments, **_uncertainty(tables)))


def _uncertainty(tables: Mapping[str, list[Any]]) -> dict[str, Any]:
    """Weights and covariances, as the constructor takes them, where objects have any."""
    found: dict[str, Any] = {}
    if any(item.weight is not None for items in tables.values() for item in items):
        ones = {kind: [1.0 if item.weight is None else item.weight for item in items] for kind, items in tables.items()}
        found["weights"] = {kind: values for kind, values in ones.items() if values}
    if any(item.covariance is not None for items in tables.values() for item in items):
        found["covariances"] = {kind: [_matrix(kind, i, item) for i, item in enumerate(items)]
                                for kind, items in tables.items() if items}  # fmt: skip
    return found


def _matrix(kind: str, i: int, item: Any) -> list[list[float]]:
    rows: list[list[float]] | None = item.covariance
    size = SIZES[kind]
    if rows is None:
        raise InputError(f"{PLURALS[kind]}[{i}] has no covariance, and others have.", remedy="Give all, or weights")
    if [len(row) for row in rows] != [size] * size:
        raise InputError(f"{PLURALS[kind]}[{i}].covariance is not a matrix of {size} rows of {size} numbers.")
    return rows


def _constructor_array(kind: str, tables: list[Any]) -> Rows:
    """The array that the constructor takes for a kind."""
    array = np.array(_rows(kind, tables), np.float64)
    return array.reshape(-1, *SHAPES[kind]) if kind in SHAPES else array


def _rows(kind: str, tables: list[Any]) -> list[list[float]]:
    names = list(columns(kind))
    vectors = [(name, size == 3) for name, size in FIELDS[kind]]
    if len(names) == 1:
        return [list(getattr(t, names[0])) for t in tables]
    return [[x for name, wide in vectors for x in (getattr(t, name) if wide else (getattr(t, name),))] for t in tables]
