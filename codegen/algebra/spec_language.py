"""A small, safe language for GA expressions in specs: Python's expressions on multivectors, read by a walker.

Kinds state their constraints and a random member in it. Nothing is ever passed to `eval`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from ..errors import BladeError, BladesmithError, SpecError, one_line, suggest
from .multivector import Multivector

#: Longest expression that is read; specs are written by people.
MAX_LENGTH = 4000
#: Most binary digits of a number's numerator, and of its denominator.
MAX_BITS = 20_000
_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: Fraction(a) / b if isinstance(a, int | Fraction) and isinstance(b, int | Fraction) else a / b,
    ast.BitXor: lambda a, b: a ^ b,
    ast.BitOr: lambda a, b: a | b,
    ast.BitAnd: lambda a, b: a & b,
    ast.RShift: lambda a, b: a >> b,
}
_METHODS: dict[str, Callable[..., Any]] = {
    "reverse": lambda x: ~x,
    "dual": lambda x: x.dual(),
    "undual": lambda x: x.undual(),
    "grade": lambda x, g: x.grade(int(g)),
    "scalar": lambda x: x.grade(0),
}


def parse(text: str, where: str) -> ast.Module:
    """Syntax tree of assignments followed by one expression.

    Raises
    ------
    SpecError
        If the text is not such a program.
    """
    if not isinstance(text, str) or len(text) > MAX_LENGTH:
        raise SpecError(f"{where} is not an expression of at most {MAX_LENGTH} characters.")
    try:
        tree = ast.parse(text.strip())
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise SpecError(f"{where}: {one_line(text)} is not an expression ({getattr(error, 'msg', error)}).") from None
    body = tree.body
    if not body or not isinstance(body[-1], ast.Expr) or not all(isinstance(s, ast.Assign) for s in body[:-1]):
        raise SpecError(f"{where}: {one_line(text)} must be assignments `name = expression` and, last, one expression.")
    return tree


def evaluate(
    text: str, like: Multivector, names: Mapping[str, Any], where: str, functions: Mapping[str, Callable[..., Any]] = {}
) -> Multivector:
    """Value of a program over the algebra and ring of ``like``.

    Names are those given, those assigned, and the algebra's blades (``e12``, ``no``).
    """
    tree = parse(text, where)
    scope: dict[str, Any] = dict(names)
    walker = _Walker(like, scope, {**_METHODS, **functions}, where)
    try:
        return _value(tree, walker, scope, like, where)
    except SpecError:
        raise
    except (BladesmithError, ArithmeticError, TypeError, ValueError) as error:
        raise SpecError(f"{where}: {one_line(text)} cannot be computed: {error}") from None


def _value(tree: ast.Module, walker: _Walker, scope: dict[str, Any], like: Multivector, where: str) -> Multivector:
    for statement in tree.body[:-1]:
        assert isinstance(statement, ast.Assign)
        target = statement.targets[0]
        if len(statement.targets) != 1 or not isinstance(target, ast.Name):
            raise SpecError(f"{where}: assign to one plain name at a time.")
        scope[target.id] = walker.visit(statement.value)
    last = tree.body[-1]
    assert isinstance(last, ast.Expr)
    value = walker.visit(last.value)
    return value if isinstance(value, Multivector) else like.constant(value)


class _Walker:
    """Evaluates the few node types that the language has; any other is a `SpecError`."""

    def __init__(
        self, like: Multivector, scope: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]], where: str
    ) -> None:
        self.like = like
        self.scope = scope
        self.functions = functions
        self.where = where

    def visit(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=int() as value) if not isinstance(value, bool):
                return Fraction(value)
            case ast.Constant(value=float() as value):
                return Fraction(str(value))
            case ast.Name(id=name):
                return self._name(name)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return -self.visit(operand)
            case ast.UnaryOp(op=ast.Invert(), operand=operand):
                return ~self.visit(operand)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
                return self._checked(_BINARY[type(op)](self.visit(left), self.visit(right)))
            case ast.Subscript(value=value, slice=ast.Constant(value=str() as name)):
                return self.visit(value)[name]
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]):
                if name not in self.functions:
                    known = ", ".join(sorted(self.functions))
                    raise SpecError(
                        f"{self.where}: no function {name!r}{suggest(name, known.split(', '))}; it has {known}."
                    )
                return self.functions[name](*(self.visit(a) for a in args))
        raise SpecError(f"{self.where}: {ast.unparse(node)!r} is not allowed in an expression.")

    def _checked(self, value: Any) -> Any:
        """A number, unless it is longer than any that a spec needs: a few squares make one that no memory holds."""
        if isinstance(value, Fraction) and max(value.numerator.bit_length(), value.denominator.bit_length()) > MAX_BITS:
            raise SpecError(f"{self.where}: a number has more than {MAX_BITS} binary digits.")
        return value

    def _name(self, name: str) -> Any:
        if name in self.scope:
            return self.scope[name]
        try:
            return self.like.basis(name)
        except BladeError as error:
            raise SpecError(f"{self.where}: unknown name {name!r}; {error}") from None
