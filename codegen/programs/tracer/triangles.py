"""Triangles: the point of a ray on a row of constants, and the normal there.

A row has three corners, and three unit normals where it is shaded with them. A ray that passes through an edge or a
corner meets every triangle there: none is lost between two.
"""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import NAN, InOut, Ints, IntVector, Out, Rows, Vector, empty, int_empty
from .hits import accept_hit
from .records import HIT, RAY, SEARCH, STATE
from .surface_kinds import PLAIN

facet_sides, facet_hit, normal_of_facet, smooth_normal = PLAIN["smooth_facet"].kernels


@inlined
def cyclic_axes(x: Vector[3], axes: Out[IntVector[3]]) -> None:
    """The axes in a cyclic order in which the largest coordinate of a vector is the last."""
    a = abs(x[0])
    b = abs(x[1])
    c = abs(x[2])
    last = 2
    if a > b:
        if a > c:
            last = 0
    elif b > c:
        last = 1
    axes[0] = 0 if last == 2 else last + 1
    axes[1] = 2 if last == 0 else last - 1
    axes[2] = last


@algorithm
def facet_hits(
    row: Vector[9], ray: RAY, search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints
) -> None:
    """Offer the point on a triangle."""
    axes = int_empty(3)
    origin = empty(3)
    direction = empty(3)
    corners = empty(9)
    cyclic_axes(ray.direction, axes)
    for i in range(3):
        origin[i] = ray.origin[axes[i]]
        direction[i] = ray.direction[axes[i]]
        corners[i] = row[axes[i]]
        corners[3 + i] = row[3 + axes[i]]
        corners[6 + i] = row[6 + axes[i]]
    sides = facet_sides(origin, direction, corners[:3], corners[3:6], corners[6:])
    is_outside = sides[0] < 0.0 or sides[1] < 0.0 or sides[2] < 0.0
    if is_outside and (sides[0] > 0.0 or sides[1] > 0.0 or sides[2] > 0.0):
        return
    t, weights, local = facet_hit(origin, direction, corners[:3], corners[3:6], corners[6:], sides)
    place = accept_hit(t, NAN, search, hits, state, integers)
    if place >= 0:
        hit = hits[place]
        hit.local[:] = weights
        for i in range(3):
            hit.point[axes[i]] = row[axes[i]] + local[i]


@inlined
def facet_normal(normal: Out[Vector[3]], row: Vector[9], ray: RAY, hit: HIT) -> None:
    """Normal of a triangle."""
    normal[:] = normal_of_facet(row[:3], row[3:6], row[6:])


@inlined
def smooth_facet_hits(
    row: Vector[18], ray: RAY, search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints
) -> None:
    """Offer the point on a triangle that is shaded with the normals of its corners."""
    facet_hits(row[:9], ray, search, hits, state, integers)


@inlined
def smooth_facet_normal(normal: Out[Vector[3]], row: Vector[18], ray: RAY, hit: HIT) -> None:
    """Mean of the corners' normals."""
    normal[:] = smooth_normal(ray.direction, row[:3], row[3:6], row[6:9], row[9:12], row[12:15], row[15:], hit.local)


#: By the name of the kind: its hits, and its normal.
TRIANGLE_ALGORITHMS = {
    "facet": (facet_hits, facet_normal),
    "smooth_facet": (smooth_facet_hits, smooth_facet_normal),
}
