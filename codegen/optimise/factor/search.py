"""The search for a cheap factoring: several starts, then rounds that undo some definitions and factor again.

Deterministic: the only clock is the work, counted in pairs of terms and terms looked at.
"""

from __future__ import annotations

from .divisors import Extractor
from .packed import System, Terms
from .products import common_products

_WIDTH = 12
"""Candidates grown per extraction in the first pass; more gave no better forms on motors and circles."""

_ROUND_WIDTHS = (2, 4, 6, 12)
"""Widths drawn from in the rounds."""

_WHOLE_ONE_IN = 4
"""One round in so many takes coefficients only whole (see `Extractor`): other forms, 4 % cheaper at times."""

_UNDONE_PERCENT = (10, 100)
"""Share of the definitions that a round undoes, drawn between these."""


class Stream:
    """Pseudo-random integers, the same on every machine and Python (Lehmer's generator)."""

    def __init__(self, seed: int) -> None:
        self._state = seed % 1_000_000_007 * 2 + 1

    def below(self, bound: int) -> int:
        """A number in 0 .. bound - 1."""
        self._state = self._state * 48271 % 2147483647
        return (self._state >> 8) % bound


def cost(system: System) -> tuple[int, int]:
    """Multiplications and additions of a system as it stands."""
    additions = sum(len(terms) - 1 for terms in system.polynomials.values() if terms)
    return common_products(system).multiplications, additions


def search(system: System, atom_count: int, budget: int, seed: int) -> System:
    """The cheapest equivalent system found with about that much work; the seed chooses the rounds."""
    work = 0
    best: System | None = None
    best_cost = 0
    for start in _starts(system, atom_count, budget):
        extractor = Extractor(start, _WIDTH)
        extractor.run(max(budget - work, 0))
        work += extractor.work
        start.inline_trivial()
        value = sum(cost(start))
        if best is None or value < best_cost:
            best, best_cost = start, value
        if work >= budget:
            break
    assert best is not None
    return _improve(best, best_cost, atom_count, budget - work, Stream(seed))


def _improve(best: System, best_cost: int, atom_count: int, budget: int, stream: Stream) -> System:
    """Rounds with noise; a form of equal cost is taken too, to keep moving."""
    current, current_cost = best, best_cost
    while budget > 0:
        trial = current.compact(atom_count)
        defined = trial.definitions()
        if not defined:
            break
        low, high = _UNDONE_PERCENT
        share = low + stream.below(high - low + 1)
        for _ in range(max(1, len(defined) * share // 100)):
            trial.inline(defined.pop(stream.below(len(defined))))
        width = _ROUND_WIDTHS[stream.below(len(_ROUND_WIDTHS))]
        extractor = Extractor(trial, width, stream.below, parts=stream.below(_WHOLE_ONE_IN) > 0)
        extractor.run(budget)
        budget -= extractor.work + trial.pair_count()
        trial.inline_trivial()
        trial_cost = sum(cost(trial))
        if trial_cost <= current_cost:
            current, current_cost = trial, trial_cost
        if trial_cost < best_cost:
            best, best_cost = trial, trial_cost
    return best


# -- starts ------------------------------------------------------------------------------------------------


def _starts(system: System, atom_count: int, budget: int) -> list[System]:
    """Systems to begin with: as given, and split by atoms in which it is linear; if too large, coarsely."""
    plain = system.compact(atom_count)
    if plain.pair_count() > budget:
        _split_coarsely(plain, budget)
        return [plain]
    starts = [plain]
    linear = _linear_atoms(system, atom_count)
    if linear:
        grouped = system.compact(atom_count)
        for index in list(grouped.polynomials):
            _split(grouped, index, linear)
        starts.append(grouped)
    return starts


def _linear_atoms(system: System, atom_count: int) -> list[int]:
    """Atoms of which no term holds two or a power, the most frequent first: a point under a sandwich."""
    together: dict[int, set[int]] = {}
    count: dict[int, int] = {}
    for terms in system.polynomials.values():
        for monomial in terms:
            for atom, exponent in system.packing.exponents(monomial).items():
                count[atom] = count.get(atom, 0) + 1
                others = together.setdefault(atom, set())
                others.update(other for other in system.packing.exponents(monomial) if other != atom)
                if exponent > 1:
                    others.add(atom)
    chosen: list[int] = []
    for atom in sorted(count, key=lambda atom: (len(together[atom]), -count[atom], atom)):
        if atom not in together[atom] and not together[atom].intersection(chosen):
            chosen.append(atom)
    return chosen if len(chosen) > 1 else []


def _split(system: System, index: int, variables: list[int]) -> list[int]:
    """Write a polynomial as sum of variable times quotient, plus a rest; returns the quotients' variables."""
    created = []
    for variable in variables:
        bit = system.packing.bit(variable)
        terms = system.polynomials[index]
        inside = {monomial: value for monomial, value in terms.items() if monomial & bit}
        if len(inside) < 2:
            continue
        quotient: Terms = {system.packing.divide(monomial, bit): value for monomial, value in inside.items()}
        defined = system.define(quotient)
        created.append(defined)
        rest = {monomial: value for monomial, value in terms.items() if monomial not in inside}
        rest[bit | system.packing.bit(defined)] = 1
        system.polynomials[index] = rest
    return created


def _split_coarsely(system: System, budget: int) -> None:
    """Split by the most frequent variable, as Horner's rule does, until the pairs of terms fit the budget."""
    open_ = list(system.polynomials)
    while open_ and system.pair_count() > budget:
        index = max(open_, key=lambda index: (len(system.polynomials[index]), -index))
        count: dict[int, int] = {}
        for monomial in system.polynomials[index]:
            for variable in system.packing.exponents(monomial):
                count[variable] = count.get(variable, 0) + 1
        frequent = max(count, key=lambda variable: (count[variable], -variable), default=None)
        if frequent is None or count[frequent] < 2:
            open_.remove(index)
            continue
        open_.extend(_split(system, index, [frequent]))
