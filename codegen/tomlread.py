"""TOML files, checked against a schema; every fault becomes one line that says file, line, key and remedy.

What the files mean is not known here. Imported only when a file is read, because pydantic is slow to import.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path as FilePath
from typing import Annotated, Any, Generic, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from .errors import InputError, suggest
from .tomlindex import Path, line_index, line_of

M = TypeVar("M", bound=BaseModel)

_SHOWN = 40  # characters of a wrong value that a message repeats
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
            return tomllib.loads(self.text)
        except tomllib.TOMLDecodeError as error:
            match = _SYNTAX.fullmatch(str(error).splitlines()[0])
            what, where = (match["what"], match["where"]) if match else (str(error), "")
            place = f"{self.name}, {where}" if where else self.name
            raise self._error(f"{_lowered(what)}.", where=place) from None
        except RecursionError:
            raise self._error("arrays or tables are nested too deeply.", where=self.name) from None

    def _validated(self, model: type[M]) -> M:
        for path, value in _leaves(self.data, ()):
            if isinstance(value, float) and not math.isfinite(value):
                raise self.error(path, f"is {value}; numbers are finite")
        try:
            # JSON, because only there does pydantic's strict mode take an array for a tuple
            return model.model_validate_json(json.dumps(self.data, default=str), strict=True)
        except ValidationError as error:
            raise self._first_fault(model, error) from None

    def _first_fault(self, model: type[M], error: ValidationError) -> InputError:
        """The fault that stands first in the file; the others are counted."""
        index = self._index()
        faults = []
        for detail in map(dict, error.errors(include_url=False)):
            path = _path_in(self.data, detail["loc"])
            what = _sentence(model, detail, path, self.data)
            # a misspelt key comes before the missing one that it causes
            faults.append((detail["type"] == "missing", line_of(index, _place(detail, path)) or 0, what))
        _, line, what = min(faults)
        more = len(set(faults)) - 1
        return self._fault(line, what, f"({more} more fault{'s'[: more - 1]}.)" if more else None)


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


def dotted(path: Path) -> str:
    """A path as users write it: `surfaces[2].radius`."""
    parts = [f"[{part}]" if isinstance(part, int) else f".{part}" for part in path]
    return "".join(parts).removeprefix(".")


def _leaves(value: Any, path: Path) -> Iterator[tuple[Path, Any]]:
    pairs = (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    )
    if pairs is None:
        yield path, value
    else:
        for key, item in pairs:
            yield from _leaves(item, (*path, key))


def _path_in(data: Any, loc: Iterable[Any]) -> Path:
    """pydantic's location without what is not in the file: the names of a union's members."""
    path: Path = ()
    for i, part in enumerate(loc):
        if part in (data if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ()):
            data = data[part]
            path += (part,)
        elif i == len(loc) - 1 and isinstance(data, dict | list):  # the one that is missing
            path += (part,)
    return path


def _value_at(data: Any, path: Path) -> Any:
    for part in path:
        data = data[part]
    return data


def _place(detail: dict[str, Any], path: Path) -> Path:
    """The key to look up: for a wrong tag of a union, the tag's own."""
    tag = str(detail.get("ctx", {}).get("discriminator", "")).strip("'")
    return (*path, tag) if detail["type"] == "union_tag_invalid" else path


def _sentence(model: type[BaseModel], detail: dict[str, Any], path: Path, data: Any) -> str:
    """What is wrong with a key, and what would be right."""
    context = detail.get("ctx", {})
    key, kind = dotted(path), detail["type"]
    if kind == "missing":
        return _missing(path, data)
    if kind == "extra_forbidden":
        return f"{key} is not a known key{_valid_keys(model, detail['loc'], str(path[-1]))}"
    if kind == "union_tag_not_found":
        return f"{key} has no {context['discriminator'].strip(chr(39))}, which says what it is"
    if kind == "union_tag_invalid":
        options = re.findall(r"'([^']*)'", context["expected_tags"])
        key = dotted(_place(detail, path))
        return f"{key} is {_shown(context['tag'])}{_choices(context['tag'], options)}"
    value = detail["input"]
    if kind in ("literal_error", "enum"):
        options = re.findall(r"'([^']*)'", context["expected"])
        return f"{key} is {_shown(value)}{_choices(value, options)}"
    rule = _rule(kind, context, path, detail["msg"])
    if isinstance(value, dict) and kind in _ABOUT_TABLES:
        return f"{key}: {rule}" if key else rule
    return f"{key} is {_shown(value)}; {rule}"


