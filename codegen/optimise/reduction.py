"""Shortest representatives of polynomials modulo a kind's constraints.

No representative is better in itself: callers factor the variants, count, and compare error bounds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .factor.packed import Poly
from .factor.shortest import Shortener

#: Polynomials with more terms are not reduced: it would take long, and they are too long to factor anyway.
MAX_TERMS = 400
#: Default work of `reduced_variants`, in monomials looked at: about half a second.
_BUDGET = 400_000


def reduced_variants(
    polynomials: Sequence[Poly], constraints: Sequence[Poly], atom_count: int, budget: int = _BUDGET
) -> Iterator[list[Poly]]:
    """Different polynomials with the same values where the constraints hold, worth factoring and counting.

    Multiples of constraints are subtracted wherever the number of terms falls, or stays and the terms get simpler;
    the variants prefer to drop the first atoms, to keep them, and to drop the last. Repetitions and the polynomials
    themselves are left out.

    Parameters
    ----------
    polynomials : sequence of Poly
        Those with more than `MAX_TERMS` terms stay as they are.
    constraints : sequence of Poly
        They may mention atoms from atom_count on; the variants do not.
    atom_count : int
        Atoms of the polynomials are numbered 0 .. atom_count - 1.
    budget : int
        Work of each variant, in monomials looked at; never time. Shortening stops there.
    """
    known = [_nonzero(polynomials)]
    generators = [constraint for constraint in _nonzero(constraints) if len(constraint) <= MAX_TERMS]
    natural = list(range(atom_count))
    for atoms, keep in ((natural, False), (natural, True), (natural[::-1], False)):
        shortener = Shortener(generators, atom_count, atoms, keep, budget)
        found = [shortener.shortest(p) if len(p) <= MAX_TERMS else p for p in known[0]]
        if found not in known:
            known.append(found)
            yield found


def _nonzero(polynomials: Sequence[Poly]) -> list[Poly]:
    """Polynomials without their zero terms."""
    return [{monomial: value for monomial, value in p.items() if value} for p in polynomials]
