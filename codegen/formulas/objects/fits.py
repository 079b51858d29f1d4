"""Distances of points from spheres and circles with their derivatives, for least squares (cf. Dorst 2014 on k-spheres).

A sphere is its dual unit vector s, s^2 = 1, of any curvature kappa = -s . n_inf: planes are spheres too, and nothing is
special where they meet. A circle is s and a dual plane p through its center, s . p = 0.
"""

from __future__ import annotations

from fractions import Fraction

from ...algebra.multivector import Multivector, absolute, reciprocal, select, sqrt
from ...status import Status
from ...trace.outputs import Result, row
from ..motions.motions import translator
from ..products.outcome import epsilon, outcome, where_or_nan
from .blades import norm_squared
from .conformal import circle, infinity, origin, point
from .euclidean import attached_part, euclidean_part

#: Curvature in units of the points' extent from which an object is built from its center: further away than this,
#: the center costs more digits than moving the object does.
LEAST_CURVATURE = Fraction(1, 1024)


def _signed_distance(q: Multivector, curvature: Multivector) -> tuple[Multivector, Multivector]:
    """The d with d + curvature d^2/2 = q, for any curvature, and 1/(1 + curvature d).

    1 + curvature d is the distance from the center over the radius. At the center the distance has no derivative: 0.
    """
    square = 1 + 2 * curvature * q
    off_center = square > epsilon(q)
    root = sqrt(select(off_center, square, q.constant(0)))
    return 2 * q / (1 + root), select(off_center, 1 / root, q.constant(0))


def _along_basis(gradient: Multivector) -> list[Multivector]:
    """Inner products with the basis vectors: the derivative for each coefficient."""
    one = gradient.constant(1)
    basis = [one.new({1 << i: one.terms[0]}) for i in range(gradient.algebra.dimension)]
    return [gradient.scalar_product(e) for e in basis]


def sphere_distance(s: Multivector, position: Multivector) -> tuple[Result, Result]:
    """Distance of a point from a unit dual sphere, positive outside, and its derivative by the coefficients of s.

    s . X = -(d + kappa d^2/2). The derivative is the dual sphere of radius |d| about the point, -(X - d^2/2 n_inf),
    over 1 + kappa d.
    """
    x, ni = point(position), infinity(position)
    d, slope = _signed_distance(-s.scalar_product(x), -s.scalar_product(ni))
    gradient = (d * d / 2 * ni - x) * slope
    return row([d], "distance"), row(_along_basis(gradient), "gradient")


def circle_distances(s: Multivector, p: Multivector, position: Multivector) -> tuple[Result, Result]:
    """A point's height over a circle's plane p and its distance in that plane from the circle, with their derivatives.

    The circle is the meet of the unit dual plane p and of the unit dual sphere s about a point of it. Derivatives come
    in one row: of the height by p; of the distance by s, then by p.
    """
    x, ni = point(position), infinity(position)
    curvature, z = -s.scalar_product(ni), p.scalar_product(x)
    d, slope = _signed_distance(-s.scalar_product(x) - curvature * z * z / 2, curvature)
    by_sphere = ((z * z + d * d) / 2 * ni - x) * slope
    by_plane = -curvature * z * slope * x
    derivatives = [*_along_basis(x), *_along_basis(by_sphere), *_along_basis(by_plane)]
    return row([z, d], "distances"), row(derivatives, "gradient")


def placed_sphere(s: Multivector, position: Multivector, unit: Multivector) -> tuple[Multivector, Result]:
    """The outward sphere (or plane) with the dual s in coordinates about a position, in a unit of length."""
    return _normalize_at(_outward(s, unit), s.scalar_product(s), position)


def placed_circle(
    s: Multivector, p: Multivector, position: Multivector, unit: Multivector
) -> tuple[Multivector, Result]:
    """The circle sphere* ^ plane* with these duals in coordinates about a position, in a unit of length.

    Built from its center, unless that is far away: then what is moved is the object itself, which may be a line.
    """
    curvature = -s.scalar_product(infinity(s))
    is_round = absolute(curvature) > LEAST_CURVATURE
    scale = reciprocal(select(is_round, curvature, s.constant(1)))
    center = position + unit * scale * euclidean_part(s)
    built, _ = circle(center, euclidean_part(p), unit * absolute(scale))
    moved, status = _normalize_at(_outward(s, unit) ^ _dilate(p, unit), norm_squared(s ^ p), position)
    return select(is_round, built, moved), status


def placed_plane(p: Multivector, position: Multivector, unit: Multivector) -> tuple[Multivector, Result]:
    """The plane with the dual n + d n_inf in coordinates about a position, in a unit of length."""
    flat = euclidean_part(p) + attached_part(p) * infinity(p)
    return _normalize_at(_dilate(flat, unit), norm_squared(flat), position)


def translate_sphere(s: Multivector, position: Multivector) -> Multivector:
    """A dual sphere, moved from the origin to a position."""
    return (translator(position) >> s).grade(1)


def _outward(s: Multivector, unit: Multivector) -> Multivector:
    """s or -s, with s . n_inf <= 0, scaled."""
    return _dilate(s, unit) * select(s.scalar_product(infinity(s)) > 0, s.constant(-1), s.constant(1))


def _dilate(s: Multivector, unit: Multivector) -> Multivector:
    """A vector dilated about the origin; a dilator subtracts nearly equal numbers where the unit is far from one."""
    ni, no = infinity(s), origin(s)
    return euclidean_part(s) - s.scalar_product(ni) / unit * no - s.scalar_product(no) * unit * ni


def _normalize_at(dual: Multivector, square: Multivector, position: Multivector) -> tuple[Multivector, Result]:
    """A dual object at the origin over the root of its square (far away that would be noise), moved."""
    regular = square > 0
    found = translator(position) >> dual / sqrt(where_or_nan(regular, square))
    return found.grade(*dual.grades).undual(), outcome(dual, (~regular, Status.SINGULAR))
