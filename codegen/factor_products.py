"""Common products: the last stage of factoring, where sums are settled and monomials share their parts.

A coefficient other than +-1 is a literal like any other here, so that 2 a in 2 a b and 2 a c can be shared.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from .factor_packed import System

Literal: TypeAlias = tuple[int, Fraction]
"""(0, coefficient), (1, variable) or (2, number of a shared product)."""

_COEFFICIENT, _VARIABLE, _SHARED = 0, 1, 2

Node: TypeAlias = tuple[Literal, ...]
"""A product of literals, ascending."""


@dataclass(frozen=True)
class Products:
    """How the products of a system are computed.

    `shared` are pairs of literals in order of computation; `nodes` says what remains of each distinct product.
    """

    shared: tuple[tuple[Literal, Literal], ...]
    nodes: dict[Node, Node]

    @property
    def multiplications(self) -> int:
        """Multiplications in all of them."""
        return len(self.shared) + sum(len(rest) - 1 for rest in dict.fromkeys(self.nodes.values()))


def coefficient_literal(value: Fraction) -> Literal:
    """The literal of a coefficient's magnitude."""
    return (_COEFFICIENT, value)


def variable_literal(variable: int) -> Literal:
    """The literal of an atom or a definition."""
    return (_VARIABLE, Fraction(variable))


def system_nodes(system: System) -> dict[Node, int]:
    """The distinct products of two or more literals, with the number of terms that use each."""
    found: dict[Node, int] = {}
    for terms in system.polynomials.values():
        for monomial, value in terms.items():
            node = term_node(system, monomial, Fraction(value))
            if len(node) > 1:
                found[node] = found.get(node, 0) + 1
    return found
