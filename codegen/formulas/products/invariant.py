"""Exponential, logarithm and square root of every rotor of an algebra of up to five dimensions: rotations, dilations,
translations, transversions and all that they make, by invariant decomposition.

A bivector is a sum of two simple ones that commute, B = B1 + B2 with squares l1 and l2, if one signature of the metric
has at most one vector; the rotor is then the product of two simple ones. Motors have shorter forms in `exponentials`.
"""

from __future__ import annotations

from typing import NamedTuple

from ..errors import GradeError
from ..multivector import Mask, Multivector, absolute, atan2, log, select, sqrt, stumpff0, stumpff1
from ..status import Status
from ..trace import Result
from .exponentials import is_unit, square_signs
from .outcome import NOISE, as_computed, epsilon, only_if, outcome
from .products import absolute_product
from .turns import turn_plane

#: Invariant decomposition needs B^2 = scalar + grade 4 whose square is a scalar: so in five dimensions and fewer.
MOST_DIMENSIONS = 5
#: Squares of two simple parts that differ by less than this many roots of the rounding unit, relative to their sum:
#: the difference is noise below one of them, and above as many its cube is no error.
NEARLY_EQUAL = 32


def decomposes(like: Multivector, invertibly: bool = False) -> bool:
    """Whether each bivector of the algebra is a real sum of two commuting simple ones (or is simple)."""
    p, q, r = like.algebra.signature
    return p + q + r <= MOST_DIMENSIONS and min(p, q) <= 1 and not (invertibly and r)


def _require(like: Multivector, invertibly: bool) -> None:
    if not decomposes(like, invertibly):
        which = "non-degenerate signatures (p, 1), (1, q)" if invertibly else "signatures (p, 1, r), (1, q, r)"
        raise GradeError(
            f"bivectors of {like.algebra.name} are no sums of two simple ones that the closed form knows: it is for "
            f"{which} and definite ones of up to {MOST_DIMENSIONS} dimensions."
        )


def _least(like: Multivector) -> Multivector:
    """Squares and their differences below this are none: their quotients might underflow, and 1 does not see them."""
    return epsilon(like) * epsilon(like) * epsilon(like) * epsilon(like)


class Squares(NamedTuple):
    """The squares l1 <= l2 of the simple parts of a bivector B, and their difference d >= 0; B^2 = s + q."""

    s: Multivector
    q: Multivector
    l1: Multivector
    l2: Multivector
    d: Multivector


def squares(b: Multivector) -> Squares:
    """l1, l2 = (s -+ d)/2 with d^2 = s^2 - q^2, the smaller in size from l1 l2 = q^2/4: nothing is subtracted.

    Where l1 and l2 nearly agree, d has half of the digits only: what is made of them must be symmetric.
    """
    square = b * b
    s, q = square.grade(0), square.grade(4)
    q2 = (q * q).grade(0)
    d = sqrt(absolute(s * s - q2))
    negative = s < 0
    large = (s + select(negative, -d, d)) / 2
    small = select(absolute(large) > _least(b), q2 / (4 * large), b.constant(0))
    return Squares(s, q, select(negative, large, small), select(negative, small, large), d)


def exp_bivector(b: Multivector) -> Multivector:
    """exp(B) = (C1 + S1 B1) (C2 + S2 B2) with C = cosh(sqrt l), S = sinh(sqrt l)/sqrt l, for any signs of l1, l2.

    B1 - B2 = 2 F/(l2 - l1) with F = q B/2 - s B/2, so that the product is C1 C2 + S1 S2 q/2 + B (f1 + f2)/2
    + F (f1 - f2)/(l2 - l1), f1 = S1 C2, f2 = C1 S2. Errors of the last quotient are eps/(l2 - l1), and multiply an F
    of size l2 - l1: it is good also where the planes of B are not determined. Where l2 - l1 is rounding noise F need
    not be as small, and the quotient is its limit.

    Raises
    ------
    GradeError
        In more than five dimensions, or where both signatures of the metric have two vectors.
    """
    _require(b, invertibly=False)
    s, q, l1, l2, d = squares(b)
    c1, s1, c2, s2 = stumpff0(-l1), stumpff1(-l1), stumpff0(-l2), stumpff1(-l2)
    f1, f2 = s1 * c2, c1 * s2
    slope = select(d > _least(b), (f1 - f2) / d, b.constant(0))
    regular = c1 * c2 + b * ((f1 + f2) / 2)
    if not q.terms:
        return regular - b * (s * slope / 2)
    slope = select(d > NEARLY_EQUAL * sqrt(epsilon(b)) * absolute(s), slope, _slope_of_equal(s / 2))
    difference = (q * b).grade(2) / 2 - b * (s / 2)
    return regular + q * (s1 * s2 / 2) + difference * slope


