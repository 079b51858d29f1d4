"""Algorithms in C, on the short names of templates/c/lib/instance.h; CUDA takes the same text.

A number is declared where it is first assigned, as far inside the blocks as its uses allow.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from functools import cache

from ...ir.loops.nodes import (
    Allocate,
    Array,
    Assign,
    Break,
    Call,
    Constant,
    Continue,
    Expression,
    For,
    Function,
    If,
    Intrinsic,
    KernelSignature,
    Return,
    Statement,
    Store,
    Variable,
    View,
    While,
    blocks,
    expressions,
    parts,
    walk,
)  # fmt: skip
from ...ir.loops.types import BOOL, INT, REAL, ArrayType, Parameter, Scalar
from ..loops import LoopPrinter, counted, in_calling_order, takes_count
from ..printer import comment_text
from ..templates import template_text

_TYPES = {REAL: "S", INT: "ptrdiff_t", BOOL: "int"}
#: Functions of numbers: those of loops.h in small letters.
_FUNCTIONS = {
    "sqrt": "SQRT", "abs": "ABS", "sin": "SIN", "cos": "COS", "exp": "EXP", "log": "LOG", "atan2": "ATAN2",
    "min": "FN(bs_min)", "max": "FN(bs_max)", "imin": "bs_min", "imax": "bs_max", "iabs": "bs_magnitude",
    "real": "(S)", "int": "(ptrdiff_t)", "//": "bs_quotient", "%": "bs_remainder",
}  # fmt: skip
ELEMENTARY = frozenset(("sin", "cos", "exp", "log", "atan2"))
_INDENT, _LINE = "  ", 118


def c_name(name: str) -> str:
    """A name of the text: never one that C or instance.h has. Theirs do not end with an underscore."""
    return f"{name}_" if name.isupper() or name in _TAKEN or name.endswith("_") or name.startswith("bs_") else name


#: Words of C and C++, and names that their headers or CUDA give a meaning.
_WORDS = """
alignas alignof and and_eq asm auto bool break case catch char class const continue default delete do double else enum
explicit export extern false float for friend goto if inline int long main mutable namespace nan new not operator or
private protected ptrdiff_t public register restrict return short signed size_t sizeof static struct switch template
this throw true try typedef typename union unsigned using virtual void volatile wchar_t while xor int32_t int64_t
errno linux unix stdin stdout stderr uint8_t uint32_t uint64_t threadIdx blockIdx blockDim gridDim
"""
_TAKEN = frozenset(_WORDS.split())


#: Headers before the functions of an algorithm.
_HEADERS = ("instance.h", "rows.h", "loops.h", "elementary.h")


def c_function_name(name: str) -> str:
    """A name of an algorithm, to which the instance's tag is added: never one of the headers."""
    return f"{name}_" if name in _library() else c_name(name)


@cache
def _library() -> frozenset[str]:
    """Functions of the headers, without their tags."""
    return frozenset(name for header in _HEADERS for name in re.findall(r"FN\((\w+)\)", template_text(header)))


