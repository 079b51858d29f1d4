"""Exponential, logarithm and square root of every rotor of an algebra of up to five dimensions: rotations, dilations,
translations, transversions and all that they make, by invariant decomposition.

A bivector is a sum of two simple ones that commute, B = B1 + B2 with squares l1 and l2, if one signature of the metric
has at most one vector; the rotor is then the product of two simple ones. Motors have shorter forms in `exponentials`.
"""

from __future__ import annotations

from math import comb
from typing import NamedTuple

from ...algebra.algebra import Algebra
from ...algebra.multivector import Mask, Multivector, absolute, atan2, log, select, sqrt, stumpff0, stumpff1
from ...errors import GradeError
from ...status import Status
from ...trace.outputs import Result
from ..motions.commuting_planes import commuting_plane
from .double_rotations import Squares, halves, has_half_turn, square_of, squares
from .exponentials import is_unit, square_signs
from .outcome import NOISE, as_computed, epsilon, outcome, where_or_nan
from .parabolic import (
    EXP_SMALL,
    NearParabolic,
    are_planes_lost,
    least,
    log_of_lost,
    near_parabolic,
    slope_of_small,
    sqrt_of_lost,
)
from .products import absolute_product

#: Invariant decomposition needs B^2 = scalar + grade 4 whose square is a scalar: so in five dimensions and fewer.
MOST_DIMENSIONS = 5
#: Squares below which an arc over its sine is a series: the quotient has no derivatives to rounding there.
ARC_SMALL = 0.01
#: Coefficients of arsinh(x)/x by the square of x; of arcsin by its negative.
_ARC = tuple((-1) ** k * comb(2 * k, k) / (4**k * (2 * k + 1)) for k in range(9))
#: Squares of two simple parts that differ by less than this many roots of the rounding unit, relative to their sum:
#: the difference is noise below one of them, and above as many its cube is no error.
NEARLY_EQUAL = 32


def decomposes(like: Multivector, invertibly: bool = False) -> bool:
    """Return whether each bivector of the algebra is a real sum of two commuting simple ones (or is simple)."""
    return decomposes_in(like.algebra, invertibly)


def decomposes_in(algebra: Algebra, invertibly: bool = False) -> bool:
    """The same of an algebra."""
    p, q, r = algebra.signature
    return p + q + r <= MOST_DIMENSIONS and min(p, q) <= 1 and not (invertibly and r)


def _require(like: Multivector, invertibly: bool) -> None:
    if not decomposes(like, invertibly):
        which = "non-degenerate signatures (p, 1), (1, q)" if invertibly else "signatures (p, 1, r), (1, q, r)"
        raise GradeError(
            f"bivectors of {like.algebra.name} are not sums of two simple ones as the closed form needs: it is for "
            f"{which} and definite ones of up to {MOST_DIMENSIONS} dimensions."
        )


def exp_bivector(b: Multivector) -> Multivector:
    """exp(B) = (C1 + S1 B1) (C2 + S2 B2) with C = cosh(sqrt l), S = sinh(sqrt l)/sqrt l, for any signs of l1, l2.

    B1 - B2 = 2 F/(l2 - l1) with F = q B/2 - s B/2, so that the product is C1 C2 + S1 S2 q/2 + B (f1 + f2)/2
    + F (f1 - f2)/(l2 - l1), f1 = S1 C2, f2 = C1 S2. Errors of the last quotient are eps/(l2 - l1), and multiply an F
    of size l2 - l1: it is good also where the planes of B are not determined. Where l2 - l1 is rounding noise F need
    not be as small, and the quotient is its limit, or for small squares a series.

    Raises
    ------
    GradeError
        In more than five dimensions, or where both signatures of the metric have two vectors.
    """
    _require(b, invertibly=False)
    s, q, l1, l2, d = squares(b)
    c1, s1, c2, s2 = stumpff0(-l1), stumpff1(-l1), stumpff0(-l2), stumpff1(-l2)
    f1, f2 = s1 * c2, c1 * s2
    slope = select(d > least(b), (f1 - f2) / d, b.constant(0))
    regular = c1 * c2 + b * ((f1 + f2) / 2)
    if not q.terms:
        return regular - b * (s * slope / 2)
    slope = select(d > NEARLY_EQUAL * sqrt(epsilon(b)) * absolute(s), slope, _slope_of_equal(s / 2))
    small = are_planes_lost(b, d) & (d + absolute(s) < EXP_SMALL)
    slope = select(small, slope_of_small(s, (q * q).grade(0)), slope)
    difference = (q * b).grade(2) / 2 - b * (s / 2)
    return regular + q * (s1 * s2 / 2) + difference * slope


