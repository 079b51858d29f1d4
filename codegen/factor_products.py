"""Common products: the last stage of factoring, where sums are settled and monomials share their parts.

A coefficient other than +-1 is a literal like any other here: the 2 a of 2 a b and 2 a c can be shared.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TypeAlias

from .factor_packed import Number, System, magnitude

Node: TypeAlias = tuple[int, ...]
"""A product as ascending literals: -1 - i is coefficient i; variables; and above them shared pairs."""


@dataclass(frozen=True)
class Products:
    """How the products of a system are computed.

    `shared[i]`, two literals, is the literal `first_shared + i`; `rests` says what remains of each distinct
    product, and `uses` in how many terms it stands.
    """

    coefficients: tuple[Number, ...]
    first_shared: int
    shared: tuple[Node, ...]
    rests: dict[Node, Node]
    uses: dict[Node, int]

    @property
    def multiplications(self) -> int:
        """Multiplications in all of them."""
        return len(self.shared) + sum(len(rest) - 1 for rest in self.rests.values())


def common_products(system: System) -> Products:
    """Greedily share the pair of literals that the most products contain, until none is in two."""
    numbers: dict[Number, int] = {}
    uses: dict[Node, int] = {}
    for terms in system.polynomials.values():
        for monomial, value in terms.items():
            literals = system.packing.literals(monomial)
            size = magnitude(value)
            if size != 1 and literals:
                literals.insert(0, -1 - numbers.setdefault(size, len(numbers)))
            if len(literals) > 1:
                node = tuple(literals)
                uses[node] = uses.get(node, 0) + 1
    first_shared = len(system.packing.bits)
    rests, shared = _share(list(uses), first_shared)
    return Products(tuple(numbers), first_shared, tuple(shared), dict(zip(uses, rests, strict=True)), uses)


def _share(nodes: list[Node], first_shared: int) -> tuple[list[Node], list[Node]]:
    """What remains of each node, and the shared pairs in order."""
    rests = list(nodes)
    shared: list[Node] = []
    members: dict[Node, dict[int, None]] = {}
    for number, node in enumerate(rests):
        for both in combinations(node, 2):
            members.setdefault(both, {})[number] = None
    while members:
        pair: Node = max(members, key=lambda key: (len(members[key]), key))
        if len(members[pair]) < 2:
            break
        literal = first_shared + len(shared)
        shared.append(pair)
        for number in list(members[pair]):
            for old in dict.fromkeys(combinations(rests[number], 2)):
                del members[old][number]
                if not members[old]:
                    del members[old]
            rests[number] = _replaced(rests[number], pair, literal)
            for new in combinations(rests[number], 2):
                members.setdefault(new, {})[number] = None
    return rests, shared


def _replaced(node: Node, pair: Node, literal: int) -> Node:
    """The node with the pair, as often as it occurs, replaced by its literal."""
    left = list(node)
    found = 0
    while pair[0] in left and pair[1] in left and (pair[0] != pair[1] or left.count(pair[0]) > 1):
        left.remove(pair[0])
        left.remove(pair[1])
        found += 1
    return tuple(left + [literal] * found)