def _slope_of_equal(level: Multivector) -> Multivector:
    """Limit of (S1 C2 - C1 S2)/(l2 - l1) for l1, l2 towards one level l: (S^2 - C (C - S)/l)/2."""
    c, s = stumpff0(-level), stumpff1(-level)
    bent = select(absolute(level) > _least(level), (c - s) / level, level.constant(1) / 3)
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


def parts(r: Multivector, known: Squares) -> Parts:
    """Split R = r0 + V + r4, the bivector V = c2 v1 + c1 v2 first; then (c1 c2)^2 = r0^2, (c2 v1)^2 = r0^2 - c2^2.

    Of the two orders (and signs) the one with c2 >= |c1| is taken: half angles of a double rotation add up to pi at
    most. v2 = c1 (c1 v2) - v1 r4 needs no quotient by c1: half turns are like any other. Not for equal angles.
    """
    r0, v, r4 = r.grade(0), r.grade(2), r.grade(4)
    still = _no_turn(v, known, r0)
    rotation = _first_part(v, known, still)
    own = -_square(rotation)  # l1 has the errors of V^2, which may be large beside it
    own = select(own > 0, own, select(still, r.constant(0), -known.l1))
    c2 = sqrt(r0 * r0 + own)
    c1 = r0 / c2
    v2 = (v - rotation) * c1
    if r4.terms:
        v2 = v2 - (rotation * r4).grade(2) / c2
    root = sqrt(own)
    return Parts(atan2(root, r0), c1, root / c2, rotation / c2, c2, v2, _square(v2), still & (r0 < 0))


def _first_part(v: Multivector, known: Squares, still: Mask) -> Multivector:
    """The simple part V1 of V with the lesser square; zero where all is still.

    V1 = (q V/2 - l1 V)/(l2 - l1). What rounding leaves of V2 in it, or tilts it out of V's planes, would be divided
    by a small sine later: so it is made to commute with V by a step of Newton's method, and simple by another.
    """
    s, q, l1, _, d = known
    zero = v.constant(0)
    inverse = select((d > _least(v)) & ~still, 1 / d, zero)
    part = (q * v).grade(2) * (inverse / 2) - v * (l1 * inverse)
    if not q.terms:
        return part
    part = as_computed(part)
    # From plane to plane, X -> X x V has the eigenvalues +-sqrt(l1) +- sqrt(l2): a^4 - 2 s a^2 + d^2 = 0.
    tilt = as_computed(part.commutator(v)).commutator(v) * inverse
    part = as_computed(part - tilt * (2 * s * inverse) + tilt.commutator(v).commutator(v) * inverse)
    square = -_square(part)
    excess = (part ^ part) * select(square > _least(v), 1 / (2 * square), zero)
    return part + (excess * part).grade(2)


def _no_turn(v: Multivector, known: Squares, r0: Multivector) -> Mask:
    """Whether the rotation in V is rounding noise: V is simple and its square not negative, or R is a full turn."""
    noise = NOISE * epsilon(v)
    scale = absolute_product(v, v)
    simple = known.s >= -noise * scale.grade(0)
    for blade, value in known.q.terms.items():
        simple = simple & (absolute(v.new({0: value})) <= noise * v.new({0: scale.terms[blade]}))
    return simple | ((-known.l1 <= noise * noise) & (r0 < 0))


class Half(NamedTuple):
    """One half of a double rotation: R i = (c + v) i with the idempotent i, and the angle of c + v in [0, pi]."""

    i: Multivector
    c: Multivector
    v: Multivector
    sine: Multivector
    f: Multivector


def halves(r: Multivector, known: Squares) -> tuple[Mask, list[Half]]:
    """Where R is two rotations by angles that nearly agree, or add up to nearly a turn; and R as sum of two halves.

    There the planes are badly determined, but the 4-vector of both together, J with J^2 = 1, is not: R is the sum of
    R (1 + J)/2 and R (1 - J)/2, whose bivectors have angles f - g and f + g. Each is projected twice, so that a small
    one has no rounding of the other left in it.
    """
    r0, v, r4 = r.grade(0), r.grade(2), r.grade(4)
    r4_squared = (r4 * r4).grade(0)
    least = epsilon(r) * epsilon(r)  # a square that can be squared
    double = (2 * known.d < -known.s) & (known.s < -least) | (2 * r4_squared > 1)  # there s may be noise above zero
    by_r4 = 4 * r0 * r0 < 1
    both = select(by_r4, r4, known.q)
    j = both / sqrt(select(by_r4, r4_squared, (known.q * known.q).grade(0)))
    cosine = (r4 * j).grade(0)
    found = []
    across = (v * j).grade(2)
    for sign in (1, -1):
        half = as_computed((v + across * sign) / 2)
        turned = (half * j).grade(2)
        half = ((turned * j).grade(2) + turned * sign) / 2
        c, sine = r0 + cosine * sign, sqrt(-2 * _square(half))
        found.append(Half((1 + j * sign) / 2, c, half, sine, atan2(sine, c)))
    return double, found


