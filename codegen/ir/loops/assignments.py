"""Reading assignments of algorithms: numbers, parts of arrays, elements."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from .expressions import ExpressionReader
from .nodes import (
    Allocate,
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
    parts,
    plus,
    scaled,
)  # fmt: skip
from .scope import Meaning, Static, bound_names, items_of, whole
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
        self.was_decided = False  # whether a static branch is why it cannot
        for p in parameters:
            if isinstance(p.type, ArrayType):
                self.scope.bind(p.name, whole(Array(p.name, p.type)))
            elif isinstance(p.type, Scalar):
                self.scope.bind(p.name, Variable(p.name, p.type))
        for name, value in statics.items():
            self.scope.bind(name, Static(value))

    def emit(self, statement: Statement) -> None:
        self.blocks[-1].append(statement)

    def assign_several(self, node: ast.stmt, target: ast.Tuple, found: Meaning) -> None:
        items = items_of(found) or ()
        if len(items) != len(target.elts):
            self.refuse(node, f"{len(target.elts)} names for {len(items)} values", "Give each name one value.")
        storages = [self._storage(each) for each in target.elts]
        if any(_reads(item) & set().union(*storages[:k]) for k, item in enumerate(items)):
            items = tuple(self._settle(node, item) for item in items)  # all are computed before any is assigned
        for each, item in zip(target.elts, items, strict=True):
            self.assign_one(node, each, item)

    def assign_to_each(self, node: ast.stmt, targets: Sequence[ast.expr], value: ast.expr) -> None:
        """``a = b = value``: computed once."""
        found = self.meaning(value)
        items = items_of(found)
        found = self._settle(node, found) if items is None else tuple(self._settle(node, i) for i in items)
        for target in targets:
            if isinstance(target, ast.Tuple):
                self.assign_several(node, target, found)
            else:
                self.assign_one(node, target, found)

    def _settle(self, node: ast.AST, found: Meaning) -> Meaning:
        """A meaning that no later assignment changes: numbers and offsets get names of their own."""
        if isinstance(found, View):
            is_constant = isinstance(found.offset, Constant)
            return found if is_constant else replace(found, offset=self.named(found.offset))
        return found if isinstance(found, Static) else self.named(self.number(node, found))

    def _storage(self, target: ast.expr) -> set[str]:
        """Names of what an assignment changes, as the IR has them."""
        base = target
        while isinstance(base, (ast.Subscript, ast.Attribute)):
            base = base.value
        if not isinstance(base, ast.Name):
            return set()
        known = self.scope.types.get(base.id)
        if isinstance(target, ast.Name):
            is_moved = isinstance(known, View) and isinstance(known.offset, Variable)
            return {base.id, known.offset.name} if is_moved else {base.id}  # type: ignore[union-attr]
        return {known.array.name} if isinstance(known, View) else set()

    def named(self, value: Expression) -> Variable:
        variable = Variable(self.scope.fresh("value"), value.type)
        self.emit(Assign(variable, value))
        return variable

    def assign_one(self, node: ast.AST, target: ast.expr, found: Meaning) -> None:
        match target:
            case ast.Name("_") if not isinstance(found, View) and "_" not in self.scope.types:
                pass  # not looked at
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
        elif (items := items_of(found)) is not None:
            self.fill(node, target, items)
        else:
            value = self.converted(node, self.number(node, found), target.array.type.scalar)
            self.each(target, lambda index: Store(target.array, plus(target.offset, index), value))

    def fill(self, node: ast.AST, target: View, items: Sequence[Any]) -> None:
        """Elements one by one."""
        if target.type.is_open or target.type.size != len(items):
            self.refuse(node, f"{len(items)} values for {target.type}", "Give as many as it has elements.")
        values = [self.converted(node, self.number(node, item), target.array.type.scalar) for item in items]
        if any(target.array.name in _reads(v) for v in values):
            values = [v if isinstance(v, Constant) else self.named(v) for v in values]
        for k, value in enumerate(values):
            self.emit(Store(target.array, plus(target.offset, integer(k)), value))

    def copy(self, node: ast.AST, target: View, source: View) -> None:
        if target.type != source.type or target.type.is_open:
            self.refuse(node, f"{source.type} for {target.type}", "Both have one fixed shape.")
        if source.array == target.array:  # they may overlap: as NumPy, through a copy
            copied = Array(self.scope.fresh("row"), replace(source.type, record=None), is_local=True)
            self.emit(Allocate(copied, False))
            self.copy(node, whole(copied), source)
            source = whole(copied)
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


def _reads(found: Meaning) -> set[str]:
    """Names of the numbers and arrays that a meaning is computed from."""
    if isinstance(found, (Static, tuple)):
        return set()
    return {
        part.name if isinstance(part, Variable) else part.array.name
        for part in parts(found.offset if isinstance(found, View) else found)
        if isinstance(part, (Variable, Load))
    }
