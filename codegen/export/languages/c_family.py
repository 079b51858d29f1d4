"""What C, C++ and GLSL share: functions of the loop IR on plain numbers, and kernels on structs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...elementary.constants import TWO_OVER_PI
from ...ir.loops.nodes import Array, Constant, Expression, Function
from ...ir.loops.types import REAL, Scalar
from ...targets.blocks import wrap_arguments
from ...targets.c.loops import CLoopPrinter
from ...targets.c.names import c_name
from ...targets.elementary import FAR_OR_NEAR
from ..bound import Table
from ..elementary import far_functions
from ..header import header_lines
from ..places import places_of, result_of
from ..unit import Entry, Slot, Unit

#: The variable that a kernel returns.
RESULT = "result_"


class ExportPrinter(CLoopPrinter):
    """One function of a file.

    Parameters
    ----------
    function : Function
    unit : Unit
    places : mapping of str to sequence of str, optional
        Arrays whose elements stand elsewhere, and where.
    statuses : frozenset of str
        Arrays that hold a code.
    """

    #: Before names of elementary functions, and what stands before a function.
    mathematics = "math_"
    storage = "static inline"

    def __init__(
        self, function: Function, unit: Unit, places: Mapping[str, Sequence[str]] | None = None,
        statuses: frozenset[str] = frozenset(),
    ) -> None:  # fmt: skip
        super().__init__(function)
        self.unit, self.places, self.statuses = unit, places or {}, statuses
        self.is_far = any(function.name == f.name for f in far_functions())
        self.precision = "f64" if self.is_far else unit.precision

    @property
    def real(self) -> str:
        """Type of real numbers."""
        return "double" if self.precision == "f64" else "float"

    def type_of(self, name: str, scalar: Scalar) -> str:
        return self.real if scalar == REAL else self.types[scalar]

    def result_type(self, k: int) -> str:
        return self.type_of("", self.function.results[k])

    def head(self, storage: str = "", end: str = ")") -> list[str]:
        return super().head(storage or self.storage, end)

    def constant(self, value: Constant) -> str:
        if value.type != REAL:
            return super().constant(value)
        number = float(value.value)
        if math.isnan(number):
            return self.not_a_number
        if math.isinf(number):
            return self.infinity if number > 0 else f"-{self.infinity}"
        return self.literal(number)

    #: Numbers that are none.
    not_a_number, infinity = "NAN", "INFINITY"

    def literal(self, number: float) -> str:
        """A finite number."""
        return repr(number) if self.precision == "f64" else f"{float(np.float32(number))!r}f"

    def symbol(self, name: str) -> str:
        return f"{self.unit.name}_{name}"

    def function_name(self, function: Function) -> str:
        if self.is_far or function in self.unit.mathematics:
            return self.mathematics + function.name
        return self.unit.name_of(function)

    def array_length(self, size: int) -> str:
        return f"[{size}]"

    def element(self, array: Array, index: Expression) -> str:
        if array.name in self.places and isinstance(index, Constant):
            return self.places[array.name][int(index.value)]
        return super().element(array, index)

    def value_for(self, name: str, value: Expression) -> str:
        text = super().value_for(name, value)
        return f"(int)({text})" if name in self.statuses else text

    def table_lines(self, table: Table) -> list[str]:
        """Constants of the file."""
        kind = self.stored.get(table.type.bits) or self.type_of("", table.type.scalar)
        numbers = [self.constant(Constant(v, table.type.scalar)) for v in table.values]
        return wrap_arguments(f"static const {kind} {table.name}[{len(numbers)}] = {{", numbers, "};")

    # -- kernels on structs --------------------------------------------------------------------------------------------

    def kernel_lines(self, entry: Entry) -> list[str]:
        """A kernel for users, without its comment."""
        own = result_of(entry)
        kind = self.slot_type(own.slot) if own.slot else self.symbol(f"{entry.name}_result")
        parameters = [self.slot_parameter(s) for s in entry.inputs]
        unused = [f"(void){c_name(s.array)};" for s in entry.inputs if s.array not in self._used]
        head = wrap_arguments(f"{self.storage} {kind} {self.symbol(entry.name)}(", parameters or ["void"], ")")
        body = [f"{kind} {RESULT};", *unused, *self._body(), f"return {RESULT};"]
        return [*head, "{", *(f"  {line}" for line in body), "}"]

    def slot_type(self, slot: Slot) -> str:
        """Type of a result or an argument, without an array's length."""
        if slot.is_status:
            return "int"
        return self.symbol(slot.struct.name) if slot.struct else self.real

    def slot_parameter(self, slot: Slot) -> str:
        if slot.size and slot.struct is None:
            return f"const {self.real} {c_name(slot.array)}[{slot.size}]"
        return f"{self.slot_type(slot)} {c_name(slot.array)}"

    def slot_field(self, slot: Slot) -> str:
        """Declaration of a result among others."""
        length = f"[{slot.size}]" if slot.size and slot.struct is None else ""
        return f"{self.slot_type(slot)} {slot.name}{length};"


def file_values(unit: Unit, printer: type[ExportPrinter]) -> dict[str, Any]:
    """What templates of files are filled with."""
    far = far_functions() if unit.is_reduced_far else []
    kernels, algorithms = [], []
    for entry in unit.entries:
        if entry.is_kernel:
            codes = frozenset(s.array for s in entry.outputs if s.is_status)
            kernels.append((entry, printer(entry.function, unit, places_of(entry, RESULT, c_name), codes)))
        else:
            algorithms.append((entry, printer(entry.function, unit).lines()[1:]))
    return {
        "unit": unit,
        "header": header_lines(unit),
        "places": TWO_OVER_PI.tolist(),
        "far": [printer(f, unit).lines() for f in far],
        "mathematics": [printer(f, unit).lines() for f in unit.mathematics if f.name != FAR_OR_NEAR],
        "tables": [printer(unit.entries[0].function, unit).table_lines(t) for t in unit.tables],
        "functions": [printer(f, unit).lines() for f in unit.functions],
        "kernels": kernels,
        "algorithms": algorithms,
        "result_of": result_of,
    }
