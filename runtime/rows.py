"""Rows of coefficients for a call: broadcast over items, made contiguous, put on other blades. No products here."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .codegen.errors import ShapeError

if TYPE_CHECKING:
    from .codegen.kinds import Kind
    from .multivector import Multivector


def broadcast(*operands: Multivector) -> tuple[int, ...]:
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


def expanded(x: Multivector, lead: tuple[int, ...]) -> NDArray[Any]:
    """Contiguous rows for the common shape: as they are, one for all, or repeated."""
    if x._lead == lead or math.prod(x._lead) == 1:
        return x._data
    return np.ascontiguousarray(np.broadcast_to(x._data, (*lead, x._type.size)))


def embedded(x: Multivector, kind: Kind) -> NDArray[Any]:
    """Rows on the blades of ``kind``: zero where x has no such blade; the others of x are left out."""
    if x._type.blades == kind.blades:
        return x._data
    columns = x._type.columns
    pairs = [(i, columns[blade]) for i, blade in enumerate(kind.blades) if blade in columns]
    data = np.zeros((*x._lead, kind.size), x.dtype)
    if pairs:
        target, source = (list(side) for side in zip(*pairs, strict=True))
        data[..., target] = x._data[..., source]
    return data
