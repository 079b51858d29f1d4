"""Matched models of few sets of kinds, with outliers."""

from __future__ import annotations

import numpy as np
import pytest

from bladesmith import cga3d as cga
from bladesmith import registration

from ..registration import fresh, noisy, pose, rotation, turned
from ..registration import moved as moved_parameters

#: Few sets of kinds: each has a driver of its own to compile.
LINES, POINTS = {"lines": 20}, {"points": 20}
EVERY = {"points": 5, "point_pairs": 5, "lines": 5, "circles": 5, "planes": 5, "spheres": 5}
SPECS = pytest.mark.parametrize("spec", [LINES, POINTS, EVERY], ids=["lines", "points", "every"])


def scene(spec, seed, noise=0.0, wrong=0.0, angle=None, shift=1.0, turn=False):
    """Matched models, the motor from one to the other, and for each kind which are wrong."""
    rng = np.random.default_rng([seed, 5])
    q, t, motor = pose(rng)
    if angle is not None:
        axis, t = rng.normal(size=3), shift * rng.normal(size=3) / np.sqrt(3)
        q, motor = rotation(axis, angle), cga.translator(t) * cga.rotor(axis, angle)
    query, reference, bad = {}, {}, {}
    for kind, n in spec.items():
        x = fresh(kind, n, rng)
        y = noisy(kind, moved_parameters(kind, x, q, t), noise, rng)
        bad[kind] = np.arange(n) < int(wrong * n)
        if bad[kind].any():
            y[bad[kind]] = fresh(kind, int(wrong * n), rng)
        query[kind], reference[kind] = x, turned(kind, y, rng) if turn else y
    return registration.Model(**query), registration.Model(**reference), motor, bad
