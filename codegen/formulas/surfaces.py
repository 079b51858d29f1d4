"""Surfaces evolved along curves of circles, of any degree n: constants, conditions for a ray to meet them, normals.

C' = sum c_k a^(n-k) b^k with b = t, a = 1 - t: controls with the binomial inside. -C' ~C' = S0 + w Q, with w = a b
where both ends are circles (blades), else w = 1. K = Q^2, s = sqrt(S0^2 - w^2 K), m = S0 + s; the circle itself is, up
to a positive weight, (m - w Q) C'. Polynomials are rows of coefficients of a^(d-k) b^k, first k = 0. The degree n and
w are known from their lengths; nothing else depends on n.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import comb

from ..homogeneous import HomogeneousRing, coefficients, parameters, polynomial, rate, value
from ..multivector import Multivector, absolute, from_values, select, sqrt
from ..trace import Result, row
from .conformal import infinity as ni
from .conformal import point
from .euclidean import euclidean_part as euclidean
from .rays import dot, dual_sphere, line, pair_parameters, zero

Scalars = Sequence[Multivector]
#: Coefficients of a trivector, and of the meet of a ray with one in the ray's own frame.
TRIVECTOR, MEET = 10, 3
#: Coefficients of Q.
QUAD = 5
#: Square of what u is at most for |C'| = 1 and a unit line through the origin; (1 + x^2)^2 as much at the distance x.
LINE = 16


def trivectors(numbers: Scalars) -> list[Multivector]:
    """Trivectors from a row of their coefficients."""
    algebra, ring = numbers[0].algebra, numbers[0].ring
    blades = algebra.kind("circle").blades
    rows = [numbers[i : i + TRIVECTOR] for i in range(0, len(numbers), TRIVECTOR)]
    return [from_values(algebra, ring, blades, [c.scalar() for c in values]) for values in rows]


def _flat(values: Sequence[Multivector], name: str) -> Result:
    """Trivectors as one row of numbers."""
    blades = values[0].algebra.kind("circle").blades
    return row([c.new({0: c.terms[b]} if b in c.terms else {}) for c in values for b in blades], name)


# -- constants of one surface --------------------------------------------------------------------------


def square_term(
    norm: Multivector, quad: Scalars, first: Multivector, last: Multivector, weight: Multivector
) -> tuple[Result, Result]:
    """Coefficients of S0 and w Q with the product of two controls added: -weight (C ~D + D ~C)/2."""
    square = -(weight / 2) * (first * ~last + last * ~first)
    q = _quad(quad) + square.grade(4)
    return row([norm + square.grade(0)], "norm_sum"), row(_quad_numbers(q), "quad_sum")


def kappa_term(kappa: Multivector, first: Scalars, last: Scalars, weight: Multivector) -> Result:
    """A coefficient of K with the product of two of Q's added."""
    return row([kappa + weight * dot(_quad(first), _quad(last))], "kappa_sum")


def product_term(product: Scalars, quad: Scalars, control: Multivector) -> Result:
    """A coefficient of Q C' with the product of one of Q's and a control added."""
    return _flat([trivectors(product)[0] + (_quad(quad) * control).grade(3)], "product_sum")


def _quad_blades(like: Multivector) -> list[int]:
    full = like.algebra.pseudoscalar
    return [full ^ b for b in like.algebra.kind("vector").blades]


def _quad(numbers: Scalars) -> Multivector:
    """A 4-vector from its coefficients."""
    like = numbers[0]
    return from_values(like.algebra, like.ring, _quad_blades(like), [c.scalar() for c in numbers])


def _quad_numbers(q: Multivector) -> list[Multivector]:
    return [q.new({0: q.terms[b]} if b in q.terms else {}) for b in _quad_blades(q)]


