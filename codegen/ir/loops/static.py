"""Arithmetic of values that are known when the text is printed, as Python does it."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from enum import IntEnum
from typing import Any, NoReturn

BINARY = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow,
    ast.BitAnd: operator.and_, ast.BitOr: operator.or_, ast.BitXor: operator.xor,
    ast.LShift: operator.lshift, ast.RShift: operator.rshift,
}  # fmt: skip
COMPARISONS = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Eq: operator.eq,
    ast.NotEq: operator.ne, ast.In: lambda a, b: a in b, ast.NotIn: lambda a, b: a not in b,
    ast.Is: operator.is_, ast.IsNot: operator.is_not,
}  # fmt: skip
#: Largest exponent of a static power: 10 ** 10 ** 10 would not end.
_LARGEST_POWER = 1100


def plain(value: Any) -> Any:
    """Members of integer enumerations are integers."""
    return int(value) if isinstance(value, IntEnum) else value


def fold_binary(refuse: Callable[[ast.AST, str, str], NoReturn], node: ast.BinOp, left: Any, right: Any) -> Any:
    """The value of an operation on two static values."""
    function = BINARY.get(type(node.op))
    if function is None:
        known = "There are + - * / // % & | ^ << >> and, of static values, **."
        refuse(node, "an operator that algorithms have not", known)
    left, right = plain(left), plain(right)
    is_growing = isinstance(node.op, (ast.Pow, ast.LShift))
    if is_growing and not (isinstance(right, (int, float)) and abs(right) <= _LARGEST_POWER):
        refuse(node, "a static power or shift with a very large exponent", "Write the value.")
    try:
        return function(left, right)
    except (ArithmeticError, TypeError, ValueError) as error:
        refuse(node, f"static values give no result ({error})", "Look at the values of the names in it.")
