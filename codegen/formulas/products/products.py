"""The products and involutions of thesis 1.2, by name: what kernels are declared from.

One operator each. The only formula of its own here is the sum of absolute terms, which tells rounding noise.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector
from ...algebra.product_terms import Filter, product_terms


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


def right_contraction(x: Multivector, y: Multivector) -> Multivector:
    """Right contraction of x by y."""
    return x.right_contraction(y)


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
    return x.meet(y)


def join(x: Multivector, y: Multivector) -> Multivector:
    """Span of disjoint objects: x ^ y, or x & y where the metric is degenerate."""
    return x.join(y)


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
    terms = product_terms(x.algebra, keep)
    return x.bilinear(
        y,
        lambda a, b: [(c, abs(w)) for c, w in terms(a, b)],
        lambda p, q: x.ring.apply("abs", x.ring.multiply(p, q)),
    )
