"""Surfaces evolved linearly between two circles: constants, conditions for a ray to meet them, normals.

C' = a C1 + b C2 with b = 1 - a, C1 C2 + C2 C1 = m0 + M4, kappa = M4^2, D_i = M4 C_i. The square of C' is
S0 + S4 with S0 = a^2 + b^2 + a b m0 and S4 = a b M4, its norm s = sqrt(S0^2 - kappa a^2 b^2). The circle
itself is, up to a positive weight, (t - S4) C' with t = S0 + s. Every function of (a, b) is homogeneous.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb

from ..homogeneous import coefficients, parameters, polynomial
from ..multivector import Multivector, absolute, select, sqrt
from ..trace import Result, named, row
from .conformal import infinity as ni
from .conformal import origin as no
from .conformal import point
from .euclidean import euclidean_part as euclidean
from .rays import circle, dot, dual_sphere, line, pair_parameters, unit, zero

Scalars = Sequence[Multivector]


# -- constants of one surface --------------------------------------------------------------------------


def evolved_constants(
    center1: Multivector, normal1: Multivector, radius1: Multivector,
    center2: Multivector, normal2: Multivector, radius2: Multivector,
) -> tuple[Result, ...]:  # fmt: skip
    """C1, C2, D1 = M4 C1, D2 = M4 C2, and (m0, kappa), from two circles near the origin."""
    c1, c2 = circle(center1, normal1, radius1), circle(center2, normal2, radius2)
    m = c1 * c2 + c2 * c1
    m4 = m.grade(4)
    d1, d2 = (m4 * c1).grade(3), (m4 * c2).grade(3)
    scalars = row([m.grade(0), dot(m4, m4)], "scalars")
    return named("c1", c1), named("c2", c2), named("d1", d1), named("d2", d2), scalars


# -- constants of one ray and one surface --------------------------------------------------------------


def evolved_ray(
    origin: Multivector, direction: Multivector,
    c1: Multivector, c2: Multivector, d1: Multivector, d2: Multivector,
) -> Result:  # fmt: skip
    """u = B.B, x = B.E, e = E.E for B = L v C', E = L v (M4 C'): three coefficients of b^2, a b, a^2 each."""
    ray = line(origin, direction)
    b1, b2, e1, e2 = (ray & trivector for trivector in (c1, c2, d1, d2))
    u = [dot(b2, b2), 2 * dot(b1, b2), dot(b1, b1)]
    x = [dot(b2, e2), dot(b1, e2) + dot(b2, e1), dot(b1, e1)]
    e = [dot(e2, e2), 2 * dot(e1, e2), dot(e1, e1)]
    return row([*u, *x, *e], "scalars")


# -- polynomials ---------------------------------------------------------------------------------------


def evolved_octic(ray: Scalars, surface: Scalars) -> Result:
    """Coefficients of b^8 .. a^8 of p8 = 4 (S0 u - a b x)(S0 e - kappa a b x) + a^2 b^2 (kappa u - e)^2.

    The printed polynomial of degree 12 without its spurious factor kappa a^2 b^2, and without a division.
    """
    u, x, e, s0, ab = _polynomials(ray, surface)
    p8 = _octic(u, x, e, s0, ab, polynomial([surface[1]], s0.ring), minus=-1)
    return row(coefficients(p8, 8, ray[0].ring), "octic")


def evolved_octic_bound(ray: Scalars, surface: Scalars, a: Multivector, b: Multivector) -> Result:
    """Sum of the absolute values of p8's terms at (a, b): the scale of its rounding errors. It rises in both."""
    u, x, e, ab = _values([absolute(c) for c in ray], a, b)
    m0, kappa = (absolute(c) for c in surface)
    return row([_octic(u, x, e, a * a + b * b + ab * m0, ab, kappa, minus=1)], "bound")


def _octic(
    u: Multivector, x: Multivector, e: Multivector, s0: Multivector, ab: Multivector, kappa: Multivector, minus: int
) -> Multivector:
    """p8, or with ``minus = 1`` the same with all terms added."""
    difference = kappa * u + minus * e
    product = (s0 * u + minus * (ab * x)) * (s0 * e + minus * (kappa * (ab * x)))
    return 4 * product + ab * ab * (difference * difference)


