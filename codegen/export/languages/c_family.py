"""What C, C++ and GLSL share: functions of the loop IR on plain numbers, and kernels on structs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ...elementary.constants import TWO_OVER_PI
from ...ir.loops.nodes import Array, Constant, Expression, Function
from ...ir.loops.types import BOOL, INT, REAL, Scalar
from ...targets.blocks import wrap_arguments
from ...targets.c.loops import CLoopPrinter
from ...targets.c.names import c_name
from ...targets.elementary import FAR_OR_NEAR
from ..bound import Table
from ..elementary import far_functions
from ..header import SAME_BITS, header_lines
from ..names import language_words
from ..places import places_of, result_of
from ..unit import Entry, Slot, Unit
from .numbers import rounded

#: The variable that a kernel returns.
RESULT = "result_"


#: Longer arrays are left as they are: clearing takes time, and no compiler looks into them.
CLEARED = 64


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

    #: Names of the language's words, and what the header of a file says of its numbers.
    language, arithmetic = "", SAME_BITS
    #: Before names of elementary functions, and what stands before a function.
    mathematics = "math_"
    storage = kernel_storage = "static inline"
    #: Whether there is a type for conditions, and types are called as functions: ``int(x)``.
    has_booleans, is_functional = False, False
    #: What a kernel's result is before its coefficients are known.
    initial = ""
    #: Type of integers without a sign.
    unsigned = "uint64_t"
    #: Names of functions that are called, which no variable may hide.
    own_words: frozenset[str] = frozenset(("sqrt", "fabs", "sqrtf", "fabsf", "NAN", "INFINITY"))

    def __init__(
        self, function: Function, unit: Unit, places: Mapping[str, Sequence[str]] | None = None,
        statuses: frozenset[str] = frozenset(),
    ) -> None:  # fmt: skip
        super().__init__(function)
        self.unit, self.places, self.statuses = unit, places or {}, statuses
        self.is_far = any(function.name == f.name for f in far_functions())
        self.is_mathematics = self.is_far or function in unit.mathematics
        self.precision = "f64" if self.is_far else unit.precision

    @property
    def real(self) -> str:
        """Type of real numbers."""
        return "double" if self.precision == "f64" else "float"

    def type_of(self, name: str, scalar: Scalar) -> str:
        return self.real if scalar == REAL else self.types[scalar]

    def result_type(self, k: int) -> str:
        return self.type_of("", self.function.results[k])

    def default_storage(self) -> str:
        return self.storage

    # -- numbers -------------------------------------------------------------------------------------------------------

    def constant(self, value: Constant) -> str:
        if value.type == BOOL and self.has_booleans:
            return "true" if value.value else "false"
        if value.type != REAL:
            return super().constant(value)
        number = rounded(float(value.value), self.precision)
        if math.isnan(number):
            return self.not_a_number
        if math.isinf(number):
            return self.infinity if number > 0 else f"-{self.infinity}"
        return self.literal(number)

    @property
    def not_a_number(self) -> str:
        """What is no number, in the precision of the file: the macro is a float."""
        return "(double)NAN" if self.precision == "f64" else "NAN"

    @property
    def infinity(self) -> str:
        """The infinite number."""
        return "(double)INFINITY" if self.precision == "f64" else "INFINITY"

    def literal(self, number: float) -> str:
        """A finite number, which the precision has."""
        return repr(number) if self.precision == "f64" else f"{number!r}f"

    def machine_number(self, name: str) -> str:
        """``"epsilon"``: the distance from 1 to the next number; ``"largest"``: the largest finite number."""
        limits = np.finfo(np.float64 if self.precision == "f64" else np.float32)
        return self.literal(float({"epsilon": limits.eps, "largest": limits.max}[name]))

    def square_root_or_size(self, name: str) -> str:
        """What ``"sqrt"`` and ``"abs"`` of reals are called."""
        return f"{ {'sqrt': 'sqrt', 'abs': 'fabs'}[name] }{'' if self.precision == 'f64' else 'f'}"

    def cast(self, type: str, text: str) -> str:
        if not self.is_functional:
            return super().cast(type, text)
        return f"{type}{text}" if _is_bracketed(text) else f"{type}({text})"

    def call(self, name: str, arguments: Sequence[str]) -> str:
        bracketed = f"({', '.join(arguments)})"
        match name:
            case "epsilon" | "largest":
                return self.machine_number(name)
            case "sqrt" | "abs":
                return self.square_root_or_size(name) + bracketed
            case "real":
                return self.cast(self.real, bracketed)
            case "int":
                return self.cast(self.types[INT], bracketed)
            case "any":
                return bracketed
            case "<<":
                unsigned = self.cast(self.unsigned, f"({arguments[0]})")
                return self.cast(self.types[INT], f"({unsigned} << ({arguments[1]}))")
            case "//" | "%" | "min" | "max" | "imin" | "imax" | "iabs":
                return self.helper({"//": "quotient", "%": "remainder"}.get(name, name)) + bracketed
            case _:
                return self.helper(self.mathematics + name) + bracketed

    # -- names ---------------------------------------------------------------------------------------------------------

    def variable(self, name: str) -> str:
        found = c_name(name)
        return f"{found}_" if found in self.own_words or found in language_words(self.language) else found

    def symbol(self, name: str) -> str:
        return f"{self.unit.name}_{name}"

    def helper(self, name: str) -> str:
        """What a function of the file's own is called that no text of the loop IR is behind."""
        return self.symbol(name)

    def function_name(self, function: Function) -> str:
        if function in self.unit.mathematics or any(function.name == f.name for f in far_functions()):
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
        return self.cast("int", f"({text})") if name in self.statuses else text

    @staticmethod
    def is_cleared(array: Array) -> bool:
        """Whether an array gets zeros where it is made: compilers warn of small ones that a loop fills."""
        return array.type.size <= CLEARED

    def table_lines(self, table: Table) -> list[str]:
        """Constants of the file."""
        kind = self.stored.get(table.type.bits) or self.type_of("", table.type.scalar)
        numbers = [self.constant(Constant(v, table.type.scalar)) for v in table.values]
        head, tail = self.table_form(kind, table.name, len(numbers))
        return wrap_arguments(head, numbers, tail)

    def table_form(self, kind: str, name: str, size: int) -> tuple[str, str]:
        """What stands before and behind the numbers of a table."""
        return f"static const {kind} {name}[{size}] = {{", "};"

    # -- kernels on structs --------------------------------------------------------------------------------------------

    def kernel_head(self, entry: Entry, end: str = ")") -> list[str]:
        """What a kernel for users begins with, or all of its declaration."""
        parameters = [self.slot_parameter(s) for s in entry.inputs]
        head = f"{self.kernel_storage} {self.kernel_type(entry)} {self.symbol(entry.name)}(".lstrip()
        return wrap_arguments(head, parameters or ["void"], end)

    def kernel_lines(self, entry: Entry) -> list[str]:
        """A kernel for users, without its comment."""
        body = [
            f"{self.kernel_type(entry)} {RESULT}{self.initial};",
            *self.unused(s.array for s in entry.inputs), *self._body(), f"return {RESULT};",
        ]  # fmt: skip
        return [*self.kernel_head(entry), "{", *(f"  {line}" for line in body), "}"]

    def kernel_type(self, entry: Entry) -> str:
        """Type of what a kernel returns."""
        own = result_of(entry)
        return self.slot_type(own.slot) if own.slot else self.struct_type(f"{entry.name}_result")

    def struct_type(self, name: str) -> str:
        """Type of a struct by its name in the unit."""
        return self.symbol(name)

    def slot_type(self, slot: Slot) -> str:
        """Type of a result or an argument, without an array's length."""
        if slot.is_status:
            return "int"
        return self.struct_type(slot.struct.name) if slot.struct else self.real

    def slot_parameter(self, slot: Slot) -> str:
        if slot.size and slot.struct is None:
            return f"const {self.real} {self.variable(slot.array)}[{slot.size}]"
        return f"{self.slot_type(slot)} {self.variable(slot.array)}"

    def slot_field(self, slot: Slot) -> str:
        """Declaration of a result among others."""
        length = f"[{slot.size}]" if slot.size and slot.struct is None else ""
        return f"{self.slot_type(slot)} {slot.name}{length};"


