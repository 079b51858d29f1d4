"""Algorithms whose items take different paths, as statements that all items run: what is done is done for those meant.

A branch runs where any item takes it, a loop as long as any is in it; numbers that the others know keep their values.
After M. Pharr and W. R. Mark, "ispc: a SPMD compiler for high-performance CPU programming" (2012).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ....ir.loops.nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
    Break,
    Call,
    Continue,
    Expression,
    For,
    Function,
    If,
    Load,
    Return,
    Statement,
    Store,
    Unary,
    Variable,
    While,
    assigned_variables,
    blocks,
    boolean,
    integer,
    walk,
)  # fmt: skip
from ....ir.loops.types import BOOL, INT, Parameter
from ...uses import is_inside_one_block
from .guards import Mask, any_of, both, but_not, zero
from .masked_calls import CallMasker
from .paths import varies
from .places import ParallelLoop, Region
from .varying import Lanes

#: More steps than a loop can have whose end differs between items.
_ENDLESS = 1 << 62
#: A branch with no more statements than this, all of them short, is not worth asking whether any item takes it.
SHORT = 4


def masked_function(function: Function, lanes: Lanes) -> Function:
    """A function of several items, those that are meant a parameter if it needs to know; callees come before it."""
    found = _Masker(function, lanes).function()
    lanes.printed[function] = found
    lanes.names[found], lanes.results[found] = lanes.names[function], lanes.results[function]
    return found


class _Masker(CallMasker):
    """One function."""

    def function(self) -> Function:
        function = self.original
        mask: Mask = None
        parameters = function.parameters
        if function in self.lanes.masked:
            mask = self.guards.fresh("mask", BOOL)
            parameters = (*parameters, Parameter(mask.name, BOOL))
        if self.paths.has_divergent_return:
            mask = self.guards.named("active", mask or boolean(True))
            self.results = [self.guards.named("returned", zero(t)) for t in function.results]
        self.regions = [Region((), mask)]
        known = {p.name for p in function.parameters}
        self._block(function.body, known)
        if self.paths.has_divergent_return and not isinstance(self.out[-1], Return):
            self.out.append(Return(tuple(self.results)))
        return replace(function, parameters=parameters, body=tuple(self.out))

    # -- statements --------------------------------------------------------------------------------------------------

    def _inner(self, body: Sequence[Statement], known: set[str]) -> tuple[Statement, ...]:
        outer, self.out = self.out, []
        self._block(body, known)
        found, self.out = tuple(self.out), outer
        return found

    def _block(self, body: Sequence[Statement], known: set[str]) -> None:
        known = set(known)
        for statement in body:
            self._begin_numbers(statement, known)
            self._statement(statement, known)
            known.update(v.name for v in assigned_variables((statement,), deep=False))

    def _begin_numbers(self, statement: Statement, known: set[str]) -> None:
        """Zero for numbers that only some items assign first."""
        if not blocks(statement):
            return
        for variable in assigned_variables((statement,)):
            name = variable.name
            if name in known or name not in self.partial or not self.is_own(name):
                continue
            if id(statement) in self.paths.divergent or not is_inside_one_block(statement, name):
                self.out.append(Assign(variable, zero(variable.type)))
                known.add(name)

    def _statement(self, statement: Statement, known: set[str]) -> None:
        match statement:
            case Assign(target, value):
                self._assign(target, self.expression(value))
            case Allocate(array, is_zero):
                self.out.append(Allocate(array, is_zero or array.name in self.partial))
            case Store(array, index, value):
                self._store(array, self.expression(index), self.expression(value))
            case Call():
                self.call(statement)
            case If(condition, yes, no):
                self._if(statement, self.expression(condition), yes, no, known)
            case For() | While():
                self._loop(statement, known)
            case Break():
                self._break()
            case Continue():
                self._continue()
            case Return(values):
                self._return(tuple(self.expression(v) for v in values))

    def _assign(self, target: Variable, value: Expression) -> None:
        if target.name in self.names and not self.is_own(target.name):
            value = self.blend(value, target)
        self.out.append(Assign(target, value))

    def _store(self, array: Array, index: Expression, value: Expression) -> None:
        is_scattered = varies(self.names, index)
        if is_scattered:
            index = self.guards.named("place", self.guards.index(index, self.mask))
        if is_scattered or (array.name in self.names and not self.is_own(array.name)):
            value = self.blend(value, Load(array, index))
        self.out.append(Store(array, index, value))

    def _if(
        self, statement: If, condition: Expression, yes: Sequence[Statement], no: Sequence[Statement], known: set[str]
    ) -> None:
        if id(statement) not in self.paths.divergent:
            self.out.append(If(condition, self._inner(yes, known), self._inner(no, known)))
            return
        decides = self.guards.named("holds", condition)
        taken = decides if self.mask is None else self.guards.named("taken", both(self.mask, decides))
        others = self.guards.named("others", but_not(self.mask, decides)) if no else None
        path = self.path
        for k, (mask, body) in enumerate(((taken, yes), (others, no))):
            if mask is None:
                continue
            self.regions.append(Region(self.paths.path_into(statement, path, k), mask))
            found = self._inner(body, known)
            self.regions.pop()
            if self._is_short(body, statement.condition):
                self.out.extend(found)
            else:
                self.out.append(If(any_of(mask), found))
        if _leaves(statement):
            self._skip_if_none()

    def _is_short(self, body: Sequence[Statement], condition: Expression) -> bool:
        """Whether a branch is computed whether or not any item takes it."""
        computed = [(s.value,) if isinstance(s, Assign) else (Load(s.array, s.index), s.value) for s in body
                    if isinstance(s, (Assign, Store))]  # fmt: skip
        return len(computed) == len(body) <= SHORT and all(
            self.guards.is_safe(e, condition) for each in computed for e in each
        )

    def _skip_if_none(self) -> None:
        """What follows is left out if no item is left."""
        region = self.regions[-1]
        if region.mask is None:
            return
        nobody = Unary("not", any_of(region.mask), BOOL)
        if region.loop is not None and self.loops and self.loops[-1] is region.loop:
            self.out.append(If(nobody, (Continue(),)))
        elif len(self.regions) == 1 and self.paths.has_divergent_return:
            self.out.append(If(nobody, (Return(tuple(self.results)),)))

    # -- loops -------------------------------------------------------------------------------------------------------

    def _loop(self, statement: For | While, known: set[str]) -> None:
        if id(statement) not in self.paths.divergent:
            self._common_loop(statement, known)
            return
        inside = self.guards.named("inside", self.mask or boolean(True))
        loop = ParallelLoop(inside, len(self.regions))
        self.loops.append(loop)
        begin: list[Statement] = []
        repeated = self._steps(statement, inside, begin) if isinstance(statement, For) else None
        outer, self.out = self.out, begin
        if isinstance(statement, While):
            condition = self.guards.mask_expression(statement.condition, inside)
            if condition != boolean(True):
                self.out.append(Assign(inside, both(inside, condition)))
        nobody = Unary("not", any_of(inside), BOOL)
        self.out.append(If(nobody, (Break(),)))
        present = self.guards.named("present", inside) if _continues(statement) else inside
        self.regions.append(Region(self.paths.path_into(statement, self.path), present, loop))
        self._block(statement.body, {*known, *([statement.variable.name] if isinstance(statement, For) else [])})
        self.regions.pop()
        self.loops.pop()
        body, self.out = tuple(self.out), outer
        self.out.append(While(boolean(True), body) if repeated is None else replace(repeated, body=body))
        if any(isinstance(s, Return) for s in walk(statement.body)):
            self._skip_if_none()

    def _steps(self, statement: For, inside: Variable, body: list[Statement]) -> For:
        """The loop that all items run; its body begins with who has left."""
        variable, step = statement.variable, statement.step
        start, stop = self.expression(statement.start), self.expression(statement.stop)
        if not varies(self.names, start):
            counter = self._counter(variable, body)
            if not varies(self.names, stop):
                return For(counter, start, stop, step, ())
            repeated = For(counter, start, integer(_ENDLESS if step > 0 else -_ENDLESS), step, ())
            end = self.guards.named("last", stop)
        else:
            end = self.guards.named("last", stop)
            first, count = self.guards.named("first", start), self.guards.fresh("step", INT, is_shared=True)
            repeated = For(count, integer(0), integer(_ENDLESS), 1, ())
            body.append(Assign(variable, Binary("+", first, Binary("*", integer(step), count, INT), INT)))
        condition = Binary("<" if step > 0 else ">", variable, end, BOOL)
        body.append(Assign(inside, both(inside, condition)))
        return repeated

    def _counter(self, variable: Variable, body: list[Statement]) -> Variable:
        """What counts steps that all items share: another, where a loop of the same name has steps that differ."""
        if variable.name not in self.names:
            return variable
        count = self.guards.fresh("step", INT, is_shared=True)
        body.append(Assign(variable, count))
        return count

    def _common_loop(self, statement: For | While, known: set[str]) -> None:
        self.loops.append(ParallelLoop(None, len(self.regions)))
        if isinstance(statement, For):
            start, stop = self.expression(statement.start), self.expression(statement.stop)
            begin: list[Statement] = []
            counter = self._counter(statement.variable, begin)
            body = self._inner(statement.body, {*known, statement.variable.name})
            self.out.append(For(counter, start, stop, statement.step, (*begin, *body)))
        else:
            self.out.append(While(statement.condition, self._inner(statement.body, known)))
        self.loops.pop()

    # -- jumps -------------------------------------------------------------------------------------------------------

    def _remove(self, depth: int, inside: Sequence[Variable | None] = ()) -> None:
        """Items that are meant here leave the places from a depth on, this one last."""
        here = self.mask
        assert here is not None
        masks = [r.mask for r in self.regions[depth:-1]] + list(inside)
        for mask in dict.fromkeys(m for m in masks if m is not None and m != here):
            self.out.append(Assign(mask, but_not(mask, here)))
        self.out.append(Assign(here, boolean(False)))

    def _break(self) -> None:
        loop = self.loops[-1]
        if loop.inside is None:
            self.out.append(Break())
        elif len(self.regions) - 1 == loop.depth:
            if self.mask == loop.inside:
                self.out.append(Break())
            else:
                self._remove(loop.depth, [loop.inside])
                self.out.append(Continue())
        else:
            self._remove(loop.depth, [loop.inside])

    def _continue(self) -> None:
        loop = self.loops[-1]
        if loop.inside is None or len(self.regions) - 1 == loop.depth:
            self.out.append(Continue())
        else:
            self._remove(loop.depth)

    def _return(self, values: tuple[Expression, ...]) -> None:
        if not self.paths.has_divergent_return:
            self.out.append(Return(values))
            return
        for result, value in zip(self.results, values, strict=True):
            self.out.append(Assign(result, self.blend(value, result)))
        if len(self.regions) == 1:
            self.out.append(Return(tuple(self.results)))
        else:
            self._remove(0, [loop.inside for loop in self.loops])


def _jumps(body: Sequence[Statement]) -> list[Statement]:
    """Jumps of the loop around some statements, and returns."""
    found: list[Statement] = []
    for each in body:
        if isinstance(each, (For, While)):
            found += [s for s in walk(each.body) if isinstance(s, Return)]
        elif isinstance(each, (Break, Continue, Return)):
            found.append(each)
        else:
            found += [s for block in blocks(each) for s in _jumps(block)]
    return found


def _leaves(statement: If) -> bool:
    return bool(_jumps((*statement.yes, *statement.no)))


def _continues(statement: For | While) -> bool:
    """Whether some items may go on with the next step before others."""
    return any(isinstance(s, Continue) for s in _jumps(statement.body))
