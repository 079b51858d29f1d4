"""Parameters of objects of the algebra that users give by parameters or by coefficients.

Coefficients come as an array, or in anything with ``.values``; far from the origin parameters keep more digits. Errors
are `SceneError`s with the name of the object.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.validation import short_repr
from ...core.registry import stock_algebra
from ...errors import SceneError, suggest
from ...status import Status
from . import values

Array = NDArray[np.float64]
#: Largest parameter: squares and products of larger ones would overflow.
LARGEST = 1e90
#: Objects whose parameters are not finite, by the kind whose blades they have.
FLAT = {"plane": "without a normal", "sphere": "a plane", "circle": "a line", "point_pair": "a flat point"}
#: Names of the parameters of controls, by kind.
FIELDS = {"circle": ("center", "normal", "radius"), "point_pair": ("a", "b")}


class Circle(NamedTuple):
    """A circle, oriented counter-clockwise about its normal."""

    center: Array
    normal: Array
    radius: float


class PointPair(NamedTuple):
    """A point pair, oriented from a to b."""

    a: Array
    b: Array


def coefficients(value: Any, kind: str) -> Array | None:
    """Coefficients of an object of this kind, or None if the value is not such an object."""
    raw = getattr(value, "values", value)
    if isinstance(value, Mapping) or callable(raw) or _contradicting_kind(value, kind):
        return None
    array, shape = values.reals(raw), (stock_algebra("cga3d").kind(kind).size,)
    return array.astype(np.float64) if array is not None and array.shape == shape else None


def _contradicting_kind(value: Any, kind: str) -> str:
    """Kind of an object that certainly belongs to another kind; empty for sums and values without a kind."""
    actual = getattr(value, "kind", None)
    name = getattr(actual, "name", None)
    is_constrained = bool(getattr(actual, "constraints", None))
    return name if is_constrained and isinstance(name, str) and name != kind else ""


def read_object(array: Array, kind: str, prefix: str = "") -> Any:
    """Parameters of a real object, of any scale, from its coefficients; ``prefix`` begins the message of an error."""
    cga = stock_algebra("cga3d")
    what = f"{prefix}the {kind.replace('_', ' ')}"
    x = cga.wrap(cga.kind(kind).layout, values.finite(array, what))
    unit = x.normalized(kind)
    if unit.status != Status.OK:
        raise SceneError(f"{what} is imaginary, or of norm zero.")
    parameters = unit.parameters()
    if not all(np.isfinite(part).all() for part in parameters):
        raise SceneError(f"{what} is {FLAT[kind]}.")
    return parameters


def circle_parameters(value: Any, name: str) -> Circle:
    """Read a circle given by (center, normal, radius), a mapping of these, or its coefficients."""
    array = coefficients(value, "circle")
    if array is not None:
        center, normal, radius = read_object(array, "circle", f"{name}: ")
        return Circle(center, values.unit(normal, "normal"), float(radius))
    center, normal, radius = _fields(value, name, "circle")
    return Circle(
        _position(center, f"{name}.center"), values.unit(normal, f"{name}.normal"), _length(radius, f"{name}.radius")
    )


def point_pair_parameters(value: Any, name: str) -> PointPair:
    """Read a point pair given by (a, b), a mapping of these, or its coefficients."""
    array = coefficients(value, "point_pair")
    if array is not None:
        return PointPair(*read_object(array, "point_pair", f"{name}: "))
    a, b = (_position(x, f"{name}.{key}") for x, key in zip(_fields(value, name, "point_pair"), "ab", strict=True))
    if (a == b).all():
        raise SceneError(f"{name}.b is {b.tolist()}, equal to a; a point pair has two end points.")
    return PointPair(a, b)


def _fields(value: Any, name: str, kind: str) -> list[Any]:
    """Select the parameters of an object from a tuple or a mapping."""
    fields, what = FIELDS[kind], kind.replace("_", " ")
    if isinstance(value, Mapping):
        missing = [key for key in fields if key not in value]
        if missing:
            raise SceneError(f"{name} has no {missing[0]}; a {what} has {', '.join(fields[:-1])} and {fields[-1]}.")
        others = [key for key in value if key not in fields]
        if others:
            near = suggest(str(others[0]), fields)
            raise SceneError(f"{name} has {short_repr(others[0])}{near}; a {what} has {', '.join(fields)}.")
        return [value[key] for key in fields]
    if not isinstance(value, list | tuple | np.ndarray) or len(value) != len(fields):
        other, shape = _contradicting_kind(value, kind).replace("_", " "), getattr(value, "shape", ())
        fault = f"is a {other}, not a {what}" if other else f"is not a {what}"
        if not other and hasattr(value, "kind") and shape:
            fault = f"is a batch of shape {shape}; it is one {what}"
        raise SceneError(f"{name} {fault}; give ({', '.join(fields)}) or its coefficients.")
    return list(value)


def _position(value: Any, name: str) -> Array:
    position = values.finite(value, name, 3)
    if np.abs(position).max() > LARGEST:
        raise SceneError(f"{name} is {position.tolist()}; coordinates go to {LARGEST:g}.")
    return position


def _length(value: Any, name: str) -> float:
    length = values.positive(value, name)
    if length > LARGEST:
        raise SceneError(f"{name} is {length:g}; lengths go to {LARGEST:g}.")
    return length
