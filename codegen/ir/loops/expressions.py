"""Reading expressions of algorithms: operators, comparisons and functions of numbers."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from enum import IntEnum
from typing import Any

from ...elementary.machine import select
from . import language
from .elements import ElementReader
from .nodes import Binary, Constant, Expression, Intrinsic, Select, Unary, View, plus
from .scope import Meaning, Static
from .static import COMPARISONS, fold_binary, plain
from .text import is_static
from .types import BOOL, INT, REAL

_OPERATORS = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%",
    ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^", ast.LShift: "<<", ast.RShift: ">>",
}  # fmt: skip
#: Operators on the bits of integers; the first three are there for truth values, too, both of which are computed.
_BITWISE = {"&": "&", "|": "|", "^": "!=", "<<": "", ">>": ""}
_COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
#: Of an integer.
_BITS = 64
_WHAT_THERE_IS = "Algorithms have numbers, arrays, arithmetic, comparisons, and/or/not, `a if c else b` and calls."


class ExpressionReader(ElementReader):
    """Turns expressions of the text into IR. Calls of algorithms and kernels are statements: see `StatementReader`."""

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
                return self._select(node, node.test, node.body, node.orelse)
            case ast.Call():
                return self._call(node)
            case _:
                return self.refuse(node, f"{ast.unparse(node)} is not in the language", _WHAT_THERE_IS)

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
            value = plain(found.value)
            if not isinstance(value, (int, float)):
                self.number(node.operand, found)  # refuses it
            return Static(-value if isinstance(node.op, ast.USub) else +value)
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
            known = "There are + - * / // % & | ^ << >>; write x * x for x ** 2."
            self.refuse(node, "an operator that algorithms have not", known)
        return self.operation(node, operator, self.number(node.left, left), self.number(node.right, right))

    def operation(self, node: ast.AST, operator: str, left: Expression, right: Expression) -> Expression:
        """Arithmetic of two numbers: of integers if both are, but for ``/``."""
        if operator in _BITWISE:
            return self._bitwise(node, operator, left, right)
        left, right = self._arithmetic(node, left), self._arithmetic(node, right)
        if left.type == right.type == INT and operator != "/":
            return plus(left, right) if operator == "+" else Binary(operator, left, right, INT)
        if operator in ("//", "%"):
            self.refuse(node, f"{operator} of real numbers", "It is there for integers alone.")
        return Binary(operator, self.converted(node, left, REAL), self.converted(node, right, REAL), REAL)

    def _bitwise(self, node: ast.AST, operator: str, left: Expression, right: Expression) -> Expression:
        if left.type == right.type == BOOL and _BITWISE[operator]:
            return Binary(_BITWISE[operator], left, right, BOOL)
        if not left.type == right.type == INT:
            also = ", and for conditions" if _BITWISE[operator] else ""
            self.refuse(node, f"{operator} of {left.type} and {right.type}", f"It is there for integers{also}.")
        if not _BITWISE[operator] and isinstance(right, Constant) and not 0 <= right.value < _BITS:
            self.refuse(node, f"a shift by {right.value}", f"Shift by 0 to {_BITS - 1} bits.")
        return Binary(operator, left, right, INT)

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

    def _select(self, node: ast.expr, test: ast.expr, first: ast.expr, second: ast.expr) -> Meaning:
        """``first if test else second``, or select(test, first, second), whose arguments are always computed."""
        condition = self.condition(test)
        if isinstance(condition, Static):
            return self.meaning(first if condition.value else second)
        meaning = self.guarded if isinstance(node, ast.IfExp) else self.meaning
        yes, no = (self.number(each, meaning(each)) for each in (first, second))
        if yes.type != no.type:
            yes, no = self.converted(node, yes, REAL), self.converted(node, no, REAL)
        return Select(self.number(test, condition), yes, no, yes.type)

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
                    return self._fold(node, float, plain(found.value))
                value = self.number(argument, found)
                if value.type != INT:
                    self.refuse(node, "float() of what is not an integer", "Reals need no conversion.")
                return self.converted(node, value, REAL)
            case _, [argument] if function is int:
                return self._truncate(node, argument)
            case _, [first, second] if function in (min, max):
                return self._extreme(node, "<" if function is min else ">", first, second)
            case _, [condition, yes, no] if function is select:
                return self._select(node, condition, yes, no)
            case _ if isinstance(function, type(len)) or callable(function):
                return self._function(node, function)
        return self.refuse(node, f"{ast.unparse(node.func)} is not a function of algorithms", _WHAT_THERE_IS)

    def _function(self, node: ast.Call, function: Any) -> Meaning:
        try:
            name, types, result = language.FUNCTIONS[function]
        except (KeyError, TypeError):
            if isinstance(found := getattr(function, "static_value", None), tuple):  # of any arguments
                return Static(found)
            known = "sqrt, abs, sin, cos, exp, log, atan2, min, max, int, float, len, epsilon, largest"
            if getattr(function, "is_callable_in_algorithms", False):
                return self.call_inside(node, function)
            if any(function is each for each in language.ALLOCATORS):
                self.refuse(node, f"the call {ast.unparse(node)} inside an expression", "Give its result a name first.")
            self.refuse(
                node,
                f"{ast.unparse(node.func)} cannot be called in an algorithm",
                f"Call algorithms, kernels, or one of {known} (of bladesmith.codegen.language).",
            )
        if len(node.args) != len(types):
            self.refuse(node, f"{name} takes {len(types)} numbers", "Give it as many.")
        arguments = [self.expression(a) for a in node.args]
        if name == "abs" and arguments[0].type == INT:
            return Intrinsic("iabs", tuple(arguments), INT)
        numbers = tuple(self.converted(n, a, t) for n, a, t in zip(node.args, arguments, types, strict=True))
        if name == "abs" and isinstance(numbers[0], Constant):
            return Static(math.fabs(numbers[0].value))
        return Intrinsic(name, numbers, result)

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

    def _fold(self, node: ast.AST, function: Callable[..., Any], *values: Any) -> Static:
        """A function of static values."""
        try:
            return Static(function(*values))
        except (ArithmeticError, TypeError, ValueError) as error:
            self.refuse(node, f"static values give no result ({error})", "Look at the values of the names in it.")

    def _length(self, node: ast.Call, found: Meaning) -> Meaning:
        if isinstance(found, Static):
            return self._fold(node, len, found.value)
        if not isinstance(found, View):
            self.refuse(node, "the length of what is not an array", "Take len() of an array.")
        length = found.type.sizes[0]
        if length is not None:
            return Static(length)
        assert found.rows is not None
        return found.rows

    def _truncate(self, node: ast.Call, argument: ast.expr) -> Meaning:
        found = self.meaning(argument)
        if isinstance(found, Static) and isinstance(found.value, (int, float, IntEnum)):
            return self._fold(node, int, found.value)
        value = self.number(argument, found)
        if value.type == INT:
            return value
        return Intrinsic("int", (self.converted(node, value, REAL),), INT)

    def _extreme(self, node: ast.Call, operator: str, first: ast.expr, second: ast.expr) -> Meaning:
        """As in Python: the first, unless the second is less or greater."""
        meanings = self.meaning(first), self.meaning(second)
        if all(isinstance(m, Static) for m in meanings):
            values = [plain(m.value) for m in meanings if isinstance(m, Static)]
            return self._fold(node, min if operator == "<" else max, *values)
        a, b = self.number(first, meanings[0]), self.number(second, meanings[1])
        if a.type != b.type:
            a, b = self.converted(node, a, REAL), self.converted(node, b, REAL)
        if BOOL in (a.type, b.type):
            self.refuse(node, "the extreme of truth values", "Use and, or.")
        prefix = "i" if a.type == INT else ""
        return Intrinsic(prefix + ("min" if operator == "<" else "max"), (a, b), a.type)
