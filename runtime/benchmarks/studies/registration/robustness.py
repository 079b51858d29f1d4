"""Success rate of registration over displacement, noise, wrong and missing objects, and size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...harness.study import Case, sweep_cases
from .poses import Scenes, scenes
from .registrations import LINES, NEAR
from .registrations import STUDY as REGISTRATIONS

DISPLACEMENTS = (0.03, 0.1, 0.3, 1.0, 3.0)
NOISES = (1e-4, 1e-3, 1e-2, 3e-2, 1e-1)
FRACTIONS = (0.1, 0.2, 0.4, 0.6, 0.8)
SIZES = (5, 10, 20, 50, 100, 400)
#: Number of scenes of one value.
EACH = 10
#: The same for methods that take long.
EACH_SLOW = 5


def scenes_with(
    rng: np.random.Generator, count: int, value: float, name: str, counts: Mapping[str, int] = LINES, **options: Any
) -> Scenes:
    """Scenes of 20 lines with one option varied."""
    return scenes(rng, count, counts, True, **{**options, name: value})


near = partial(scenes_with, displacement=NEAR, noise=1e-3)
STUDY = replace(
    REGISTRATIONS,
    name="robustness",
    title="How often a pose is found",
    methods=tuple(replace(m, most=EACH_SLOW) if m.slow else m for m in REGISTRATIONS.methods if m.prepare is None),
    cases=(
        Case("20 lines, a tenth away, noise 0.001", partial(near, value=NEAR, name="displacement")),
        *sweep_cases("displacement: radians, half widths", DISPLACEMENTS, partial(near, name="displacement")),
        *sweep_cases("noise; a tenth away", NOISES, partial(near, name="noise")),
        *sweep_cases("fraction of wrong objects; a tenth away", FRACTIONS, partial(near, name="outliers")),
        *sweep_cases("fraction of missing objects; a tenth away", FRACTIONS, partial(near, name="missing")),
        *(
            Case(
                f"{n} lines",
                partial(near, value=0.3, name="outliers", missing=0.3, counts={"line": n}),
                "extreme",
                ("number of lines; a tenth away, 30 % wrong and missing", n),
            )
            for n in SIZES
        ),
    ),
    count=EACH,
    draws_fractions=True,
)  # fmt: skip
