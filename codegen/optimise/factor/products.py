"""Common products: the last stage of factoring, where sums are settled and monomials share their parts.

A coefficient other than +-1 is a literal like any other here: the 2 a of 2 a b and 2 a c can be shared.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TypeAlias

from .packed import Number, System, magnitude

Node: TypeAlias = tuple[int, ...]
"""A product as ascending literals: -1 - i is coefficient i; variables; and above them shared pairs."""


@dataclass(frozen=True)
class Products:
    """Plan of computing the products of a system.

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
    rests, shared = _extract_pairs(list(uses), first_shared)
    return Products(tuple(numbers), first_shared, tuple(shared), dict(zip(uses, rests, strict=True)), uses)


def _extract_pairs(nodes: list[Node], first_shared: int) -> tuple[list[Node], list[Node]]:
    """Remainder of each node, and the shared pairs in order."""
    rests = list(nodes)
    shared: list[Node] = []
    members: dict[Node, dict[int, int]] = {}
    for number, node in enumerate(rests):
        for pair, times in _pairs(node).items():
            members.setdefault(pair, {})[number] = times
    while members:
        times, best = max((sum(where.values()), pair) for pair, where in members.items())
        if times < 2:
            break
        literal = first_shared + len(shared)
        shared.append(best)
        for number in list(members[best]):
            for old in _pairs(rests[number]):
                del members[old][number]
                if not members[old]:
                    del members[old]
            rests[number] = _replace_pair(rests[number], best, literal)
            for new, times in _pairs(rests[number]).items():
                members.setdefault(new, {})[number] = times
    return rests, shared


def _pairs(node: Node) -> dict[Node, int]:
    """The pairs of literals in a product, and how often each can be taken out of it."""
    pairs: dict[Node, int] = dict.fromkeys(combinations(node, 2), 1)
    if len(pairs) < len(node) * (len(node) - 1) // 2:
        for first, second in pairs:
            times = node.count(first)
            pairs[first, second] = times // 2 if first == second else min(times, node.count(second))
    return pairs


def _replace_pair(node: Node, pair: Node, literal: int) -> Node:
    """The node with the pair, as often as it occurs, replaced by its literal."""
    left = list(node)
    found = 0
    while pair[0] in left and pair[1] in left and (pair[0] != pair[1] or left.count(pair[0]) > 1):
        left.remove(pair[0])
        left.remove(pair[1])
        found += 1
    return tuple(left + [literal] * found)
