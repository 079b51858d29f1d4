"""Tops, free and heavy: every integrator's error against its run time, beside the choice of "auto"."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ...harness.study import Array, Case
from . import integrators
from .integrators import Motions

#: Bodies of a case.
COUNT = 3
#: Relative spread of spins among the bodies of a case.
SPREAD = 0.1
#: A cuboid's: it flips about its middle axis three times in half a minute.
CUBOID, FLIPPING = (1.0, 2.0, 2.5), (2e-3, 2.0, 1e-3)


def free(rng: np.random.Generator, count: int, moments: Any, spin: Any, duration: float) -> Motions:
    """Tops without loads."""
    spins = np.asarray(spin) * rng.uniform(1 - SPREAD, 1 + SPREAD, (count, 3))
    return integrators.motions(moments, spins, integrators.rotations(rng, count), duration)


def heavy(
    rng: np.random.Generator, count: int, moments: Any, spin: Any, arm: Any = (0, 0, 0.5), duration: float = 3.0
) -> Motions:
    """Tops that stand on a point, leaning by up to a right angle."""
    lean, azimuth = rng.uniform(0.2, 1.5, count), rng.uniform(0, 2 * np.pi, count)
    rotation = np.stack([leaning(a, b) for a, b in zip(lean, azimuth, strict=True)])
    spins = np.asarray(spin) * rng.uniform(1 - SPREAD, 1 + SPREAD, (count, 3))
    return integrators.motions(moments, spins, rotation, duration, arm=arm, held="point")


def leaning(lean: float, azimuth: float) -> Array:
    """Rotation that tilts the third axis from upright, in a direction."""
    (s, c), (u, v) = ((np.sin(x), np.cos(x)) for x in (lean, azimuth))
    return np.array([[v * c, -u, v * s], [u * c, v, u * s], [-s, 0, c]])


STUDY = integrators.study(
    name="tops",
    title="Integrators on free and heavy tops",
    methods=integrators.methods(COUNT),
    cases=(
        Case("free, no two moments equal, t = 20", partial(free, moments=CUBOID, spin=(1.5, 1.0, 2.0), duration=20.0)),
        Case("free cuboid, flipping, t = 30", partial(free, moments=CUBOID, spin=FLIPPING, duration=30.0)),
        Case("free, symmetric, t = 20", partial(free, moments=(1, 1, 1.8), spin=(0.5, 0.3, 3.0), duration=20.0)),
        Case("heavy, symmetric, t = 3", partial(heavy, moments=(0.2, 0.2, 0.1), spin=(0.3, 0.2, 20.0))),
        Case("heavy, slow, t = 3", partial(heavy, moments=(0.2, 0.3, 0.4), spin=(0.5, 0.5, 0.5))),
        Case(
            "heavy, no symmetry, t = 3",
            partial(heavy, moments=(0.1, 0.2, 0.25), spin=(1.0, 5.0, 2.0), arm=(0.1, 0.2, 0.3)),
        ),
    ),
    count=COUNT,
    source="thesis 6.4 to 6.7",
    notes="A point is a whole motion. Integrators with steps of one size are labelled with their number, the others "
    'with their tolerance; "auto" runs as users get it who say nothing. Times hold what a call costs, shared by the '
    "bodies of a batch.",
)
