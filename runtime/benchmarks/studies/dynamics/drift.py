"""What should not change and does: energy and momentum over many steps, by integrator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..study import Case, Errors, Method, Study
from . import integrators
from .integrators import GRAVITY, Motions
from .tops import CUBOID, free, heavy

Array = NDArray[Any]
#: Step of methods that do not choose their own; how often the motion is looked at; steps of a run.
STEP, STORES = 0.01, 100
COUNTS = (100.0, 1e3, 1e4)


@dataclass(frozen=True)
class Long:
    """A long run.

    Attributes
    ----------
    motions : Motions
    steps : int
    what : {"energy", "momentum"}
        What is looked at.
    """

    motions: Motions
    steps: int
    what: str

    def __len__(self) -> int:
        return len(self.motions)


def drifted(inputs: Long, setting: Any, *, integrator: str) -> Array | None:
    """The largest change on the way, as a share of what there is; infinite if the end was not reached."""
    motions, duration = inputs.motions, inputs.steps * STEP
    simulation = motions.simulation(integrator=integrator)
    times = np.linspace(0, duration, STORES + 1)
    trajectory = integrators.ran(simulation, duration, times, step=STEP)
    if trajectory is None:
        return None
    if len(trajectory.time) <= STORES:
        return np.full(len(inputs), np.inf)
    value = energy(motions, trajectory) if inputs.what == "energy" else momentum(motions, trajectory)
    changes: Array = np.linalg.norm(value - value[:, :1], axis=-1).max(1)
    return changes


def energy(motions: Motions, trajectory: Any) -> Array:
    """In units of the kinetic energy at the start, and of the weight at the arm's end: (n, times, 1)."""
    kinetic = (motions.moments * motions.spin**2).sum(1) / 2
    lever = motions.mass * np.linalg.norm(motions.arm, axis=1) * np.linalg.norm(GRAVITY)
    found: Array = trajectory.energy.reshape(len(motions), -1, 1) / (kinetic + lever)[:, None, None]
    return found


def momentum(motions: Motions, trajectory: Any) -> Array:
    """The moment of momentum about the origin, of its size at the start; of bodies with weight its vertical part."""
    from ... import dynamics

    _, moment = dynamics.wrench_parts(trajectory.momentum)
    found: Array = np.asarray(moment).reshape(len(motions), -1, 3)
    found = found / np.linalg.norm(found[:, :1], axis=-1, keepdims=True)
    return found[..., 2:] if motions.held else found


def case(name: str, make: Any, what: str, steps: float, sweep: tuple[str, float] | None = None) -> Case:
    """So many steps of one motion."""

    def inputs(rng: np.random.Generator, count: int) -> Long:
        return Long(make(np.random.default_rng(0), 1), int(steps), what)

    def describe(given: Long, i: int) -> str:
        return integrators.describe(given.motions, i)

    return Case(name, inputs, "ordinary", describe, sweep)


#: Bodies that are looked at for long.
TOPS = {
    "a free top": free(CUBOID, (1.5, 1.0, 2.0), 1.0),
    "a heavy top": heavy((0.2, 0.2, 0.1), (0.3, 0.2, 10.0), (0, 0, 0.5), 1.0),
}


def compiled(integrator: str) -> None:
    """One step of each, so that programs are there."""
    for make in TOPS.values():
        motions = make(np.random.default_rng(0), 1)
        integrators.ran(motions.simulation(integrator=integrator), STEP, [STEP], step=STEP)


def study(counts: Sequence[float] = COUNTS) -> Study:
    """The study for other numbers of steps: up to 1e6 is a matter of seconds for each method."""
    from ...dynamics.methods import INTEGRATORS

    methods = [
        Method(name, partial(drifted, integrator=name), most=1, repeats=0, prepare=partial(compiled, name))
        for name in (*INTEGRATORS, "auto")
    ]
    cases = []
    for body, make in TOPS.items():
        for what in ("energy", "momentum"):
            cases.append(case(f"{what} of {body}, {counts[-1]:g} steps", make, what, counts[-1]))
            cases += [
                case(f"{what} of {body}, {n:g} steps, swept", make, what, n, (f"steps, {what} of {body}", n))
                for n in counts
            ]
    return Study(
        name="drift",
        title="Energy and momentum over many steps",
        methods=tuple(methods),
        cases=tuple(cases),
        reference=lambda inputs: np.zeros(len(inputs)),
        error=error,
        unit="relative change",
        count=4,
        source="thesis 6.4 and 6.5",
        notes=f"Steps of {STEP} s; integrators that choose their own run as long, and auto as users get it who give "
        f"that step. The largest change at {STORES} times.",
    )


def error(answer: Array, exact: Array, inputs: Long) -> Errors:
    """The change itself; infinite once nothing is left."""
    found: Errors = np.where(answer < 1, answer - exact, np.inf)
    return found


STUDY = study()
