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
from ..trace import Result, named, row
from .conformal import infinity as ni
from .conformal import point
from .euclidean import euclidean_part as euclidean
from .outcome import epsilon
from .rays import dot, dual_sphere, line, pair_parameters, zero

Scalars = Sequence[Multivector]
#: Coefficients of a trivector, and of the meet of a ray with one in the ray's own frame.
TRIVECTOR, MEET = 10, 3
#: Coefficients of Q.
QUAD = 5
#: Square of what u is at most for |C'| = 1 and a unit line through the origin; (1 + x^2)^2 as much at the distance x.
LINE = 16
#: Within that many spacings at 1 the condition is zero to rounding; roots.h counts in halves of them.
TOUCH = 8


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


def evolved_nearest(origin: Multivector, direction: Multivector) -> tuple[Result, Result]:
    """Parameter of the point of a ray nearest to the origin of the frame, and that point.

    From there meets have the smallest coefficients, wherever the surface reaches.
    """
    t = -dot(origin, direction) / dot(direction, direction)
    return row([t], "t"), named("nearest", origin + t * direction)


def evolved_approach(origin: Multivector, direction: Multivector, center: Multivector, radius: Multivector) -> Result:
    """Parameter of the point of a ray nearest to a centre, and half the chord in its sphere; NaN for a miss."""
    relative = origin - center
    pair = line(relative, direction) & dual_sphere(zero(relative), radius * radius).undual()
    first, last = pair_parameters(pair, relative, direction)
    return row([(first + last) / 2, (last - first) / 2], "middle_half")


def evolved_meets(origin: Multivector, direction: Multivector, controls: Scalars, products: Scalars) -> Result:
    """Coefficients of the meets B = L v C' and E = L v (Q C') of the unit line L = X ^ D ^ n_inf.

    A meet is Y = w X + v D + h n_inf, three numbers: w, v, h.
    """
    frame = _line_frame(origin, direction)
    return row([_wedge(part, c) for c in (*trivectors(controls), *trivectors(products)) for part in frame], "meets")


def _line_frame(origin: Multivector, direction: Multivector) -> tuple[Multivector, ...]:
    """The bivectors of which the outer products with a trivector are w, v and h of the meet."""
    x, n = point(origin), ni(origin)
    along = direction + dot(origin, direction) * n
    return (direction ^ n) / dot(direction, direction), n ^ x, x ^ along


def _wedge(part: Multivector, trivector: Multivector) -> Multivector:
    """(L . V) ^ C as a number: the inner product of V and the meet L v C, for V in the line L."""
    return (part ^ trivector).dual()


def _wedge_terms(part: Multivector, trivector: Multivector) -> Multivector:
    """The sum of the absolute values of the terms of `_wedge`."""
    full, total = trivector.algebra.pseudoscalar, zero(trivector)
    for blade, coefficient in trivector.terms.items():
        if full ^ blade in part.terms:
            other = absolute(part.new({0: part.terms[full ^ blade]}))
            total = total + other * absolute(trivector.new({0: coefficient}))
    return total


# -- polynomials ---------------------------------------------------------------------------------------


def evolved_polynomial(meets: Scalars, norm: Scalars, kappa: Scalars) -> Result:
    """Bernstein coefficients of p = 4 (S0 u - w x)(S0 e - K w x) + w^2 (K u - e)^2, the product of both branches.

    With u = B.B, x = B.E, e = E.E. Of degree 12 n - 4. The printed polynomial without its spurious factor w^2 Q^2, and
    without a division.
    """
    degree, ring = _degree(norm, kappa), meets[0].ring
    scaled = coefficients(_both(-1, *_polynomials(meets, norm, kappa)), degree, ring)
    return row([c / comb(degree, i) for i, c in enumerate(scaled)], "bernstein")


