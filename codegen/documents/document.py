"""TOML and JSON files, checked against a schema; every fault becomes one line that says file, line, key and remedy.

What the files mean is not known here. Imported only when a file is read, because pydantic is slow to import.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path as FilePath
from typing import Annotated, Any, ClassVar, Generic, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ..errors import BladesmithError, CompileError, InputError, MissingExtraError
from .faults import dotted_path, explain_fault, lower_message
from .index import Path, json_line_index, line_index, line_of
from .text import read_text

M = TypeVar("M", bound=BaseModel)
T = TypeVar("T")

_SYNTAX = re.compile(r"(?P<what>.*) \(at (?P<where>line \d+, column \d+|end of document)\)", re.DOTALL)
#: Parts of a dotted key; the parser's time grows with the square of their number.
MOST_PARTS = 64
_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*"|'[^'\n]*')"""
_DEEP_KEY = re.compile(rf"(?:{_PART}[ \t]*\.[ \t]*){{{MOST_PARTS}}}")
#: Characters of a fault's text: it repeats what stands in the file.
MAX_MESSAGE = 2000
#: Faults of a file that are explained.
MOST_FAULTS = 100
_KEY = re.compile(r"(?P<key>[A-Za-z_]\w*(?:\.[A-Za-z_]\w*|\[\d+\])*):? (?P<rest>.*)", re.DOTALL)


class Table(BaseModel):
    """Base of the schemas: unknown keys are refused, and numbers are finite."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


Positive = Annotated[float, Field(gt=0.0)]
Vector3 = tuple[float, float, float]


class Document(Generic[M]):
    """A checked TOML file: its contents, and errors that point into it.

    Parameters
    ----------
    name
        What messages call the file.
    text
        The whole of it.
    model
        Schema, a pydantic model. Types are strict: a number in quotation marks is not a number.
    error
        Class of the errors: `SceneError`, `SpecError`.
    """

    #: Largest file, in bytes: a text takes some ten times its size in memory.
    max_size: ClassVar[int] = 16_000_000

    def __init__(self, name: str, text: str, model: type[M], error: type[InputError] = InputError) -> None:
        self.name = name
        self.text = text
        self._model = model
        self._error = error
        self.data = self._parse()
        self.contents = self._validate()

    # -- errors of whoever knows more than the schema --------------------------------------------------------------

    def error(self, path: Path, what: str, remedy: str | None = None) -> InputError:
        """An error about the key at `path`, to be raised.

        Parameters
        ----------
        path
            Keys and positions: `("surfaces", 2, "radius")`.
        what
            Follows the key's name: `"is -0.4; a radius is positive"`.
        remedy
            A further sentence.
        """
        return self._fault(line_of(self._index(), path), f"{dotted_path(path)} {what}".lstrip(), remedy)

    def build(self, path: Path, make: Callable[[], T]) -> T:
        """Call a factory of what the table at `path` describes; its errors get the file, the line and the key.

        Raises
        ------
        InputError
            Of the document's class, for every error of the package but those of the machine: a missing extra or
            compiler, a full disk. A key of the table that the message begins with becomes part of the path.
        """
        try:
            return make()
        except (MissingExtraError, CompileError):
            raise
        except BladesmithError as error:
            if f"{error.where}, ".startswith(f"{self.name}, "):  # it has all that already
                raise
            key, what = self._split_key(path, f"{error.where}: {error.what}" if error.where else error.what)
            raise self.error((*path, *key), what, error.remedy) from None

    def _split_key(self, path: Path, what: str) -> tuple[Path, str]:
        """The key of a table that a message begins with, and the rest; without one, that something is refused."""
        table: Any = self.contents
        for part in path:
            table = getattr(table, str(part), None) if isinstance(table, BaseModel) else table[part]
        keys = getattr(type(table), "model_fields", ())
        match = _KEY.fullmatch(what)
        if match is not None and match["key"] != "a":  # the article
            key = tuple(int(p) if p.isdigit() else p for p in re.findall(r"[A-Za-z_]\w*|\d+", match["key"]))
            if key[0] not in keys:
                key = key[1:]  # the name of the object, as "camera.position"
            if key and key[0] in keys:
                return key, match["rest"]
        return (), f"is refused: {what}" if path else what

    def _fault(self, line: int | None, what: str, remedy: str | None = None) -> InputError:
        where = f"{self.name}, line {line}" if line else self.name
        what = "".join(c if c.isprintable() else repr(c)[1:-1] for c in what)  # keys may have line breaks
        if len(what) > MAX_MESSAGE:
            what = f"{what[: MAX_MESSAGE // 2]} ... {what[-MAX_MESSAGE // 2 :]}"
        text = what if what.endswith((".", "?")) else what + "."
        return self._error(text, where=where, remedy=remedy)

    # -- reading ---------------------------------------------------------------------------------------------------

    def _index(self) -> dict[Path, int]:
        try:
            return self._line_index(self.text)
        except (ValueError, IndexError, RecursionError):  # never for valid text; better no line than no message
            return {}

    def _line_index(self, text: str) -> dict[Path, int]:
        return line_index(text)

    def _parse(self) -> Any:
        if _DEEP_KEY.search(self.text):
            raise self._too_deep()
        try:
            return tomllib.loads(self.text + "\n")  # without a last newline its errors there have no line
        except tomllib.TOMLDecodeError as error:
            match = _SYNTAX.fullmatch(str(error).splitlines()[0])
            what, where = (match["what"], match["where"]) if match else (str(error), "")
            place = f"{self.name}, {where}" if where else self.name
            raise self._error(f"{lower_message(what)}.", where=place) from None
        except RecursionError:
            raise self._too_deep() from None
        except ValueError:  # of Python, without a place
            raise self._too_long() from None

    def _too_deep(self) -> InputError:
        return self._error("arrays or tables are nested too deeply.", where=self.name)

    def _too_long(self) -> InputError:
        return self._error("a whole number has thousands of digits.", where=self.name)

    def _as_json(self) -> str:
        """The contents as JSON, because only there does pydantic's strict mode take an array for a tuple."""
        try:
            return json.dumps(self.data, default=str, allow_nan=False)
        except ValueError:  # some number is not finite
            self._refuse_infinite()
            raise

    def _refuse_infinite(self) -> None:
        for path, value in _leaves(self.data, ()):
            if isinstance(value, float) and not math.isfinite(value):
                raise self.error(path, f"is {value}; numbers are finite")

    def _validate(self) -> M:
        try:
            return self._model.model_validate_json(self._as_json(), strict=True)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            if first["type"] != "json_invalid":
                raise self._first_fault(error) from None
            if "recursion" in first["msg"]:
                raise self._too_deep() from None
            raise self._error(f"cannot be read: {lower_message(first['msg'])}.", where=self.name) from None

    def _first_fault(self, error: ValidationError) -> InputError:
        """The fault that stands first in the file, of the first `MOST_FAULTS`; the others are counted."""
        index = self._index()
        faults, details = [], error.errors(include_url=False)[:MOST_FAULTS]
        for detail in details:
            path, what = explain_fault(self._model, dict(detail), self.data, details)
            # a misspelt key comes before the missing one that it causes
            faults.append((detail["type"] == "missing", line_of(index, path) or 0, what))
        _, line, what = min(faults)
        others = len(set(faults)) - 1 + max(0, error.error_count() - MOST_FAULTS)
        count = "1 more fault" if others == 1 else f"{others} more faults"
        return self._fault(line, what, f"({count}.)" if others else None)


