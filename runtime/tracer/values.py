"""Checked numbers from users: finite vectors, unit normals, positive lengths; CGA objects read into them.

Errors are `SceneError`s that name the value. Objects may be given by parameters or by coefficients (anything
with ``.values``, or an array): far from the origin parameters keep more digits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..codegen.formulas import conformal
from ..codegen.multivector import Multivector, from_values
from ..codegen.programs import cga3d
from ..codegen.rings import NumericRing
from ..codegen.trace import Result
from ..errors import SceneError, suggest

Array = NDArray[np.float64]
T = TypeVar("T")
#: Letters of a wrong value that a message repeats.
MOST_SHOWN = 60
#: A normal shorter than this has no direction that means anything.
TINY = 1e-150
#: Light of which products with colors and shares are numbers, in single precision too.
BRIGHTEST = 1e9
#: Squares and products of larger parameters would overflow on the way.
LARGEST = 1e90
#: Parameters of the objects that evolved surfaces follow, by kind.
FIELDS = {"circle": ("center", "normal", "radius"), "point_pair": ("a", "b")}


class Circle(NamedTuple):
    """A circle that turns counter-clockwise about its normal."""

    center: Array
    normal: Array
    radius: float


class PointPair(NamedTuple):
    """Two end points, from a to b."""

    a: Array
    b: Array


def shown(value: Any) -> str:
    """A wrong value as messages repeat it: one line, and not a long one."""
    try:
        line = " ".join(repr(value).split())
    except Exception:  # whatever a foreign object does
        line = type(value).__name__
    return line if len(line) <= MOST_SHOWN else f"{line[:MOST_SHOWN]}.."


def reals(value: Any) -> NDArray[Any] | None:
    """An array of real numbers, or None: complex numbers, texts, objects and masked arrays are never converted."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        return None
    if isinstance(value, np.ma.MaskedArray):
        return None  # what the mask hides would come to light
    return array if array.dtype.kind in "iuf" else None


def finite(value: Any, name: str, size: int | None = None) -> Array:
    """A finite float64 array, with ``size`` entries where one is given."""
    found = reals(value)
    if found is None:
        raise SceneError(f"{name} is {shown(value)}; real numbers are needed.")
    array = found.astype(np.float64)
    if size is not None and array.shape != (size,):
        raise SceneError(f"{name} has shape {array.shape}; {size} numbers are needed.")
    if not np.all(np.isfinite(array)):
        raise SceneError(f"{name} is {shown(array.tolist())}; numbers are finite.")
    array.setflags(write=False)  # drivers hold copies
    return array


def number(value: Any, name: str) -> float:
    """One finite number."""
    if type(value) is float and math.isfinite(value):
        return value  # most are: scenes have thousands
    array = finite(value, name)
    return float(finite(array.reshape(-1) if array.size == 1 else array, name, 1)[0])


def flag(value: Any, name: str) -> bool:
    """True or False, and nothing that merely counts as one of them."""
    return truth(value, name, SceneError)


def text(value: Any, name: str) -> str:
    """A text."""
    if not isinstance(value, str):
        raise SceneError(f"{name} is {shown(value)}; a text is needed.")
    return value


def whole(value: Any, name: str, low: int, high: int | None = None) -> int:
    """A whole number from ``low`` on, up to ``high`` where one is given."""
    good = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not good or value < low or (high is not None and value > high):
        limits = f"from {low} to {high}" if high is not None else f"of at least {low}"
        raise SceneError(f"{name} is {shown(value)}; it is a whole number {limits}.")
    return int(value)


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
    """Linear red, green and blue, from 0 to `BRIGHTEST`."""
    rgb = finite(value, name, 3)
    if np.any(rgb < 0):
        raise SceneError(f"{name} is {rgb.tolist()}; colors are not negative.")
    if np.any(rgb > BRIGHTEST):
        raise SceneError(f"{name} is {rgb.tolist()}; colors go to {BRIGHTEST:g}.")
    return rgb


def members(given: Any, name: str, kind: type[T]) -> tuple[T, ...]:
    """The members of a list, each of the class that it must be."""
    try:
        found = tuple(given)
    except TypeError:
        raise SceneError(f"{name} is {type(given).__name__}; a list is needed.") from None
    for i, member in enumerate(found):
        if not isinstance(member, kind):
            raise SceneError(f"{name}[{i}] is {type(member).__name__}, which is no {kind.__name__}.")
    return found


def unit(value: Any, name: str) -> Array:
    """A direction of length 1."""
    v = finite(value, name, 3)
    largest = float(np.max(np.abs(v)))
    if largest < TINY:
        raise SceneError(f"{name} is {v.tolist()}; a direction is not zero.")
    v = v / largest
    v = v / np.sqrt(v @ v)
    v.setflags(write=False)
    return v


# -- objects of the algebra ----------------------------------------------------------------------------


def coefficients(value: Any, kind: str) -> Array | None:
    """Coefficients of an object of this kind, or None if the value is no such object."""
    values = getattr(value, "values", value)
    if isinstance(value, Mapping) or callable(values) or _other_kind(value, kind):
        return None
    array = reals(values)
    return array.astype(np.float64) if array is not None and array.shape == (cga3d().kind(kind).size,) else None


