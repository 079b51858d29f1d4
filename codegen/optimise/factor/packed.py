"""Polynomials packed for speed: monomials as bit sets, and systems of polynomials that define each other.

The lowest layer of the factoring: the polynomial types, exact arithmetic on monomials, and inlining. It does not
decide what is worth extracting.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

Monomial: TypeAlias = tuple[tuple[int, int], ...]
"""Sorted (atom, exponent > 0) pairs; the empty tuple is 1."""

Poly: TypeAlias = dict[Monomial, Fraction]

Number: TypeAlias = int | Fraction
Terms: TypeAlias = dict[int, Number]
"""A packed polynomial: packed monomial -> coefficient (an int where it is one, because ints are fast)."""


def exact(value: Number) -> Number:
    """The same number, as an int if it is one."""
    return value.numerator if value.denominator == 1 else value


def magnitude(value: Number) -> Number:
    """Absolute value."""
    return value if value > 0 else -value


@lru_cache(maxsize=4096)
def ratio(dividend: Number, divisor: Number) -> Number:
    """Exact quotient, as an int if it is one."""
    return exact(Fraction(dividend) / divisor)


def product_cost(literals: int, coefficient: Number) -> int:
    """Multiplications in a coefficient times that many literals; +-1 costs nothing."""
    if coefficient != 1 and coefficient != -1:
        literals += 1
    return literals - 1 if literals > 1 else 0


class Packing:
    """Variables as bits in unary coding: the cube of a variable holds its first three bits.

    So the greatest common divisor of two monomials is `&`, and divisibility is a mask test. Products and
    quotients are `|` and `^` unless a variable meets itself.
    """

    def __init__(self, variable_count: int = 0) -> None:
        self.variable_of_bit: list[int] = []
        self.bits: list[list[int]] = []
        self.powers = 0  # the bits that stand for second and higher copies
        self._quotients: dict[int, int] = {}
        self._squares: dict[tuple[int, int], int] = {}
        for _ in range(variable_count):
            self.new_variable()

    def new_variable(self) -> int:
        """A fresh variable's number."""
        self.bits.append([])
        variable = len(self.bits) - 1
        self._copy(variable, 0)
        return variable

    def _copy(self, variable: int, index: int) -> int:
        bits = self.bits[variable]
        while len(bits) <= index:
            bit = 1 << len(self.variable_of_bit)
            self.variable_of_bit.append(variable)
            if bits:
                self.powers |= bit
            bits.append(bit)
        return bits[index]

    def bit(self, variable: int) -> int:
        """The packed monomial of the variable alone."""
        return self.bits[variable][0]

    def pack(self, exponents: Mapping[int, int]) -> int:
        """Packed monomial of variable -> exponent."""
        monomial = 0
        for variable, exponent in exponents.items():
            for index in range(exponent):
                monomial |= self._copy(variable, index)
        return monomial

    def literals(self, monomial: int) -> list[int]:
        """The variables of a packed monomial, repeated as often as they occur, ascending."""
        found = []
        while monomial:
            low = monomial & -monomial
            found.append(self.variable_of_bit[low.bit_length() - 1])
            monomial ^= low
        found.sort()
        return found

    def exponents(self, monomial: int) -> dict[int, int]:
        """Variable -> exponent of a packed monomial."""
        found: dict[int, int] = {}
        for variable in self.literals(monomial):
            found[variable] = found.get(variable, 0) + 1
        return found

    def multiply(self, left: int, right: int) -> int:
        """Product of two packed monomials."""
        if not left & right:
            return left | right
        key = (left, right)
        found = self._squares.get(key)
        if found is None:
            exponents = self.exponents(left)
            for variable in self.literals(right):
                exponents[variable] = exponents.get(variable, 0) + 1
            found = self._squares[key] = self.pack(exponents)
        return found

    def divide(self, monomial: int, divisor: int) -> int:
        """Quotient of packed monomials, where `monomial & divisor == divisor`."""
        quotient = monomial ^ divisor
        if not quotient & self.powers:
            return quotient
        found = self._quotients.get(quotient)
        if found is None:
            found = self._quotients[quotient] = self.pack(self.exponents(quotient))
        return found


