"""Stiff and extreme bodies: every integrator at one step, over inertia ratio, spin, distance, size and nearness."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ..study import Method, Study, swept
from . import integrators
from .integrators import Motions
from .tops import leaning

#: Steps of methods that do not choose their own: of stiff bodies as in the text, of the others.
LONG_STEP, STEP = 0.05, 1e-3
RATIOS, SPINS, DISTANCES = (1.0, 1e2, 1e4, 1e6), (10.0, 1e2, 1e3, 1e4), (1.0, 1e2, 1e4, 1e6)
SIZES, GAPS = (1.0, 1e-2, 1e-4, 1e-6), (1.0, 1e-2, 1e-4, 1e-6, 1e-8)
#: From this spin on tops run a tenth of a second: a thousand radians at 1e4 rad/s.
FAST, SHORT = 1e3, 0.1


def one(
    moments: Any, spin: Any, duration: float, step: float, *, arm: Any = (0, 0, 0), lean: float = 0.0, **held: Any
) -> Any:
    """Maker of one motion, whatever is asked for."""

    def make(rng: np.random.Generator, count: int) -> Motions:
        return Motions(
            np.ones(count), np.tile(moments, (count, 1)), np.tile(spin, (count, 1)),
            np.tile(leaning(lean, 0.0), (count, 1, 1)), duration, np.tile(arm, (count, 1)), step=step, **held,
        )  # fmt: skip

    return make


def needle(ratio: float) -> Any:
    """A free body of which one moment is so many times smaller than the others."""
    return one((1.0, ratio, ratio + 0.5), (1.0, 0.3, 0.2), 30.0, LONG_STEP)


def spinning(symmetric: bool) -> Callable[[float], Any]:
    """Tops on their tips, that turn about their axes so fast."""

    def make(spin: float) -> Any:
        duration = SHORT if spin >= FAST else 1.0
        moments = (0.2, 0.2 if symmetric else 0.25, 0.1)
        return one(moments, (0.3, 0.2, spin), duration, STEP, arm=(0, 0, 0.5), lean=0.5, held="point")

    return make


def distant(distance: float) -> Any:
    """A slow top so far from the origin."""
    place = distance * np.array([0.6, 0.0, 0.8])
    return one((0.2, 0.3, 0.4), (0.5, 0.4, 0.6), 3.0, STEP, arm=(0, 0, 0.5), lean=2.0, held="point", place=place)


def tiny(size: float) -> Any:
    """The same top, so many times smaller: its time is shorter by the root."""
    time = float(np.sqrt(size))
    moments, spin = size**2 * np.array([0.2, 0.3, 0.4]), np.array([0.5, 0.4, 0.6]) / time
    return one(moments, spin, 3 * time, STEP * time, arm=(0, 0, 0.5 * size), lean=2.0, held="point")


def hinge(gap: float) -> Any:
    """A pendulum that hangs on two of its points, so far from each other."""
    return one((0.2, 0.3, 0.4), (0.0, 0.6, 0.0), 3.0, STEP, arm=(0, 0, -0.5), lean=1.0, held="points", gap=gap)


def methods() -> tuple[Method, ...]:
    """"auto" at its default, and at the step of the others; they at that step or their default tolerance."""
    from ...dynamics.methods import INTEGRATORS

    found = [Method("auto", partial(integrators.integrate, integrator="auto"), "", (None, "step"), most=1, repeats=1)]
    for name in INTEGRATORS:
        settings: tuple[Any, ...] = ("step",) if name in integrators.STEPS else (None,)
        found.append(Method(name, partial(integrators.integrate, integrator=name), "", settings, most=1, repeats=1))
    return tuple(found)


STUDY = Study(
    name="stiffness",
    title="Integrators on stiff and extreme bodies",
    methods=methods(),
    cases=(
        *swept("inertia ratio", RATIOS, needle, integrators.describe),
        *swept("spin in rad/s, symmetric", SPINS, spinning(True), integrators.describe),
        *swept("spin in rad/s, not symmetric", SPINS, spinning(False), integrators.describe),
        *swept("metres away", DISTANCES, distant, integrators.describe),
        *swept("size in metres", SIZES, tiny, integrators.describe),
        *swept("metres between two pins", GAPS, hinge, integrators.describe),
    ),
    reference=integrators.truth,
    error=integrators.error,
    unit="radian, or relative",
    count=4,
    source="thesis 6.4 to 6.8",
    notes=f"Steps are {LONG_STEP} s for inertia ratios and {STEP} s otherwise (of a body that is smaller shorter by the "
    'root), for those who do not choose their own. "auto" is shown as users get it who say nothing, and with that step.',
)
