"""Trajectories: what a simulation gives, states at times and what follows from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..core.multivector import Multivector
from ..mechanics.arguments import coefficients
from .exports import ENDINGS, TrajectoryExports
from .integration import driver
from .model.loads import Gravity, Load, Spring
from .results.states import TrajectoryStates
from .results.trajectory_data import OF_BODIES, SCREWS, TrajectoryData
from .sensitivity.gradients import Sensitivities, Sensitivity

Array = NDArray[Any]


class Trajectory(TrajectoryStates, TrajectoryExports):
    """States of one body, of a batch of them, or of several bodies, at times.

    Shapes below are those of one body and one simulation; a batch puts (n,) in front, several bodies give
    dictionaries by name through ``bodies``.

    Attributes
    ----------
    time : array (stores,)
    motor : Multivector (stores,)
        Body to world.
    position, velocity : array (stores, 3)
        Center of mass and its velocity, in the world.
    orientation : array (stores, 3, 3)
        Body to world.
    angular_velocity : array (stores, 3)
        Along the body's axes.
    momentum, reaction : Multivector (stores,)
        In the world, moments about its origin; the reaction is the wrench of all constraints together.
    energy : array (stores,)
        Kinetic, of gravity (zero at the world's origin) and of springs; other loads have none.
    violation : array (stores,)
        Largest error of a constraint's coefficients; for `VirtualPower`, which has none, the power that should be zero,
        as a fraction of the most that the bodies' kinetic energy allows.
    sensitivities : dict of str to `gradients.Sensitivity`
        Derivatives with respect to the parameters that were requested of the run.
    steps : int or array (n,)
        Number of steps taken.
    status : Status, or array (n,)
        OK; NOT_CONVERGED: it ended early, without an answer for later times; SINGULAR: the rank of the constraints
        changed; INVALID: a function failed, or the state is no longer finite.
    converged : bool, or array (n,)
        Whether the status is OK.
    ending : str, or array (n,)
        "ok", "event", or why it ended early, in two words; see ``message``.
    message : str
        Why it ended early, and when; of a batch, the first one that did. Empty otherwise, or the name of an event.
    integrator : str
    """

    def __init__(
        self, run: driver.Run, loads: Sequence[Load], message: str = "", slices: Mapping[str, slice] | None = None
    ) -> None:
        super().__init__(run)
        self._loads, self._slices = loads, slices or {}
        self.integrator = run.driver.method.name
        self.message = message

    def to_data(self) -> TrajectoryData:
        """Plain arrays of all bodies."""
        rows = {}
        for name, body in self.bodies.items():
            arrays = {key: np.asarray(getattr(body, key)) for key in OF_BODIES if key not in ("motor", *SCREWS)}
            arrays["motor"] = body.motor.as_kind("motor", check=False).values
            for key in SCREWS:
                arrays[key] = coefficients(getattr(body, key), "twist", key)
            rows[name] = arrays
        return TrajectoryData(
            self._assembly.algebra.name, self.time, rows, np.asarray(self.energy), np.asarray(self.violation),
            self.integrator, self.ending, self.message, self.steps,
        )  # fmt: skip

    @property
    def energy(self) -> Array:
        """Energy of all bodies: kinetic, of gravity (zero at the world's origin) and of springs."""
        bodies = list(self.bodies.values())
        total: Array = sum(body._kinetic() + body._potential() for body in bodies) + self._springs(bodies)
        return total

    def _kinetic(self) -> Array:
        energy = self._with_inertia("inertia.energy")
        return np.asarray(energy.values[..., 0] if isinstance(energy, Multivector) else energy)

    def _potential(self) -> Array:
        gravity = sum((g.acceleration for g in self._loads if isinstance(g, Gravity)), np.zeros(3))
        return np.asarray(
            -self._over_time(self._rigid_body.mass) * (self.position * self._over_time(gravity, 1)).sum(-1)
        )

    def _springs(self, bodies: Sequence[Self]) -> Array:
        total = np.zeros(())
        for spring in self._loads:
            if isinstance(spring, Spring):
                ends = [
                    self._position_of(bodies, body, point)
                    for body, point in ((spring.body, spring.point), (spring.other, spring.anchor))
                ]
                stretch = np.linalg.norm(ends[1] - ends[0], axis=-1) - self._over_time(spring.length)
                total = total + self._over_time(spring.stiffness) * stretch**2 / 2
        return total

    def _position_of(self, bodies: Sequence[Self], body: int | str | None, point: Array) -> Array:
        """Position over time of a point of a body, or of the world."""
        point = self._over_time(point, 1)
        if body is None:
            return point
        states = bodies[self._assembly.body_index(body, "a spring")]
        return np.asarray(np.einsum("...ij,...j->...i", states.orientation, point) + states.position)

    @property
    def sensitivities(self) -> Sensitivities:
        """Derivatives with respect to the requested parameters, by name (`gradients.Sensitivity`)."""
        return Sensitivities({name: Sensitivity(self, part) for name, part in self._slices.items()})

    @property
    def violation(self) -> Array:
        """Largest error of a constraint's coefficients, in the driver's world; `VirtualPower`: fraction of rates."""
        return self._array(self._run.violations)

    @property
    def steps(self) -> int | NDArray[np.int64]:
        """Number of steps taken."""
        return int(self._run.steps[0]) if self._single else self._run.steps

    @property
    def ending(self) -> str | NDArray[np.str_]:
        """Reason why it ended, or "ok"."""
        ending = np.array(list(ENDINGS))[self._run.status]
        return str(ending[0]) if self._single else ending

    def __repr__(self) -> str:
        end = self.time[-1] if len(self) else 0.0
        return f"<Trajectory: {len(self)} states to t = {end:.6g}, {self.integrator}, {self.steps} steps>"


__all__ = ["Trajectory"]
