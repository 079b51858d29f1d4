"""Types of the values in files of mechanisms and simulations: numbers, vectors, names, units; faults as sentences."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from ...common.documents import Table
from ..arguments import LARGEST, SHORTEST

#: Letters of a name, of a label and of a unit.
MOST_LETTERS, MOST_OF_UNIT = 60, 12

Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Field(gt=0.0, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Vector = tuple[Number, Number, Number]


def _nonzero(v: Vector) -> Vector:
    if max(map(abs, v)) < SHORTEST:
        raise ValueError("a direction is not zero")
    return v


def _check_position(value: Any) -> Any:
    """Three numbers, or the name of a body's point."""
    if isinstance(value, str):
        return value
    if isinstance(value, list) and len(value) == 3 and all(_is_number(x) for x in value):
        return tuple(float(x) for x in value)
    raise ValueError("three numbers, or the name of one of the body's points, are needed")


def _is_number(x: Any) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool) and abs(x) <= LARGEST


def _name(text: str) -> str:
    if not text or len(text) > MOST_LETTERS or not text[0].isalnum() or not text.isprintable():
        raise ValueError(f"it begins with a letter or digit, and has {MOST_LETTERS} printable letters at most")
    return text


def _label(text: str) -> str:
    return text and _name(text)


def _unit(text: str) -> str:
    if len(text) > MOST_OF_UNIT or not all(c.isalnum() or c in " /^.*%-" for c in text):
        raise ValueError(f"a unit has {MOST_OF_UNIT} letters, digits and / ^ . * % - at most")
    return text


def one_of(text: str, choices: Sequence[str]) -> str:
    if text not in choices or text == "#rrggbb":
        raise PydanticCustomError("literal_error", "unknown", {"expected": ", ".join(f"'{x}'" for x in choices)})
    return text


Direction = Annotated[Vector, AfterValidator(_nonzero)]
Place = Annotated[Any, AfterValidator(_check_position)]
Name = Annotated[str, AfterValidator(_name)]
Label = Annotated[str, AfterValidator(_label)]  # may be empty
Unit = Annotated[str, AfterValidator(_unit)]


def present_keys(table: Table, *keys: str) -> list[str]:
    """Keys of a list that a table has."""
    return [key for key in keys if getattr(table, key) is not None]


def exactly_one(table: Table, *keys: str) -> None:
    found = present_keys(table, *keys)
    if not found:
        raise ValueError(f"has neither {' nor '.join(keys)}; one is needed")
    at_most_one(table, *keys)


def at_most_one(table: Table, *keys: str) -> None:
    found = present_keys(table, *keys)
    if len(found) > 1:
        raise ValueError(f"{' and '.join(found)} say the same thing; give one of them")