def evolved_sizes(norm: Scalars, kappa: Scalars, quad: Scalars, controls: Scalars, products: Scalars) -> Result:
    """Size of Q relative to the products that it is made of, and the most that the terms of p can add up to.

    The first is rounding where all circles lie on one sphere. The second is for unit lines through the origin.
    """
    c, qc = trivectors(controls), trivectors(products)
    q = [coefficient_product(x, x) for x in (_quad(quad[i : i + QUAD]) for i in range(0, len(quad), QUAD))]
    squares = [coefficient_product(x, x) for x in c]
    inner = squares[1:-1] if _ended(norm, kappa) else squares
    nothing = zero(norm[0])
    whole = nothing.sum(squares)
    pairs = (whole * whole - nothing.sum(x * x for x in squares)) / 2 + nothing.sum(x * x for x in inner)
    s0, k = (_largest([absolute(x) for x in part]) for part in (norm, kappa))
    b, e = (sqrt(_largest([coefficient_product(x, x) for x in part], square=True)) for part in (c, qc))
    w = nothing + (Fraction(1, 4) if _ended(norm, kappa) else 1)
    return row([sqrt(nothing.sum(q) / pairs), LINE * _both(1, b * b, b * e, e * e, s0, k, w)], "sizes")


def _largest(scaled: Scalars, square: bool = False) -> Multivector:
    """Largest of some numbers over the binomial coefficients of their place, or over their squares."""
    most = zero(scaled[0])
    for i, c in enumerate(scaled):
        part = c / comb(len(scaled) - 1, i) ** (2 if square else 1)
        most = select(part > most, part, most) if i else part
    return most


# -- constants of one ray and one surface --------------------------------------------------------------


def evolved_approach(origin: Multivector, direction: Multivector, center: Multivector, radius: Multivector) -> Result:
    """Parameter of the point of a ray nearest to a centre, and half the chord in its sphere; NaN for a miss."""
    relative = origin - center
    pair = line(relative, direction) & dual_sphere(zero(relative), radius * radius).undual()
    first, last = pair_parameters(pair, relative, direction)
    return row([(first + last) / 2, (last - first) / 2], "middle_half")


