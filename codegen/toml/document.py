"""TOML files, checked against a schema; every fault becomes one line that says file, line, key and remedy.

What the files mean is not known here. Imported only when a file is read, because pydantic is slow to import.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Annotated, Any, Generic, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ..errors import InputError
from .faults import dotted, explained, lowered
from .index import Path, line_index, line_of

M = TypeVar("M", bound=BaseModel)

_SYNTAX = re.compile(r"(?P<what>.*) \(at (?P<where>line \d+, column \d+|end of document)\)", re.DOTALL)


class Table(BaseModel):
    """Base of the schemas: unknown keys are refused, and numbers are finite."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


Positive = Annotated[float, Field(gt=0.0)]
Vector3 = tuple[float, float, float]


class Document(Generic[M]):
    """A checked file: its contents, and errors that point into it.

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

    def __init__(self, name: str, text: str, model: type[M], error: type[InputError] = InputError) -> None:
        self.name = name
        self.text = text
        self._error = error
        self.data = self._parsed()
        self.contents = self._validated(model)

    def error(self, path: Path, what: str, remedy: str | None = None) -> InputError:
        """An error about the key at `path`, to be raised by whoever knows more than the schema.

        Parameters
        ----------
        path
            Keys and positions: `("surfaces", 2, "radius")`.
        what
            Follows the key's name: `"is -0.4; a radius is positive"`.
        remedy
            A further sentence.
        """
        return self._fault(line_of(self._index(), path), f"{dotted(path)} {what}", remedy)

    def _fault(self, line: int | None, what: str, remedy: str | None = None) -> InputError:
        where = f"{self.name}, line {line}" if line else self.name
        text = what if what.endswith((".", "?")) else what + "."
        return self._error(text, where=where, remedy=remedy)

    def _index(self) -> dict[Path, int]:
        try:
            return line_index(self.text)
        except (ValueError, IndexError):  # never for valid text; a message without a line is better than none
            return {}

    def _parsed(self) -> dict[str, Any]:
        try:
            return tomllib.loads(self.text + "\n")  # without a last newline its errors there have no line
        except tomllib.TOMLDecodeError as error:
            match = _SYNTAX.fullmatch(str(error).splitlines()[0])
            what, where = (match["what"], match["where"]) if match else (str(error), "")
            place = f"{self.name}, {where}" if where else self.name
            raise self._error(f"{lowered(what)}.", where=place) from None
        except RecursionError:
            raise self._too_deep() from None
        except ValueError:  # of Python, without a place
            raise self._error("a whole number has thousands of digits.", where=self.name) from None

    def _too_deep(self) -> InputError:
        return self._error("arrays or tables are nested too deeply.", where=self.name)

    def _validated(self, model: type[M]) -> M:
        try:
            # JSON, because only there does pydantic's strict mode take an array for a tuple
            text = json.dumps(self.data, default=str, allow_nan=False)
        except ValueError:  # some number is not finite
            for path, value in _leaves(self.data, ()):
                if isinstance(value, float) and not math.isfinite(value):
                    raise self.error(path, f"is {value}; numbers are finite") from None
            raise
        try:
            return model.model_validate_json(text, strict=True)
        except ValidationError as error:
            if error.errors(include_url=False)[0]["type"] == "json_invalid":  # the one thing that JSON cannot say
                raise self._too_deep() from None
            raise self._first_fault(model, error) from None

    def _first_fault(self, model: type[M], error: ValidationError) -> InputError:
        """The fault that stands first in the file; the others are counted."""
        index = self._index()
        faults = []
        for detail in error.errors(include_url=False):
            path, what = explained(model, dict(detail), self.data)
            # a misspelt key comes before the missing one that it causes
            faults.append((detail["type"] == "missing", line_of(index, path) or 0, what))
        _, line, what = min(faults)
        others = len(set(faults)) - 1
        count = "1 more fault" if others == 1 else f"{others} more faults"
        return self._fault(line, what, f"({count}.)" if others else None)


def read_document(path: str | FilePath, model: type[M], error: type[InputError] = InputError) -> Document[M]:
    """Read and check a TOML file. See `Document`.

    Raises
    ------
    InputError
        Of the class `error`, if the file cannot be read, is not TOML, or does not fit the schema.
    """
    name = str(path)
    try:
        text = FilePath(path).read_bytes().decode("utf-8-sig")
    except OSError as failure:
        raise error(f"cannot be read: {failure.strerror or failure}.", where=name) from None
    except UnicodeDecodeError as failure:
        raise error(f"is not UTF-8 text (byte {failure.start}).", where=name) from None
    return Document(name, text, model, error)


def read_toml(path: str | FilePath, model: type[M], error: type[InputError] = InputError) -> M:
    """The contents of a TOML file, as an instance of the schema. Raises as `read_document` does."""
    return read_document(path, model, error).contents


def _leaves(value: Any, path: Path) -> Iterator[tuple[Path, Any]]:
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    if pairs is None:
        yield path, value
    else:
        for key, item in pairs:
            yield from _leaves(item, (*path, key))
