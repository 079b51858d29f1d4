"""Control objects of evolved surfaces as plain parameters, however they were given; errors name the control.

Parameters keep their digits far from the origin, where coefficients do not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..calls import Target, target
from ..errors import BladesmithError, SceneError
from ..multivector import Multivector
from ..objects import inputs
from ..rows import embedded
from . import values

Array = NDArray[np.float64]
#: Positions (as triples of columns) and lengths (as columns) in the rows of parameters of a kind, and what messages
#: say: circles are center, normal, radius; point pairs a, b.
_POSITIONS = {"circle": (slice(0, 3),), "point_pair": (slice(0, 3), slice(3, 6))}
_LENGTHS = {"circle": (6,), "point_pair": ()}
_SIZES = {"circle": 7, "point_pair": 6}
_WANTED = {"circle": "circles as (center, normal, radius)", "point_pair": "point pairs as (a, b)"}
_FORMULAS = {"circle": ("conformal.circle", (3, 3, 0)), "point_pair": ("pairs.pair_about", (3, 3))}
_READING = {"circle": "conformal.circle_parameters", "point_pair": "pairs.pair_middle_half"}


@dataclass(frozen=True, eq=False)
class Controls:
    """Circles or point pairs by their parameters.

    Attributes
    ----------
    kind : {"circle", "point_pair"}
    rows : (n, 7) or (n, 6)
        Center, normal and radius; or end points a and b.
    halves : (n, 3)
        Of point pairs, half of b - a: of a short pair it has digits that its ends have not.
    """

    kind: str
    rows: Array
    halves: Array | None = None

    def __len__(self) -> int:
        return len(self.rows)

    def box(self) -> tuple[Array, Array, Array]:
        """Lowest and highest position, and largest radius of each, (n, 3), (n, 3) and (n,)."""
        positions = [self.rows[:, at] for at in _POSITIONS[self.kind]]
        radius = self.rows[:, 6] if self.kind == "circle" else np.zeros(len(self))
        if len(positions) == 1:
            return positions[0], positions[0], radius
        return np.minimum(*positions), np.maximum(*positions), radius

    def taken(self, members: NDArray[np.intp]) -> Controls:
        """Some of them, in the order given."""
        return Controls(self.kind, self.rows[members], None if self.halves is None else self.halves[members])

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
        return made(self.kind, rows)


@cache
def _target(name: str, keys: tuple[Any, ...]) -> Target:
    from ..loading import stock_algebra

    cga = stock_algebra("cga3d")
    sorts: dict[int, Any] = {3: cga.layout("euclidean"), 0: 0}
    return target(cga, name, tuple(sorts[k] if isinstance(k, int) else cga.kind(k) for k in keys))


def made(kind: str, rows: Array) -> Array:
    """Coefficients (n, 10) of objects by rows of parameters: of point pairs middle and half."""
    formula, keys = _FORMULAS[kind]
    parts = [rows[:, 3 * i : 3 * i + 3] if key else rows[:, 3 * i] for i, key in enumerate(keys)]
    made_, _ = _target(formula, keys).run(*(np.ascontiguousarray(part) for part in parts))
    return np.asarray(made_)


def opposed(kind: str, first: Array, second: Array) -> NDArray[np.bool_]:
    """Where unit objects (n, 10) of one frame oppose each other: <first second>_0 < 0 by more than rounding."""
    return np.asarray(_target("interpolation.orientation", (kind, kind)).run(first, second))[..., 0] < 0


def read_controls(given: Any, kind: str) -> Controls:
    """Parameters of a row of control objects.

    Parameters
    ----------
    given : Multivector (n,), array (n, 10), or sequence
        Entries are objects of the algebra, their coefficients, parameters in a tuple, or mappings of parameters.

    Raises
    ------
    SceneError
        Naming the control, from controls[0].
    """
    if _are_objects(given):
        found = _from_objects(given, kind)
        return Controls(kind, _one_by_one(given, kind)) if found is None else found
    return from_numbers(given, kind) or Controls(kind, _one_by_one(given, kind))


def _are_objects(given: Any) -> bool:
    if isinstance(given, Multivector):
        return True
    return isinstance(given, (list, tuple)) and bool(given) and all(isinstance(x, Multivector) for x in given)


def _from_objects(given: Any, kind: str) -> Controls | None:
    """Of unit objects that are what they should be; None for others, which are looked at one by one."""
    try:
        objects = inputs.as_objects(given, "controls")
    except BladesmithError:
        return None
    if objects.ndim != 1 or objects.kind != objects.algebra.kinds.get(kind):
        return None
    if objects._status is not None and objects._status.any():
        return None
    found = _read(objects._data.astype(np.float64), kind)
    return found if np.isfinite(found.rows).all() else None


def parameters_of(sums: Multivector, kind: str) -> Controls | None:
    """Parameters of the real objects among projected sums; None if there is none."""
    layout = sums.algebra.kind(kind)
    found = _read(np.ascontiguousarray(embedded(sums, layout), np.float64), kind)
    found = found.taken(np.flatnonzero(np.isfinite(found.rows).all(axis=1)))
    return found if len(found) else None


def _read(coefficients: Array, kind: str) -> Controls:
    """Parameters of unit objects; rows of NaN where there are none."""
    with np.errstate(all="ignore"):
        *parts, status = _target(_READING[kind], (kind,)).run(coefficients)
        halves = None
        if kind == "point_pair":
            middle, halves = parts
            parts = [middle - halves, middle + halves]
    rows = np.concatenate(parts, axis=1)
    rows[status != 0] = np.nan
    return Controls(kind, rows, halves)


def from_numbers(given: Any, kind: str) -> Controls | None:
    """Of tuples and mappings of good numbers; None for anything else, which is looked at one by one."""
    names = values.FIELDS[kind]
    if not _is_row(given):
        return None
    try:
        entries = [_fields(x, names) if isinstance(x, Mapping) else x for x in given]
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
    return Controls(kind, rows) if _are_good(kind, rows) else None


def _fields(x: Mapping[str, Any], names: tuple[str, ...]) -> list[Any]:
    """Parameters of an object from a mapping of these; none where it has others too, which is told later."""
    return [x[name] for name in names] if len(x) == len(names) else []


def _is_row(x: Any) -> bool:
    """Whether it has an order, and numbers if it is an array: no set, nothing masked, no array of objects."""
    return isinstance(x, list | tuple) or (type(x) is np.ndarray and x.dtype.kind in "iuf")


def _has_rows(entry: Any) -> bool:
    """Whether it has an order, two positions or directions first, and no truth value for a radius."""
    if not _is_row(entry):
        return False
    first, second, *radius = entry
    return _is_row(first) and _is_row(second) and not any(isinstance(x, bool | np.bool_) for x in radius)


def _are_good(kind: str, rows: Array) -> bool:
    """Whether they stand for objects, in whose frames nothing overflows."""
    largest = np.abs(rows).max(initial=0.0)
    if not largest <= values.LARGEST:  # NaN fails too
        return False
    if kind == "point_pair":
        return bool((rows[:, :3] != rows[:, 3:]).any(axis=1).all())
    return bool((rows[:, 6] > 0).all() and (np.abs(rows[:, 3:6]).max(axis=1, initial=0.0) >= values.TINY).all())


def _one_by_one(given: Any, kind: str) -> Array:
    """The way that finds what is wrong, and says it."""
    if isinstance(given, (str, Mapping)) or not isinstance(given, (Sequence, np.ndarray, Multivector)):
        raise SceneError(f"curve is a {type(given).__name__}; give a curve, or {_WANTED[kind]}.")
    if isinstance(given, np.ndarray) and values.reals(given) is None:
        raise SceneError(f"curve is an array of {_held(given)}; give a curve, or {_WANTED[kind]} in a list.")
    if getattr(given, "ndim", 1) == 0:
        raise SceneError(f"curve is one object; give a curve, or {_WANTED[kind]}.")
    read = values.circle if kind == "circle" else values.point_pair
    rows = [np.concatenate([np.ravel(part) for part in read(x, f"controls[{i}]")]) for i, x in enumerate(given)]
    return np.array(rows).reshape(-1, _SIZES[kind])


def _held(array: np.ndarray[Any, Any]) -> str:
    """What an array holds that is no array of real numbers."""
    return "masked numbers" if isinstance(array, np.ma.MaskedArray) else f"type {array.dtype}"
