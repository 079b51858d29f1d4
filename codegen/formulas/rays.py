"""Rays against planes, spheres and discs; reflection, normals and lighting (thesis 4.3, 4.4).

Positions and directions are Euclidean vectors; a direction may have any length, and a parameter t counts in
units of it. Objects are moved to a local origin before anything is multiplied: far from the origin a point
stores the square of its distance, and subtracting two such squares loses every digit that matters.
"""

from __future__ import annotations

from ..multivector import Multivector, exp, log, select, sqrt
from ..trace import Result, named, row
from .conformal import infinity as ni
from .conformal import origin as no
from .conformal import point
from .euclidean import euclidean_part as euclidean


def zero(x: Multivector) -> Multivector:
    """The zero of the same algebra and ring, as a position the local origin."""
    return x.new({})


def dot(x: Multivector, y: Multivector) -> Multivector:
    """Scalar product, also where an operand vanishes identically."""
    return x.scalar_product(y)


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


def pair_points(pair: Multivector) -> tuple[Multivector, Multivector]:
    """Positions A, B of a point pair F = A ^ B; NaN for an imaginary one.

    (4.5) times sqrt(F^2), so that a tangent's double point is found too.
    """
    chord = pair | ni(pair)
    root = sqrt(dot(pair, pair))
    middle = (pair * chord).grade(1)
    first, last = root * chord - middle, root * chord + middle
    return euclidean(first) / -dot(first, ni(pair)), euclidean(last) / -dot(last, ni(pair))


def pair_parameters(pair: Multivector, origin: Multivector, direction: Multivector) -> list[Multivector]:
    """Parameters t of a ray's points on a sphere about the origin; the origin's foot is their middle."""
    square = dot(direction, direction)
    middle = -dot(origin, direction) / square
    half = sqrt(dot(pair, pair)) / square
    return [middle - half, middle + half]


def sphere_hit(
    origin: Multivector, direction: Multivector, center: Multivector, radius: Multivector
) -> tuple[Result, Result, Result]:
    """Parameters of the first and last point of a ray on a sphere, and the points relative to the centre.

    The sphere stands at the origin, so F = L v S has the square r^2 m^2 - moment^2 of the line's direction m
    and moment about the centre. NaN where the ray passes by.
    """
    relative = origin - center
    pair = line(relative, direction) & dual_sphere(zero(relative), radius * radius).undual()
    first, last = pair_points(pair)
    return row(pair_parameters(pair, relative, direction), "t"), named("first", first), named("last", last)


def disc_hit(
    origin: Multivector, direction: Multivector, center: Multivector, normal: Multivector, radius: Multivector
) -> tuple[Result, Result]:
    """Parameter of the point of a ray on a disc's plane with Y^2, and the point relative to the centre.

    Y = L v C; the ray passes through the disc where Y^2 < 0 (thesis 4.4.1).
    """
    relative = origin - center
    rim = (dual_sphere(zero(relative), radius * radius) ^ normal).undual()
    meet = line(relative, direction) & rim
    t = -dot(relative, normal) / dot(direction, normal)
    return row([t, dot(meet, meet)], "t_square"), named("local", relative + t * direction)


# -- reflection and light ----------------------------------------------------------------------------------


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


def light_terms(
    position: Multivector, normal: Multivector, direction: Multivector, light: Multivector, shininess: Multivector
) -> tuple[Result, Result]:
    """Vector from a position to a light, and the factors of Lambert's law and of Blinn's highlight.

    Both are 0 where the light is behind the surface.
    """
    towards = light - position
    lamp, eye = unit(towards), unit(direction)
    half = lamp - eye
    lambert = dot(lamp, normal)
    blinn = dot(half, normal) / sqrt(dot(half, half))
    nothing = lambert.constant(0)
    highlight = select((lambert > 0) & (blinn > 0), exp(shininess * log(blinn)), nothing)
    return named("towards", towards), row([select(lambert > 0, lambert, nothing), highlight], "factors")


# -- camera ------------------------------------------------------------------------------------------------


def camera_direction(motor: Multivector, lens: tuple[Multivector, ...], pixel: tuple[Multivector, ...]) -> Multivector:
    """Unit direction of the ray through a point of the image plane (4.2, through pixel centres).

    ``lens`` holds the focal length and the widths x_max and y_max of the image plane; ``pixel`` runs over
    [-1, 1] from left to right and from bottom to top. The camera looks along e2, with e1 right and e3 up.
    """
    focal, x_max, y_max = lens
    right, up = pixel
    e1, e2, e3 = (motor.basis(name) for name in ("e1", "e2", "e3"))
    target = focal * e2 + x_max / 2 * right * e1 + y_max / 2 * up * e3
    ray = motor >> line(zero(target), target)
    return unit(line_direction(ray.grade(3)))


def camera_position(motor: Multivector) -> Multivector:
    """Where a motor takes the origin."""
    return euclidean(motor >> no(motor))
