"""What sums of objects are made of: operands on common blades, orientation, weights, sums over an axis, results."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import arrays
from ..arrays import truth
from ..calls import Outcome, call, finite, merged, raise_first
from ..codegen.errors import InputError, ShapeError
from ..codegen.kinds import Kind
from ..multivector import Multivector
from ..rows import embedded
from ..status import Status
from . import local
from .inputs import same_sort

#: Weights whose sum is smaller than this many rounding units of the sum of their sizes sum to zero.
ZERO_SUM_ULPS = 64
#: So many items are added one after the other.
BLOCK = 64


def free(x: Multivector, kind: Kind) -> Multivector:
    """x on the blades of a kind, with nothing known: what projection repairs must not be taken for granted."""
    return x._make(x.algebra.type_of(kind.layout, x.dtype), embedded(x, kind), x.shape)


def alike(a: Multivector, b: Multivector) -> tuple[Multivector, Multivector]:
    """Both on the blades of the wider of their kinds, as layouts."""
    wide = max(a.kind, b.kind, key=lambda kind: kind.size)
    return free(a, wide), free(b, wide)


def opposed(a: Multivector, b: Multivector) -> NDArray[np.bool_]:
    """Where b is opposed to a."""
    same_sort(a, b)
    return np.asarray(call(a.algebra, "interpolation.orientation", *alike(a, b)).value._data[..., 0] < 0)


def turned(x: Multivector, where: NDArray[np.bool_]) -> Multivector:
    """-x where the mask holds."""
    data = x._data * np.where(where, x.dtype.type(-1), x.dtype.type(1))[..., None]
    status = None if x._status is None else np.array(np.broadcast_to(x._status, data.shape[:-1]))
    return x._make(x._type, data, data.shape[:-1], status)


def checked_axis(x: Multivector, axis: int) -> int:
    if not x.ndim:
        raise InputError("a single object has no axis to average over; hand over a batch, or a list.")
    if not -x.ndim <= axis < x.ndim:
        raise InputError(f"axis {axis} does not exist in a batch of shape {x.shape}.")
    place = axis % x.ndim
    if not x.shape[place]:
        raise InputError(f"there are no objects along axis {axis} of a batch of shape {x.shape}.")
    return place


def shares(weights: Any, lead: tuple[int, ...], place: int) -> NDArray[Any] | None:
    """Weights over their sums, in a shape that broadcasts with the batch; None: all are alike."""
    if weights is None:
        return None
    w = arrays.real(weights, "weights")
    if w.shape != lead:
        if w.shape != (lead[place],):
            wanted = " or ".join(dict.fromkeys(str(shape) for shape in ((lead[place],), lead)))
            raise ShapeError(f"weights have shape {w.shape}; it must be {wanted}.")
        w = w.reshape([-1 if i == place else 1 for i in range(len(lead))])
    if not np.isfinite(w).all():
        raise InputError(f"weight {_place(~np.isfinite(w))} is not finite.")
    total, size = w.sum(place, keepdims=True), np.abs(w).sum(place, keepdims=True)
    nothing = np.abs(total) <= ZERO_SUM_ULPS * float(np.finfo(w.dtype).eps) * size
    if nothing.any():
        raise InputError("the weights sum to zero.", remedy="A mean needs a total weight")
    return np.asarray(w / total)


def _place(bad: NDArray[np.bool_]) -> Any:
    place = tuple(int(i) for i in np.argwhere(bad)[0])
    return place[0] if len(place) == 1 else place


def first_along(x: Multivector, place: int) -> Multivector:
    """The first along an axis, which stays with length one."""
    return x[(slice(None),) * place + (slice(0, 1),)]  # type: ignore[no-any-return]


def summed(data: NDArray[Any], place: int) -> NDArray[Any]:
    """Sum over an axis, block by block: the rounding error does not grow with the number of items."""
    while data.shape[place] > BLOCK:
        data = np.add.reduceat(data, np.arange(0, data.shape[place], BLOCK), place)
    return np.asarray(data.sum(place))


def finished(
    outcome: Outcome, operands: tuple[Multivector, ...], name: str, strict: bool, frame: local.Frame | None = None
) -> Multivector:
    """A formula's result, seen from the world's origin: NaN where there is nothing; operands' reasons come first."""
    refuses = truth(strict, "strict")
    value: Multivector = outcome.value if frame is None else frame.outward(outcome.value)
    if frame is None and outcome.status is not None and not outcome.status.any():
        return value  # the formulas of sums give whatever is not finite a status
    known = [_reasons(x, value.shape) for x in operands]
    result = finite(value._make(value._type, value._data, value.shape, merged(*known, outcome.status)))
    if refuses:
        raise_first(result._status, name)
    return result


def _reasons(x: Multivector, lead: tuple[int, ...]) -> NDArray[np.uint8] | None:
    """Why an operand has no value; its choices were its own business."""
    if x._status is None or not x._status.any():
        return None
    codes = np.where(x._status == Status.NOT_UNIQUE, np.uint8(Status.OK), x._status)
    return np.broadcast_to(codes, lead)
