"""Simulations: a body or several, what acts on them and what holds them, run over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from . import engine, methods
from .assembly import Assembly, assemble
from .bodies import RigidBody
from .constraints import Constraint
from .given import finite, positive
from .trajectory import Trajectory

Array = NDArray[Any]


class Simulation:
    """A body with loads and constraints.

    Parameters
    ----------
    body : RigidBody
    loads : sequence of loads
    constraints : sequence of constraints
    integrator : str
        "auto", or one of `methods.INTEGRATORS`.
    map : {"exponential", "bortz", "cayley", "outer"}
        The chart of integrators that have one.
    stabilization : {"auto", "null-space", "projection", "baumgarte", "none"}
    """

    def __init__(
        self,
        body: RigidBody,
        loads: Sequence[Any] = (),
        constraints: Sequence[Constraint] = (),
        integrator: str = "auto",
        map: str = "exponential",  # the name of the contract
        stabilization: str = "auto",
        stabilisation: str | None = None,
    ) -> None:
        self.bodies, self.names = (body,), ("body",)
        self.loads, self.constraints = tuple(loads), tuple(constraints)
        self.integrator = methods.check(integrator, ("auto", *methods.INTEGRATORS), "integrator")
        self.map = methods.check(map, methods.MAPS, "map")
        self.stabilization = methods.check(stabilisation or stabilization, methods.STABILIZATIONS, "stabilization")

    def run(
        self,
        duration: float,
        step: float | None = None,
        times: Any = None,
        rtol: float | None = None,
        atol: float | None = None,
        threads: int | None = None,
    ) -> Trajectory:
        """The motion over some time."""
        duration = float(positive(duration, "the duration"))
        step = methods.STEP if step is None else float(positive(step, "the step"))
        stores = self._times(duration, step, times)
        null_space = self.stabilization in ("auto", "null-space")
        made = assemble(self.bodies, self.names, self.loads, self.constraints, duration, null_space)
        name = methods.chosen(self.integrator, made)
        adaptive = methods.INTEGRATORS[name] == "adaptive"
        tolerance = methods.RTOL if rtol is None else float(positive(rtol, "rtol"))
        method = methods.Method(name, duration if adaptive else step, tolerance, atol or 0.0)
        project = made.mode == "constrained" and self.stabilization in ("auto", "projection")
        baumgarte = 10.0 if self.stabilization == "baumgarte" else 0.0
        driver = engine.Driver(made, method, self.map, project, baumgarte)
        motors, twists = _start(made)
        run = engine.Run(driver, stores, motors, twists, threads)
        run.to(0, len(stores))
        driver._raise()
        return Trajectory(self, run)

    def _times(self, duration: float, step: float, times: Any) -> Array:
        if times is None:
            count = int(np.ceil(duration / step * (1 - 1e-12)))
            return np.concatenate([np.arange(count) * step, [duration]])
        found = finite(times, "times")
        if found.ndim != 1 or not len(found) or (np.diff(found) < 0).any() or found[0] < 0 or found[-1] > duration * (1 + 1e-12):
            raise InputError(f"times rise from 0 to the duration, {duration:.6g}.")
        return found if found[0] == 0 else np.concatenate([[0.0], found])


def _start(made: Assembly) -> tuple[Array, Array]:
    """Motors (n, bodies, 8) and twists (n, bodies, 6) in the driver's frames."""
    motors = np.empty((made.size, len(made.bodies), 8))
    twists = np.empty((made.size, len(made.bodies), 6))
    for i, (body, frame) in enumerate(zip(made.bodies, made.frames, strict=True)):
        motors[:, i] = frame.pose.as_kind("motor", check=False).values
        own = ~frame.own >> body.twist_in_body
        twists[:, i] = own.values if frame.allowed is None else np.where(frame.allowed, own.values, 0.0)
    return motors, twists
