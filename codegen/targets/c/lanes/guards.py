"""Expressions on several items of which only some are meant: what the others have is computed, and not looked at.

Elements of arrays are read for no item that is not meant: an index is zero for it, and a part of an expression that a
condition guards is computed only where the condition holds for any.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

from ....ir.loops.nodes import (
    Assign,
    Binary,
    Constant,
    Expression,
    If,
    Intrinsic,
    Load,
    Select,
    Statement,
    Unary,
    Variable,
    boolean,
    integer,
    names_in,
    parts,
    real,
)  # fmt: skip
from ....ir.loops.types import BOOL, INT, REAL, Scalar
from .paths import varies

#: The items that are meant; None: all.
Mask = Variable | None


def any_of(mask: Expression) -> Expression:
    """Whether a condition holds for any item."""
    return Intrinsic("any", (mask,), BOOL)


def both(mask: Mask, condition: Expression) -> Expression:
    """A condition of the items that are meant."""
    return condition if mask is None else Binary("and", mask, condition, BOOL)


def but_not(mask: Mask, condition: Expression) -> Expression:
    """The items that are meant, without those of a condition."""
    return both(mask, Unary("not", condition, BOOL))


def zero(type: Scalar) -> Constant:
    """What a number begins with that only some items assign."""
    return {REAL: real(0.0), INT: integer(0), BOOL: boolean(False)}[type]


class Guards:
    """Turns expressions into those of several items.

    Parameters
    ----------
    names : set of str
        What differs between items; new numbers are added.
    emit : callable
        Takes the statements that come before.
    taken : collection of str
        Names that are not new.
    """

    def __init__(self, names: set[str], emit: Callable[[Statement], None], taken: Collection[str]) -> None:
        self.names, self._emit, self._taken, self._count = names, emit, set(taken), 0

    def fresh(self, prefix: str, type: Scalar, is_shared: bool = False) -> Variable:
        """A new number."""
        while (name := f"{prefix}{self._count}_") in self._taken:
            self._count += 1
        self._count += 1
        if not is_shared:
            self.names.add(name)
        return Variable(name, type)

    def named(self, prefix: str, value: Expression) -> Variable:
        """A new number with a value."""
        found = self.fresh(prefix, value.type)
        self._emit(Assign(found, value))
        return found

    def mask_expression(self, expression: Expression, mask: Mask) -> Expression:
        """An expression, of the items that are meant."""
        match expression:
            case Load(array, index):
                return Load(array, self.index(index, mask))
            case Unary(_, operand, _):
                return replace(expression, operand=self.mask_expression(operand, mask))
            case Binary("and" | "or" as operator, left, right, _) if varies(self.names, expression):
                first = self.mask_expression(left, mask)
                if not self._is_guarded(right, left):
                    return replace(expression, left=first, right=self.mask_expression(right, mask))
                found = self.named("holds", first)
                asked = both(mask, found) if operator == "and" else but_not(mask, found)
                self._emit_guarded(asked, right, lambda value: Assign(found, Binary(operator, found, value, BOOL)))
                return found
            case Binary(_, left, right, _):
                first, second = (self.mask_expression(each, mask) for each in (left, right))
                return replace(expression, left=first, right=second)
            case Select(condition, yes, no, type) if not varies(self.names, condition):
                return self._shared_select(expression, mask)
            case Select(condition, yes, no, type):
                if not (self._is_guarded(yes, condition) or self._is_guarded(no, condition)):
                    return self._select(expression, mask)
                decides = self.named("holds", self.mask_expression(condition, mask))
                found = self.named("chosen", zero(type))
                self._emit_guarded(both(mask, decides), yes, lambda value: Assign(found, value))
                self._emit_guarded(
                    but_not(mask, decides), no, lambda value: Assign(found, Select(decides, found, value, type))
                )
                return found
            case Intrinsic("any", (condition,), _):
                return any_of(both(mask, self.mask_expression(condition, mask)))
            case Intrinsic(_, arguments, _):
                return replace(expression, arguments=tuple(self.mask_expression(a, mask) for a in arguments))
            case _:
                return expression

    def _select(self, select: Select, mask: Mask) -> Select:
        condition, yes, no = (self.mask_expression(each, mask) for each in (select.condition, select.yes, select.no))
        return Select(condition, yes, no, select.type)

    def _shared_select(self, select: Select, mask: Mask) -> Expression:
        """Of a condition that all items share, of which only one side is computed."""
        emit, sides = self._emit, []
        condition = self.mask_expression(select.condition, mask)
        for side in (select.yes, select.no):
            before: list[Statement] = []
            self._emit = before.append
            sides.append((before, self.mask_expression(side, mask)))
            self._emit = emit
        if not any(before for before, _ in sides):
            return Select(condition, sides[0][1], sides[1][1], select.type)
        found = self.named("chosen", zero(select.type))
        yes, no = ((*before, Assign(found, value)) for before, value in sides)
        emit(If(condition, yes, no))
        return found

    def index(self, index: Expression, mask: Mask) -> Expression:
        """An index, which is zero for items that are not meant."""
        found = self.mask_expression(index, mask)
        if mask is None or not varies(self.names, found):
            return found
        return Select(mask, found, integer(0), INT)

    def is_safe(self, expression: Expression, guard: Expression) -> bool:
        """Whether an expression may be computed where a condition does not hold."""
        return not self._is_guarded(expression, guard)

    def _is_guarded(self, expression: Expression, guard: Expression) -> bool:
        found = [p for p in parts(expression) if isinstance(p, Load)]
        guarding = names_in(guard)
        return any(
            varies(self.names, load.index)
            or any(isinstance(p, Load) for p in parts(load.index))
            or bool(names_in(load.index) & guarding)
            for load in found
        )

    def _emit_guarded(self, asked: Expression, value: Expression, assign: Callable[[Expression], Statement]) -> None:
        emit, found = self._emit, list[Statement]()
        mask = self.named("asked", asked)
        self._emit = found.append
        found.append(assign(self.mask_expression(value, mask)))
        self._emit = emit
        emit(If(any_of(mask), tuple(found)))