class CLoopPrinter(LoopPrinter):
    """One function."""

    logical = {"and": "&&", "or": "||", "not": "!"}
    functions = frozenset(("//", "%"))

    def __init__(self, function: Function) -> None:
        self.function = function
        self.outs = {p.name for p in function.parameters if p.access != "in"}
        self.arrays = {p.name for p in function.parameters if isinstance(p.type, ArrayType)}

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
        return f"{c_name(array.name)}_count_"

    def load(self, array: Array, index: Expression) -> str:
        return f"{c_name(array.name)}[{self.text(index)}]"

    def select(self, condition: str, yes: str, no: str) -> str:
        return f"{condition} ? {yes} : {no}"

    def call(self, name: str, arguments: Sequence[str]) -> str:
        if name == "epsilon":
            return "K(BS_EPSILON)"
        function = _FUNCTIONS[name]
        joined = ", ".join(arguments)
        return f"{function}({joined})"

    def view(self, view: View) -> str:
        offset = self.text(view.offset)
        name = c_name(view.array.name)
        return name if offset == "0" else f"{name} + {self.inside(view.offset, 6)}"

    # -- what differs where several items are computed at once (see lanes.py) ------------------------------------------

    def type_of(self, name: str, scalar: Scalar) -> str:
        """C type of a number, or of those of an array."""
        return _TYPES[scalar]

    def result_type(self, k: int) -> str:
        """C type of a number that the function returns."""
        return _TYPES[self.function.results[k]]

    def value_for(self, name: str, value: Expression) -> str:
        """What is assigned to a number or an element."""
        return self.text(value)

    def returned(self, k: int, value: Expression) -> str:
        """What is returned."""
        return self.text(value)

    def argument(self, call: Call, k: int, before: list[str]) -> str:
        """An argument of a call; lines that come before it are added."""
        each = call.arguments[k]
        return self.view(each) if isinstance(each, View) else self.text(each)

    # -- functions ---------------------------------------------------------------------------------------------------

    def lines(self) -> list[str]:
        """The function, with its comment."""
        function = self.function
        note = comment_text(function.note)
        result = self.result_type(0) if len(function.results) == 1 else "void"
        parameters = [text for p in function.parameters for text in self._parameter(p)]
        if len(function.results) > 1:
            parameters += [f"{self.result_type(k)} *result{k}_" for k in range(len(function.results))]
        storage = "BS_INLINE" if function.is_inline else "BS_OUTLINED"
        name = c_function_name(function.name)
        head = _wrapped(f"{storage} {result} FN({name})(", parameters or ["void"], ")")
        unused = [f"(void){c_name(p.name)};" for p in function.parameters if not self._is_used(p)]
        return [f"/* {note} */", *head, "{", *_indent([*unused, *self._body()]), "}"]

    def _parameter(self, parameter: Parameter) -> list[str]:
        name = c_name(parameter.name)
        if not isinstance(parameter.type, ArrayType):
            assert isinstance(parameter.type, Scalar)
            return [f"{self.type_of(parameter.name, parameter.type)} {name}"]
        const = "const " if parameter.access == "in" else ""
        type = self.type_of(parameter.name, parameter.type.scalar)
        if parameter.type.is_open:
            count = [f"ptrdiff_t {name}_count_"] if parameter.name in counted(self.function) else []
            return [f"{const}{type} *{name}", *count]
        return [f"{const}{type} {name}[BS_LENGTH({parameter.type.size})]"]

    def _is_used(self, parameter: Parameter) -> bool:
        for statement in self.function.walk():
            if isinstance(statement, Store) and statement.array.name == parameter.name:
                return True
            if isinstance(statement, Assign) and statement.target.name == parameter.name:
                return True
            if isinstance(statement, Call):
                if any(isinstance(a, View) and a.array.name == parameter.name for a in statement.arguments):
                    return True
                if any(r.name == parameter.name for r in statement.results):
                    return True
            for expression in expressions(statement):
                if parameter.name in _names(expression):
                    return True
        return False

    def _body(self) -> list[str]:
        names = {p.name for p in self.function.parameters}
        return self._block(self.function.body, names)

    def _block(self, body: Sequence[Statement], declared: set[str]) -> list[str]:
        """A block: numbers that nothing outside of it needs are declared in it."""
        declared, lines = set(declared), []
        for k, statement in enumerate(body):
            here = [v for v in _assigned((statement,)) if v.name not in declared]
            for variable in here:
                rest = body[k + 1 :]
                direct = isinstance(statement, Assign) and statement.target == variable
                results = isinstance(statement, Call) and variable in statement.results
                if direct or results:
                    continue  # the statement does
                if _uses(rest, variable.name) or not _is_inside_one_block(statement, variable.name):
                    lines.append(f"{self.type_of(variable.name, variable.type)} {c_name(variable.name)};")
                    declared.add(variable.name)
            lines += self._statement(statement, declared, body)
            if isinstance(statement, Assign):
                declared.add(statement.target.name)
            if isinstance(statement, Call):
                declared.update(r.name for r in statement.results)
        return lines

    def _statement(self, statement: Statement, declared: set[str], body: Sequence[Statement]) -> list[str]:
        match statement:
            case Assign(target, value):
                type = self.type_of(target.name, target.type)
                prefix = "" if target.name in declared else f"{self._const(target, body)}{type} "
                return [f"{prefix}{c_name(target.name)} = {self.value_for(target.name, value)};"]
            case Allocate(array, is_zero):
                zero = " = {0}" if is_zero else ""
                type = self.type_of(array.name, array.type.scalar)
                return [f"{type} {c_name(array.name)}[{array.type.size}]{zero};"]
            case Store(array, index, value):
                return [f"{c_name(array.name)}[{self.text(index)}] = {self.value_for(array.name, value)};"]
            case Call():
                return self._call_lines(statement, declared)
            case For(variable, start, stop, step, inner):
                name = c_name(variable.name)
                compare = "<" if step > 0 else ">"
                change = {1: f"{name}++", -1: f"{name}--"}.get(step, f"{name} += {step}")
                bounds = f"{name} = {self.text(start)}; {name} {compare} {self.inside(stop, 6)}"
                body_lines = self._block(inner, {*declared, variable.name})
                return [f"for (ptrdiff_t {bounds}; {change}) {{", *_indent(body_lines), "}"]
            case While(condition, inner):
                return [f"while ({self.text(condition)}) {{", *_indent(self._block(inner, declared)), "}"]
            case If(condition, yes, no):
                lines = [f"if ({self.text(condition)}) {{", *_indent(self._block(yes, declared))]
                if no:
                    lines += ["} else {", *_indent(self._block(no, declared))]
                return [*lines, "}"]
            case Break():
                return ["break;"]
            case Continue():
                return ["continue;"]
            case Return(values):
                if len(values) == 1:
                    return [f"return {self.returned(0, values[0])};"]
                return [*(f"*result{k}_ = {self.returned(k, v)};" for k, v in enumerate(values)), "return;"]
        raise TypeError(statement)

    def _const(self, variable: Variable, body: Sequence[Statement]) -> str:
        assigned = [s for s in walk(tuple(body)) if variable in _assigned((s,), deep=False)]
        return "const " if len(assigned) == 1 else ""

    def _call_lines(self, call: Call, declared: set[str]) -> list[str]:
        arguments: list[str] = []
        before: list[str] = []
        for k, each in enumerate(call.arguments):
            arguments.append(self.argument(call, k, before))
            if isinstance(each, View) and each.rows is not None and takes_count(call.callee, k):
                arguments.append(self.text(each.rows))
        if isinstance(call.callee, KernelSignature):
            return [*before, *_wrapped(f"FN({call.callee.symbol})(", arguments, ");")]
        lines = [
            f"{self.type_of(r.name, r.type)} {c_name(r.name)};"
            for r in call.results
            if r.name not in declared and len(call.results) > 1
        ]
        name = f"FN({c_function_name(call.callee.name)})("
        if len(call.results) == 1 and len(call.callee.results) == 1:
            result = call.results[0]
            prefix = "" if result.name in declared else f"const {self.type_of(result.name, result.type)} "
            return [*before, *_wrapped(f"{prefix}{c_name(result.name)} = {name}", arguments, ");")]
        arguments += [f"&{c_name(r.name)}" for r in call.results]
        return [*before, *lines, *_wrapped(name, arguments, ");")]


