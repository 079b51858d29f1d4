"""Cotangents of expressions: what they are computed from gets its share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...errors import AlgorithmError
from ..loops.nodes import (
    Array,
    Assign,
    Binary,
    Constant,
    Expression,
    If,
    Intrinsic,
    Load,
    Select,
    Statement,
    Store,
    Unary,
    Variable,
    parts,
    real,
)  # fmt: skip
from ..loops.scope import fresh_name
from ..loops.tangent import OF_ONE, greater_of, over_angle, sources
from ..loops.types import BOOL, REAL


class Cotangents:
    """Names of cotangents, and statements that add to them.

    Parameters
    ----------
    active : set of str
        Numbers and arrays that have a cotangent.
    taken : set of str
        Names that there are.
    where : str
        Of the algorithm, for errors.
    """

    def __init__(self, active: set[str], taken: set[str], where: str) -> None:
        self.active, self.taken, self.where = active, taken, where
        self.names: dict[str, str] = {}
        self.numbers: dict[str, Variable] = {}  # cotangents of numbers that are in use, and arrays of them
        self.arrays: dict[str, Array] = {}

    def number(self, name: str) -> Variable:
        """The cotangent of a number."""
        if name not in self.numbers:
            self.numbers[name] = Variable(fresh_name(f"{name}_bar", self.taken), REAL)
        return self.numbers[name]

    def array(self, array: Array) -> Array:
        """The cotangents of an array."""
        if array.name not in self.arrays:
            self.arrays[array.name] = replace(array, name=fresh_name(f"{array.name}_bar", self.taken), is_local=True)
        return self.arrays[array.name]

    def taken_from(self, target: Variable | Load) -> tuple[Expression, list[Statement]]:
        """The cotangent of what is assigned to, which is zero before."""
        weight = Variable(fresh_name("share", self.taken), REAL)
        if isinstance(target, Variable):
            own = self.number(target.name)
            return weight, [Assign(weight, own), Assign(own, real(0.0))]
        array = self.array(target.array)
        return weight, [Assign(weight, Load(array, target.index)), Store(array, target.index, real(0.0))]

    def spread(self, expression: Expression, weight: Expression, visible: set[str]) -> list[Statement]:
        """Statements that add to the cotangents of what an expression is computed from.

        Nothing is added for a cotangent of zero where a partial derivative may be infinite or NaN: of a quotient by
        zero, of the root of zero, or of a product with what is computed and not selected.

        Parameters
        ----------
        expression : Expression
        weight : Expression
            Its cotangent.
        visible : set of str
            Numbers and arrays that vary here.
        """
        added = _Spreader(self, visible).spread(expression, weight)
        if added and any(_is_curved(p) and not visible.isdisjoint(sources(p)) for p in parts(expression)):
            return [If(Binary("!=", weight, real(0.0), BOOL), tuple(added))]
        return added


class _Spreader:
    """One expression."""

    def __init__(self, cotangents: Cotangents, visible: set[str]) -> None:
        self.cotangents, self.visible = cotangents, visible

    def _varies(self, expression: Expression) -> bool:
        return not self.visible.isdisjoint(sources(expression))

    def _shared(self, weight: Expression, add: Callable[[Expression], list[Statement]]) -> list[Statement]:
        """What is added by shares of a weight, which is computed once."""
        if isinstance(weight, (Variable, Constant)):
            return add(weight)
        name = Variable(fresh_name("share", self.cotangents.taken), REAL)
        return [Assign(name, weight), *add(name)]

    def spread(self, expression: Expression, weight: Expression) -> list[Statement]:
        if not self._varies(expression):
            return []
        match expression:
            case Variable(name, _):
                own = self.cotangents.number(name)
                return [Assign(own, Binary("+", own, weight, REAL))]
            case Load(array, index):
                cotangents = self.cotangents.array(array)
                return [Store(cotangents, index, Binary("+", Load(cotangents, index), weight, REAL))]
            case Unary(_, operand, _):
                return self.spread(operand, Unary("-", weight, REAL))
            case Binary(operator, left, right, _):
                return self._shared(weight, lambda w: self._binary(operator, left, right, w))
            case Select(condition, yes, no, _):
                return self._shared(weight, lambda w: [_branch(condition, self.spread(yes, w), self.spread(no, w))])
            case Intrinsic(name, arguments, _):
                return self._shared(weight, lambda w: self._function(name, arguments, w))
        raise TypeError(expression)

    def _binary(self, operator: str, a: Expression, b: Expression, w: Expression) -> list[Statement]:
        if operator == "+":
            return [*self.spread(a, w), *self.spread(b, w)]
        if operator == "-":
            return [*self.spread(a, w), *self.spread(b, Unary("-", w, REAL))]
        if operator == "*":
            return [*self.spread(a, Binary("*", w, b, REAL)), *self.spread(b, Binary("*", w, a, REAL))]
        quotient = Binary("/", w, b, REAL)
        if not self._varies(b):
            return self.spread(a, quotient)

        def divided(q: Expression) -> list[Statement]:
            own = Unary("-", Binary("*", q, Binary("/", a, b, REAL), REAL), REAL)
            return [*self.spread(a, q), *self.spread(b, own)]

        return self._shared(quotient, divided)

    def _function(self, name: str, arguments: tuple[Expression, ...], w: Expression) -> list[Statement]:
        if name in OF_ONE:
            return self.spread(arguments[0], OF_ONE[name](arguments[0], w))
        if name in ("min", "max"):
            a, b = arguments
            condition = Binary("<" if name == "min" else ">", b, a, BOOL)
            return [_branch(condition, self.spread(b, w), self.spread(a, w))]
        if name == "atan2":
            a, b = arguments
            return self._shared(greater_of(a, b), lambda h: self._angle(a, b, h, w))
        raise AlgorithmError(f"{name} has no derivative", where=self.cotangents.where)

    def _angle(self, a: Expression, b: Expression, size: Expression, w: Expression) -> list[Statement]:
        """Of atan2: ``size`` is the greater of both, by which they are divided."""

        def spread(u: Expression, v: Expression) -> list[Statement]:
            return self._shared(
                Binary("/", w, over_angle(u, v, size), REAL),
                lambda q: [
                    *self.spread(a, Binary("*", q, v, REAL)),
                    *self.spread(b, Unary("-", Binary("*", q, u, REAL), REAL)),
                ],
            )

        up, along = Binary("/", a, size, REAL), Binary("/", b, size, REAL)
        return self._shared(up, lambda u: self._shared(along, lambda v: spread(u, v)))


def _is_curved(expression: Expression) -> bool:
    """Whether partial derivatives depend on values, of which some may not be finite."""
    match expression:
        case Binary("*", left, right, _):
            return not isinstance(left, Constant) and not isinstance(right, Constant)
        case Binary("/", _, divisor, _):
            return not isinstance(divisor, Constant)
        case Intrinsic(name, _, _):
            return name not in ("abs", "min", "max")
    return False


def _branch(condition: Expression, yes: list[Statement], no: list[Statement]) -> Statement:
    if not yes:
        return If(Unary("not", condition, BOOL), tuple(no))
    return If(condition, tuple(yes), tuple(no))
