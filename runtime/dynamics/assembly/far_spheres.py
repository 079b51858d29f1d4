"""Spheres far from the origin: beside the squared distance in their coefficients, the radius loses digits.

A sphere of radius r at distance c is known to eps c^2/r. Where that is more than rounding, the driver's sphere is
rebuilt in its own frame: about the center, through the pinned point if that starts on the sphere to the accuracy of the
coefficients; otherwise with their radius. The constraint receives the radius error.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Multivector

Array = NDArray[np.float64]
EPSILON, TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)
#: A radius that is known to this share is known.
KNOWN = 1e-14
#: Roundings that come together in the coefficients of a sphere that users made and moved.
ROUNDINGS = 8.0


def unknown_of(sphere: Multivector) -> float:
    """Length by which the radius of a sphere is not known; 0 for what is known well, and for other objects."""
    if sphere.kind.name != "sphere":
        return 0.0
    center, radius = _exact_parameters(sphere)
    unknown = _unknown(center, radius)
    return float(unknown.max()) if (unknown > KNOWN * radius).any() else 0.0


def _unknown(center: Array, radius: Array) -> Array:
    """Lengths that rounding of the squares of distances adds to radii or takes from them: its root at most."""
    square = EPSILON * (center**2).sum(-1)
    return np.asarray(square / np.maximum(np.maximum(radius, np.sqrt(square)), TINY))


def far_sphere(sphere: Multivector, frame: Multivector, point: Multivector) -> tuple[Multivector, float] | None:
    """A sphere of the world as a frame sees it, and by how much its radius is not known; None if it is known well.

    Parameters
    ----------
    sphere : Multivector
        In the world.
    frame : Multivector
        Motor of the frame.
    point : Multivector
        What is held, at the start, as the frame sees it.
    """
    if not unknown_of(sphere):
        return None
    center, radius = _exact_parameters(sphere)
    unknown, algebra, moved = _unknown(center, radius), sphere.algebra, ~frame >> sphere
    place = (~frame >> algebra.point(center)).parameters().xyz
    gap = np.linalg.norm(point.parameters().xyz - place, axis=-1)
    near = (np.abs(gap - radius) <= ROUNDINGS * unknown) & (gap > 0)
    known = np.where(near, gap, radius)
    if not known.all():  # a sphere of radius 0 has no coefficients of a unit sphere
        return moved, float(unknown.max())
    anew: Multivector = algebra.sphere(place, known).as_kind("sphere")
    sign = np.sign((anew.values * moved.values).sum(-1))
    return anew * sign, float(np.where(near, np.abs(gap - radius), unknown).max())


def _exact_parameters(sphere: Multivector) -> tuple[Array, Array]:
    """Centers and radii that coefficients mean, rounded once."""
    dual = sphere.dual()
    names = [dual.algebra.blade_name(b) for b in dual.kind.blades]
    values = dual.values[..., [names.index(name) for name in ("e1", "e2", "e3", "no", "ni")]]
    found = np.array([_parameters(row) for row in values.reshape(-1, 5)]).reshape(*values.shape[:-1], 4)
    return found[..., :3], found[..., 3]


def _parameters(row: Array) -> list[float]:
    *center, weight, offset = (Fraction(float(x)) for x in row)
    center = [x / weight for x in center]
    square = sum((x * x for x in center), -2 * offset / weight)
    return [*map(float, center), max(0.0, float(square)) ** 0.5]
