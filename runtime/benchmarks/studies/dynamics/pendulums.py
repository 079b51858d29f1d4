"""Physical pendulums that hang on a point or a line: every integrator's error against its run time."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ...harness.study import Array, Case
from . import integrators
from .integrators import Motions
from .tops import COUNT, SPREAD, leaning

MASS, MOMENTS, ARM = 2.0, (0.3, 0.4, 0.2), (0.1, 0.0, -0.5)
DURATION = 3.0


def hinged_pendulums(rng: np.random.Generator, count: int, lean: float = 1.5, rate: float = 1.0) -> Motions:
    """Pendulums that rotate about the line along their second axis, so far from hanging, at such a rate."""
    rotation = np.stack([leaning(lean * a, 0.0) for a in rng.uniform(1 - SPREAD, 1, count)])
    spin = np.zeros((count, 3))
    spin[:, 1] = rate * rng.uniform(1 - SPREAD, 1 + SPREAD, count)
    return _pendulums(rotation, spin, "line")


def spherical_pendulums(rng: np.random.Generator, count: int, lean: float = 1.5, **options: Any) -> Motions:
    """Pendulums on a point, that swing to the side too."""
    rotation = np.stack([leaning(lean, azimuth) for azimuth in rng.uniform(0, 2 * np.pi, count)])
    return _pendulums(rotation, rng.uniform(0.5, 1.5, (count, 3)), "point", **options)


def _pendulums(rotation: Array, spin: Array, held: str, **options: Any) -> Motions:
    return integrators.motions(MOMENTS, spin, rotation, DURATION, arm=ARM, held=held, mass=MASS, **options)


STUDY = integrators.study(
    name="pendulums",
    title="Integrators on pendulums",
    methods=integrators.methods(COUNT),
    cases=(
        Case("on a line, to and fro", hinged_pendulums),
        Case("on a line, over the top", partial(hinged_pendulums, lean=1.0, rate=9.0)),
        Case("on a point", spherical_pendulums),
        Case("on a point, by projection", partial(spherical_pendulums, stabilization="projection")),
    ),
    count=COUNT,
    source="thesis 6.7 and 6.8",
    notes="A point is a whole motion. Pins that never move are kept by moving only as they allow; the last panel is "
    "the same with multipliers and projection, as constraints are kept that move.",
)
