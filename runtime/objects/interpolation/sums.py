"""Parts of sums of objects: operands on common blades, orientation, weights, sums over an axis, results."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algebra.algebra import Kind
from ...codegen.errors import InputError, ShapeError
from ...common.validation import as_axis, check_items, real_array
from ...core.multivector import Multivector
from ...dispatch.coefficients import embed
from ...dispatch.formulas import FormulaResult, evaluate
from ...dispatch.item_statuses import invalidate_nonfinite, merge_statuses
from ...status import Status
from ..arguments import same_sort
from ..rotors import local_origin

#: Weights whose sum is smaller than this many rounding units of the sum of their sizes sum to zero.
ZERO_SUM_ULPS = 64
#: So many items are added one after the other.
BLOCK = 64


def to_layout(x: Multivector, kind: Kind) -> Multivector:
    """x on the blades of a kind, with nothing known: what projection repairs must not be taken for granted."""
    return x._make(x.algebra.type_of(kind.layout, x.dtype), embed(x, kind), x.shape)


def to_common_layout(a: Multivector, b: Multivector) -> tuple[Multivector, Multivector]:
    """Both on the blades of the wider of their kinds, as layouts."""
    wide = max(a.kind, b.kind, key=lambda kind: kind.size)
    return to_layout(a, wide), to_layout(b, wide)


def is_opposite(a: Multivector, b: Multivector) -> NDArray[np.bool_]:
    """Mask of the items of b whose orientation is opposite to a's."""
    same_sort(a, b)
    return np.asarray(evaluate(a.algebra, "interpolation.orientation", *to_common_layout(a, b)).value._data[..., 0] < 0)


def negate_where(x: Multivector, where: NDArray[np.bool_]) -> Multivector:
    """-x where the mask holds."""
    data = x._data * np.where(where, x.dtype.type(-1), x.dtype.type(1))[..., None]
    status = None if x._status is None else np.array(np.broadcast_to(x._status, data.shape[:-1]))
    return x._make(x._type, data, data.shape[:-1], status)


def checked_axis(x: Multivector, axis: int) -> int:
    if not x.ndim:
        raise InputError("a single object has no axis to average over; hand over a batch, or a list.")
    index = as_axis(axis, x.shape, "the objects have")
    if not x.shape[index]:
        raise InputError(f"there are no objects along axis {axis} of a batch of shape {x.shape}.")
    return index


def normalized_weights(weights: Any, lead: tuple[int, ...], axis: int) -> NDArray[Any] | None:
    """Weights over their sums, in a shape that broadcasts with the batch; None: all are alike."""
    if weights is None:
        return None
    w = real_array(weights, "weights")
    if w.shape != lead:
        if w.shape != (lead[axis],):
            wanted = " or ".join(dict.fromkeys(str(shape) for shape in ((lead[axis],), lead)))
            raise ShapeError(f"weights have shape {w.shape}; it must be {wanted}.")
        w = w.reshape([-1 if i == axis else 1 for i in range(len(lead))])
    check_items(np.isfinite(w), w, "weights", "a finite number")
    total, size = w.sum(axis, keepdims=True), np.abs(w).sum(axis, keepdims=True)
    nothing = np.abs(total) <= ZERO_SUM_ULPS * float(np.finfo(w.dtype).eps) * size
    if nothing.any():
        raise InputError("the weights sum to zero.", remedy="A mean needs a total weight")
    return np.asarray(w / total)


def _first_index(bad: NDArray[np.bool_]) -> Any:
    index = tuple(int(i) for i in np.argwhere(bad)[0])
    return index[0] if len(index) == 1 else index


def first_along(x: Multivector, axis: int) -> Multivector:
    """The first along an axis, which stays with length one."""
    return x[(slice(None),) * axis + (slice(0, 1),)]  # type: ignore[no-any-return]


def block_sum(data: NDArray[Any], axis: int) -> NDArray[Any]:
    """Sum over an axis, block by block: the rounding error does not grow with the number of items."""
    while data.shape[axis] > BLOCK:
        data = np.add.reduceat(data, np.arange(0, data.shape[axis], BLOCK), axis)
    return np.asarray(data.sum(axis))


def assemble(
    outcome: FormulaResult, operands: tuple[Multivector, ...], frame: local_origin.Frame | None = None
) -> Multivector:
    """A formula's result in world coordinates: NaN without an answer; statuses of operands come first."""
    value: Multivector = outcome.value if frame is None else frame.to_world(outcome.value)
    if frame is None and outcome.status is not None and not outcome.status.any():
        return value  # the formulas of sums give whatever is not finite a status
    known = [_reasons(x, value.shape) for x in operands]
    return invalidate_nonfinite(
        value._make(value._type, value._data, value.shape, merge_statuses(*known, outcome.status))
    )


def _reasons(x: Multivector, lead: tuple[int, ...]) -> NDArray[np.uint8] | None:
    """Statuses of an operand's items without an answer; NOT_UNIQUE is dropped."""
    if x._status is None or not x._status.any():
        return None
    codes = np.where(x._status == Status.NOT_UNIQUE, np.uint8(Status.OK), x._status)
    return np.broadcast_to(codes, lead)
