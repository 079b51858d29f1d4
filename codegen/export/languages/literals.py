"""What Rust and JavaScript share: results of kernels are literals, and helpers are printed where they are needed."""

from __future__ import annotations

import math
import re
import textwrap
from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ...elementary.constants import TWO_OVER_PI
from ...ir.loops.nodes import Array, Constant, Expression, Function, Store, View
from ...ir.loops.types import REAL
from ...targets.blocks import BlockPrinter
from ...targets.elementary import FAR_OR_NEAR
from ..bound import Table
from ..elementary import far_functions
from ..header import header_lines
from ..places import places_of, result_of
from ..unit import Entry, Slot, Unit
from .numbers import rounded

#: A line of fields may have so many.
MOST_LETTERS = 90


class LiteralPrinter(BlockPrinter):
    """One function of a file.

    Parameters
    ----------
    function : Function
    unit : Unit
    entry : Entry, optional
        The kernel that is printed with structs in place of arrays.
    """

    #: Numbers that have no digits.
    not_a_number = infinity = ""
    #: Before a comment's line.
    comment = "//"

    def __init__(self, function: Function, unit: Unit, entry: Entry | None = None) -> None:
        super().__init__(function)
        self.unit, self.entry = unit, entry
        self.is_far = any(function.name == f.name for f in far_functions())
        self.is_mathematics = self.is_far or function in unit.mathematics
        self.precision = "f64" if self.is_far else unit.precision
        self.places: Mapping[str, Sequence[str]] = places_of(entry, "", self.variable) if entry else {}

    # -- the part of a language ----------------------------------------------------------------------------------------

    @abstractmethod
    def head(self) -> str:
        """What a function begins with."""

    @abstractmethod
    def algorithm_lines(self, entry: Entry) -> list[str]:
        """An algorithm for users, without its comment."""

    @abstractmethod
    def kernel_head(self, entry: Entry) -> str:
        """What a kernel begins with."""

    @abstractmethod
    def number(self, slot: Slot, value: Expression) -> str:
        """A result that is one number."""

    @abstractmethod
    def struct(self, name: str, fields: Sequence[tuple[str, str]]) -> str:
        """A struct with its fields."""

    @abstractmethod
    def table_lines(self, table: Table) -> list[str]:
        """Constants of the file."""

    @abstractmethod
    def inner_element(self, array: Array, index: Expression) -> str:
        """An element of an array."""

    # -- expressions ---------------------------------------------------------------------------------------------------

    def real_constant(self, value: Constant) -> str:
        """A number in the precision of the file."""
        number = rounded(float(value.value), self.precision)
        if math.isnan(number):
            return self.not_a_number
        if math.isinf(number):
            return self.infinity if number > 0 else f"-{self.infinity}"
        return repr(number)

    def element(self, array: Array, index: Expression) -> str:
        if array.name in self.places and isinstance(index, Constant):
            return self.places[array.name][int(index.value)]
        return self.inner_element(array, index)

    # -- functions -----------------------------------------------------------------------------------------------------

    def lines(self) -> list[str]:
        """The function, with its comment."""
        notes = [f"{self.comment} {self.function.note}"] if self.function.note else []
        return [*notes, f"{self.head()} {{", *self.indented(self._body()), "}"]

    def kernel_lines(self, entry: Entry) -> list[str]:
        """A kernel for users, without its comment: what it stores is what it returns."""
        outputs = {s.array for s in entry.outputs}
        values: dict[str, list[Expression]] = {name: [] for name in outputs}
        body = []
        for statement in self.function.body:
            if isinstance(statement, Store) and statement.array.name in outputs:
                values[statement.array.name].append(statement.value)
            else:
                body.append(statement)
        own = result_of(entry)
        slots = {self.spelled(s.name): self._slot_value(s, values[s.array]) for s in entry.outputs}
        several = self.struct(f"{entry.name}_result", list(slots.items()))
        result = next(iter(slots.values())) if own.slot else several
        lines = [*self._block(body, set()), *self.result(result).splitlines()]
        return [f"{self.kernel_head(entry)} {{", *self.indented(lines), "}"]

    def spelled(self, name: str) -> str:
        """The name of a result among others."""
        return name

    def result(self, value: str) -> str:
        """What a kernel ends with."""
        return f"return {value};"

    def _slot_value(self, slot: Slot, values: Sequence[Expression]) -> str:
        if slot.size == 0:
            return self.number(slot, values[0])
        texts = [self.text(v) for v in values]
        if slot.struct is None:
            return f"[{', '.join(texts)}]"
        return self.struct(slot.struct.name, list(zip(slot.struct.fields, texts, strict=True)))


def struct_literal(head: str, fields: Sequence[str], indent: str) -> str:
    """A struct with its fields, each on a line where one is too short for all."""
    line = f"{head}{{ {', '.join(fields)} }}"
    if len(line) < MOST_LETTERS and "\n" not in line:
        return line
    inner = textwrap.indent(",\n".join(fields), indent)
    return f"{head}{{\n{inner},\n}}"


def is_whole(view: View) -> bool:
    """Whether a part of an array of known size is all of it."""
    size = view.type.size
    if view.type.is_open:
        if not isinstance(view.rows, Constant):
            return False
        size *= int(view.rows.value)
    is_first = isinstance(view.offset, Constant) and view.offset.value == 0
    return is_first and not view.array.type.is_open and view.array.type.size == size


def file_values(unit: Unit, printer: type[LiteralPrinter]) -> dict[str, Any]:
    """What templates of files are filled with; ``uses(name)``: whether a function of the file is called."""
    far = far_functions() if unit.is_reduced_far else []
    mathematics = [f for f in unit.mathematics if f.name != FAR_OR_NEAR]
    any_function = unit.entries[0].function
    texts: dict[str, list[list[str]]] = {
        "far": [printer(f, unit).lines() for f in far],
        "mathematics": [printer(f, unit).lines() for f in mathematics],
        "tables": [printer(any_function, unit).table_lines(t) for t in unit.tables],
        "functions": [printer(f, unit).lines() for f in unit.functions if unit.name_of(f) not in _algorithms(unit)],
        "entries": [
            p.kernel_lines(e) if e.is_kernel else p.algorithm_lines(e)
            for e in unit.entries
            for p in [printer(e.function, unit, e if e.is_kernel else None)]
        ],
    }
    called = set(re.findall(r"\w+(?=\()", "\n".join(_lines(texts.values()))))
    return {
        "unit": unit,
        "header": header_lines(unit),
        "places": TWO_OVER_PI.tolist(),
        **texts,
        "entries": list(zip(unit.entries, texts["entries"], strict=True)),
        "uses": called.__contains__,
        "result_of": result_of,
        "is_real": lambda type: type == REAL,
    }


def _algorithms(unit: Unit) -> set[str]:
    return {e.name for e in unit.entries if not e.is_kernel}


def _lines(texts: Iterable[list[list[str]]]) -> list[str]:
    return [line for part in texts for lines in part for line in lines]
