"""Rays and triangles (thesis 4.7.4), so that neighbors that share an edge agree on which side of it a ray passes.

The point pairs A ^ B, B ^ C, C ^ A of a triangle meet a line L in the scalars L v (A ^ B), ...: with (4.7.4), alpha and
beta lie between 0 and 1 where the three have one sign. Each is the weight of (A ^ L) v (B ^ L) = (L v (A ^ B)) L, the
meet of the planes through the ray and the ends of the edge. A coefficient of that is one difference of two products of
rounded numbers that belong to one corner each: its sign is never wrong, whatever is rounded, but for a zero, which
counts as inside. So no ray passes between two triangles.
"""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.multivector import Multivector, absolute, select
from ...trace.outputs import Result, named, row
from ..objects.euclidean import cross, dot
from ..products.outcome import epsilon, size, where_or_nan
from .rays import line, line_direction, unit, zero

#: Roundings, of the sums of coordinates, by which a point may be beside a ray: less than boxes are wider (boxes.py).
BESIDE = 128


class Sides(NamedTuple):
    """A number for each side of a triangle."""

    bc: Multivector
    ca: Multivector
    ab: Multivector


class Barycentric(NamedTuple):
    """Barycentric coordinates: a weight for each corner of a triangle."""

    a: Multivector
    b: Multivector
    c: Multivector


def facet_sides(
    origin: Multivector, direction: Multivector, a: Multivector, b: Multivector, c: Multivector
) -> Result:  # fmt: skip
    """L v (B ^ C), L v (C ^ A), L v (A ^ B), times the ray's e3: of one sign, or 0, where it meets the triangle.

    Corners are seen from the ray's own origin. The axes are to be in such an order that the direction's largest
    coordinate is along e3: the coefficient along it is used, and vanishes only with the whole.
    """
    ray = line(zero(direction), direction)
    at_a, at_b, at_c = ((corner - origin) ^ ray for corner in (a, b, c))
    return row([line_direction(p & q)["e3"] for p, q in ((at_b, at_c), (at_c, at_a), (at_a, at_b))], "sides")


def facet_hit(
    origin: Multivector, direction: Multivector, a: Multivector, b: Multivector, c: Multivector,
    sides: Sides,
) -> tuple[Result, Result, Result]:  # fmt: skip
    """Parameter t of the ray's point on the triangle, its barycentric coordinates, and the point relative to A.

    These are the sides over their sum; t is that mean of the corners' own, and cannot leave their range however the ray
    grazes. NaN where all vanish: the ray lies in the plane of the triangle and meets no more of it. And where
    one does that should not, so nearly does the ray lie in the plane: then that point is beside the ray.
    """
    total = sides[0] + sides[1] + sides[2]
    barycentric = [side / total for side in sides]
    point = zero(a)
    for weight, corner in zip(barycentric, (a, b, c), strict=True):
        point = point + weight * (corner - origin)
    t = point["e3"] / direction["e3"]
    beside, noise = point - t * direction, BESIDE * epsilon(origin) * (size(origin) + size(a))
    inside = (absolute(sides[0]) > 0) & (absolute(sides[1]) > 0) & (absolute(sides[2]) > 0)
    t = where_or_nan(inside | (dot(beside, beside) <= noise * noise), t)
    local = barycentric[1] * (b - a) + barycentric[2] * (c - a)
    return row([t], "t"), row(barycentric, "barycentric"), named("local", local)


def facet_normal(a: Multivector, b: Multivector, c: Multivector) -> Multivector:
    """Unit normal of the triangle, counter-clockwise from A over B to C."""
    return unit(cross(b - a, c - a))


def smooth_normal(
    direction: Multivector,
    a: Multivector, b: Multivector, c: Multivector,
    at_a: Multivector, at_b: Multivector, at_c: Multivector,
    barycentric: Barycentric,
) -> Multivector:  # fmt: skip
    """Mean of the corners' normals, on that side of the ray on which the triangle's own normal is.

    Near outlines the mean may face away from a ray that meets the front: then its part along the ray is reflected.
    """
    flat = facet_normal(a, b, c)
    mean = barycentric[0] * at_a + barycentric[1] * at_b + barycentric[2] * at_c
    along = dot(mean, direction)
    agrees = dot(flat, direction) * along >= 0
    mirrored = mean - 2 * along / dot(direction, direction) * direction
    return unit(select(agrees, mean, mirrored))
