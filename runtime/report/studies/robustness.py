"""How often a pose is found, over displacement, noise, wrong and missing objects, and size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ..study import Case
from .poses import describe, scenes
from .registrations import LINES, NEAR
from .registrations import STUDY as REGISTRATIONS

DISPLACEMENTS = (0.03, 0.1, 0.3, 1.0, 3.0)
NOISES = (1e-4, 1e-3, 1e-2, 3e-2, 1e-1)
SHARES = (0.1, 0.2, 0.4, 0.6, 0.8)
SIZES = (5, 10, 20, 50, 100, 400)
#: Scenes of one value, and for methods that take long.
EACH, EACH_SLOW = 10, 5


def sweep(what: str, name: str, values: Sequence[float], **options: Any) -> tuple[Case, ...]:
    """Scenes of 20 lines with one option varied."""
    return tuple(
        Case(f"{what} {v:g}", scenes(LINES, True, **{**options, name: v}), "extreme", describe, (what, v))
        for v in values
    )


STUDY = replace(
    REGISTRATIONS,
    name="robustness",
    title="How often a pose is found",
    methods=tuple(replace(m, most=EACH_SLOW) if m.slow else m for m in REGISTRATIONS.methods if m.prepare is None),
    cases=(
        Case("20 lines, a tenth away, noise 0.001", scenes(LINES, True, displacement=NEAR, noise=1e-3), "ordinary",
             describe),
        *sweep("displacement: radians, half widths", "displacement", DISPLACEMENTS, noise=1e-3),
        *sweep("noise; a tenth away", "noise", NOISES, displacement=NEAR),
        *sweep("share of wrong objects; a tenth away", "outliers", SHARES, displacement=NEAR, noise=1e-3),
        *sweep("share of missing objects; a tenth away", "missing", SHARES, displacement=NEAR, noise=1e-3),
        *(Case(f"{n} lines", scenes({"line": n}, True, displacement=NEAR, noise=1e-3, outliers=0.3, missing=0.3),
               "extreme", describe, ("number of lines; a tenth away, 30 % wrong and missing", n)) for n in SIZES),
    ),
    count=EACH,
    shares=True,
)  # fmt: skip
