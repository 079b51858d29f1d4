"""Algorithms in C, on the short names of templates/c/lib/instance.h; CUDA takes the same text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from ...ir.loops.nodes import (
    Array,
    Call,
    Constant,
    Expression,
    For,
    Function,
    Intrinsic,
    KernelSignature,
    Variable,
    View,
    expressions,
    parts,
)  # fmt: skip
from ...ir.loops.types import INT, REAL, ArrayType, Parameter, Scalar
from ..blocks import BlockPrinter, wrap_arguments
from ..loops import counted, in_calling_order, takes_count
from ..printer import comment_text
from .names import STORED, TYPES, c_function_name, c_name

#: Functions of numbers: those of loops.h in small letters.
_FUNCTIONS = {
    "sqrt": "SQRT", "abs": "ABS", "sin": "SIN", "cos": "COS", "exp": "EXP", "log": "LOG", "atan2": "ATAN2",
    "min": "FN(bs_min)", "max": "FN(bs_max)", "imin": "bs_min", "imax": "bs_max", "iabs": "bs_magnitude",
    "real": "(S)", "int": "(ptrdiff_t)", "//": "bs_quotient", "%": "bs_remainder",
    "any": "",
}  # fmt: skip
ELEMENTARY = frozenset(("sin", "cos", "exp", "log", "atan2"))


class CLoopPrinter(BlockPrinter):
    """One function."""

    logical = {"and": "&&", "or": "||", "not": "!"}
    functions = frozenset(("//", "%", "<<"))
    #: Types of numbers, and of integers of arrays by the bits in which they are stored.
    types, stored = TYPES, STORED
    #: Before the type of a number that is assigned once.
    constant_word = "const "
    #: How functions of numbers are called.
    number_functions = _FUNCTIONS

    # -- expressions -------------------------------------------------------------------------------------------------

    def constant(self, value: Constant) -> str:
        if value.type == REAL:
            number = float(value.value)
            if math.isinf(number):
                return "K(BS_HUGE_VALUE)" if number > 0 else "-K(BS_HUGE_VALUE)"
            return "K(BS_NOT_A_NUMBER)" if math.isnan(number) else f"K({number!r})"
        return str(int(value.value)) if value.value != -(1 << 63) else "(-9223372036854775807 - 1)"

    def variable(self, name: str) -> str:
        return c_name(name)

    def count(self, array: Array) -> str:
        return f"{self.variable(array.name)}_count_"

    def load(self, array: Array, index: Expression) -> str:
        element = self.element(array, index)
        return element if array.type.bits == 64 else self.cast(self.types[INT], element)

    def element(self, array: Array, index: Expression) -> str:
        return f"{self.variable(array.name)}[{self.text(index)}]"

    def cast(self, type: str, text: str) -> str:
        """A number in another type."""
        return f"({type}){text}"

    def select(self, condition: str, yes: str, no: str) -> str:
        return f"{condition} ? {yes} : {no}"

    def call(self, name: str, arguments: Sequence[str]) -> str:
        if name == "epsilon":
            return "K(BS_EPSILON)"
        if name == "largest":
            return "K(BS_GREATEST)"
        if name == "<<":
            return f"({self.types[INT]})((uint64_t)({arguments[0]}) << ({arguments[1]}))"
        function = self.number_functions[name]
        joined = ", ".join(arguments)
        return f"{function}({joined})"

    def view(self, view: View) -> str:
        offset = self.text(view.offset)
        name = self.variable(view.array.name)
        return name if offset == "0" else f"{name} + {self.inside(view.offset, 6)}"

    # -- what differs where several items are computed at once (see lanes.py) ------------------------------------------

    def type_of(self, name: str, scalar: Scalar) -> str:
        """C type of a number, or of those of an array."""
        return self.types[scalar]

    def stored_type(self, array: Array) -> str:
        """C type of the numbers of a parameter's array."""
        return self.stored.get(array.type.bits) or self.type_of(array.name, array.type.scalar)

    def result_type(self, k: int) -> str:
        """C type of a number that the function returns."""
        return self.types[self.function.results[k]]

    def returned(self, k: int, value: Expression) -> str:
        """What is returned."""
        return self.text(value)

    def function_name(self, function: Function) -> str:
        """Its name in C, without the instance's tag."""
        return c_function_name(function.name)

    def symbol(self, name: str) -> str:
        """What a function of this name, which C can have, is called."""
        return f"FN({name})"

    def called(self, function: Function) -> str:
        """How a function is written where it is called."""
        return self.symbol(self.function_name(function))

    def default_storage(self) -> str:
        """What stands before a function."""
        return "BS_INLINE" if self.function.is_inline else "BS_OUTLINED"

    def unused(self, names: Iterable[str]) -> list[str]:
        """Statements that use parameters which the function does not."""
        return [f"(void){self.variable(name)};" for name in names if name not in self._used]

    def result_parameter(self, k: int) -> str:
        """Declaration of the place of one of several results."""
        return f"{self.result_type(k)} *result{k}_"

    def result_place(self, k: int) -> str:
        """The place of one of several results, inside the function."""
        return f"*result{k}_"

    def result_argument(self, variable: Variable) -> str:
        """Where a function that is called puts one of several results."""
        return f"&{self.variable(variable.name)}"

    def array_parameter(self, parameter: Parameter, type: str, length: str) -> str:
        """Declaration of an array that the function takes; ``length``: empty where it is not known."""
        const = "const " if parameter.access == "in" else ""
        name = self.variable(parameter.name)
        return f"{const}{type} {name}{length}" if length else f"{const}{type} *{name}"

    def array_length(self, size: int) -> str:
        """Behind the name of an array that a function takes."""
        return f"[BS_LENGTH({size})]"

    def argument(self, call: Call, k: int, before: list[str]) -> str:
        """An argument of a call; lines that come before it are added."""
        each = call.arguments[k]
        return self.view(each) if isinstance(each, View) else self.text(each)

    # -- functions ---------------------------------------------------------------------------------------------------

    def lines(self, storage: str = "") -> list[str]:
        """The function, with its comment."""
        function = self.function
        note = comment_text(function.note)
        body = self.indented([*self.unused(p.name for p in function.parameters), *self._body()])
        return [f"/* {note} */", *self.head(storage), "{", *body, "}"]

    def head(self, storage: str = "", end: str = ")") -> list[str]:
        """What a function begins with, or all of its declaration."""
        function = self.function
        result = self.result_type(0) if len(function.results) == 1 else "void"
        parameters = [text for p in function.parameters for text in self._parameter(p)]
        if len(function.results) > 1:
            parameters += [self.result_parameter(k) for k in range(len(function.results))]
        name = self.function_name(function)
        head = f"{storage or self.default_storage()} {result} {self.symbol(name)}(".lstrip()
        return wrap_arguments(head, parameters or ["void"], end)

    def _parameter(self, parameter: Parameter) -> list[str]:
        name = self.variable(parameter.name)
        if not isinstance(parameter.type, ArrayType):
            assert isinstance(parameter.type, Scalar)
            return [f"{self.type_of(parameter.name, parameter.type)} {name}"]
        type = self.stored_type(Array(parameter.name, parameter.type))
        if not parameter.type.is_open:
            return [self.array_parameter(parameter, type, self.array_length(parameter.type.size))]
        count = [f"{self.types[INT]} {name}_count_"] if parameter.name in counted(self.function) else []
        return [self.array_parameter(parameter, type, ""), *count]

    # -- statements ----------------------------------------------------------------------------------------------------

    def declaration(self, variable: Variable) -> str:
        return f"{self.type_of(variable.name, variable.type)} {self.variable(variable.name)};"

    def definition(self, variable: Variable, value: str, is_constant: bool) -> str:
        type = self.type_of(variable.name, variable.type)
        return f"{self.constant_word if is_constant else ''}{type} {self.variable(variable.name)} = {value};"

    def allocation(self, array: Array, is_zero: bool) -> list[str]:
        zero = " = {0}" if is_zero else ""
        return [f"{self.type_of(array.name, array.type.scalar)} {self.variable(array.name)}[{array.type.size}]{zero};"]

    def stored_value(self, array: Array, value: Expression) -> str:
        cast, text = self.stored.get(array.type.bits), self.value_for(array.name, value)
        return self.cast(cast, f"({text})") if cast else text

    def for_head(self, loop: For) -> str:
        name = self.variable(loop.variable.name)
        compare = "<" if loop.step > 0 else ">"
        change = {1: f"{name}++", -1: f"{name}--"}.get(loop.step, f"{name} += {loop.step}")
        bounds = f"{name} = {self.text(loop.start)}; {name} {compare} {self.inside(loop.stop, 6)}"
        return f"for ({self.types[INT]} {bounds}; {change})"

    def return_lines(self, values: Sequence[Expression]) -> list[str]:
        if len(values) == 1:
            return [f"return {self.returned(0, values[0])};"]
        return [*(f"{self.result_place(k)} = {self.returned(k, v)};" for k, v in enumerate(values)), "return;"]

    def _call_lines(self, call: Call, declared: set[str]) -> list[str]:
        arguments: list[str] = []
        before: list[str] = []
        for k, each in enumerate(call.arguments):
            arguments.append(self.argument(call, k, before))
            if isinstance(each, View) and each.rows is not None and takes_count(call.callee, k):
                arguments.append(self.text(each.rows))
        if isinstance(call.callee, KernelSignature):
            return [*before, *wrap_arguments(f"{self.symbol(call.callee.symbol)}(", arguments, ");")]
        lines = [self.declaration(r) for r in call.results if r.name not in declared and len(call.results) > 1]
        name = f"{self.called(call.callee)}("
        if len(call.results) == 1 and len(call.callee.results) == 1:
            result = call.results[0]
            if result.name not in self._read:
                return [*before, *wrap_arguments(name, arguments, ");")]
            prefix = "" if result.name in declared else f"{self.constant_word}{self.type_of(result.name, result.type)} "
            return [*before, *wrap_arguments(f"{prefix}{self.variable(result.name)} = {name}", arguments, ");")]
        arguments += [self.result_argument(r) for r in call.results]
        return [*before, *lines, *wrap_arguments(name, arguments, ");")]


def c_functions(roots: Iterable[Function], printed: Iterable[Function] = ()) -> str:
    """C text of some algorithms and of those that they call, callees first.

    Parameters
    ----------
    roots : iterable of Function
    printed : iterable of Function
        Algorithms whose text, with that of what they call, stands before.
    """
    before = set(in_calling_order(printed, is_c=True)[0])
    functions, _ = in_calling_order(roots, is_c=True)
    return "\n".join("\n".join([*CLoopPrinter(f).lines(), ""]) for f in functions if f not in before)


def c_declarations(functions: Iterable[Function], storage: str) -> str:
    """C declarations of functions that are defined elsewhere."""
    return "".join("\n".join([*CLoopPrinter(f).head(storage, ");"), ""]) for f in functions)


def needs_elementary(roots: Iterable[Function]) -> bool:
    """Whether elementary.h is to be included."""
    functions, _ = in_calling_order(roots, is_c=True)
    found = (p for f in functions for s in f.walk() for e in expressions(s) for p in parts(e))
    return any(isinstance(p, Intrinsic) and p.name in ELEMENTARY for p in found)
