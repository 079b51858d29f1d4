"""Constraint stabilization over many steps, and its effect on the motion: the methods side by side."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...harness.study import Case, Errors, Method, Study, lost_beyond, sweep_cases
from . import integrators
from .drift import COUNTS, STEP, STORES
from .integrators import Motions
from .pendulums import hinged_pendulums, spherical_pendulums
from .tops import COUNT

#: Integrator of all methods: one that has a chart, and takes steps of one size.
INTEGRATOR = "rkmk4"
METHODS = ("null-space", "projection", "baumgarte", "none")
SETTINGS = (250, 1000, 4000)
COPIES = 2


def integrate_constrained(inputs: Motions, setting: Any, *, method: str) -> Any:
    """States at the end; for sweeps the largest violation on the way."""
    if inputs.step is None:
        return integrators.integrate(inputs, setting, copies=COPIES, integrator=INTEGRATOR, stabilization=method)
    if setting is not None:
        return None
    simulation = inputs.simulation(integrator=INTEGRATOR, stabilization=method)
    times = np.linspace(0, inputs.duration, STORES + 1)
    trajectory = integrators.run_if_possible(simulation, inputs.duration, times, step=inputs.step)
    if trajectory is None:
        return None
    violation = trajectory.violation.reshape(len(inputs), -1)
    return violation.max(1) if violation.shape[1] > STORES else np.full(len(inputs), np.inf)


def truth(inputs: Motions) -> Any:
    """Exact states; for sweeps no violation."""
    return integrators.truth(inputs) if inputs.step is None else np.zeros(len(inputs))


def error(answer: Any, exact: Any, inputs: Motions) -> Errors:
    """Error of the motion, or the violation."""
    if inputs.step is None:
        return integrators.error(answer, exact, inputs)
    return lost_beyond(answer, np.inf)


def long_pendulum(rng: np.random.Generator, _: int, steps: float, held: str) -> Motions:
    """A pendulum for so many steps."""
    motions = (hinged_pendulums if held == "line" else spherical_pendulums)(rng, 1)
    return replace(motions, duration=steps * STEP, held=held, step=STEP)


STUDY = Study(
    name="violations",
    title="Keeping constraints",
    methods=tuple(
        Method(
            method, partial(integrate_constrained, method=method), "steps", (None, *SETTINGS), most=COUNT, repeats=1,
            copies=COPIES,
        )
        for method in METHODS
    ),
    cases=(
        Case("on a line, t = 3", hinged_pendulums),
        Case("on a point, t = 3", spherical_pendulums),
        *sweep_cases("steps, hanging on a line", COUNTS, partial(long_pendulum, held="line")),
        *sweep_cases("steps, hanging on a point", COUNTS, partial(long_pendulum, held="point")),
        *sweep_cases("steps, a point on a sphere", COUNTS, partial(long_pendulum, held="sphere")),
    ),
    reference=truth,
    error=error,
    describe=integrators.describe,
    unit="radian, or of coefficients",
    count=COUNT,
    source="thesis 6.6 to 6.10",
    notes=f"All with {INTEGRATOR}. The first picture shows the error of the motion; the second the largest error of a "
    f"constraint's coefficients over steps of {STEP} s. What slides on a sphere has no null space of its own.",
)  # fmt: skip
