"""The smallest sphere around two, and the weights with which spheres blend by their centers (thesis 4.5.1, 3.11)."""

from __future__ import annotations

from ...algebra.multivector import Multivector, select
from ...trace.outputs import Result, named
from .conformal import infinity, point
from .euclidean import direction_of, euclidean_part, length


def enclosing_pair(c1: Multivector, r1: Multivector, c2: Multivector, r2: Multivector) -> tuple[Result, Result]:
    """Center and radius of the smallest sphere around two spheres, given by theirs.

    The line through the centers leaves the first at A and the second at B, the far poles: the sphere on A and B has
    the dual (A + B)/2 + (A . B)/2 n_inf (the printed one, without the last term, is imaginary). A sphere that holds
    the other is the answer; with equal centers it is the larger. Everything is relative to the first center.
    """
    gap = c2 - c1
    u, scale = direction_of(gap)
    apart = scale > 0
    nothing = c1.constant(0)
    distance = select(apart, 1 / scale, nothing)
    u = select(apart, u, nothing)
    far, near = point(-r1 * u), point(gap + r2 * u)
    dual = (far + near) / 2 + (far | near) / 2 * infinity(c1)
    radius = length(euclidean_part(near - far)) / 2
    first, second = distance + r2 <= r1, distance + r1 <= r2
    center = select(first, nothing, select(second, gap, euclidean_part(dual)))
    return named("center", c1 + center), named("radius", select(first, r1, select(second, r2, radius)))