class System:
    """Packed polynomials by variable: outputs under -1, -2, ..., a definition under the variable it defines.

    Definitions are acyclic; substituting all of them back gives the outputs that were loaded.
    """

    def __init__(self, packing: Packing, polynomials: dict[int, Terms]) -> None:
        self.packing = packing
        self.polynomials = polynomials

    @classmethod
    def load(cls, polynomials: Sequence[Poly], atom_count: int) -> System:
        """Outputs in the order given, over atoms 0 .. atom_count - 1; terms in a canonical order."""
        packing = Packing(atom_count)
        return cls(
            packing,
            {
                -1 - index: {
                    packing.pack(dict(monomial)): exact(polynomial[monomial])
                    for monomial in sorted(polynomial)
                    if polynomial[monomial]
                }
                for index, polynomial in enumerate(polynomials)
            },
        )

    def compact(self, atom_count: int) -> System:
        """A copy without the variables that nothing defines any more (atoms stay)."""
        packing = Packing(atom_count)
        renamed = {variable: variable for variable in range(atom_count)}
        for variable in self.polynomials:
            if variable >= 0:
                renamed[variable] = packing.new_variable()
        old = self.packing
        memo: dict[int, int] = {}

        def renumber(monomial: int) -> int:
            if monomial not in memo:
                memo[monomial] = packing.pack(
                    {renamed[variable]: exponent for variable, exponent in old.exponents(monomial).items()}
                )
            return memo[monomial]

        return System(
            packing,
            {
                renamed.get(variable, variable): {renumber(monomial): value for monomial, value in terms.items()}
                for variable, terms in self.polynomials.items()
            },
        )

    def definitions(self) -> list[int]:
        """The defined variables."""
        return [variable for variable in self.polynomials if variable >= 0]

    def define(self, terms: Terms) -> int:
        """A new variable that stands for these terms."""
        variable = self.packing.new_variable()
        self.polynomials[variable] = terms
        return variable

    def inline(self, variable: int) -> None:
        """Substitute a definition into all its users and drop it."""
        body = self.polynomials.pop(variable)
        bit = self.packing.bit(variable)
        for user, terms in self.polynomials.items():
            while any(monomial & bit for monomial in terms):
                terms = self._substitute(terms, bit, body)
                self.polynomials[user] = terms

    def _substitute(self, terms: Terms, bit: int, body: Terms) -> Terms:
        """The terms with one power of the variable replaced by its body."""
        result: Terms = {}
        for monomial, value in terms.items():
            if not monomial & bit:
                pieces = [(monomial, value)]
            else:
                rest = self.packing.divide(monomial, bit)
                pieces = [(self.packing.multiply(rest, inner), value * amount) for inner, amount in body.items()]
            for target, added in pieces:
                total = exact(result.get(target, 0) + added)
                if total:
                    result[target] = total
                else:
                    result.pop(target, None)
        return result

    def inline_trivial(self) -> None:
        """Inline definitions that save nothing: of one term, or used once as a bare +-1 term of a sum."""
        while True:
            uses: dict[int, int] = {}
            bare: dict[int, bool] = {}
            for terms in self.polynomials.values():
                for monomial, value in terms.items():
                    literals = self.packing.literals(monomial)
                    for variable in literals:
                        uses[variable] = uses.get(variable, 0) + 1
                        bare[variable] = len(literals) == 1 and value in (1, -1)
            trivial = next(
                (
                    variable
                    for variable in self.definitions()
                    if len(self.polynomials[variable]) < 2
                    or uses.get(variable, 0) == 0
                    or (uses[variable] == 1 and bare[variable])
                ),
                None,
            )
            if trivial is None:
                return
            self.inline(trivial)

    def pair_count(self) -> int:
        """Pairs of terms within the polynomials: the size of the search for common divisors."""
        return sum(len(terms) * (len(terms) - 1) // 2 for terms in self.polynomials.values())