def evolved_dodecic(ray: Scalars, surface: Scalars) -> Result:
    """Coefficients of 1, a, .. a^12 of the printed polynomial, (4.16) with its two sides subtracted.

    With P = S0 B - S4-part, Q = B: (P^2 + s^2 Q^2)^2 - s^2 (P Q + Q P)^2.
    """
    u, x, e, s0, ab = _polynomials(ray, surface)
    kappa = polynomial([surface[1]], s0.ring)
    norm = s0 * s0 - kappa * (ab * ab)
    p_square = s0 * s0 * u - 2 * (s0 * ab) * x + ab * ab * e
    p_q = s0 * u - ab * x
    even = p_square + norm * u
    printed = even * even - 4 * (norm * (p_q * p_q))
    return row(_powers(coefficients(printed, 12, ray[0].ring)), "dodecic")


def _polynomials(ray: Scalars, surface: Scalars) -> tuple[Multivector, ...]:
    """u, x, e, S0 and a b as polynomials in (a, b)."""
    base = ray[0].ring
    a, b = parameters(ray[0].algebra, base)
    u, x, e = (polynomial(ray[i : i + 3], a.ring) for i in (0, 3, 6))
    s0 = polynomial([ray[0].constant(1), surface[0], ray[0].constant(1)], a.ring)
    return u, x, e, s0, a * b


def _powers(bernstein: Scalars) -> list[Multivector]:
    """Coefficients of 1, a, a^2, ... of sum h_k a^k (1 - a)^(n - k)."""
    n = len(bernstein) - 1
    powers = []
    for j in range(n + 1):
        total = zero(bernstein[0])
        for k in range(j + 1):
            total = total + (-1) ** (j - k) * comb(n - k, j - k) * bernstein[k]
        powers.append(total)
    return powers


# -- the condition that is not squared -----------------------------------------------------------------


def evolved_condition(ray: Scalars, surface: Scalars, a: Multivector, b: Multivector) -> Result:
    """2 s^2 t f for f = (L v C)^2: t (t u - 2 a b x) + a^2 b^2 e."""
    u, x, e, ab = _values(ray, a, b)
    t, _, _ = evolved_norm(surface, a, b)
    return row([_condition(u, x, e, ab, t)], "f")


def evolved_meet_square(ray: Scalars, surface: Scalars, a: Multivector, b: Multivector) -> Result:
    """f = (L v C)^2 itself, for the unit circle C."""
    u, x, e, ab = _values(ray, a, b)
    t, s, _ = evolved_norm(surface, a, b)
    return row([_condition(u, x, e, ab, t) / (2 * s * s * t)], "f")


def _values(ray: Scalars, a: Multivector, b: Multivector) -> tuple[Multivector, ...]:
    aa, ab, bb = a * a, a * b, b * b
    u, x, e = (ray[i] * bb + ray[i + 1] * ab + ray[i + 2] * aa for i in (0, 3, 6))
    return u, x, e, ab


def _condition(u: Multivector, x: Multivector, e: Multivector, ab: Multivector, t: Multivector) -> Multivector:
    return t * (t * u - 2 * (ab * x)) + ab * ab * e


def evolved_norm(surface: Scalars, a: Multivector, b: Multivector) -> tuple[Multivector, Multivector, Multivector]:
    """t, s and S0. For S0 < 0 the sum t = S0 + s cancels: there t = -kappa a^2 b^2/(s - S0)."""
    m0, kappa = surface
    ab = a * b
    s0 = a * a + b * b + ab * m0
    quad = kappa * (ab * ab)
    square = s0 * s0 - quad
    s = sqrt(select(square > 0, square, square.constant(0)))  # rounding may leave less than nothing
    return select(s0 >= 0, s0 + s, -quad / (s - s0)), s, s0


# -- the point and the normal --------------------------------------------------------------------------


def evolved_circle(
    surface: Scalars, a: Multivector, b: Multivector,
    c1: Multivector, c2: Multivector, d1: Multivector, d2: Multivector,
) -> Multivector:  # fmt: skip
    """The circle of parameter a, up to a positive weight: (t - S4) C'."""
    t, _, _ = evolved_norm(surface, a, b)
    return t * (a * c1 + b * c2) - a * b * (a * d1 + b * d2)


def evolved_circle_rate(
    surface: Scalars, a: Multivector, b: Multivector,
    c1: Multivector, c2: Multivector, d1: Multivector, d2: Multivector,
) -> Multivector:  # fmt: skip
    """Derivative of `evolved_circle` by a: dt = (t dS0 - kappa a b (b - a))/s divides by s only."""
    m0, kappa = surface
    t, s, _ = evolved_norm(surface, a, b)
    ab, turn = a * b, b - a
    dt = (t * (turn * (m0 - 2)) - kappa * (ab * turn)) / s
    plain = dt * (a * c1 + b * c2) + t * (c1 - c2)
    return plain - turn * (a * d1 + b * d2) - ab * (d1 - d2)


