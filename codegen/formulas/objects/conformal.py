"""Objects of CGA from their parameters, and their parameters back (thesis 1.3; conventions of the whole project).

Objects are direct and normalized: X^2 = +1 for point pairs, lines and circles, -1 for planes and spheres,
X . n_inf = -1 for points. Parameters are Euclidean vectors and numbers. Objects through points are built and
normalized about the first of them, so the distance from the origin costs no digits of the shape.
"""

from __future__ import annotations

from ...algebra.multivector import Mask, Multivector, absolute, reciprocal, select, sqrt
from ...algebra.product_terms import keep_outer, keep_scalar
from ...status import Status
from ...trace.outputs import Result, named, row
from ..motions.motions import translator
from ..products.outcome import NOISE, epsilon, outcome, where_or_nan
from ..products.products import absolute_product
from .blades import Checked, norm_squared
from .euclidean import attached_part, axes, cross, direction_of, euclidean_part, length, space


def infinity(like: Multivector) -> Multivector:
    """n_inf."""
    return like.basis("ni")


def origin(like: Multivector) -> Multivector:
    """n0."""
    return like.basis("no")


# -- from parameters ---------------------------------------------------------------------------------------


def point(position: Multivector) -> Multivector:
    """X = x^2/2 n_inf + x + n0."""
    return position * position / 2 * infinity(position) + position + origin(position)


def direction(vector: Multivector) -> Multivector:
    """v ^ n_inf, not normalized."""
    return vector ^ infinity(vector)


def flat_point(position: Multivector) -> Multivector:
    """(x + n0) ^ n_inf."""
    return (position + origin(position)) ^ infinity(position)


def line(point: Multivector, direction: Multivector) -> Checked:
    """Line through a point along a direction. INVALID: the direction is zero."""
    m, scale = direction_of(direction)
    return (point + origin(point)) ^ m ^ infinity(point), outcome(point, (~(scale > 0), Status.INVALID))


def dual_plane(normal: Multivector, offset: Multivector) -> tuple[Multivector, Multivector]:
    """(n + d n_inf)/|n|, the plane normal . x = offset, and 1/|n|."""
    n, scale = direction_of(normal)
    return n + offset * scale * infinity(normal), scale


def plane(normal: Multivector, offset: Multivector) -> Checked:
    """Plane normal . x = offset; the normal need not be unit. INVALID: it is zero."""
    dual, scale = dual_plane(normal, offset)
    return dual.undual(), outcome(normal, (~(scale > 0), Status.INVALID))


def dual_sphere(center: Multivector, radius: Multivector) -> Multivector:
    """(C - r^2/2 n_inf)/r: negative inner products with points outside, positive inside."""
    return (point(center) - radius * radius / 2 * infinity(center)) / radius


def sphere(center: Multivector, radius: Multivector) -> Checked:
    """Outward sphere (in the plane: circle). INVALID: the radius is not positive."""
    valid = radius > 0
    return dual_sphere(center, where_or_nan(valid, radius)).undual(), outcome(center, (~valid, Status.INVALID))


def circle(center: Multivector, normal: Multivector, radius: Multivector) -> Checked:
    """Circle counter-clockwise about its normal: plane v sphere. INVALID: zero normal, or no positive radius."""
    n, scale = direction_of(normal)
    valid = (radius > 0) & (scale > 0)
    carrier = n + (n | center) * infinity(n)
    dual = dual_sphere(center, where_or_nan(valid, radius)) ^ carrier
    return dual.undual(), outcome(center, (~valid, Status.INVALID))


def point_pair(a: Multivector, b: Multivector) -> Checked:
    """A ^ B, normalized; from a to b. SINGULAR: a = b.

    With m the midpoint and h half of b - a, A ^ B = 2 (m + n0 + (m^2 + h^2)/2 n_inf) ^ (h + (h . m) n_inf).
    """
    return pair_of((a + b) / 2, (b - a) / 2)


