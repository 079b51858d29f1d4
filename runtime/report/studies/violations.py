"""How constraints are kept over many steps, and what that does to the motion: the ways to do it, side by side."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Errors, Method, Study, swept
from . import integrators
from .drift import COUNTS, STEP, STORES
from .integrators import Motions, case
from .pendulums import hinged, swinging
from .tops import COUNT

Array = NDArray[Any]
#: Integrator of all: one that has a chart, and takes steps of one size.
INTEGRATOR = "rkmk4"
WAYS = ("null-space", "projection", "baumgarte", "none")
SETTINGS = (250, 1000, 4000)
COPIES = 2


def kept(inputs: Motions, setting: Any, *, way: str) -> Any:
    """The states at the end; of sweeps the largest violation on the way."""
    if inputs.step is None:
        return integrators.integrate(inputs, setting, copies=COPIES, integrator=INTEGRATOR, stabilization=way)
    if setting is not None:
        return None
    simulation = inputs.simulation(integrator=INTEGRATOR, stabilization=way)
    times = np.linspace(0, inputs.duration, STORES + 1)
    trajectory = integrators.ran(simulation, inputs.duration, times, step=inputs.step)
    if trajectory is None:
        return None
    found = trajectory.violation.reshape(len(inputs), -1)
    return found.max(1) if found.shape[1] > STORES else np.full(len(inputs), np.inf)


def truth(inputs: Motions) -> Any:
    """Of sweeps: no violation."""
    return integrators.truth(inputs) if inputs.step is None else np.zeros(len(inputs))


def error(answer: Any, exact: Any, inputs: Motions) -> Errors:
    """Of the motion, or the violation."""
    if inputs.step is None:
        return integrators.error(answer, exact, inputs)
    return np.where(np.isfinite(answer), answer, np.inf)


def long(held: str) -> Any:
    """Maker of a pendulum for so many steps."""

    def make(steps: float) -> Any:
        def inputs(rng: np.random.Generator, count: int) -> Motions:
            one = (hinged(1.5, 1.0) if held == "line" else swinging(1.5))(rng, 1)
            return Motions(one.mass, one.moments, one.spin, one.rotation, steps * STEP, one.arm, held, step=STEP)

        return inputs

    return make


STUDY = Study(
    name="violations",
    title="Keeping constraints",
    methods=tuple(Method(way, partial(kept, way=way), "steps", (None, *SETTINGS), most=COUNT, repeats=1, copies=COPIES)
                  for way in WAYS),
    cases=(
        case("on a line, t = 3", hinged(1.5, 1.0)),
        case("on a point, t = 3", swinging(1.5)),
        *swept("steps, hanging on a line", COUNTS, long("line"), integrators.describe),
        *swept("steps, hanging on a point", COUNTS, long("point"), integrators.describe),
        *swept("steps, a point on a sphere", COUNTS, long("sphere"), integrators.describe),
    ),
    reference=truth,
    error=error,
    unit="radian, or of coefficients",
    count=COUNT,
    source="thesis 6.6 to 6.10",
    notes=f"All with {INTEGRATOR}. The first picture shows the error of the motion; the second the largest error of a "
    f"constraint's coefficients over steps of {STEP} s. What slides on a sphere has no null space of its own.",
)  # fmt: skip
