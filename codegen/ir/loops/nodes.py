"""The loop IR: what an algorithm is after its text was read, its types checked and its static values put in.

Arrays have one index: the reader turns ``a[i, j]`` into an offset. A part of an array is a `View`: the array and an
offset into it. Expressions have no side effects; calls are statements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from .types import BOOL, INT, REAL, ArrayType, Parameter, Scalar

Value = float | int | bool


@dataclass(frozen=True)
class Constant:
    value: Value
    type: Scalar


@dataclass(frozen=True)
class Variable:
    """A number by name."""

    name: str
    type: Scalar


@dataclass(frozen=True)
class Array:
    """An array by name. ``is_local``: made by the algorithm itself, of fixed size."""

    name: str
    type: ArrayType
    is_local: bool = False


@dataclass(frozen=True)
class Count:
    """The rows of an open array."""

    array: Array
    type: Scalar = INT


@dataclass(frozen=True)
class Load:
    array: Array
    index: Expression

    @property
    def type(self) -> Scalar:
        return self.array.type.scalar


@dataclass(frozen=True)
class Unary:
    """``-`` or ``not``."""

    operator: str
    operand: Expression
    type: Scalar


@dataclass(frozen=True)
class Binary:
    """``+ - * /`` of reals; ``+ - * // % & | ^ << >>`` of integers; ``and or !=`` of booleans; comparisons."""

    operator: str
    left: Expression
    right: Expression
    type: Scalar


@dataclass(frozen=True)
class Select:
    """One of two, of which only one is computed."""

    condition: Expression
    yes: Expression
    no: Expression
    type: Scalar


@dataclass(frozen=True)
class Intrinsic:
    """``sqrt``, ``abs``, an elementary function, a conversion, or one of the functions of `elementary.machine`."""

    name: str
    arguments: tuple[Expression, ...]
    type: Scalar


Expression = Constant | Variable | Count | Load | Unary | Binary | Select | Intrinsic


@dataclass(frozen=True)
class View:
    """A part of an array, from an offset on. ``is_still``: derivatives take it for constant where a kernel reads it."""

    array: Array
    offset: Expression
    type: ArrayType
    rows: Expression | None = None  # of an open one
    is_still: bool = False


# -- statements --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Assign:
    target: Variable
    value: Expression


@dataclass(frozen=True)
class Allocate:
    """A local array, zero or not yet defined."""

    array: Array
    is_zero: bool


@dataclass(frozen=True)
class Store:
    array: Array
    index: Expression
    value: Expression


@dataclass(frozen=True)
class Call:
    """Another algorithm, or a kernel: results of arrays are views among the arguments, numbers are variables."""

    callee: Function | KernelSignature
    arguments: tuple[Expression | View, ...]
    results: tuple[Variable, ...]


@dataclass(frozen=True)
class For:
    variable: Variable
    start: Expression
    stop: Expression
    step: int
    body: tuple[Statement, ...]
    where: str = field(default="", compare=False, repr=False)  # file and line


@dataclass(frozen=True)
class While:
    condition: Expression
    body: tuple[Statement, ...]
    where: str = field(default="", compare=False, repr=False)


@dataclass(frozen=True)
class If:
    condition: Expression
    yes: tuple[Statement, ...]
    no: tuple[Statement, ...] = ()


@dataclass(frozen=True)
class Break:
    pass


@dataclass(frozen=True)
class Continue:
    pass


@dataclass(frozen=True)
class Return:
    values: tuple[Expression, ...]


Statement = Assign | Allocate | Store | Call | For | While | If | Break | Continue | Return


@dataclass(frozen=True)
class KernelSignature:
    """A traced formula as algorithms call it: sizes of its rows, results and inputs by name.

    Results come first in a `Call`, as in the printed function. ``kernel``: what a target prints it from.
    """

    symbol: str
    outputs: tuple[tuple[str, int], ...]
    inputs: tuple[tuple[str, int], ...]
    kernel: Any = field(default=None, compare=False, repr=False)

    @property
    def are_values(self) -> list[bool]:
        """For each result whether it has a derivative: a status has none."""
        if not any(name.rstrip("_") == "status" for name, _ in self.outputs):  # to ask the kernel may be to trace it
            return [True] * len(self.outputs)
        return [output.role != "status" for output in self.kernel.outputs]