def _slope_of_equal(level: Multivector) -> Multivector:
    """Limit of (S1 C2 - C1 S2)/(l2 - l1) for l1, l2 towards one level l: (S^2 - C (C - S)/l)/2."""
    c, s = stumpff0(-level), stumpff1(-level)
    bent = select(absolute(level) > least(level), (c - s) / level, level.constant(1) / 3)
    return (s * s - c * bent) / 2


class Parts(NamedTuple):
    """A rotor R = (c1 + v1) (c2 + v2): a rotation by the half angle f in [0, pi] and a simple rotor with c2 >= 0.

    ``sine`` is |v1|, ``square`` v2^2. Where the rotation is a full turn but for rounding (``full``), v1 is zero.
    """

    f: Multivector
    c1: Multivector
    sine: Multivector
    v1: Multivector
    c2: Multivector
    v2: Multivector
    square: Multivector
    full: Mask


def parts(r: Multivector, invariants: Squares, at: NearParabolic | None = None) -> Parts:
    """Split R = r0 + V + r4, the bivector V = c2 v1 + c1 v2 first; then (c1 c2)^2 = r0^2, (c2 v1)^2 = r0^2 - c2^2.

    The order (and sign) with c2 >= |c1| is taken: half angles of a double rotation add up to pi at most.
    v2 = c1 (c1 v2) - v1 r4 needs no quotient by c1: half turns are like any other. Not for equal angles. With ``at``,
    angles and squares are those of `parabolic.lost` where the planes are (v1 and v2 are of no use there).
    """
    r0, v, r4 = r.grade(0), r.grade(2), r.grade(4)
    still = _is_rotation_noise(v, invariants, r0)
    rotation = _first_part(v, invariants, still)
    own = -square_of(rotation)  # l1 has the errors of V^2, which may be large beside it
    own = select(own > 0, own, select(still, r.constant(0), -invariants.l1))
    if at:
        own = select(at.here, at.turn * (1 + at.growth), own)
    c2 = sqrt(r0 * r0 + own)
    c1 = r0 / c2
    v2 = (v - rotation) * c1
    if r4.terms:
        v2 = v2 - (rotation * r4).grade(2) / c2
    root, square = sqrt(own), square_of(v2)
    if at:
        square = select(at.here, at.growth, square)
    return Parts(atan2(root, r0), c1, root / c2, rotation / c2, c2, v2, square, still & (r0 < 0))


def _first_part(v: Multivector, invariants: Squares, still: Mask) -> Multivector:
    """The simple part V1 of V with the lesser square; zero where all is still.

    V1 = (q V/2 - l1 V)/(l2 - l1). Remains of V2 in it, or a tilt out of V's planes, both from rounding, would be
    divided by a small sine later: so it is made to commute with V by a step of Newton's method, and simple by another.
    """
    s, q, l1, _, d = invariants
    zero = v.constant(0)
    inverse = select((d > least(v)) & ~still, 1 / d, zero)
    part = (q * v).grade(2) * (inverse / 2) - v * (l1 * inverse)
    if not q.terms:
        return part
    part = as_computed(part)
    # From plane to plane, X -> X x V has the eigenvalues +-sqrt(l1) +- sqrt(l2): a^4 - 2 s a^2 + d^2 = 0.
    tilt = as_computed(part.commutator(v)).commutator(v) * inverse
    part = as_computed(part - tilt * (2 * s * inverse) + tilt.commutator(v).commutator(v) * inverse)
    square = -square_of(part)
    excess = (part ^ part) * select(square > least(v), 1 / (2 * square), zero)
    return part + (excess * part).grade(2)


def _is_rotation_noise(v: Multivector, invariants: Squares, r0: Multivector) -> Mask:
    """Return whether the rotation in V is noise: V is simple and its square not negative, or R is a full turn."""
    noise = NOISE * epsilon(v)
    scale = absolute_product(v, v)
    simple = invariants.s >= -noise * scale.grade(0)
    for blade, value in invariants.q.terms.items():
        simple = simple & (absolute(v.new({0: value})) <= noise * v.new({0: scale.terms[blade]}))
    return simple | ((-invariants.l1 <= noise * noise) & (r0 < 0))


