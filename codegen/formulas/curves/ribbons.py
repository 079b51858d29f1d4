"""Ribbons, surfaces evolved along curves of point pairs of any degree n (thesis 4.7): conditions, points, normals.

Polynomials, C', S0, w, Q, K, s and m = S0 + s are those of surfaces.py, on bivectors: the meets B = L v C' and
E = L v (Q C') are scalars, and a ray L meets the carrier line of the pair (m - w Q) C' where m B = w E. The ribbon is
made of the segments between the end points, not of the whole carriers.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb
from typing import NamedTuple

from ...algebra.multivector import Multivector, absolute, select, sqrt
from ...rings.bernstein import HomogeneousRing
from ...trace.outputs import Result, named, row
from ..objects.conformal import infinity as ni
from ..objects.conformal import origin as no
from ..objects.conformal import point
from ..objects.euclidean import dot
from ..products.outcome import epsilon
from ..products.sizes import sizes
from ..rays.rays import line, line_direction, unit
from .homogeneous import Bivectors, Scalars, coefficients, from_row, parameters, polynomial, value
from .rulings import carrier_motion, carriers, parallel_parameters, plane_normal, volume_of
from .surface_conditions import powers
from .surfaces import branch, branch_at, center_of_round, evolved_circle, evolved_circle_rate, weight

#: Spacings that a meet may be off 0, relative to its terms, and be taken for 0: products, sums, the ray's moment.
MEET = 8
#: Squared roundings, relative to the normal in the middle of a segment, below which a point has no normal of its own.
NO_NORMAL = 1 << 12


def bivectors(numbers: Scalars) -> list[Multivector]:
    """Bivectors from a row of their coefficients."""
    return from_row(numbers, "point_pair")


# -- constants of one ray and one surface --------------------------------------------------------------


class Levers(NamedTuple):
    """What rounding may leave of B and of E: a part by the size of the ray's origin, and the rest."""

    controls_by_origin: Multivector
    controls: Multivector
    products_by_origin: Multivector
    products: Multivector


def ribbon_ray(
    origin: Multivector, direction: Multivector, controls: Bivectors, products: Bivectors, levers: Levers
) -> tuple[Result, Result]:
    """B = L v C' and E = L v (Q C'), for a line of the direction's weight, and what rounding may leave of each."""
    ray = line(origin, direction)
    meets = [(ray & c).grade(0) for c in (*bivectors(controls), *bivectors(products))]
    width, length = MEET * epsilon(origin) * sizes(direction)[1], sizes(origin)[1]
    noise = [width * (levers[i] * length + levers[i + 1]) for i in (0, 2)]
    return row(meets, "meets"), row(noise, "noise")


def _parts(meets: Scalars, norm: Scalars) -> tuple[Scalars, Scalars]:
    """Coefficients of B and of E."""
    size = (len(norm) + 1) // 2
    return meets[:size], meets[size:]


def _polynomials(meets: Scalars, norm: Scalars, kappa: Scalars) -> tuple[Multivector, ...]:
    """B, E, S0, K and w as polynomials."""
    a, b = parameters(meets[0].algebra, meets[0].ring)
    rows, ring = (*_parts(meets, norm), norm, kappa), HomogeneousRing(meets[0].ring)
    return (*(polynomial(part, ring) for part in rows), weight(norm, kappa, a, b))


# -- polynomials ---------------------------------------------------------------------------------------


def ribbon_polynomial(meets: Scalars, norm: Scalars, kappa: Scalars) -> Result:
    """Bernstein coefficients of p = w (E^2 + K B^2) - 2 S0 B E, the product of both branches over w.

    Its degree is 6 n - 2 (6 n where the ends are no pairs).
    """
    b, e, s0, k, w = _polynomials(meets, norm, kappa)
    degree = 2 * (len(norm) - 1) + (len(kappa) - 1) // 2
    scaled = coefficients(w * (e * e + k * (b * b)) - 2 * (s0 * (b * e)), degree, meets[0].ring)
    return row([c / comb(degree, i) for i, c in enumerate(scaled)], "bernstein")


