"""Checked numbers from users: finite vectors, unit normals, positive lengths; and CGA objects read back into them.

Errors are `SceneError`s that name the value. Objects may be given by parameters or by coefficients (anything with
``.values``, or an array): far from the origin parameters keep more digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..codegen.formulas import rays, surfaces
from ..codegen.multivector import Multivector, from_values
from ..codegen.programs import cga3d
from ..codegen.rings import NumericRing
from ..errors import SceneError

Array = NDArray[np.float64]
#: A normal shorter than this has no direction that means anything.
TINY = 1e-150


class Circle(NamedTuple):
    """A circle that turns counter-clockwise about its normal."""

    center: Array
    normal: Array
    radius: float


def finite(value: Any, name: str, size: int | None = None) -> Array:
    """A finite float64 array, with ``size`` entries where one is given."""
    try:
        array = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise SceneError(f"{name} is {value!r}; numbers are needed.") from None
    if size is not None and array.shape != (size,):
        raise SceneError(f"{name} has shape {array.shape}; {size} numbers are needed.")
    if not np.all(np.isfinite(array)):
        raise SceneError(f"{name} is {array.tolist()}; numbers are finite.")
    return array


def number(value: Any, name: str) -> float:
    """One finite number."""
    return float(finite(np.reshape(value, -1) if np.size(value) == 1 else value, name, 1)[0])


def positive(value: Any, name: str) -> float:
    """One number above zero."""
    x = number(value, name)
    if x <= 0:
        raise SceneError(f"{name} is {x:g}; it must be positive.")
    return x


def between(value: Any, name: str, low: float, high: float) -> float:
    """One number in an interval."""
    x = number(value, name)
    if not low <= x <= high:
        raise SceneError(f"{name} is {x:g}; it must lie between {low:g} and {high:g}.")
    return x


def color(value: Any, name: str) -> Array:
    """Linear red, green and blue, not negative."""
    rgb = finite(value, name, 3)
    if np.any(rgb < 0):
        raise SceneError(f"{name} is {rgb.tolist()}; colors are not negative.")
    return rgb


def unit(value: Any, name: str) -> Array:
    """A direction of length 1."""
    v = finite(value, name, 3)
    largest = float(np.max(np.abs(v)))
    if largest < TINY:
        raise SceneError(f"{name} is {v.tolist()}; a direction is not zero.")
    v = v / largest
    return v / np.sqrt(v @ v)


# -- objects of the algebra ------------------------------------------------------------------------------------


def coefficients(value: Any, kind: str) -> Array | None:
    """Coefficients of an object of this kind, or None if the value is no such object."""
    values = getattr(value, "values", value)
    if isinstance(value, Mapping) or callable(values):
        return None
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        return None
    return array if array.shape == (cga3d().kind(kind).size,) else None


def _multivector(values: Array, kind: str) -> Multivector:
    return from_values(cga3d(), NumericRing(), cga3d().kind(kind).blades, list(values))


def _vector(x: Multivector) -> Array:
    return np.array([x[name].scalar() for name in ("e1", "e2", "e3")], np.float64)


def read_plane(values: Array) -> tuple[Array, float]:
    """Unit normal and offset of a plane."""
    dual = _multivector(finite(values, "the plane"), "plane").dual()
    normal, offset = _vector(dual), float(dual["ni"].scalar())
    length = float(np.linalg.norm(normal))
    if length < TINY:
        raise SceneError("the plane has no normal.")
    return normal / length, offset / length


def read_sphere(values: Array) -> tuple[Array, float]:
    """Centre and radius of a sphere of either orientation."""
    dual = _multivector(finite(values, "the sphere"), "sphere").dual()
    weight = float(dual["no"].scalar())
    if abs(weight) < TINY:
        raise SceneError("the sphere is a plane.")
    center = _vector(dual) / weight
    square = float(rays.dot(dual, dual).scalar()) / weight**2
    if square <= 0:
        raise SceneError("the sphere is imaginary.")
    return center, float(np.sqrt(square))


def read_circle(values: Array) -> Circle:
    """Centre, normal and radius of a circle."""
    circle = _multivector(finite(values, "the circle"), "circle")
    normal = -_vector((circle ^ rays.ni(circle)).dual())
    if float(np.linalg.norm(normal)) < TINY:
        raise SceneError("the circle is a line.")
    square = float(surfaces.circle_square(circle).scalar())
    if square <= 0:
        raise SceneError("the circle is imaginary.")
    return Circle(_vector(surfaces.circle_center(circle)), unit(normal, "normal"), float(np.sqrt(square)))


def circle(value: Any, name: str) -> Circle:
    """A circle from (center, normal, radius), a mapping of these, or its coefficients."""
    array = coefficients(value, "circle")
    if array is not None:
        return read_circle(array)
    if isinstance(value, Mapping):
        missing = [key for key in Circle._fields if key not in value]
        if missing:
            raise SceneError(f"{name} has no {missing[0]}; a circle has center, normal and radius.")
        value = [value[key] for key in Circle._fields]
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise SceneError(f"{name} is no circle; give (center, normal, radius) or its coefficients.")
    center, normal, radius = value
    return Circle(
        finite(center, f"{name}.center", 3), unit(normal, f"{name}.normal"), positive(radius, f"{name}.radius")
    )
