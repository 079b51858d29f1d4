"""Unit twists as matrices: how objects move under them, and which of their coefficients are rotations."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.multivector import Algebra, Multivector
from ..dispatch.formulas import evaluate
from .motion_closed_kinds import on_layout

Array = NDArray[Any]


def commutator_matrix(x: Multivector, layout: str) -> Array:
    """Matrices (..., k, 6) of the commutators X x E with the unit twists E."""
    algebra = x.algebra
    on = algebra.wrap(algebra.kind(layout).layout, on_layout(x, layout))
    row: Array = evaluate(algebra, "pins.moved_rates", on).value
    size = algebra.kind(layout).size
    return np.swapaxes(row.reshape(*row.shape[:-1], 6, size), -1, -2)


def screw_vectors(algebra: Algebra, twists: Array) -> tuple[Array, Array]:
    """Vectors w and v (..., 3) of twists w I3 + v n by their coefficients (..., 6)."""
    screws = evaluate(
        algebra, "mechanics.screw_vectors", algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(twists))
    )
    return screws.values[0].values, screws.values[1].values


@cache
def rotational_mask(algebra: Algebra) -> Array:
    """Mask (6,) of the coefficients of a twist that are rotations (read-only)."""
    rotations, _ = screw_vectors(algebra, np.eye(6))
    mask: Array = np.abs(rotations).max(-1) > 0
    mask.flags.writeable = False
    return mask
