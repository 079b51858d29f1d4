"""Objects of PGA from their parameters, and their parameters back (thesis 1.4; conventions of the whole project).

Planes are vectors n + d e0 with n . x = d; points are the meets of their coordinate planes, directions the points
at infinity; planes meet by ^, and & joins. X ~X = +1 for planes, lines and points.
"""

from __future__ import annotations

from ...algebra.multivector import Multivector, absolute, sqrt
from ...status import Status
from ...trace.outputs import Result, named
from ..products.outcome import NOISE, epsilon, outcome, where_or_nan
from .blades import Checked
from .euclidean import attached_part, cross, direction_of, euclidean_part, null_vector, space

# -- from parameters ---------------------------------------------------------------------------------------


def point(position: Multivector) -> Multivector:
    """(e1 + x1 e0) ^ (e2 + x2 e0) ^ (e3 + x3 e0) = (1 + e0 x) I3."""
    return (1 + null_vector(position) * position) * space(position)


def direction(vector: Multivector) -> Multivector:
    """e0 v I3: the difference of two points, not normalized."""
    return null_vector(vector) * vector * space(vector)


def line(point: Multivector, direction: Multivector) -> Checked:
    """m I3 + (p x m) e0, m the unit vector along the direction. INVALID: the direction is zero."""
    m, scale = direction_of(direction)
    return line_of(m, point), outcome(point, (~(scale > 0), Status.INVALID))


def line_of(m: Multivector, p: Multivector) -> Multivector:
    """Line through p along the unit vector m."""
    return m * space(m) + cross(p, m) * null_vector(m)


def plane(normal: Multivector, offset: Multivector) -> Checked:
    """Plane normal . x = offset; the normal need not be unit. INVALID: it is zero."""
    n, scale = direction_of(normal)
    return n + offset * scale * null_vector(normal), outcome(normal, (~(scale > 0), Status.INVALID))


def line_through(a: Multivector, b: Multivector) -> Checked:
    """Line from a to b: the join of the points, normalized. SINGULAR: a = b."""
    m, scale = direction_of(b - a)
    return line_of(m, a), outcome(a, (~(scale > 0), Status.SINGULAR))


def line_in_plane(a: Multivector, b: Multivector) -> Checked:
    """Line of the plane from a to b: the join of the points, normalized. SINGULAR: a = b."""
    m, scale = direction_of(b - a)
    normal = -(m * space(m))
    return normal + (normal | a) * null_vector(a), outcome(a, (~(scale > 0), Status.SINGULAR))


def plane_through(a: Multivector, b: Multivector, c: Multivector) -> Checked:
    """Join of three points, normalized. SINGULAR: they are on a line."""
    u, v = b - a, c - a
    normal = cross(u, v)
    square, noise = (normal * normal).grade(0), NOISE * epsilon(a)
    regular = square > noise * noise * (u * u).grade(0) * (v * v).grade(0)
    unit = normal / sqrt(where_or_nan(regular, square))
    return unit + (unit | a) * null_vector(a), outcome(a, (~regular, Status.SINGULAR))


def normalise_point(x: Multivector) -> Checked:
    """A point at weight one, so that x ~I3 = 1 + e0 x. SINGULAR: it is at infinity."""
    weight = x.scalar_product(~space(x))
    regular = absolute(weight) > 0
    return x / where_or_nan(regular, weight), outcome(x, (~regular, Status.SINGULAR))


# -- back to parameters ------------------------------------------------------------------------------------


def point_parameters(x: Multivector) -> tuple[Result, Result]:
    """Position of a point of any weight. SINGULAR: it is at infinity."""
    unit, status = normalise_point(x)
    return named("position", -attached_part(unit * ~space(x)).grade(1)), status


def direction_parameters(x: Multivector) -> Result:
    """The vector of a direction."""
    return named("vector", -attached_part(x * ~space(x)).grade(1))


def line_parameters(x: Multivector) -> tuple[Result, Result]:
    """Point nearest the origin and unit direction of a unit line m I3 + (p x m) e0."""
    m = -(euclidean_part(x) * space(x)).grade(1)
    return named("point", cross(m, attached_part(x))), named("direction", m)


def plane_parameters(x: Multivector) -> tuple[Result, Result]:
    """Unit normal and offset of a unit plane."""
    return named("normal", euclidean_part(x)), named("offset", attached_part(x))


# -- other systems -----------------------------------------------------------------------------------------


def printed_point(position: Multivector) -> Multivector:
    """J(x + e0) of thesis 1.4.1: with our planes and translators it is minus the point -x."""
    return (position + null_vector(position)).complement()
