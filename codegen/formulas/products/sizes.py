"""Sizes of multivectors as written, and bounds of the rounding errors of products that should be zero.

Scaling by s multiplies n0 by 1/s and n_inf by s: coefficients are compared only with those of blades of one weight,
and all of these share one bound, since a turned object has its noise in other places.
"""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, absolute
from .outcome import size

#: Sums of absolute coefficients on blades with n0 alone (weight -1), with neither or both, with n_inf alone (+1).
Sizes = tuple[Multivector, Multivector, Multivector]


def weight_of(x: Multivector, blade: int) -> int:
    """-1, 0 or 1; 0 for all blades of an algebra without n0 and n_inf."""
    vectors = x.algebra.vectors
    bits = [blade >> vectors.index(v) & 1 if v in vectors else 0 for v in ("no", "ni")]
    return bits[1] - bits[0] if {"no", "ni"} <= set(vectors) else 0


def sizes(x: Multivector, unit: Multivector | None = None, written: Sizes | None = None) -> Sizes:
    """Sizes of x; with ``unit`` times the sizes ``written`` on top."""
    own = [size(x.new({b: c for b, c in x.terms.items() if weight_of(x, b) == w})) for w in (-1, 0, 1)]
    if unit is not None and written is not None:
        own = [a + unit * b for a, b in zip(own, written, strict=True)]
    return own[0], own[1], own[2]


def displace(x: Sizes, distance: Multivector) -> Sizes:
    """Sizes of x with its positions known to rounding at a distance: a move adds so much of the next lower weight."""
    return x[0], x[1] + distance * x[0], x[2] + distance * x[1]


def product_sizes(x: Sizes, y: Sizes) -> Sizes:
    """Bounds of any coefficient of a product, by its weight."""
    return (
        x[0] * y[1] + x[1] * y[0],
        x[0] * y[2] + x[2] * y[0] + x[1] * y[1],
        x[1] * y[2] + x[2] * y[1],
    )


def vanishes(x: Multivector, bounds: Sizes) -> Mask:
    """Return whether every coefficient is within the bound of its weight."""
    zero = x.constant(0)
    mask = zero <= zero
    for blade, value in x.terms.items():
        mask = mask & (absolute(x.new({0: value})) <= bounds[weight_of(x, blade) + 1])
    return mask
