"""Positions of objects (center, axis, size), rotations about them, and similarities between them (thesis 4.10).

Objects are unit blades, rounds and flats alike. `center_axis_curvature` reads them for the other formulas.
"""

from __future__ import annotations

from fractions import Fraction

from ...algebra.multivector import Mask, Multivector, absolute, select, sqrt
from ...status import Status
from ...trace.outputs import Result, named
from ..objects.blades import Checked
from ..objects.conformal import infinity, origin, round_center
from ..objects.euclidean import attached_part, axes, cross, euclidean_part, space
from ..products.outcome import NOISE, epsilon, outcome, where_or_nan
from ..products.sizes import sizes
from .motions import translator

Placement = tuple[Multivector, Multivector, Multivector]
#: The product of the sizes of weights -1 and +1 is at least this fraction of the square of the middle one for rounds
#: whose radius is not, to some thousandths, the distance of their center; for flats it is noise of their distance.
ROUND_FRACTION = Fraction(1, 1024)


def is_hyper(x: Multivector) -> bool:
    """Return whether x is the dual of a vector: planes and spheres; in the plane lines and circles."""
    return x.grades == (len(x.algebra.vectors) - 1,)


def is_round(x: Multivector) -> Mask:
    """Return whether a plane or sphere is a sphere, to rounding."""
    return _is_round_vector(x.dual())


# -- center, axis and size -----------------------------------------------------------------------------------


def center_axis_curvature(x: Multivector) -> tuple[Result, Result, Result]:
    """Center (of a flat the point nearest the origin), unit axis, and 1/radius (of a flat 0) of an object.

    The axis is the normal of a circle or plane, the direction of a line or of a point pair. Spheres (e1 is given)
    and flat points (0) have none. 1/radius is negative for a sphere that is inside out.
    """
    if is_hyper(x):
        center, axis, curvature = _vector_placement(x.dual())
    else:
        center, axis, curvature = _bivector_placement(x, x if x.grades == (2,) else x.dual())
    return named("center", center), named("axis", axis), named("curvature", curvature)


def _is_round_vector(d: Multivector) -> Mask:
    """Return whether d is a sphere (C - r^2/2 n_inf)/r, not a plane n + d n_inf."""
    u, weight = euclidean_part(d), d | infinity(d)
    return _is_curved(d, weight * weight, (u * u).grade(0))


def _is_curved(d: Multivector, square: Multivector, flat_square: Multivector) -> Mask:
    """Return whether d is round, from the squares of its curvature and of what a flat has in its place.

    The curvature is no noise in a unit of length; or, of large radii, in no unit: see `ROUND_FRACTION`.
    """
    noise = NOISE * epsilon(d)
    own = sizes(d)
    return (square > noise * noise * flat_square) | (own[0] * own[2] > ROUND_FRACTION * own[1] * own[1])


def _vector_placement(d: Multivector) -> Placement:
    """Position of a plane n + d n_inf or a sphere (C - r^2/2 n_inf)/r."""
    u, first = euclidean_part(d), axes(d)[0]
    weight = -(d | infinity(d))
    foot = u * attached_part(d)
    if not weight.terms:
        return foot, u, d.constant(0)
    curved = _is_round_vector(d)
    axis = select(curved, first, u / sqrt(where_or_nan(~curved, (u * u).grade(0))))
    center = select(curved, u / where_or_nan(curved, weight), foot)
    return center, axis, select(curved, weight, d.constant(0))


def _bivector_placement(x: Multivector, d: Multivector) -> Placement:
    """Position of a point pair d, or of a line or circle x with the dual d."""
    if x.grades == (2,):
        foot, axis = euclidean_part(attached_part(d)), d.new({})
        weight = -d.scalar_product(infinity(d) ^ origin(d))
        foot = foot / where_or_nan(absolute(weight) > 0, weight)
    else:
        axis = -(euclidean_part(d) * space(d)).grade(1)
        foot = cross(axis, attached_part(d))
    if not euclidean_part(d | infinity(d)).terms:
        return foot, axis, d.constant(0)
    center, u, _ = round_center(d)
    square, flat = (u * u).grade(0), euclidean_part(d)
    curved = _is_curved(d, square, flat.scalar_product(~flat))
    curvature = sqrt(square)
    return (
        select(curved, center, foot),
        select(curved, u / where_or_nan(curved, curvature), axis),
        select(curved, curvature, d.constant(0)),
    )


