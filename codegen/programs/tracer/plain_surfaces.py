"""Planes, spheres and discs: the points of a ray on a row of constants, and normals there.

A row is of a plane: unit normal, offset; of a sphere: centre, radius; of a disc: centre, unit normal, radius.
"""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import InOut, Ints, Out, Rows, Vector, empty
from .hits import AXES, offer
from .records import HIT, RAY, SEARCH, STATE
from .surface_kinds import PLAIN

(plane_hit,), (sphere_hit,) = PLAIN["plane"].kernels, PLAIN["sphere"].kernels
disc_hit, disc_graze, rim_hit = PLAIN["disc"].kernels


@algorithm
def plane_hits(
    row: Vector[4], ray: RAY, search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints
) -> None:
    """Offer the point on a plane."""
    local = empty(3)
    t = plane_hit(ray.origin, ray.direction, row[:3], row[3:])
    for i in AXES:
        local[i] = t * ray.direction[i]
    offer(t, ray.origin, local, search, hits, state, integers)


@inlined
def plane_normal(normal: Out[Vector[3]], row: Vector[4], ray: RAY, hit: HIT) -> None:
    """Normal of a plane."""
    normal[:] = row[:3]


@algorithm
def sphere_hits(
    row: Vector[4], ray: RAY, search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints
) -> None:
    """Offer both points on a sphere."""
    t, first, last = sphere_hit(ray.origin, ray.direction, row[:3], row[3:])
    offer(t[0], row[:3], first, search, hits, state, integers)
    offer(t[1], row[:3], last, search, hits, state, integers)


@inlined
def sphere_normal(normal: Out[Vector[3]], row: Vector[4], ray: RAY, hit: HIT) -> None:
    """Normal of a sphere."""
    for i in AXES:
        normal[i] = hit.local[i] / row[3]


@algorithm
def disc_rim(
    row: Vector[7], ray: RAY, search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints
) -> None:
    """Offer where a ray in the disc's plane meets the rim: nowhere, once where it touches, or twice."""
    t, first, last = rim_hit(ray.origin, ray.direction, row[:3], row[3:6], row[6:])
    offer(t[0], row[:3], first, search, hits, state, integers)
    offer(t[1], row[:3], last, search, hits, state, integers)


@algorithm
def disc_grazed(
    row: Vector[7], ray: RAY, search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints
) -> None:
    """Offer the point of a ray that only grazes the disc."""
    t, local = disc_graze(ray.origin, ray.direction, row[:3], row[3:6], row[6:])
    offer(t, row[:3], local, search, hits, state, integers)


@algorithm
def disc_hits(
    row: Vector[7], ray: RAY, search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints
) -> None:
    """Offer the points on a disc."""
    measures, local = disc_hit(ray.origin, ray.direction, row[:3], row[3:6], row[6:])  # t, square, along
    if measures[2] > 0.0:
        disc_rim(row, ray, search, hits, state, integers)
    elif measures[1] <= 0.0 and measures[2] < 0.0:
        disc_grazed(row, ray, search, hits, state, integers)
    elif measures[1] <= 0.0:
        offer(measures[0], row[:3], local, search, hits, state, integers)


@inlined
def disc_normal(normal: Out[Vector[3]], row: Vector[7], ray: RAY, hit: HIT) -> None:
    """Normal of a disc."""
    normal[:] = row[3:6]


#: By the name of the kind: its hits, and its normal.
PLAIN_ALGORITHMS = {
    "plane": (plane_hits, plane_normal),
    "sphere": (sphere_hits, sphere_normal),
    "disc": (disc_hits, disc_normal),
}
