"""Boxes along the axes: where a ray is inside, never less than that for any rounding; how far circles and pairs reach.

A ray is made ready once: its origin is moved by a margin each way, so that no surface that stands in a box is missed
although the ray's own numbers and the surface's formulas are rounded.
"""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.multivector import Multivector, absolute, reciprocal, select, sqrt
from ...trace.outputs import Result, named, row
from ..curves.surfaces import center_of_round
from ..objects.conformal import infinity as ni
from ..objects.euclidean import coordinates, dot, vector
from ..objects.euclidean import euclidean_part as euclidean
from ..products.outcome import epsilon

#: Roundings, relative to the ray's origin and the farthest box, by which formulas may misplace a point: most make some
#: ten, but a ray counts as in a disc's plane (`rays.rim_hit`) within twice 64 roundings of the sums of coordinates.
ROUNDINGS = 1024


def box_ray(origin: Multivector, direction: Multivector, extent: Multivector) -> tuple[Result, ...]:
    """The origins from which near and far sides of boxes are seen, and one over the direction.

    ``extent`` is the largest absolute coordinate of any box, more than 0. Where a component of the direction is zero,
    one over it is infinite, of plus sign.
    """
    size = extent
    for x in coordinates(origin):
        size = _larger(absolute(x), size)
    margin = ROUNDINGS * (epsilon(origin) * size)
    near, far, inverse = [], [], []
    for x, d in zip(coordinates(origin), coordinates(direction), strict=True):
        backward = d < 0
        steep = reciprocal(absolute(d))
        near.append(select(backward, x - margin, x + margin))
        far.append(select(backward, x + margin, x - margin))
        inverse.append(select(backward, -steep, steep))
    rows = {"near": near, "far": far, "inverse": inverse}
    return tuple(named(name, vector(tuple(x))) for name, x in rows.items())


class Bounds(NamedTuple):
    """First and last parameter of a ray."""

    first: Multivector
    last: Multivector


def box_span(
    near: Multivector, far: Multivector, inverse: Multivector,
    near_corner: Multivector, far_corner: Multivector, bounds: Bounds,
) -> Result:  # fmt: skip
    """Parameters between which a ray, made by `box_ray`, is inside a box and inside bounds; none if they fall.

    The corners are those that the ray sees first and last. In a side's own plane, where infinity meets zero, the side
    says nothing: it is a margin away from anything in the box.
    """
    first, last = bounds
    for o, p, i, low, high in zip(*map(coordinates, (near, far, inverse, near_corner, far_corner)), strict=True):
        first = _larger((low - o) * i, first)
        last = _smaller((high - p) * i, last)
    return row([first, last], "span")


def _larger(x: Multivector, y: Multivector) -> Multivector:
    """The larger of two; y where x is no number."""
    return select(x > y, x, y)


def _smaller(x: Multivector, y: Multivector) -> Multivector:
    return select(x < y, x, y)


# -- how far objects reach -----------------------------------------------------------------------------------


def circle_shape(round_: Multivector) -> tuple[Multivector, Multivector, Multivector]:
    """Center, squared radius and normal, of any length, of a circle of any weight.

    The circle over its plane is the dual of the sphere of which it is an equator.
    """
    carrier = round_ ^ ni(round_)
    normal = euclidean(carrier.dual())
    flat = reciprocal(dot(normal, normal))
    center = -euclidean((round_ * carrier).grade(1)) * flat
    return center, dot(round_, round_) * flat, normal


def circle_extents(square: Multivector, normal: Multivector) -> list[Multivector]:
    """Half lengths of the box around a circle: along an axis, the radius times the normal's part across it."""
    squares = [n * n for n in coordinates(normal)]
    share = square / dot(normal, normal)
    across = [squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]]
    return [sqrt(share * part) for part in across]


def circle_extent(center: Multivector, square: Multivector, normal: Multivector) -> Multivector:
    """Squared distance from the origin to a circle's farthest point.

    The point lies where the center's projection onto the plane points to: d^2 + r^2 + 2 r |d ^ n|.
    """
    across = center ^ normal
    along = -dot(across, across) / dot(normal, normal)
    return dot(center, center) + square + 2 * sqrt(square * along)


def pair_shape(pair: Multivector) -> tuple[Multivector, Multivector]:
    """Middle of a point pair of any weight, and half the vector between its points."""
    chord = pair | ni(pair)
    return center_of_round(pair), euclidean(chord) * (sqrt(dot(pair, pair)) / dot(chord, chord))
