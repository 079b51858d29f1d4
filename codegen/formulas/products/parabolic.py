"""Rotors whose two simple parts rounding does not tell apart: next to parabolic ones, where circles or spheres touch.

R = (c1 + v1) (c2 + v2) with c1 = cos f, v1^2 = -sin(f)^2, c2 = cosh g, v2^2 = sinh(g)^2, and log(R) = v1 f/sin f
+ v2 g/sinh g. With V = <R>_2 and Q = <R>_4 = v1 v2, and with d = sin(f)^2 + sinh(g)^2, both parts are
v1 = (c2 sin(f)^2 V + c1 Q V)/d and v2 = (c1 sinh(g)^2 V - c2 Q V)/d: where d is small beside what V^2 sums up, their
rounding errors are larger than they are. Their sum, log(R) = A V - D Q V, has none of it: A and D are analytic in
sinh(g)^2 - sin(f)^2 = r0^2 - 1 - Q^2 and in the product -Q^2, also at d = 0.
"""

from __future__ import annotations

from math import factorial
from typing import NamedTuple

from ...algebra.multivector import Mask, Multivector, absolute, select, sqrt
from .outcome import as_computed, epsilon
from .products import absolute_product

#: Squares of simple parts that differ by less than this part of the sum of V^2's absolute terms leave the planes with
#: six bits less than V has.
PLANES = 1 / 64
#: Bound of d + |sum| for the logarithm's power series: above it, quotients by d have errors of no more than a few dozen
#: rounding units.
LOG_SMALL = 1 / 32
#: Terms of that series above the rounding unit.
LOG_TERMS = 10
#: The same bound for the exponential.
EXP_SMALL = 1 / 8
#: Terms of its series above the rounding unit.
EXP_TERMS = 8


def least(like: Multivector) -> Multivector:
    """Bound below which squares and their differences count as zero: quotients might underflow, and 1 absorbs them."""
    return epsilon(like) * epsilon(like) * epsilon(like) * epsilon(like)


def two_numbers(total: Multivector, product: Multivector) -> tuple[Multivector, Multivector, Multivector]:
    """x1 <= x2 of a sum and a product, and their difference, the smaller in size from the product.

    Where rounding leaves them complex they are equal, and keep their sum.
    """
    room = total * total - 4 * product
    real = room > 0
    d = sqrt(select(real, room, total.constant(0)))
    negative = total < 0
    large = (total + select(negative, -d, d)) / 2
    small = select(absolute(large) > least(total), product / large, total.constant(0))
    small = select(real, small, large)
    return select(negative, large, small), select(negative, small, large), d


def are_planes_lost(b: Multivector, d: Multivector) -> Mask:
    """Return whether rounding takes the planes of the simple parts of b, whose squares differ by d."""
    return d < absolute_product(b, b).grade(0) * PLANES


def slope_of_small(s: Multivector, q2: Multivector) -> Multivector:
    """(S1 C2 - C1 S2)/(l2 - l1) of `invariant.exp_bivector`, for s = l1 + l2 and q2 = 4 l1 l2.

    Twice the divided difference of sinh(sqrt(m))/sqrt(m), at two m whose sum is 2 s and whose product s^2 - q2.
    """
    coefficients = [s.constant(1) / factorial(2 * k + 1) for k in range(EXP_TERMS)]
    return 2 * _polynomial(coefficients, 2 * s, s * s - q2)[1]


class NearParabolic(NamedTuple):
    """Mask of lost planes where the angle f is less than 2 pi/3 (``here``); sin(f)^2 and sinh(g)^2 there.

    ``small`` is the part of it where both are: only there may rounding be all that they are.
    """

    here: Mask
    small: Mask
    turn: Multivector
    growth: Multivector


def near_parabolic(r: Multivector, d: Multivector) -> NearParabolic:
    """Position of R relative to parabolic rotors; d is the difference of the squares of its bivector's parts."""
    r = as_computed(r)
    r0 = r.grade(0)
    q2 = (r.grade(4) * r.grade(4)).grade(0)
    total = r0 * r0 - 1 - q2
    x1, x2, difference = two_numbers(total, q2)
    here = are_planes_lost(r.grade(2), d) & (2 * r0 > -1)
    small = here & (difference + absolute(total) < LOG_SMALL)
    return NearParabolic(here, small, select(x1 < 0, -x1, r.constant(0)), x2)


def log_of_lost(
    r: Multivector, at: NearParabolic, c1: Multivector, c2: Multivector, by_sine: Multivector, by_sinh: Multivector
) -> Multivector:
    """log(R) = A V - D Q V where the planes are lost, of cos f and cosh g, f/sin f and g/sinh g.

    A = (c2 sin(f)^2 f/sin f + c1 sinh(g)^2 g/sinh g)/d and D = (c2 g/sinh g - c1 f/sin f)/d, or by the series of
    artanh(w)/w at w^2 = -tan(f)^2 and tanh(g)^2.
    """
    r = as_computed(r)
    r0, v, r4 = r.grade(0), r.grade(2), r.grade(4)
    q2 = (r4 * r4).grade(0)
    one_by_d, one_by_r0 = 1 / (at.turn + at.growth), 1 / r0
    first = (c2 * at.turn * by_sine + c1 * at.growth * by_sinh) * one_by_d
    second = (c2 * by_sinh - c1 * by_sine) * one_by_d
    inverse = one_by_r0 * one_by_r0
    total = (r0 * r0 - 1 + q2) * inverse
    coefficients = [r.constant(1) / (2 * k + 1) for k in range(LOG_TERMS)]
    a, b = _polynomial(coefficients, total, q2 * inverse)
    first = select(at.small, (a + b * total) * one_by_r0, first)
    second = select(at.small, b * inverse, second)
    return v * first - (r4 * v).grade(2) * second


def sqrt_of_lost(r: Multivector) -> Multivector:
    """The unit rotor (1 + R)/sqrt(2 (1 + r0 + Q)): without planes, and good where -1 is no eigenvalue of R."""
    r0, v, r4 = r.grade(0), r.grade(2), r.grade(4)
    norm = sqrt((1 + r0) * (1 + r0) - (r4 * r4).grade(0))
    k = sqrt(1 + r0 + norm)
    return k / 2 + r4 / (2 * k) + (v * k - (r4 * v).grade(2) / k) / (2 * norm)


def _polynomial(
    coefficients: list[Multivector], total: Multivector, product: Multivector
) -> tuple[Multivector, Multivector]:
    """(a, b) with p(x) = a + b x at both x of this sum and product: b is the divided difference of p there.

    Step by step: expanded, its powers would be no shorter.
    """
    total, product = as_computed(total), as_computed(product)
    a, b = coefficients[-1], total.constant(0)
    for c in reversed(coefficients[:-1]):
        a, b = as_computed(c - product * b), as_computed(a + total * b)
    return a, b
