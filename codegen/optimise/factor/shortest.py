"""Shortest representatives: subtract multiples of vanishing polynomials wherever the result has fewer terms.

No division algorithm: a term is replaced only where it pays, so that w^2 + x^2 - y^2 - z^2 becomes
1 - 2 y^2 - 2 z^2 modulo w^2 + x^2 + y^2 + z^2 - 1. Equally short ones are selected alike on every machine.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from .packed import Number, Packing, Poly, Terms, exact, product_cost, ratio

_ATOM_WEIGHT = 4096
"""Base of the weights that rank atoms: more than one step can change the degree in one atom."""

Multiple: TypeAlias = tuple[int, int]
"""A generator's number and a packed cofactor."""

Change: TypeAlias = tuple[int, int, int]
"""What a step changes: number of terms, multiplications of the terms, weight of the atoms."""

_NOTHING: Change = (0, 0, 0)


class Shortener:
    """Shortens polynomials modulo generators, alike in all of them.

    Parameters
    ----------
    generators : sequence of Poly
        Polynomials that vanish.
    atom_count : int
        Terms with atoms from here on are never brought in.
    atoms : sequence of int
        Which atoms matter first when several steps save the same.
    keep : bool
        Whether to keep those atoms, instead of getting rid of them.
    budget : int
        Monomials looked at, in all; then polynomials stay as short as they are.
    """

    def __init__(
        self, generators: Sequence[Poly], atom_count: int, atoms: Sequence[int], keep: bool, budget: int
    ) -> None:
        occurring = {atom for generator in generators for monomial in generator for atom, _ in monomial}
        self._atom_count = atom_count
        self._packing = Packing(max([atom_count, *(atom + 1 for atom in occurring)]))
        self._generators = [self._pack(generator) for generator in generators]
        ranked = [atom for atom in atoms if atom in occurring]
        sign = -1 if keep else 1
        self._weight_of = {atom: sign * _ATOM_WEIGHT ** (len(ranked) - 1 - rank) for rank, atom in enumerate(ranked)}
        self._weights: dict[int, int] = {}
        self._classified = self._ranked = self._foreign = 0
        self._left = budget
        self._terms: Terms = {}
        self._steps: dict[Multiple, tuple[Change, Number]] = {}

    def _pack(self, polynomial: Poly) -> Terms:
        return {self._packing.pack(dict(monomial)): exact(polynomial[monomial]) for monomial in sorted(polynomial)}

    def shortest(self, polynomial: Poly) -> Poly:
        """An equal polynomial modulo the generators that no single step makes shorter."""
        self._terms = self._pack(polynomial)
        self._steps = {}
        self._look_around(list(self._terms))
        while self._steps and self._left > 0:
            multiple = min(self._steps, key=lambda key: (self._steps[key][0], key))
            self._look_around(self._subtract(multiple, self._steps[multiple][1]))
        return {
            tuple(sorted(self._packing.exponents(monomial).items())): Fraction(value)
            for monomial, value in self._terms.items()
        }

    def _look_around(self, monomials: list[int]) -> None:
        """Reconsider the multiples of generators that contain one of the monomials."""
        seen: set[Multiple] = set()
        for monomial in monomials:
            for number, generator in enumerate(self._generators):
                for part in generator:
                    if monomial & part == part:
                        multiple = (number, self._packing.divide(monomial, part))
                        if multiple not in seen:
                            seen.add(multiple)
                            self._consider(multiple)

    def _consider(self, multiple: Multiple) -> None:
        """Find the best scale for subtracting a multiple; remember it if it makes things better."""
        number, cofactor = multiple
        generator = self._generators[number]
        self._left -= len(generator)
        places = []
        there = 0
        for part, value in generator.items():
            monomial = self._packing.multiply(cofactor, part)
            actual = self._terms.get(monomial, 0)
            places.append((monomial, actual, value))
            if actual:
                there += 1
            elif self._is_foreign(monomial):
                self._steps.pop(multiple, None)
                return
        best: Change = _NOTHING
        best_scale: Number = 0
        vanishing = Counter(ratio(actual, value) for _, actual, value in places if actual)
        for scale, count in vanishing.items():
            terms = len(places) - count - there
            if terms <= best[0]:
                change = (terms, *self._change(places, scale))
                if change < best:
                    best, best_scale = change, scale
        if best < _NOTHING:
            self._steps[multiple] = (best, best_scale)
        else:
            self._steps.pop(multiple, None)

    def _change(self, places: list[tuple[int, Number, Number]], scale: Number) -> tuple[int, int]:
        """What a multiple changes but for the number of terms."""
        multiplications = weight = 0
        for monomial, actual, value in places:
            rest = actual - scale * value
            if rest:
                multiplications += product_cost(monomial.bit_count(), rest)
                weight += self._weight(monomial)
            if actual:
                multiplications -= product_cost(monomial.bit_count(), actual)
                weight -= self._weight(monomial)
        return multiplications, weight

    def _weight(self, monomial: int) -> int:
        self._classify()
        total, left = 0, monomial & self._ranked
        while left:
            bit = left & -left
            total += self._weights[bit]
            left ^= bit
        return total

    def _is_foreign(self, monomial: int) -> bool:
        self._classify()
        return bool(monomial & self._foreign)

    def _classify(self) -> None:
        """Sort the bits of monomials that are new: those of atoms that matter, and those that are never brought in."""
        while self._classified < len(self._packing.variable_of_bit):
            atom, bit = self._packing.variable_of_bit[self._classified], 1 << self._classified
            if atom in self._weight_of:
                self._ranked |= bit
                self._weights[bit] = self._weight_of[atom]
            self._foreign |= bit if atom >= self._atom_count else 0
            self._classified += 1

    def _subtract(self, multiple: Multiple, scale: Number) -> list[int]:
        """Take the multiple off; returns the monomials whose coefficients changed."""
        number, cofactor = multiple
        changed = []
        for part, value in self._generators[number].items():
            monomial = self._packing.multiply(cofactor, part)
            rest = exact(self._terms.get(monomial, 0) - scale * value)
            if rest:
                self._terms[monomial] = rest
            else:
                self._terms.pop(monomial, None)
            changed.append(monomial)
        return changed