def log_rotor(r: Multivector) -> tuple[Multivector, Result]:
    """The b with exp(b) = r, for any unit rotor r; the angle of its rotation is in [0, 2 pi).

    Of two rotations the larger has an angle in [0, 2 pi) and both together at most 2 pi. The sign of r counts:
    exp(b) = r, not -r. NOT_UNIQUE: r is a full turn, alone or with a dilation or translation; a plane that commutes
    with it is chosen (see `turn_plane`), e12 if there is nothing else. SINGULAR: no plane does (the negative of a
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
    if not _has_turns(r):
        b = v * _arc(_square(v), absolute(r0))
        return _finished(r, b, valid, r0 < 0, r0 > 0)
    known = squares(v)
    p = parts(r, known)
    zero, one = r.constant(0), r.constant(1)
    plane, possible = turn_plane(p.v2)
    b = p.v1 * select(p.sine > 0, p.f / p.sine, one) + p.v2 * _arc(p.square, p.c2) + plane * select(p.full, p.f, zero)
    if not known.q.terms:
        return _finished(r, b, valid, p.full, possible)
    double, found = halves(r, known)
    other = r.sum(h.v * select(h.sine > 0, h.f / h.sine, one) for h in found)
    return _finished(r, select(double, other, b), valid, p.full, possible, double & _opposed(found))


def _has_turns(r: Multivector) -> bool:
    """Whether by the blades of r it may rotate: dilations and translations, from one centre, do not."""
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
    return select(length > 0, arc / length, square.constant(1))


def sqrt_rotor(r: Multivector) -> tuple[Multivector, Result]:
    """exp(log(r)/2), with the statuses of `log_rotor`: half angles of both parts, without functions of angles."""
    _require(r, invertibly=True)
    r = as_computed(r)
    valid = is_unit(r)
    if not _has_turns(r):
        r0 = r.grade(0)
        return _finished(r, (1 + r) / sqrt(2 * (1 + absolute(r0))), valid, r0 < 0, r0 > 0)
    known = squares(r.grade(2))
    p = parts(r, known)
    plane, possible = turn_plane(p.v2)
    cosine, scale = _half_angle(p.c1, p.sine)
    first = select(p.full, r.constant(0), cosine)
    v1 = p.v1 * select(p.full, r.constant(0), scale) + plane * select(p.full, r.constant(1), r.constant(0))
    second = sqrt((1 + p.c2) / 2)
    root = (first + v1) * (second + p.v2 / (2 * second))
    if not known.q.terms:
        return _finished(r, root, valid, p.full, possible)
    double, found = halves(r, known)
    other = r.sum(h.i * cosine + h.v * scale for h in found for cosine, scale in [_half_angle(h.c, h.sine)])
    return _finished(r, select(double, other, root), valid, p.full, possible, double & _opposed(found))


def _half_angle(c: Multivector, sine: Multivector) -> tuple[Multivector, Multivector]:
    """cos(f/2) and sin(f/2)/sin(f) for f in [0, pi], from cos(f) and sin(f)."""
    larger = sqrt((1 + absolute(c)) / 2)
    return select(c < 0, sine / (2 * larger), larger), select(c < 0, larger / sine, 1 / (2 * larger))


def _opposed(found: list[Half]) -> Mask:
    """Whether a half of a double rotation is -1, so that its plane is any."""
    first, second = ((h.sine <= NOISE * epsilon(h.c)) & (h.c < 0) for h in found)
    return first | second


def _square(b: Multivector) -> Multivector:
    return (b * b).grade(0)


def _finished(
    r: Multivector, value: Multivector, valid: Mask, full: Mask, possible: Mask, opposed: Mask | None = None
) -> tuple[Multivector, Result]:
    nowhere = full & ~possible
    if opposed is not None:
        nowhere = nowhere | opposed
    cases = [(~valid, Status.INVALID), (nowhere, Status.SINGULAR), (full, Status.NOT_UNIQUE)]
    return value * only_if(valid & ~nowhere, r.constant(1)), outcome(r, *cases)