def pair_of(middle: Multivector, half: Multivector) -> Checked:
    """`point_pair` of the points middle -+ half."""
    h, scale = direction_of(half)
    ni = infinity(half)
    dual_sphere = point(middle) * scale + ni / (2 * scale)  # over |h|
    return dual_sphere ^ (h + (h | middle) * ni), outcome(half, (~(scale > 0), Status.SINGULAR))


def line_through(a: Multivector, b: Multivector) -> Checked:
    """A ^ B ^ n_inf, normalized; from a to b. SINGULAR: a = b."""
    m, scale = direction_of(b - a)
    return (a + origin(a)) ^ m ^ infinity(a), outcome(a, (~(scale > 0), Status.SINGULAR))


def circle_through(a: Multivector, b: Multivector, c: Multivector) -> Checked:
    """A ^ B ^ C, normalized. SINGULAR: the points are on a line."""
    u, v = b - a, c - a
    noise = NOISE * epsilon(a)
    area = (u ^ v).scalar_product(v ^ u)
    bent = area > noise * noise * (u * u).grade(0) * (v * v).grade(0)
    return _span(a, [point(u), point(v)], bent)


def plane_through(a: Multivector, b: Multivector, c: Multivector) -> Checked:
    """A ^ B ^ C ^ n_inf, normalized. SINGULAR: the points are on a line."""
    return _span(a, [b - a, c - a, infinity(a)])


def sphere_through(a: Multivector, b: Multivector, c: Multivector, d: Multivector) -> Checked:
    """A ^ B ^ C ^ D, normalized, in the orientation of the points. SINGULAR: they are on a circle."""
    return _span(a, [point(b - a), point(c - a), point(d - a)])


def _span(a: Multivector, others: list[Multivector], round_: Mask | None = None) -> Checked:
    """n0 ^ (others), normalized about the origin and moved to a; singular where only rounding is left of it.

    Or where the mask ``round_`` does not hold.
    """
    blade = terms = origin(a)
    for x in others:
        blade, terms = blade ^ x, absolute_product(terms, x, keep_outer)
    square = -norm_squared(blade)
    noise = NOISE * epsilon(a)
    regular = square > noise * noise * absolute_product(terms, terms, keep_scalar)
    if round_ is not None:
        regular = regular & round_
    unit = blade / sqrt(where_or_nan(regular, square))
    return translator(a) >> unit, outcome(a, (~regular, Status.SINGULAR))


def normalise_point(x: Multivector) -> Checked:
    """A point at weight one, X . n_inf = -1. SINGULAR: it is at infinity."""
    weight = -(x | infinity(x))
    regular = absolute(weight) > 0
    return x / where_or_nan(regular, weight), outcome(x, (~regular, Status.SINGULAR))


def normalise_flat_point(x: Multivector) -> Checked:
    """A flat point at weight one. SINGULAR: it is at infinity."""
    weight = -x.scalar_product(infinity(x) ^ origin(x))
    regular = absolute(weight) > 0
    return x / where_or_nan(regular, weight), outcome(x, (~regular, Status.SINGULAR))


# -- back to parameters ------------------------------------------------------------------------------------


def point_parameters(x: Multivector) -> tuple[Result, Result]:
    """Position of a point of any weight. SINGULAR: it is at infinity."""
    unit, status = normalise_point(x)
    return named("position", euclidean_part(unit)), status


def direction_parameters(x: Multivector) -> Result:
    """The vector of v ^ n_inf."""
    return named("vector", attached_part(x))


def flat_point_parameters(x: Multivector) -> tuple[Result, Result]:
    """Position of a flat point of any weight. SINGULAR: it is at infinity."""
    unit, status = normalise_flat_point(x)
    return named("position", attached_part(unit)), status


def line_parameters(x: Multivector) -> tuple[Result, Result]:
    """Point nearest the origin and unit direction of a unit line, from L* = m I3 + (p x m) n_inf."""
    dual = x.dual()
    m = -(euclidean_part(dual) * space(x)).grade(1)
    moment = attached_part(dual)
    return named("point", cross(m, moment)), named("direction", m)


def plane_parameters(x: Multivector) -> tuple[Result, Result]:
    """Unit normal and offset of a unit plane, from its dual n + d n_inf."""
    dual = x.dual()
    return named("normal", euclidean_part(dual)), named("offset", attached_part(dual))


