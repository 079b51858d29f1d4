"""Frames of a curve's pieces, and which of its controls oppose each other; refusals of controls that sweep nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from .controls import Controls, opposed

Array = NDArray[np.float64]


def frames(controls: Controls, near: NDArray[np.bool_], members: Any = None) -> tuple[Array, Array]:
    """Origins (pieces, 3) and units (pieces,): the middle of what is near (pieces, m), and its size."""
    lowest, highest, radius = controls.box()
    if members is not None:
        lowest, highest, radius = lowest[members], highest[members], radius[members]
    low = np.where(near[..., None], lowest, np.inf).min(axis=1)
    high = np.where(near[..., None], highest, -np.inf).max(axis=1)
    size = np.maximum((high - low).max(axis=1), np.where(near, radius, 0.0).max(axis=1))
    return low + (high - low) / 2, size


def opposed_neighbours(controls: Controls) -> NDArray[np.bool_]:
    """Which control (n - 1,) opposes the one before, each two in a frame of their own."""
    pairs = np.arange(len(controls) - 1)[:, None] + np.arange(2)
    center, size = frames(controls, np.ones(pairs.shape, bool), pairs)
    first, second = (controls.taken(at).coefficients(center, size) for at in pairs.T)
    return opposed(controls.kind, first, second)


def turned_over(against: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which controls (..., n) to turn over where each (..., n - 1) opposes the one before."""
    odd = np.cumsum(against, axis=-1) % 2 == 1
    return np.concatenate([np.zeros((*odd.shape[:-1], 1), bool), odd], axis=-1)


def refuse_one_object(controls: Controls) -> None:
    """Raise a `SceneError` for controls that are all the same: nothing moves between them."""
    if len(controls) > 1 and (controls.rows == controls.rows[0]).all():
        raise SceneError(
            f"the {len(controls)} controls are one and the same {controls.kind.replace('_', ' ')}; nothing is swept.",
            remedy="Give controls that differ",
        )
