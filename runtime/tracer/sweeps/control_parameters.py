"""Parameters of the control objects of evolved surfaces, from any accepted input; errors name the control.

Far from the origin parameters keep more digits than coefficients.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Multivector
from ...dispatch.coefficients import embed
from ...dispatch.formulas import ResolvedKernel, resolve_kernel
from ...errors import BladesmithError, SceneError
from ...objects import arguments
from ..scene import object_parameters, values

Array = NDArray[np.float64]
#: Columns of positions in the rows of parameters: center, normal, radius of a circle; a, b of a point pair.
_POSITIONS = {"circle": (slice(0, 3),), "point_pair": (slice(0, 3), slice(3, 6))}
#: Columns of lengths.
_LENGTHS = {"circle": (6,), "point_pair": ()}
#: Number of columns.
_SIZES = {"circle": 7, "point_pair": 6}
#: Expected input, for messages.
_EXPECTED = {"circle": "circles as (center, normal, radius)", "point_pair": "point pairs as (a, b)"}
#: Formula that constructs an object, and the grades of its arguments (3: a vector, 0: a number).
_FORMULAS = {"circle": ("conformal.circle", (3, 3, 0)), "point_pair": ("pairs.pair_about", (3, 3))}
#: Formula that reads the parameters of an object.
_READING = {"circle": "conformal.circle_parameters", "point_pair": "pairs.pair_middle_half"}


@dataclass(frozen=True, eq=False)
class ControlParameters:
    """Circles or point pairs by their parameters.

    Attributes
    ----------
    kind : {"circle", "point_pair"}
    rows : (n, 7) or (n, 6)
        Center, normal and radius of circles; end points a and b of point pairs.
    halves : (n, 3)
        Half of b - a of point pairs: for a short pair it has digits that the difference of its ends lacks.
    """

    kind: str
    rows: Array
    halves: Array | None = None

    def __len__(self) -> int:
        return len(self.rows)

    def box(self) -> tuple[Array, Array, Array]:
        """Lowest and highest position and radius of each control, (n, 3), (n, 3) and (n,)."""
        positions = [self.rows[:, at] for at in _POSITIONS[self.kind]]
        radius = self.rows[:, 6] if self.kind == "circle" else np.zeros(len(self))
        if len(positions) == 1:
            return positions[0], positions[0], radius
        return np.minimum(*positions), np.maximum(*positions), radius

    def take(self, members: NDArray[np.intp]) -> ControlParameters:
        """Select controls by index, in the given order."""
        return ControlParameters(self.kind, self.rows[members], None if self.halves is None else self.halves[members])

    def coefficients(self, center: Array, size: Array) -> Array:
        """Coefficients (n, 10) in frames: positions less ``center`` (n, 3) or (3,), over ``size`` (n,) or ()."""
        rows = self.rows.copy()
        unit = np.asarray(size)[..., None]
        for at in _POSITIONS[self.kind]:
            rows[:, at] = (rows[:, at] - center) / unit
        for column in _LENGTHS[self.kind]:
            rows[:, column] /= size
        if self.kind == "point_pair":
            halves = (self.rows[:, 3:] - self.rows[:, :3]) / 2 if self.halves is None else self.halves
            rows = np.concatenate([(rows[:, :3] + rows[:, 3:]) / 2, halves / unit], axis=1)
        return object_coefficients(self.kind, rows)


@cache
def _target(name: str, keys: tuple[Any, ...]) -> ResolvedKernel:
    from ...core.registry import stock_algebra

    cga = stock_algebra("cga3d")
    sorts: dict[int, Any] = {3: cga.layout("euclidean"), 0: 0}
    return resolve_kernel(cga, name, tuple(sorts[k] if isinstance(k, int) else cga.kind(k) for k in keys))


def object_coefficients(kind: str, rows: Array) -> Array:
    """Coefficients (n, 10) of objects from rows of parameters: midpoint and half of point pairs."""
    formula, keys = _FORMULAS[kind]
    parts = [rows[:, 3 * i : 3 * i + 3] if key else rows[:, 3 * i] for i, key in enumerate(keys)]
    coefficients, _ = _target(formula, keys).run(*(np.ascontiguousarray(part) for part in parts))
    return np.asarray(coefficients)


def is_opposite(kind: str, first: Array, second: Array) -> NDArray[np.bool_]:
    """Test which unit objects (n, 10) of one frame oppose each other: <first second>_0 < 0 by more than rounding."""
    return np.asarray(_target("interpolation.orientation", (kind, kind)).run(first, second))[..., 0] < 0


def read_controls(source: Any, kind: str) -> ControlParameters:
    """Read the parameters of a sequence of control objects.

    Parameters
    ----------
    source : Multivector (n,), array (n, 10), or sequence
        Entries are objects of the algebra, their coefficients, parameters in a tuple, or mappings of parameters.

    Raises
    ------
    SceneError
        With the name of the control, from controls[0].
    """
    if _are_objects(source):
        controls = _from_objects(source, kind)
        return ControlParameters(kind, _read_each(source, kind)) if controls is None else controls
    return from_numbers(source, kind) or ControlParameters(kind, _read_each(source, kind))


def _are_objects(source: Any) -> bool:
    if isinstance(source, Multivector):
        return True
    return isinstance(source, (list, tuple)) and bool(source) and all(isinstance(x, Multivector) for x in source)


def _from_objects(source: Any, kind: str) -> ControlParameters | None:
    """Read valid unit objects together; None for others, which are read one by one."""
    try:
        objects = arguments.as_objects(source, "controls")
    except BladesmithError:
        return None
    if objects.ndim != 1 or objects.kind != objects.algebra.kinds.get(kind):
        return None
    if objects._status is not None and objects._status.any():
        return None
    controls = _read(objects._data.astype(np.float64), kind)
    return controls if np.isfinite(controls.rows).all() else None


def parameters_of(sums: Multivector, kind: str) -> ControlParameters | None:
    """Parameters of the real objects among projected sums; None if all are imaginary."""
    layout = sums.algebra.kind(kind)
    controls = _read(np.ascontiguousarray(embed(sums, layout), np.float64), kind)
    controls = controls.take(np.flatnonzero(np.isfinite(controls.rows).all(axis=1)))
    return controls if len(controls) else None


def _read(coefficients: Array, kind: str) -> ControlParameters:
    """Read parameters of unit objects; rows of NaN for imaginary ones."""
    with np.errstate(all="ignore"):
        *parts, status = _target(_READING[kind], (kind,)).run(coefficients)
        halves = None
        if kind == "point_pair":
            middle, halves = parts
            parts = [middle - halves, middle + halves]
    rows = np.concatenate(parts, axis=1)
    rows[status != 0] = np.nan
    return ControlParameters(kind, rows, halves)


def from_numbers(source: Any, kind: str) -> ControlParameters | None:
    """Read tuples and mappings of valid numbers together; None for anything else, which is read one by one."""
    names = object_parameters.FIELDS[kind]
    if not _is_row(source):
        return None
    try:
        entries = [_fields(x, names) if isinstance(x, Mapping) else x for x in source]
        if not all(map(_has_rows, entries)):
            return None
        if kind == "circle":
            rows = np.array([(*center, *normal, radius) for center, normal, radius in entries])
        else:
            rows = np.array([(*a, *b) for a, b in entries])
    except (TypeError, ValueError, KeyError, IndexError, BladesmithError):
        return None
    if rows.dtype.kind not in "iuf" or rows.ndim != 2 or rows.shape[1] != _SIZES[kind]:
        return None
    rows = rows.astype(np.float64, copy=False)
    return ControlParameters(kind, rows) if _are_good(kind, rows) else None


def _fields(x: Mapping[str, Any], names: tuple[str, ...]) -> list[Any]:
    """Parameters of an object from a mapping; empty where it has other keys too, which is reported later."""
    return [x[name] for name in names] if len(x) == len(names) else []


def _is_row(x: Any) -> bool:
    """Test for a list, a tuple, or a plain array of real numbers: not a set, a masked array or an array of objects."""
    return isinstance(x, list | tuple) or (type(x) is np.ndarray and x.dtype.kind in "iuf")


def _has_rows(entry: Any) -> bool:
    """Test for a sequence that begins with two vectors, and has no truth value for a radius."""
    if not _is_row(entry):
        return False
    first, second, *radius = entry
    return _is_row(first) and _is_row(second) and not any(isinstance(x, bool | np.bool_) for x in radius)


def _are_good(kind: str, rows: Array) -> bool:
    """Test whether the rows are parameters of objects, small enough not to overflow."""
    largest = np.abs(rows).max(initial=0.0)
    if not largest <= object_parameters.LARGEST:  # NaN fails too
        return False
    if kind == "point_pair":
        return bool((rows[:, :3] != rows[:, 3:]).any(axis=1).all())
    return bool((rows[:, 6] > 0).all() and (np.abs(rows[:, 3:6]).max(axis=1, initial=0.0) >= values.TINY).all())


def _read_each(source: Any, kind: str) -> Array:
    """Read controls one by one, to find and report the first invalid one."""
    if isinstance(source, (str, Mapping)) or not isinstance(source, (Sequence, np.ndarray, Multivector)):
        raise SceneError(f"curve is a {type(source).__name__}; give a curve, or {_EXPECTED[kind]}.")
    if isinstance(source, np.ndarray) and values.reals(source) is None:
        raise SceneError(
            f"curve is an array of {_describe_dtype(source)}; give a curve, or {_EXPECTED[kind]} in a list."
        )
    if getattr(source, "ndim", 1) == 0:
        raise SceneError(f"curve is one object; give a curve, or {_EXPECTED[kind]}.")
    read = object_parameters.circle_parameters if kind == "circle" else object_parameters.point_pair_parameters
    rows = [np.concatenate([np.ravel(part) for part in read(x, f"controls[{i}]")]) for i, x in enumerate(source)]
    return np.array(rows).reshape(-1, _SIZES[kind])


def _describe_dtype(array: np.ndarray[Any, Any]) -> str:
    """Describe the contents of an array that is not one of real numbers."""
    return "masked numbers" if isinstance(array, np.ma.MaskedArray) else f"type {array.dtype}"
