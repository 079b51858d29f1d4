"""Algorithms for numba, on float64: an array is a flat array and where in it to begin.

Local arrays are in work arrays that the caller of the outermost function makes: numba allocates on the heap.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

from ...ir.loops.algorithm import refusal_of_library
from ...ir.loops.nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
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
    View,
    While,
    expressions,
    integer,
    parts,
    plus,
)  # fmt: skip
from ...ir.loops.types import INT, REAL, ArrayType
from ..loops import ATOM, LoopPrinter, counted, in_calling_order, takes_count
from ..printer import comment_text
from .printer import wrap

#: Functions of numbers; the elementary ones are those of the package, whose bits are those of C.
_FUNCTIONS = {
    "sqrt": "np.sqrt", "abs": "abs", "min": "min_", "max": "max_", "imin": "min_", "imax": "max_", "iabs": "abs",
    "real": "float", "int": "int", "sin": "sin", "cos": "cos", "exp": "exp", "log": "log", "atan2": "atan2",
    "//": "quotient_", "any": "",
}  # fmt: skip
_ELEMENTARY = frozenset(("sin", "cos", "exp", "log", "atan2"))
_INDENT = "    "
#: Work arrays: of numbers, and of integers.
_WORK = {REAL: "work_", INT: "integers_"}


def numba_name(name: str) -> str:
    """A name of the text: those of this printer end with an underscore."""
    return f"{name}_" if name.endswith("_") or name in _TAKEN else name


#: Names that the text of the module has by itself.
_WORDS = "U I np float int bool abs range len select sqrt sin cos exp log atan2 NAN EPSILON LARGEST print object type"
_TAKEN = frozenset(_WORDS.split())


def frame(function: Function) -> dict[str, int]:
    """Numbers that a function and those that it calls need in work arrays, by the array's name."""
    own = _own_frame(function)
    deepest = {name: 0 for name in own}
    for callee in function.callees():
        if isinstance(callee, Function):
            for name, size in frame(callee).items():
                deepest[name] = max(deepest[name], size)
    return {name: own[name] + deepest[name] for name in own}


def _own_frame(function: Function) -> dict[str, int]:
    sizes = dict.fromkeys(_WORK.values(), 0)
    for statement in function.walk():
        if isinstance(statement, Allocate):
            sizes[_WORK[statement.array.type.scalar]] += statement.array.type.size
    return sizes