def ribbon_polynomial_bound(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """Sum of the absolute values of p's terms at (a, b): the scale of its rounding errors. It rises in both."""
    meets, norm, kappa = ([absolute(c) for c in part] for part in (meets, norm, kappa))
    b_, e, s0, k, w = _values(meets, norm, kappa, a, b)
    return row([w * (e * e + k * (b_ * b_)) + 2 * (s0 * (b_ * e))], "bound")


def ribbon_published_polynomial(meets: Scalars, norm: Scalars, kappa: Scalars) -> Result:
    """Coefficients of 1, t, t^2, .. of the published polynomial of degree 6 n, (4.31): (S0 B - w E)^2 - s^2 B^2."""
    b, e, s0, k, w = _polynomials(meets, norm, kappa)
    other = s0 * b - w * e
    polynomial = other * other - (s0 * s0 - k * (w * w)) * (b * b)
    return row(powers(coefficients(polynomial, 3 * (len(norm) - 1), meets[0].ring)), "powers")


# -- the condition that is not squared -----------------------------------------------------------------


def _values(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> tuple[Multivector, ...]:
    """B, E, S0, K and w at (a, b)."""
    rows = (*_parts(meets, norm), norm, kappa)
    return (*(value(part, a, b) for part in rows), weight(norm, kappa, a, b))


def ribbon_condition(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """m B - w E: L v P for the pair P, up to a positive weight."""
    b_, e, s0, k, w = _values(meets, norm, kappa, a, b)
    m, _ = branch(s0, k, w)
    return row([m * b_ - w * e], "f")


def ribbon_condition_bound(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """Scale of its rounding error: the absolute values of its terms, and of those of S0, dm = m dS0/s."""
    b_, e, s0, k, w = _values([absolute(c) for c in meets], norm, kappa, a, b)
    m, s = branch(s0, k, w)
    written = value([absolute(c) for c in norm], a, b)
    lost = select(s > 0, m * written / s, written)
    return row([(m + lost) * b_ + w * e], "bound")


def ribbon_meet(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """L v P itself, for the unit pair P."""
    b_, e, s0, k, w = _values(meets, norm, kappa, a, b)
    m, s = branch(s0, k, w)
    return row([(m * b_ - w * e) / (s * sqrt(2 * m))], "f")


def ribbon_closed_alpha(meets: Scalars) -> Result:
    """t of the pair whose carrier a ray meets, for two pairs on one circle (4.7.3)."""
    return row([meets[0] / (meets[0] - meets[1])], "alpha")


# -- the pair of a parameter ---------------------------------------------------------------------------


def ribbon_pair(
    norm: Scalars, kappa: Scalars, controls: Sequence[Multivector], products: Sequence[Multivector],
    a: Multivector, b: Multivector,
) -> Multivector:  # fmt: skip
    """The pair at (a, b), up to a positive weight: (m - w Q) C'. Its square is 2 m s^2."""
    return evolved_circle(norm, kappa, controls, products, a, b)


def pair_half_square(
    norm: Scalars, kappa: Scalars, pair: Multivector, a: Multivector, b: Multivector
) -> Multivector:  # fmt: skip
    """Squared half of the distance between the end points of `ribbon_pair`. Good on intervals.

    F^2 over that of its carrier F ^ n_inf, with F^2 = 2 m s^2 from the norm: of the coefficients of a short pair,
    rounding is all that is left of its length.
    """
    m, s = branch_at(norm, kappa, a, b)
    carrier = pair ^ ni(pair)
    return 2 * m * (s * s) / dot(carrier, carrier)


# -- the point and the normal --------------------------------------------------------------------------


def ribbon_point(
    origin: Multivector, direction: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Bivectors, products: Bivectors,
) -> tuple[Result, ...]:  # fmt: skip
    """Point of a ray nearest to a root's carrier: t, `_lengths` and distance there; position, sine squared.

    X ^ L_C for X = origin + t direction is a plane through the carrier, of normal n + t k: it is least there. The sine
    is that between ray and carrier.
    """
    pair = ribbon_pair(norm, kappa, bivectors(controls), bivectors(products), a, b)
    carrier = pair ^ ni(pair)
    n, k = plane_normal((origin + no(origin)) ^ carrier), plane_normal(direction ^ carrier)
    tilt = dot(k, k)
    t = -dot(n, k) / tilt
    position, weight, off = origin + t * direction, dot(carrier, carrier), n + t * k
    lengths = [*_lengths(position, pair, norm, kappa, a, b), sqrt(dot(off, off) / weight)]
    sine = tilt / (dot(direction, direction) * weight)
    return row([t, *lengths], "t_place"), named("position", position), row([sine], "sine_square")


def ribbon_position(
    position: Multivector, direction: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Bivectors, products: Bivectors,
) -> Result:  # fmt: skip
    """Offset of a position on a pair's carrier from the pair's middle, along the carrier; half of the pair's length.

    And the squared sine between a direction and the carrier.
    """
    pair = ribbon_pair(norm, kappa, bivectors(controls), bivectors(products), a, b)
    along, turn = line_direction(pair ^ ni(pair)), plane_normal(direction ^ (pair ^ ni(pair)))
    sine = dot(turn, turn) / (dot(direction, direction) * dot(along, along))
    return row([*_lengths(position, pair, norm, kappa, a, b), sine], "place")


def _lengths(
    position: Multivector, pair: Multivector, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector
) -> list[Multivector]:
    along = unit(line_direction(pair ^ ni(pair)))
    return [dot(position - center_of_round(pair), along), sqrt(pair_half_square(norm, kappa, pair, a, b))]


def ribbon_ends(
    origin: Multivector, direction: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Bivectors, products: Bivectors,
) -> Result:  # fmt: skip
    """For a ray along the carrier of a pair: where it passes the pair's middle, half of it in t, its distance there.

    Then both t where the carrier's motion points from it to the ray: there the ray meets carriers of pairs near this
    one, of places far from each other. Then the step of b to the carrier that is nearest to the ray along the segment,
    and the squared sine between ray and carrier.
    """
    arguments = norm, kappa, bivectors(controls), bivectors(products), a, b
    pair, rate = evolved_circle(*arguments), evolved_circle_rate(*arguments)
    square, towards = dot(direction, direction), center_of_round(pair) - origin
    middle = dot(towards, direction) / square
    beside = towards - middle * direction
    half_square = pair_half_square(norm, kappa, pair, a, b) / square
    m, off, by_t, motion, turn = carrier_motion(origin + middle * direction, direction, pair, rate)
    step = -(dot(off, motion) + half_square * dot(by_t, turn)) / (dot(motion, motion) + half_square * dot(turn, turn))
    sine = dot(by_t, by_t) / (square * dot(m, m))
    starts = (middle + t for t in parallel_parameters(m, off, by_t, motion, turn))
    return row([middle, sqrt(half_square), sqrt(dot(beside, beside)), *starts, step, sine], "ends")


def ribbon_polish(
    origin: Multivector, direction: Multivector, t: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Bivectors, products: Bivectors,
) -> Result:  # fmt: skip
    """Newton step (dt, db) towards X ^ L_C = 0 for X = origin + t direction.

    For rays that are nearly parallel to the carrier: there roots lie close together, and t from the root alone
    loses the square of the angle. The third number is the squared sine between the changes of X ^ L_C with t and with
    b: both agree where the ribbon is flat, and nothing is known of the step.
    """
    arguments = norm, kappa, bivectors(controls), bivectors(products), a, b
    pair, rate = evolved_circle(*arguments), evolved_circle_rate(*arguments)
    m, off, by_t, by_b, _ = carrier_motion(origin + t * direction, direction, pair, rate)
    volume, dt, db = (volume_of(m, x, y) for x, y in ((by_t, by_b), (off, by_b), (by_t, off)))
    apart = volume * volume / (dot(m, m) * dot(by_t, by_t) * dot(by_b, by_b))
    return row([-dt / volume, -db / volume, apart], "step")


def ribbon_normal(
    position: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Bivectors, products: Bivectors,
) -> Multivector:  # fmt: skip
    """Unit normal at a position on the ribbon: of the carrier L_C and of dX = X . (L_C dL_C).

    The weight of L_C and its rate do not matter: they add a scalar to L_C dL_C. Where the carrier turns about the
    position itself, as about a corner shared by all pairs, it is the normal in the middle of the pair.
    """
    arguments = norm, kappa, bivectors(controls), bivectors(products), a, b
    pair, rate = evolved_circle(*arguments), evolved_circle_rate(*arguments)
    carrier, turned = carriers(pair, rate)
    omega = (carrier * turned).grade(2)
    here, middle = (_across(x, carrier, omega) for x in (position, center_of_round(pair)))
    least = NO_NORMAL * epsilon(position) * epsilon(position)
    return unit(select(dot(here, here) > least * dot(middle, middle), here, middle))


def _across(position: Multivector, carrier: Multivector, omega: Multivector) -> Multivector:
    """Normal of the carrier and of the velocity of a position under omega."""
    x = point(position)
    velocity = (x | omega) ^ x ^ ni(x)
    return line_direction((velocity * carrier).grade(2) * x.pseudoscalar())
