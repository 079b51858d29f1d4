"""States of bodies over time in the user's frames, from those that the driver stored in its own."""

from __future__ import annotations

from copy import copy
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Multivector
from ...dispatch.formulas import ArrayOperand, evaluate
from ...mechanics.rigid_body import RigidBody
from ..integration import runs
from .trajectory_data import no_body, several_bodies

Array = NDArray[Any]


class TrajectoryStates:
    """Poses and velocities of one body of a run; of several bodies ``bodies`` holds those of each.

    Shapes are those of one simulation; a batch puts (n,) in front.

    Parameters
    ----------
    run : runs.Run
    """

    def __init__(self, run: runs.Run) -> None:
        self._run, self._assembly = run, run.driver.assembly
        self._chosen: int | None = None if len(self._assembly.names) > 1 else 0
        stored = run.stored
        self._stored = slice(0, stored.item(0) if self._single else int(stored.max()))
        self.time: Array = run.times[self._stored].copy()

    @property
    def _single(self) -> bool:
        return not self._assembly.batched

    @property
    def _body(self) -> int:
        """Index of the body."""
        if self._chosen is None:
            raise several_bodies(self._assembly.names)
        return self._chosen

    @property
    def _rigid_body(self) -> RigidBody:
        return self._assembly.bodies[self._body]

    def _array(self, values: Array) -> Array:
        """Stored part of (simulations, stores, ...), contiguous; of one simulation without the first axis."""
        stored = values[:, self._stored]
        return np.ascontiguousarray(stored[0] if self._single else stored)

    def _over_time(self, values: Array, trailing: int = 0) -> Array:
        """Values of each simulation, (n, ...) or one for all, with an axis for the states."""
        return values if values.ndim == trailing or self._single else values[:, None]

    def _motor_over_time(self, motor: Multivector) -> Multivector:
        """Motors of each simulation, (n,) or one for all, with an axis for the states."""
        return motor if motor.shape == () or self._single else motor.reshape(-1, 1)

    @property
    def bodies(self) -> dict[str, Self]:
        """Trajectories of all bodies, by name."""
        return {name: self[name] for name in self._assembly.names}

    def __getitem__(self, name: str) -> Self:
        """Trajectory of one body of a system."""
        names = self._assembly.names
        if name not in names:
            raise no_body(name, names)
        other = copy(self)
        other._chosen, other.time = names.index(name), self._run.times[self._stored].copy()
        return other

    # -- states --------------------------------------------------------------------------------------------

    def _state(self) -> tuple[Multivector, Multivector]:
        run, body = self._run, self._body
        return self._assembly.to_user(body, self._array(run.motors[:, :, body]), self._array(run.twists[:, :, body]))

    @property
    def motor(self) -> Multivector:
        """Takes the body's frame (origin at the center of mass) to the world's."""
        return self._state()[0]

    @property
    def twist(self) -> Multivector:
        """In the body's frame."""
        return self._state()[1]

    def _local(self) -> Multivector:
        """Poses in the driver's world, whose origin is near: positions keep their digits."""
        algebra = self._assembly.algebra
        motors = algebra.wrap(algebra.kind("motor"), self._array(self._run.motors[:, :, self._body]))
        to_body = self._motor_over_time(self._assembly.frames[self._body].to_body)
        return (motors * ~to_body).as_kind("motor", check=False)

    def _matrix(self) -> Array:
        return self._assembly.algebra.matrix(self._local())

    @property
    def position(self) -> Array:
        """Center of mass, in the world."""
        return self._matrix()[..., :3, 3] + self._over_time(self._assembly.origin, 1)

    @property
    def orientation(self) -> Array:
        """Body to world."""
        return self._matrix()[..., :3, :3]

    def _velocities(self) -> tuple[Array, Array]:
        """Angular and linear, along the body's axes."""
        angular, linear = evaluate(self._assembly.algebra, "mechanics.screw_vectors", self.twist).values
        return angular.values, linear.values

    @property
    def angular_velocity(self) -> Array:
        """Along the body's axes."""
        return self._velocities()[0]

    @property
    def velocity(self) -> Array:
        """Velocity of the center of mass, in the world."""
        linear: Array = np.einsum("...ij,...j->...i", self.orientation, self._velocities()[1])
        return linear

    def _with_inertia(self, formula: str) -> Any:
        """Value of a formula of the body's mass, moments and twist, such as its momentum."""
        algebra, body = self._assembly.algebra, self._rigid_body
        axes = self._motor_over_time(algebra.motor_from_matrix(body.axes).as_kind("motor", check=False))
        mass, moments = self._over_time(body.mass), algebra.spatial(self._over_time(body.moments, 1), "the moments")
        return evaluate(algebra, formula, axes, ArrayOperand(mass, 0, "the mass"), moments, self.twist).value

    @property
    def momentum(self) -> Multivector:
        """In the world, moments about its origin."""
        local: Multivector = self._local() >> self._with_inertia("mechanics.momentum_in")  # near: it keeps its digits
        return self._motor_over_time(self._assembly.shift) >> local

    @property
    def reaction(self) -> Multivector:
        """Wrench of all constraints on the body, in the world, moments about its origin."""
        assembly = self._assembly
        rows = self._array(self._run.reactions[:, :, self._body])
        local = assembly.algebra.wrap(assembly.algebra.kind("twist"), rows)
        wrench: Multivector = self._motor_over_time(assembly.shift) >> local
        return wrench

    def __len__(self) -> int:
        return len(self.time)


__all__ = ["TrajectoryStates"]