@dataclass(frozen=True, eq=False)
class Function:
    """An algorithm for one choice of sizes and static values.

    Attributes
    ----------
    name : str
        In generated code.
    note : str
        First line of its docstring.
    parameters : tuple of Parameter
        Static ones left out; arrays have shapes.
    results : tuple of Scalar
        What it returns.
    body : tuple of statements
    is_inline : bool
        C puts it where it is called.
    is_library : bool
        C has a text of its own, in its library of headers.
    rule : callable, optional
        Gives the algorithm that is declared as its derivative: its parameters, then tangents ``d_x`` of some of them.
    is_still : bool
        Derivatives take what it gives for constant.
    home : str
        Of one without a text: the module that has it for numba, or empty.
    """

    name: str
    note: str
    parameters: tuple[Parameter, ...]
    results: tuple[Scalar, ...]
    body: tuple[Statement, ...] = field(repr=False)
    is_inline: bool = False
    is_library: bool = False
    rule: Callable[[], Function] | None = field(default=None, repr=False)
    is_still: bool = False
    home: str = ""
    where: str = field(default="", repr=False)

    def walk(self) -> Iterator[Statement]:
        """All statements, in the order of the text."""
        yield from walk(self.body)

    @cached_property
    def local_size(self) -> int:
        """Numbers in its local arrays and in those of what it calls, at the deepest."""
        own = sum(s.array.type.size for s in self.walk() if isinstance(s, Allocate))
        return own + max((c.local_size for c in self.callees() if isinstance(c, Function)), default=0)

    def callees(self) -> list[Function | KernelSignature]:
        """What it calls, each once."""
        return list(dict.fromkeys(s.callee for s in self.walk() if isinstance(s, Call)))


def walk(body: tuple[Statement, ...]) -> Iterator[Statement]:
    """All statements of a block and of those inside it."""
    for statement in body:
        yield statement
        for block in blocks(statement):
            yield from walk(block)


def blocks(statement: Statement) -> tuple[tuple[Statement, ...], ...]:
    """The blocks of a statement."""
    if isinstance(statement, (For, While)):
        return (statement.body,)
    return (statement.yes, statement.no) if isinstance(statement, If) else ()


def expressions(statement: Statement) -> tuple[Expression, ...]:
    """The expressions of a statement itself, offsets of views among them, without those of its blocks."""
    match statement:
        case Assign(_, value):
            return (value,)
        case Store(_, index, value):
            return (index, value)
        case Call(_, arguments, _):
            views = [(a.offset, *([a.rows] if a.rows else [])) if isinstance(a, View) else (a,) for a in arguments]
            return tuple(e for each in views for e in each)
        case For(_, start, stop, _, _):
            return (start, stop)
        case While(condition, _) | If(condition, _, _):
            return (condition,)
        case Return(values):
            return values
        case _:
            return ()


def parts(expression: Expression) -> Iterator[Expression]:
    """An expression and all in it."""
    yield expression
    match expression:
        case Load(_, index):
            yield from parts(index)
        case Unary(_, operand, _):
            yield from parts(operand)
        case Binary(_, left, right, _):
            yield from parts(left)
            yield from parts(right)
        case Select(condition, yes, no, _):
            for each in (condition, yes, no):
                yield from parts(each)
        case Intrinsic(_, arguments, _):
            for each in arguments:
                yield from parts(each)
        case _:
            pass


def names_in(expression: Expression) -> set[str]:
    """Numbers and arrays of an expression."""
    found = set()
    for part in parts(expression):
        if isinstance(part, Variable):
            found.add(part.name)
        if hasattr(part, "array"):
            found.add(part.array.name)
    return found


def outputs(call: Call) -> list[View]:
    """Arrays that a call writes to."""
    if isinstance(call.callee, KernelSignature):
        found = call.arguments[: len(call.callee.outputs)]
    else:
        found = tuple(a for p, a in zip(call.callee.parameters, call.arguments, strict=True) if p.access != "in")
    return [a for a in found if isinstance(a, View)]


def assigned_variables(body: Sequence[Statement], deep: bool = True) -> list[Variable]:
    """Numbers that some statements assign to, each once; what counts a loop belongs to the loop."""
    found: dict[Variable, None] = {}
    for statement in walk(tuple(body)) if deep else body:
        if isinstance(statement, Assign):
            found[statement.target] = None
        elif isinstance(statement, Call):
            found.update(dict.fromkeys(statement.results))
    return list(found)


# -- index arithmetic ----------------------------------------------------------------------------------------------


def integer(value: int) -> Constant:
    return Constant(value, INT)


def real(value: float) -> Constant:
    return Constant(value, REAL)


def boolean(value: bool) -> Constant:
    return Constant(value, BOOL)


def plus(a: Expression, b: Expression) -> Expression:
    """The sum of two integers, folded where both are known."""
    if isinstance(a, Constant) and isinstance(b, Constant):
        return integer(int(a.value) + int(b.value))
    if isinstance(a, Constant) and a.value == 0:
        return b
    if isinstance(b, Constant) and b.value == 0:
        return a
    return Binary("+", a, b, INT)


def scaled(a: Expression, factor: int) -> Expression:
    """An integer times a constant."""
    if isinstance(a, Constant):
        return integer(int(a.value) * factor)
    return a if factor == 1 else Binary("*", integer(factor), a, INT)
