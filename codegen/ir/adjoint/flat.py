"""An algorithm as one text: the algorithms that it calls stand where they are called, without jumps.

Calls of kernels are left, and of algorithms that are still. Every name has one meaning, and the lengths of arrays are
known.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from ...errors import AlgorithmError
from ..loops.nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
    Call,
    Constant,
    Count,
    Expression,
    For,
    Function,
    If,
    Intrinsic,
    Load,
    Select,
    Statement,
    Store,
    Unary,
    Variable,
    View,
    While,
    boolean,
    integer,
    plus,
    real,
    scaled,
)  # fmt: skip
from ..loops.scope import fresh_name
from ..loops.tangent import bound_by, tangent
from ..loops.types import INT, REAL, ArrayType, Scalar
from .jumps import without_jumps
from .statements import PassedElement, PassedNumber, Region, copy, fill

#: What is inlined has at most so many statements.
_MOST_STATEMENTS = 20_000


@dataclass
class Flat:
    """One text.

    Attributes
    ----------
    body : sequence of statements
    results : sequence of expressions
        What is returned behind it.
    arrays : list of Array
        What it works in.
    changed : dict of str to View
        Of each parameter that it changes, the array in its place.
    taken : set of str
        All names.
    """

    body: Sequence[Statement]
    results: Sequence[Expression]
    arrays: list[Array]
    changed: dict[str, View]
    taken: set[str]


def flat(function: Function, rows: Mapping[str, int]) -> Flat:
    """An algorithm as one text.

    Parameters
    ----------
    function : Function
    rows : mapping of str to int
        Of the parameters whose number of rows is not known.

    Raises
    ------
    AlgorithmError
        If it calls a function that has no text, or is longer than can be.
    """
    inliner = _Inliner(function)
    body: list[Statement] = []
    names = _Names(function)
    changed: dict[str, View] = {}
    for p in function.parameters:
        inliner.taken.add(p.name)
    for p in function.parameters:
        if not isinstance(p.type, ArrayType):
            assert isinstance(p.type, Scalar)
            names.numbers[p.name] = Variable(p.name, p.type)
            continue
        own = closed(p.type, rows.get(p.name, 0))
        size = own.size if not own.is_open else 0
        count = integer(rows.get(p.name, 0)) if p.type.is_open else None
        view = View(Array(p.name, own), integer(0), p.type, count)
        if p.access != "in":
            local = inliner.local(p.name, p.type.scalar, size)
            changed[p.name] = replace(view, array=local)
            if p.access == "inout":
                body += copy(changed[p.name], view, size, inliner.taken)
            view = changed[p.name]
        names.arrays[p.name] = view
    inlined, results = inliner.text(function, names)
    return Flat([*body, *inlined], results, inliner.arrays, changed, inliner.taken)


def closed(type: ArrayType, rows: int) -> ArrayType:
    """The type of an array of which the number of rows is known; one without rows stays as it is."""
    return replace(type, shape=(rows, *type.sizes[1:])) if type.is_open and rows else type


@dataclass
class _Names:
    """What the names of one function mean in the whole text."""

    function: Function
    numbers: dict[str, Expression] = field(default_factory=dict)
    arrays: dict[str, View] = field(default_factory=dict)


class _Inliner:
    """The text so far."""

    def __init__(self, function: Function) -> None:
        self.function = function
        self.taken: set[str] = set()
        self.arrays: list[Array] = []
        self.count = 0

    def local(self, name: str, scalar: Scalar, size: int) -> Array:
        """A new array to work in."""
        array = Array(fresh_name(name, self.taken), ArrayType(scalar, (max(1, size),)), is_local=True)
        self.arrays.append(array)
        return array

    def text(self, function: Function, names: _Names) -> tuple[list[Statement], list[Expression]]:
        """Statements of a function, and what it returns."""
        if function.is_library and not function.body:
            raise AlgorithmError(
                f"{function.name} is a function of C alone", where=self.function.where or self.function.name,
                remedy="It has no derivative: leave out its call.",
            )  # fmt: skip
        body, results = without_jumps(function)
        found = self._block(body, names)
        return found, [self._expression(e, names) for e in results]

    def _variable(self, variable: Variable, names: _Names) -> Variable:
        """A number that is assigned to."""
        if variable.name not in names.numbers:
            names.numbers[variable.name] = Variable(fresh_name(variable.name, self.taken), variable.type)
        found = names.numbers[variable.name]
        assert isinstance(found, Variable)
        return found

    def _block(self, body: Iterable[Statement], names: _Names) -> list[Statement]:
        return [new for statement in body for new in self._statement(statement, names)]

    def _statement(self, statement: Statement, names: _Names) -> list[Statement]:
        self.count += 1
        if self.count > _MOST_STATEMENTS:
            raise AlgorithmError(
                f"the reverse derivative of {self.function.name} has more than {_MOST_STATEMENTS} statements, with "
                "those of what it calls", where=self.function.where, remedy="Use derivative(...), or call less in it.",
            )  # fmt: skip

        def ask(e: Expression) -> Expression:
            return self._expression(e, names)

        match statement:
            case Assign(target, value):
                return [Assign(self._variable(target, names), ask(value))]
            case Allocate(array, is_zero):
                names.arrays[array.name] = View(self.local(array.name, array.type.scalar, array.type.size), integer(0),
                                                array.type)  # fmt: skip
                return [Allocate(names.arrays[array.name].array, is_zero)]
            case Store(array, index, value):
                place = names.arrays[array.name]
                return [Store(place.array, plus(place.offset, ask(index)), ask(value))]
            case For(variable, start, stop, step, body):
                bounds, before = (ask(start), ask(stop)), names.numbers.get(variable.name)
                names.numbers[variable.name] = own = Variable(fresh_name(variable.name, self.taken), INT)
                inner = tuple(self._block(body, names))
                names.numbers.pop(variable.name)
                if before is not None:
                    names.numbers[variable.name] = before
                return [For(own, *bounds, step, inner, statement.where)]
            case While(condition, body):
                return [While(ask(condition), tuple(self._block(body, names)), statement.where)]
            case If(condition, yes, no):
                return [If(ask(condition), tuple(self._block(yes, names)), tuple(self._block(no, names)))]
            case Call(callee, arguments, results):
                given = [self._view(a, names) if isinstance(a, View) else ask(a) for a in arguments]
                targets = tuple(self._variable(r, names) for r in results)
                if not isinstance(callee, Function) or callee.is_still:
                    return [Call(callee, tuple(given), targets)]
                return self._along(callee, given, targets) if callee.rule else self._call(callee, given, targets)
            case _:
                return [statement]

    # -- calls -------------------------------------------------------------------------------------------------------

    def _call(
        self, callee: Function, arguments: Sequence[Expression | View], results: Sequence[Variable]
    ) -> list[Statement]:
        body, names = self._given(callee, arguments)
        inlined, values = self.text(callee, names)
        return [*body, *inlined, *(Assign(r, v) for r, v in zip(results, values, strict=True))]

    def _given(self, callee: Function, arguments: Sequence[Expression | View]) -> tuple[list[Statement], _Names]:
        """Names of a callee's parameters, and statements that give them their values."""
        body: list[Statement] = []
        names = _Names(callee)
        assigned = {name for s in callee.walk() for name in bound_by(s)}
        for p, a in zip(callee.parameters, arguments, strict=True):
            if isinstance(a, View):
                if not isinstance(a.offset, (Constant, Variable)):
                    at = Variable(fresh_name(f"{p.name}_at", self.taken), INT)
                    body.append(Assign(at, a.offset))
                    a = replace(a, offset=at)
                names.arrays[p.name] = a
            elif isinstance(a, Constant) and p.name not in assigned:
                names.numbers[p.name] = a
            else:
                body.append(Assign(self._variable(Variable(p.name, a.type), names), a))
        return body, names

    def _along(
        self, callee: Function, arguments: Sequence[Expression | View], results: Sequence[Variable]
    ) -> list[Statement]:
        """The declared derivative in place of an algorithm.

        It is linear in the tangents that it takes: along zero it gives the values, and in reverse what those of its
        results are pulled back to.
        """
        derived, count = tangent(callee, ()).function, len(callee.parameters)
        known = set(self.taken)
        places = {p.name: a for p, a in zip(callee.parameters, arguments, strict=True)}
        before: list[Statement] = []
        after: list[Statement] = []
        tangents: list[Expression | View] = []
        for p in derived.parameters[count:]:
            a = places[p.name.removeprefix("d_")]
            if not isinstance(a, View):
                own = Variable(fresh_name(p.name, self.taken), a.type)
                before += [Assign(own, real(0.0)), PassedNumber(own, a)]
                tangents.append(own)
                continue
            size = _size(a, callee)
            place = replace(a, array=self.local(p.name, a.array.type.scalar, size), offset=integer(0))
            before += fill(place, size, self.taken)
            if p.access != "out":
                before += copy(place, a, size, self.taken, PassedElement)
            if p.access != "in":
                after += copy(a, place, size, self.taken, PassedElement)
            tangents.append(place)
        reals = [r for r in results if r.type == REAL]
        along = [Variable(fresh_name(f"d_{r.name}", self.taken), REAL) for r in reals]
        body = self._call(derived, [*arguments, *tangents], [*results, *along])
        after += [PassedNumber(r, d) for r, d in zip(reals, along, strict=True)]
        inside = Region(boolean(True), tuple(body), (), frozenset(self.taken - known))
        return [*before, inside, *after]

    # -- expressions -------------------------------------------------------------------------------------------------

    def _view(self, view: View, names: _Names) -> View:
        place = names.arrays[view.array.name]
        rows = None if view.rows is None else self._expression(view.rows, names)
        return replace(view, array=place.array, offset=plus(place.offset, self._expression(view.offset, names)),
                       rows=rows)  # fmt: skip

    def _expression(self, expression: Expression, names: _Names) -> Expression:

        def ask(e: Expression) -> Expression:
            return self._expression(e, names)

        match expression:
            case Variable():
                found = names.numbers.get(expression.name)
                return found if found is not None else self._variable(expression, names)
            case Load(array, index):
                place = names.arrays[array.name]
                return Load(place.array, plus(place.offset, ask(index)))
            case Count(array):
                rows = names.arrays[array.name].rows
                assert rows is not None
                return rows
            case Unary(_, operand, _):
                return replace(expression, operand=ask(operand))
            case Binary("+", left, right, type) if type == INT:
                return plus(ask(left), ask(right))
            case Binary("*", Constant(factor), right, type) if type == INT:
                return scaled(ask(right), int(factor))
            case Binary("-", left, right, type) if type == INT:
                a, b = ask(left), ask(right)
                both = isinstance(a, Constant) and isinstance(b, Constant)
                return integer(int(a.value) - int(b.value)) if both else Binary("-", a, b, INT)  # type: ignore[union-attr]
            case Binary(_, left, right, _):
                return replace(expression, left=ask(left), right=ask(right))
            case Select(condition, yes, no, _):
                return replace(expression, condition=ask(condition), yes=ask(yes), no=ask(no))
            case Intrinsic(_, arguments, _):
                return replace(expression, arguments=tuple(map(ask, arguments)))
            case _:
                return expression


def _size(view: View, callee: Function) -> int:
    """Numbers of a view."""
    if not view.type.is_open:
        return view.type.size
    if isinstance(view.rows, Constant):
        return int(view.rows.value) * view.type.size
    raise AlgorithmError(
        f"{callee.name} is declared with its derivative and takes rows whose number is not known",
        where=callee.where, remedy="Give it whole arrays, or use derivative(...).",
    )  # fmt: skip