def _missing(path: Path, data: Any) -> str:
    parent, last = path[:-1], path[-1]
    if isinstance(last, int):
        return f"{dotted(parent)} has {len(_value_at(data, parent))} items, which is too few"
    return f"{dotted(parent)} has no {last}, which is required" if parent else f"{last} is missing"


_ABOUT_TABLES = ("value_error", "assertion_error")  # raised by a schema's own checks, of a key or of a table
_BOUNDS = {
    "greater_than": ("gt", "is greater than"),
    "greater_than_equal": ("ge", "is at least"),
    "less_than": ("lt", "is less than"),
    "less_than_equal": ("le", "is at most"),
    "multiple_of": ("multiple_of", "is a multiple of"),
}
_TYPES = {
    "float": "a number is needed",
    "int": "a whole number is needed",
    "bool": "true or false is needed",
    "string": "text in quotation marks is needed",
    "list": "an array is needed",
    "tuple": "an array is needed",
    "dict": "a table is needed",
    "model": "a table is needed",
    "model_attributes": "a table is needed",
}


def _rule(kind: str, context: dict[str, Any], path: Path, message: str) -> str:
    """The rule that a value breaks, as the end of a sentence."""
    if kind in _BOUNDS:
        name, comparison = _BOUNDS[kind]
        bound = context[name]
        rule = "is positive" if (name, bound) == ("gt", 0) else f"{comparison} {bound:g}"
        return f"{_noun(path)} {rule}"
    if kind in _ABOUT_TABLES:
        return str(context["error"])
    if kind in ("too_short", "too_long"):
        limit = context.get("min_length", context.get("max_length"))
        return f"it has {context['actual_length']} items where {limit} are {_extreme(kind)}"
    stem = kind.removesuffix("_type").removesuffix("_parsing")
    return _TYPES.get(stem, _lowered(message))


def _extreme(kind: str) -> str:
    return "the least" if kind == "too_short" else "the most"


def _noun(path: Path) -> str:
    """`a radius` for `("surfaces", 2, "radius")`."""
    keys = [part for part in path if isinstance(part, str)]
    noun = keys[-1].replace("_", " ") if keys else "value"
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _choices(value: object, options: Sequence[str]) -> str:
    return suggest(value, options) or f"; known: {', '.join(options)}"


def _shown(value: object) -> str:
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


def _lowered(text: str) -> str:
    return text[:1].lower() + text[1:]


def _valid_keys(model: type[BaseModel], loc: Sequence[str | int], word: str) -> str:
    """The nearest key that the schema knows at this place, or all of them."""
    candidates = [model]
    for part in loc[:-1]:
        if isinstance(part, int):
            continue
        entered = [field.annotation for each in candidates if (field := each.model_fields.get(part))]
        tagged = [each for each in candidates if part == each.__name__ or part in _tags(each)]
        candidates = (
            [inner for annotation in entered for inner in _models(annotation)] or tagged or candidates
        )
    keys = list(dict.fromkeys(key for each in candidates for key in each.model_fields))
    return suggest(word, keys) or f"; known keys: {', '.join(keys)}"


def _tags(model: type[BaseModel]) -> Iterator[object]:
    for field in model.model_fields.values():
        if get_origin(field.annotation) is Literal:
            yield from get_args(field.annotation)


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    """Every schema in an annotation: `list[Sphere | Plane]` holds two."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _models(inner)
