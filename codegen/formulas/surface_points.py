"""Where rays meet surfaces evolved along curves of circles: points, steps towards them, normals.

Arguments are those of surfaces.py: a row of constants, a ray and its scalars, and a = 1 - t, b = t.
"""

from __future__ import annotations

from ..multivector import Multivector
from ..trace import Result, named, row
from .conformal import infinity as ni
from .conformal import origin as no
from .conformal import point
from .euclidean import euclidean_part as euclidean
from .rays import dot, dual_sphere, line, pair_parameters, unit, zero
from .surfaces import (
    MEET,
    Scalars,
    circle_center,
    circle_square,
    coefficient_product,
    evolved_circle,
    evolved_circle_rate,
    trivectors,
)


def evolved_point(
    origin: Multivector, direction: Multivector, meets: Scalars, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Scalars, products: Scalars,
) -> tuple[Result, Result]:  # fmt: skip
    """Where a ray meets the plane of a root's circle: (t, squared cosine to the circle's axis), position.

    At a root the meet Y = w X + v D + h n_inf is null and the hit point itself, X + (v/w) D + ..; its w is the
    cosine times the weight of the circle's carrier.
    """
    c, qc = trivectors(controls), trivectors(products)
    rows = [meets[i : i + MEET] for i in range(0, len(meets), MEET)]
    first, last = rows[: len(c)], rows[len(c) :]
    weight, along = (evolved_circle(norm, kappa, [y[i] for y in first], [y[i] for y in last], a, b) for i in range(2))
    carrier = evolved_circle(norm, kappa, [x ^ ni(x) for x in c], [x ^ ni(x) for x in qc], a, b)
    square = dot(direction, direction)
    t = along / (weight * square)
    return row([t, -weight * weight * square / dot(carrier, carrier)], "t_cosine"), named(
        "position", origin + t * direction
    )


def evolved_sphere(
    origin: Multivector, direction: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Scalars, products: Scalars,
) -> Result:  # fmt: skip
    """Both parameters t of the ray on the sphere that has the circle as equator.

    For a ray in the circle's plane, where Y vanishes, these are its points on the circle.
    """
    round_ = evolved_circle(norm, kappa, trivectors(controls), trivectors(products), a, b)
    relative = origin - circle_center(round_)
    pair = line(relative, direction) & dual_sphere(zero(relative), circle_square(round_)).undual()
    return row(pair_parameters(pair, relative, direction), "t")


def evolved_polish(
    origin: Multivector, direction: Multivector, t: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Scalars, products: Scalars,
) -> Result:  # fmt: skip
    """Gauss-Newton step (dt, db) towards X ^ C = 0 for X = F(origin + t direction).

    Well conditioned where the ray crosses the surface, also where it lies in the plane of the circle.
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
    return row([(tb * rb - bb * rt) / scale, (tb * rt - tt * rb) / scale], "step")


def evolved_normal(
    position: Multivector, norm: Scalars, kappa: Scalars,
    a: Multivector, b: Multivector, controls: Scalars, products: Scalars,
) -> Multivector:  # fmt: skip
    """Unit normal at a position on the surface (4.17 to 4.25).

    Two tangent lines: L_C along the circle, and L_T along dX = X . Omega, Omega = C dC. The weight of C
    and its rate do not matter: they add a scalar to C dC.
    """
    arguments = norm, kappa, trivectors(controls), trivectors(products), a, b
    round_, rate_ = evolved_circle(*arguments), evolved_circle_rate(*arguments)
    x = point(position)
    along = (x | round_) ^ ni(x)
    velocity = x | (round_ * rate_).grade(2)
    across = velocity ^ x ^ ni(x)
    normal = (across * along).grade(2) * x.pseudoscalar()
    return unit(euclidean(-(normal | (no(x) ^ ni(x)))))
