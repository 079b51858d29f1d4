"""Hits of rays on surfaces evolved along curves of circles: points, steps towards them, normals.

Arguments are those of surfaces.py: a row of constants, a ray and its scalars, and a = 1 - t, b = t.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, reciprocal
from ...trace.outputs import Result, named, row
from ..objects.conformal import infinity as ni
from ..objects.conformal import origin as no
from ..objects.conformal import point
from ..objects.euclidean import dot
from ..objects.euclidean import euclidean_part as euclidean
from ..products.outcome import size
from ..rays.rays import dual_sphere, line, pair_parameters, unit, zero
from .homogeneous import Scalars, Trivectors
from .surfaces import (
    branch_at,
    center_of_round,
    circle_square,
    coefficient_product,
    evolved_circle,
    evolved_circle_motion,
    evolved_circle_rate,
    meet_rows,
    trivectors,
)


def evolved_point(
    origin: Multivector, direction: Multivector, meets: Scalars, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Trivectors, products: Trivectors,
) -> tuple[Result, Result]:  # fmt: skip
    """Hit of a ray on the plane of a root's circle: (t, squared cosine to the circle's axis), position; far away.

    At a root the meet Y = w X + v D + h n_inf is null and the hit point itself, X + (v/w) D + .., with v^2 = 2 w h; its
    w is the cosine times the weight of the circle's carrier. Where circles grow to lines w and v are next to nothing,
    but not h: the hit is far away at t = 2 h/v. The last numbers are that, its squared distance, and h^2 for C^2 = 1.
    """
    c, qc = trivectors(controls), trivectors(products)
    w, v, h = (evolved_circle(norm, kappa, *part, a, b) for part in meet_rows(meets, norm))
    carrier = evolved_circle(norm, kappa, [x ^ ni(x) for x in c], [x ^ ni(x) for x in qc], a, b)
    m, s = branch_at(norm, kappa, a, b)
    square = dot(direction, direction)
    t = v / (w * square)
    cosine = -w * w * square / dot(carrier, carrier)
    far = 2 * h / (v * square)
    distant = [far, far * far * square, h * h / (2 * s * s * m * square)]
    return row([t, cosine, *distant], "t_cosine"), named("position", origin + t * direction)


def evolved_sphere(
    origin: Multivector, direction: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Trivectors, products: Trivectors,
) -> Result:  # fmt: skip
    """Both parameters t of the ray on the sphere that has the circle as equator.

    For a ray in the circle's plane, where Y vanishes, these are its points on the circle.
    """
    round_ = evolved_circle(norm, kappa, trivectors(controls), trivectors(products), a, b)
    relative = origin - center_of_round(round_)
    pair = line(relative, direction) & dual_sphere(zero(relative), circle_square(round_)).undual()
    return row(pair_parameters(pair, relative, direction), "t")


def evolved_polish(
    origin: Multivector, direction: Multivector, t: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Trivectors, products: Trivectors,
) -> Result:  # fmt: skip
    """Gauss-Newton step (dt, db) towards X ^ C = 0 for X = F(origin + t direction); last dt with the circle kept.

    Well conditioned where the ray crosses the surface, also where it lies in the plane of the circle; the last where
    the ray does not touch the circle.
    """
    arguments = norm, kappa, trivectors(controls), trivectors(products), a, b
    round_, rate_ = evolved_circle(*arguments), evolved_circle_rate(*arguments)
    position = origin + t * direction
    velocity = direction + dot(position, direction) * ni(position)
    here = point(position)
    residual, by_t, by_b = here ^ round_, velocity ^ round_, here ^ rate_
    tt, tb, bb = coefficient_product(by_t, by_t), coefficient_product(by_t, by_b), coefficient_product(by_b, by_b)
    rt, rb = coefficient_product(residual, by_t), coefficient_product(residual, by_b)
    scale = tt * bb - tb * tb
    return row([(tb * rb - bb * rt) / scale, (tb * rt - tt * rb) / scale, -rt / tt], "step")


def evolved_normal(
    position: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Trivectors, products: Trivectors,
) -> Multivector:  # fmt: skip
    """Unit normal at a position on the surface: that of the sphere through the circle that touches the surface there.

    Neighboring circles meet the moving point, X ^ C = 0 = dX ^ C + X ^ dC, so (X ^ dC)* holds C and the direction dX.
    """
    here = point(position)
    sphere = (here ^ evolved_circle_motion(norm, kappa, trivectors(controls), trivectors(products), a, b)).dual()
    normal = euclidean(sphere) + dot(sphere, ni(here)) * position
    return unit(reciprocal(size(normal)) * normal)  # squares of light ones are no numbers


def swept_direction(position: Multivector, carrier: Multivector, rate: Multivector) -> tuple[Multivector, Multivector]:
    """Normal, of any length, at a position on the surface that a circle or line C sweeps at the rate dC (4.17 to 4.25).

    Two tangent lines: L_C along C, and L_T along dX = X . Omega, Omega = C dC. For point pairs C is the carrier line
    P ^ n_inf. The weight of C and its rate do not matter: they add a scalar to C dC. Right-handed: along C, then along
    the curve. The second result is what the rounding error of the normal is relative to.
    """
    x = point(position)
    along = (x | carrier) ^ ni(x)
    omega = (carrier * rate).grade(2)
    across = (x | omega) ^ x ^ ni(x)
    normal = (across * along).grade(2) * x.pseudoscalar()
    return euclidean(-(normal | (no(x) ^ ni(x)))), size(along) * size(x) * size(omega)