def c_functions(roots: Iterable[Function], printer: Callable[[Function], CLoopPrinter] = CLoopPrinter) -> str:
    """C text of some algorithms and of those that they call, callees first."""
    functions, _ = in_calling_order(roots)
    return "\n".join("\n".join([*printer(f).lines(), ""]) for f in functions)


def needs_elementary(roots: Iterable[Function]) -> bool:
    """Whether elementary.h is to be included."""
    functions, _ = in_calling_order(roots)
    found = (p for f in functions for s in f.walk() for e in expressions(s) for p in parts(e))
    return any(isinstance(p, Intrinsic) and p.name in ELEMENTARY for p in found)


def _indent(lines: Iterable[str]) -> list[str]:
    return [_INDENT + line for line in lines]


def _wrapped(head: str, items: Sequence[str], tail: str) -> list[str]:
    """A list of arguments, on several lines where it is long."""
    lines, line = [], head
    for k, item in enumerate(items):
        text = item + (", " if k + 1 < len(items) else tail)
        if len(line) + len(text) > _LINE and line.strip():
            lines.append(line.rstrip())
            line = _INDENT * 2
        line += text
    return [*lines, line]


def _assigned(body: Sequence[Statement], deep: bool = True) -> list[Variable]:
    """Numbers that some statements assign to, each once; what counts a loop belongs to the loop."""
    found: dict[Variable, None] = {}
    for statement in walk(tuple(body)) if deep else body:
        if isinstance(statement, Assign):
            found[statement.target] = None
        elif isinstance(statement, Call):
            found.update(dict.fromkeys(statement.results))
    return list(found)


def _names(expression: Expression) -> set[str]:
    found = set()
    for part in parts(expression):
        if isinstance(part, Variable):
            found.add(part.name)
        if hasattr(part, "array"):
            found.add(part.array.name)
    return found


def _uses(body: Sequence[Statement], name: str) -> bool:
    """Whether some statements read or assign to a number."""
    for statement in walk(tuple(body)):
        if any(v.name == name for v in _assigned((statement,), deep=False)):
            return True
        if any(name in _names(e) for e in expressions(statement)):
            return True
    return False


def _is_inside_one_block(statement: Statement, name: str) -> bool:
    """Whether one block of a statement has all that is about a number."""
    if any(name in _names(e) for e in expressions(statement)):
        return False
    return sum(_uses(block, name) for block in blocks(statement)) == 1
