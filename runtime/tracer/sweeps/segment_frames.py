"""Local frames of a curve's pieces, and the orientation of its controls."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from .control_parameters import ControlParameters, is_opposite

Array = NDArray[np.float64]


def local_frames(controls: ControlParameters, near: NDArray[np.bool_], members: Any = None) -> tuple[Array, Array]:
    """Origins (pieces, 3) and units (pieces,): center and size of the box around the ``near`` controls (pieces, m)."""
    lowest, highest, radius = controls.box()
    if members is not None:
        lowest, highest, radius = lowest[members], highest[members], radius[members]
    low = np.where(near[..., None], lowest, np.inf).min(axis=1)
    high = np.where(near[..., None], highest, -np.inf).max(axis=1)
    size = np.maximum((high - low).max(axis=1), np.where(near, radius, 0.0).max(axis=1))
    return low + (high - low) / 2, size


def opposite_neighbors(controls: ControlParameters) -> NDArray[np.bool_]:
    """Test which controls (n - 1,) oppose their predecessor, each two in a frame of their own."""
    pairs = np.arange(len(controls) - 1)[:, None] + np.arange(2)
    center, size = local_frames(controls, np.ones(pairs.shape, bool), pairs)
    first, second = (controls.take(at).coefficients(center, size) for at in pairs.T)
    return is_opposite(controls.kind, first, second)


def alternating_flips(against: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Controls (..., n) to flip so that none opposes its predecessor, where ``against`` (..., n - 1) do."""
    odd = np.cumsum(against, axis=-1) % 2 == 1
    return np.concatenate([np.zeros((*odd.shape[:-1], 1), bool), odd], axis=-1)


def refuse_one_object(controls: ControlParameters) -> None:
    """Raise a `SceneError` for controls that are all equal: they sweep no surface."""
    if len(controls) > 1 and (controls.rows == controls.rows[0]).all():
        raise SceneError(
            f"the {len(controls)} controls are all the same {controls.kind.replace('_', ' ')}; nothing is swept.",
            remedy="Give controls that differ",
        )