def kernel_printer(printer: type[ExportPrinter], unit: Unit, entry: Entry) -> ExportPrinter:
    """What prints a kernel for users."""
    names = printer(entry.function, unit)
    codes = frozenset(s.array for s in entry.outputs if s.is_status)
    return printer(entry.function, unit, places_of(entry, RESULT, names.variable), codes)


def mathematics_texts(unit: Unit, printer: type[ExportPrinter]) -> list[list[str]]:
    """Elementary functions of the unit's precision."""
    return _texts((f for f in unit.mathematics if f.name != FAR_OR_NEAR), unit, printer)


def file_values(unit: Unit, printer: type[ExportPrinter]) -> dict[str, Any]:
    """What templates of files are filled with."""
    own = {e.function: e for e in unit.entries if not e.is_kernel}
    return {
        "unit": unit,
        "header": header_lines(unit, printer.arithmetic),
        "places": TWO_OVER_PI.tolist(),
        "far": _texts(far_functions() if unit.is_reduced_far else [], unit, printer),
        "mathematics": mathematics_texts(unit, printer),
        "tables": [printer(unit.entries[0].function, unit).table_lines(t) for t in unit.tables],
        "functions": [(own.get(f), printer(f, unit).lines()) for f in unit.functions],
        "kernels": [(e, kernel_printer(printer, unit, e)) for e in unit.entries if e.is_kernel],
        "algorithms": [(e, printer(f, unit)) for f, e in own.items()],
        "result_of": result_of,
    }


def _texts(functions: Iterable[Function], unit: Unit, printer: type[ExportPrinter]) -> list[list[str]]:
    return [printer(f, unit).lines() for f in functions]


def _is_bracketed(text: str) -> bool:
    """Whether the first bracket closes at the end."""
    depth = 0
    for k, character in enumerate(text):
        depth += {"(": 1, ")": -1}.get(character, 0)
        if depth == 0:
            return text.startswith("(") and k == len(text) - 1
    return False
