"""Rays against planes, spheres and discs; reflection and normals (thesis 4.3, 4.4).

Positions and directions are Euclidean vectors; a direction may have any length, and a parameter t counts in
units of it. Objects are moved to a local origin before anything is multiplied: far from the origin a point
stores the square of its distance, and subtracting two such squares loses every digit that matters.
"""

from __future__ import annotations

from fractions import Fraction

from ...algebra.multivector import Mask, Multivector, absolute, reciprocal, select, sqrt
from ...status import Status
from ...trace.outputs import Result, named, row
from ..motions.motions import translator
from ..objects.conformal import infinity as ni
from ..objects.conformal import line as unit_line
from ..objects.conformal import origin as no
from ..objects.conformal import point
from ..objects.euclidean import attached_part, dot, length
from ..objects.euclidean import euclidean_part as euclidean
from ..products.outcome import epsilon, is_finite, outcome, size, where_or_nan

#: A ray lies in a plane if its slope is below this many rounding errors: two or three come with its own numbers.
FLAT = 8
#: Slope below which a ray grazes: above, a point is off by less than boxes are wider for rounding (boxes.py).
GRAZING = Fraction(1, 64)


def zero(x: Multivector) -> Multivector:
    """The zero of the same algebra and ring, as a position the local origin."""
    return x.new({})


def unit(x: Multivector) -> Multivector:
    """A Euclidean vector over its length."""
    return x / sqrt(dot(x, x))


# -- objects, of any weight --------------------------------------------------------------------------------


def line(origin: Multivector, direction: Multivector) -> Multivector:
    """X ^ direction ^ n_inf: the line through a position; its weight is the length of the direction."""
    return (origin + no(origin)) ^ direction ^ ni(origin)


def dual_plane(normal: Multivector, offset: Multivector) -> Multivector:
    """Dual of the plane normal . x = offset."""
    return normal + offset * ni(normal)


def dual_sphere(center: Multivector, square: Multivector) -> Multivector:
    """Dual of the sphere of a squared radius, weighted S* . n_inf = -1 (4.6)."""
    return point(center) - square / 2 * ni(center)


def circle(center: Multivector, normal: Multivector, radius: Multivector) -> Multivector:
    """The unit circle that turns counter-clockwise about its normal, the dual of sphere* ^ plane*."""
    sphere = dual_sphere(center, radius * radius) / radius
    return (sphere ^ dual_plane(normal, dot(normal, center))).undual()


# -- meets -------------------------------------------------------------------------------------------------


def plane_hit(origin: Multivector, direction: Multivector, normal: Multivector, offset: Multivector) -> Result:
    """Parameter t of the point of a ray on a plane, infinite or NaN where they are parallel.

    X(t) . Phi* = 0 is linear in t: the meet L v Phi of (4.4) in the ray's own frame.
    """
    plane = dual_plane(normal, offset)
    return row([-dot(point(origin), plane) / dot(direction, plane)], "t")


def pair_root(origin: Multivector, direction: Multivector, radius: Multivector) -> Multivector:
    """sqrt(F^2) of the pair F = L v S of a ray and a sphere about the origin; NaN where the ray passes by.

    F^2 = r^2 m^2 - |X ^ m|^2 of the line's direction m and moment. Multiplied out from F it is the same, but longer.
    """
    moment = origin ^ direction
    return sqrt(radius * radius * dot(direction, direction) - dot(moment, ~moment))


def pair_points(pair: Multivector, root: Multivector | None = None) -> tuple[Multivector, Multivector]:
    """Positions A, B of a point pair F = A ^ B; NaN for an imaginary one. ``root`` is sqrt(F^2), where it is known.

    (4.5) times that root, so that a tangent's double point is found too.
    """
    chord = pair | ni(pair)
    root = sqrt(dot(pair, pair)) if root is None else root
    middle = (pair * chord).grade(1)
    first, last = root * chord - middle, root * chord + middle
    return euclidean(first) / -dot(first, ni(pair)), euclidean(last) / -dot(last, ni(pair))


def pair_parameters(
    pair: Multivector, origin: Multivector, direction: Multivector, root: Multivector | None = None
) -> list[Multivector]:
    """Parameters t of a ray's points on a sphere about the origin; the origin's foot is their middle."""
    square = dot(direction, direction)
    middle = -dot(origin, direction) / square
    half = (sqrt(dot(pair, pair)) if root is None else root) / square
    return [middle - half, middle + half]


