"""Derivatives of algorithms: forward mode on the loop IR, branches as taken.

Each number and array that depends on what is varied has a tangent beside it, computed before the number itself is
replaced. Kernels have the kernels of their formulas' derivatives. An algorithm that is declared with its derivative has
that; what one that is still gives is constant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ...errors import AlgorithmError
from .nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
    Call,
    Expression,
    For,
    Function,
    If,
    Intrinsic,
    KernelSignature,
    Load,
    Return,
    Select,
    Statement,
    Store,
    Unary,
    Variable,
    View,
    While,
    integer,
    plus,
    real,
)  # fmt: skip
from .scope import fresh_name
from .types import BOOL, INT, REAL, ArrayType

#: Derivatives of functions of one number: from the argument and its tangent, or in reverse its cotangent.
OF_ONE: dict[str, Callable[[Expression, Expression], Expression]] = {
    "sqrt": lambda x, d: _times(d, _over(real(0.5), Intrinsic("sqrt", (x,), REAL))),
    "abs": lambda x, d: Select(Binary("<", x, real(0.0), BOOL), Unary("-", d, REAL), d, REAL),
    "sin": lambda x, d: _times(d, Intrinsic("cos", (x,), REAL)),
    "cos": lambda x, d: Unary("-", _times(d, Intrinsic("sin", (x,), REAL)), REAL),
    "exp": lambda x, d: _times(d, Intrinsic("exp", (x,), REAL)),
    "log": lambda x, d: _over(d, x),
}


@dataclass(frozen=True)
class Tangent:
    """The derivative of an algorithm.

    Attributes
    ----------
    function : Function
        Parameters, then the tangents of those of them that vary; results, then tangents of all real ones.
    varies : frozenset of str
        Parameters that have a tangent.
    """

    function: Function
    varies: frozenset[str]


def tangent(function: Function, wrt: Iterable[str]) -> Tangent:
    """The derivative of an algorithm with respect to some of its parameters.

    Raises
    ------
    AlgorithmError
        If a kernel's derivative has other blades than the kernel.
    """
    key = (function, frozenset(wrt))
    if key not in _tangents:
        found = _declared(function) if function.rule else _Reader(function, key[1]).result()
        _tangents[key] = _tangents.setdefault((function, found.varies), found)  # one, whatever led to it
    return _tangents[key]


def _declared(function: Function) -> Tangent:
    """The derivative that an algorithm is declared with."""
    assert function.rule is not None
    derived, count = function.rule(), len(function.parameters)
    results = (*function.results, *(t for t in function.results if t == REAL))
    if derived.results != results:
        raise AlgorithmError(
            f"{derived.name} is the derivative of {function.name} and returns {len(derived.results)} numbers",
            remedy=f"Return {len(results)}: what {function.name} returns, then the tangents of real numbers.",
        )
    return Tangent(derived, frozenset(p.name.removeprefix("d_") for p in derived.parameters[count:]))


_tangents: dict[tuple[Function, frozenset[str]], Tangent] = {}


def _plus(a: Expression | None, b: Expression | None) -> Expression | None:
    if a is None or b is None:
        return a or b
    return Binary("+", a, b, REAL)


def _minus(a: Expression | None, b: Expression | None) -> Expression | None:
    if b is None:
        return a
    return Unary("-", b, REAL) if a is None else Binary("-", a, b, REAL)


def _times(a: Expression, b: Expression) -> Expression:
    return Binary("*", a, b, REAL)


def _over(a: Expression, b: Expression) -> Expression:
    return Binary("/", a, b, REAL)


def greater_of(a: Expression, b: Expression) -> Expression:
    """The greater size of two numbers."""
    return Intrinsic("max", (Intrinsic("abs", (a,), REAL), Intrinsic("abs", (b,), REAL)), REAL)


def over_angle(u: Expression, v: Expression, size: Expression) -> Expression:
    """What derivatives of atan2(size u, size v) are divided by: squares of u and v neither overflow nor vanish."""
    return _times(Binary("+", _times(u, u), _times(v, v), REAL), size)


class _Reader:
    """One algorithm and what is varied."""

    def __init__(self, function: Function, wrt: frozenset[str]) -> None:
        self.function = function
        self.active = self._active(wrt)
        self.taken = names_of(function)
        self.names: dict[str, str] = {}

    def name(self, name: str) -> str:
        """The tangent's name: one that the text has not."""
        if name not in self.names:
            self.names[name] = fresh_name(f"d_{name}", self.taken)
        return self.names[name]

    def result(self) -> Tangent:
        if self.function.is_library and not self.function.body:
            name = self.function.name
            raise AlgorithmError(f"{name} is a function of C alone", remedy="It has no derivative: leave out its call.")
        parameters = list(self.function.parameters)
        for p in self.function.parameters:
            if p.name in self.active:
                parameters.append(replace(p, name=self.name(p.name)))
        results = [*self.function.results, *(t for t in self.function.results if t == REAL)]
        body = self._block(self.function.body)
        suffix = "_".join(sorted(self.active & {p.name for p in self.function.parameters}))
        name = f"{self.function.name}_d_{suffix}"
        note = f"Derivative of {self.function.name}: {self.function.note}"
        derived = Function(name, note, tuple(parameters), tuple(results), body, self.function.is_inline)
        return Tangent(derived, frozenset(p.name for p in self.function.parameters if p.name in self.active))

    # -- what varies -------------------------------------------------------------------------------------------------

    def _active(self, wrt: frozenset[str]) -> set[str]:
        """Numbers and arrays that depend on what is varied, anywhere in the text."""
        active = set(wrt)
        while True:
            before = len(active)
            for statement in self.function.walk():
                active |= self._newly_active(statement, active)
            if len(active) == before:
                return active

    def _newly_active(self, statement: Statement, active: set[str]) -> set[str]:
        match statement:
            case Assign(target, value) if target.type == REAL and _depends(value, active):
                return {target.name}
            case Store(array, _, value) if array.type.scalar == REAL and _depends(value, active):
                return {array.name}
            case Call(KernelSignature() as kernel, arguments, _):
                count = len(kernel.outputs)
                inputs = [a for a in arguments[count:] if isinstance(a, View)]
                if any(v.array.name in active and not v.is_still for v in inputs):
                    return {a.array.name for a in arguments[:count] if isinstance(a, View)}
            case Call(Function() as callee, arguments, results):
                given = _varying_parameters(callee, arguments, active)
                if given and not callee.is_still:
                    varies = tangent(callee, given).varies
                    pairs = zip(callee.parameters, arguments, strict=True)
                    arrays = {a.array.name for p, a in pairs if isinstance(a, View) and p.name in varies}
                    return arrays | {r.name for r in results if r.type == REAL}
        return set()

    # -- statements --------------------------------------------------------------------------------------------------

    def _block(self, body: Sequence[Statement]) -> tuple[Statement, ...]:
        return tuple(new for statement in body for new in self._statement(statement))

    def _statement(self, statement: Statement) -> list[Statement]:
        match statement:
            case Assign(target, value) if target.name in self.active:
                return [Assign(self._variable(target), self._or_zero(self.d(value))), statement]
            case Allocate(array, _) if array.name in self.active:
                return [statement, replace(statement, array=self._array(array))]
            case Store(array, index, value) if array.name in self.active:
                return [Store(self._array(array), index, self._or_zero(self.d(value))), statement]
            case For():
                return [replace(statement, body=self._block(statement.body))]
            case While():
                return [replace(statement, body=self._block(statement.body))]
            case If():
                return [replace(statement, yes=self._block(statement.yes), no=self._block(statement.no))]
            case Return(values):
                reals = [v for v, t in zip(values, self.function.results, strict=True) if t == REAL]
                return [Return((*values, *(self._or_zero(self.d(v)) for v in reals)))]
            case Call(KernelSignature(), _, _):
                return self._kernel_call(statement)
            case Call():
                return self._call(statement)
            case _:
                return [statement]

    def _call(self, call: Call) -> list[Statement]:
        callee = call.callee
        assert isinstance(callee, Function)
        given = _varying_parameters(callee, call.arguments, self.active)
        written = {p.name for p, a in zip(callee.parameters, call.arguments, strict=True)
                   if isinstance(a, View) and a.array.name in self.active and p.access != "in"}  # fmt: skip
        if callee.is_still:
            numbers = [r for r in call.results if r.name in self.active]
            return [call, *(Assign(self._variable(r), real(0.0)) for r in numbers)]
        if not given and not written and not any(r.name in self.active for r in call.results):
            return [call]
        derived = tangent(callee, given | written)
        arguments = list(call.arguments)
        for p, a in zip(callee.parameters, call.arguments, strict=True):
            if p.name not in derived.varies:
                continue
            arguments.append(self._view(a) if isinstance(a, View) else self._or_zero(self.d(a)))
        extra = [self._variable(r) for r in call.results if r.type == REAL]
        return [Call(derived.function, tuple(arguments), (*call.results, *extra))]

    def _kernel_call(self, call: Call) -> list[Statement]:
        """The kernel of the formula's tangents, and the kernel itself unless the other gives its results too."""
        kernel = call.callee
        assert isinstance(kernel, KernelSignature)
        count = len(kernel.outputs)
        outputs = [a for a in call.arguments[:count] if isinstance(a, View)]
        inputs = [a for a in call.arguments[count:] if isinstance(a, View)]
        if not any(v.array.name in self.active for v in outputs):
            return [call]
        varying = [v.array.name in self.active and not v.is_still for v in inputs]
        names = tuple(n for (n, _), varies in zip(kernel.inputs, varying, strict=True) if varies)
        if not names:
            return [*(self._zero(v) for v in outputs), call]
        derived: KernelSignature = kernel.kernel.tangent_signature(names)
        values = [v for v, is_value in zip(outputs, kernel.are_values, strict=True) if is_value]
        statuses = [v for v in outputs if v not in values]
        with_values = len(derived.outputs) == 2 * len(values)
        sizes = [n for (_, n), is_value in zip(kernel.outputs, kernel.are_values, strict=True) if is_value]
        if [n for _, n in derived.outputs] != sizes * (1 + with_values):
            raise AlgorithmError(
                f"the derivative of the kernel {kernel.symbol} with respect to {', '.join(names)} has other blades",
                where=self.function.where or self.function.name,
                remedy="Declare its result by a layout that holds both.",
            )  # fmt: skip
        directions = [self._view(v) for v, varies in zip(inputs, varying, strict=True) if varies]
        own = values if with_values else []
        along = Call(derived, (*own, *map(self._view, values), *inputs, *directions), ())
        zeros = [self._zero(v) for v in statuses if v.array.name in self.active]
        return [*zeros, along] if with_values and not statuses else [*zeros, along, call]

    def _zero(self, view: View) -> For:
        """A loop that makes a tangent zero."""
        index, target = Variable(fresh_name("k", self.taken), INT), self._view(view)
        store = Store(target.array, plus(target.offset, index), real(0.0))
        return For(index, integer(0), integer(view.type.size), 1, (store,))

    # -- expressions -------------------------------------------------------------------------------------------------

    def _variable(self, variable: Variable) -> Variable:
        return Variable(self.name(variable.name), variable.type)

    def _array(self, array: Array) -> Array:
        return replace(array, name=self.name(array.name))

    def _view(self, view: View) -> View:
        return replace(view, array=self._array(view.array))

    @staticmethod
    def _or_zero(found: Expression | None) -> Expression:
        return real(0.0) if found is None else found

    def d(self, expression: Expression) -> Expression | None:
        """The tangent of an expression; None where it is zero."""
        match expression:
            case Variable(name, type) if name in self.active and type == REAL:
                return self._variable(expression)
            case Load(array, index) if array.name in self.active and array.type.scalar == REAL:
                return Load(self._array(array), index)
            case Unary("-", operand, type) if type == REAL:
                return _minus(None, self.d(operand))
            case Binary(operator, left, right, type) if type == REAL:
                return self._binary(operator, left, right)
            case Select(condition, yes, no, type) if type == REAL:
                a, b = self.d(yes), self.d(no)
                return None if a is None and b is None else Select(condition, self._or_zero(a), self._or_zero(b), REAL)
            case Intrinsic(name, arguments, type) if type == REAL and arguments:
                return self._function(name, arguments)
            case _:
                return None

    def _binary(self, operator: str, a: Expression, b: Expression) -> Expression | None:
        da, db = self.d(a), self.d(b)
        if operator in "+-":
            return _plus(da, db) if operator == "+" else _minus(da, db)
        if operator == "*":
            return _plus(_times(da, b) if da else None, _times(a, db) if db else None)
        top = _minus(da, _times(_over(a, b), db) if db else None)
        return _over(top, b) if top else None

    def _function(self, name: str, arguments: tuple[Expression, ...]) -> Expression | None:
        tangents = [self.d(a) if a.type == REAL else None for a in arguments]
        if all(t is None for t in tangents):
            return None
        if name in OF_ONE:
            assert tangents[0] is not None
            return OF_ONE[name](arguments[0], tangents[0])
        a, b = arguments
        da, db = tangents
        if name in ("min", "max"):
            condition = Binary("<" if name == "min" else ">", b, a, BOOL)
            return Select(condition, self._or_zero(db), self._or_zero(da), REAL)
        if name == "atan2":
            size = greater_of(a, b)
            u, v = _over(a, size), _over(b, size)
            top = _minus(_times(v, da) if da else None, _times(u, db) if db else None)
            return _over(self._or_zero(top), over_angle(u, v, size))
        raise AlgorithmError(f"{name} has no derivative", where=self.function.where or self.function.name)