class JsonDocument(Document[M]):
    """A checked JSON file, whose schema has the literals `format` and `version`."""

    max_size = 1_000_000_000  # programs write them

    def _line_index(self, text: str) -> dict[Path, int]:
        return json_line_index(text)

    def _parse(self) -> Any:
        constants: list[float] = []

        def infinite(word: str) -> float:
            constants.append(float(word))
            return constants[-1]

        try:
            data = json.loads(self.text, object_pairs_hook=self._unique, parse_constant=infinite)
        except json.JSONDecodeError as error:
            where = f"{self.name}, line {error.lineno}, column {error.colno}"
            raise self._error(f"is not JSON: {lower_message(error.msg)}.", where=where) from None
        except RecursionError:
            raise self._too_deep() from None
        except InputError:
            raise
        except ValueError:
            raise self._too_long() from None
        self._check_version(data)
        if constants:
            self.data = data
            self._refuse_infinite()
        return data

    def _unique(self, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        table = dict(pairs)
        if len(table) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise self._error(f"duplicate key {twice!r} in one object.", where=self.name,
                              remedy="Remove one, or join their lists")  # fmt: skip
        return table

    def _check_version(self, data: Any) -> None:
        """Refuse files of something else, or of another release, before their keys are compared with the schema's."""
        expected, read = (get_args(self._model.model_fields[key].annotation)[0] for key in ("format", "version"))
        if not isinstance(data, dict) or data.get("format") != expected:
            noun = expected.rpartition("-")[2]
            raise self._error(f'is not a {noun}: it has no "format": "{expected}".', where=self.name)
        version = data.get("version", "missing")
        if version != read or isinstance(version, bool):
            raise self._error(f"version is {json.dumps(version)}; this release reads version {read}.", where=self.name,
                              remedy="A newer release of bladesmith may read it")  # fmt: skip

    def _as_json(self) -> str:
        return self.text


def read_document(
    path: str | FilePath, model: type[M], error: type[InputError] = InputError, kind: type[Document[M]] = Document
) -> Document[M]:
    """Read and check a TOML file, or another kind of `Document`.

    Raises
    ------
    InputError
        Of the class `error`, if the file cannot be read, has another syntax, or does not fit the schema.
    """
    return kind(str(path), read_text(path, error, kind.max_size), model, error)


def _leaves(value: Any, path: Path) -> Iterator[tuple[Path, Any]]:
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    if pairs is None:
        yield path, value
    else:
        for key, item in pairs:
            yield from _leaves(item, (*path, key))
