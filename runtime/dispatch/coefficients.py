"""Arrays of coefficients for a call: broadcast over items, contiguous, scaled, on other blades. No products."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Kind
from ..codegen.errors import ShapeError
from .multivector_data import M, MultivectorData
from .types import Type


def broadcast(*operands: MultivectorData) -> tuple[int, ...]:
    """Common leading shape.

    Raises
    ------
    ShapeError
        If the shapes do not broadcast.
    """
    try:
        return np.broadcast_shapes(*(x._lead for x in operands))
    except ValueError:
        shapes = " and ".join(str(x._lead) for x in operands)
        raise ShapeError(f"shapes {shapes} do not broadcast; insert axes with a[:, None].") from None


def expand_rows(x: MultivectorData, lead: tuple[int, ...]) -> NDArray[Any]:
    """Contiguous rows for the common shape: as they are, one for all, or repeated."""
    if x._lead == lead or math.prod(x._lead) == 1:
        return x._data
    return np.ascontiguousarray(np.broadcast_to(x._data, (*lead, x._type.size)))


def embed(x: MultivectorData, kind: Kind) -> NDArray[Any]:
    """Rows on the blades of ``kind``: zero where x has no such blade; the others of x are left out."""
    if x._type.blades == kind.blades:
        return x._data
    if x._type.backend is not None:
        columns = np.array([x._type.columns.get(blade, -1) for blade in kind.blades], np.int64)
        return x._type.backend.take(x._data, columns)  # type: ignore[no-any-return]
    target, source = x._type.memoize(("embedded", kind.blades), lambda: _shared_columns(x._type, kind))
    data = np.zeros((*x._lead, kind.size), x.dtype)
    if len(target):
        data[..., target] = x._data[..., source]
    return data


def _shared_columns(type: Type, kind: Kind) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns of a kind's blades that a type has, and those of the type."""
    columns = type.columns
    pairs = [(i, columns[blade]) for i, blade in enumerate(kind.blades) if blade in columns]
    return np.array([i for i, _ in pairs], np.intp), np.array([j for _, j in pairs], np.intp)


def no_items(x: MultivectorData) -> Any:
    """No items of the same kind, on NumPy arrays: what a function makes of them says the kind of its results."""
    plain = x.algebra.type_of(x.kind, x.dtype)
    return x.algebra.multivector_class._make(plain, np.empty((0, plain.size), x.dtype), (0,))


def normalize_exponents(x: M) -> tuple[M, NDArray[Any] | None]:
    """Items, those beyond the ordinary over a power of two that brings their largest coefficient near 1; its exponent.

    Exact, so that products neither overflow nor vanish; x itself, and None, where all items are ordinary, or where a
    constraint holds their scale.
    """
    if x.kind.constraints or not x._data.size:
        return x, None
    with np.errstate(all="ignore"):
        size = np.abs(x._data).max(-1)
        room = np.finfo(x.dtype).maxexp // 2 ** (x.algebra.dimension // 2 + 2)  # determinants are of such a degree
        if 2.0**-room < size.min() and size.max() < 2.0**room:
            return x, None
        scales = np.isfinite(size) & ~((2.0**-room < size) & (size < 2.0**room))  # no item depends on another
        exponent = np.where(scales, np.frexp(size)[1], 0).astype(np.int32)
    return x._make(x._type, np.ldexp(x._data, -exponent[..., None]), x._lead, x._status), exponent
