"""Printing of the loop IR in languages whose blocks stand in braces: C and its relatives, Rust, JavaScript.

A number is declared where it is first assigned, as far inside the blocks as its uses allow.
"""

from __future__ import annotations

from abc import abstractmethod
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cached_property

from ..ir.loops.nodes import (
    Allocate,
    Array,
    Assign,
    Break,
    Call,
    Continue,
    Expression,
    For,
    Function,
    If,
    Return,
    Statement,
    Store,
    Variable,
    View,
    While,
    assigned_variables,
    expressions,
    names_in,
    walk,
)  # fmt: skip
from .loops import LoopPrinter
from .uses import is_inside_one_block, uses

_LINE = 118


class BlockPrinter(LoopPrinter):
    """Statements of one function."""

    #: Before the lines of a block.
    indent = "  "

    def __init__(self, function: Function) -> None:
        self.function = function
        self._assignments: dict[int, Counter[Variable]] = {}  # in each block and those inside it, to each number

    # -- the part of a language ----------------------------------------------------------------------------------------

    @abstractmethod
    def declaration(self, variable: Variable) -> str:
        """What declares a number that is assigned later."""

    @abstractmethod
    def definition(self, variable: Variable, value: str, is_constant: bool) -> str:
        """What declares a number with its value."""

    @abstractmethod
    def allocation(self, array: Array, is_zero: bool) -> list[str]:
        """What makes a local array."""

    @abstractmethod
    def element(self, array: Array, index: Expression) -> str:
        """An element, to be read or stored."""

    @abstractmethod
    def stored_value(self, array: Array, value: Expression) -> str:
        """What is stored in an element."""

    @abstractmethod
    def for_head(self, loop: For) -> str:
        """What stands before the block of a loop that counts."""

    @abstractmethod
    def return_lines(self, values: Sequence[Expression]) -> list[str]:
        """What leaves the function."""

    @abstractmethod
    def _call_lines(self, call: Call, declared: set[str]) -> list[str]:
        """A call, which declares those of its results that are new."""

    def condition(self, condition: Expression) -> str:
        """What stands behind ``if``."""
        return f"({self.text(condition)})"

    def while_head(self, condition: Expression) -> str:
        """What stands before the block of a loop on a condition."""
        return f"while {self.condition(condition)}"

    def value_for(self, name: str, value: Expression) -> str:
        """What is assigned to a number or an element."""
        return self.text(value)

    # -- statements ----------------------------------------------------------------------------------------------------

    @cached_property
    def _read(self) -> set[str]:
        """Names that expressions read."""
        asked = [e for s in self.function.walk() for e in expressions(s)]
        return {name for e in asked for name in names_in(e)}

    @cached_property
    def _used(self) -> set[str]:
        """Names that the function reads, or writes to."""
        found = set(self._read)
        for statement in self.function.walk():
            if isinstance(statement, Store):
                found.add(statement.array.name)
            elif isinstance(statement, Assign):
                found.add(statement.target.name)
            elif isinstance(statement, Call):
                found |= {a.array.name for a in statement.arguments if isinstance(a, View)}
                found |= {r.name for r in statement.results}
        return found

    def _body(self) -> list[str]:
        return self._block(self.function.body, {p.name for p in self.function.parameters})

    def _block(self, body: Sequence[Statement], declared: set[str]) -> list[str]:
        """A block: numbers that nothing outside of it needs are declared in it."""
        declared, lines = set(declared), []
        for k, statement in enumerate(body):
            here = [v for v in assigned_variables((statement,)) if v.name not in declared]
            for variable in here:
                rest = body[k + 1 :]
                direct = isinstance(statement, Assign) and statement.target == variable
                results = isinstance(statement, Call) and variable in statement.results
                if direct or results:
                    continue  # the statement does
                if uses(rest, variable.name) or not is_inside_one_block(statement, variable.name):
                    lines.append(self.declaration(variable))
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
                text = self.value_for(target.name, value)
                if target.name in declared:
                    return [f"{self.variable(target.name)} = {text};"]
                return [self.definition(target, text, self._is_constant(target, body))]
            case Allocate(array, is_zero):
                return self.allocation(array, is_zero)
            case Store(array, index, value):
                return [f"{self.element(array, index)} = {self.stored_value(array, value)};"]
            case Call():
                return self._call_lines(statement, declared)
            case For(variable, _, _, _, inner):
                block = self._block(inner, {*declared, variable.name})
                return [f"{self.for_head(statement)} {{", *self.indented(block), "}"]
            case While(condition, inner):
                return [f"{self.while_head(condition)} {{", *self.indented(self._block(inner, declared)), "}"]
            case If(condition, yes, no):
                lines = [f"if {self.condition(condition)} {{", *self.indented(self._block(yes, declared))]
                if no:
                    lines += ["} else {", *self.indented(self._block(no, declared))]
                return [*lines, "}"]
            case Break():
                return ["break;"]
            case Continue():
                return ["continue;"]
            case Return(values):
                return self.return_lines(values)
        raise TypeError(statement)

    def _is_constant(self, variable: Variable, body: Sequence[Statement]) -> bool:
        if id(body) not in self._assignments:
            found = Counter(v for s in walk(tuple(body)) for v in assigned_variables((s,), deep=False))
            self._assignments[id(body)] = found
        return self._assignments[id(body)][variable] == 1

    def indented(self, lines: Iterable[str]) -> list[str]:
        return [self.indent + line for line in lines]


def wrap_arguments(head: str, items: Sequence[str], tail: str, indent: str = "    ") -> list[str]:
    """A list of arguments, on several lines where it is long."""
    lines, line = [], head
    items = items or [""]
    for k, item in enumerate(items):
        text = item + (", " if k + 1 < len(items) else tail)
        if len(line) + len(text) > _LINE and line.strip():
            lines.append(line.rstrip())
            line = indent
        line += text
    return [*lines, line]
