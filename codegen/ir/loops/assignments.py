"""Reading assignments of algorithms: numbers, parts of arrays, elements."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import Any

from .expressions import ExpressionReader
from .nodes import (
    Array,
    Assign,
    Constant,
    Expression,
    For,
    Load,
    Statement,
    Store,
    Variable,
    View,
    integer,
    plus,
    scaled,
)  # fmt: skip
from .scope import Meaning, Static, bound_names, whole
from .text import AlgorithmText
from .types import INT, REAL, ArrayType, Parameter, Scalar, StaticType


class AssignmentReader(ExpressionReader):
    """What assignments mean, and the statements that are read so far.

    Parameters
    ----------
    text : AlgorithmText
    parameters : sequence of Parameter
        With shapes; static ones left out.
    statics : mapping of str to value
        Of the static parameters.
    """

    def __init__(self, text: AlgorithmText, parameters: Sequence[Parameter], statics: dict[str, Any]) -> None:
        super().__init__(text)
        self.bound = scope_names(text)
        self.scope.reserve(self.bound)
        self.parameters = {p.name: p for p in parameters}
        self.results = text.results
        self.blocks: list[list[Statement]] = [[]]
        self.loops: list[Loop] = []
        self.is_live = True  # whether the statement that is read can be reached
        for p in parameters:
            if isinstance(p.type, ArrayType):
                self.scope.bind(p.name, whole(Array(p.name, p.type)))
            elif isinstance(p.type, Scalar):
                self.scope.bind(p.name, Variable(p.name, p.type))
        for name, value in statics.items():
            self.scope.bind(name, Static(value))

    def emit(self, statement: Statement) -> None:
        self.blocks[-1].append(statement)

    def assign_several(self, node: ast.stmt, target: ast.Tuple, value: ast.expr) -> None:
        found = self.meaning(value)
        items: tuple[Any, ...] = ()
        if isinstance(found, tuple):
            items = found
        elif isinstance(found, Static) and isinstance(found.value, tuple):
            items = tuple(Static(v) for v in found.value)
        if len(items) != len(target.elts):
            self.refuse(node, f"{len(target.elts)} names for {len(items)} values", "Give each name one value.")
        if _depends(target, value):  # all values are computed before any is assigned
            items = tuple(i if isinstance(i, (Static, View)) else self.named(self.number(node, i)) for i in items)
        for each, item in zip(target.elts, items, strict=True):
            self.assign_one(node, each, item)

    def named(self, value: Expression) -> Variable:
        variable = Variable(self.scope.fresh("value"), value.type)
        self.emit(Assign(variable, value))
        return variable

    def assign_one(self, node: ast.AST, target: ast.expr, found: Meaning) -> None:
        match target:
            case ast.Name(name):
                if isinstance(found, View):
                    self._name_view(node, name, found)
                elif isinstance(found, Static) and self._stays_static(name, found):
                    self.scope.bind(name, found)
                else:
                    self._assign_number(node, name, self.number(node, found))
            case ast.Subscript() | ast.Attribute():
                self._store(node, self.target_of(target), found)
            case _:
                self.refuse(node, f"{ast.unparse(target)} cannot be assigned to", "Assign to names and elements.")

    def _stays_static(self, name: str, found: Static) -> bool:
        """A name with one static value, bound once, is a constant of the text; numbers that change are variables."""
        before = self.scope.types.get(name)
        if isinstance(before, Variable):
            return False
        return self.bound.get(name, 0) == 1

    def _assign_number(self, node: ast.AST, name: str, value: Expression) -> None:
        before = self.scope.types.get(name)
        if isinstance(before, View) or (isinstance(before, Static) and name in self.scope.defined):
            self.refuse(node, f"{name} is an array or a static value elsewhere", "Use another name.")
        if any(loop.variable == name for loop in self.loops):
            self.refuse(node, f"{name} counts a loop and is assigned to in it", "Use another name.")
        if name in self.parameters and isinstance(self.parameters[name].type, StaticType):
            self.refuse(node, f"{name} is a static parameter", "Use another name.")
        if isinstance(before, Variable) and before.type != value.type:
            if not (before.type == REAL and value.type == INT):
                self.refuse(
                    node, f"{name} is {before.type} elsewhere and {value.type} here",
                    "Use two names, or begin with 0.0 what becomes a real number.",
                )  # fmt: skip
            value = self.converted(node, value, REAL)
        variable = Variable(name, value.type)
        self.scope.bind(name, variable)
        self.emit(Assign(variable, value))

    def _name_view(self, node: ast.AST, name: str, found: View) -> None:
        """A part of an array gets a name. Where it begins is computed once, here."""
        before = self.scope.types.get(name)
        if before is not None and not (
            isinstance(before, View) and before.array == found.array and before.type == found.type
        ):
            self.refuse(node, f"{name} is something else elsewhere", "Use another name.")
        offset, known = found.offset, before.offset if isinstance(before, View) else None
        if isinstance(known, Variable) or not isinstance(offset, Constant):
            at = known if isinstance(known, Variable) else Variable(self.scope.fresh(f"{name}_at"), INT)
            self.emit(Assign(at, offset))
            offset = at
        self.scope.bind(name, View(found.array, offset, found.type, found.rows))

    def target_of(self, target: ast.Subscript | ast.Attribute) -> Load | View:
        """What a subscript on the left names."""
        found = self.meaning(target)
        if not isinstance(found, (Load, View)):
            self.refuse(target, "an element of what is not an array", "Assign to elements of arrays.")
        self.check_written(target, found.array)
        return found

    def check_written(self, node: ast.AST, array: Array) -> None:
        parameter = self.parameters.get(array.name)
        if parameter and not array.is_local and parameter.access == "in":
            self.refuse(node, f"{array.name} is changed, but is an input", f"Annotate {array.name} with InOut or Out.")

    def _store(self, node: ast.AST, target: Load | View, found: Meaning) -> None:
        if isinstance(target, Load):
            value = self.converted(node, self.number(node, found), target.array.type.scalar)
            self.emit(Store(target.array, target.index, value))
        elif isinstance(found, View):
            self.copy(node, target, found)
        elif isinstance(found, tuple) or (isinstance(found, Static) and isinstance(found.value, tuple)):
            self.fill(node, target, found if isinstance(found, tuple) else tuple(Static(v) for v in found.value))
        else:
            value = self.converted(node, self.number(node, found), target.array.type.scalar)
            self.each(target, lambda index: Store(target.array, plus(target.offset, index), value))

    def fill(self, node: ast.AST, target: View, items: Sequence[Any]) -> None:
        """Elements one by one."""
        if target.type.is_open or target.type.size != len(items):
            self.refuse(node, f"{len(items)} values for {target.type}", "Give as many as it has elements.")
        for k, item in enumerate(items):
            value = self.converted(node, self.number(node, item), target.array.type.scalar)
            self.emit(Store(target.array, plus(target.offset, integer(k)), value))

    def copy(self, node: ast.AST, target: View, source: View) -> None:
        if target.type != source.type or target.type.is_open:
            self.refuse(node, f"{source.type} for {target.type}", "Both have one fixed shape.")
        self.each(
            target, lambda i: Store(target.array, plus(target.offset, i), Load(source.array, plus(source.offset, i)))
        )

    def each(self, view: View, statement: Any) -> None:
        """A loop over all numbers of an array."""
        index = Variable(self.scope.fresh("k"), INT)
        stop: Expression = integer(view.type.size)
        if view.type.is_open:
            assert view.rows is not None
            stop = scaled(view.rows, view.type.size)
        self.emit(For(index, integer(0), stop, 1, (statement(index),)))


class Loop:
    """A loop that is being read: what counts it, and what is defined where it is left."""

    def __init__(self, variable: str | None, is_unrolled: bool = False) -> None:
        self.variable = variable
        self.is_unrolled = is_unrolled
        self.leaves: list[dict[str, Any]] = []


def scope_names(text: AlgorithmText) -> dict[str, int]:
    """Names that the function binds, and how often."""
    counts = bound_names(text.tree)
    for parameter in text.parameters:
        counts[parameter.name] = counts.get(parameter.name, 0) + 1
    return counts


def _depends(target: ast.Tuple, value: ast.expr) -> bool:
    """Whether a later value of a tuple reads what an earlier one is assigned to."""
    if not isinstance(value, ast.Tuple):
        return False
    for k, each in enumerate(target.elts):
        base = each
        while isinstance(base, ast.Subscript):
            base = base.value
        names = {n.id for n in ast.walk(base) if isinstance(n, ast.Name)}
        for later in value.elts[k + 1 :]:
            if names & {n.id for n in ast.walk(later) if isinstance(n, ast.Name)}:
                return True
    return False
