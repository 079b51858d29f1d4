"""Physical pendulums that hang on a point or a line: every integrator's error against its run time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..study import Study
from . import integrators
from .integrators import Motions, case
from .tops import COUNT, SPREAD, leaning

MASS, MOMENTS, ARM = 2.0, (0.3, 0.4, 0.2), (0.1, 0.0, -0.5)
DURATION = 3.0


def hinged(lean: float, rate: float, **options: Any) -> Any:
    """Maker of pendulums that turn about the line along their second axis, so far from hanging, at such a rate."""

    def make(rng: np.random.Generator, count: int) -> Motions:
        rotation = np.stack([leaning(lean * a, 0.0) for a in rng.uniform(1 - SPREAD, 1, count)])
        spin = np.zeros((count, 3))
        spin[:, 1] = rate * rng.uniform(1 - SPREAD, 1 + SPREAD, count)
        return _motions(rotation, spin, "line", **options)

    return make


def swinging(lean: float, **options: Any) -> Any:
    """Maker of pendulums on a point, that swing to the side too."""

    def make(rng: np.random.Generator, count: int) -> Motions:
        ways = rng.uniform(0, 2 * np.pi, count)
        rotation = np.stack([leaning(lean, way) for way in ways])
        return _motions(rotation, rng.uniform(0.5, 1.5, (count, 3)), "point", **options)

    return make


def _motions(rotation: Any, spin: Any, held: str, **options: Any) -> Motions:
    n = len(rotation)
    mass, moments, arm = np.full(n, MASS), np.tile(MOMENTS, (n, 1)), np.tile(ARM, (n, 1))
    return Motions(mass, moments, spin, rotation, DURATION, arm, held, **options)


STUDY = Study(
    name="pendulums",
    title="Integrators on pendulums",
    methods=integrators.methods(COUNT),
    cases=(
        case("on a line, to and fro", hinged(1.5, 1.0)),
        case("on a line, over the top", hinged(1.0, 9.0)),
        case("on a point", swinging(1.5)),
        case("on a point, by projection", swinging(1.5, stabilization="projection")),
    ),
    reference=integrators.truth,
    error=integrators.error,
    unit="radian, or relative",
    count=COUNT,
    source="thesis 6.7 and 6.8",
    notes="A point is a whole motion. Pins that never move are kept by moving only as they allow; the last panel is "
    "the same with multipliers and projection, as constraints are kept that move.",
)
