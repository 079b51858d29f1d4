"""What varies in a text, what keeps its value, and how often loops run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence

from ..loops.nodes import (
    Assign,
    Binary,
    Break,
    Call,
    Constant,
    Expression,
    For,
    If,
    Intrinsic,
    KernelSignature,
    Load,
    Select,
    Statement,
    Store,
    Unary,
    Variable,
    View,
    While,
    blocks,
    names_in,
    parts,
    walk,
)  # fmt: skip
from ..loops.tangent import bound_by, sources
from ..loops.types import BOOL, INT, REAL
from .statements import PassedNumber, Region, written

Interval = tuple[int | None, int | None]
_UNKNOWN: Interval = (None, None)


# -- what varies -----------------------------------------------------------------------------------------------------


def varying_names(body: Iterable[Statement], wrt: Collection[str], results: Collection[str]) -> set[str]:
    """Numbers and arrays through which results depend on what is varied."""
    edges = list(_edges(body, None))
    varies = _closure(set(wrt), edges)
    return varies & _closure(set(results), [(sources, targets) for targets, sources in edges])


def _closure(found: set[str], edges: Sequence[tuple[set[str], set[str]]]) -> set[str]:
    """Names that others lead to. ``edges``: names, and those that lead to them."""
    while True:
        before = len(found)
        for targets, origins in edges:
            if not found.isdisjoint(origins):
                found |= targets
        if len(found) == before:
            return found


def _edges(body: Iterable[Statement], visible: frozenset[str] | None) -> Iterator[tuple[set[str], set[str]]]:
    """What each statement assigns to, and what that varies with."""

    def seen(names: set[str]) -> set[str]:
        return names if visible is None else names & visible

    for s in body:
        match s:
            case Assign(target, value) if target.type == REAL:
                yield seen({target.name}), seen(sources(value))
            case Store(array, _, value) if array.type.scalar == REAL:
                yield seen({array.name}), seen(sources(value))
            case Call(KernelSignature() as kernel, arguments, _):
                views = [a for a in arguments if isinstance(a, View)]
                count = len(kernel.outputs)
                inputs = {v.array.name for v in views[count:] if not v.is_still}
                yield seen({v.array.name for v in views[:count]}), seen(inputs)
            case Region():
                yield from _edges(s.yes, s.names)
            case _:
                for block in blocks(s):
                    yield from _edges(block, visible)


# -- what keeps its value ----------------------------------------------------------------------------------------------


class Stable:
    """Numbers that have one value wherever they are read, or are computed anew from such.

    Attributes
    ----------
    kept : set of str
        Those that are assigned once in the whole run.
    computed : set of str
        Those that each step of a loop computes from what counts loops and from what keeps its value.
    """

    def __init__(self, body: Sequence[Statement], parameters: Collection[str]) -> None:
        self.counts = Counter([*parameters, *(name for s in walk(tuple(body)) for name in _assigned(s))])
        self.arrays = set(written(body)[1])
        self.kept = {name for name in parameters if self.counts[name] == 1}
        self.computed: set[str] = set()
        self.loops = {s.variable.name for s in walk(tuple(body)) if isinstance(s, For)}
        self._read(body)

    def _read(self, body: Iterable[Statement], is_repeated: bool = False) -> None:
        for s in body:
            once = [name for name in _assigned(s) if self.counts[name] == 1]
            if not is_repeated:
                self.kept.update(once)
            elif isinstance(s, Assign) and once and self.is_stable(s.value):
                self.computed.update(once)
            for block in blocks(s):
                self._read(block, is_repeated or isinstance(s, (For, While)))

    def is_stable(self, expression: Expression) -> bool:
        """Whether an expression has the same value in the reverse sweep."""
        for p in parts(expression):
            if isinstance(p, Variable) and not self.is_stable_name(p.name):
                return False
            if isinstance(p, Load) and p.array.name in self.arrays:
                return False
        return True

    def is_stable_name(self, name: str) -> bool:
        """Whether a number has."""
        return name in self.loops or name in self.kept or name in self.computed or not self.counts[name]


def _assigned(statement: Statement) -> set[str]:
    if isinstance(statement, (For, PassedNumber)):
        return set()
    return bound_by(statement)


# -- how often loops run -----------------------------------------------------------------------------------------------


class Bounds:
    """Bounds of the integers of a text, where they are seen."""

    def __init__(self, body: Sequence[Statement], parameters: Collection[str]) -> None:
        self.values: dict[str, list[Expression]] = {}
        self.conditions: dict[str, list[Expression]] = {}
        self.loops: dict[str, list[For]] = {}
        self.unknown = set(parameters)
        self.asked: set[str] = set()
        for s in walk(tuple(body)):
            if isinstance(s, Assign) and s.target.type == INT:
                self.values.setdefault(s.target.name, []).append(s.value)
            elif isinstance(s, Assign) and s.target.type == BOOL:
                self.conditions.setdefault(s.target.name, []).append(s.value)
            elif isinstance(s, For):
                self.loops.setdefault(s.variable.name, []).append(s)
            elif isinstance(s, Call):
                self.unknown |= {r.name for r in s.results}

    def steps(self, loop: For | While) -> int | None:
        """The most steps of a loop."""
        if isinstance(loop, While):
            return self._steps_of_while(loop)
        match loop.stop:
            case Binary("+" | "-" as operator, left, Constant(value, _), _) if left == loop.start:
                distance = int(value) if (operator == "+") == (loop.step > 0) else -int(value)
                return max(0, -(-distance // abs(loop.step)))
        start, stop = self.interval(loop.start), self.interval(loop.stop)
        first, last = (start[0], stop[1]) if loop.step > 0 else (stop[0], start[1])
        return None if first is None or last is None else max(0, -(-(last - first) // abs(loop.step)))

    def _steps_of_while(self, loop: While) -> int | None:
        """Of one that counts: ``while k < n and ...`` with ``k += 1`` in every step, and no other change of k."""
        found = [n for c in _conjuncts(loop.condition) if (n := self._steps_of_condition(c, loop)) is not None]
        return min(found, default=None)

    def _steps_of_condition(self, condition: Expression, loop: While) -> int | None:
        match condition:
            case Binary("<" | "<=" as operator, Variable(name, type), limit, _) if type == INT:
                changes = [s for s in walk(loop.body) if isinstance(s, Assign) and s.target.name == name]
                first, last = self._of_name(name)[0], self.interval(limit)[1]
                if name in self.loops or len(changes) != 1:
                    return None
                by = _increment(name, changes[0].value) if self._is_in_every_step(changes[0], loop.body) else 0
                if last is None or first is None or by <= 0:
                    return None
                return max(0, -(-(last + (operator == "<=") - first) // by))
        return None

    def _is_in_every_step(self, change: Statement, body: Sequence[Statement], ends: Collection[str] = ()) -> bool:
        """Whether a statement is run in every step but one that leaves the loop. ``ends``: flags of such."""
        match body[-1] if body else None:
            case If(condition, (Break(),), _):
                ends = names_in(condition)
        for s in body:
            if s is change:
                return True
            if isinstance(s, If) and not s.no and self._is_end(s.condition, ends):
                return self._is_in_every_step(change, s.yes, ends)
        return False

    def _is_end(self, condition: Expression, ends: Collection[str]) -> bool:
        """Whether a condition holds unless the loop is left."""
        if isinstance(condition, Variable) and len(self.conditions.get(condition.name, ())) == 1:
            condition = self.conditions[condition.name][0]
        return isinstance(condition, Unary) and bool(ends) and names_in(condition.operand) <= set(ends)

    def interval(self, expression: Expression) -> Interval:
        """The least and the greatest value; None: not known."""
        match expression:
            case Constant(value, _):
                return int(value), int(value)
            case Variable(name, _):
                return self._of_name(name)
            case Unary("-", operand, _):
                low, high = self.interval(operand)
                return None if high is None else -high, None if low is None else -low
            case Binary("+" | "-" as operator, left, right, _):
                (a, b), (c, d) = self.interval(left), self.interval(right)
                c, d = (c, d) if operator == "+" else (None if d is None else -d, None if c is None else -c)
                return None if a is None or c is None else a + c, None if b is None or d is None else b + d
            case Binary("*", left, right, _):
                a, b, c, d = *self.interval(left), *self.interval(right)
                if a is None or b is None or c is None or d is None:
                    return _UNKNOWN
                products = (a * c, a * d, b * c, b * d)
                return min(products), max(products)
            case Binary("//", left, Constant(value, _), _) if value > 0:
                low, high = self.interval(left)
                return None if low is None else low // int(value), None if high is None else high // int(value)
            case Binary("%", _, Constant(value, _), _) if value > 0:
                return 0, int(value) - 1
            case Intrinsic("imin" | "imax" as name, (left, right), _):
                (a, b), (c, d) = self.interval(left), self.interval(right)
                choose = min if name == "imin" else max
                lows, highs = [x for x in (a, c) if x is not None], [x for x in (b, d) if x is not None]
                low = choose(lows) if len(lows) == 2 or (name == "imax" and lows) else None
                high = choose(highs) if len(highs) == 2 or (name == "imin" and highs) else None
                return low, high
            case Select(_, yes, no, _):
                return _union([self.interval(yes), self.interval(no)])
            case _:
                return _UNKNOWN

    def _of_name(self, name: str) -> Interval:
        if name in self.asked or name in self.unknown or not (name in self.values or name in self.loops):
            return _UNKNOWN
        self.asked.add(name)
        try:
            values = self.values.get(name, ())
            found = [self.interval(v) for v in values if not _increment(name, v)]
            steps = {_increment(name, v) > 0 for v in values if _increment(name, v)}
            for loop in self.loops.get(name, ()):
                (a, b), (c, d) = self.interval(loop.start), self.interval(loop.stop)
                up = loop.step > 0
                low, high = (a, None if d is None else d - 1) if up else (None if c is None else c + 1, b)
                found.append((low, high))
            low, high = _union(found)
            return None if False in steps else low, None if True in steps else high
        finally:
            self.asked.remove(name)


def _union(found: Sequence[Interval]) -> Interval:
    lows, highs = [low for low, _ in found], [high for _, high in found]
    low = None if None in lows or not lows else min(x for x in lows if x is not None)
    high = None if None in highs or not highs else max(x for x in highs if x is not None)
    return low, high


def _conjuncts(condition: Expression) -> list[Expression]:
    if isinstance(condition, Binary) and condition.operator == "and":
        return [*_conjuncts(condition.left), *_conjuncts(condition.right)]
    return [condition]


def _increment(name: str, value: Expression) -> int:
    """By how much a value is more than the integer of a name; 0: it is something else."""
    match value:
        case Binary("+" | "-" as operator, Variable(other, _), Constant(by, _), _) if other == name:
            return int(by) if operator == "+" else -int(by)
    return 0
