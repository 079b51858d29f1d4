"""Rays against surfaces evolved between point pairs: lost roots, false roots and errors, by method and time."""

from __future__ import annotations

import numpy as np

from ...harness.vectors import unit
from .rays import Control, study


def any_pairs(rng: np.random.Generator) -> list[Control]:
    """Two pairs of any points."""
    return [(rng.normal(size=3), rng.normal(size=3)) for _ in range(2)]


def ribbon(degree: int, rng: np.random.Generator) -> list[Control]:
    """Pairs along a path."""
    axis, across = unit(rng.normal(size=(2, 3)))
    found = []
    for k in range(degree + 1):
        middle = (1.6 * k / degree - 0.8) * axis + 0.2 * rng.normal(size=3)
        half = 0.6 * unit(across + 0.5 * rng.normal(size=3))
        found.append((middle - half, middle + half))
    return found


def cocircular_pairs(rng: np.random.Generator) -> list[Control]:
    """Two pairs that miss lying on one circle by 1e-8."""
    u, v = unit(rng.normal(size=(2, 3)))
    v = unit(v - (u @ v) * u)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 4))[[0, 3, 1, 2], None]
    ends = np.cos(angles) * u + np.sin(angles) * v + 1e-8 * rng.normal(size=(4, 3))
    return [(ends[0], ends[1]), (ends[2], ends[3])]


STUDY = study(
    "pairs", any_pairs, cocircular_pairs, ribbon, special_name="circle", path_name="ribbons", name="ribbons",
    title="Rays against surfaces evolved between point pairs", source="thesis 4.7.2, corrected",
)  # fmt: skip
