"""Objects of joints from a position and directions, as mechanics and files give them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.validation import finite_array
from ...core.geometry.euclidean import perpendicular
from ...core.multivector import Algebra, Multivector
from ..screws import geometry
from .base import Joint

Array = NDArray[Any]
#: Radius of circles of which only center and normal count.
RADIUS = 1.0


def place(
    joint: Joint, fields: tuple[str, ...], make: Callable[..., tuple[Multivector, ...]], algebra: Algebra | None,
    **given: Any,
) -> None:  # fmt: skip
    """Set the objects of a joint, if it is given by a position and directions and not by the objects themselves.

    Parameters
    ----------
    joint : Joint
    fields : tuple of str
        Names of its objects.
    make : callable
        Makes them from an algebra, the position and directions.
    algebra : Algebra, optional
        Default: cga3d.
    **given
        The position, and directions of any length; None where none is given.

    Raises
    ------
    InputError
        If there are both or neither, one object where two are needed, a direction is zero, or numbers are not finite.
    """
    names = " and ".join(f"{name}=" for name in given)
    missing = [name for name, value in given.items() if value is None]
    if getattr(joint, fields[0]) is not None:
        if len(missing) < len(given) or algebra is not None:
            raise InputError(f"{joint.label} is given by objects, and by {names} too.", remedy="Give one of them")
        if len(fields) > 1 and getattr(joint, fields[1]) is None:
            raise InputError(f"{joint.label} has one object; it is of two.", remedy=joint.remedy or f"Or give {names}")
        return
    if missing:
        remedy = f"Give {names}, or the objects that the bodies share"
        raise InputError(f"{joint.label} has no {missing[0]}.", remedy=remedy)
    home = geometry(algebra, f"{joint.label}: its algebra")
    vectors = {name: finite_array(value, f"{joint.label}: its {name}", (3,)) for name, value in given.items()}
    for name, vector in vectors.items():
        if name != "point" and not vector.any():
            raise InputError(f"{joint.label}: its {name} is zero.", remedy="Give a direction, of any length")
        if name != "point":  # no square over- or underflows
            vectors[name] = np.ldexp(vector, -np.frexp(np.abs(vector).max())[1])
    for field, x in zip(fields, make(home, *vectors.values()), strict=False):
        object.__setattr__(joint, field, x)


def ball(algebra: Algebra, point: Array) -> tuple[Multivector, ...]:
    """A point."""
    return (algebra.point(point, strict=True),)


def line(algebra: Algebra, point: Array, axis: Array) -> tuple[Multivector, ...]:
    """A line along the axis."""
    return (algebra.line(point, axis, strict=True),)


def hinge(algebra: Algebra, point: Array, axis: Array) -> tuple[Multivector, ...]:
    """A circle; in PGA, which has none, a line and a point on it."""
    if algebra.is_degenerate:
        return (*line(algebra, point, axis), *ball(algebra, point))
    return (algebra.circle(point, axis, RADIUS, strict=True),)


def slide(algebra: Algebra, point: Array, axis: Array) -> tuple[Multivector, ...]:
    """A line along the axis, and a direction across."""
    return (*line(algebra, point, axis), algebra.direction(perpendicular(axis), strict=True))


def plane(algebra: Algebra, point: Array, normal: Array) -> tuple[Multivector, ...]:
    """A plane through the point."""
    unit = normal / np.linalg.norm(normal)
    return (algebra.plane(unit, float(unit @ point), strict=True),)


def cross(algebra: Algebra, point: Array, axis_a: Array, axis_b: Array) -> tuple[Multivector, ...]:
    """Two circles about the point."""
    if algebra.is_degenerate:
        raise InputError(f"a universal joint is not of {algebra.name}, which has no circles.", remedy="Use cga3d")
    return tuple(algebra.circle(point, axis, RADIUS, strict=True) for axis in (axis_a, axis_b))


__all__ = ["ball", "cross", "hinge", "line", "place", "plane", "slide"]
