"""Stiff and extreme bodies: every integrator on each, and at one step over inertia ratio, spin and size."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ...harness.study import Case, sweep_cases
from . import integrators
from .integrators import Motions
from .tops import leaning

#: Steps of methods that do not choose their own: of stiff bodies as in the text, of the others.
LONG_STEP, STEP = 0.05, 1e-3
RATIOS, SPINS, SIZES = (1.0, 1e2, 1e4, 1e6), (10.0, 1e2, 1e3, 1e4), (1e-6, 1e-4, 1e-2, 1.0)
#: Number of copies of each motion that are computed at once.
COPIES, FEW_COPIES = 60, 12
#: From this spin on tops run a tenth of a second: a thousand radians at 1e4 rad/s.
FAST, SHORT = 1e3, 0.1


SYMMETRIC, UNEQUAL, SLOW = (0.2, 0.2, 0.1), (0.2, 0.25, 0.1), (0.2, 0.3, 0.4)


def one(
    count: int, moments: Any, spin: Any, duration: float, step: float | None, lean: float = 0.0, **options: Any
) -> Motions:
    """Copies of one motion."""
    rotation = np.tile(leaning(lean, 0.0), (count, 1, 1))
    return integrators.motions(moments, np.tile(spin, (count, 1)), rotation, duration, step=step, **options)


def needle(_: np.random.Generator, count: int, ratio: float, step: float | None = LONG_STEP) -> Motions:
    """A free body of which one moment is so many times smaller than the others."""
    return one(count, (1.0, ratio, ratio + 0.5), (1.0, 0.3, 0.2), 30.0, step)


def spinning(
    _: np.random.Generator, count: int, spin: float, step: float | None = STEP, moments: Any = SYMMETRIC
) -> Motions:
    """Tops on their tips, that rotate about their axes so fast."""
    duration = SHORT if spin >= FAST else 1.0
    return one(count, moments, (0.3, 0.2, spin), duration, step, lean=0.5, arm=(0, 0, 0.5), held="point")


def distant(_: np.random.Generator, count: int, distance: float) -> Motions:
    """A slow top so far from the origin."""
    position = distance * np.array([0.6, 0.0, 0.8])
    return one(count, SLOW, (0.5, 0.4, 0.6), 3.0, None, lean=2.0, arm=(0, 0, 0.5), held="point", position=position)


def tiny(_: np.random.Generator, count: int, size: float, step: float | None = STEP) -> Motions:
    """A smaller top: times scale with the square root of its size."""
    time = float(np.sqrt(size))
    moments, spin = size**2 * np.array(SLOW), np.array([0.5, 0.4, 0.6]) / time
    scaled = None if step is None else step * time
    return one(count, moments, spin, 3 * time, scaled, lean=2.0, arm=(0, 0, 0.5 * size), held="point")


def hinge(_: np.random.Generator, count: int, gap: float) -> Motions:
    """A pendulum that hangs on two of its points, so far from each other."""
    return one(count, SLOW, (0.0, 0.6, 0.0), 3.0, None, lean=1.0, arm=(0, 0, -0.5), held="points", gap=gap)


STUDY = integrators.study(
    name="stiffness",
    title="Integrators on stiff and extreme bodies",
    methods=integrators.methods(1, COPIES, FEW_COPIES),
    cases=(
        Case("inertia ratio 1e6, t = 30", partial(needle, ratio=1e6, step=None), "stiff"),
        Case("spin 1e4 rad/s, symmetric, t = 0.1", partial(spinning, spin=1e4, step=None), "stiff"),
        Case(
            "spin 1e4 rad/s, not symmetric, t = 0.1", partial(spinning, spin=1e4, step=None, moments=UNEQUAL), "stiff"
        ),
        Case("10 km away, t = 3", partial(distant, distance=1e4), "extreme"),
        Case("body of 1e-6 m, t = 0.003", partial(tiny, size=1e-6, step=None), "extreme"),
        Case("two pins 1e-8 m apart, t = 3", partial(hinge, gap=1e-8), "extreme"),
        *sweep_cases("inertia ratio", RATIOS, needle),
        *sweep_cases("spin in rad/s, symmetric", SPINS, spinning),
        *sweep_cases("spin in rad/s, not symmetric", SPINS, partial(spinning, moments=UNEQUAL)),
        *sweep_cases("size in metres", SIZES, tiny),
    ),
    count=4,
    source="thesis 6.4 to 6.8",
    notes="A point is a whole motion; labels are numbers of steps, or tolerances. In the second picture all have one "
    f"step, {LONG_STEP} s for inertia ratios and {STEP} s otherwise (of a body that is smaller shorter by the root), "
    "but for those who choose their own.",
)
