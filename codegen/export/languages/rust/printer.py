"""Statements and functions of Rust."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ....ir.loops.nodes import (
    Array,
    Call,
    Constant,
    Count,
    Expression,
    For,
    Function,
    Load,
    Variable,
    View,
    assigned_variables,
    integer,
    parts,
    plus,
    scaled,
)
from ....ir.loops.types import BOOL, INT, REAL, ArrayType, Parameter, Scalar
from ....targets.blocks import wrap_arguments
from ....targets.loops import ATOM
from ....targets.templates import render
from ...bound import Table
from ...names import camel_case
from ...places import result_of
from ...unit import Entry, Slot, Unit
from ..literals import file_values, is_whole, struct_literal
from .expressions import STORED, RustExpressions


class RustPrinter(RustExpressions):
    """One function.

    Of an array that a call changes, other parts are copied for it: what it reads has the values from before. Parts of
    one array that it changes must not overlap, or the program stops.
    """

    # -- statements ----------------------------------------------------------------------------------------------------

    def declaration(self, variable: Variable) -> str:
        zero = {REAL: "0.0", INT: "0", BOOL: "false"}[variable.type]
        return f"let mut {self.variable(variable.name)}: {self.type_of(variable.type)} = {zero};"

    def definition(self, variable: Variable, value: str, is_constant: bool) -> str:
        word = "let" if is_constant else "let mut"
        return f"{word} {self.variable(variable.name)}: {self.type_of(variable.type)} = {value};"

    def allocation(self, array: Array, is_zero: bool) -> list[str]:
        zero = "0.0" if array.type.scalar == REAL else "0"
        return [f"let mut {self.variable(array.name)}: {self.array_type(array.type)} = [{zero}; {array.type.size}];"]

    def stored_value(self, array: Array, value: Expression) -> str:
        stored = STORED.get(array.type.bits)
        return f"{self._cast_operand(value)} as {stored}" if stored else self.text(value)

    def condition(self, condition: Expression) -> str:
        return self.text(condition)

    def while_head(self, condition: Expression) -> str:
        always = isinstance(condition, Constant) and condition.value
        return "loop" if always else super().while_head(condition)

    def for_head(self, loop: For) -> str:
        start, stop = (loop.start, loop.stop) if loop.step > 0 else (_after(loop.stop), _after(loop.start))
        is_known = isinstance(start, Constant) and isinstance(stop, Constant)
        bounds = f"{self._bound(start)}{'_i64' if is_known else ''}..{self._bound(stop)}"
        if loop.step != 1:
            bounds = f"({bounds}){'.rev()' if loop.step < 0 else ''}"
        step = "" if abs(loop.step) == 1 else f".step_by({abs(loop.step)})"
        return f"for {self.variable(loop.variable.name)} in {bounds}{step}"

    def _bound(self, value: Expression) -> str:
        return self.constant(value) if isinstance(value, Constant) else self.inside(value, ATOM)

    def return_lines(self, values: Sequence[Expression]) -> list[str]:
        texts = [self.text(v) for v in values]
        return [f"return {texts[0]};" if len(texts) == 1 else f"return ({', '.join(texts)});" if texts else "return;"]

    # -- calls ---------------------------------------------------------------------------------------------------------

    def _call_lines(self, call: Call, declared: set[str]) -> list[str]:
        callee = call.callee
        assert isinstance(callee, Function)
        before: list[str] = []
        arguments: list[str] = [""] * len(call.arguments)
        is_written = [p.access != "in" for p in callee.parameters]
        views = {k: a for k, a in enumerate(call.arguments) if isinstance(a, View)}
        changed = {views[k].array.name for k in views if is_written[k]}
        for k, each in enumerate(call.arguments):  # what is read of arrays that the call changes
            if not isinstance(each, View):
                arguments[k] = self.text(self._before(f"argument{k}_", each, changed, before))
                continue
            offset = self._before(f"offset{k}_", each.offset, changed, before)
            rows = each.rows and self._before(f"rows{k}_", each.rows, changed, before)
            views[k] = replace(each, offset=offset, rows=rows)
        for name in sorted(changed):
            own = [k for k, view in views.items() if view.array.name == name]
            for k in own if len(own) > 1 else ():
                if not is_written[k] and not views[k].type.is_open:
                    before.append(f"let part{k}_: {self.array_type(views[k].type)} = *{self._part(views[k], False)};")
                    arguments[k] = f"&part{k}_"
            rest = [k for k in own if not arguments[k]]
            if len(rest) > 1:
                before += self._split([views[k] for k in rest], [f"part{k}_" for k in rest])
                for k in rest:
                    arguments[k] = f"part{k}_" if views[k].type.is_open else f"math::part_mut(part{k}_, 0)"
        for k, view in views.items():
            arguments[k] = arguments[k] or self._part(view, is_written[k])
        names = [self.variable(r.name) if r.name in self._read else "_" for r in call.results]
        prefix = ""
        if any(name != "_" for name in names):
            old = [r for r in call.results if r.name in declared and r.name in self._read]
            if old:
                before += [self.declaration(r) for r in call.results if r.name not in declared and r.name in self._read]
            joined = names[0] if len(names) == 1 else f"({', '.join(names)})"
            prefix = f"{'' if old else 'let '}{joined} = "
        return [*before, *wrap_arguments(f"{prefix}{self._function_path(callee)}(", arguments, ");")]

    def _before(self, name: str, value: Expression, changed: set[str], before: list[str]) -> Expression:
        """A number by a name, where it is read from an array that cannot be read in the call."""
        if not any(isinstance(p, (Load, Count)) and p.array.name in changed for p in parts(value)):
            return value
        own = Variable(name, value.type)
        before.append(self.definition(own, self.text(value), True))
        return own

    def _split(self, views: Sequence[View], names: Sequence[str]) -> list[str]:
        places = ", ".join(f"({self.text(v.offset)}, {self._length(v)})" for v in views)
        array = self._whole_array(views[0].array, True)
        return [f"let [{', '.join(names)}] = math::parts_mut({array}, [{places}]);"]

    def _length(self, view: View) -> str:
        """Numbers of a part."""
        if view.rows is None:
            return str(view.type.size)
        return self.text(scaled(view.rows, view.type.size))

    def _whole_array(self, array: Array, is_written: bool) -> str:
        if not self._is_own(array):
            return f"&{array.name.upper()}"
        name = self.variable(array.name)
        return f"&{'mut ' if is_written else ''}{name}" if array.is_local else name

    def _part(self, view: View, is_written: bool) -> str:
        whole, suffix = self._whole_array(view.array, is_written), "_mut" if is_written else ""
        is_first = isinstance(view.offset, Constant) and view.offset.value == 0
        if is_whole(view) or (is_first and view.type.is_open and view.rows == Count(view.array)
                              and view.type.size == view.array.type.size):  # fmt: skip
            return whole
        if view.type.is_open:
            return f"math::rows{suffix}({whole}, {self.text(view.offset)}, {self._length(view)})"
        return f"math::part{suffix}({whole}, {self.text(view.offset)})"

    def _function_path(self, function: Function) -> str:
        if function in self.unit.mathematics or self.is_far:
            return f"{self._mathematics}{function.name}"
        return f"self::{self.unit.name_of(function)}"

    # -- functions -----------------------------------------------------------------------------------------------------

    def head(self) -> str:
        function = self.function
        inline = "#[inline]\n" if function.is_inline and not self.is_mathematics else ""
        name = function.name if self.is_mathematics else self.unit.name_of(function)
        return f"{inline}{'pub ' if self.is_mathematics else ''}{self._signature(name)}"

    def algorithm_lines(self, entry: Entry) -> list[str]:
        return [f"pub {self._signature(entry.name)} {{", *self.indented(self._body()), "}"]

    def _signature(self, name: str) -> str:
        results = [self.type_of(r) for r in self.function.results]
        returned = "" if not results else f" -> {results[0] if len(results) == 1 else '(' + ', '.join(results) + ')'}"
        parameters = [self._parameter(p) for p in self.function.parameters]
        return "\n".join(wrap_arguments(f"fn {name}(", parameters, f"){returned}"))

    def _parameter(self, parameter: Parameter) -> str:
        name = self.variable(parameter.name)
        if isinstance(parameter.type, ArrayType):
            return f"{name}: &{'' if parameter.access == 'in' else 'mut '}{self.array_type(parameter.type)}"
        assert isinstance(parameter.type, Scalar)
        is_changed = any(v.name == parameter.name for v in assigned_variables(self.function.body))
        return f"{'mut ' if is_changed else ''}{name}: {self.type_of(parameter.type)}"

    def table_lines(self, table: Table) -> list[str]:
        numbers = [self.constant(Constant(v, table.type.scalar)) for v in table.values]
        return wrap_arguments(f"static {table.name.upper()}: {self.array_type(table.type)} = [", numbers, "];")

    # -- kernels on structs --------------------------------------------------------------------------------------------

    def kernel_head(self, entry: Entry) -> str:
        own = [f"{self.variable(s.array)}: {self._argument_type(s)}" for s in entry.inputs]
        single = result_of(entry).slot
        kind = self.slot_type(single) if single else camel_case(f"{entry.name}_result")
        return "\n".join(["#[inline]", *wrap_arguments(f"pub fn {entry.name}(", own, f") -> {kind}")])

    def _argument_type(self, slot: Slot) -> str:
        return f"&{self.slot_type(slot)}" if slot.size and not slot.struct else self.slot_type(slot)

    def slot_type(self, slot: Slot) -> str:
        """Type of a result or an argument."""
        if slot.struct:
            return camel_case(slot.struct.name)
        return "i32" if slot.is_status else f"[{self.precision}; {slot.size}]" if slot.size else self.precision

    def number(self, slot: Slot, value: Expression) -> str:
        if not slot.is_status:
            return self.text(value)
        return str(int(value.value)) if isinstance(value, Constant) else f"{self._cast_operand(value)} as i32"

    def struct(self, name: str, fields: Sequence[tuple[str, str]]) -> str:
        inner = [f if f == v else f"{f}: {v}" for f, v in fields]
        return struct_literal(f"{camel_case(name)} ", inner, self.indent)

    def result(self, value: str) -> str:
        return value


def _after(value: Expression) -> Expression:
    return plus(value, integer(1))


def rust_files(unit: Unit) -> Mapping[str, str]:
    """The module.

    Returns
    -------
    mapping of str to str
        File name to text.
    """
    values = file_values(unit, RustPrinter)
    types = RustPrinter(unit.entries[0].function, unit)
    return {f"{unit.name}.rs": render("rust.rs.j2", **values, slot_type=types.slot_type, camel_case=camel_case)}