def evolved_point(
    origin: Multivector, direction: Multivector, surface: Scalars, a: Multivector, b: Multivector,
    c1: Multivector, c2: Multivector, d1: Multivector, d2: Multivector,
) -> tuple[Result, Result]:  # fmt: skip
    """Where a ray meets the plane of a root's circle: (t, squared cosine to the circle's axis), position.

    At a root the meet Y = L v C is null and the hit point itself. Its n0 part is the cosine times weights.
    """
    round_ = evolved_circle(surface, a, b, c1, c2, d1, d2)
    meet = line(origin, direction) & round_
    weight = -dot(meet, ni(meet))
    position = euclidean(meet) / weight
    carrier = round_ ^ ni(round_)
    square = dot(direction, direction)
    t = dot(position - origin, direction) / square
    cosine = weight * weight / (-dot(carrier, carrier) * square)
    return row([t, cosine], "t_cosine"), named("position", position)


def circle_center(round_: Multivector) -> Multivector:
    """Centre of a circle of any weight: the image of infinity."""
    image = (round_ * ni(round_) * round_).grade(1)
    return euclidean(image) / -dot(image, ni(image))


def circle_square(round_: Multivector) -> Multivector:
    """Squared radius of a circle of any weight."""
    carrier = round_ ^ ni(round_)
    return -dot(round_, round_) / dot(carrier, carrier)


def evolved_sphere(
    origin: Multivector, direction: Multivector, surface: Scalars, a: Multivector, b: Multivector,
    c1: Multivector, c2: Multivector, d1: Multivector, d2: Multivector,
) -> Result:  # fmt: skip
    """Both parameters t of the ray on the sphere that has the circle as equator.

    For a ray in the circle's plane, where Y vanishes, these are its points on the circle.
    """
    round_ = evolved_circle(surface, a, b, c1, c2, d1, d2)
    relative = origin - circle_center(round_)
    pair = line(relative, direction) & dual_sphere(zero(relative), circle_square(round_)).undual()
    return row(pair_parameters(pair, relative, direction), "t")


def evolved_polish(
    origin: Multivector, direction: Multivector, t: Multivector, surface: Scalars, a: Multivector, b: Multivector,
    c1: Multivector, c2: Multivector, d1: Multivector, d2: Multivector,
) -> Result:  # fmt: skip
    """Gauss-Newton step (dt, da) towards X ^ C = 0 for X = F(origin + t direction).

    Well conditioned where the ray crosses the surface, also where it lies in the plane of the circle.
    """
    arguments = surface, a, b, c1, c2, d1, d2
    round_, rate = evolved_circle(*arguments), evolved_circle_rate(*arguments)
    position = origin + t * direction
    velocity = direction + dot(position, direction) * ni(position)
    here = point(position)
    residual, by_t, by_a = here ^ round_, velocity ^ round_, here ^ rate
    tt, ta, aa = _sum(by_t, by_t), _sum(by_t, by_a), _sum(by_a, by_a)
    rt, ra = _sum(residual, by_t), _sum(residual, by_a)
    scale = tt * aa - ta * ta
    return row([(ta * ra - aa * rt) / scale, (ta * rt - tt * ra) / scale], "step")


def _sum(x: Multivector, y: Multivector) -> Multivector:
    """Sum of products of coefficients: a plain, positive measure of residuals."""
    total = zero(x)
    for name, value in x.terms.items():
        if name in y.terms:
            total = total + x.new({0: value}) * y.new({0: y.terms[name]})
    return total


def evolved_normal(
    position: Multivector, surface: Scalars, a: Multivector, b: Multivector,
    c1: Multivector, c2: Multivector, d1: Multivector, d2: Multivector,
) -> Multivector:  # fmt: skip
    """Unit normal at a position on the surface (4.17 to 4.25).

    Two tangent lines: L_C along the circle, and L_T along dX = X . Omega, Omega = C dC. The weight of C
    and its rate do not matter: they add a scalar to C dC.
    """
    arguments = surface, a, b, c1, c2, d1, d2
    round_, rate = evolved_circle(*arguments), evolved_circle_rate(*arguments)
    x = point(position)
    along = (x | round_) ^ ni(x)
    velocity = x | (round_ * rate).grade(2)
    across = velocity ^ x ^ ni(x)
    normal = (across * along).grade(2) * x.pseudoscalar()
    return unit(euclidean(-(normal | (no(x) ^ ni(x)))))
