"""Rotors that take one object to another (thesis chapter 2), and similarities (translation, rotation, scale; 4.10).

Objects are unit blades of one grade, rounds and flats alike. Where no unique rotor exists a turn of the first object
goes before; what is singular is measured by `margin`, in units of the rounding error's scale.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..multivector import Mask, Multivector, absolute, keep_scalar, select, sqrt
from ..status import Status
from ..trace import Result, row
from .blades import principal_root, project_sum, written_size
from .conformal import Checked, infinity, normalise_point, origin, round_center
from .euclidean import attached_part, axes, canonical_sign, cross, euclidean_part, space
from .motions import translator
from .outcome import NOISE, as_computed, epsilon, only_if, outcome, size
from .products import absolute_product


def gamma(x: Multivector) -> int:
    """x^2 of a unit object, for which x ~x = -1: +1 for point pairs, lines, circles, -1 for planes and spheres."""
    (k,) = x.grades
    return 1 if k * (k - 1) // 2 % 2 else -1


def is_hyper(x: Multivector) -> bool:
    """Whether x is the dual of a vector: planes and spheres; in the plane lines and circles."""
    return x.grades == (len(x.algebra.vectors) - 1,)


def plain_rotor(x1: Multivector, x2: Multivector) -> Multivector:
    """R = S (1 + gamma x2 x1)/sqrt(mu), with R x1 ~R = x2 and R = 1 for x1 = x2 (2.4, 2.6; printed S gives -R).

    With gamma x2 x1 = p0 + p2 + p4, K/2 = h = (1 + p0) + p4 commutes with everything here and 1 + gamma x2 x1 is
    h + p2; so R is (sqrt(h) + sqrt(h*) p2/[[h]])/sqrt(2), whose scalar part is not negative. Where p4 vanishes by
    the blades (planes, spheres) and h < 0, R takes x1 to -x2 (2.7). No statuses: NaN, or digits lost, where
    `margin` is small.
    """
    p0, p2, p4 = _parts(x1, x2)
    h0 = 1 + p0
    if not p4.terms:
        return _hyper_rotor(p0, p2, h0 < 0)
    if not (p4 * p4).terms:
        root = sqrt(h0 / 2)
        slope = 1 / (4 * root)
        return root + slope * p4 + ((2 * slope) * p2 - (slope / h0) * (p4 * p2).grade(2))
    norm = sqrt(h0 * h0 - (p4 * p4).grade(0))
    g4 = p4 / 2
    a, b = principal_root(h0 / 2, g4, norm / 2)
    quad, inverse = b * g4, 1 / norm
    return a + quad + ((a * inverse) * p2 - inverse * (quad * p2).grade(2))


def _parts(x1: Multivector, x2: Multivector) -> tuple[Multivector, Multivector, Multivector]:
    """Grades 0, 2 and 4 of gamma x2 x1."""
    product = gamma(x1) * (x2 * x1)
    return product.grade(0), product.grade(2), product.grade(4)


def _hyper_rotor(p0: Multivector, p2: Multivector, flipped: Mask) -> Multivector:
    """(1 + p0 + p2)/sqrt(2 + 2 p0), of p0 and p2 with the other sign where x1 is to go to -x2."""
    sign = select(flipped, p0.constant(-1), p0.constant(1))
    root = sqrt((1 + sign * p0) / 2)
    return root + (sign / (2 * root)) * p2


def margin(x1: Multivector, x2: Multivector) -> tuple[Multivector, Multivector]:
    """How far x1, x2 are from having no rotor or several, and the scale of its rounding errors.

    Of the eigenvalues of h (complex, or real where linked), the distance from zero and from the negative axis.
    `plain_rotor` loses its inverse in digits, once or twice; near the rounding unit of the scale no rotor is left.
    """
    p0, _, p4 = _parts(x1, x2)
    h0, scale = 1 + p0, 1 + absolute_product(x2, x1, keep_scalar)
    square = (p4 * p4).grade(0)
    if not square.terms:
        return h0, scale
    root = sqrt(absolute(square))
    return select(h0 < 0, root, (h0 * h0 - square) / (h0 + root)), scale


def rotor_between(x1: Multivector, x2: Multivector) -> tuple[Multivector, Result, Result]:
    """`plain_rotor` and what tells its rounding errors: a row of `margin` and the product of the objects' sizes.

    SINGULAR: the margin is zero to rounding (the value is of no use). NOT_UNIQUE: K0 <= 0 to rounding for spheres,
    unless both are flat: x1 goes to -x2.
    """
    p0, p2, _ = _parts(x1, x2)
    room, scale = margin(x1, x2)
    lost = ~(room > NOISE * epsilon(x1) * scale)
    rotor, written = plain_rotor(x1, x2), size(x1) * size(x2)
    if not is_hyper(x1):
        return rotor, row([room, written], "quality"), outcome(x1, (lost, Status.SINGULAR))
    flipped = lost & (placed(x1).is_round | placed(x2).is_round)
    rotor = _hyper_rotor(p0, p2, flipped)
    code = outcome(x1, (flipped, Status.NOT_UNIQUE), (lost, Status.SINGULAR))
    return rotor, row([select(flipped, 1 - p0, room), written], "quality"), code


def translation_between(x1: Multivector, x2: Multivector) -> Checked:
    """The translator from one point to another. SINGULAR: one is at infinity."""
    (a, first), (b, second) = normalise_point(x1), normalise_point(x2)
    code = select(first.value > 0, first.value, second.value)
    return translator(euclidean_part(b - a)), Result((code,), "status", "status")


def mirror_between(x1: Multivector, x2: Multivector) -> Checked:
    """S (x1 + x2)/sqrt(mu): the object M with M x1 M = gamma x2, the blade nearest the sum (2.4; 2.1 for gamma = 1).

    IMAGINARY, SINGULAR: as of `blades.project_sum`. Sigma comes from the computed sum, not from K = 2 + ..., which
    would lose twice as many digits near x2 = -x1.
    """
    return project_sum(as_computed(x1 + x2), written_size(x1, x2))


# -- where digits are lost -----------------------------------------------------------------------------------


def unit_rotor(r: Multivector) -> Multivector:
    """r (r ~r)^(-1/2), the root on the principal branch: the unit rotor at r, for r ~r near 1."""
    square = r * ~r
    s0, s4 = square.grade(0), square.grade(4)
    if not s4.terms:
        return r / sqrt(s0)
    if not (s4 * s4).terms:
        return r * (1 - s4 / (2 * s0)) / sqrt(s0)
    norm = sqrt(s0 * s0 - (s4 * s4).grade(0))
    p, q = principal_root(s0, s4, norm)
    return r * (p - q * s4) / norm


def refined_rotor(r: Multivector, x1: Multivector, x2: Multivector) -> Multivector:
    """Rotor from x1 to x2 near r, which does that with few digits: first r, then the rotor from there to x2."""
    first = unit_rotor(r)
    led = (first >> x1).grade(*x1.grades)  # by its blades alone, r could be more than a rotor
    return _from_geometry(plain_rotor(led, x2) * first)


def turned_rotor(x1: Multivector, x2: Multivector) -> Checked:
    """A rotor from x1 to x2 where no rotor, or more than one, is the direct one: x1 is turned first.

    By half a turn about an axis that is perpendicular to x1, through its centre (its point nearest the origin): that
    gives -x1, from which there is a rotor to x2, unless every object near is as singular (a circle and its own axis).
    Then by a quarter of a turn, which takes the axis of x1 into its plane. NOT_UNIQUE; SINGULAR: neither does.
    """
    half, quarter = turns(x1)
    after_half, after_quarter = half >> x1, quarter >> x1
    (room, scale), (other, other_scale) = margin(after_half, x2), margin(after_quarter, x2)
    take_other = 4 * room < other
    room, scale = select(take_other, other, room), select(take_other, other_scale, scale)
    by_half = plain_rotor(after_half, x2) * half
    r = by_half if is_hyper(x1) else select(take_other, plain_rotor(after_quarter, x2) * quarter, by_half)
    regular = room > NOISE * epsilon(x1) * scale
    r = _from_geometry(r) * only_if(regular, x1.constant(1))
    return r, outcome(x1, (~regular, Status.SINGULAR), (regular, Status.NOT_UNIQUE))


def turns(x: Multivector) -> tuple[Multivector, Multivector]:
    """Half a turn that takes x to -x, and a quarter turn in the same plane, that of the axis of x and an `upright`.

    Of a flat point the half turn is the inversion in the unit sphere about it, with the reflection in e1.
    """
    place = placed(x)
    upright = _upright(place.axis)
    plane = upright ^ place.axis
    move = translator(place.center)
    half, quarter = move >> plane, move >> ((1 + plane) / sqrt(x.constant(2)))
    if x.grades == (2,):
        inversion = move >> ((origin(x) - infinity(x) / 2) ^ axes(x)[0])
        half = select(place.has_axis, half, inversion)
    return half, quarter


def _from_geometry(r: Multivector) -> Multivector:
    """r or -r: <r>_0 >= 0, or the first coefficient that is not zero."""
    return r * canonical_sign(r)


# -- centre, axis and size -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Placed:
    """Where an object is: centre (of a flat the point nearest the origin), unit axis, 1/radius (of a flat 0).

    The axis is the normal of a circle or plane, the direction of a line or of a point pair. Spheres (e1 is given)
    and flat points (0) have none. 1/radius is negative for a sphere that is inside out.
    """

    center: Multivector
    axis: Multivector
    curvature: Multivector
    is_round: Mask
    has_axis: Mask


def placed(x: Multivector) -> Placed:
    """Centre, axis and curvature of an object, round or flat."""
    if is_hyper(x):
        return _placed_vector(x.dual())
    return _placed_bivector(x, x if x.grades == (2,) else x.dual())


def _nothing(like: Multivector) -> Mask:
    return like.constant(0) > like.constant(1)


def _placed_vector(d: Multivector) -> Placed:
    """Of a plane n + d n_inf or a sphere (C - r^2/2 n_inf)/r."""
    u, first = euclidean_part(d), axes(d)[0]
    weight = -(d | infinity(d))
    square = (u * u).grade(0)
    foot = u * attached_part(d)
    if not weight.terms:
        return Placed(foot, u, d.constant(0), _nothing(d), ~_nothing(d))
    noise = NOISE * epsilon(d)
    is_round = weight * weight > noise * noise * square
    axis = select(is_round, first, u / sqrt(only_if(~is_round, square)))
    center = select(is_round, u / only_if(is_round, weight), foot)
    return Placed(center, axis, select(is_round, weight, d.constant(0)), is_round, ~_nothing(d))


def _placed_bivector(x: Multivector, d: Multivector) -> Placed:
    """Of a point pair d, or of a line or circle x with the dual d."""
    if x.grades == (2,):
        foot, axis = euclidean_part(attached_part(d)), d.new({})
        weight = -d.scalar_product(infinity(d) ^ origin(d))
        foot = foot / only_if(absolute(weight) > 0, weight)
    else:
        axis = -(euclidean_part(d) * space(d)).grade(1)
        foot = cross(axis, attached_part(d))
    if not euclidean_part(d | infinity(d)).terms:
        return Placed(foot, axis, d.constant(0), _nothing(d), ~_nothing(d))
    center, u, _ = round_center(d)
    square, flat = (u * u).grade(0), euclidean_part(d)
    noise = NOISE * epsilon(d)
    is_round = square > noise * noise * flat.scalar_product(~flat)
    curvature = sqrt(square)
    return Placed(
        select(is_round, center, foot),
        select(is_round, u / only_if(is_round, curvature), axis),
        select(is_round, curvature, d.constant(0)),
        is_round,
        is_round if x.grades == (2,) else ~_nothing(d),
    )


def _upright(axis: Multivector) -> Multivector:
    """A unit vector perpendicular to a unit vector: the part of the basis vector that is least along it, normalised."""
    candidates = axes(axis)
    best, least = candidates[0], absolute(axis | candidates[0])
    for e in candidates[1:]:
        along = absolute(axis | e)
        nearer = along < least
        best, least = select(nearer, e, best), select(nearer, along, least)
    part = best - (best | axis) * axis
    return part / sqrt((part * part).grade(0))


# -- similarities ----------------------------------------------------------------------------------------------


def trs_rotor(x1: Multivector, x2: Multivector) -> Checked:
    """Translation, rotation and scaling that take x1 to x2 (4.10, with the dilation exp(-g/2 E0), g = ln(r2/r1)).

    T(c2) D R ~T(c1): the centres c, the scaling by r2/r1, the rotation R between the axes by the smallest angle.
    Flats are moved by their points nearest the origin, without scaling. NOT_UNIQUE: axes that are opposite (half a
    turn about the `upright` of the second); a sphere and one that is inside out (x1 goes to -x2). SINGULAR: a round
    and a flat.
    """
    a, b = placed(x1), placed(x2)
    same = (a.is_round & b.is_round) | (~a.is_round & ~b.is_round)
    ratio = select(a.is_round, a.curvature, x1.constant(1)) / select(b.is_round, b.curvature, x1.constant(1))
    root = sqrt(only_if(same, absolute(ratio)))
    scaling = (root + 1 / root - (root - 1 / root) * (infinity(x1) ^ origin(x1))) / 2
    turn, opposite = _turn(a.axis, b.axis)
    turn = select(a.has_axis & b.has_axis, turn, x1.constant(1))
    opposite = opposite & a.has_axis & b.has_axis
    r = translator(b.center) * (scaling * turn) * translator(-a.center)
    return _from_geometry(r), outcome(x1, (~same, Status.SINGULAR), (opposite | (ratio < 0), Status.NOT_UNIQUE))


def _turn(a: Multivector, b: Multivector) -> tuple[Multivector, Mask]:
    """Rotation of the unit vector a to b by the smallest angle, and whether they are opposite to rounding.

    b (a + b)/|a + b|, twice: a second time from where the first one led, for small |a + b| keep few digits.
    """
    sum_square = ((a + b) * (a + b)).grade(0)
    noise = NOISE * epsilon(a)
    opposite = sum_square <= noise * noise
    first = (1 + b * a) / sqrt(only_if(~opposite, sum_square))
    led = (first >> a).grade(1)
    second_sum = ((led + b) * (led + b)).grade(0)
    turn = (1 + b * led) / sqrt(second_sum) * first
    return select(opposite, _upright(b) ^ b, turn), opposite
