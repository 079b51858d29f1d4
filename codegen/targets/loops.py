"""Printing of the loop IR: expressions and the order of functions, which all targets share.

Brackets keep the order of operations that Python has, and so every target computes the same bits.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from functools import cache

from ..errors import AlgorithmError
from ..ir.loops.nodes import (
    Array,
    Binary,
    Call,
    Constant,
    Count,
    Expression,
    Function,
    Intrinsic,
    KernelSignature,
    Load,
    Select,
    Unary,
    Variable,
    View,
    expressions,
    parts,
)  # fmt: skip
from ..ir.loops.types import INT

#: Operators by how tightly they bind, in Python and in C alike; a select binds least.
_TIGHTNESS = {
    "or": 1, "and": 2, "==": 4, "!=": 4, "<": 5, "<=": 5, ">": 5, ">=": 5,
    "+": 6, "-": 6, "*": 7, "/": 7, "//": 7, "%": 7,
}  # fmt: skip
_BITWISE = frozenset(("&", "|", "^", "<<", ">>"))
_COMPARISONS = frozenset(("==", "!=", "<", "<=", ">", ">="))
_SUM, _UNARY, ATOM = 6, 8, 9


def in_calling_order(roots: Iterable[Function], *, is_c: bool = False) -> tuple[list[Function], list[KernelSignature]]:
    """All functions that some need, callees first, and the kernels that these call; in C without those of its own."""
    functions: dict[Function, None] = {}
    kernels: dict[KernelSignature, None] = {}

    def visit(function: Function) -> None:
        if function in functions or (is_c and function.is_library):
            return
        for callee in function.callees():
            if isinstance(callee, Function):
                visit(callee)
            else:
                kernels[callee] = None
        functions[function] = None

    for root in roots:
        visit(root)
    named: dict[str, Function] = {}
    for function in functions:
        if named.setdefault(function.name, function) is not function:
            raise AlgorithmError(
                f"two algorithms of one program have the name {function.name}", remedy="Rename one of them."
            )
    return list(functions), list(kernels)


@cache
def counted(function: Function) -> frozenset[str]:
    """Open arrays whose number of rows a function asks for, or one that it calls with them: others pass none."""
    found: set[str] = set()
    for statement in function.walk():
        asked = expressions(statement)
        if isinstance(statement, Call) and isinstance(statement.callee, Function):
            pairs = zip(statement.arguments, statement.callee.parameters, strict=True)
            asked = tuple(e for each, p in pairs for e in _expressions(each, p.name in counted(statement.callee)))
        found |= {part.array.name for e in asked for part in parts(e) if isinstance(part, Count)}
    return frozenset(found)


def takes_count(callee: Function | KernelSignature, k: int) -> bool:
    """Whether a number of rows follows an argument."""
    return isinstance(callee, Function) and callee.parameters[k].name in counted(callee)


def _expressions(argument: Expression | View, is_counted: bool) -> tuple[Expression, ...]:
    if not isinstance(argument, View):
        return (argument,)
    return (argument.offset, argument.rows) if is_counted and argument.rows is not None else (argument.offset,)


class LoopPrinter(ABC):
    """Expressions of one target."""

    # -- the part of a target ----------------------------------------------------------------------------------------

    @abstractmethod
    def constant(self, value: Constant) -> str:
        """A number."""

    @abstractmethod
    def variable(self, name: str) -> str:
        """A name of the text as the target can have it."""

    @abstractmethod
    def count(self, array: Array) -> str:
        """The rows of an open array."""

    @abstractmethod
    def load(self, array: Array, index: Expression) -> str:
        """An element."""

    @abstractmethod
    def select(self, condition: str, yes: str, no: str) -> str:
        """One of two."""

    @abstractmethod
    def call(self, name: str, arguments: Sequence[str]) -> str:
        """A function of numbers."""

    #: How ``and``, ``or``, ``not`` and comparisons are written.
    logical: dict[str, str]
    #: Integer operators that are functions.
    functions: frozenset[str] = frozenset()

    # -- expressions ---------------------------------------------------------------------------------------------------

    def text(self, expression: Expression) -> str:
        return self._print(expression)[0]

    def _print(self, expression: Expression) -> tuple[str, int]:
        """Text, and how tightly it binds."""
        match expression:
            case Constant():
                text = self.constant(expression)
                return text, _UNARY if text.startswith("-") else ATOM
            case Variable(name, _):
                return self.variable(name), ATOM
            case Count(array, _):
                return self.count(array), ATOM
            case Load(array, index):
                return self.load(array, index), ATOM
            case Unary(operator, operand, _):
                sign = self.logical["not"] if operator == "not" else "-"
                inner, tightness = self._print(operand)
                bare = tightness == ATOM or (tightness > _UNARY and operator == "not")
                return sign + (inner if bare else f"({inner})"), 3 if sign == "not " else _UNARY
            case Binary():
                return self._binary(expression)
            case Select(condition, yes, no, _):
                return self.select(self.inside(condition, 1), self.inside(yes, 1), self.inside(no, 1)), 0
            case Intrinsic(name, arguments, _):
                return self.call(name, [self.text(a) for a in arguments]), ATOM
        raise TypeError(expression)

    def inside(self, expression: Expression, least: int) -> str:
        """An expression, in brackets where it binds less than is needed."""
        text, tightness = self._print(expression)
        return text if tightness >= least else f"({text})"

    def _binary(self, expression: Binary) -> tuple[str, int]:
        operator, left, right = expression.operator, expression.left, expression.right
        if operator in self.functions and expression.type == INT:
            return self.call(operator, [self.text(left), self.text(right)]), ATOM
        if operator in _BITWISE:
            return f"({self.inside(left, ATOM)} {operator} {self.inside(right, ATOM)})", ATOM
        tightness = _TIGHTNESS[operator]
        if operator in _COMPARISONS:  # a < b < c is not (a < b) < c in Python
            word = self.logical.get(operator, operator)
            return f"{self.inside(left, _SUM)} {word} {self.inside(right, _SUM)}", tightness
        low = ATOM if operator in ("and", "or") and self._mixes(operator, left, right) else tightness
        first = self.inside(left, low)
        second = self.inside(right, low + 1 if low == tightness else low)
        return f"{first} {self.logical.get(operator, operator)} {second}", tightness

    @staticmethod
    def _mixes(operator: str, left: Expression, right: Expression) -> bool:
        """``a and b or c``: compilers warn, and readers stumble."""
        other = {"and": "or", "or": "and"}[operator]
        return any(isinstance(e, Binary) and e.operator == other for e in (left, right))
