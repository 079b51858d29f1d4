"""Statements of a text that is to be reversed: what has its value from elsewhere, regions, and arrays as a whole."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from ..loops.nodes import (
    Allocate,
    Array,
    Assign,
    Call,
    For,
    If,
    Load,
    Statement,
    Store,
    Variable,
    View,
    While,
    integer,
    outputs,
    plus,
    real,
    walk,
)  # fmt: skip
from ..loops.scope import fresh_name
from ..loops.tangent import bound_by
from ..loops.types import INT


class PassedNumber(Assign):
    """The derivative of what has its value from elsewhere."""


class PassedElement(Store):
    """The same of an element."""


@dataclass(frozen=True)
class Region(If):
    """The text of a declared derivative: there, numbers of these names alone vary."""

    names: frozenset[str] = frozenset()


def copy(
    target: View, source: View, size: int, taken: set[str], store: Callable[..., Store] = Store
) -> list[Statement]:
    """Statements that copy all numbers of an array."""
    if not size:
        return []
    k = Variable(fresh_name("k", taken), INT)
    value = Load(source.array, plus(source.offset, k))
    return [For(k, integer(0), integer(size), 1, (store(target.array, plus(target.offset, k), value),))]


def fill(target: View, size: int, taken: set[str]) -> list[Statement]:
    """Statements that make all numbers of an array zero."""
    k = Variable(fresh_name("k", taken), INT)
    zero = real(0.0) if target.array.type.scalar != INT else integer(0)
    return [For(k, integer(0), integer(size), 1, (Store(target.array, plus(target.offset, k), zero),))] if size else []


def written(body: Iterable[Statement]) -> tuple[set[str], dict[str, Array]]:
    """Names of the numbers, and arrays by name, that some statements change."""
    numbers: set[str] = set()
    arrays: dict[str, Array] = {}
    for s in walk(tuple(body)):
        match s:
            case PassedNumber() | PassedElement():
                continue
            case Store(array, _, _) | Allocate(array, _):
                arrays[array.name] = array
            case Call():
                arrays.update({v.array.name: v.array for v in outputs(s)})
                numbers |= bound_by(s)
            case _:
                numbers |= bound_by(s)
    return numbers, arrays


def has_forward(body: Sequence[Statement]) -> bool:
    """Whether a block has anything to do in the forward sweep."""
    return not body or any(not isinstance(s, (PassedNumber, PassedElement)) for s in walk(tuple(body)))


def without_marks(s: Statement) -> Statement:
    """A statement without what the forward sweep leaves out."""

    def plain(body: Sequence[Statement]) -> tuple[Statement, ...]:
        kept = (b for b in body if not isinstance(b, (PassedNumber, PassedElement, Allocate)))
        return tuple(map(without_marks, kept))

    if isinstance(s, (For, While)):
        return replace(s, body=plain(s.body))
    if isinstance(s, If):
        return If(s.condition, plain(s.yes), plain(s.no))
    return s
