"""Reading expressions of algorithms: types, index arithmetic, static values."""

from __future__ import annotations

import ast
import math
from dataclasses import replace
from enum import IntEnum
from typing import Any, NoReturn

from ...errors import AlgorithmError
from . import language
from .nodes import (
    Binary,
    Constant,
    Expression,
    Intrinsic,
    Load,
    Select,
    Unary,
    View,
    integer,
    plus,
    scaled,
)  # fmt: skip
from .scope import Meaning, Scope, Static
from .static import COMPARISONS, fold_binary, plain
from .text import AlgorithmText, is_static
from .types import BOOL, INT, REAL, ArrayType, Scalar

_OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%"}
_COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
_WHAT_THERE_IS = "Algorithms have numbers, arrays, arithmetic, comparisons, and/or/not, `a if c else b` and calls."


class ExpressionReader:
    """Turns expressions of the text into IR. Calls of algorithms and kernels are statements: see `StatementReader`."""

    def __init__(self, text: AlgorithmText) -> None:
        self.text = text
        self.scope = Scope()
        self.guards = 0  # of expressions that are not always computed: no statement may come before them

    def refuse(self, node: ast.AST, what: str, remedy: str) -> NoReturn:
        self.text.refuse(node, what, remedy)

    # -- meanings ------------------------------------------------------------------------------------------------

    def meaning(self, node: ast.expr) -> Meaning:
        """What an expression means: a static value, a number, or a part of an array."""
        match node:
            case ast.Constant(value) if is_static(value):
                return Static(value)
            case ast.Name(name):
                return self._name(node, name)
            case ast.Tuple(elements):
                items = tuple(self.meaning(e) for e in elements)
                values = tuple(i.value for i in items if isinstance(i, Static))
                return Static(values) if len(values) == len(items) else items
            case ast.Attribute(value, attribute):
                inner = self.meaning(value)
                if isinstance(inner, View) and inner.type.record is not None:
                    return self._field(node, inner, attribute)
                if not isinstance(inner, Static):
                    self.refuse(node, f"a number or an array has no attribute {attribute}", _WHAT_THERE_IS)
                return self._static(node, self.text.attribute(node, inner.value, attribute))
            case ast.Subscript(value, index):
                return self._subscript(node, self.meaning(value), index)
            case ast.UnaryOp():
                return self._unary(node)
            case ast.BinOp():
                return self._binary(node)
            case ast.BoolOp():
                return self._boolean(node)
            case ast.Compare():
                return self._compare(node)
            case ast.IfExp():
                return self._select(node)
            case ast.Call():
                return self._call(node)
            case _:
                return self.refuse(node, f"{ast.unparse(node)} is not in the language", _WHAT_THERE_IS)

    def static(self, node: ast.expr, what: str) -> Any:
        """The value of an expression that must be static."""
        found = self.meaning(node)
        if not isinstance(found, Static):
            self.refuse(node, f"{what} is not static", "Use constants, Static parameters and lengths of fixed arrays.")
        return found.value

    def expression(self, node: ast.expr, type: Scalar | None = None) -> Expression:
        """A number, converted to a type where that is asked for and loses nothing."""
        found = self.number(node, self.meaning(node))
        return self.converted(node, found, type) if type else found

    def number(self, node: ast.AST, found: Meaning) -> Expression:
        """A meaning as a number."""
        if isinstance(found, Static):
            value = plain(found.value)
            kinds: dict[type, Scalar] = {bool: BOOL, int: INT, float: REAL}
            if type(value) not in kinds:
                self.refuse(node, f"{value!r} is not a number", "Static strings and tuples only decide branches.")
            return Constant(value, kinds[type(value)])
        if isinstance(found, (View, tuple)):
            self.refuse(node, "an array or a tuple stands where a number should", "Take one element of it.")
        return found

    def converted(self, node: ast.AST, found: Expression, type: Scalar) -> Expression:
        if found.type == type:
            return found
        if found.type == INT and type == REAL:
            if isinstance(found, Constant):
                return Constant(float(found.value), REAL)
            return Intrinsic("real", (found,), REAL)
        return self.refuse(node, f"a value of type {found.type} stands where {type} should", "Convert it: int(x).")

    def condition(self, node: ast.expr) -> Meaning:
        """A condition: static or of type Bool."""
        found = self.meaning(node)
        if isinstance(found, Static):
            return Static(bool(found.value))
        return self.converted_condition(node, self.number(node, found))

    def converted_condition(self, node: ast.AST, found: Expression) -> Expression:
        if found.type != BOOL:
            self.refuse(node, f"a condition is of type {found.type}", "Write a comparison, such as x != 0.")
        return found

    # -- names and elements --------------------------------------------------------------------------------------

    def _name(self, node: ast.Name, name: str) -> Meaning:
        if name in self.scope.defined:
            return self.scope.defined[name]
        if name in self.bound:
            self.refuse(node, f"{name} may not be defined here", "Give it a value on every path to this line.")
        return self._static(node, self.text.outside(node, name))

    #: Names that the function binds itself.
    bound: dict[str, int]

    def _static(self, node: ast.AST, value: Any) -> Static:
        return Static(value)  # whether its type is of any use, what takes it decides

    def index_of(self, node: ast.expr, length: int | None) -> Expression:
        """One index; a static one is checked against a fixed length, and may count from the end."""
        found = self.expression(node)
        if found.type != INT:
            self.refuse(node, f"an index is of type {found.type}", "Use an integer; int(x) cuts a number off.")
        if isinstance(found, Constant):
            value = int(found.value)
            if value < 0 and length is not None:
                value += length
            if value < 0 or (length is not None and value >= length):
                given = int(found.value)
                self.refuse(node, f"the index {given} is outside of a length of {length}", "Take one inside.")
            return integer(value)
        return found

    def _subscript(self, node: ast.Subscript, base: Meaning, index: ast.expr) -> Meaning:
        if isinstance(base, Static):
            key = self.static(index, "the index of a static value")
            try:
                return Static(base.value[key])
            except (LookupError, TypeError) as error:
                self.refuse(node, f"a static value has no such element ({error})", "Look at the value.")
        if not isinstance(base, View):
            self.refuse(node, "an index of what is not an array", "Arrays are parameters, zeros(...) or empty(...).")
        indices = index.elts if isinstance(index, ast.Tuple) else [index]
        if len(indices) == 1 and isinstance(indices[0], ast.Slice):
            return self._slice(base, indices[0])
        sizes = base.type.sizes
        if len(indices) > len(sizes) or any(isinstance(i, ast.Slice) for i in indices):
            self.refuse(node, f"{len(indices)} indices for {base.type}", "Slices stand alone: a[2:4], a[i][:].")
        offset = base.offset
        for axis, each in enumerate(indices):
            offset = plus(offset, scaled(self.index_of(each, sizes[axis]), base.type.stride(axis)))
        if len(indices) == len(sizes):
            return Load(base.array, offset)
        return View(base.array, offset, base.type.row(len(indices)))

    def _field(self, node: ast.AST, base: View, name: str) -> Meaning:
        """A field of one row of a record."""
        if len(base.type.sizes) != 1:
            self.refuse(node, f"the field {name} of several rows", "Take one row first, such as x[i].")
        try:
            offset, type = base.type.record.field(name)
        except AlgorithmError as error:
            self.refuse(node, error.what, str(error.remedy))
        place = plus(base.offset, integer(offset))
        return View(base.array, place, type) if isinstance(type, ArrayType) else Load(base.array, place)

    def _slice(self, base: View, bounds: ast.Slice) -> View:
        """``a[:]``, or part of a fixed array from one static index to another."""
        if bounds.step is not None:
            self.refuse(bounds.step, "a slice with a step", "Write a loop.")
        if bounds.lower is None and bounds.upper is None:
            return base
        length = base.type.sizes[0]
        if length is None:
            self.refuse(bounds, "a slice of rows whose number is not fixed", "Write a loop over them.")
        low = self.static(bounds.lower, "the begin of a slice") if bounds.lower else 0
        high = self.static(bounds.upper, "the end of a slice") if bounds.upper else length
        if not (isinstance(low, int) and isinstance(high, int) and 0 <= low < high <= length):
            self.refuse(bounds, f"a slice from {low} to {high} of a length of {length}", "Take one inside, not empty.")
        shape = (high - low, *base.type.sizes[1:])
        offset = plus(base.offset, integer(low * base.type.stride(0)))
        return View(base.array, offset, replace(base.type, shape=shape, record=None))

    # -- operations ----------------------------------------------------------------------------------------------

    def _unary(self, node: ast.UnaryOp) -> Meaning:
        found = self.meaning(node.operand)
        if isinstance(node.op, ast.Not):
            if isinstance(found, Static):
                return Static(not found.value)
            return Unary("not", self.converted_condition(node, self.number(node.operand, found)), BOOL)
        if not isinstance(node.op, (ast.USub, ast.UAdd)):
            self.refuse(node, "an operator that algorithms have not", _WHAT_THERE_IS)
        if isinstance(found, Static):
            operand = self.number(node.operand, found)
            value = operand.value if isinstance(operand, Constant) else 0
            return Static(-value if isinstance(node.op, ast.USub) else value)
        inner = self._arithmetic(node.operand, self.number(node.operand, found))
        return Unary("-", inner, inner.type) if isinstance(node.op, ast.USub) else inner

    def _arithmetic(self, node: ast.AST, found: Expression) -> Expression:
        if found.type == BOOL:
            self.refuse(node, "arithmetic with a truth value", "Write 1 if c else 0.")
        return found

    def _binary(self, node: ast.BinOp) -> Meaning:
        left, right = self.meaning(node.left), self.meaning(node.right)
        if isinstance(left, Static) and isinstance(right, Static):
            return Static(fold_binary(self.refuse, node, left.value, right.value))
        operator = _OPERATORS.get(type(node.op))
        if operator is None:
            self.refuse(node, "an operator that algorithms have not", "There are + - * / // %; write x * x for x ** 2.")
        return self.operation(node, operator, self.number(node.left, left), self.number(node.right, right))

    def operation(self, node: ast.AST, operator: str, left: Expression, right: Expression) -> Expression:
        """Arithmetic of two numbers: of integers if both are, but for ``/``."""
        left, right = self._arithmetic(node, left), self._arithmetic(node, right)
        if left.type == right.type == INT and operator != "/":
            return plus(left, right) if operator == "+" else Binary(operator, left, right, INT)
        if operator in ("//", "%"):
            self.refuse(node, f"{operator} of real numbers", "It is there for integers alone.")
        return Binary(operator, self.converted(node, left, REAL), self.converted(node, right, REAL), REAL)

    def _boolean(self, node: ast.BoolOp) -> Meaning:
        """Static operands decide, or vanish; those behind a decision are not read."""
        operator, decisive = ("and", False) if isinstance(node.op, ast.And) else ("or", True)
        result: Expression | None = None
        for each in node.values:
            self.guards += result is not None
            found = self.condition(each)
            self.guards -= result is not None
            if isinstance(found, Static):
                if found.value == decisive and result is None:
                    return found
                if found.value == decisive:
                    return Binary(operator, result, Constant(decisive, BOOL), BOOL) if result else found
                continue
            value = self.number(each, found)
            result = value if result is None else Binary(operator, result, value, BOOL)
        return Static(not decisive) if result is None else result

    def _compare(self, node: ast.Compare) -> Meaning:
        operands = [node.left, *node.comparators]
        meanings = [self.meaning(o) for o in operands]
        if all(isinstance(m, Static) for m in meanings):
            values = [m.value for m in meanings if isinstance(m, Static)]
            try:
                return Static(
                    all(COMPARISONS[type(o)](a, b) for o, a, b in zip(node.ops, values, values[1:], strict=False))
                )
            except TypeError as error:
                self.refuse(node, f"static values do not compare ({error})", "Look at the values.")
        numbers = [self.number(o, m) for o, m in zip(operands, meanings, strict=True)]
        result: Expression | None = None
        for op, a, b in zip(node.ops, numbers, numbers[1:], strict=False):
            if type(op) not in _COMPARISONS:
                self.refuse(node, "`in` and `is` compare static values alone", "Write a loop or ==.")
            if BOOL in (a.type, b.type):
                self.refuse(node, "a comparison of truth values", "Write `a and b`, `not a`, ...")
            if a.type != b.type:
                a, b = self.converted(node, a, REAL), self.converted(node, b, REAL)
            one = Binary(_COMPARISONS[type(op)], a, b, BOOL)
            result = one if result is None else Binary("and", result, one, BOOL)
        assert result is not None
        return result

    def _select(self, node: ast.IfExp) -> Meaning:
        condition = self.condition(node.test)
        if isinstance(condition, Static):
            return self.meaning(node.body if condition.value else node.orelse)
        yes, no = (self.number(each, self.guarded(each)) for each in (node.body, node.orelse))
        if yes.type != no.type:
            yes, no = self.converted(node, yes, REAL), self.converted(node, no, REAL)
        return Select(self.number(node.test, condition), yes, no, yes.type)

    # -- functions -----------------------------------------------------------------------------------------------

    def called(self, node: ast.Call) -> Any:
        """The object that a call names, from outside the function."""
        if node.keywords:
            self.refuse(node, "arguments by name", "Give them in their order.")
        found = self.meaning(node.func)
        if not isinstance(found, Static):
            self.refuse(node, f"{ast.unparse(node.func)} is not a function", _WHAT_THERE_IS)
        return found.value

    def _call(self, node: ast.Call) -> Meaning:
        function = self.called(node)
        match function, node.args:
            case _, [argument] if function is len:
                return self._length(node, self.meaning(argument))
            case _, [argument] if function is float:
                found = self.meaning(argument)
                if isinstance(found, Static):
                    return Static(float(plain(found.value)))
                value = self.number(argument, found)
                if value.type != INT:
                    self.refuse(node, "float() of what is not an integer", "Reals need no conversion.")
                return self.converted(node, value, REAL)
            case _, [argument] if function is int:
                return self._truncated(node, argument)
            case _, [first, second] if function in (min, max):
                return self._extreme(node, "<" if function is min else ">", first, second)
            case _ if isinstance(function, type(len)) or callable(function):
                return self._function(node, function)
        return self.refuse(node, f"{ast.unparse(node.func)} is not a function of algorithms", _WHAT_THERE_IS)

    def _function(self, node: ast.Call, function: Any) -> Meaning:
        try:
            name, count = language.FUNCTIONS[function]
        except (KeyError, TypeError):
            known = "sqrt, abs, sin, cos, exp, log, atan2, min, max, int, float, len, epsilon"
            if getattr(function, "is_callable_in_algorithms", False):
                return self.call_inside(node, function)
            if any(function is each for each in language.ALLOCATORS):
                self.refuse(node, f"the call {ast.unparse(node)} inside an expression", "Give its result a name first.")
            self.refuse(
                node,
                f"{ast.unparse(node.func)} cannot be called in an algorithm",
                f"Call algorithms, kernels, or one of {known} (of bladesmith.codegen.algorithms).",
            )
        if len(node.args) != count:
            self.refuse(node, f"{name} takes {count} numbers", "Give it as many.")
        arguments = [self.expression(a) for a in node.args]
        if name == "abs" and arguments[0].type == INT:
            return Intrinsic("iabs", tuple(arguments), INT)
        reals = tuple(self.converted(n, a, REAL) for n, a in zip(node.args, arguments, strict=True))
        if name == "abs" and isinstance(reals[0], Constant):
            return Static(math.fabs(reals[0].value))
        return Intrinsic(name, reals, REAL)

    def call_inside(self, node: ast.Call, callee: Any) -> Expression:
        """The number that a call of an algorithm returns, in the middle of an expression."""
        raise NotImplementedError

    def guarded(self, node: ast.expr) -> Meaning:
        """The meaning of an expression that is not always computed."""
        self.guards += 1
        try:
            return self.meaning(node)
        finally:
            self.guards -= 1

    def _length(self, node: ast.Call, found: Meaning) -> Meaning:
        if isinstance(found, Static):
            return Static(len(found.value))
        if not isinstance(found, View):
            self.refuse(node, "the length of what is not an array", "Take len() of an array.")
        length = found.type.sizes[0]
        if length is not None:
            return Static(length)
        assert found.rows is not None
        return found.rows

    def _truncated(self, node: ast.Call, argument: ast.expr) -> Meaning:
        found = self.meaning(argument)
        if isinstance(found, Static) and isinstance(found.value, (int, float, IntEnum)):
            return Static(int(found.value))
        value = self.number(argument, found)
        if value.type == INT:
            return value
        return Intrinsic("int", (self.converted(node, value, REAL),), INT)

    def _extreme(self, node: ast.Call, operator: str, first: ast.expr, second: ast.expr) -> Meaning:
        """As in Python: the first, unless the second is less or greater."""
        meanings = self.meaning(first), self.meaning(second)
        if all(isinstance(m, Static) for m in meanings):
            values = [plain(m.value) for m in meanings if isinstance(m, Static)]
            return Static(min(values) if operator == "<" else max(values))
        a, b = self.number(first, meanings[0]), self.number(second, meanings[1])
        if a.type != b.type:
            a, b = self.converted(node, a, REAL), self.converted(node, b, REAL)
        if BOOL in (a.type, b.type):
            self.refuse(node, "the extreme of truth values", "Use and, or.")
        prefix = "i" if a.type == INT else ""
        return Intrinsic(prefix + ("min" if operator == "<" else "max"), (a, b), a.type)
