"""Exact and 50-digit arithmetic on all items of a batch at once: a formula runs once, on columns of numbers."""

from __future__ import annotations

import decimal
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from ..rings.protocol import PrecisionRing, RationalRing, Ring, Terms
from ..trace.kernel import Kernel

Column = Sequence[Any]
#: More digits than products of floating-point numbers of any formula have; what has more is left to fractions.
EXACT = decimal.Context(
    prec=4000, Emin=decimal.MIN_EMIN, Emax=decimal.MAX_EMAX,
    traps=[decimal.Inexact, decimal.InvalidOperation, decimal.DivisionByZero, decimal.Overflow],
)  # fmt: skip


class ColumnRing:
    """Numbers of another ring, which have +, - and *, item by item; what is zero in every item is zero."""

    def __init__(self, ring: Ring, items: int) -> None:
        self.ring, self.items = ring, items

    def constant(self, value: Fraction) -> Column:
        return (self.ring.constant(value),) * self.items

    def combine(self, terms: Terms) -> Column:
        total: Column | None = None
        for column, weight in terms:
            if total is None:
                total = self._scaled(column, weight)
            elif weight == -1:
                total = [a - b for a, b in zip(total, column, strict=True)]
            else:
                total = [a + b for a, b in zip(total, self._scaled(column, weight), strict=True)]
        return self.constant(Fraction(0)) if total is None else total

    def _scaled(self, column: Column, weight: Fraction) -> Column:
        if abs(weight) == 1:
            return column if weight > 0 else [-x for x in column]
        return [self.ring.combine([(x, weight)]) for x in column]

    def multiply(self, a: Column, b: Column) -> Column:
        return [x * y for x, y in zip(a, b, strict=True)]

    def apply(self, name: str, *arguments: Column) -> Column:
        if not arguments:
            return (self.ring.apply(name),) * self.items
        return [self.ring.apply(name, *each) for each in zip(*arguments, strict=True)]

    def select(self, mask: Column, a: Column, b: Column) -> Column:
        return [self.ring.select(*each) for each in zip(mask, a, b, strict=True)]

    def is_zero(self, a: Column) -> bool:
        return all(map(self.ring.is_zero, a))


class DecimalRing(RationalRing):
    """Exact decimals, which sums and products of floating-point numbers are: `EXACT` raises where one would be rounded.

    Many times as fast as fractions, which look for common divisors.
    """

    def constant(self, value: Fraction) -> Any:
        return EXACT.divide(decimal.Decimal(value.numerator), decimal.Decimal(value.denominator))

    def combine(self, terms: Terms) -> Any:
        return sum((c if w == 1 else -c if w == -1 else c * self.constant(w) for c, w in terms), decimal.Decimal(0))

    def apply(self, name: str, *arguments: Any) -> Any:
        found = super().apply(name, *arguments)
        return self.constant(found) if isinstance(found, Fraction) else found


def exact_items(kernel: Kernel, columns: Sequence[Sequence[Sequence[float]]], rational: bool, digits: int,
                epsilon: Fraction) -> list[list[list[Any]]]:  # fmt: skip
    """Values of a kernel's formula: of each item, for each output, its coefficients.

    ``columns`` hold the items' numbers for each coefficient of each argument. What is rational is a `Fraction`, the
    rest an mpmath number of so many digits; ``epsilon`` is that of the numbers whose reference this is.
    """
    if not rational:
        ring = PrecisionRing(digits, epsilon=epsilon)
        return _items(kernel, ring, columns, ring.context.mpf, lambda x: x)
    try:
        with decimal.localcontext(EXACT):
            return _items(kernel, DecimalRing(), columns, decimal.Decimal, Fraction)
    except decimal.Inexact:  # a quotient
        return _items(kernel, RationalRing(), columns, Fraction, Fraction)


def _items(kernel: Kernel, ring: Ring, columns: Any, number: Any, result: Any) -> list[list[list[Any]]]:
    count = len(columns[0][0])
    given = [[[number(x) for x in column] for column in argument] for argument in columns]
    found = kernel.reference(ColumnRing(ring, count), given)
    return [[[result(column[i]) for column in output] for output in found] for i in range(count)]