class NumbaLoopPrinter(LoopPrinter):
    """One function."""

    logical = {"and": "and", "or": "or", "not": "not "}

    def __init__(self, function: Function) -> None:
        self.function = function
        self.offsets: dict[str, int] = {}
        used = dict.fromkeys(_WORK.values(), 0)
        for statement in function.walk():
            if isinstance(statement, Allocate):
                work = _WORK[statement.array.type.scalar]
                self.offsets[statement.array.name] = used[work]
                used[work] += statement.array.type.size
        self.own = used
        self.callees = {c.name if isinstance(c, Function) else c.symbol for c in function.callees()}

    # -- expressions -------------------------------------------------------------------------------------------------

    def constant(self, value: Constant) -> str:
        if value.type == REAL:
            number = float(value.value)
            if math.isnan(number):
                return "np.nan"
            return repr(number) if not math.isinf(number) else ("np.inf" if number > 0 else "-np.inf")
        return repr(value.value)

    def variable(self, name: str) -> str:
        return f"{name}_" if name in self.callees else numba_name(name)

    def count(self, array: Array) -> str:
        return f"{self.variable(array.name)}_count_"

    def load(self, array: Array, index: Expression) -> str:
        name, place = self._place(array, index)
        return f"{name}[U({place})]"

    def _place(self, array: Array, index: Expression) -> list[str]:
        """The flat array, and where in it an element is."""
        name, base = self._base(array)
        if isinstance(base, int):
            return [name, _sum(f"at_{_WORK[array.type.scalar]}", self.text(plus(integer(base), index)))]
        return [name, _sum(base, self.text(index))]

    def _base(self, array: Array) -> tuple[str, str | int]:
        """The flat array, and where this one begins in it: an offset in the frame, or a parameter."""
        if array.is_local:
            return _WORK[array.type.scalar], self.offsets[array.name]
        return self.variable(array.name), f"{self.variable(array.name)}_at_"

    def _binary(self, expression: Binary) -> tuple[str, int]:
        operator, left, right = expression.operator, expression.left, expression.right
        if operator == "//" and expression.type == INT and not (isinstance(right, Constant) and right.value != -1):
            return self.call(operator, [self.text(left), self.text(right)]), ATOM
        return super()._binary(expression)

    def select(self, condition: str, yes: str, no: str) -> str:
        return f"{yes} if {condition} else {no}"

    def call(self, name: str, arguments: Sequence[str]) -> str:
        if name == "epsilon":
            return "EPSILON"
        if name == "largest":
            return "LARGEST"
        joined = ", ".join(arguments)
        return f"{_FUNCTIONS[name]}({joined})"

    def view(self, view: View) -> list[str]:
        """The flat array and an offset."""
        return self._place(view.array, view.offset)

    # -- functions ---------------------------------------------------------------------------------------------------

    def lines(self) -> list[str]:
        if self.function.is_library and not self.function.body:
            raise refusal_of_library(self.function.name)
        names: list[str] = []
        for p in self.function.parameters:
            name = self.variable(p.name)
            names.append(name)
            if isinstance(p.type, ArrayType):
                names += [f"{name}_at_", *([f"{name}_count_"] if p.name in counted(self.function) else [])]
        for work, size in frame(self.function).items():
            if size:
                names += [work, f"at_{work}"]
        head = f"def {numba_name(self.function.name)}({wrap(names, 1)}):"
        return [*head.splitlines(), f'{_INDENT}"""{_doc_text(self.function.note)}"""', *self._block(self.function.body)]

    def _block(self, body: Sequence[Statement]) -> list[str]:
        lines = [line for statement in body for line in self._statement(statement)]
        return [_INDENT + line for line in lines or ["pass"]]

    def _statement(self, statement: Statement) -> list[str]:
        match statement:
            case Assign(target, value):
                return [f"{self.variable(target.name)} = {self.text(value)}"]
            case Allocate(array, is_zero):
                return self._zero(array) if is_zero else []
            case Store(array, index, value):
                return [f"{self.load(array, index)} = {self.text(value)}"]
            case Call():
                return self._call(statement)
            case For(variable, start, stop, step, inner):
                bounds = [self.text(e) for e in (start, stop)]
                if step != 1:
                    bounds.append(str(step))
                elif bounds[0] == "0":
                    bounds = bounds[1:]
                return [f"for {self.variable(variable.name)} in range({', '.join(bounds)}):", *self._block(inner)]
            case While(condition, inner):
                return [f"while {self.text(condition)}:", *self._block(inner)]
            case If(condition, yes, no):
                lines = [f"if {self.text(condition)}:", *self._block(yes)]
                return [*lines, "else:", *self._block(no)] if no else lines
            case Break():
                return ["break"]
            case Continue():
                return ["continue"]
            case Return(values):
                return [f"return {', '.join(self.text(v) for v in values)}".rstrip()]
        raise TypeError(statement)

    def _zero(self, array: Array) -> list[str]:
        zero = "0" if array.type.scalar == INT else "0.0"
        work = _WORK[array.type.scalar]
        first = self.offsets[array.name]
        at = _sum(f"at_{work}", str(first))
        return [f"{work}[{at}:{_sum(f'at_{work}', str(first + array.type.size))}] = {zero}"]

    def _call(self, call: Call) -> list[str]:
        arguments: list[str] = []
        for k, each in enumerate(call.arguments):
            given = self.view(each) if isinstance(each, View) else [self.text(each)]
            arguments += [_argument(text) for text in given]
            if isinstance(each, View) and each.rows is not None and takes_count(call.callee, k):
                arguments.append(self.text(each.rows))
        if isinstance(call.callee, KernelSignature):
            return f"{call.callee.symbol}({wrap(arguments, 1)})".splitlines()
        for work, size in frame(call.callee).items():
            if size:
                arguments += [work, _sum(f"at_{work}", str(self.own[work]))]
        results = ", ".join(self.variable(r.name) for r in call.results)
        prefix = f"{results} = " if results else ""
        return f"{prefix}{numba_name(call.callee.name)}({wrap(arguments, 1)})".splitlines()


def numba_functions(roots: Iterable[Function]) -> str:
    """Python text of some algorithms and of those that they call, callees first."""
    functions, _ = in_calling_order(roots)
    return "\n\n\n".join("\n".join(NumbaLoopPrinter(f).lines()) for f in functions if not f.home)


def imported_functions(roots: Iterable[Function]) -> list[tuple[str, str]]:
    """Module and name of what some algorithms call that has no text."""
    functions, _ = in_calling_order(roots)
    return sorted((f.home, f.name) for f in functions if f.home)


def elementary_functions(roots: Iterable[Function]) -> list[str]:
    """Names of the elementary functions that some algorithms call."""
    functions, _ = in_calling_order(roots)
    found = (p for f in functions for s in f.walk() for e in expressions(s) for p in parts(e))
    return sorted({p.name for p in found if isinstance(p, Intrinsic) and p.name in _ELEMENTARY})


def _sum(a: str, b: str) -> str:
    if b == "0":
        return a
    return f"{a} + {b}" if not b.startswith("-") else f"{a} + ({b})"


def _argument(text: str) -> str:
    """An argument of a call: integers and truth values as such would be types, each of which numba compiles anew."""
    if re.fullmatch("-?[0-9]+", text):
        return f"I({text})"
    return f"bool({text})" if text in ("True", "False") else text


def _doc_text(note: str) -> str:
    return comment_text(note).replace("\\", "\\\\").replace('"""', "'''")