def sphere_parameters(x: Multivector) -> tuple[Result, Result, Result, Result]:
    """Center, positive radius and orientation (+1 outward) of a unit sphere. SINGULAR: it is a plane."""
    dual = x.dual()
    weight = -(dual | infinity(x))
    regular = absolute(weight) > 0
    scale = reciprocal(where_or_nan(regular, weight))
    orientation = select(weight < 0, x.constant(-1), x.constant(1))
    return (
        named("center", euclidean_part(dual) * scale),
        named("radius", absolute(scale)),
        named("orientation", orientation),
        outcome(x, (~regular, Status.SINGULAR)),
    )


def circle_parameters(x: Multivector) -> tuple[Result, Result, Result, Result]:
    """Center, unit normal and radius of a unit circle. SINGULAR: it is a line."""
    center, u, regular = round_center(x.dual())
    size = length(u)
    return (
        named("center", center),
        named("normal", u / size),
        named("radius", reciprocal(size)),
        outcome(x, (~regular, Status.SINGULAR)),
    )


def point_pair_parameters(x: Multivector) -> tuple[Result, Result, Result]:
    """End points a and b of a unit point pair A ^ B. SINGULAR: it is a flat point.

    From the center and the half vector: the printed (4.5) loses digits as the ends meet.
    """
    center, u, regular = round_center(x)
    half = u / (u * u).grade(0)
    return named("a", center - half), named("b", center + half), outcome(x, (~regular, Status.SINGULAR))


def round_center(x: Multivector) -> tuple[Multivector, Multivector, Mask]:
    """Center of a round bivector x = M ^ H/r (a point pair, the dual of a circle), x . n_inf = H/r, and is it round.

    M is the dual sphere about the center, orthogonal to H: x (x . n_inf) = M/r^2, whose Euclidean part is the
    center, so no squared coordinates are subtracted.
    """
    attitude = x | infinity(x)
    u = euclidean_part(attitude)
    square = (u * u).grade(0)
    regular = square > 0
    return euclidean_part((x | attitude).grade(1)) / where_or_nan(regular, square), u, regular


# -- conformal rotors --------------------------------------------------------------------------------------


def dilator(scale: Multivector) -> Checked:
    """cosh(g/2) - sinh(g/2) E0 with g = ln(scale): scaling about the origin. INVALID: the scale is not positive."""
    valid = scale > 0
    root = sqrt(where_or_nan(valid, scale))
    e0 = infinity(scale) ^ origin(scale)
    return (1 + scale - (scale - 1) * e0) / (2 * root), outcome(scale, (~valid, Status.INVALID))


def homothety(scale: Multivector, center: Multivector) -> Checked:
    """Scaling about a center."""
    scaling, status = dilator(scale)
    return translator(center) >> scaling, status


def transversor(t: Multivector) -> Multivector:
    """1 - t n0: inversion in the unit sphere, translation by t, inversion; x -> (x + x^2 t)/(1 + 2 t.x + t^2 x^2)."""
    return 1 - t * origin(t)


def dilator_parameters(x: Multivector) -> tuple[Result, Result, Result]:
    """Scale and center of cosh(g/2) + sinh(g/2) n0 n_inf + .. : the sum of the two is the root of the scale, their
    difference its inverse. NOT_UNIQUE: a homothety of scale 1, about any center."""
    c, k = x["1"], x["noni"]
    attached = [x[f"e{i + 1}ni"] for i in range(len(axes(x)))]
    regular = absolute(k) > 0
    center = [a / select(regular, k, k.constant(1)) for a in attached]
    anywhere = [(absolute(k) <= 0, Status.NOT_UNIQUE)] if any(a.terms for a in attached) else []
    return named("scale", (c + k) / (c - k)), row(center, "center"), outcome(x, *anywhere)


def transversor_parameters(x: Multivector) -> Result:
    """The vector of a transversor."""
    return row([-x[f"e{i + 1}no"] for i in range(len(axes(x)))], "t")