def evolved_polynomial_bound(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """Sum of the absolute values of p's terms at (a, b): the scale of its rounding errors. It rises in both."""
    n, q = len(norm) // 2, len(kappa) // 2
    parts = zip(_squares(meets, norm), (2 * n, 2 * n + q, 2 * n + 2 * q), strict=True)
    rows = (*(coefficients(part, degree, meets[0].ring) for part, degree in parts), norm, kappa)
    u, x, e, s0, k = (value([absolute(c) for c in part], a, b) for part in rows)
    return row([_both(1, u, x, e, s0, k, weight(norm, kappa, a, b))], "bound")


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


def evolved_printed(meets: Scalars, norm: Scalars, kappa: Scalars) -> Result:
    """Coefficients of 1, t, t^2, .. of the printed polynomial of degree 12 n, (4.16) with its sides subtracted.

    With P = S0 B - w E and Q = B: (P^2 + s^2 Q^2)^2 - s^2 (P Q + Q P)^2.
    """
    u, x, e, s0, k, w = _polynomials(meets, norm, kappa)
    square = s0 * s0 - k * (w * w)
    p_square = s0 * s0 * u - 2 * (s0 * w) * x + w * w * e
    p_q = s0 * u - w * x
    even = p_square + square * u
    printed = even * even - 4 * (square * (p_q * p_q))
    return row(powers(coefficients(printed, 6 * (len(norm) - 1), meets[0].ring)), "powers")


def powers(scaled: Scalars) -> list[Multivector]:
    """Coefficients of 1, t, t^2, ... of sum h_k (1 - t)^(n-k) t^k."""
    n = len(scaled) - 1
    found = []
    for j in range(n + 1):
        total = zero(scaled[0])
        for k in range(j + 1):
            total = total + (-1) ** (j - k) * comb(n - k, j - k) * scaled[k]
        found.append(total)
    return found


def meet_rows(meets: Scalars, norm: Scalars) -> list[tuple[Scalars, Scalars]]:
    """Coefficients of B and of E, of w, v and h each."""
    size = len(norm) // 2 + 1
    rows = [meets[i::MEET] for i in range(MEET)]
    return [(part[:size], part[size:]) for part in rows]


def _squares(meets: Scalars, norm: Scalars) -> tuple[Multivector, Multivector, Multivector]:
    """u = B.B, x = B.E, e = E.E as polynomials."""
    ring = HomogeneousRing(meets[0].ring)
    (bw, ew), (bv, ev), (bh, eh) = (
        (polynomial(first, ring), polynomial(last, ring)) for first, last in meet_rows(meets, norm)
    )
    return bv * bv - 2 * (bw * bh), bv * ev - (bw * eh + bh * ew), ev * ev - 2 * (ew * eh)


def _polynomials(meets: Scalars, norm: Scalars, kappa: Scalars) -> tuple[Multivector, ...]:
    """u, x, e, S0, K and w as polynomials."""
    a, b = parameters(meets[0].algebra, meets[0].ring)
    rest = (polynomial(part, a.ring) for part in (norm, kappa))
    return (*_squares(meets, norm), *rest, weight(norm, kappa, a, b))


def weight(norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Multivector:
    """w: a b where the ends are circles."""
    return a * b if _ended(norm, kappa) else a.constant(1)


def _weight_rate(norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Multivector:
    return a - b if _ended(norm, kappa) else zero(a)


def _ended(norm: Scalars, kappa: Scalars) -> bool:
    """Whether the curve begins and ends with circles."""
    return len(kappa) < 2 * len(norm) - 1


# -- the condition that is not squared -----------------------------------------------------------------


def evolved_condition(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """2 s^2 m (L v C)^2: the square of the meet Y = m B - w E with the circle as `evolved_circle` has it.

    Y vanishes where the ray lies in the circle's plane. Its rounding error does so with Y, unlike that of sums of
    u, x and e.
    """
    y = [evolved_circle(norm, kappa, *part, a, b) for part in meet_rows(meets, norm)]
    return row([_meet_product(y, y)], "f")


def evolved_condition_rate(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """The condition and its derivative by t."""
    rows = meet_rows(meets, norm)
    y = [evolved_circle(norm, kappa, *part, a, b) for part in rows]
    dy = [evolved_circle_rate(norm, kappa, *part, a, b) for part in rows]
    return row([_meet_product(y, y), 2 * _meet_product(y, dy)], "f_rate")


def evolved_condition_bound(
    origin: Multivector, direction: Multivector, meets: Scalars, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Scalars, products: Scalars,
) -> Result:  # fmt: skip
    """What the rounding error of the condition is relative to: |Y| times what that of Y is relative to, and more.

    The last term counts where Y is nothing but rounding.
    """
    written = [absolute(c) for c in norm]
    m, s = branch(value(norm, a, b), value(kappa, a, b), weight(norm, kappa, a, b))
    large = m + select(s > 0, m * value(written, a, b) / s, value(written, a, b))
    y = [evolved_circle(norm, kappa, *part, a, b) for part in meet_rows(meets, norm)]
    c, qc = trivectors(controls), trivectors(products)
    terms = [
        large * value([_wedge_terms(part, x) for x in c], a, b)
        + weight(norm, kappa, a, b) * value([_wedge_terms(part, x) for x in qc], a, b)
        for part in _line_frame(origin, direction)
    ]
    return row([_square_bound(y, terms)], "bound")


def _square_bound(y: Scalars, terms: Scalars) -> Multivector:
    """What the rounding error of the square of a meet is relative to, from what those of its parts are relative to."""
    (w, v, h), (dw, dv, dh) = ([absolute(x) for x in part] for part in (y, terms))
    rounding = TOUCH * epsilon(w)
    return 2 * (v * dv + w * dh + h * dw) + rounding * (dv * dv + 2 * (dw * dh))


def evolved_meet_square(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """f = (L v C)^2 itself, for the unit circle C."""
    m, s = branch(value(norm, a, b), value(kappa, a, b), weight(norm, kappa, a, b))
    y = [evolved_circle(norm, kappa, *part, a, b) for part in meet_rows(meets, norm)]
    return row([_meet_product(y, y) / (2 * s * s * m)], "f")


def _meet_product(x: Scalars, y: Scalars) -> Multivector:
    """Inner product of two meets w X + v D + h n_inf."""
    return x[1] * y[1] - (x[0] * y[2] + x[2] * y[0])


def branch(s0: Multivector, k: Multivector, w: Multivector) -> tuple[Multivector, Multivector]:
    """m = S0 + s and s. For S0 < 0 the sum cancels: there m = -K w^2/(s - S0)."""
    quad = k * (w * w)
    square = s0 * s0 - quad
    s = sqrt(select(square > 0, square, square.constant(0)))  # rounding may leave less than nothing
    return select(s0 >= 0, s0 + s, -quad / (s - s0)), s


def common_sphere_meets(meets: Scalars, norm: Scalars) -> Result:
    """Coefficients of u, for circles that lie on one sphere, Q = 0: f is u up to a positive factor."""
    return row(coefficients(_squares(meets, norm)[0], len(norm) - 1, meets[0].ring), "u")


def common_sphere_condition(meets: Scalars, norm: Scalars, a: Multivector, b: Multivector) -> Result:
    """u as the square of the meet B, and its derivative by t."""
    rows = [part for part, _ in meet_rows(meets, norm)]
    y, dy = [value(part, a, b) for part in rows], [_rate(part, a, b) for part in rows]
    return row([_meet_product(y, y), 2 * _meet_product(y, dy)], "f_rate")


def common_sphere_condition_bound(
    origin: Multivector, direction: Multivector, meets: Scalars, norm: Scalars,
    a: Multivector, b: Multivector, controls: Scalars,
) -> Result:  # fmt: skip
    """What the rounding error of the square of B is relative to."""
    y = [value(part, a, b) for part, _ in meet_rows(meets, norm)]
    c = trivectors(controls)
    terms = [value([_wedge_terms(part, x) for x in c], a, b) for part in _line_frame(origin, direction)]
    return row([_square_bound(y, terms)], "bound")


def common_sphere_bound(u: Scalars, a: Multivector, b: Multivector) -> Result:
    """Sum of the absolute values of the terms of u as a polynomial."""
    return row([value([absolute(c) for c in u], a, b)], "bound")


def common_sphere_polynomial(u: Scalars) -> Result:
    """Bernstein coefficients of u."""
    return row([c / comb(len(u) - 1, i) for i, c in enumerate(u)], "bernstein")


# -- the circle of a parameter -------------------------------------------------------------------------


def evolved_circle(
    norm: Scalars, kappa: Scalars, controls: Sequence[Multivector], products: Sequence[Multivector],
    a: Multivector, b: Multivector,
) -> Multivector:  # fmt: skip
    """The circle at (a, b), up to a positive weight: (m - w Q) C'."""
    w = weight(norm, kappa, a, b)
    m, _ = branch(value(norm, a, b), value(kappa, a, b), w)
    return m * value(controls, a, b) - w * value(products, a, b)


def evolved_circle_rate(
    norm: Scalars, kappa: Scalars, controls: Sequence[Multivector], products: Sequence[Multivector],
    a: Multivector, b: Multivector,
) -> Multivector:  # fmt: skip
    """Derivative of `evolved_circle` by t: dm = (m dS0 - d(K w^2)/2)/s divides by s only."""
    s0, k, w = value(norm, a, b), value(kappa, a, b), weight(norm, kappa, a, b)
    m, s = branch(s0, k, w)
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
