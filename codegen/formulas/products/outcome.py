"""Singular cases of a formula: items without a value become NaN, and a status code says why.

Only masks and scalars are handled here; which items are singular is each formula's own business.
"""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, absolute, select
from ...status import Status
from ...trace.outputs import Result, status

#: A sum is zero if it is less than this many units of roundoff of the sum of its terms' magnitudes.
NOISE = 64


def not_a_number(like: Multivector) -> Multivector:
    """The scalar NaN over the ring of ``like``; only a branch of `select` may hold it."""
    return like.new({0: like.ring.apply("nan")})


def epsilon(like: Multivector) -> Multivector:
    """Spacing of the ring's floating-point numbers at 1: tolerances that suit every precision."""
    return like.new({0: like.ring.apply("epsilon")})


def as_computed(x: Multivector) -> Multivector:
    """x with its rounding errors: what is exactly zero in mathematics can be measured in numbers."""
    return x.new({b: x.ring.apply("rounded", c) for b, c in x.terms.items()})


def where_or_nan(mask: Mask, x: Multivector) -> Multivector:
    """The scalar x where the mask holds, else NaN. Divide by it, or multiply with it, and the item is NaN."""
    return select(mask, x, not_a_number(x))


def without_negative_zeros(x: Multivector) -> Multivector:
    """x with 0 where a coefficient is -0."""
    scalars = {b: x.new({0: c}) for b, c in x.terms.items()}
    return x.new({b: select(absolute(c) <= 0, c.constant(0), c).scalar() for b, c in scalars.items()})


def outcome(like: Multivector, *cases: tuple[Mask, Status]) -> Result:
    """Status output: the code of the first case that holds, else `OK`."""
    code = like.constant(Status.OK)
    for mask, value in reversed(cases):
        code = select(mask, like.constant(value), code)
    return status(code)


def is_finite(x: Multivector) -> Mask:
    """Return whether no coefficient is NaN or infinite: then their size less itself is zero."""
    total = size(x)
    return total - as_computed(total) <= 0


def abs_coefficients(x: Multivector) -> list[Multivector]:
    """Absolute values of all coefficients, as scalars."""
    return [x.new({0: x.ring.apply("abs", c)}) for c in x.terms.values()]


def size(x: Multivector) -> Multivector:
    """Sum of the absolute values of the coefficients: how large x is written, not what it measures."""
    return x.sum(abs_coefficients(x))
