"""Files of models: JSON that people can read, with parameters and not coefficients (docs/models.md).

Every fault of a file is one line that says path, key and remedy. pydantic is imported only when a file is read.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError

from ..codegen.errors import InputError
from ..codegen.toml.faults import explained, lowered
from ..files import write_atomically
from ..tomlread import Positive, Table, Vector3
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
    file = _file(path, "written to")
    try:
        write_atomically(file, model_text(rows, texts))
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be written: {_reason(error)}.", where=str(file)) from None


# -- reading -----------------------------------------------------------------------------------------------


def load_model(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, str], str]:
    """Rows by kind, texts, and the name of the file for messages.

    Raises
    ------
    InputError
        If the file cannot be read, is no JSON, or does not fit the schema: with path and key.
    """
    file = _file(path, "read from")
    name = str(file)
    if file.suffix.lower() in (".npz", ".npy"):
        raise InputError("models are JSON files.", where=name,
                         remedy="Read multivectors with bladesmith.load, and make a Model of them")  # fmt: skip
    try:
        text = file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text (byte {error.start}).", where=name) from None
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read: {_reason(error)}.", where=name) from None
    _refuse_syntax(text, name)
    try:  # JSON, because only there does pydantic's strict mode take an array for a tuple
        table = ModelTable.model_validate_json(text, strict=True)
    except ValidationError as error:
        raise InputError(_first_fault(error, json.loads(text)), where=name) from None
    rows = {kind: _rows(kind, getattr(table, PLURALS[kind])) for kind in FIELDS}
    return rows, {key: getattr(table, key) for key in TEXTS}, name


def _rows(kind: str, tables: list[Any]) -> list[list[float]]:
    names = list(columns(kind))
    vectors = [(name, size == 3) for name, size in FIELDS[kind]]
    if len(names) == 1:
        return [list(getattr(t, names[0])) for t in tables]
    return [[x for name, wide in vectors for x in (getattr(t, name) if wide else (getattr(t, name),))] for t in tables]


def _refuse_syntax(text: str, name: str) -> None:
    """What no schema sees: text that is no JSON, keys that are there twice, files of another format or version."""
    try:
        data = json.loads(text, object_pairs_hook=_unique, parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        where = f"{name}, line {error.lineno}, column {error.colno}"
        raise InputError(f"is no JSON: {lowered(error.msg)}.", where=where) from None
    except InputError as error:
        raise InputError(error.what, where=name, remedy=error.remedy) from None
    except RecursionError:
        raise InputError("arrays or objects are nested too deeply.", where=name) from None
    except ValueError as error:  # whole numbers of thousands of digits
        raise InputError(f"a number cannot be read: {lowered(str(error))}.", where=name) from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise InputError(f'is no model: it has no "format": "{FORMAT}".', where=name)
    version = data.get("version", "missing")
    if version != VERSION or isinstance(version, bool):
        raise InputError(f"version is {json.dumps(version)}; this release reads version {VERSION}.", where=name,
                         remedy="A newer release of bladesmith may read it")  # fmt: skip


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise InputError(f"the key {twice!r} is there twice in one object.", remedy="Remove one, or join their lists")
    return found


def _no_constant(word: str) -> float:
    raise InputError(f"{word} is no number of JSON; numbers are finite.", remedy="Leave such objects out")


def _first_fault(error: ValidationError, data: Any) -> str:
    """One fault, and how many more there are; a misspelt key comes before the missing one that it causes."""
    details = error.errors(include_url=False)
    if details[0]["type"] == "json_invalid":
        return f"cannot be read: {lowered(details[0]['msg'])}."
    detail = min(details, key=lambda d: d["type"] == "missing")
    _, what = explained(ModelTable, dict(detail), data)
    others = len(details) - 1
    more = "" if not others else " (1 more fault.)" if others == 1 else f" ({others} more faults.)"
    return (what if what.endswith((".", "?")) else what + ".") + more


def _file(path: Any, what: str) -> Path:
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise InputError(f"a model is {what} a file, and {path!r} names none.") from None
    if "\0" in str(file):
        raise InputError(f"the name {str(file)!r} has a null character.")
    return file


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
