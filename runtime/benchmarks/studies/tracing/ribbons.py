"""Rays against surfaces evolved between point pairs: roots lost, false, and how far off, per method and time."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..study import Case, Study
from .rays import COPIES, FAR, METHODS, NOTES, Control, describe, error, rays, truth, unit


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
    turn = np.sort(rng.uniform(0, 2 * np.pi, 4))[[0, 3, 1, 2], None]
    ends = np.cos(turn) * u + np.sin(turn) * v + 1e-8 * rng.normal(size=(4, 3))
    return [(ends[0], ends[1]), (ends[2], ends[3])]


STUDY = Study(
    name="ribbons",
    title="Rays against surfaces evolved between point pairs",
    methods=METHODS,
    cases=(
        Case("random point pairs", rays("pairs", any_pairs), "ordinary", describe),
        Case("rays 1e-9 off tangents", rays("pairs", partial(ribbon, 1), is_tangent=True), "extreme", describe),
        Case("1e-8 off a common circle", rays("pairs", cocircular_pairs), "extreme", describe),
        Case("ribbons, 1e6 from the origin", rays("pairs", partial(ribbon, 1), FAR), "stiff", describe),
        Case("ribbons of degree 2", rays("pairs", partial(ribbon, 2)), "ordinary", describe),
        Case("ribbons of degree 3", rays("pairs", partial(ribbon, 3)), "ordinary", describe),
    ),
    reference=truth,
    error=error,
    unit="curve parameter",
    count=100,
    copies=COPIES,
    source="thesis 4.7.2, corrected",
    notes=NOTES,
)
