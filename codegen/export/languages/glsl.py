"""GLSL: functions and structs for shaders of version 330, 300 es and later, in single precision."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from ...elementary.constants import SINGLE
from ...errors import InputError
from ...ir.loops.nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
    Call,
    Constant,
    Expression,
    Function,
    Load,
    Return,
    Store,
    Variable,
    View,
    expressions,
    parts,
)
from ...ir.loops.types import BOOL, INT, REAL, ArrayType, Parameter
from ...targets.c.names import c_name
from ...targets.templates import render
from ..names import language_words
from ..unit import Entry, Slot, Unit, deep_callees
from .c_family import ExportPrinter, file_values
from .notation import Notation

_NEAR = int(SINGLE.near)
_REMEDY = "Export it in another language, or give all arrays fixed lengths and pass them whole."


class GlslPrinter(ExportPrinter):
    """Functions of GLSL, which has no pointers: arrays are copied in and out."""

    language = "glsl"
    arithmetic = (
        "Numbers are float, integers have 32 bits. The order of operations is that of the other languages, but shaders "
        "may contract products and sums, and their quotients, roots, infinities and NaN are what the driver gives. "
        f"Angles up to {_NEAR} are reduced here; beyond, they are as good as the driver's own sin and cos."
    )
    types = {INT: "int", BOOL: "bool"}
    stored: dict[int, str] = {}
    unsigned = "uint"
    storage = kernel_storage = constant_word = ""
    has_booleans = is_functional = True
    not_a_number, infinity = "intBitsToFloat(0x7fc00000)", "intBitsToFloat(0x7f800000)"
    own_words = frozenset(("sqrt", "abs"))

    def literal(self, number: float) -> str:
        return super().literal(number).removesuffix("f")

    def square_root_or_size(self, name: str) -> str:
        return name

    def variable(self, name: str) -> str:
        return _glsl_name(name)

    def _print(self, expression: Expression) -> tuple[str, int]:
        match expression:
            case Binary(("&" | "|" | "^") as operator, left, right, type) if type == BOOL:
                return super()._print(Binary({"&": "and", "|": "or", "^": "!="}[operator], left, right, type))
            case _:
                return super()._print(expression)

    # -- declarations --------------------------------------------------------------------------------------------------

    def declaration(self, variable: Variable) -> str:
        return self._before(variable) + super().declaration(variable)

    def definition(self, variable: Variable, value: str, is_constant: bool) -> str:
        return self._before(variable) + super().definition(variable, value, is_constant)

    def _before(self, variable: Variable) -> str:
        return f"{self._precise} " if self.is_mathematics and variable.type == REAL else ""

    @property
    def _precise(self) -> str:
        return f"{self.unit.name.upper()}_PRECISE"

    def unused(self, names: Iterable[str]) -> list[str]:
        return []

    def array_parameter(self, parameter: Parameter, type: str, length: str) -> str:
        access = {"in": "", "out": "out " if _writes_all(self.function, parameter) else "inout "}
        return f"{access.get(parameter.access, 'inout ')}{type} {self.variable(parameter.name)}{length}"

    def result_parameter(self, k: int) -> str:
        precise = f"{self._precise} " if self.is_mathematics else ""
        return f"{precise}out {self.result_type(k)} result{k}_"

    def result_place(self, k: int) -> str:
        return f"result{k}_"

    def result_argument(self, variable: Variable) -> str:
        return self.variable(variable.name)

    def allocation(self, array: Array, is_zero: bool) -> list[str]:
        lines = super().allocation(array, False)
        if is_zero:
            zero = "0.0" if array.type.scalar == REAL else "0"
            each = f"{self.variable(array.name)}[zero_] = {zero};"
            lines.append(f"for (int zero_ = 0; zero_ < {array.type.size}; zero_++) {each}")
        return lines

    def table_form(self, kind: str, name: str, size: int) -> tuple[str, str]:
        return f"const {kind} {name}[{size}] = {kind}[{size}](", ");"

    def slot_parameter(self, slot: Slot) -> str:
        return super().slot_parameter(slot).removeprefix("const ")


def renamed(unit: Unit) -> Unit:
    """The unit with fields that have no word of the language for a name."""

    def entry(e: Entry) -> Entry:
        return replace(e, outputs=tuple(replace(s, name=_glsl_name(s.name)) for s in e.outputs))

    return replace(unit, entries=tuple(entry(e) for e in unit.entries))


def _glsl_name(name: str) -> str:
    """Names do not begin with ``gl_``, nor have two underscores side by side."""
    found = c_name(name)
    found = f"{found}_" if found in GlslPrinter.own_words or found in language_words("glsl") else found
    found = found.replace("__", "_0_")
    return f"of_{found}" if found.startswith("gl_") else found


def glsl_files(unit: Unit) -> Mapping[str, str]:
    """The file.

    Returns
    -------
    mapping of str to str
        File name to text.

    Raises
    ------
    InputError
        If an algorithm needs what GLSL does not have.
    """
    for entry in unit.entries:
        if not entry.is_kernel:
            for function in (entry.function, *deep_callees(entry.function)):
                _check(entry.name, function)
    unit = renamed(unit)
    notation = Notation(
        32, "float", "int", "uint", "bool", "int", "uint", "", "", prefix=f"{unit.name}_{GlslPrinter.mathematics}",
        name=f"{unit.name}_", constant="", is_functional=True,
    )  # fmt: skip
    values = {**file_values(unit, GlslPrinter), "l": notation}
    return {f"{unit.name}.glsl": render("export.glsl.j2", **values)}


# -- what cannot be said ---------------------------------------------------------------------------------------------


def _check(name: str, function: Function) -> None:
    for parameter in function.parameters:
        if isinstance(parameter.type, ArrayType) and parameter.type.is_open:
            raise _refusal(name, function, f"takes {parameter.name!r}, an array of any length")
    for statement in function.walk():
        numbers = [p for e in expressions(statement) for p in parts(e) if isinstance(p, Constant) and p.type == INT]
        if large := [n for n in numbers if abs(n.value) >= 1 << 31]:
            raise _refusal(name, function, f"has the integer {large[0].value}, which needs more than 32 bits")
        if isinstance(statement, Call) and isinstance(statement.callee, Function):
            _check_views(name, function, statement.callee, statement)


def _check_views(name: str, function: Function, callee: Function, call: Call) -> None:
    views = [a for a in call.arguments if isinstance(a, View)]
    for view in views:
        is_whole = (
            isinstance(view.offset, Constant) and view.offset.value == 0 and view.type.size == view.array.type.size
        )
        if not is_whole:
            raise _refusal(name, function, f"hands a part of {view.array.name!r} on to {callee.name}")
    arrays = [v.array.name for v in views]
    if len(set(arrays)) < len(arrays) and not _reads_first(callee):
        raise _refusal(name, function, f"hands one array on to {callee.name} twice")


def _refusal(name: str, function: Function, what: str) -> InputError:
    return InputError(f"the algorithm {name!r} cannot be exported as GLSL: {function.name} {what}.", remedy=_REMEDY)


def _reads_first(function: Function) -> bool:
    """Whether a function without branches stores nothing before all is read: copies do not matter then."""
    if not all(isinstance(s, (Assign, Store, Allocate, Call, Return)) for s in function.body):
        return False
    inputs = {p.name for p in function.parameters if p.access == "in"}
    outputs = {p.name for p in function.parameters if p.access != "in"}
    has_stored = False
    for statement in function.body:
        loads = [p for e in expressions(statement) for p in parts(e) if isinstance(p, Load)]
        views = (
            [a.array.name for a in statement.arguments if isinstance(a, View)] if isinstance(statement, Call) else []
        )
        if has_stored and (any(p.array.name in inputs for p in loads) or inputs.intersection(views)):
            return False
        has_stored |= isinstance(statement, Store) and statement.array.name in outputs
        has_stored |= bool(outputs.intersection(views))
    return True


def _writes_all(function: Function, parameter: Parameter) -> bool:
    """Whether every element of an array is stored in any case."""
    stored = {
        s.index.value
        for s in function.body
        if isinstance(s, Store) and s.array.name == parameter.name and isinstance(s.index, Constant)
    }
    return isinstance(parameter.type, ArrayType) and stored == set(range(parameter.type.size))
