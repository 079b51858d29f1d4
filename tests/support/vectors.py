"""Plain vectors as arrays, for tests: directions and rotations without any geometric algebra."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def unit(v: Any) -> Array:
    """v over its length."""
    v = np.asarray(v)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def rotation_matrix(axis: Array, angle: Any) -> Array:
    """Rodrigues' formula."""
    axis, angle = np.asarray(axis, float), np.asarray(angle, float)
    a = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    k = np.zeros((*a.shape[:-1], 3, 3))
    k[..., 0, 1], k[..., 0, 2], k[..., 1, 2] = -a[..., 2], a[..., 1], -a[..., 0]
    k = k - np.swapaxes(k, -1, -2)
    s, c = np.sin(angle)[..., None, None], np.cos(angle)[..., None, None]
    return np.eye(3) + s * k + (1 - c) * (k @ k)
