"""The forward sweep of a text, which keeps what it replaces, and the reverse sweep, which adds up cotangents.

What is kept is what cotangents of earlier statements need ("to be recorded", Hascoët and Pascual 2013), and of loops
without cotangents what they change as a whole. Numbers that a step of a loop can compute anew are not kept.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from ...errors import AlgorithmError
from ..loops.nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
    Call,
    Expression,
    For,
    If,
    KernelSignature,
    Load,
    Statement,
    Store,
    Variable,
    View,
    While,
    assigned_variables,
    expressions,
    integer,
    names_in,
    outputs,
    walk,
)  # fmt: skip
from ..loops.scope import fresh_name
from ..loops.types import INT
from .analysis import Bounds, Stable
from .kernels import KernelCalls
from .partials import Cotangents
from .statements import PassedElement, PassedNumber, Region, has_forward, without_marks, written
from .steps import backward_loop, end_of_steps
from .tape import Kept, Room, Tape


@dataclass(frozen=True)
class Swept:
    """Both sweeps of some statements, and what is kept between them."""

    forward: tuple[Statement, ...] = ()
    backward: tuple[Statement, ...] = ()
    room: Room = Room()


@dataclass(frozen=True)
class _Adjoint:
    """What adds up the cotangents of one statement, and the numbers and arrays that this reads."""

    body: tuple[Statement, ...]
    reads: frozenset[str]
    statement: Statement  # held, since it is found by its id


class Sweeper:
    """One text.

    Parameters
    ----------
    cotangents : Cotangents
    stable : Stable
    bounds : Bounds
    tape : Tape
    where : str
        Of the algorithm, for errors.
    """

    def __init__(self, cotangents: Cotangents, stable: Stable, bounds: Bounds, tape: Tape, where: str) -> None:
        self.cotangents, self.stable, self.bounds, self.tape, self.where = cotangents, stable, bounds, tape, where
        self.visible = cotangents.active
        self.kernels = KernelCalls(cotangents, where)
        self.kept: set[str] = set()  # numbers and arrays that are kept somewhere
        self._adjoints: dict[int, _Adjoint] = {}
        self._counts: dict[int, tuple[Assign, Statement]] = {}

    # -- blocks ------------------------------------------------------------------------------------------------------

    def block(self, body: Sequence[Statement], required: set[str]) -> Swept:
        """Both sweeps of a block.

        Parameters
        ----------
        body : sequence of statements
        required : set of str
            Numbers and arrays whose values the reverse sweep needs as they are now; those of the end, afterwards.
        """
        forward: list[Statement] = []
        backward: list[Statement] = []
        room = Room()
        for s in body:
            swept = self._statement(s, required)
            forward += swept.forward
            backward = [*swept.backward, *backward]
            room += swept.room
        anew = [s for s in body if isinstance(s, Assign) and s.target.name in self.stable.computed]
        return Swept(tuple(forward), (*anew, *backward) if backward else (), room)

    def _statement(self, s: Statement, required: set[str]) -> Swept:
        match s:
            case PassedNumber() | PassedElement():
                return self._simple(s, [], [], required)
            case Allocate():
                return Swept()
            case Assign(target, _):
                return self._simple(s, [target], [], required)
            case Store(array, index, _):
                return self._simple(s, [], [(array, index, 1)], required)
            case Call():
                parts = []
                for v in outputs(s):
                    is_whole = v.type.is_open
                    parts.append((v.array, integer(0) if is_whole else v.offset,
                                  v.array.type.size if is_whole else v.type.size))  # fmt: skip
                return self._simple(s, s.results, parts, required)
            case Region():
                outside, self.visible = self.visible, self.cotangents.active & s.names
                swept = self.block(s.yes, required)
                self.visible = outside
                return swept
            case If():
                return self._if(s, required)
            case For() | While():
                return self._loop(s, required)
            case _:
                return Swept((s,))

    def _simple(
        self, s: Statement, numbers: Sequence[Variable], parts: Sequence[tuple[Array, Expression, int]],
        required: set[str],
    ) -> Swept:  # fmt: skip
        """A statement without blocks, the numbers that it assigns to, and the parts of arrays that it changes."""
        adjoint = self._adjoint(s)
        required |= adjoint.reads
        kept: list[Kept] = []
        for v in numbers:
            if v.name in required and not self.stable.is_stable_name(v.name):
                self.kept.add(v.name)
                if (undone := self._undone(s)) is not None:
                    kept.append(([], [undone], Room()))
                    continue
                kept.append(self.tape.number(v))
            required.discard(v.name)
        for array, offset, size in parts:
            if array.name in required:
                kept.append(self.tape.elements(array, offset, size))
                self.kept.add(array.name)
                required |= names_in(offset)
        forward = [] if isinstance(s, (PassedNumber, PassedElement)) else [s]
        return _around(kept, Swept(tuple(forward), adjoint.body))

    def _undone(self, s: Statement) -> Statement | None:
        """What takes a step of a counter back."""
        match s:
            case Assign(target, Binary("+" | "-" as operator, left, right, type)) if type == INT and left == target:
                if self.stable.is_stable(right):
                    return Assign(target, Binary("-" if operator == "+" else "+", target, right, INT))
        return None

    def _if(self, s: If, required: set[str]) -> Swept:
        other = set(required)
        yes, no = self.block(s.yes, required), self.block(s.no, other)
        required |= other
        backward: tuple[Statement, ...] = ()
        if yes.backward or no.backward:
            required |= names_in(s.condition)
            backward = (If(s.condition, yes.backward, no.backward),)
        return Swept((If(s.condition, yes.forward, no.forward),), backward, yes.room.either(no.room))

    # -- loops -------------------------------------------------------------------------------------------------------

    def _loop(self, s: For | While, required: set[str]) -> Swept:
        """Step by step, or where it has no cotangents, and that keeps less, as a whole."""
        if self.bounds.steps(s) == 0:
            return Swept()
        if not has_forward(s.body):
            return self._passed_loop(s, required)
        is_whole = not self._has_cotangents(s.body)
        whole: Swept | None = None
        if is_whole:
            after = set(required)
            names = set(self.kept)
            whole = self._as_a_whole(s, after)
            steps = self.bounds.steps(s)
            if not whole.backward or steps is None or whole.room.total <= 2 * steps:
                required.clear()
                required |= after
                return whole
            self.kept = names
        return self._steps(s, required)

    def _passed_loop(self, s: For | While, required: set[str]) -> Swept:
        assert isinstance(s, For)
        swept = self.block(s.body, required)
        return Swept((), (replace(s, body=swept.backward),) if swept.backward else ())

    def _as_a_whole(self, s: Statement, required: set[str]) -> Swept:
        numbers, arrays = written((s,))
        kept: list[Kept] = []
        types = {v.name: v for v in assigned_variables((s,))}
        for name in sorted(numbers & required):
            if name in types and not self.stable.is_stable_name(name):
                kept.append(self.tape.number(types[name]))
                self.kept.add(name)
        for name in sorted(arrays.keys() & required):
            kept.append(self.tape.elements(arrays[name], integer(0), arrays[name].type.size))
            self.kept.add(name)
        required -= numbers | arrays.keys()
        return _around(kept, Swept((without_marks(s),)))

    def _steps(self, s: For | While, required: set[str]) -> Swept:
        ends, body = end_of_steps(s.body)
        count: Variable | None = None
        before = Swept()
        if ends or isinstance(s, While):
            begin, counted = self._count(s)
            count = begin.target
            before = self._simple(begin, [count], [], required)
        while True:
            inside = set(required)
            swept = self.block(body, inside)
            if inside <= required:
                break
            required |= inside
        steps = self.bounds.steps(s)
        if steps is None and swept.room.total:
            raise AlgorithmError(
                "a reverse derivative keeps numbers of each step of this loop, of which there may be any number",
                where=s.where or self.where,
                remedy="Bound it, such as for _ in range(min(n, 100)) with a break, or use derivative(...)",
            )  # fmt: skip
        if not swept.backward:
            count = None
            before = Swept()
        head = (counted,) if count else ()
        forward = (*before.forward, replace(s, body=(*head, *swept.forward, *ends)))
        backward: tuple[Statement, ...] = ()
        if swept.backward:
            backward = (backward_loop(s, count, swept.backward, self.cotangents.taken), *before.backward)
            read = {count.name} if count else set()
            if isinstance(s, For):
                read |= names_in(s.start) | (set() if count else names_in(s.stop))
            required |= read
        return Swept(forward, backward, before.room + swept.room.times(steps or 0))

    def _count(self, s: Statement) -> tuple[Assign, Statement]:
        """What counts the steps of a loop whose end is not known before."""
        if id(s) not in self._counts:
            name = Variable(fresh_name("steps", self.cotangents.taken), INT)
            self.stable.counts[name.name] = 2
            self._counts[id(s)] = Assign(name, integer(0)), Assign(name, Binary("+", name, integer(1), INT))
        return self._counts[id(s)]

    def _has_cotangents(self, body: Sequence[Statement]) -> bool:
        """Whether any statement adds up cotangents."""
        found = False
        for s in body:
            if isinstance(s, Region):
                outside, self.visible = self.visible, self.cotangents.active & s.names
                found |= self._has_cotangents(s.yes)
                self.visible = outside
            elif isinstance(s, If):
                found |= self._has_cotangents(s.yes) or self._has_cotangents(s.no)
            elif isinstance(s, (For, While)):
                found |= self._has_cotangents(s.body)
            else:
                found |= bool(self._adjoint(s).body)
        return found

    # -- cotangents of one statement ---------------------------------------------------------------------------------

    def _adjoint(self, s: Statement) -> _Adjoint:
        if id(s) not in self._adjoints:
            body, reads = self._cotangents(s)
            asked = {n for t in walk(tuple(body)) for e in _asked(t) for n in names_in(e)} | reads
            own = {v.name for v in self.cotangents.numbers.values()} | {a.name for a in self.cotangents.arrays.values()}
            made = {n for t in walk(tuple(body)) if isinstance(t, (Assign, For)) for n in _made(t)}
            rows = {a.array.name for a in self.kernels.rows}
            self._adjoints[id(s)] = _Adjoint(tuple(body), frozenset(asked - own - made - rows), s)
        return self._adjoints[id(s)]

    def _cotangents(self, s: Statement) -> tuple[list[Statement], set[str]]:
        match s:
            case Assign(target, value) if target.name in self.visible:
                return self._assigned(target, value), set()
            case Store(array, index, value) if array.name in self.visible:
                return self._assigned(Load(array, index), value), set()
            case Call(KernelSignature(), _, _):
                return self.kernels.spread(s, self.visible)
            case Call(_, _, results):
                return [
                    n for r in results if r.name in self.visible for n in self.cotangents.taken_from(r)[1][1:]
                ], set()
        return [], set()

    def _assigned(self, target: Variable | Load, value: Expression) -> list[Statement]:
        share, body = self.cotangents.taken_from(target)
        added = self.cotangents.spread(value, share, self.visible)
        return [*body, *added] if added else body[1:]


def _around(kept: Sequence[Kept], inner: Swept) -> Swept:
    """What is kept before some statements, and put back before their cotangents are."""
    forward = [s for put, _, _ in kept for s in put]
    backward = [s for _, take, _ in reversed(kept) for s in take]
    room = inner.room
    for each in kept:
        room += each[2]
    return Swept((*forward, *inner.forward), (*backward, *inner.backward), room)


def _asked(statement: Statement) -> Iterable[Expression]:
    """What a statement of the reverse sweep reads; inputs of kernels are told apart."""
    if isinstance(statement, Call):
        return [a.offset for a in statement.arguments if isinstance(a, View)]
    return expressions(statement)


def _made(statement: Assign | For) -> set[str]:
    return {statement.target.name if isinstance(statement, Assign) else statement.variable.name}