def evolved_ray(
    origin: Multivector, direction: Multivector, controls: Scalars, products: Scalars
) -> tuple[Result, Result]:
    """u = B.B, x = B.E, e = E.E for B = L v C', E = L v (Q C') of the unit line L, and the meets B, E themselves.

    A meet of L = X ^ D ^ n_inf is Y = w X + v D + h n_inf, three numbers: w, v, h.
    """
    x, n = point(origin), ni(origin)
    along = direction + dot(origin, direction) * n
    square = dot(direction, direction)
    frame = (direction ^ n) / square, n ^ x, x ^ along
    meets = [[_wedge(part, c) for part in frame] for c in (*trivectors(controls), *trivectors(products))]
    size, ring = len(controls) // TRIVECTOR, HomogeneousRing(origin.ring)
    (bw, bv, bh), (ew, ev, eh) = (
        [polynomial([y[i] for y in part], ring) for i in range(MEET)] for part in (meets[:size], meets[size:])
    )
    u, e = bv * bv - 2 * (bw * bh), ev * ev - 2 * (ew * eh)
    x_ = bv * ev - (bw * eh + ew * bh)
    lowest, highest = 2 * (size - 1), 2 * (len(meets) - size - 1)
    degrees = (u, lowest), (x_, (lowest + highest) // 2), (e, highest)
    scalars = [c for part, degree in degrees for c in coefficients(part, degree, origin.ring)]
    return row(scalars, "scalars"), row([c for y in meets for c in y], "meets")


def _wedge(part: Multivector, trivector: Multivector) -> Multivector:
    """(L . V) ^ C as a number: the inner product of V and the meet L v C, for V in the line L."""
    return (part ^ trivector).dual()


# -- polynomials ---------------------------------------------------------------------------------------


def evolved_polynomial(ray: Scalars, norm: Scalars, kappa: Scalars) -> Result:
    """Bernstein coefficients of p = 4 (S0 u - w x)(S0 e - K w x) + w^2 (K u - e)^2, the product of both branches.

    Of degree 12 n - 4. The printed polynomial without its spurious factor w^2 Q^2, and without a division.
    """
    u, x, e, s0, k, w = _polynomials(ray, norm, kappa)
    degree = _degree(norm, kappa)
    scaled = coefficients(_both(-1, u, x, e, s0, k, w), degree, ray[0].ring)
    return row([c / comb(degree, i) for i, c in enumerate(scaled)], "bernstein")


def evolved_polynomial_bound(ray: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """Sum of the absolute values of p's terms at (a, b): the scale of its rounding errors. It rises in both."""
    ray, norm, kappa = ([absolute(c) for c in part] for part in (ray, norm, kappa))
    return row([_both(1, *_values(ray, norm, kappa, a, b))], "bound")


def _degree(norm: Scalars, kappa: Scalars) -> int:
    """Degree of p: that of S0^2 u e."""
    return 4 * (len(norm) - 1) + len(kappa) - 1


def _both(
    minus: int, u: Multivector, x: Multivector, e: Multivector, s0: Multivector, k: Multivector, w: Multivector
) -> Multivector:
    """p for ``minus = -1``, or with 1 the same with all terms added."""
    difference = k * u + minus * e
    product = (s0 * u + minus * (w * x)) * (s0 * e + minus * (k * (w * x)))
    return 4 * product + w * w * (difference * difference)


def evolved_printed(ray: Scalars, norm: Scalars, kappa: Scalars) -> Result:
    """Coefficients of 1, t, t^2, .. of the printed polynomial of degree 12 n, (4.16) with its sides subtracted.

    With P = S0 B - w E and Q = B: (P^2 + s^2 Q^2)^2 - s^2 (P Q + Q P)^2.
    """
    u, x, e, s0, k, w = _polynomials(ray, norm, kappa)
    square = s0 * s0 - k * (w * w)
    p_square = s0 * s0 * u - 2 * (s0 * w) * x + w * w * e
    p_q = s0 * u - w * x
    even = p_square + square * u
    printed = even * even - 4 * (square * (p_q * p_q))
    return row(_powers(coefficients(printed, 6 * (len(norm) - 1), ray[0].ring)), "powers")


def _powers(scaled: Scalars) -> list[Multivector]:
    """Coefficients of 1, t, t^2, ... of sum h_k (1 - t)^(n-k) t^k."""
    n = len(scaled) - 1
    powers = []
    for j in range(n + 1):
        total = zero(scaled[0])
        for k in range(j + 1):
            total = total + (-1) ** (j - k) * comb(n - k, j - k) * scaled[k]
        powers.append(total)
    return powers


def _parts(ray: Scalars, norm: Scalars, kappa: Scalars) -> tuple[Scalars, ...]:
    """Coefficients of u, x and e."""
    u, x = len(norm), len(norm) + len(kappa) // 2
    return ray[:u], ray[u : u + x], ray[u + x :]


def _polynomials(ray: Scalars, norm: Scalars, kappa: Scalars) -> tuple[Multivector, ...]:
    """u, x, e, S0, K and w as polynomials."""
    a, b = parameters(ray[0].algebra, ray[0].ring)
    rows = (*_parts(ray, norm, kappa), norm, kappa)
    return (*(polynomial(part, a.ring) for part in rows), _weight(norm, kappa, a, b))


def _values(ray: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> tuple[Multivector, ...]:
    """u, x, e, S0, K and w at (a, b)."""
    rows = (*_parts(ray, norm, kappa), norm, kappa)
    return (*(value(part, a, b) for part in rows), _weight(norm, kappa, a, b))


def _weight(norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Multivector:
    """w: a b where the ends are circles."""
    return a * b if _ended(norm, kappa) else a.constant(1)


def _weight_rate(norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Multivector:
    return a - b if _ended(norm, kappa) else zero(a)


def _ended(norm: Scalars, kappa: Scalars) -> bool:
    """Whether the curve begins and ends with circles."""
    return len(kappa) < 2 * len(norm) - 1


# -- the condition that is not squared -----------------------------------------------------------------


def evolved_condition(ray: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """2 s^2 m f for f = (L v C)^2: m (m u - 2 w x) + w^2 e."""
    return row([_condition(*_values(ray, norm, kappa, a, b))[0]], "f")


def evolved_condition_rate(ray: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """The condition and its derivative by t."""
    u, x, e, s0, k, w = _values(ray, norm, kappa, a, b)
    du, dx, de, ds0, dk = (_rate(part, a, b) for part in (*_parts(ray, norm, kappa), norm, kappa))
    m, s = _branch(s0, k, w)
    dw = _weight_rate(norm, kappa, a, b)
    dm = (m * ds0 - (dk * (w * w) / 2 + k * (w * dw))) / s
    half = m * u - w * x
    first = 2 * (dm * half + w * dw * e - m * dw * x)
    return row([m * (half - w * x) + w * w * e, first + m * (m * du - 2 * w * dx) + w * w * de], "f_rate")


def evolved_condition_bound(ray: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """Sum of the absolute values of its terms: what its rounding error is relative to."""
    u, x, e = ([absolute(c) for c in part] for part in _parts(ray, norm, kappa))
    return row([_condition(*_values([*u, *(-c for c in x), *e], norm, kappa, a, b))[0]], "bound")


def evolved_meet_square(ray: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """f = (L v C)^2 itself, for the unit circle C."""
    f, m, s = _condition(*_values(ray, norm, kappa, a, b))
    return row([f / (2 * s * s * m)], "f")


def _condition(
    u: Multivector, x: Multivector, e: Multivector, s0: Multivector, k: Multivector, w: Multivector
) -> tuple[Multivector, ...]:
    """The condition, m and s."""
    m, s = _branch(s0, k, w)
    return m * (m * u - 2 * (w * x)) + w * w * e, m, s


def _branch(s0: Multivector, k: Multivector, w: Multivector) -> tuple[Multivector, Multivector]:
    """m = S0 + s and s. For S0 < 0 the sum cancels: there m = -K w^2/(s - S0)."""
    quad = k * (w * w)
    square = s0 * s0 - quad
    s = sqrt(select(square > 0, square, square.constant(0)))  # rounding may leave less than nothing
    return select(s0 >= 0, s0 + s, -quad / (s - s0)), s


def common_sphere_condition(u: Scalars, a: Multivector, b: Multivector) -> Result:
    """f of circles that lie on one sphere, Q = 0, up to a positive factor: u; and the sum of its absolute terms."""
    return row([value(u, a, b), value([absolute(c) for c in u], a, b)], "f_bound")


def common_sphere_polynomial(u: Scalars) -> Result:
    """Bernstein coefficients of u."""
    return row([c / comb(len(u) - 1, i) for i, c in enumerate(u)], "bernstein")


# -- the circle of a parameter -------------------------------------------------------------------------


def evolved_circle(
    norm: Scalars, kappa: Scalars, controls: Sequence[Multivector], products: Sequence[Multivector],
    a: Multivector, b: Multivector,
) -> Multivector:  # fmt: skip
    """The circle at (a, b), up to a positive weight: (m - w Q) C'."""
    w = _weight(norm, kappa, a, b)
    m, _ = _branch(value(norm, a, b), value(kappa, a, b), w)
    return m * value(controls, a, b) - w * value(products, a, b)


def evolved_circle_rate(
    norm: Scalars, kappa: Scalars, controls: Sequence[Multivector], products: Sequence[Multivector],
    a: Multivector, b: Multivector,
) -> Multivector:  # fmt: skip
    """Derivative of `evolved_circle` by t: dm = (m dS0 - d(K w^2)/2)/s divides by s only."""
    s0, k, w = value(norm, a, b), value(kappa, a, b), _weight(norm, kappa, a, b)
    m, s = _branch(s0, k, w)
    dw = _weight_rate(norm, kappa, a, b)
    ds0, dk, dc, dqc = (_rate(part, a, b) for part in (norm, kappa, controls, products))
    dm = (m * ds0 - (dk * (w * w) / 2 + k * (w * dw))) / s
    return dm * value(controls, a, b) + m * dc - dw * value(products, a, b) - w * dqc


def _rate(coefficients: Sequence[Multivector], a: Multivector, b: Multivector) -> Multivector:
    return value(rate(coefficients), a, b) if len(coefficients) > 1 else zero(coefficients[0])


def circle_center(round_: Multivector) -> Multivector:
    """Centre of a circle of any weight: the image of infinity."""
    image = (round_ * ni(round_) * round_).grade(1)
    return euclidean(image) / -dot(image, ni(image))


def circle_square(round_: Multivector) -> Multivector:
    """Squared radius of a circle of any weight."""
    carrier = round_ ^ ni(round_)
    return -dot(round_, round_) / dot(carrier, carrier)


def coefficient_product(x: Multivector, y: Multivector) -> Multivector:
    """Sum of products of coefficients: a plain, positive measure of residuals."""
    total = zero(x)
    for name, coefficient in x.terms.items():
        if name in y.terms:
            total = total + x.new({0: coefficient}) * y.new({0: y.terms[name]})
    return total
