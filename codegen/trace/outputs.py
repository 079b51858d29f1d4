"""Results of formulas: multivectors with a role and a name, and rows of plain numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..algebra.multivector import Multivector
from ..errors import TraceError


@dataclass(frozen=True)
class Result:
    """One value returned by a formula, with its role; a row of numbers has several scalars."""

    values: tuple[Multivector, ...]
    role: str = "value"
    name: str = ""
    is_row: bool = False

    @property
    def value(self) -> Multivector:
        """The only multivector."""
        return self.values[0]


def status(code: Multivector) -> Result:
    """Mark a scalar as the status code of the item."""
    return Result((code,), "status", "status")


def row(values: Sequence[Multivector], name: str = "") -> Result:
    """Return several scalars as one row of plain numbers."""
    return Result(tuple(values), name=name, is_row=True)


def named(name: str, value: Multivector) -> Result:
    """Give an output a name (the first is called "out" otherwise)."""
    return Result((value,), name=name)


def as_outputs(returned: Any) -> list[Result]:
    """Results of a formula as a list: one multivector, or a tuple of multivectors and statuses."""
    items = returned if isinstance(returned, tuple) else (returned,)
    if not items:
        raise TraceError("a formula returns at least one multivector; this one returned an empty tuple.")
    results = [item if isinstance(item, Result) else Result((item,)) for item in items]
    for item in results:
        for value in item.values:
            if not isinstance(value, Multivector):
                raise TraceError(f"a formula returns multivectors, not {type(value).__name__}.")
    return results
