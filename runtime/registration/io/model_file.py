"""Files of models: JSON that people can read, with parameters and not coefficients (docs/models.md).

Every fault of a file is one line that says path, key and remedy. pydantic is imported only when a file is read.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from typing import Any, Literal

from ..codegen.errors import InputError
from ..tomlread import Positive, Table, Vector3
from .documents import named_file, read_document, write_document
from .parameters import FIELDS, PLURALS, Rows, columns

FORMAT, VERSION = "bladesmith-model", 1
#: Texts of a model that are written where there are any.
TEXTS = ("name", "unit", "origin")


class PointTable(Table):
    """A point."""

    xyz: Vector3


class PointPairTable(Table):
    """Two end points."""

    a: Vector3
    b: Vector3


class LineTable(Table):
    """A line through a point."""

    point: Vector3
    direction: Vector3


class CircleTable(Table):
    """A circle about its normal."""

    center: Vector3
    normal: Vector3
    radius: Positive


class PlaneTable(Table):
    """The points with normal . x = offset."""

    normal: Vector3
    offset: float


class SphereTable(Table):
    """A sphere."""

    center: Vector3
    radius: Positive


class ModelTable(Table):
    """A whole file."""

    format: Literal["bladesmith-model"]
    version: Literal[1]
    name: str = ""
    unit: str = ""
    origin: str = ""
    points: list[PointTable] = []
    point_pairs: list[PointPairTable] = []
    lines: list[LineTable] = []
    circles: list[CircleTable] = []
    planes: list[PlaneTable] = []
    spheres: list[SphereTable] = []


# -- writing -----------------------------------------------------------------------------------------------


def model_text(rows: Mapping[str, Rows], texts: Mapping[str, str]) -> str:
    """A model as JSON: one object a line; numbers so that reading gives the same to the last bit."""
    parts = [f'"format": {json.dumps(FORMAT)}', f'"version": {VERSION}']
    parts += [f'"{key}": {json.dumps(texts[key], ensure_ascii=False)}' for key in TEXTS if texts[key]]
    for kind, found in rows.items():
        objects = ",\n".join(f"    {line}" for line in _lines(kind, found))
        parts.append(f'"{PLURALS[kind]}": [\n{objects}\n  ]')
    return "{\n  " + ",\n  ".join(parts) + "\n}\n"


def _lines(kind: str, rows: Rows) -> Iterator[str]:
    # Python writes the shortest number that reads as the same: 17 digits at most
    template = ", ".join(f'"{name}": {"%r" if size == 1 else "[%r, %r, %r]"}' for name, size in FIELDS[kind])
    for row in rows.tolist():
        yield "{" + template % tuple(row) + "}"


def save_model(path: str | os.PathLike[str], rows: Mapping[str, Rows], texts: Mapping[str, str]) -> None:
    """Write a model, whole or not at all.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    write_document(path, model_text(rows, texts), "a model")


# -- reading -----------------------------------------------------------------------------------------------


def load_model(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, str], str]:
    """Rows by kind, texts, and the name of the file for messages.

    Raises
    ------
    InputError
        If the file cannot be read, is no JSON, or does not fit the schema: with path and key.
    """
    file = named_file(path, "a model", "read from")
    if file.suffix.lower() in (".npz", ".npy"):
        raise InputError("models are JSON files.", where=str(file),
                         remedy="Read multivectors with bladesmith.load, and make a Model of them")  # fmt: skip
    table, name = read_document(file, ModelTable, "a model")
    rows = {kind: _rows(kind, getattr(table, PLURALS[kind])) for kind in FIELDS}
    return rows, {key: getattr(table, key) for key in TEXTS}, name


def _rows(kind: str, tables: list[Any]) -> list[list[float]]:
    names = list(columns(kind))
    vectors = [(name, size == 3) for name, size in FIELDS[kind]]
    if len(names) == 1:
        return [list(getattr(t, names[0])) for t in tables]
    return [[x for name, wide in vectors for x in (getattr(t, name) if wide else (getattr(t, name),))] for t in tables]
