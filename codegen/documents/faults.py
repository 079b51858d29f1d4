"""pydantic's findings as sentences: what is wrong with a key, and what would be right."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel

from ..errors import nearest
from .index import Path

_SHOWN = 40  # characters of a wrong value that a message repeats


def dotted_path(path: Path) -> str:
    """A path as users write it: `surfaces[2].radius`."""
    parts = [f"[{part}]" if isinstance(part, int) else f".{part}" for part in path]
    return "".join(parts).removeprefix(".")


def explain_fault(
    model: type[BaseModel], detail: dict[str, Any], data: Any, others: Sequence[Any] = ()
) -> tuple[Path, str]:
    """Path of a fault in the file, and a sentence about it.

    Parameters
    ----------
    model
        The schema of the whole file.
    detail
        One item of `ValidationError.errors()`.
    data
        The whole file's contents.
    others
        All of these items: each entry that an array lacks is one of its own.
    """
    path = _path_in(data, detail["loc"])
    context, kind = detail.get("ctx", {}), detail["type"]
    if kind in _FROM_SCHEMA and path and not _holds(_value_at(data, path[:-1]), path[-1]):
        path = path[:-1]  # a member's name, of a union, behind the table that breaks a rule of its own
    key, value = dotted_path(path), detail["input"]
    if kind == "missing":
        lacks = [x["loc"][-1] for x in others if x["type"] == kind and x["loc"][:-1] == detail["loc"][:-1]]
        return path, _missing(path, data, lacks)
    if kind == "extra_forbidden":
        return path, f"{key} is not a {_valid_keys(model, detail['loc'], str(path[-1]))}"
    if kind == "union_tag_not_found":
        return path, f"{key} has no {_quoted_words(context['discriminator'])[0]}, which says what it is"
    if kind == "union_tag_invalid":
        tag, path = context["tag"], (*path, _quoted_words(context["discriminator"])[0])
        expected = _quoted_words(context["expected_tags"])
        return path, f"{dotted_path(path)} is {_format_value(tag)}{_choices(tag, expected)}"
    if kind in ("literal_error", "enum"):
        return path, f"{key} is {_format_value(value)}{_choices(value, _quoted_words(context['expected']))}"
    rule = _rule(kind, context, path, detail["msg"])
    if isinstance(value, dict) and kind in _FROM_SCHEMA:
        return path, f"{key}: {rule}" if key else rule
    return path, f"{key} is {_format_value(value)}; {rule}"


def lower_message(text: str) -> str:
    """A message of another library, to go on after a colon."""
    return text[:1].lower() + text[1:]


def _path_in(data: Any, loc: Sequence[str | int]) -> Path:
    """pydantic's location without what is not in the file: the names of a union's members."""
    path: Path = ()
    for i, part in enumerate(loc):
        if _holds(data, part):
            data = data[part]
        elif i < len(loc) - 1 or not isinstance(data, dict | list):
            continue  # a member's name; only the last part can be a key that is missing
        path += (part,)
    return path


def _holds(data: Any, part: str | int) -> bool:
    if isinstance(data, list):
        return isinstance(part, int) and part < len(data)
    return isinstance(data, dict) and part in data


def _value_at(data: Any, path: Path) -> Any:
    for part in path:
        data = data[part]
    return data


def _quoted_words(text: str) -> list[str]:
    """The words that pydantic puts between quotation marks."""
    return re.findall(r"'([^']*)'", text)


def _missing(path: Path, data: Any, lacks: Sequence[Any]) -> str:
    parent, last = path[:-1], path[-1]
    if isinstance(last, int):
        items = _value_at(data, parent)
        nouns = {_ITEMS.get(type(x).__name__, "items") for x in items}
        noun = nouns.pop() if len(nouns) == 1 else "items"
        return f"{dotted_path(parent)} has {len(items)} where {max([last, *lacks]) + 1} {noun} are needed"
    return f"{dotted_path(parent)} has no {last}, which is required" if parent else f"{last} is missing"


_FROM_SCHEMA = ("value_error", "assertion_error")  # raised by a schema's own checks, of a key or of a table
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


#: What the items of an array are, by the class of those that are there.
_ITEMS = {"float": "numbers", "int": "numbers", "str": "texts", "list": "arrays", "dict": "tables"}


def _rule(kind: str, context: dict[str, Any], path: Path, message: str) -> str:
    """The rule that a value breaks, as the end of a sentence."""
    if kind in _BOUNDS:
        name, comparison = _BOUNDS[kind]
        bound = context[name]
        rule = "is positive" if (name, bound) == ("gt", 0) else f"{comparison} {bound:g}"
        return f"{'it' if _is_plural(path) else _noun(path)} {rule}"
    if kind in _FROM_SCHEMA:
        return str(context["error"])
    if kind in ("too_short", "too_long"):
        limit = context.get("min_length", context.get("max_length"))
        return f"it has {context['actual_length']} items where {limit} are {_extreme(kind)}"
    stem = kind.removesuffix("_type").removesuffix("_parsing")
    return _TYPES.get(stem, lower_message(message))


def _extreme(kind: str) -> str:
    return "the least" if kind == "too_short" else "the most"


def _last_key(path: Path) -> str:
    keys = [part for part in path if isinstance(part, str)]
    return keys[-1].replace("_", " ") if keys else "value"


def _is_plural(path: Path) -> bool:
    """`reflections`, but not `radius`, `shininess` or `axis`."""
    return re.search(r"[^ius]s$", _last_key(path)) is not None


def _noun(path: Path) -> str:
    """`a radius` for `("surfaces", 2, "radius")`."""
    noun = _last_key(path)
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _choices(value: object, options: Sequence[str]) -> str:
    return _did_you_mean(value, options) or f"; known: {', '.join(options)}"


def _did_you_mean(word: object, options: Sequence[str]) -> str:
    near = nearest(word, options)
    return f"; did you mean {near!r}?" if near else ""


def _format_value(value: object) -> str:
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


def _valid_keys(model: type[BaseModel], loc: Sequence[str | int], word: str) -> str:
    """`known key` and the nearest that the schema knows at this place, or all of them.

    A key that other members of a union have, such as a disc's key on a sphere, is told to be theirs.
    """
    candidates, members, tag = [model], [model], ""
    for part in loc[:-1]:
        if isinstance(part, int):
            continue
        entered = [field.annotation for each in candidates if (field := each.model_fields.get(part))]
        tagged = [each for each in candidates if part == each.__name__ or part in _tags(each)]
        inside = [inner for annotation in entered for inner in _models(annotation)]
        if tagged and not inside:
            members, tag = candidates, part
        else:
            members, tag = [], ""
        candidates = inside or tagged or candidates
    owners = [str(label) for each in members if tag and word in each.model_fields for label in _tags(each)]
    if owners:
        return f"key of {tag!r}; it is for {' and '.join(map(repr, owners))}"
    keys = list(dict.fromkeys(key for each in candidates for key in each.model_fields))
    return "known key" + (_did_you_mean(word, keys) or f"; known keys: {', '.join(keys)}")


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
