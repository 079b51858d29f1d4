"""Statements and functions of JavaScript, and how TypeScript declares them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ....ir.loops.nodes import (
    Allocate,
    Array,
    Call,
    Constant,
    Expression,
    For,
    Function,
    Variable,
    View,
)
from ....ir.loops.types import BOOL, INT, REAL, ArrayType, Parameter, Scalar
from ....targets.blocks import wrap_arguments
from ....targets.loops import ATOM, counted, takes_count
from ....targets.templates import render
from ...bound import Table
from ...names import camel_case, lower_camel_case
from ...places import result_of
from ...unit import Entry, Slot, Unit
from ..literals import file_values, struct_literal
from .expressions import JsExpressions

#: Local arrays up to this length are set to zero one by one.
_SHORT = 8
#: Types of arrays by how their numbers are stored.
_WRITTEN = {"Real": "Float64Array", "Int": "Float64Array | Int32Array", "Int32": "Int32Array", "Int8": "Uint8Array"}


class JsPrinter(JsExpressions):
    """One function."""

    # -- statements ----------------------------------------------------------------------------------------------------

    def declaration(self, variable: Variable) -> str:
        zero = "false" if variable.type == BOOL else "0n" if variable.type == INT and self.is_wide else "0"
        return f"let {self.variable(variable.name)} = {zero};"

    def definition(self, variable: Variable, value: str, is_constant: bool) -> str:
        return f"{'const' if is_constant else 'let'} {self.variable(variable.name)} = {value};"

    def allocation(self, array: Array, is_zero: bool) -> list[str]:
        if not is_zero:
            return []
        if array.type.size > _SHORT:
            return [f"{self._local(array)}.fill(0);"]
        return [" = ".join([*(f"{self._local(array)}[{k}]" for k in range(array.type.size)), "0;"])]

    def stored_value(self, array: Array, value: Expression) -> str:
        bits = array.type.bits
        if bits == 64:
            return self._number(value)
        if self.is_wide:
            return f"Number(BigInt.as{'Uint' if bits == 8 else 'Int'}N({bits}, {self.text(value)}))"
        return f"{self.inside(value, ATOM)} {'& 255' if bits == 8 else '| 0'}"

    def for_head(self, loop: For) -> str:
        name, one = self.variable(loop.variable.name), "1n" if self.is_wide else "1"
        size = one.replace("1", str(abs(loop.step)))
        change = f"{name} {'+' if loop.step > 0 else '-'}= {size}"
        compare = "<" if loop.step > 0 else ">"
        return f"for (let {name} = {self.text(loop.start)}; {name} {compare} {self.inside(loop.stop, 6)}; {change})"

    def return_lines(self, values: Sequence[Expression]) -> list[str]:
        texts = [self._number(v) for v in values]
        return [f"return {texts[0]};" if len(texts) == 1 else f"return [{', '.join(texts)}];" if texts else "return;"]

    def _call_lines(self, call: Call, declared: set[str]) -> list[str]:
        callee = call.callee
        assert isinstance(callee, Function)
        arguments: list[str] = []
        for k, each in enumerate(call.arguments):
            if not isinstance(each, View):
                arguments.append(self._number(each))
                continue
            arguments += self._place(each.array, each.offset)
            if each.rows is not None and takes_count(callee, k):
                arguments.append(self._number(each.rows))
        begin = f"{self._own_name(callee)}("
        read = [(k, r) for k, r in enumerate(call.results) if r.name in self._read]
        if not read:
            return wrap_arguments(begin, arguments, ");")
        if len(callee.results) == 1:
            first, *others = wrap_arguments(begin, arguments, ")")
            text = self._taken_result("\n".join([first, *others]), read[0][1])
            return self._result(read[0][1], text, declared)
        together = self._spelled(f"{id(call)}.results", "results")
        lines = wrap_arguments(f"const {together} = {begin}", arguments, ");")
        for k, result in read:
            lines += self._result(result, self._taken_result(f"{together}[{k}]", result), declared)
        return lines

    def _taken_result(self, text: str, result: Variable) -> str:
        return f"BigInt({text})" if self.is_wide and result.type == INT else text

    def _result(self, result: Variable, text: str, declared: set[str]) -> list[str]:
        if result.name in declared:
            return [f"{self.variable(result.name)} = {text};"]
        return [self.definition(result, text, True)]

    # -- functions -----------------------------------------------------------------------------------------------------

    def head(self) -> str:
        taken = [name for p in self.function.parameters for name in self._parameter(p)]
        return "\n".join(wrap_arguments(f"function {self._own_name(self.function)}(", taken, ")"))

    def _parameter(self, parameter: Parameter) -> list[str]:
        name = self.variable(parameter.name)
        if not isinstance(parameter.type, ArrayType):
            return [name]
        has_count = parameter.name in counted(self.function)
        count = [self._spelled(f"{parameter.name}.count", f"{parameter.name}_count")] if has_count else []
        return [name, self._begin(parameter.name), *count]

    def _body(self) -> list[str]:
        integers = [self.variable(p.name) for p in self.function.parameters if p.type == INT and self.is_wide]
        return [*(f"{name} = BigInt({name});" for name in integers), *super()._body()]

    def lines(self) -> list[str]:
        return [*super().lines(), *self._arrays()]

    def _arrays(self) -> list[str]:
        """Local arrays, which are made once."""
        local = [s.array for s in self.function.walk() if isinstance(s, Allocate)]
        return [f"const {self._local(a)} = new Float64Array({a.type.size});" for a in local]

    def algorithm_lines(self, entry: Entry) -> list[str]:
        taken, given = [self.variable(p.name) for p in self.function.parameters], []
        for p in self.function.parameters:
            given.append(self.variable(p.name))
            if isinstance(p.type, ArrayType):
                rows = f"{given[-1]}.length"
                rows = rows if p.type.size == 1 else f"Math.floor({rows} / {p.type.size})"
                given += ["0", *([rows] if p.name in counted(self.function) else [])]
        word = "return " if self.function.results else ""
        call = wrap_arguments(f"{word}{self._own_name(self.function)}(", given, ");")
        head = f"export function {self.spelled(entry.name)}({', '.join(taken)}) {{"
        inner = [f"{self.head()} {{", *self.indented(self._body()), "}", *self._arrays()]
        return [head, *self.indented(call), "}", "", *inner]

    def table_lines(self, table: Table) -> list[str]:
        numbers = [self.real_constant(Constant(v, REAL)) if table.type.scalar == REAL else str(v) for v in table.values]
        return wrap_arguments(f"const {table.name} = new Float64Array([", numbers, "]);")

    # -- kernels on structs --------------------------------------------------------------------------------------------

    def kernel_head(self, entry: Entry) -> str:
        return f"export function {self.spelled(entry.name)}({', '.join(self.variable(s.array) for s in entry.inputs)})"

    def kernel_lines(self, entry: Entry) -> list[str]:
        return [*super().kernel_lines(entry), *self._arrays()]

    def number(self, slot: Slot, value: Expression) -> str:
        return str(int(value.value)) if slot.is_status and isinstance(value, Constant) else self.text(value)

    def struct(self, name: str, fields: Sequence[tuple[str, str]]) -> str:
        return struct_literal("", [f if f == v else f"{f}: {v}" for f, v in fields], self.indent)

    # -- declarations of types -----------------------------------------------------------------------------------------

    def declared(self, entry: Entry) -> str:
        """The function as TypeScript declares it."""
        if entry.is_kernel:
            taken = [f"{self.variable(s.array)}: {_slot_type(s, 'ArrayLike<number>')}" for s in entry.inputs]
            own = result_of(entry).slot
            kind = _slot_type(own, "") if own else camel_case(f"{entry.name}_result")
        else:
            taken = [f"{self.variable(p.name)}: {_type(p)}" for p in entry.function.parameters]
            kinds = ["boolean" if t == BOOL else "number" for t in entry.function.results]
            kind = kinds[0] if len(kinds) == 1 else f"[{', '.join(kinds)}]" if kinds else "void"
        return "\n".join(wrap_arguments(f"export function {self.spelled(entry.name)}(", taken, f"): {kind};"))


def _slot_type(slot: Slot, array: str) -> str:
    if slot.struct:
        return camel_case(slot.struct.name)
    return array if slot.size else "number"


def _type(parameter: Parameter) -> str:
    if isinstance(parameter.type, Scalar):
        return "boolean" if parameter.type == BOOL else "number"
    assert isinstance(parameter.type, ArrayType)
    return "ArrayLike<number>" if parameter.access == "in" else f"{_WRITTEN[parameter.type.storage]} | number[]"


def js_files(unit: Unit) -> Mapping[str, str]:
    """The module and its declarations.

    Returns
    -------
    mapping of str to str
        File name to text.
    """
    values = file_values(unit, JsPrinter)
    types = [(e, JsPrinter(e.function, unit, e if e.is_kernel else None).declared(e)) for e in unit.entries]
    values.update(types=types, slot_type=_slot_type, camel_case=camel_case, spelled=lower_camel_case)
    return {f"{unit.name}.mjs": render("js.mjs.j2", **values), f"{unit.name}.d.mts": render("js.d.mts.j2", **values)}
