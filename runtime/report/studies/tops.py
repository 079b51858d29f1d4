"""Tops, free and heavy: every integrator's error against its run time, beside what "auto" takes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Study
from . import integrators
from .integrators import Motions, case

Array = NDArray[Any]
#: Bodies of a case.
COUNT = 4
#: How much spins differ among the bodies of a case.
SPREAD = 0.1
#: A cuboid's: it flips about its middle axis three times in half a minute.
CUBOID, FLIPPING = (1.0, 2.0, 2.5), (2e-3, 2.0, 1e-3)


def free(moments: Any, spin: Any, duration: float) -> Any:
    """Maker of tops without loads."""

    def make(rng: np.random.Generator, count: int) -> Motions:
        spins = np.asarray(spin) * rng.uniform(1 - SPREAD, 1 + SPREAD, (count, 3))
        return Motions(
            np.ones(count), np.tile(moments, (count, 1)), spins, integrators.rotations(rng, count), duration,
            np.zeros((count, 3)),
        )  # fmt: skip

    return make


def heavy(moments: Any, spin: Any, arm: Any, duration: float) -> Any:
    """Maker of tops that stand on a point, leaning by up to a right angle."""

    def make(rng: np.random.Generator, count: int) -> Motions:
        lean, way = rng.uniform(0.2, 1.5, count), rng.uniform(0, 2 * np.pi, count)
        rotation = np.stack([leaning(a, b) for a, b in zip(lean, way, strict=True)])
        spins = np.asarray(spin) * rng.uniform(1 - SPREAD, 1 + SPREAD, (count, 3))
        return Motions(
            np.ones(count), np.tile(moments, (count, 1)), spins, rotation, duration, np.tile(arm, (count, 1)), "point"
        )

    return make


def leaning(lean: float, way: float) -> Array:
    """The third axis so far from upright, in a direction."""
    (s, c), (u, v) = ((np.sin(x), np.cos(x)) for x in (lean, way))
    return np.array([[v * c, -u, v * s], [u * c, v, u * s], [-s, 0, c]])


STUDY = Study(
    name="tops",
    title="Integrators on free and heavy tops",
    methods=integrators.methods(COUNT),
    cases=(
        case("free, no two moments equal, t = 20", free(CUBOID, (1.5, 1.0, 2.0), 20.0)),
        case("free cuboid, flipping, t = 30", free(CUBOID, FLIPPING, 30.0)),
        case("free, symmetric, t = 20", free((1.0, 1.0, 1.8), (0.5, 0.3, 3.0), 20.0)),
        case("heavy, symmetric, t = 5", heavy((0.2, 0.2, 0.1), (0.3, 0.2, 20.0), (0, 0, 0.5), 5.0)),
        case("heavy, slow, t = 5", heavy((0.2, 0.3, 0.4), (0.5, 0.5, 0.5), (0, 0, 0.5), 5.0)),
        case("heavy, no symmetry, t = 5", heavy((0.1, 0.2, 0.25), (1.0, 5.0, 2.0), (0.1, 0.2, 0.3), 5.0)),
    ),
    reference=integrators.truth,
    error=integrators.error,
    unit="radian, or relative",
    count=COUNT,
    source="thesis 6.4 to 6.7",
    notes="A point is a whole motion. Integrators with steps of one size are labelled with their number, the others with "
    "their tolerance; \"auto\" runs as users get it who say nothing. Times hold what a call costs, shared by the "
    "bodies of a batch.",
)
