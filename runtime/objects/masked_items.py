"""Items of batches under masks: taken out, put together again, one of two for each. No algebra comes in here."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.multivector import Multivector
from ..dispatch.coefficients import embed


def at(x: Multivector, where: NDArray[np.bool_]) -> Multivector:
    """Items of a batch that broadcasts with a mask, where it holds: (n,)."""
    data = np.broadcast_to(x._data, (*where.shape, x._type.size))[masked_indices(where)]
    return x._make(x._type, data, data.shape[:-1])


def masked_indices(where: NDArray[np.bool_]) -> Any:
    """The index of a mask's items: for few of many several times faster than the mask."""
    return np.nonzero(where) if where.ndim else where


def select(where: NDArray[np.bool_], inside: Multivector, outside: Multivector) -> Multivector:
    """One of two batches, item by item."""
    data = np.where(where[..., None], inside._data, outside._data)
    return outside._make(outside._type, data, outside.shape, np.where(where, codes(inside), codes(outside)))


def merge_items(where: NDArray[np.bool_], inside: Multivector, outside: Multivector) -> Multivector:
    """One batch of the items under a mask and the others."""
    data = np.empty((*where.shape, outside._type.size), outside.dtype)
    status = np.empty(where.shape, np.uint8)
    data[where], data[~where] = embed(inside, outside.kind), outside._data
    status[where], status[~where] = codes(inside), codes(outside)
    return outside._make(outside._type, data, where.shape, status)


def codes(x: Multivector) -> NDArray[np.uint8]:
    """Statuses as a new array."""
    return np.zeros(x.shape, np.uint8) if x._status is None else np.array(x._status)


__all__ = ["at", "codes", "masked_indices", "merge_items", "select"]