def _varying_parameters(callee: Function, arguments: Sequence[Any], active: set[str]) -> frozenset[str]:
    """Parameters of a callee whose arguments vary when it is called."""
    found = set()
    for p, a in zip(callee.parameters, arguments, strict=True):
        scalar = p.type.scalar if isinstance(p.type, ArrayType) else p.type
        if scalar != REAL or p.access == "out":
            continue
        if a.array.name in active if isinstance(a, View) else _depends(a, active):
            found.add(p.name)
    return frozenset(found)


def _depends(expression: Expression, active: set[str]) -> bool:
    """Whether a number varies."""
    return not active.isdisjoint(sources(expression))


def sources(expression: Expression) -> set[str]:
    """Numbers and arrays that an expression varies with: what only decides, counts or is an index it does not."""
    match expression:
        case Variable(name, type):
            return {name} if type == REAL else set()
        case Load(array, _):
            return {array.name} if array.type.scalar == REAL else set()
        case Unary(_, operand, _):
            return sources(operand)
        case Binary(_, left, right, type):
            return sources(left) | sources(right) if type == REAL else set()
        case Select(_, yes, no, _):
            return sources(yes) | sources(no)
        case Intrinsic(_, arguments, type):
            return {name for a in arguments for name in sources(a)} if type == REAL else set()
        case _:
            return set()


def names_of(function: Function) -> set[str]:
    """All names of an algorithm."""
    return {p.name for p in function.parameters} | {n for s in function.walk() for n in bound_by(s)}


def bound_by(statement: Statement) -> set[str]:
    """Numbers and arrays that a statement itself makes or assigns to."""
    match statement:
        case Assign(target, _):
            return {target.name}
        case Allocate(array, _):
            return {array.name}
        case Call(_, _, results):
            return {r.name for r in results}
        case For(variable, _, _, _, _):
            return {variable.name}
        case _:
            return set()
