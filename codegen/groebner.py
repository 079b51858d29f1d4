"""Polynomials modulo a kind's constraints: Groebner bases, normal forms, and shortest representatives.

Only `basis` needs SymPy, and imports it when called; bases are plain data that can be checked in. No form
here is better in itself: callers factor the variants, count, and compare error bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal, TypeAlias, get_args, overload

from .factor_packed import Monomial, Poly
from .factor_shortest import Shortener

Order: TypeAlias = Literal["lex", "grlex", "grevlex"]
_ORDERS = get_args(Order)

MAX_TERMS = 400
"""Polynomials with more terms are not reduced: it would take long, and they are too long to factor anyway."""

_MAX_STEPS = 20_000
"""Division steps after which `reduce` gives up."""

_BUDGET = 400_000
"""Default work of `reduced_variants`, in monomials looked at: about half a second."""


class TermLimitError(ValueError):
    """A polynomial has, or would get, more than `MAX_TERMS` terms; or a division takes too many steps."""


@dataclass(frozen=True)
class Basis(Sequence[Poly]):
    """A Groebner basis with the monomial order that it belongs to."""

    polynomials: tuple[Poly, ...]
    order: Order
    atom_order: tuple[int, ...]

    def __post_init__(self) -> None:
        if self.order not in _ORDERS:
            raise ValueError(f"{self.order!r} is no monomial order; orders are {', '.join(_ORDERS)}.")

    @overload
    def __getitem__(self, index: int) -> Poly: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Poly, ...]: ...
    def __getitem__(self, index: int | slice) -> Poly | tuple[Poly, ...]:
        return self.polynomials[index]

    def __len__(self) -> int:
        return len(self.polynomials)


# -- Groebner bases ----------------------------------------------------------------------------------------


def basis(
    constraints: Sequence[Poly],
    atom_count: int,
    order: Order = "grevlex",
    atom_order: Sequence[int] | None = None,
) -> Basis:
    """Reduced Groebner basis of the ideal that the constraints span, over the rationals.

    Parameters
    ----------
    constraints : sequence of Poly
        Polynomials that vanish.
    atom_count : int
        Atoms of interest are numbered 0 .. atom_count - 1.
    order : {"lex", "grlex", "grevlex"}
        Monomial order.
    atom_order : sequence of int, optional
        Atoms from the largest to the smallest; those left out follow, from atom_count on first, so that a
        lexicographic basis eliminates them.

    Returns
    -------
    Basis
        Empty if there are no constraints.
    """
    occurring = {atom for constraint in constraints for monomial in constraint for atom, _ in monomial}
    foreign = sorted(atom for atom in occurring if atom >= atom_count)
    ranked = tuple(dict.fromkeys([*(atom_order or ()), *foreign, *range(atom_count)]))
    atoms = [atom for atom in ranked if atom in occurring]
    nonzero = [constraint for constraint in constraints if constraint]
    if not nonzero or not atoms:
        return Basis(tuple({(): Fraction(1)} for _ in nonzero[:1]), order, ranked)
    from sympy import QQ
    from sympy.polys.groebnertools import groebner
    from sympy.polys.rings import ring

    domain: Any = QQ
    place = {atom: position for position, atom in enumerate(atoms)}
    polynomials, *_ = ring([f"a{atom}" for atom in atoms], domain, order)

    def dense(monomial: Monomial) -> tuple[int, ...]:
        powers = [0] * len(atoms)
        for atom, exponent in monomial:
            powers[place[atom]] = exponent
        return tuple(powers)

    elements = [
        polynomials.from_dict({dense(m): domain(c.numerator, c.denominator) for m, c in constraint.items()})
        for constraint in nonzero
    ]
    return Basis(
        tuple(
            {
                tuple(sorted((atoms[i], e) for i, e in enumerate(powers) if e)): Fraction(
                    int(value.numerator), int(value.denominator)
                )
                for powers, value in element.terms()
            }
            for element in groebner(elements, polynomials)
        ),
        order,
        ranked,
    )


def to_json(found: Basis) -> dict[str, Any]:
    """Plain lists, strings and integers."""
    return {
        "order": found.order,
        "atom_order": list(found.atom_order),
        "polynomials": [
            [[str(value), [list(power) for power in monomial]] for monomial, value in polynomial.items()]
            for polynomial in found
        ],
    }


def from_json(data: Mapping[str, Any]) -> Basis:
    """The basis that `to_json` wrote."""
    return Basis(
        tuple(
            {
                tuple((int(atom), int(exponent)) for atom, exponent in monomial): Fraction(value)
                for value, monomial in polynomial
            }
            for polynomial in data["polynomials"]
        ),
        data["order"],
        tuple(int(atom) for atom in data["atom_order"]),
    )


def reduce(polynomial: Poly, modulo: Basis) -> Poly:
    """Normal form: the one representative without a term that a leading monomial of the basis divides.

    Atoms that are not in the basis's order, larger than all that are, are left alone.

    Raises
    ------
    TermLimitError
        If the polynomial is too long, or becomes so.
    """
    key = _order_key(modulo)
    leads = [(max(element, key=key), element) for element in modulo if element]
    rest = {monomial: value for monomial, value in polynomial.items() if value}
    result: Poly = {}
    for _ in range(_MAX_STEPS):
        if not rest:
            return result
        if len(rest) + len(result) > MAX_TERMS:
            break
        lead = max(rest, key=key)
        for divisor, element in leads:
            quotient = _quotient(lead, divisor)
            if quotient is not None:
                _subtract(rest, element, quotient, rest[lead] / element[divisor])
                break
        else:
            result[lead] = rest.pop(lead)
    raise TermLimitError(f"The normal form has more than {MAX_TERMS} terms, or takes too long.")


def _order_key(modulo: Basis) -> Callable[[Monomial], tuple[Any, ...]]:
    """Sort key of monomials in the basis's order; unknown atoms come first of all."""
    rank = {atom: position for position, atom in enumerate(modulo.atom_order)}

    def key(monomial: Monomial) -> tuple[Any, ...]:
        powers = [0] * len(rank)
        strange = tuple(power for power in monomial if power[0] not in rank)
        for atom, exponent in monomial:
            if atom in rank:
                powers[rank[atom]] = exponent
        if modulo.order == "lex":
            return (strange, tuple(powers))
        if modulo.order == "grlex":
            return (strange, sum(powers), tuple(powers))
        return (strange, sum(powers), tuple(-exponent for exponent in reversed(powers)))

    return key


