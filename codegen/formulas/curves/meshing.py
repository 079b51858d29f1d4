"""Vertices of meshes on surfaces that circles, point pairs and lines sweep (thesis 4.10), and their normals.

The rotor that carries points from circle to circle, Z = T(c2) D R ~T(c1), composes along a row of circles to
T(c_i) D(r_i) R_i with R_i the product of the rotations: translations and scalings telescope, so that no error
gathers in them and every point is on its own circle to rounding.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, absolute, select, sqrt
from ..objects.conformal import infinity as ni
from ..objects.euclidean import dot
from ..objects.euclidean import euclidean_part as euclidean
from ..products.outcome import NOISE, epsilon, where_or_nan
from .surface_points import swept_direction


def point_on_circle(center: Multivector, radius: Multivector, rotor: Multivector, spoke: Multivector) -> Multivector:
    """c + r R x ~R: where T(c) D(r) R takes a point of the unit circle."""
    return center + radius * euclidean(rotor >> spoke)


def interpolate_position(a: Multivector, b: Multivector, fraction: Multivector) -> Multivector:
    """The position from a (fraction 0) to b (fraction 1)."""
    return a + fraction * (b - a)


def swept_normal(position: Multivector, carrier: Multivector, rate: Multivector) -> Multivector:
    """Unit normal at a position on the surface that a circle or line C sweeps at the rate dC (4.17 to 4.25).

    See `surface_points.swept_direction`. NaN where rounding is all that is left of it: at points that stand still, and
    where the two directions agree.
    """
    normal, terms = swept_direction(position, carrier, rate)
    largest = _largest(normal)
    noise = NOISE * epsilon(position) * terms
    scaled = normal / where_or_nan(largest > noise, largest)
    return scaled / sqrt(dot(scaled, scaled))


def segment_normal(position: Multivector, pair: Multivector, rate: Multivector) -> Multivector:
    """Unit normal at a position on the surface that the segment of a point pair sweeps (4.7.2, by its carrier)."""
    return swept_normal(position, pair ^ ni(pair), rate ^ ni(pair))


def _largest(v: Multivector) -> Multivector:
    """The largest coordinate's absolute value."""
    largest = v.constant(0)
    for name in ("e1", "e2", "e3"):
        here = absolute(v[name])
        largest = select(here > largest, here, largest)
    return largest
