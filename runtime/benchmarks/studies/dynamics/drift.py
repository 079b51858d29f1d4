"""Drift of conserved quantities: energy and momentum over many steps, by integrator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from .... import dynamics
from ....dynamics.integration.integrators import INTEGRATORS
from ...harness.study import Array, Case, Method, Study, lost_beyond
from . import integrators
from .integrators import GRAVITY, Motions
from .tops import CUBOID, free, heavy

#: Step of methods that do not choose their own; number of times at which the motion is stored; steps of a run.
STEP, STORES = 0.01, 100
COUNTS = (100.0, 1e3, 1e4)


@dataclass(frozen=True)
class LongRun:
    """A long run.

    Attributes
    ----------
    motions : Motions
    steps : int
    quantity : {"energy", "momentum"}
        Conserved quantity.
    """

    motions: Motions
    steps: int
    quantity: str

    def __len__(self) -> int:
        return len(self.motions)


def largest_drift(inputs: LongRun, setting: Any, *, integrator: str) -> Array | None:
    """Largest relative change on the way; infinite if the end was not reached."""
    motions, duration = inputs.motions, inputs.steps * STEP
    simulation = motions.simulation(integrator=integrator)
    times = np.linspace(0, duration, STORES + 1)
    trajectory = integrators.run_if_possible(simulation, duration, times, step=STEP)
    if trajectory is None:
        return None
    if len(trajectory.time) <= STORES:
        return np.full(len(inputs), np.inf)
    value = energy(motions, trajectory) if inputs.quantity == "energy" else momentum(motions, trajectory)
    return np.asarray(np.linalg.norm(value - value[:, :1], axis=-1).max(1))


def energy(motions: Motions, trajectory: Any) -> Array:
    """Energy in units of the initial kinetic energy, and of the weight at the arm's end: (n, times, 1)."""
    kinetic = (motions.moments * motions.spin**2).sum(1) / 2
    lever = motions.mass * np.linalg.norm(motions.arm, axis=1) * np.linalg.norm(GRAVITY)
    return np.asarray(trajectory.energy.reshape(len(motions), -1, 1) / (kinetic + lever)[:, None, None])


def momentum(motions: Motions, trajectory: Any) -> Array:
    """The moment of momentum about the origin, of its size at the start; of bodies with weight its vertical part."""
    _, moment = dynamics.wrench_parts(trajectory.momentum)
    moments = np.asarray(moment).reshape(len(motions), -1, 3)
    moments = np.asarray(moments / np.linalg.norm(moments[:, :1], axis=-1, keepdims=True))
    return moments[..., 2:] if motions.held else moments


#: Bodies of long runs.
TOPS = {
    "a free top": partial(free, moments=CUBOID, spin=(1.5, 1.0, 2.0), duration=1.0),
    "a heavy top": partial(heavy, moments=(0.2, 0.2, 0.1), spin=(0.3, 0.2, 10.0), duration=1.0),
}


def long_run(_: np.random.Generator, count: int, body: str, quantity: str, steps: float) -> LongRun:
    """A long run of one motion."""
    return LongRun(TOPS[body](np.random.default_rng(0), 1), int(steps), quantity)


def compile_integrator(integrator: str) -> None:
    """Run one step of each, so that its programs are compiled."""
    for make in TOPS.values():
        motions = make(np.random.default_rng(0), 1)
        integrators.run_if_possible(motions.simulation(integrator=integrator), STEP, [STEP], step=STEP)


def study(counts: Sequence[float] = COUNTS) -> Study:
    """The study for other numbers of steps: up to 1e6 is a matter of seconds for each method."""
    cases = []
    for body in TOPS:
        for quantity in ("energy", "momentum"):
            subject, make = f"{quantity} of {body}", partial(long_run, body=body, quantity=quantity)
            cases.append(Case(f"{subject}, {counts[-1]:g} steps", partial(make, steps=counts[-1])))
            cases += [
                Case(f"{subject}, {n:g} steps, swept", partial(make, steps=n), sweep=(f"steps, {subject}", n))
                for n in counts
            ]
    return Study(
        name="drift",
        title="Energy and momentum over many steps",
        methods=tuple(
            Method(
                name, partial(largest_drift, integrator=name), most=1, repeats=0,
                prepare=partial(compile_integrator, name),
            )
            for name in (*INTEGRATORS, "auto")
        ),
        cases=tuple(cases),
        reference=lambda inputs: np.zeros(len(inputs)),
        error=lambda answer, exact, _: lost_beyond(answer, 1.0),  # the change itself; infinite once nothing is left
        describe=lambda inputs, i: integrators.describe(inputs.motions, i),
        unit="relative change",
        count=4,
        source="thesis 6.4 and 6.5",
        notes=f"Steps of {STEP} s; integrators that choose their own run as long, and auto as users get it who give "
        f"that step. The largest change at {STORES} times.",
    )  # fmt: skip


STUDY = study()
