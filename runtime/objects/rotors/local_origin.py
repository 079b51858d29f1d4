"""Local origins for objects far from the origin: what is computed there keeps the digits of the objects' own size.

Without one, products of coefficients of size c^2/r lose (c/r)^2 rounding units. A frame takes objects in, results out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Multivector
from ...dispatch.coefficients import embed
from ...dispatch.formulas import ArrayOperand, evaluate

M = TypeVar("M", Multivector, NDArray[Any])
#: Re-centring gains where a coefficient is larger: products of two coefficients of this size lose 5 digits of 16.
NEAR = 256.0
#: Lines at angles below this have no middle along them; any place will do.
SAME_DIRECTION = 1e-4
#: The middle of a batch is that of this many of its items.
SOME = 256


@dataclass(frozen=True)
class Frame:
    """Local origins, one for each item of a batch.

    Attributes
    ----------
    origin : array (..., 3)
        Positions; they broadcast with the items.
    translator : Multivector
        T, from the world's origin to these.
    """

    origin: NDArray[Any]
    translator: Multivector

    def to_local(self, x: Multivector) -> Multivector:
        """~T x T for objects: rebuilt from their accurate parameters, of the kind that they have."""
        return _with_kind_of(evaluate(x.algebra, "local.inward", x, self._origin()).value, x)

    def to_world(self, y: Multivector) -> Multivector:
        """T y ~T for objects, rotors, or anything else seen from the local origins; kinds and statuses are kept."""
        return _with_kind_of(self.translator >> y, y)

    def _origin(self) -> ArrayOperand:
        operand: ArrayOperand = self.translator.algebra.spatial(self.origin, "origin")
        return operand


def frame(*objects: Multivector, shared: bool = False, axis: int | None = None) -> Frame | None:
    """Local origins for batches of objects that are computed with together, or None where none are needed.

    Parameters
    ----------
    *objects : Multivector
        Objects as `inputs.as_objects` gives them, whose shapes broadcast. The origin of an item is the point of the
        first near the world's origin, then the point of the second near that, and so on: of a plane and a small
        sphere on it one near the sphere.
    shared : bool
        One origin for all items of a batch, in the middle of them, for sums of many.
    axis : int, optional
        With ``shared``: one for the items along this axis.
    """
    if not any(_largest(x) > NEAR for x in objects):
        return None
    algebra = objects[0].algebra
    if not shared:
        position = _nearest_points(objects, None)
        good = np.isfinite(position).all(-1, keepdims=True)
        position = np.where(good, position, position.dtype.type(0))
    else:
        position = _middle([_subsample(x, axis) for x in objects] if len(objects) == 1 else objects, axis)
    position = position.astype(np.result_type(*(x.dtype for x in objects)), copy=False)
    return Frame(position, algebra.translator(position))


def for_each(compute: Callable[[Frame | None], M], *objects: Multivector, axis: int | None = None) -> M:
    """Results about local origins of the items that are far from the origin, and without one of the others: items of a
    batch do not depend on each other.

    Parameters
    ----------
    compute
        What gives the results of all items about the origins of a frame, or about the world's.
    *objects : Multivector
        Objects whose shapes broadcast with the results'.
    axis : int, optional
        Results are of all items along this axis, about one origin.
    """
    origins = frame(*objects, shared=axis is not None, axis=axis)
    if origins is None:
        return compute(None)
    found = compute(origins)
    if any(_are_all_far(x) for x in objects):
        return found
    far: NDArray[np.bool_] = np.logical_or.reduce(np.broadcast_arrays(*(_is_far(x) for x in objects)))
    far = far if axis is None else np.asarray(far.any(axis))
    return found if far.all() else _chosen(far, found, compute(None))


def _are_all_far(x: Multivector) -> bool:
    """Whether one coefficient says so of all items: what tells most batches far away, at the cost of a column."""
    rows = x._data.reshape(-1, x._data.shape[-1])
    if not len(rows):
        return False
    column = np.abs(rows[:, np.abs(rows[0]).argmax()])
    return bool(((column > NEAR) & (column < np.inf)).all())


def _is_far(x: Multivector) -> NDArray[np.bool_]:
    size = np.abs(x._data)
    return np.asarray(((size > NEAR) & (size < np.inf)).any(-1))


def _chosen(far: NDArray[np.bool_], found: M, other: M) -> M:
    if not isinstance(found, Multivector) or not isinstance(other, Multivector):
        return np.where(far, found, other)
    kind = found._type if found._type is other._type else found.algebra.type_of(found.kind.layout, found.dtype)
    data = [embed(x, kind.kind) for x in (found, other)]
    status = None
    if found._status is not None or other._status is not None:
        codes = (np.zeros(x.shape, np.uint8) if x._status is None else x._status for x in (found, other))
        status = np.where(far, *codes).astype(np.uint8)
    return found._make(kind, np.where(far[..., None], *data), found.shape, status)


def _nearest_points(objects: Sequence[Multivector], start: NDArray[Any] | None) -> NDArray[Any]:
    """Nearest points in turn: of the first object to a start (None: the world's origin), of the second to that, ..."""
    algebra = objects[0].algebra
    position = start
    for x in objects:
        if position is None:
            outcome = evaluate(algebra, "local.anchor", x)
        else:
            outcome = evaluate(algebra, "local.nearest", x, algebra.spatial(position, "origin"))
        position = outcome.value._data
    assert position is not None
    return position


def _middle(objects: Sequence[Multivector], axis: int | None) -> NDArray[Any]:
    """The place p that is the mean of what is reached from p: in the middle of far flats that pass near each other.

    Of flats what is reached is an affine function of the start, so one step solves for p; of small rounds it is a
    constant. The mean of what is reached from the world's origin serves where that step does not lead nearer.
    """

    def mean(start: NDArray[Any] | None) -> NDArray[Any]:
        position = _nearest_points(objects, start)
        over = tuple(range(position.ndim - 1)) if axis is None else axis % (position.ndim - 1)
        good = np.isfinite(position).all(-1, keepdims=True)
        total = np.sum(np.where(good, position, 0), over, keepdims=axis is not None)
        return np.asarray(total / np.maximum(np.sum(good, over, keepdims=axis is not None), 1))

    start = mean(None)
    step = np.maximum(np.linalg.norm(start, axis=-1, keepdims=True), 1)
    reached = mean(start)
    slope = np.stack([(mean(start + step * e) - reached) / step for e in np.eye(start.shape[-1])], -1)
    slope = np.where(np.isfinite(slope), slope, 0)
    inverse = np.linalg.pinv(np.eye(start.shape[-1]) - slope, rcond=SAME_DIRECTION)
    place = start + (inverse @ (reached - start)[..., None])[..., 0]
    nearer = np.linalg.norm(mean(place) - place, axis=-1) < np.linalg.norm(reached - start, axis=-1)
    return np.where(nearer[..., None], place, start)


def _subsample(x: Multivector, axis: int | None) -> Multivector:
    """At most `SOME` items along the axis (of all): their middle is as good."""
    if axis is None:
        x, axis = x.reshape(-1), 0
    axis %= x.ndim
    step = -(-x.shape[axis] // SOME)
    return x[(slice(None),) * axis + (slice(None, None, step),)] if step > 1 else x


def _largest(x: Multivector) -> float:
    """Largest finite coefficient."""
    largest = x._largest_coefficient()
    return largest if math.isfinite(largest) else float(np.max(np.abs(x._data), initial=0, where=np.isfinite(x._data)))


def _with_kind_of(value: Multivector, like: Multivector) -> Multivector:
    """The value as a multivector of the kind, where that can be, and with the statuses, that it had elsewhere."""
    status = None if like._status is None else np.array(np.broadcast_to(like._status, value.shape))
    if not set(value._type.blades) <= set(like.kind.blades):  # a rotation becomes a motor
        return value._make(value._type, value._data, value.shape, status)
    kind = like.algebra.type_of(like.kind, value.dtype)
    return value._make(kind, embed(value, like.kind), value.shape, status)
