"""Stiff and extreme bodies: every integrator on each, and at one step over inertia ratio, spin and size."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..study import Study, swept
from . import integrators
from .integrators import Motions, case
from .tops import leaning

#: Steps of methods that do not choose their own: of stiff bodies as in the text, of the others.
LONG_STEP, STEP = 0.05, 1e-3
RATIOS, SPINS, SIZES = (1.0, 1e2, 1e4, 1e6), (10.0, 1e2, 1e3, 1e4), (1e-6, 1e-4, 1e-2, 1.0)
#: How often each motion is computed at once.
COPIES, FEW_COPIES = 60, 12
#: From this spin on tops run a tenth of a second: a thousand radians at 1e4 rad/s.
FAST, SHORT = 1e3, 0.1


def one(
    moments: Any,
    spin: Any,
    duration: float,
    step: float | None,
    *,
    arm: Any = (0, 0, 0),
    lean: float = 0.0,
    **held: Any,
) -> Any:
    """Maker of one motion, whatever is asked for."""

    def make(rng: np.random.Generator, count: int) -> Motions:
        return Motions(
            np.ones(count), np.tile(moments, (count, 1)), np.tile(spin, (count, 1)),
            np.tile(leaning(lean, 0.0), (count, 1, 1)), duration, np.tile(arm, (count, 1)), step=step, **held,
        )  # fmt: skip

    return make


def needle(ratio: float, step: float | None = LONG_STEP) -> Any:
    """A free body of which one moment is so many times smaller than the others."""
    return one((1.0, ratio, ratio + 0.5), (1.0, 0.3, 0.2), 30.0, step)


def spinning(spin: float, step: float | None = STEP, moments: Any = (0.2, 0.2, 0.1)) -> Any:
    """Tops on their tips, that turn about their axes so fast."""
    duration = SHORT if spin >= FAST else 1.0
    return one(moments, (0.3, 0.2, spin), duration, step, arm=(0, 0, 0.5), lean=0.5, held="point")


def unequal(spin: float, step: float | None = STEP) -> Any:
    """The same of bodies that are not symmetric."""
    return spinning(spin, step, (0.2, 0.25, 0.1))


def distant(distance: float) -> Any:
    """A slow top so far from the origin."""
    place = distance * np.array([0.6, 0.0, 0.8])
    return one((0.2, 0.3, 0.4), (0.5, 0.4, 0.6), 3.0, None, arm=(0, 0, 0.5), lean=2.0, held="point", place=place)


def tiny(size: float, step: float | None = STEP) -> Any:
    """The same top, so many times smaller: its time is shorter by the root."""
    time = float(np.sqrt(size))
    moments, spin = size**2 * np.array([0.2, 0.3, 0.4]), np.array([0.5, 0.4, 0.6]) / time
    own = None if step is None else step * time
    return one(moments, spin, 3 * time, own, arm=(0, 0, 0.5 * size), lean=2.0, held="point")


def hinge(gap: float) -> Any:
    """A pendulum that hangs on two of its points, so far from each other."""
    return one((0.2, 0.3, 0.4), (0.0, 0.6, 0.0), 3.0, None, arm=(0, 0, -0.5), lean=1.0, held="points", gap=gap)


STUDY = Study(
    name="stiffness",
    title="Integrators on stiff and extreme bodies",
    methods=integrators.methods(1, COPIES, FEW_COPIES),
    cases=(
        case("inertia ratio 1e6, t = 30", needle(1e6, None), "stiff"),
        case("spin 1e4 rad/s, symmetric, t = 0.1", spinning(1e4, None), "stiff"),
        case("spin 1e4 rad/s, not symmetric, t = 0.1", unequal(1e4, None), "stiff"),
        case("10 km away, t = 3", distant(1e4), "extreme"),
        case("body of 1e-6 m, t = 0.003", tiny(1e-6, None), "extreme"),
        case("two pins 1e-8 m apart, t = 3", hinge(1e-8), "extreme"),
        *swept("inertia ratio", RATIOS, needle, integrators.describe),
        *swept("spin in rad/s, symmetric", SPINS, spinning, integrators.describe),
        *swept("spin in rad/s, not symmetric", SPINS, unequal, integrators.describe),
        *swept("size in metres", SIZES, tiny, integrators.describe),
    ),
    reference=integrators.truth,
    error=integrators.error,
    unit="radian, or relative",
    count=4,
    source="thesis 6.4 to 6.8",
    notes="A point is a whole motion; labels are numbers of steps, or tolerances. In the second picture all have one "
    f"step, {LONG_STEP} s for inertia ratios and {STEP} s otherwise (of a body that is smaller shorter by the root), "
    "but for those who choose their own.",
)
