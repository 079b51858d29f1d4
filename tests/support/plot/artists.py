"""What is on axes: strokes, faces, marks, limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

art3d = pytest.importorskip("mpl_toolkits.mplot3d.art3d")


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def strokes(ax: Any) -> list[np.ndarray]:
    """Polylines of each collection of lines."""
    return [np.asarray(c._segments3d) for c in ax.collections if isinstance(c, art3d.Line3DCollection)]


def faces(ax: Any) -> list[Any]:
    return [c for c in ax.collections if isinstance(c, art3d.Poly3DCollection)]


def marks(ax: Any) -> list[np.ndarray]:
    dots = [c for c in ax.collections if isinstance(c, art3d.Path3DCollection)]
    return [np.stack([np.asarray(x) for x in c._offsets3d], -1) for c in dots]


def limits(ax: Any) -> np.ndarray:
    return np.array([ax.get_xlim3d(), ax.get_ylim3d(), ax.get_zlim3d()])