def _is_there(axis: Multivector) -> Mask:
    """Return whether a unit vector or 0 is a unit vector."""
    return (axis * axis).grade(0) > 0


def _upright(axis: Multivector) -> Multivector:
    """A unit vector perpendicular to a unit vector: the part of the basis vector that is least along it, normalized."""
    candidates = axes(axis)
    best, least = candidates[0], absolute(axis | candidates[0])
    for e in candidates[1:]:
        along = absolute(axis | e)
        nearer = along < least
        best, least = select(nearer, e, best), select(nearer, along, least)
    part = best - (best | axis) * axis
    return part / sqrt((part * part).grade(0))


# -- from one place to another -------------------------------------------------------------------------------


def half_rotations(center: Multivector, axis: Multivector) -> tuple[Result, Result]:
    """Half a turn that takes the object there to its negative, and half of that.

    In the plane of its axis and an `upright`, about its center. Without an axis (flat points) the half turn is the
    inversion in the unit sphere about it, with the reflection in e1.
    """
    inversion = (origin(center) - infinity(center) / 2) ^ axes(center)[0]
    plane = select(_is_there(axis), _upright(axis) ^ axis, inversion)
    half = translator(center) >> plane
    return named("half", half), named("quarter", (1 + half) / sqrt(center.constant(2)))


def similarity(
    center1: Multivector,
    axis1: Multivector,
    curvature1: Multivector,
    center2: Multivector,
    axis2: Multivector,
    curvature2: Multivector,
) -> Checked:
    """Translation, rotation and scaling from one place to another (4.10, dilation exp(-g/2 E0), g = ln(r2/r1)).

    T(c2) D R ~T(c1): the centers c, the scaling by r2/r1, the rotation R between the axes by the smallest angle.
    Flats are moved by their points nearest the origin, without scaling. NOT_UNIQUE: axes that are opposite (half a
    turn about the `upright` of the second); a sphere and one that is inside out (x1 goes to -x2). SINGULAR: a round
    and a flat.
    """
    one = center1.constant(1)
    first, second = absolute(curvature1) > 0, absolute(curvature2) > 0
    same = (first & second) | (~first & ~second)
    inside_out = ((curvature1 < 0) & (curvature2 > 0)) | ((curvature1 > 0) & (curvature2 < 0))
    a, b = select(first, absolute(curvature1), one), select(second, absolute(curvature2), one)
    scaling = (a + b - (a - b) * (infinity(center1) ^ origin(center1))) / (2 * sqrt(where_or_nan(same, a)) * sqrt(b))
    have_axes = _is_there(axis1) & _is_there(axis2)
    rotation, opposite = _shortest_rotation(axis1, axis2)
    r = translator(center2) * (scaling * select(have_axes, rotation, one)) * translator(-center1)
    code = outcome(center1, (~same, Status.SINGULAR), ((have_axes & opposite) | inside_out, Status.NOT_UNIQUE))
    return r, code


def _shortest_rotation(a: Multivector, b: Multivector) -> tuple[Multivector, Mask]:
    """Rotation of the unit vector a to b by the smallest angle, and whether they are opposite to rounding.

    b (a + b)/|a + b|, twice: a second time from where the first one led, for small |a + b| keep few digits.
    """
    sum_square = ((a + b) * (a + b)).grade(0)
    noise = NOISE * epsilon(a)
    opposite = sum_square <= noise * noise
    first = (1 + b * a) / sqrt(where_or_nan(~opposite, sum_square))
    image = (first >> a).grade(1)
    second_sum = ((image + b) * (image + b)).grade(0)
    rotation = (1 + b * image) / sqrt(second_sum) * first
    return select(opposite, _upright(b) ^ b, rotation), opposite
