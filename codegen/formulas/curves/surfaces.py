"""Surfaces evolved along curves of circles, of any degree n: constants, meets with a ray, the circle of a parameter.

C' = sum c_k a^(n-k) b^k with b = t, a = 1 - t: controls with the binomial inside. -C' ~C' = S0 + w Q, with w = a b
where both ends are circles (blades), else w = 1. K = Q^2, s = sqrt(S0^2 - w^2 K), m = S0 + s; the circle itself is, up
to a positive weight, (m - w Q) C'. Polynomials are rows of coefficients of a^(d-k) b^k, first k = 0. The degree n and
w are known from their lengths; nothing else depends on n.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...algebra.multivector import Multivector, absolute, from_values, select, sqrt
from ...trace.outputs import Result, named, row
from ..objects.conformal import infinity as ni
from ..objects.conformal import point
from ..objects.euclidean import dot
from ..objects.euclidean import euclidean_part as euclidean
from ..rays.rays import dual_sphere, line, zero
from .homogeneous import Quadrivectors, Scalars, Trivectors, from_row, monomial_rates, monomials, rate, to_row, value

#: Coefficients of the meet of a ray with a trivector, in the ray's own frame.
MEET = 3
#: Coefficients of Q.
QUAD = 5


def trivectors(numbers: Scalars) -> list[Multivector]:
    """Trivectors from a row of their coefficients."""
    return from_row(numbers, "circle")


# -- constants of one surface --------------------------------------------------------------------------


def square_term(
    norm: Multivector, quad: Quadrivectors, first: Multivector, last: Multivector, weight: Multivector
) -> tuple[Result, Result]:
    """Coefficients of S0 and w Q with the product of two controls added: -weight (C ~D + D ~C)/2."""
    square = -(weight / 2) * (first * ~last + last * ~first)
    q = quad_vector(quad) + square.grade(4)
    return row([norm + square.grade(0)], "norm_sum"), row(_quad_numbers(q), "quad_sum")


def kappa_term(kappa: Multivector, first: Quadrivectors, last: Quadrivectors, weight: Multivector) -> Result:
    """A coefficient of K with the product of two of Q's added."""
    return row([kappa + weight * dot(quad_vector(first), quad_vector(last))], "kappa_sum")


def product_term(product: Trivectors, quad: Quadrivectors, control: Multivector) -> Result:
    """A coefficient of Q C' with the product of one of Q's and a control added."""
    return to_row([trivectors(product)[0] + (quad_vector(quad) * control).grade(3)], "circle", "product_sum")


def _quad_blades(like: Multivector) -> list[int]:
    full = like.algebra.full_blade
    return [full ^ b for b in like.algebra.kind("vector").blades]


def quad_vector(numbers: Scalars) -> Multivector:
    """A 4-vector from its coefficients."""
    like = numbers[0]
    return from_values(like.algebra, like.ring, _quad_blades(like), [c.scalar() for c in numbers])


def _quad_numbers(q: Multivector) -> list[Multivector]:
    return [q.new({0: q.terms[b]} if b in q.terms else {}) for b in _quad_blades(q)]


# -- constants of one ray and one surface --------------------------------------------------------------


def evolved_nearest(origin: Multivector, direction: Multivector) -> tuple[Result, Result]:
    """Parameter of the point of a ray nearest to the origin of the frame, and that point.

    From there meets have the smallest coefficients, wherever the surface reaches.
    """
    t = -dot(origin, direction) / dot(direction, direction)
    return row([t], "t"), named("nearest", origin + t * direction)


def evolved_approach(origin: Multivector, direction: Multivector, center: Multivector, radius: Multivector) -> Result:
    """Parameter of the point of a ray nearest to a center, and half the chord in its sphere; NaN for a miss."""
    relative = origin - center
    pair = line(relative, direction) & dual_sphere(zero(relative), radius * radius).undual()
    square = dot(direction, direction)
    return row([-dot(relative, direction) / square, sqrt(dot(pair, pair)) / square], "middle_half")


def evolved_meets(origin: Multivector, direction: Multivector, controls: Trivectors, products: Trivectors) -> Result:
    """Coefficients of the meets B = L v C' and E = L v (Q C') of the unit line L = X ^ D ^ n_inf.

    A meet is Y = w X + v D + h n_inf, three numbers: w, v, h.
    """
    frame = line_frame(origin, direction)
    return row([_wedge(part, c) for c in (*trivectors(controls), *trivectors(products)) for part in frame], "meets")


def line_frame(origin: Multivector, direction: Multivector) -> tuple[Multivector, ...]:
    """The bivectors of which the outer products with a trivector are w, v and h of the meet."""
    x, n = point(origin), ni(origin)
    along = direction + dot(origin, direction) * n
    return (direction ^ n) / dot(direction, direction), n ^ x, x ^ along


def _wedge(part: Multivector, trivector: Multivector) -> Multivector:
    """(L . V) ^ C as a number: the inner product of V and the meet L v C, for V in the line L."""
    return (part ^ trivector).dual()


