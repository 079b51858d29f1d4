"""The products and involutions of thesis 1.2, by name: what kernels are declared from.

One operator each. The only formula of its own here is the sum of absolute terms, which tells rounding noise.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from ..algebra import grade
from ..multivector import Filter, Multivector


def geometric(x: Multivector, y: Multivector) -> Multivector:
    """Geometric product x y."""
    return x * y


def outer(x: Multivector, y: Multivector) -> Multivector:
    """Outer product x ^ y."""
    return x ^ y


def inner(x: Multivector, y: Multivector) -> Multivector:
    """Inner product of thesis 1.2.2, zero with scalars."""
    return x | y


def left_contraction(x: Multivector, y: Multivector) -> Multivector:
    """Left contraction of x on y."""
    return x.left_contraction(y)


def scalar_product(x: Multivector, y: Multivector) -> Multivector:
    """<x y>_0."""
    return x.scalar_product(y)


def commutator(x: Multivector, y: Multivector) -> Multivector:
    """Commutator product (x y - y x)/2."""
    return x.commutator(y)


def anticommutator(x: Multivector, y: Multivector) -> Multivector:
    """Anticommutator product (x y + y x)/2."""
    return x.anticommutator(y)


def regressive(x: Multivector, y: Multivector) -> Multivector:
    """Regressive product x & y: the meet in CGA, the join in PGA."""
    return x & y


def meet(x: Multivector, y: Multivector) -> Multivector:
    """Intersection: x & y, or x ^ y where the metric is degenerate and objects are built from planes."""
    return x ^ y if x.algebra.is_degenerate else x & y


def join(x: Multivector, y: Multivector) -> Multivector:
    """Span of disjoint objects: x ^ y, or x & y where the metric is degenerate."""
    return x & y if x.algebra.is_degenerate else x ^ y


def reverse(x: Multivector) -> Multivector:
    """Reversion ~x."""
    return ~x


def involute(x: Multivector) -> Multivector:
    """Grade involution."""
    return x.involute()


def conjugate(x: Multivector) -> Multivector:
    """Clifford conjugation."""
    return x.conjugate()


def dual(x: Multivector) -> Multivector:
    """x I, or J(x) where the metric is degenerate."""
    return x.dual()


def undual(x: Multivector) -> Multivector:
    """The y with dual(y) = x."""
    return x.undual()


def sandwich(r: Multivector, x: Multivector) -> Multivector:
    """r x ~r: what a rotor does to an object (thesis 1.2.6)."""
    return r >> x


def absolute_product(x: Multivector, y: Multivector, keep: Filter | None = None) -> Multivector:
    """Sums of the absolute values of the terms of x y: the scale of its rounding errors, coefficient by coefficient."""
    ring = x.ring
    gathered: dict[int, list[tuple[Any, Fraction]]] = {}
    for a, p in x.terms.items():
        for b, q in y.terms.items():
            kept = [(c, w) for c, w in x.algebra.product(a, b) if keep is None or keep(grade(a), grade(b), grade(c))]
            if kept:
                pq = ring.apply("abs", ring.multiply(p, q))
                for c, w in kept:
                    gathered.setdefault(c, []).append((pq, abs(w)))
    return x.new({c: ring.combine(parts) for c, parts in gathered.items()})