def _quotient(monomial: Monomial, divisor: Monomial) -> Monomial | None:
    exponents = dict(monomial)
    for atom, exponent in divisor:
        left = exponents.get(atom, 0) - exponent
        if left < 0:
            return None
        exponents[atom] = left
    return tuple((atom, exponent) for atom, exponent in exponents.items() if exponent)


def _subtract(polynomial: Poly, element: Poly, cofactor: Monomial, scale: Fraction) -> None:
    for monomial, value in element.items():
        exponents = dict(cofactor)
        for atom, exponent in monomial:
            exponents[atom] = exponents.get(atom, 0) + exponent
        target = tuple(sorted(exponents.items()))
        total = polynomial.get(target, Fraction(0)) - scale * value
        if total:
            polynomial[target] = total
        else:
            polynomial.pop(target, None)


# -- variants ----------------------------------------------------------------------------------------------


def reduced_variants(
    polynomials: Sequence[Poly],
    constraints: Sequence[Poly],
    atom_count: int,
    bases: Sequence[Basis] = (),
    budget: int = _BUDGET,
) -> Iterator[list[Poly]]:
    """Different polynomials with the same values where the constraints hold, worth factoring and counting.

    First shortest representatives: multiples of constraints are subtracted wherever the number of terms
    falls, or stays and the terms get simpler; the variants prefer to drop the first atoms, to keep them, and
    to drop the last. Then normal forms modulo each basis, and these shortened likewise. Repetitions
    and the polynomials themselves are left out.

    Parameters
    ----------
    polynomials : sequence of Poly
        Those with more than `MAX_TERMS` terms stay as they are.
    constraints : sequence of Poly
        They may mention atoms from atom_count on; the variants do not.
    atom_count : int
        Atoms of the polynomials are numbered 0 .. atom_count - 1.
    bases : sequence of Basis
        Groebner bases of the same ideal.
    budget : int
        Work of each variant, in monomials looked at; never time. Shortening stops there.
    """
    known = [_nonzero(polynomials)]
    generators = [constraint for constraint in _nonzero(constraints) if len(constraint) <= MAX_TERMS]
    natural = list(range(atom_count))
    for atoms, keep in ((natural, False), (natural, True), (natural[::-1], False)):
        found = _shortened(known[0], generators, atom_count, atoms, keep, budget)
        if found not in known:
            known.append(found)
            yield found
    for modulo in bases:
        try:
            normal = [reduce(p, modulo) if len(p) <= MAX_TERMS else p for p in known[0]]
        except TermLimitError:
            continue
        for found in (normal, _shortened(normal, generators, atom_count, natural, False, budget)):
            foreign = any(monomial and monomial[-1][0] >= atom_count for p in found for monomial in p)
            if not foreign and found not in known:
                known.append(found)
                yield found


def _shortened(
    polynomials: Sequence[Poly],
    generators: Sequence[Poly],
    atom_count: int,
    atoms: Sequence[int],
    keep: bool,
    budget: int,
) -> list[Poly]:
    shortener = Shortener(generators, atom_count, atoms, keep, budget)
    return [shortener.shortest(p) if len(p) <= MAX_TERMS else p for p in polynomials]


def _nonzero(polynomials: Sequence[Poly]) -> list[Poly]:
    """Without zero terms."""
    return [{monomial: value for monomial, value in p.items() if value} for p in polynomials]