def sphere_hit(
    origin: Multivector, direction: Multivector, center: Multivector, radius: Multivector
) -> tuple[Result, Result, Result]:
    """Parameters of the first and last point of a ray on a sphere, and the points relative to the center.

    The sphere stands at the origin, and F = L v S. NaN where the ray passes by.
    """
    relative = origin - center
    pair = line(relative, direction) & dual_sphere(zero(relative), radius * radius).undual()
    root = pair_root(relative, direction, radius)
    first, last = pair_points(pair, root)
    return row(pair_parameters(pair, relative, direction, root), "t"), named("first", first), named("last", last)


def along_plane(direction: Multivector, normal: Multivector) -> Mask:
    """Return whether a direction lies in the planes of a normal, to rounding."""
    return absolute(dot(direction, normal)) <= FLAT * epsilon(direction) * size(direction)


def within(x: Multivector, low: Multivector, high: Multivector) -> Multivector:
    """The number between two that is nearest to x; x itself where it is no number."""
    return select(x < low, low, select(x > high, high, x))


def disc_hit(
    origin: Multivector, direction: Multivector, center: Multivector, normal: Multivector, radius: Multivector
) -> tuple[Result, Result]:
    """Hit of a ray on a disc's plane: its parameter, Y^2, whether it runs along the plane; the point from the center.

    Y = L v C; the ray passes through the disc where Y^2 < 0 (thesis 4.4.1). It runs along: 1, it grazes: -1.
    """
    relative = origin - center
    rim = (dual_sphere(zero(relative), radius * radius) ^ normal).undual()
    meet = line(relative, direction) & rim
    slope = dot(direction, normal)
    t = -dot(relative, normal) / slope
    grazes = select(absolute(slope) <= GRAZING * size(direction), t.constant(-1), t.constant(0))
    along = select(along_plane(direction, normal), t.constant(1), grazes)
    return row([t, dot(meet, meet), along], "t_square_along"), named("local", relative + t * direction)


def disc_graze(
    origin: Multivector, direction: Multivector, center: Multivector, normal: Multivector, radius: Multivector
) -> tuple[Result, Result]:
    """The parameter, and the point from the center, of a ray that grazes a disc: its slope may be mostly rounding.

    No point of the disc is further from the center than the radius: this tells better whether the ray meets it (t is
    NaN if not) and where.
    """
    relative = origin - center
    over = reciprocal(dot(direction, direction))
    middle, half = -dot(relative, direction) * over, radius * sqrt(over)
    foot, reach = relative + middle * direction, radius + rim_noise(origin, center, radius)
    near = within(-dot(relative, normal) / dot(direction, normal), middle - half, middle + half)
    t = where_or_nan(dot(foot, foot) <= reach * reach, near)
    return row([t], "t"), named("local", relative + t * direction)


def rim_noise(origin: Multivector, center: Multivector, radius: Multivector) -> Multivector:
    """By how much a ray's distance from a disc may be off.

    Twice that of `along_plane`: where the slope is below its noise, a point within the disc is below this one.
    """
    return 2 * FLAT * epsilon(origin) * (size(origin) + size(center) + radius)


def rim_hit(
    origin: Multivector, direction: Multivector, center: Multivector, normal: Multivector, radius: Multivector
) -> tuple[Result, Result, Result]:
    """Parameters and points, relative to the center, of a ray that lies in a disc's plane on its rim; NaN for none.

    There Y vanishes, and the meet is taken in the plane: <L C>_2 dualized in it, two points where its square is
    positive (4.4.1 says negative). The pair is L v S with the sphere of the rim's own center and radius, which has
    no trouble with a line that leaves the plane by rounding. A tangent has one point, the foot of the center. Both
    are told to rounding of the numbers that ray and disc are made of.
    """
    relative = origin - center
    middle = -dot(relative, direction) / dot(direction, direction)
    foot = relative + middle * direction
    noise = rim_noise(origin, center, radius)
    inside = along_plane(direction, normal) & (absolute(dot(foot, normal)) <= noise)
    distance = sqrt(dot(foot, foot))
    touches = absolute(distance - radius) <= noise
    pair = line(foot, direction) & dual_sphere(zero(foot), radius * radius).undual()
    first, last = pair_points(pair)
    early, late = (middle + t for t in pair_parameters(pair, foot, direction))
    once, twice = inside & touches, inside & ~touches & (distance < radius)
    t = [select(once, middle, where_or_nan(twice, early)), where_or_nan(twice, late)]
    return row(t, "t"), named("first", select(once, foot, first)), named("last", last)


