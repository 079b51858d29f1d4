"""What names mean at a place in an algorithm, and which of them are defined there."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from .nodes import Array, Count, Expression, Variable, View, integer


@dataclass(frozen=True)
class Static:
    """A value that is known when the text is printed."""

    value: Any


#: What an expression of the text means.
Meaning = Static | Expression | View | tuple[Any, ...]
Binding = Static | Variable | View


class Scope:
    """Bindings of names along the text.

    A name keeps its type and, for arrays, its storage through the whole function; whether it is defined is
    followed along the branches.
    """

    def __init__(self) -> None:
        self.defined: dict[str, Binding] = {}
        self.types: dict[str, Binding] = {}  # of every name that was bound anywhere so far
        self._taken: set[str] = set()

    def bind(self, name: str, binding: Binding) -> None:
        self.defined[name] = binding
        self.types.setdefault(name, binding)
        self._taken.add(name)

    def fresh(self, stem: str) -> str:
        """A name for the generated text that nothing else has."""
        return fresh_name(stem, self._taken)

    def reserve(self, names: Iterable[str]) -> None:
        """Names of the text, which no generated name may be."""
        self._taken.update(names)

    def branch(self) -> dict[str, Binding]:
        """The state, to go back to."""
        return dict(self.defined)

    def join(self, *states: dict[str, Binding] | None) -> None:
        """After branches: what all that come here define alike. None: a branch that does not come here."""
        reached = [s for s in states if s is not None]
        if not reached:
            return  # what follows is never run; it is read with the last state
        first, *others = reached
        self.defined = {n: b for n, b in first.items() if all(n in o and _alike(o[n], b) for o in others)}


def _alike(a: Binding, b: Binding) -> bool:
    if isinstance(a, Static) or isinstance(b, Static):
        return isinstance(a, Static) and isinstance(b, Static) and type(a.value) is type(b.value) and a.value == b.value
    return a == b


def fresh_name(stem: str, taken: set[str]) -> str:
    """A name that is not taken; it is then."""
    name, k = stem, 0
    while name in taken:
        k += 1
        name = f"{stem}{k}"
    taken.add(name)
    return name


def items_of(found: Meaning) -> tuple[Any, ...] | None:
    """The meanings in a tuple; None: it is not one."""
    if isinstance(found, Static) and isinstance(found.value, tuple):
        return tuple(Static(v) for v in found.value)
    return found if isinstance(found, tuple) else None


def bound_names(tree: ast.AST) -> dict[str, int]:
    """How often each name is bound in a part of the text."""
    counts: dict[str, int] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            counts[node.id] = counts.get(node.id, 0) + 1
        if isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name):
            counts[node.target.id] = counts.get(node.target.id, 0) + 1
    return counts


def whole(array: Array) -> View:
    """All of an array."""
    return View(array, integer(0), array.type, Count(array) if array.type.is_open else None)
