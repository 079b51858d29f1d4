"""When a ray meets a circle of an evolved surface: the polynomial of both branches, and the condition itself.

Rows, a = 1 - t and b = t as in surfaces.py. The condition is (L v C)^2 = 0 for the ray L and the circle C.
"""

from __future__ import annotations

from fractions import Fraction
from math import comb

from ...algebra.multivector import Multivector, absolute, select, sqrt
from ...rings.bernstein import HomogeneousRing
from ...trace.outputs import Result, row
from ..products.outcome import epsilon
from ..rays.rays import zero
from .homogeneous import Quadrivectors, Scalars, Trivectors, coefficients, parameters, polynomial, value
from .surfaces import (
    QUAD,
    branch_at,
    branch_rates,
    coefficient_product,
    ends_with_circles,
    evolved_circle,
    line_frame,
    meet_rows,
    quad_vector,
    rate_at,
    trivectors,
    wedge_terms,
    weight,
)

#: Square of what u is at most for |C'| = 1 and a unit line through the origin; (1 + x^2)^2 as much at the distance x.
LINE = 16
#: Within that many spacings at 1 the condition is zero to rounding; `algorithms.roots` counts in halves of them.
TOUCH = 8


def evolved_sizes(
    norm: Scalars, kappa: Scalars, quad: Quadrivectors, controls: Trivectors, products: Trivectors
) -> Result:
    """Size of Q relative to the products that it is made of, and the most that the terms of p can add up to.

    The first is rounding where all circles lie on one sphere. The second is for unit lines through the origin.
    """
    c, qc = trivectors(controls), trivectors(products)
    q = [coefficient_product(x, x) for x in (quad_vector(quad[i : i + QUAD]) for i in range(0, len(quad), QUAD))]
    squares = [coefficient_product(x, x) for x in c]
    inner = squares[1:-1] if ends_with_circles(norm, kappa) else squares
    nothing = zero(norm[0])
    whole = nothing.sum(squares)
    pairs = (whole * whole - nothing.sum(x * x for x in squares)) / 2 + nothing.sum(x * x for x in inner)
    s0, k = (_largest([absolute(x) for x in part]) for part in (norm, kappa))
    b, e = (sqrt(_largest([coefficient_product(x, x) for x in part], square=True)) for part in (c, qc))
    w = nothing + (Fraction(1, 4) if ends_with_circles(norm, kappa) else 1)
    return row([sqrt(nothing.sum(q) / pairs), LINE * _both(1, b * b, b * e, e * e, s0, k, w)], "sizes")


def _largest(scaled: Scalars, square: bool = False) -> Multivector:
    """Largest of some numbers over the binomial coefficients of their place, or over their squares."""
    most = zero(scaled[0])
    for i, c in enumerate(scaled):
        part = c / comb(len(scaled) - 1, i) ** (2 if square else 1)
        most = select(part > most, part, most) if i else part
    return most


# -- polynomials ---------------------------------------------------------------------------------------