def wedge_terms(part: Multivector, trivector: Multivector) -> Multivector:
    """The sum of the absolute values of the terms of `_wedge`."""
    full, total = trivector.algebra.full_blade, zero(trivector)
    for blade, coefficient in trivector.terms.items():
        if full ^ blade in part.terms:
            other = absolute(part.new({0: part.terms[full ^ blade]}))
            total = total + other * absolute(trivector.new({0: coefficient}))
    return total


def meet_rows(meets: Scalars, norm: Scalars) -> list[tuple[Scalars, Scalars]]:
    """Coefficients of B and of E, of w, v and h each."""
    size = len(norm) // 2 + 1
    rows = [meets[i::MEET] for i in range(MEET)]
    return [(part[:size], part[size:]) for part in rows]


# -- branches ------------------------------------------------------------------------------------------


def weight(norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Multivector:
    """w: a b where the ends are circles."""
    return a * b if ends_with_circles(norm, kappa) else a.constant(1)


def weight_rate(norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> Multivector:
    return a - b if ends_with_circles(norm, kappa) else zero(a)


def ends_with_circles(norm: Scalars, kappa: Scalars) -> bool:
    """Return whether the curve begins and ends with circles."""
    return len(kappa) < 2 * len(norm) - 1


def branch(s0: Multivector, k: Multivector, w: Multivector) -> tuple[Multivector, Multivector]:
    """m = S0 + s and s. For S0 < 0 the sum cancels: there m = -K w^2/(s - S0)."""
    quad = k * (w * w)
    square = s0 * s0 - quad
    s = sqrt(select(square > 0, square, square.constant(0)))  # rounding may leave less than nothing
    return select(s0 >= 0, s0 + s, -quad / (s - s0)), s


def branch_at(norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector) -> tuple[Multivector, Multivector]:
    """m and s at (a, b)."""
    return branch(value(norm, a, b), value(kappa, a, b), weight(norm, kappa, a, b))


# -- the circle of a parameter -------------------------------------------------------------------------


def evolved_circle(
    norm: Scalars, kappa: Scalars, controls: Sequence[Multivector], products: Sequence[Multivector],
    a: Multivector, b: Multivector,
) -> Multivector:  # fmt: skip
    """The circle at (a, b), up to a positive weight: (m - w Q) C'."""
    w = weight(norm, kappa, a, b)
    m, _ = branch_at(norm, kappa, a, b)
    return m * value(controls, a, b) - w * value(products, a, b)


def branch_rates(
    norm: Scalars, kappa: Scalars, a: Multivector, b: Multivector
) -> tuple[Multivector, Multivector, Multivector]:
    """The derivatives by t of m and of s, times s, and of w: s dm = m dS0 - d(K w^2)/2, s ds = S0 dS0 - d(K w^2)/2."""
    s0, k, w = value(norm, a, b), value(kappa, a, b), weight(norm, kappa, a, b)
    m, _ = branch(s0, k, w)
    dw = weight_rate(norm, kappa, a, b)
    ds0, dk = (rate_at(part, a, b) for part in (norm, kappa))
    quad = dk * (w * w) / 2 + k * (w * dw)
    return m * ds0 - quad, s0 * ds0 - quad, dw


def evolved_circle_rate(
    norm: Scalars, kappa: Scalars, controls: Sequence[Multivector], products: Sequence[Multivector],
    a: Multivector, b: Multivector,
) -> Multivector:  # fmt: skip
    """Derivative of `evolved_circle` by t."""
    w = weight(norm, kappa, a, b)
    m, s = branch_at(norm, kappa, a, b)
    raised, _, dw = branch_rates(norm, kappa, a, b)
    dc, dqc = (rate_at(part, a, b) for part in (controls, products))
    return raised / s * value(controls, a, b) + m * dc - dw * value(products, a, b) - w * dqc


def evolved_circle_motion(
    norm: Scalars, kappa: Scalars, controls: Sequence[Multivector], products: Sequence[Multivector],
    a: Multivector, b: Multivector,
) -> Multivector:  # fmt: skip
    """Derivative of the circle by t, of constant norm, up to a positive weight: with one number to each control.

    With C^2 = 2 s^2 m and F for its root, F d(C/F) = dC - (ds/s + dm/(2 m)) C.
    """
    w = weight(norm, kappa, a, b)
    m, s = branch_at(norm, kappa, a, b)
    raised, spread, dw = branch_rates(norm, kappa, a, b)
    over = 1 / s
    dm = raised * over
    grown = spread * over * over + dm / (2 * m)
    dm, dw = dm - grown * m, dw - grown * w
    total = zero(controls[0])
    for part, at, by in ((controls, m, dm), (products, -w, -dw)):
        degree = len(part) - 1
        for c, e, de in zip(part, monomials(degree, a, b), monomial_rates(degree, a, b), strict=True):
            total = total + (by * e + at * de) * c
    return total


def rate_at(coefficients: Sequence[Multivector], a: Multivector, b: Multivector) -> Multivector:
    return value(rate(coefficients), a, b) if len(coefficients) > 1 else zero(coefficients[0])


def center_of_round(round_: Multivector) -> Multivector:
    """Center of a circle or point pair of any weight: the image of infinity. Good on intervals."""
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