def _other_kind(value: Any, kind: str) -> str:
    """The kind of an object that is known to be of another one; empty for sums and whatever has no kind."""
    own = getattr(value, "kind", None)
    name = getattr(own, "name", None)
    bound = bool(getattr(own, "constraints", None))
    return name if bound and isinstance(name, str) and name != kind else ""


#: Sign of X^2 for real objects.
_SQUARE = {"plane": -1.0, "sphere": -1.0, "circle": 1.0, "point_pair": 1.0}


def _unit_object(values: Array, kind: str) -> Multivector:
    """The object of these coefficients, scaled to X^2 = +1 or -1."""
    x = from_values(cga3d(), NumericRing(), cga3d().kind(kind).blades, list(finite(values, f"the {kind}")))
    square = _SQUARE[kind] * float((x * x).scalar())
    if not square > TINY:
        raise SceneError(f"the {kind} is imaginary, or of norm zero.")
    return x / _number(np.sqrt(square))


def _number(value: float) -> Multivector:
    return from_values(cga3d(), NumericRing(), (0,), [value])


def _read(result: Result, what: str) -> Array:
    """A parameter that a formula read: a vector or a number."""
    x = result.value
    names = ("e1", "e2", "e3") if 1 in x.grades else ("1",)
    array = np.array([x[name].scalar() for name in names], np.float64)
    if not np.all(np.isfinite(array)):
        raise SceneError(what)
    return array


def read_plane(values: Array) -> tuple[Array, float]:
    """Unit normal and offset of a plane."""
    normal, offset = conformal.plane_parameters(_unit_object(values, "plane"))
    return unit(_read(normal, "the plane has no normal."), "normal"), float(_read(offset, "")[0])


def read_sphere(values: Array) -> tuple[Array, float]:
    """Centre and radius of a sphere of either orientation."""
    center, radius, *_ = conformal.sphere_parameters(_unit_object(values, "sphere"))
    fault = "the sphere is a plane."
    return _read(center, fault), float(_read(radius, fault)[0])


def read_circle(values: Array) -> Circle:
    """Centre, normal and radius of a circle."""
    center, normal, radius, _ = conformal.circle_parameters(_unit_object(values, "circle"))
    fault = "the circle is a line."
    return Circle(_read(center, fault), unit(_read(normal, fault), "normal"), float(_read(radius, fault)[0]))


def read_point_pair(values: Array) -> PointPair:
    """End points of a point pair."""
    a, b, _ = conformal.point_pair_parameters(_unit_object(values, "point_pair"))
    fault = "the point pair is a flat point."
    return PointPair(_read(a, fault), _read(b, fault))


def circle(value: Any, name: str) -> Circle:
    """A circle from (center, normal, radius), a mapping of these, or its coefficients."""
    array = coefficients(value, "circle")
    if array is not None:
        return Circle(*_named(name, read_circle, array))
    center, normal, radius = _fields(value, name, "circle")
    return Circle(
        _position(center, f"{name}.center"), unit(normal, f"{name}.normal"), _length(radius, f"{name}.radius")
    )


def point_pair(value: Any, name: str) -> PointPair:
    """A point pair from (a, b), a mapping of these, or its coefficients."""
    array = coefficients(value, "point_pair")
    if array is not None:
        return PointPair(*_named(name, read_point_pair, array))
    a, b = (_position(x, f"{name}.{key}") for x, key in zip(_fields(value, name, "point_pair"), "ab", strict=True))
    if (a == b).all():
        raise SceneError(f"{name}.b is {b.tolist()}, which is its a too; a point pair has two end points.")
    return PointPair(a, b)


def _fields(value: Any, name: str, kind: str) -> list[Any]:
    """Parameters of an object from a tuple or a mapping."""
    fields, what = FIELDS[kind], kind.replace("_", " ")
    if isinstance(value, Mapping):
        missing = [key for key in fields if key not in value]
        if missing:
            raise SceneError(f"{name} has no {missing[0]}; a {what} has {', '.join(fields[:-1])} and {fields[-1]}.")
        others = [key for key in value if key not in fields]
        if others:
            near = suggest(str(others[0]), fields)
            raise SceneError(f"{name} has {shown(others[0])}{near}; a {what} has {', '.join(fields)}.")
        return [value[key] for key in fields]
    if not isinstance(value, list | tuple | np.ndarray) or len(value) != len(fields):
        other, shape = _other_kind(value, kind).replace("_", " "), getattr(value, "shape", ())
        fault = f"is a {other}, no {what}" if other else f"is no {what}"
        if not other and hasattr(value, "kind") and shape:
            fault = f"is a batch of shape {shape}; it is one {what}"
        raise SceneError(f"{name} {fault}; give ({', '.join(fields)}) or its coefficients.")
    return list(value)


def _position(value: Any, name: str) -> Array:
    position = finite(value, name, 3)
    if np.abs(position).max() > LARGEST:
        raise SceneError(f"{name} is {position.tolist()}; coordinates go to {LARGEST:g}.")
    return position


def _length(value: Any, name: str) -> float:
    length = positive(value, name)
    if length > LARGEST:
        raise SceneError(f"{name} is {length:g}; lengths go to {LARGEST:g}.")
    return length


def _named(name: str, read: Any, array: Array) -> Any:
    """What a reader of coefficients says, with the name of the object."""
    try:
        return read(array)
    except SceneError as error:
        raise SceneError(f"{name}: {error.what}") from None