# -- reflection ----------------------------------------------------------------------------------------------


def reflect_in_plane(ray: Multivector, plane: Multivector) -> Multivector:
    """Phi L Phi: the reflected line, correctly oriented, for a unit plane."""
    return plane * ray * plane


def reflect_in_sphere(ray: Multivector, sphere: Multivector, hit: Multivector) -> Multivector:
    """-(X . (S L S)) ^ n_inf, up to a positive weight (4.7)."""
    return -((hit | (sphere * ray * sphere).grade(3)) ^ ni(ray))


def tangent_plane(sphere: Multivector, hit: Multivector) -> Multivector:
    """(X . S) ^ n_inf (4.8)."""
    return (hit | sphere) ^ ni(hit)


def line_direction(ray: Multivector) -> Multivector:
    """Euclidean direction of a line, of the line's weight."""
    return euclidean(-(ray | (no(ray) ^ ni(ray))))


def reflected_direction(direction: Multivector, normal: Multivector) -> Multivector:
    """Direction of Phi L Phi for the plane with a unit normal through the ray's own origin (4.8)."""
    plane = dual_plane(normal, zero(normal)).undual()
    return line_direction(reflect_in_plane(line(zero(direction), direction), plane).grade(3))


def facing(normal: Multivector, direction: Multivector) -> Multivector:
    """The normal or its opposite, whichever looks towards where the ray comes from."""
    along = dot(normal, direction)
    return select(along > 0, along.constant(-1), along.constant(1)) * normal


# -- lines at a point of a surface ---------------------------------------------------------------------------


def line_from(position: Multivector, ray: Multivector) -> tuple[Result, Result]:
    """Direction of a unit line, and its distance from a position: its moment as seen from there."""
    moved = (translator(-position) >> ray).grade(3)
    return named("direction", line_direction(moved)), row([length(attached_part(moved.dual()))], "distance")


def plane_contact(position: Multivector, normal: Multivector, offset: Multivector) -> tuple[Result, Result]:
    """Distance of a position from a plane, and the unit normal there."""
    return row([absolute(dot(point(position), dual_plane(normal, offset)))], "distance"), named("normal", normal)


def sphere_contact(position: Multivector, center: Multivector, radius: Multivector) -> tuple[Result, Result]:
    """Distance of a position from a sphere, and the unit normal there: that of (X . S) ^ n_inf in (4.8)."""
    relative = position - center
    far = length(relative)
    return row([absolute(far - radius)], "distance"), named("normal", relative / far)


def disc_contact(
    position: Multivector, center: Multivector, normal: Multivector, radius: Multivector
) -> tuple[Result, Result]:
    """Distance of a position from a disc, and the disc's normal."""
    relative = position - center
    height = dot(relative, normal)
    across = length(relative - height * normal) - radius
    beyond = select(across > 0, across, across.constant(0))
    return row([sqrt(height * height + beyond * beyond)], "distance"), named("normal", normal)


def reflected_line(position: Multivector, direction: Multivector, normal: Multivector) -> tuple[Multivector, Result]:
    """The unit line Phi L Phi through a position, for the plane Phi there (4.8)."""
    line, _ = unit_line(position, reflected_direction(direction, normal))
    return line, outcome(normal, (~is_finite(normal), Status.SINGULAR))


def normal_line(
    position: Multivector, direction: Multivector, normal: Multivector, least: Multivector
) -> tuple[Multivector, Result]:
    """N ~ L' - L: the unit line along the normal, on the side that L comes from.

    The difference vanishes where L grazes the surface; the normal does not, but its side is lost there. NOT_UNIQUE,
    where the cosine of their angle is below ``least``.
    """
    cosine = absolute(dot(normal, direction))
    line, _ = unit_line(position, facing(normal, direction))
    return line, outcome(cosine, (~is_finite(normal), Status.SINGULAR), (cosine <= least, Status.NOT_UNIQUE))


def tangent_line(
    position: Multivector, direction: Multivector, normal: Multivector, least: Multivector
) -> tuple[Multivector, Result]:
    """L_T ~ L' + L: the unit line along L's own part in the tangent plane, (m ^ n) n.

    SINGULAR: L comes along the normal, and the sine of their angle is below ``least``.
    """
    along = ((direction ^ normal) * normal).grade(1)
    sine = length(along)
    line, _ = unit_line(position, where_or_nan(sine > least, sine) / sine * along)
    return line, outcome(sine, (~(sine > least), Status.SINGULAR))
