"""Rulings of ribbons, the carriers of their pairs, and rays that run nearly along one."""

from __future__ import annotations

from ...algebra.multivector import Multivector, reciprocal, select, sqrt
from ..objects.conformal import infinity as ni
from ..objects.conformal import origin as no
from ..objects.euclidean import dot, space
from ..objects.euclidean import euclidean_part as euclidean
from ..products.outcome import size
from ..rays.rays import line_direction


def plane_normal(plane: Multivector) -> Multivector:
    """Normal of a plane, of the plane's weight."""
    return euclidean(plane.dual())


def carrier_motion(
    position: Multivector, direction: Multivector, pair: Multivector, rate: Multivector
) -> tuple[Multivector, ...]:
    """Direction of a carrier; X ^ L_C and X ^ dL_C for X = position, and their changes along a direction: normals."""
    carrier, carrier_rate = carriers(pair, rate)
    here = position + no(position)
    normals = (plane_normal(x ^ line_) for line_ in (carrier, carrier_rate) for x in (here, direction))
    return (line_direction(carrier), *normals)


def carriers(pair: Multivector, rate: Multivector) -> tuple[Multivector, Multivector]:
    """Carrier of a pair of any weight and its rate, both over the pair's size: products of light ones are numbers."""
    weight = reciprocal(size(pair))
    return weight * (pair ^ ni(pair)), weight * (rate ^ ni(rate))


def parallel_parameters(
    m: Multivector, off: Multivector, by_t: Multivector, motion: Multivector, motion_rate: Multivector
) -> tuple[Multivector, Multivector]:
    """Both t where off + t by_t and motion + t motion_rate are parallel, seen along m."""
    c0, c2 = volume_of(m, off, motion), volume_of(m, by_t, motion_rate)
    c1 = volume_of(m, off, motion_rate) + volume_of(m, by_t, motion)
    square = c1 * c1 - 4 * (c0 * c2)
    root = sqrt(select(square > 0, square, square.constant(0)))
    q = -(c1 + select(c1 < 0, -root, root)) / 2
    return c0 / q, q / c2


def volume_of(x: Multivector, y: Multivector, z: Multivector) -> Multivector:
    return dot(x ^ y ^ z, ~space(x))
