"""JSON files of this package: read and checked against a schema, every fault as one line with path, key and remedy.

Imported only when a file is read or written, because pydantic is slow to import.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from ..codegen.errors import InputError
from ..codegen.toml.faults import explained, lowered
from ..files import write_atomically

T = TypeVar("T", bound=BaseModel)


def write_document(path: Any, text: str, what: str) -> None:
    """Write a file, whole or not at all.

    Parameters
    ----------
    path
    text : str
    what : str
        What the file is, for messages: "a model".

    Raises
    ------
    InputError
        If it cannot be written.
    """
    file = named_file(path, what, "written to")
    try:
        write_atomically(file, text)
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be written: {_reason(error)}.", where=str(file)) from None


def read_document(path: Any, table: type[T], what: str) -> tuple[T, str]:
    """A file's contents, and its name for messages.

    Parameters
    ----------
    path
    table : type
        Its schema: with the literals ``format`` and ``version``.
    what : str
        What the file is, for messages: "a model".

    Raises
    ------
    InputError
        If the file cannot be read, is no JSON, or does not fit the schema: with path and key.
    """
    file = named_file(path, what, "read from")
    name = str(file)
    try:
        text = file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text (byte {error.start}).", where=name) from None
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read: {_reason(error)}.", where=name) from None
    _refuse_syntax(text, name, table, what)
    try:  # JSON, because only there does pydantic's strict mode take an array for a tuple
        return table.model_validate_json(text, strict=True), name
    except ValidationError as error:
        raise InputError(_first_fault(error, json.loads(text), table), where=name) from None


def named_file(path: Any, what: str, how: str) -> Path:
    """A path that names a file.

    Raises
    ------
    InputError
        If it does not.
    """
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise InputError(f"{what} is {how} a file, and {path!r} names none.") from None
    if "\0" in str(file):
        raise InputError(f"the name {str(file)!r} has a null character.")
    return file


def _refuse_syntax(text: str, name: str, table: type[BaseModel], what: str) -> None:
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
    wanted, read = (get_args(table.model_fields[key].annotation)[0] for key in ("format", "version"))
    if not isinstance(data, dict) or data.get("format") != wanted:
        noun = what.split(" ", 1)[1]
        raise InputError(f'is no {noun}: it has no "format": "{wanted}".', where=name)
    version = data.get("version", "missing")
    if version != read or isinstance(version, bool):
        raise InputError(f"version is {json.dumps(version)}; this release reads version {read}.", where=name,
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


def _first_fault(error: ValidationError, data: Any, table: type[BaseModel]) -> str:
    """One fault, and how many more there are; a misspelt key comes before the missing one that it causes."""
    details = error.errors(include_url=False)
    if details[0]["type"] == "json_invalid":
        return f"cannot be read: {lowered(details[0]['msg'])}."
    detail = min(details, key=lambda d: d["type"] == "missing")
    _, what = explained(table, dict(detail), data)
    others = len(details) - 1
    more = "" if not others else " (1 more fault.)" if others == 1 else f" ({others} more faults.)"
    return (what if what.endswith((".", "?")) else what + ".") + more


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