def evolved_polynomial(meets: Scalars, norm: Scalars, kappa: Scalars) -> Result:
    """Bernstein coefficients of p = 4 (S0 u - w x)(S0 e - K w x) + w^2 (K u - e)^2, the product of both branches.

    With u = B.B, x = B.E, e = E.E; its degree is 12 n - 4. The published polynomial without its spurious factor
    w^2 Q^2, and without a division.
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


def evolved_published_polynomial(meets: Scalars, norm: Scalars, kappa: Scalars) -> Result:
    """Coefficients of 1, t, t^2, .. of the published polynomial of degree 12 n, (4.16) with its sides subtracted.

    With P = S0 B - w E and Q = B: (P^2 + s^2 Q^2)^2 - s^2 (P Q + Q P)^2.
    """
    u, x, e, s0, k, w = _polynomials(meets, norm, kappa)
    square = s0 * s0 - k * (w * w)
    p_square = s0 * s0 * u - 2 * (s0 * w) * x + w * w * e
    p_q = s0 * u - w * x
    even = p_square + square * u
    polynomial = even * even - 4 * (square * (p_q * p_q))
    return row(powers(coefficients(polynomial, 6 * (len(norm) - 1), meets[0].ring)), "powers")


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


# -- the condition that is not squared -----------------------------------------------------------------


def evolved_condition(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """2 s^2 m (L v C)^2: the square of the meet Y = m B - w E with the circle as `evolved_circle` has it.

    Y vanishes where the ray lies in the circle's plane. Its rounding error does so with Y, unlike that of sums of
    u, x and e.
    """
    y = [evolved_circle(norm, kappa, *part, a, b) for part in meet_rows(meets, norm)]
    return row([_meet_product(y, y)], "f")


def evolved_condition_rate(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """The condition and its derivative by t, 2 Y . dY with dY = dm B + (m dB - d(w E)): only dm divides, by s."""
    w = weight(norm, kappa, a, b)
    m, s = branch_at(norm, kappa, a, b)
    raised, _, dw = branch_rates(norm, kappa, a, b)
    rows = meet_rows(meets, norm)
    meet = [value(first, a, b) for first, _ in rows]
    y = [m * x - w * value(last, a, b) for x, (_, last) in zip(meet, rows, strict=True)]
    rest = [m * rate_at(first, a, b) - (dw * value(last, a, b) + w * rate_at(last, a, b)) for first, last in rows]
    return row([_meet_product(y, y), 2 * (_meet_product(y, rest) + raised * (_meet_product(y, meet) / s))], "f_rate")


def evolved_condition_bound(
    origin: Multivector, direction: Multivector, meets: Scalars, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Trivectors, products: Trivectors,
) -> Result:  # fmt: skip
    """Scale of the condition's rounding error: |Y| times that of Y, and a term of second order.

    The last term counts where Y is nothing but rounding.
    """
    written = [absolute(c) for c in norm]
    m, s = branch_at(norm, kappa, a, b)
    large = m + select(s > 0, m * value(written, a, b) / s, value(written, a, b))
    y = [evolved_circle(norm, kappa, *part, a, b) for part in meet_rows(meets, norm)]
    c, qc = trivectors(controls), trivectors(products)
    terms = [
        large * value([wedge_terms(part, x) for x in c], a, b)
        + weight(norm, kappa, a, b) * value([wedge_terms(part, x) for x in qc], a, b)
        for part in line_frame(origin, direction)
    ]
    return row([_square_bound(y, terms)], "bound")


def _square_bound(y: Scalars, terms: Scalars) -> Multivector:
    """Scale of the rounding error of a meet's square, from the scales of its parts."""
    (w, v, h), (dw, dv, dh) = ([absolute(x) for x in part] for part in (y, terms))
    rounding = TOUCH * epsilon(w)
    return 2 * (v * dv + w * dh + h * dw) + rounding * (dv * dv + 2 * (dw * dh))


def evolved_meet_square(meets: Scalars, norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Result:
    """f = (L v C)^2 itself, for the unit circle C."""
    m, s = branch_at(norm, kappa, a, b)
    y = [evolved_circle(norm, kappa, *part, a, b) for part in meet_rows(meets, norm)]
    return row([_meet_product(y, y) / (2 * s * s * m)], "f")


def _meet_product(x: Scalars, y: Scalars) -> Multivector:
    """Inner product of two meets w X + v D + h n_inf."""
    return x[1] * y[1] - (x[0] * y[2] + x[2] * y[0])


def common_sphere_meets(meets: Scalars, norm: Scalars) -> Result:
    """Coefficients of u, for circles that lie on one sphere, Q = 0: f is u up to a positive factor."""
    return row(coefficients(_squares(meets, norm)[0], len(norm) - 1, meets[0].ring), "u")


def common_sphere_condition(meets: Scalars, norm: Scalars, a: Multivector, b: Multivector) -> Result:
    """u as the square of the meet B, and its derivative by t."""
    rows = [part for part, _ in meet_rows(meets, norm)]
    y, dy = [value(part, a, b) for part in rows], [rate_at(part, a, b) for part in rows]
    return row([_meet_product(y, y), 2 * _meet_product(y, dy)], "f_rate")


def common_sphere_condition_bound(
    origin: Multivector, direction: Multivector, meets: Scalars, norm: Scalars,
    a: Multivector, b: Multivector, controls: Trivectors,
) -> Result:  # fmt: skip
    """Scale of the rounding error of the square of B."""
    y = [value(part, a, b) for part, _ in meet_rows(meets, norm)]
    c = trivectors(controls)
    terms = [value([wedge_terms(part, x) for x in c], a, b) for part in line_frame(origin, direction)]
    return row([_square_bound(y, terms)], "bound")


def common_sphere_bound(u: Scalars, a: Multivector, b: Multivector) -> Result:
    """Sum of the absolute values of the terms of u as a polynomial."""
    return row([value([absolute(c) for c in u], a, b)], "bound")


def common_sphere_polynomial(u: Scalars) -> Result:
    """Bernstein coefficients of u."""
    return row([c / comb(len(u) - 1, i) for i, c in enumerate(u)], "bernstein")
