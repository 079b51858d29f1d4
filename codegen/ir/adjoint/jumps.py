"""Algorithms without jumps: what `break`, `continue` and `return` leave out stands behind conditions.

One jump is left, as the last statement of a loop, ``if left: break``: it takes as many steps as the text.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

from ..loops.nodes import (
    Assign,
    Binary,
    Break,
    Continue,
    Expression,
    For,
    Function,
    If,
    Return,
    Statement,
    Store,
    Unary,
    Variable,
    While,
    boolean,
)  # fmt: skip
from ..loops.scope import fresh_name
from ..loops.tangent import names_of
from ..loops.types import BOOL


def without_jumps(function: Function) -> tuple[tuple[Statement, ...], tuple[Expression, ...]]:
    """The statements of an algorithm, and behind them what it returns."""
    *before, last = function.body or (Return(()),)
    if isinstance(last, Return) and "return" not in _jumps(before):
        return _Reader(function).read(before), last.values
    reader = _Reader(function)
    return reader.read(function.body), tuple(reader.values)


def without_assignments(body: Iterable[Statement], names: Collection[str]) -> tuple[Statement, ...]:
    """Statements without those that assign to some numbers or elements, and without what is empty then."""
    found: list[Statement] = []
    for s in body:
        if (isinstance(s, Assign) and s.target.name in names) or (isinstance(s, Store) and s.array.name in names):
            continue
        if isinstance(s, (For, While)):
            s = replace(s, body=without_assignments(s.body, names))
            if isinstance(s, For) and not s.body:
                continue
        elif isinstance(s, If):
            s = replace(s, yes=without_assignments(s.yes, names), no=without_assignments(s.no, names))
            if not s.yes and not s.no:
                continue
        found.append(s)
    return tuple(found)


class _Reader:
    """One function: numbers for what it returns, and for jumps that were taken."""

    def __init__(self, function: Function) -> None:
        self.taken = names_of(function)
        self.flags: set[str] = set()
        self.asked: set[str] = set()
        self.returned = self._flag("returned")
        self.values = [Variable(fresh_name("value", self.taken), t) for t in function.results]
        self.loops: list[tuple[Variable, Variable]] = []  # whether a loop is left, and the rest of a step

    def _flag(self, stem: str) -> Variable:
        name = fresh_name(stem, self.taken)
        self.flags.add(name)
        return Variable(name, BOOL)

    def read(self, body: Sequence[Statement]) -> tuple[Statement, ...]:
        found = (Assign(self.returned, boolean(False)), *self._block(body))
        return without_assignments(found, self.flags - self.asked)

    def _block(self, body: Sequence[Statement]) -> tuple[Statement, ...]:
        found: list[Statement] = []
        for k, statement in enumerate(body):
            rest = body[k + 1 :]
            match statement:
                case Break():
                    found.append(Assign(self.loops[-1][0], boolean(True)))
                case Continue():
                    found.append(Assign(self.loops[-1][1], boolean(True)))
                case Return(values):
                    found += [Assign(v, e) for v, e in zip(self.values, values, strict=True)]
                    found.append(Assign(self.returned, boolean(True)))
                case If(condition, yes, no) if kinds := _jumps((statement,)):
                    if _leaves(yes):
                        return (*found, If(condition, self._block(yes), self._block((*no, *rest))))
                    if _leaves(no):
                        return (*found, If(condition, self._block((*yes, *rest)), self._block(no)))
                    found.append(If(condition, self._block(yes), self._block(no)))
                    return (*found, *self._guarded(kinds, rest))
                case If(condition, yes, no):  # where loops may be left
                    found.append(If(condition, self._block(yes), self._block(no)))
                case For() | While():
                    found += self._loop(statement)
                    if "return" in _jumps(statement.body):
                        return (*found, *self._guarded({"return"}, rest))
                case _:
                    found.append(statement)
        return tuple(found)

    def _guarded(self, kinds: set[str], rest: Sequence[Statement]) -> list[Statement]:
        """What is run unless there was a jump."""
        return [If(Unary("not", self._any(kinds), BOOL), self._block(rest))] if rest else []

    def _any(self, kinds: set[str]) -> Expression:
        flags = [self.returned] if "return" in kinds else []
        flags += [f for f, kind in zip(self.loops[-1] if self.loops else (), ("break", "continue"), strict=False)
                  if kind in kinds]  # fmt: skip
        self.asked |= {f.name for f in flags}
        found: Expression = flags[0]
        for each in flags[1:]:
            found = Binary("or", found, each, BOOL)
        return found

    def _loop(self, loop: For | While) -> list[Statement]:
        kinds = _jumps(loop.body)
        self.loops.append((self._flag("left"), self._flag("skipped")))
        body = self._block(loop.body)
        left, skipped = self.loops[-1]
        if "continue" in kinds:
            body = (Assign(skipped, boolean(False)), *body)
        if ends := kinds - {"continue"}:
            body = (*body, If(self._any(ends), (Break(),)))
        self.loops.pop()
        return [Assign(left, boolean(False)), replace(loop, body=body)]


def _jumps(body: Iterable[Statement]) -> set[str]:
    """Kinds of jumps out of a block."""
    found: set[str] = set()
    for s in body:
        match s:
            case Break() | Continue() | Return():
                found.add(type(s).__name__.lower())
            case If(_, yes, no):
                found |= _jumps(yes) | _jumps(no)
            case For() | While():
                found |= _jumps(s.body) & {"return"}
            case _:
                pass
    return found


def _leaves(body: Sequence[Statement]) -> bool:
    """Whether a block always ends with a jump."""
    last = body[-1] if body else None
    if isinstance(last, If):
        return _leaves(last.yes) and _leaves(last.no)
    return isinstance(last, (Break, Continue, Return))
