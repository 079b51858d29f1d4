"""Kinds that motions keep: their blades go to each other alone."""

from __future__ import annotations

from functools import cache

from .algebra import Algebra


@cache
def closed_kinds(algebra: Algebra) -> tuple[str, ...]:
    """Kinds that are closed under motions, narrowest first, of those with the same blades the first."""
    twists = algebra.kind("twist").blades
    closed: dict[frozenset[int], str] = {}
    for name in sorted(algebra.kinds, key=lambda name: algebra.kind(name).size):
        blades = frozenset(algebra.kind(name).blades)
        if all(commutator(algebra, b, e) <= blades for b in blades for e in twists):
            closed.setdefault(blades, name)
    return tuple(closed.values())


def commutator(algebra: Algebra, a: int, b: int) -> set[int]:
    """Blades of the commutator of two."""
    one, two = dict(algebra.product(a, b)), dict(algebra.product(b, a))
    return {k for k in {*one, *two} if one.get(k, 0) != two.get(k, 0)}
