"""Control objects of a curve: checked, named by their number in errors, turned alike, and held in a frame of their own.

A control is an object of conformal geometry; for convenience also a circle by its parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Kind
from ..codegen.errors import AlgebraMismatchError, BladesmithError, GradeError, InputError, ShapeError
from ..common.dtypes import F64
from ..common.validation import as_bool, as_float, as_instance, check_shape, finite_array, invalid
from ..core.multivector import Multivector
from ..dispatch.coefficients import embed
from ..objects import arguments
from ..objects.interpolation import blending
from ..objects.rotors import local_origin
from ..status import Status
from .bernstein import Array

#: Keys of a difference of objects: the scale is 1 where it is left out.
DIFFERENCE = ("from", "to", "scale")
#: Parameters of the objects that may be given by them, in the order in which a plain tuple gives them.
PARAMETERS = {"circle": ("center", "normal", "radius"), "point_pair": ("a", "b")}


@dataclass(frozen=True, eq=False)
class Controls:
    """Controls as a curve uses them.

    Attributes
    ----------
    original
        What the user handed over.
    objects : Multivector (n,)
        Of reversed orientation where ``flipped`` says so.
    flipped : array (n,) of bool
    frame : Frame or None
        Where rows are computed: about a local origin, or in the world.
    rows : (n, k)
        Coefficients in that frame, in double precision.
    """

    original: Multivector | Sequence[Any]
    objects: Multivector
    flipped: NDArray[np.bool_]
    frame: local_origin.Frame | None
    rows: Array

    def __len__(self) -> int:
        return len(self.objects)

    @property
    def kind(self) -> Kind:
        """Kind of the objects; the layout, where they are any sums."""
        return self.objects.kind

    def with_signs(self, signs: Array) -> Controls:
        """These times signs (n,)."""
        objects = _negate(self.objects, signs)
        return Controls(self.original, objects, self.flipped ^ (signs < 0), self.frame, self.rows * signs[:, None])


def as_controls(controls: Any, align: bool = False, raw: bool = False, tangents: Sequence[Any] = ()) -> Controls:
    """Controls from a batch (n,), or a list of objects of one grade.

    Objects of a kind that does not hold the ``tangents`` are taken for ones of the next that does: lines for circles.

    Raises
    ------
    InputError, GradeError, ShapeError
        Naming the control.
    """
    align, raw = as_bool(align, "align"), as_bool(raw, "raw")
    found = _read_controls(controls, raw)
    if len(found) < 2:
        raise InputError(f"a curve needs at least 2 controls, not {len(found)}.")
    if not raw:
        _refuse_invalid(found)
    if tangents:
        found = found.as_kind(_widest([found, *tangents], "tangents"))
    objects = found.astype(F64)
    frame = None if raw else local_origin.frame(objects, shared=True)
    inner = objects if frame is None else frame.to_local(objects)
    result = Controls(controls, found, np.zeros(len(objects), bool), frame, rows_of(inner, objects.kind))
    flipped = _flips(inner) if align else result.flipped
    return result.with_signs(np.where(flipped, -1.0, 1.0)) if flipped.any() else result


def rows_of(x: Multivector, kind: Kind) -> Array:
    """Coefficients on the blades of a kind, in double precision."""
    return np.asarray(embed(x, kind), np.float64)


def _flips(x: Multivector) -> NDArray[np.bool_]:
    """Mask of the objects of a row to negate so that each agrees with the one before it; points have no orientation."""
    against = blending.align(x[1:], x[:-1])[1]
    return np.concatenate([[False], np.cumsum(against) % 2 == 1])


def _negate(x: Multivector, signs: NDArray[Any]) -> Multivector:
    """Reverse the orientation of unit objects; they stay unit objects of their kind."""
    return Multivector._make(x._type, x._data * signs.astype(x.dtype)[:, None], x.shape)


def _read_controls(controls: Any, raw: bool) -> Multivector:
    if not isinstance(controls, Multivector):
        if isinstance(controls, (str, Mapping)) or not (
            isinstance(controls, Sequence) or isinstance(controls, np.ndarray) and controls.ndim
        ):
            raise invalid(controls, "controls", "a list of objects, or a batch of them,")
        circles = _circles(controls)
        if circles is not None:
            return circles
        entries = [_entry(x, f"controls[{i}]") for i, x in enumerate(controls)]
        if not entries:
            raise InputError("a curve needs at least 2 controls, not 0.")
        for i, x in enumerate(entries):
            _same_sort(entries[0], x, f"controls[{i}]")
        return concatenate(entries, "controls") if raw else arguments.concatenate_objects(entries, "controls")
    check_shape(controls, "controls", ("n",))
    return concatenate([controls], "controls") if raw else arguments.as_objects(controls, "controls")


def _circles(controls: Any) -> Multivector | None:
    """Tuples and mappings of good parameters of circles at once; None for anything else, looked at one by one."""
    if isinstance(controls, np.ndarray) or not all(isinstance(x, (tuple, list, Mapping)) for x in controls):
        return None
    try:
        entries = [[x[key] for key in PARAMETERS["circle"]] if isinstance(x, Mapping) else x for x in controls]
        rows = np.array([(*center, *normal, radius) for center, normal, radius in entries])
    except (TypeError, ValueError, KeyError, BladesmithError):
        return None
    if rows.dtype.kind not in "iuf" or rows.ndim != 2 or rows.shape[1] != 7:
        return None
    from ..core.registry import stock_algebra

    found: Multivector = stock_algebra("cga3d").circle(rows[:, :3], rows[:, 3:6], rows[:, 6])
    return None if found._status is not None and found._status.any() else found


def _entry(x: Any, name: str) -> Multivector:
    """One control: a multivector, or a circle or a point pair from parameters, or a circle from coefficients."""
    if isinstance(x, Multivector):
        return x
    from ..core.registry import stock_algebra

    cga = stock_algebra("cga3d")
    if isinstance(x, Mapping):
        kind = "point_pair" if "a" in x or "b" in x else "circle"
        missing = [key for key in PARAMETERS[kind] if key not in x]
        if missing:
            raise InputError(
                f"{name} has no {missing[0]}; {_kind_phrase(kind)} has {_enumerate_words(PARAMETERS[kind])}."
            )
        x = tuple(x[key] for key in PARAMETERS[kind])
    if isinstance(x, (tuple, list)):
        for kind, fields in PARAMETERS.items():
            if len(x) == len(fields):
                return _from_parameters(cga, kind, x, name)
    if isinstance(x, np.ndarray) and x.shape == (cga.kind("circle").size,):
        return cga.multivector(x, kind="circle")
    raise InputError(
        f"{name} is a {type(x).__name__}; controls are objects of cga3d, circles as (center, normal, radius), "
        "or point pairs as (a, b)."
    )


def _from_parameters(cga: Any, kind: str, x: Sequence[Any], name: str) -> Multivector:
    try:
        made: Multivector = getattr(cga, kind)(*x)
    except BladesmithError as error:
        raise InputError(f"{name} is not a {kind.replace('_', ' ')}: {error}") from None
    if made._status is not None and made._status.any():
        wanted = "its normal is zero, or its radius is not positive" if kind == "circle" else "its end points are one"
        raise InputError(f"{name} is not a {kind.replace('_', ' ')}: it is not finite, {wanted}.")
    return made


def _kind_phrase(kind: str) -> str:
    return f"a {kind.replace('_', ' ')}"


def _enumerate_words(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"


def difference(x: Any, name: str) -> Multivector:
    """A tangent: a multivector, or ``scale * (to - from)`` of two objects in a mapping.

    Raises
    ------
    InputError
    """
    if not isinstance(x, Mapping):
        return as_instance(x, name, Multivector, "a multivector, or a mapping with from, to and scale,")
    unknown = [key for key in x if key not in DIFFERENCE]
    missing = [key for key in DIFFERENCE[:2] if key not in x]
    if unknown or missing:
        fault = f"has no {missing[0]}" if missing else f"has a {unknown[0]!r}"
        raise InputError(f"{name} {fault}; a difference has {_enumerate_words(DIFFERENCE)}.")
    start, end = (_entry(x[key], f"{name}.{key}") for key in DIFFERENCE[:2])
    _same_sort(start, end, f"{name}.to")
    return (end - start) * as_float(x.get("scale", 1.0), f"{name}.scale")


def concatenate(parts: Sequence[Any], name: str) -> Multivector:
    """Any finite multivectors of one grade as one batch (n,) on the blades of the widest.

    Raises
    ------
    InputError, GradeError, AlgebraMismatchError
    """
    for i, x in enumerate(parts):
        as_instance(x, f"{name}[{i}]", Multivector, "a multivector")
        _same_sort(parts[0], x, f"{name}[{i}]")
        if not np.isfinite(x._data).all():
            raise InputError(f"{name}[{i}] is not finite.")
    wide = _widest(parts, name)
    data = np.concatenate([embed(x, wide).reshape(-1, wide.size) for x in parts])
    algebra = parts[0].algebra
    return Multivector._make(algebra.type_of(wide.layout, data.dtype), data, data.shape[:1])


def _widest(parts: Sequence[Multivector], name: str) -> Kind:
    """The kind of objects whose blades hold all parts."""
    kinds = (arguments.object_kind(x, name, tuple(arguments.OBJECTS)) for x in parts)
    return max(kinds, key=lambda k: k.size)


def _same_sort(first: Multivector, x: Multivector, name: str) -> None:
    """Raise, naming x, unless both are of one grade of one algebra."""
    try:
        arguments.same_sort(first, x)
    except (AlgebraMismatchError, GradeError) as error:
        raise type(error)(error.what, where=name) from None


def _refuse_invalid(x: Multivector) -> None:
    if x._status is None:
        return
    bad = (x._status != Status.OK) & (x._status != Status.NOT_UNIQUE)
    if bad.any():
        i = int(np.argmax(bad))
        raise InputError(
            f"controls[{i}] is {Status(int(x._status[i])).name}: no unit {x.kind.name.replace('_', ' ')}.",
            remedy="Normalise it with x.normalized(), or make it with a constructor",
        )


def scalars(value: Any, count: int, name: str) -> Array:
    """One finite number for each control: a number for all, or an array (n,).

    Raises
    ------
    InputError, ShapeError
    """
    array = finite_array(value, name)
    if array.shape not in ((), (count,)):
        raise ShapeError(f"{name} has shape {array.shape}; give one number, or one for each of the {count} controls.")
    return np.array(np.broadcast_to(array, (count,)))


__all__ = ["Controls", "as_controls", "difference", "concatenate", "rows_of", "scalars"]
