"""What the forward sweep keeps of values that it replaces, for the reverse sweep: last in, first out."""

from __future__ import annotations

from dataclasses import dataclass

from ..loops.nodes import (
    Allocate,
    Array,
    Assign,
    Binary,
    Expression,
    For,
    Load,
    Select,
    Statement,
    Store,
    Variable,
    integer,
    plus,
)  # fmt: skip
from ..loops.scope import fresh_name
from ..loops.types import BOOL, INT, REAL, ArrayType, Scalar


@dataclass(frozen=True)
class Room:
    """Numbers that are kept: real ones, and integers."""

    reals: int = 0
    integers: int = 0

    def __add__(self, other: Room) -> Room:
        return Room(self.reals + other.reals, self.integers + other.integers)

    def times(self, count: int) -> Room:
        """So much several times."""
        return Room(self.reals * count, self.integers * count)

    def either(self, other: Room) -> Room:
        """Enough for one or the other."""
        return Room(max(self.reals, other.reals), max(self.integers, other.integers))

    @property
    def total(self) -> int:
        return self.reals + self.integers


#: Statements of the forward sweep, those of the reverse sweep that undo them, and what is kept meanwhile.
Kept = tuple[list[Statement], list[Statement], Room]


class Tape:
    """Two stacks, of real numbers and of integers.

    Parameters
    ----------
    taken : set of str
        Names that there are.
    """

    def __init__(self, taken: set[str]) -> None:
        self.taken = taken
        self.names = {t: fresh_name(f"kept_{stem}", taken) for t, stem in ((REAL, "reals"), (INT, "integers"))}
        self.tops = {t: Variable(fresh_name(f"{self.names[t]}_top", taken), INT) for t in (REAL, INT)}

    def _array(self, scalar: Scalar) -> Array:
        return Array(self.names[scalar], ArrayType(scalar, (1,)), is_local=True)

    def allocated(self, room: Room) -> list[Statement]:
        """Statements that begin the stacks that are needed."""
        body: list[Statement] = []
        for scalar, size in ((REAL, room.reals), (INT, room.integers)):
            if size:
                stack = Array(self.names[scalar], ArrayType(scalar, (size,)), is_local=True)
                body += [Allocate(stack, False), Assign(self.tops[scalar], integer(0))]
        return body

    def number(self, variable: Variable) -> Kept:
        """Keep a number."""
        scalar = REAL if variable.type == REAL else INT
        top = self.tops[scalar]
        value: Expression = Load(self._array(scalar), top)
        kept: Expression = variable
        if variable.type == BOOL:
            kept = Select(variable, integer(1), integer(0), INT)
            value = Binary("!=", value, integer(0), BOOL)
        return (
            [Store(self._array(scalar), top, kept), _move(top, 1)],
            [_move(top, -1), Assign(variable, value)],
            _room(scalar, 1),
        )

    def elements(self, array: Array, offset: Expression, size: int) -> Kept:
        """Keep some elements of an array."""
        scalar = array.type.scalar
        top, tape = self.tops[scalar], self._array(scalar)
        if size == 1:
            put: Statement = Store(tape, top, Load(array, offset))
            take: Statement = Store(array, offset, Load(tape, top))
        else:
            k = Variable(fresh_name("k", self.taken), INT)
            here, there = plus(top, k), plus(offset, k)
            put = For(k, integer(0), integer(size), 1, (Store(tape, here, Load(array, there)),))
            take = For(k, integer(0), integer(size), 1, (Store(array, there, Load(tape, here)),))
        return [put, _move(top, size)], [_move(top, -size), take], _room(scalar, size)


def _move(top: Variable, by: int) -> Assign:
    return Assign(top, Binary("+" if by > 0 else "-", top, integer(abs(by)), INT))


def _room(scalar: Scalar, size: int) -> Room:
    return Room(reals=size) if scalar == REAL else Room(integers=size)
