"""The ring of power series in time: formulas run on it become recurrences for Taylor coefficients.

Time-dependent values are truncated power series; constants stay scalars, and constant factors are pulled out of
products.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .protocol import Terms


@dataclass(frozen=True, eq=False)
class Item:
    """One value: a series if it depends on time (``moves``), else a number.

    ``level`` counts the convolutions on the way from the inputs.
    """

    number: int
    op: str
    args: tuple[Item, ...]
    data: Any
    moves: bool
    level: int


class SeriesRing:
    """Power series in time as the coefficients of multivectors; what is alike is made once."""

    is_symbolic = True

    def __init__(self) -> None:
        self.items: list[Item] = []
        self._known: dict[Any, Item] = {}
        self.zero = self.constant(Fraction(0))

    def _item(self, op: str, args: Sequence[Item], data: Any = None, moves: bool | None = None) -> Item:
        key = op, tuple(a.number for a in args), data
        if key not in self._known:
            moves = any(a.moves for a in args) if moves is None else moves
            level = max((a.level for a in args), default=0) + (op == "product")
            item = self._known[key] = Item(len(self.items), op, tuple(args), data, moves, level)
            self.items.append(item)
        return self._known[key]

    def input(self, name: str, index: int, moves: bool) -> Item:
        """Coefficient of an argument."""
        return self._item("input", (), (name, index), moves)

    def constant(self, value: Fraction) -> Item:
        """A number known now."""
        return self._item("const", (), Fraction(value))

    def combine(self, terms: Terms) -> Item:
        """Weighted sum; numbers known now are folded."""
        weights: dict[Item, Fraction] = {}
        constant = Fraction(0)
        for item, weight in terms:
            if item.op == "const":
                constant += item.data * weight
            elif item.op == "sum" and len(item.args) == 1 and not item.data[1]:
                weights[item.args[0]] = weights.get(item.args[0], Fraction(0)) + weight * item.data[0][0]
            else:
                weights[item] = weights.get(item, Fraction(0)) + weight
        weights = {item: weight for item, weight in weights.items() if weight}
        if not weights:
            return self.constant(constant)
        if len(weights) == 1 and not constant and next(iter(weights.values())) == 1:
            return next(iter(weights))
        return self._item("sum", tuple(weights), (tuple(weights.values()), constant))

    def multiply(self, a: Item, b: Item) -> Item:
        """Product: of two series a convolution, with numbers in front of it."""
        for x, y in ((a, b), (b, a)):
            if x.op == "const":
                return self.combine([(y, x.data)])
        (a, front, weight), (b, other, also) = _split_factors(a), _split_factors(b)
        fronts = [f for f in (front, other) if f is not None]
        if a.moves and b.moves:
            found = self._item("product", sorted((a, b), key=lambda x: x.number))
        elif a.moves or b.moves:
            found = a if a.moves else b
            fronts.append(b if a.moves else a)
        else:
            found = self._item("mul", (a, b))
        if fronts:
            factor = fronts[0] if len(fronts) == 1 else self._item("mul", fronts[:2])
            for more in fronts[2:]:
                factor = self._item("mul", (factor, more))
            found = self._item("scaled", (factor, found))
        return self.combine([(found, weight * also)])

    def apply(self, name: str, *arguments: Item) -> Item:
        """A function; comparisons hold as they are at the start of the series."""
        if name == "rounded":
            return arguments[0]
        return self._item(name, arguments)

    def select(self, mask: Item, a: Item, b: Item) -> Item:
        """One of two, as the mask is at the start of the series."""
        return a if a is b else self._item("select", (mask, a, b))

    def is_zero(self, a: Item) -> bool:
        """Return whether it is zero by construction."""
        return a is self.zero


def _split_factors(item: Item) -> tuple[Item, Item | None, Fraction]:
    """A value split into its time-dependent rest, its constant factor (or None) and its rational weight."""
    weight = Fraction(1)
    if item.op == "sum" and len(item.args) == 1 and not item.data[1]:
        item, weight = item.args[0], item.data[0][0]
    if item.op == "scaled":
        return item.args[1], item.args[0], weight
    return item, None, weight
