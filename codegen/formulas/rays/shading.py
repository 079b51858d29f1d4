"""Lights and the camera of a picture (thesis 4.2)."""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.multivector import Multivector, exp, log, select, sqrt
from ...trace.outputs import Result, named, row
from ..objects.conformal import origin as no
from ..objects.euclidean import dot
from ..objects.euclidean import euclidean_part as euclidean
from .rays import line, line_direction, unit, zero


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


class Lens(NamedTuple):
    """Focal length, and the widths of the image plane."""

    focal: Multivector
    x_max: Multivector
    y_max: Multivector


class Pixel(NamedTuple):
    """A point of the image plane, over [-1, 1] from left to right and from bottom to top."""

    right: Multivector
    up: Multivector


def camera_direction(motor: Multivector, lens: Lens, pixel: Pixel) -> Multivector:
    """Unit direction of the ray through a point of the image plane (4.2, through pixel centers).

    The camera looks along e2, with e1 right and e3 up.
    """
    focal, x_max, y_max = lens
    right, up = pixel
    e1, e2, e3 = (motor.basis(name) for name in ("e1", "e2", "e3"))
    target = focal * e2 + x_max / 2 * right * e1 + y_max / 2 * up * e3
    ray = motor >> line(zero(target), target)
    return unit(line_direction(ray.grade(3)))


def camera_position(motor: Multivector) -> Multivector:
    """Image of the origin under a motor."""
    return euclidean(motor >> no(motor))