def log_rotor(r: Multivector) -> tuple[Multivector, Result]:
    """The b with exp(b) = r, for any unit rotor r; the angle of its rotation is in [0, 2 pi).

    The larger angle of two rotations is in [0, 2 pi), their sum at most 2 pi. The sign of r counts:
    exp(b) = r, not -r. NOT_UNIQUE: r is a full turn, alone or with a dilation or translation; a plane that commutes
    with it is chosen (see `commuting_plane`), e12 if there is nothing else. SINGULAR: no plane does (the negative of a
    translation in the plane, or of a dilation whose kind has no blades for a turn), or r is a double rotation whose
    angles add up to 2 pi, other than a full turn. INVALID: r ~r differs from 1 by more than the square root of the
    rounding unit.

    Raises
    ------
    GradeError
        In more than five dimensions, where both signatures have two vectors, and for degenerate metrics.
    """
    _require(r, invertibly=True)
    r = as_computed(r)
    valid = is_unit(r)
    r0, v = r.grade(0), r.grade(2)
    if not _may_rotate(r):
        b = v * _arc(square_of(v), absolute(r0))
        return _results(r, b, valid, r0 < 0, r0 > 0)
    invariants = squares(v)
    at = near_parabolic(r, invariants.d) if invariants.q.terms else None
    p = parts(r, invariants, at)
    zero, one = r.constant(0), r.constant(1)
    plane, possible = commuting_plane(p.v2)
    by_sine, by_sinh = select(p.sine > 0, p.f / p.sine, one), _arc(p.square, p.c2)
    b = p.v1 * by_sine + p.v2 * by_sinh + plane * select(p.full, p.f, zero)
    if not at:
        return _results(r, b, valid, p.full, possible)
    double, found = halves(r, invariants)
    double = double & ~at.small
    other = r.sum(h.v * select(h.sine > 0, h.f / h.sine, one) for h in found)
    b = select(double, other, select(at.here, log_of_lost(r, at, p.c1, p.c2, by_sine, by_sinh), b))
    return _results(r, b, valid, p.full, possible, double & has_half_turn(found))


def _may_rotate(r: Multivector) -> bool:
    """Return whether by the blades of r it may rotate: dilations and translations, from one center, do not."""
    return square_signs(r.grade(2))[0]


def _arc(square: Multivector, c: Multivector) -> Multivector:
    """b/v for a simple rotor c + v with v^2 = square and c >= 0: of an angle, of a dilation, or 1 between them."""
    length = sqrt(absolute(square))
    angle = atan2(length, c)
    x = length + square / (1 + sqrt(1 + absolute(square)))  # sinh g + cosh g - 1
    whole = as_computed(1 + x)
    added = as_computed(whole - 1)
    growth = select(added > 0, log(whole) * (x / added), x)  # log(1 + x) to rounding, for x of any size
    arc = select(square < 0, angle, growth)
    series = square.constant(_ARC[-1])
    for coefficient in _ARC[-2::-1]:
        series = series * square + coefficient
    return select(absolute(square) < ARC_SMALL, series, arc / length)


def sqrt_rotor(r: Multivector) -> tuple[Multivector, Result]:
    """exp(log(r)/2), with the statuses of `log_rotor`: half angles of both parts, without functions of angles."""
    _require(r, invertibly=True)
    r = as_computed(r)
    valid = is_unit(r)
    if not _may_rotate(r):
        r0 = r.grade(0)
        return _results(r, (1 + r) / sqrt(2 * (1 + absolute(r0))), valid, r0 < 0, r0 > 0)
    invariants = squares(r.grade(2))
    p = parts(r, invariants)
    plane, possible = commuting_plane(p.v2)
    cosine, scale = _half_angle(p.c1, p.sine)
    first = select(p.full, r.constant(0), cosine)
    v1 = p.v1 * select(p.full, r.constant(0), scale) + plane * select(p.full, r.constant(1), r.constant(0))
    second = sqrt((1 + p.c2) / 2)
    root = (first + v1) * (second + p.v2 / (2 * second))
    if not invariants.q.terms:
        return _results(r, root, valid, p.full, possible)
    double, found = halves(r, invariants)
    at = near_parabolic(r, invariants.d)
    double = double & ~at.small
    other = r.sum(h.i * cosine + h.v * scale for h in found for cosine, scale in [_half_angle(h.c, h.sine)])
    root = select(double, other, select(at.here, sqrt_of_lost(r), root))
    return _results(r, root, valid, p.full, possible, double & has_half_turn(found))


def _half_angle(c: Multivector, sine: Multivector) -> tuple[Multivector, Multivector]:
    """cos(f/2) and sin(f/2)/sin(f) for f in [0, pi], from cos(f) and sin(f)."""
    larger = sqrt((1 + absolute(c)) / 2)
    return select(c < 0, sine / (2 * larger), larger), select(c < 0, larger / sine, 1 / (2 * larger))


def _results(
    r: Multivector, value: Multivector, valid: Mask, full: Mask, possible: Mask, opposed: Mask | None = None
) -> tuple[Multivector, Result]:
    nowhere = full & ~possible
    if opposed is not None:
        nowhere = nowhere | opposed
    cases = [(~valid, Status.INVALID), (nowhere, Status.SINGULAR), (full, Status.NOT_UNIQUE)]
    return value * where_or_nan(valid & ~nowhere, r.constant(1)), outcome(r, *cases)
