"""Objects relative to a local origin, rebuilt from what far coefficients keep (accuracy far from the origin).

A unit round at distance c stores 1/r and c/r to their last digits, but its n_inf part is c^2/r, rounded: sums and
products of such coefficients lose (c/r)^2. Weight, center and attitude are read, and the object is built again.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, select
from ..motions.motions import translator
from ..products.outcome import as_computed, size, where_or_nan
from .blades import norm_squared, project_to_blade
from .conformal import infinity, origin, point
from .euclidean import euclidean_part


def anchor(x: Multivector) -> Multivector:
    """Position of a point; else of the projection of the origin on the object: on flats the point nearest to it.

    On rounds it is a point of the sphere around, or between the end points: within a radius of the center, and
    never much farther from the origin than the object is.
    """
    p = x if x.grades == (1,) else (origin(x) | x) | x
    weight = -(p | infinity(x))
    return euclidean_part(p) / weight


def nearest(x: Multivector, o: Multivector) -> Multivector:
    """`anchor` as seen from another origin."""
    return o + anchor(inward(x, o))


def inward(x: Multivector, o: Multivector) -> Multivector:
    """x as seen from the origin o, ~T x T for the translator T to o, without the rounding of far squares.

    Translation is exact but for what is attached to n_inf. Rounds have that built again, (n0 + r^2/2 n_inf) ^ E
    about the center, where it is larger than what is made so: the smaller number has the smaller rounding error.
    Flats are translated, and projected.
    """
    # as computed: of an exact round both ways are one, and nothing may be simplified by that
    moved = as_computed((translator(-o) >> as_computed(x)).grade(*x.grades))
    if x.grades == (1,):
        weight = -(moved | infinity(x))
        return point(euclidean_part(moved) / weight).grade(1)
    if curvature(x).terms == {}:
        return project_to_blade(moved)
    rebuilt = _rebuilt(moved)
    far = size(_at_infinity(rebuilt)) < size(_at_infinity(x)) + size(_at_infinity(moved))
    return select(far, rebuilt, moved)


def outward(x: Multivector, o: Multivector) -> Multivector:
    """T x ~T: what is seen from o, as seen from the origin; objects and rotors."""
    return translator(o) >> x


def curvature(x: Multivector) -> Multivector:
    """E of a round (n0 + r^2/2 n_inf) ^ E about the origin, E ~E = 1/r^2; translation leaves it. Zero for flats."""
    return -euclidean_part(infinity(x) | x)


def _at_infinity(x: Multivector) -> Multivector:
    """The part of n_inf ^ (Euclidean): what grows with the square of the distance."""
    return (origin(x) | x) ^ infinity(x)


def _rebuilt(x: Multivector) -> Multivector:
    """A round, from its attitude and its center: reflected infinity, (n_inf . x) . x = E^2 (center) up to its sign."""
    e = curvature(x)
    curved = norm_squared(e)
    is_round = curved > 0
    reflected = (infinity(x) | x) | x
    center = as_computed(euclidean_part(reflected) / where_or_nan(is_round, -(reflected | infinity(x))))
    return translator(center) >> ((origin(x) + infinity(x) / (2 * curved)) ^ e)
