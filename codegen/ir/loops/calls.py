"""Reading calls of algorithms and kernels, and arrays that algorithms make."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from . import language
from .assignments import AssignmentReader
from .nodes import Allocate, Array, Binary, Call, Expression, Function, KernelSignature, Load, Variable, View, integer
from .records import Record
from .scope import Meaning, Static, items_of, whole
from .text import is_static
from .types import INT, REAL, ArrayType, Parameter, Scalar, StaticType


class CallReader(AssignmentReader):
    """What calls mean."""

    def is_allocation(self, value: ast.Call) -> bool:
        found = self.meaning(value.func)
        return isinstance(found, Static) and _is_in(found.value, language.ALLOCATORS)

    def allocate(self, node: ast.stmt, target: ast.expr, value: ast.Call) -> None:
        scalar, is_zero = language.ALLOCATORS[self.called(value)]
        shape = tuple(self.static(n, "the size of an array") for n in value.args)
        record = shape[-1] if shape and isinstance(shape[-1], Record) else None
        if record is not None:
            scalar, shape = record.scalar, (*shape[:-1], record.size)
        if not shape or not all(isinstance(n, int) and n > 0 for n in shape):
            self.refuse(node, f"an array of shape {shape}", "Sizes are positive integers.")
        if not isinstance(target, ast.Name):
            self.refuse(node, "an array without a name", "Assign it to a name.")
        self.new_array(node, target.id, ArrayType(scalar, shape, record=record), is_zero)

    def new_array(self, node: ast.AST, name: str, type: ArrayType, is_zero: bool = False) -> View:
        """A local array under a name of the text."""
        if name in self.scope.types:
            self.refuse(node, f"{name} is bound twice, here to an array", "Use another name: an array has one.")
        array = Array(name, type, is_local=True)
        self.emit(Allocate(array, is_zero))
        self.scope.bind(name, whole(array))
        return whole(array)

    def is_call_statement(self, value: ast.Call) -> bool:
        name = value.func.id if isinstance(value.func, ast.Name) else ""
        if name in self.bound and not isinstance(self.scope.defined.get(name), Static):
            return False
        return getattr(self.callee_of(value), "is_callable_in_algorithms", False)

    def callee_of(self, call: ast.Call) -> Any:
        found = self.meaning(call.func)
        return found.value if isinstance(found, Static) else None

    def call_statement(self, call: ast.Call, targets: Sequence[ast.expr]) -> None:
        callee = self.called(call)
        if not getattr(callee, "is_callable_in_algorithms", False):
            self.refuse(call, f"the call {ast.unparse(call)} does nothing here", "Call algorithms and kernels.")
        if signature := getattr(callee, "kernel_signature", None):
            self._call_kernel(call, signature, targets)
            return
        for target, result in zip(targets, self.call_algorithm(call, callee, len(targets)), strict=True):
            self.assign_one(call, target, result)

    def call_inside(self, node: ast.Call, callee: Any) -> Expression:
        if self.guards or hasattr(callee, "kernel_signature"):
            self.refuse(node, f"the call {ast.unparse(node)} inside an expression", "Give its result a name first.")
        if any(p.access != "in" for p in callee.text.parameters):  # in Python, at its place among the operands
            self.refuse(node, f"{callee.name} changes arrays inside an expression", "Give its result a name first.")
        results = self.call_algorithm(node, callee, None)
        if len(results) != 1:
            self.refuse(node, f"{callee.name} returns {len(results)} numbers", "Give them names first.")
        return results[0]

    def call_algorithm(self, call: ast.Call, callee: Any, wanted: int | None) -> tuple[Variable, ...]:
        """Call another algorithm; the numbers that it returns. ``wanted``: None: as many as there are."""
        declared: Sequence[Parameter] = callee.text.parameters
        if len(call.args) != len(declared):
            self.refuse(call, f"{callee.name} takes {len(declared)} arguments", "Give each of them.")
        types: list[ArrayType | Scalar | Static] = []
        arguments: list[Expression | View] = []
        for node, parameter in zip(call.args, declared, strict=True):
            found = self.meaning(node)
            if isinstance(parameter.type, StaticType):
                if not isinstance(found, Static) or not is_static(found.value):
                    self.refuse(node, f"{parameter.name} of {callee.name} is static", "Give it a static value.")
                types.append(found)
            elif isinstance(parameter.type, ArrayType):
                view = self._array_argument(node, parameter, found)
                if parameter.access != "in":
                    self.check_written(node, view.array)
                types.append(view.type)
                arguments.append(view)
            else:
                arguments.append(self.converted(node, self.number(node, found), parameter.type))
                types.append(parameter.type)
        function: Function = callee.specialised(types, (self.text, call))
        if wanted not in (None, 0, len(function.results)):
            self.refuse(call, f"{callee.name} returns {len(function.results)} numbers, not {wanted}", "Name each.")
        results = tuple(Variable(self.scope.fresh("result"), t) for t in function.results)
        self.emit(Call(function, tuple(arguments), results))
        return results if wanted != 0 else ()

    def _array_argument(self, node: ast.expr, parameter: Parameter, found: Meaning) -> View:
        declared = parameter.type
        assert isinstance(declared, ArrayType)
        items = items_of(found)
        if items is not None:
            found = self.temporary(node, items, declared.scalar)
        if not isinstance(found, View) or found.array.type.scalar != declared.scalar:
            self.refuse(node, f"{parameter.name} is {declared}, and gets something else", "Give it such an array.")
        if found.type == declared or (declared.is_generic and len(found.type.sizes) == declared.axes):
            return found
        if found.type.bits != declared.bits:
            self.refuse(
                node, f"{parameter.name} is stored as {declared.storage}, and gets {found.type.storage}",
                "Declare both alike, or copy the numbers: a[i] = b[i].",
            )  # fmt: skip
        count = found.type.sizes[0] if found.type.sizes else None
        if declared.is_open and count is not None and found.type.sizes[1:] == declared.sizes[1:]:
            return replace(found, type=declared, rows=integer(count))
        if declared.is_open and found.rows is not None and found.type.size == 1:
            rows = Binary("//", found.rows, integer(declared.size), INT)
            return replace(found, type=declared, rows=rows)
        if declared.sizes == (None,):  # all numbers of rows, or of an array
            size = integer(found.type.size)
            every = size if found.rows is None else Binary("*", found.rows, size, INT)
            return replace(found, type=declared, rows=every)
        return self.refuse(node, f"{found.type} for {parameter.name}, which is {declared}", "The shapes must be one.")

    def temporary(self, node: ast.AST, items: Sequence[Any], scalar: Scalar = REAL) -> View:
        """Numbers as an array without a name in the text."""
        array = Array(self.scope.fresh("row"), ArrayType(scalar, (len(items),)), is_local=True)
        self.emit(Allocate(array, False))
        self.fill(node, whole(array), items)
        return whole(array)

    def _call_kernel(self, call: ast.Call, signature: KernelSignature, targets: Sequence[ast.expr]) -> None:
        """Inputs are arrays of the declared sizes, tuples of as many numbers, or numbers; so are results."""
        if len(call.args) != len(signature.inputs):
            self.refuse(call, f"{signature.symbol} takes {len(signature.inputs)} arguments", "Give each of them.")
        inputs = [self._row(node, size) for node, (_, size) in zip(call.args, signature.inputs, strict=True)]
        if len(targets) not in (0, len(signature.outputs)):
            self.refuse(call, f"{signature.symbol} has {len(signature.outputs)} results", "Name each of them.")
        outputs: list[View] = []
        after: list[tuple[ast.expr, View]] = []
        for k, (_, size) in enumerate(signature.outputs):
            target = targets[k] if targets else None
            if isinstance(target, ast.Name) and size > 1 and not isinstance(self.scope.types.get(target.id), View):
                outputs.append(self.new_array(call, target.id, ArrayType(REAL, (size,))))
                continue
            if isinstance(target, (ast.Subscript, ast.Attribute)):
                place = self.target_of(target)
                is_row = isinstance(place, View) and not place.type.is_open and place.type.size == size
                if isinstance(place, View) and is_row and not any(v.array == place.array for v in (*inputs, *outputs)):
                    outputs.append(place)
                    continue
            if isinstance(target, ast.Name) and size > 1:
                self.refuse(call, f"{target.id} is bound twice, here to an array", f"Write {target.id}[:] = ...")
            temporary = Array(self.scope.fresh("row"), ArrayType(REAL, (size,)), is_local=True)
            self.emit(Allocate(temporary, False))
            outputs.append(whole(temporary))
            if target is not None:
                after.append((target, whole(temporary)))
        self.emit(Call(signature, (*outputs, *inputs), ()))
        for target, view in after:
            whole_target = self.target_of(target) if isinstance(target, (ast.Subscript, ast.Attribute)) else None
            if isinstance(whole_target, View):
                self.copy(call, whole_target, view)
            elif view.type.size == 1:
                self.assign_one(call, target, Load(view.array, view.offset))
            else:
                self.refuse(call, f"a result of {view.type.size} numbers", "Give it an array of that size.")

    def _row(self, node: ast.expr, size: int) -> View:
        found = self.meaning(node)
        if isinstance(found, View):
            if found.array.type.scalar != REAL or found.type.is_open or found.type.size != size:
                self.refuse(node, f"{found.type} where a kernel takes {size} numbers", "Give it as many.")
            return found
        items = items_of(found) or (found,)
        if len(items) != size:
            self.refuse(node, f"{len(items)} numbers where a kernel takes {size}", "Give it as many.")
        return self.temporary(node, items)


def _is_in(value: Any, table: dict[Any, Any]) -> bool:
    try:
        return value in table
    except TypeError:
        return False
