"""Spheres that two objects share (thesis 3.7, 3.8): through both of them, or met by both at right angles."""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, absolute, select, sqrt
from ...status import Status
from ..products.outcome import NOISE, as_computed, epsilon, outcome, where_or_nan
from ..products.sizes import Sizes, product_sizes, sizes, vanishes
from .blades import Checked, norm_squared
from .conformal import infinity, origin
from .euclidean import axes
from .local import curvature

#: Objects built by a chain of operations count as lying on one sphere within this many rounding units of the terms.
COSPHERICAL_ULPS = 4096


def common_sphere(x1: Multivector, x2: Multivector, distance: Multivector) -> Checked:
    """Outward sphere (or plane) through both of two point pairs, or of two circles and lines.

    Point pairs: A ^ B (Theorem 2). Circles: with a point-like t of x2 outside x1, x1 ^ t (the proof of Theorem 4);
    t = (a | x2) | x2 for that basis vector a for which most is left. SINGULAR: the pairs are on one circle, the
    circles on no common sphere. NOT_UNIQUE: one circle twice; the sphere of which it is a great circle.
    ``distance`` is how far away the objects were given: positions are known to that many rounding units.
    """
    tolerance = _tolerance(x1, x2, distance)
    one = x1.constant(1)
    terms = product_sizes(sizes(x1), sizes(x2))
    if x1.grades == (2,):
        span = x1 ^ x2
        value, regular = outward_unit(span, _relative_sizes(tolerance, terms), great_sphere(x1))
        regular = regular & ~vanishes(span, _relative_sizes(tolerance, terms))
        return value * where_or_nan(regular, one), outcome(x1, (~regular, Status.SINGULAR))
    cospherical = vanishes((x1 * x2).grade(4), _relative_sizes(tolerance, terms))
    span, terms, score, scale = _best_span(x1, x2)
    same = score <= tolerance * tolerance * scale
    best = select(same, great_sphere(x1), span)
    value, regular = outward_unit(best, _relative_sizes(tolerance, terms), x1 ^ infinity(x1))
    regular = regular & cospherical
    return value * where_or_nan(regular, one), outcome(x1, (~regular, Status.SINGULAR), (same, Status.NOT_UNIQUE))


def _best_span(x1: Multivector, x2: Multivector) -> tuple[Multivector, Sizes, Multivector, Multivector]:
    """Longest of x1 ^ ((a | x2) | x2) against its terms, over the basis vectors a; the sizes of terms, and squares."""
    best, score, scale = x1.new({}), x1.constant(0), x1.constant(1)
    terms = sizes(best)
    for a in [*axes(x1), origin(x1), infinity(x1)]:
        span = as_computed(x1 ^ ((a | x2) | x2))
        own = product_sizes(sizes(x1), product_sizes(product_sizes(sizes(a), sizes(x2)), sizes(x2)))
        own_score, own_scale = absolute(norm_squared(span)), product_sizes(own, own)[1]
        better = own_score * scale > score * own_scale
        best, score, scale = (select(better, *pair) for pair in ((span, best), (own_score, score), (own_scale, scale)))
        terms = select(better, own[0], terms[0]), select(better, own[1], terms[1]), select(better, own[2], terms[2])
    return best, terms, score, scale


def orthogonal_sphere(x1: Multivector, x2: Multivector, distance: Multivector) -> Checked:
    """<x1 x2>_4, outward: the sphere that two circles (lines) meet at right angles (Theorem 5).

    IMAGINARY: it has no real points (the circles are linked). SINGULAR: they are on a common sphere, or share a point
    (two lines: the one at infinity). ``distance`` as of `common_sphere`.
    """
    quad, terms = (x1 * x2).grade(4), product_sizes(sizes(x1), sizes(x2))
    noise = _relative_sizes(NOISE * epsilon(x1), terms)
    square, limit = norm_squared(quad), 2 * product_sizes(sizes(quad), noise)[1]
    apart = ~vanishes(quad, _relative_sizes(_tolerance(x1, x2, distance), terms))
    regular, imaginary = (square < -limit) & apart, (square > limit) & apart
    value, _ = outward_unit(quad, noise, quad)
    status = outcome(x1, (imaginary, Status.IMAGINARY), (~regular, Status.SINGULAR))
    return value * where_or_nan(regular, x1.constant(1)), status


def great_sphere(x: Multivector) -> Multivector:
    """x (x ^ n_inf) I5: the sphere of which a circle is a great circle, unscaled; zero for lines (Conjecture 1)."""
    return (x * (x ^ infinity(x))).dual().grade(4)


def outward_unit(x: Multivector, noise: Sizes, side: Multivector) -> tuple[Multivector, Mask]:
    """x over its norm as an outward sphere; planes (to rounding noise) on the side of ``side``. And where it can."""
    square = -norm_squared(x)
    regular = square > 0
    weight, limit = x.dual() | infinity(x), noise[0]  # -1/r of an outward sphere
    product = -x.scalar_product(~side)
    flat = absolute(weight) <= limit
    turned = (~flat & (weight > 0)) | (flat & (product < 0))
    scale = select(turned, x.constant(-1), x.constant(1)) / sqrt(where_or_nan(regular, square))
    plane = infinity(x) ^ -(origin(x) | x)
    return select(flat, plane, x) * scale, regular


def _relative_sizes(factor: Multivector, x: Sizes) -> Sizes:
    return factor * x[0], factor * x[1], factor * x[2]


def _tolerance(x1: Multivector, x2: Multivector, distance: Multivector) -> Multivector:
    """Relative to the terms of a product: rounding units of what led to the objects, and of where they were given."""
    lost = NOISE * distance * (_inverse_radius(x1) + _inverse_radius(x2))
    return (COSPHERICAL_ULPS + lost) * epsilon(x1)


def _inverse_radius(x: Multivector) -> Multivector:
    """1/r, 0 for flats."""
    return sqrt(norm_squared(curvature(x)))
