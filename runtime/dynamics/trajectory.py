"""What a simulation gives: states at times, and what follows from them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import call
from ..codegen.errors import InputError, suggest
from ..multivector import Multivector
from . import engine
from .bodies import RigidBody
from .loads import Gravity, Spring

if TYPE_CHECKING:
    from .simulation import Simulation

Array = NDArray[Any]


class Trajectory:
    """States of one body, of a batch of them, or of several bodies, at times.

    Shapes below are those of one body and one simulation; a batch puts (n,) in front, several bodies give
    dictionaries by name through ``bodies``.

    Attributes
    ----------
    time : array (stores,)
    motor : Multivector (stores,)
        Body to world.
    position, velocity : array (stores, 3)
        Of the centre of mass, in the world.
    orientation : array (stores, 3, 3)
        Body to world.
    angular_velocity : array (stores, 3)
        Along the body's axes.
    momentum, reaction : Multivector (stores,)
        In the world, moments about its origin; the reaction is the wrench of all constraints together.
    energy : array (stores,)
        Kinetic, of gravity (zero at the world's origin) and of springs; of other loads there is none.
    violation : array (stores,)
        Largest error of a constraint's coefficients.
    steps : int or array (n,)
        Taken.
    status : array (n,) of str
        "ok", or why it ended: see ``message``.
    message : str
    integrator : str
    """

    def __init__(self, simulation: Simulation, run: engine.Run, body: int = 0) -> None:
        self._simulation, self._run, self._body = simulation, run, body
        self._made = run.driver.made
        self._own: RigidBody = self._made.bodies[body]
        least = int(run.stored.min())
        self._cut = slice(0, least) if self._single else slice(0, int(run.stored.max()))
        self.time: Array = run.times[self._cut].copy()
        self.integrator = run.driver.method.name
        self.message = ""

    @property
    def _single(self) -> bool:
        return self._made.size == 1

    def _array(self, values: Array) -> Array:
        chosen = values[:, self._cut]
        return chosen[0] if self._single else chosen

    @property
    def bodies(self) -> dict[str, Trajectory]:
        """Trajectories of all bodies, by name."""
        return {name: Trajectory(self._simulation, self._run, i) for i, name in enumerate(self._made.names)}

    @property
    def _state(self) -> tuple[Multivector, Multivector]:
        motors, twists = (self._run.motors[:, :, self._body], self._run.twists[:, :, self._body])
        return self._made.to_user(self._body, np.ascontiguousarray(self._array(motors)), np.ascontiguousarray(self._array(twists)))

    @property
    def motor(self) -> Multivector:
        return self._state[0]

    @property
    def twist(self) -> Multivector:
        """In the body's frame (origin at the centre of mass)."""
        return self._state[1]

    def _matrix(self) -> Array:
        """In the driver's world, of the body's frame."""
        algebra = self._made.algebra
        own = self._made.frames[self._body].own
        motors = np.ascontiguousarray(self._array(self._run.motors[:, :, self._body]))
        if own.shape:
            own = own.reshape(own.shape[0], 1)
        return algebra.matrix((algebra.wrap(algebra.kind("motor"), motors) * ~own).as_kind("motor", check=False))

    @property
    def position(self) -> Array:
        origin = self._made.origin
        return self._matrix()[..., :3, 3] + (origin if origin.ndim == 1 else origin[:, None])

    @property
    def orientation(self) -> Array:
        return self._matrix()[..., :3, :3]

    def _velocities(self) -> tuple[Array, Array]:
        found = call(self._made.algebra, "mechanics.screw_vectors", self.twist).values
        return found[0].values, found[1].values

    @property
    def angular_velocity(self) -> Array:
        return self._velocities()[0]

    @property
    def velocity(self) -> Array:
        return np.einsum("...ij,...j->...i", self.orientation, self._velocities()[1])

    @property
    def momentum(self) -> Multivector:
        made, body = self._made, self._own
        motor, twist = self._state
        place = self._run.driver.made
        del place
        mass = np.asarray(body.mass)[..., None] if np.ndim(body.mass) else body.mass
        linear = np.asarray(mass)[..., None] * self.velocity
        spin = self._tensor(self.angular_velocity)
        angular = np.einsum("...ij,...j->...i", self.orientation, spin) + np.cross(self.position, linear)
        algebra = made.algebra
        moved: Multivector = call(algebra, "mechanics.screw_of", algebra.vector(linear, "p"), algebra.vector(angular, "L")).value
        return moved

    def _tensor(self, omega: Array) -> Array:
        """I w along the body's axes."""
        axes, moments = self._own.axes, self._own.moments
        tensor = np.einsum("...ij,...j,...kj->...ik", axes, moments, axes)
        if tensor.ndim == 3:
            tensor = tensor[:, None]
        return np.einsum("...ij,...j->...i", tensor, omega)

    @property
    def energy(self) -> Array:
        total = np.zeros(())
        for each in self.bodies.values():
            total = total + each._kinetic() + each._potential()
        return total + self._springs()

    def _kinetic(self) -> Array:
        omega, v = self._velocities()
        mass = np.asarray(self._own.mass)
        found: Array = (mass[..., None] if mass.ndim else mass) * (v * v).sum(-1) / 2 + (omega * self._tensor(omega)).sum(-1) / 2
        return found

    def _potential(self) -> Array:
        gravity = sum((g.acceleration for g in self._simulation.loads if isinstance(g, Gravity)), np.zeros(3))
        mass = np.asarray(self._own.mass)
        gravity = gravity[:, None] if gravity.ndim == 2 else gravity
        return -(mass[..., None] if mass.ndim else mass) * (self.position * gravity).sum(-1)

    def _springs(self) -> Array:
        total: Array = np.zeros(())
        for spring in self._simulation.loads:
            if isinstance(spring, Spring):
                ends = [self._place(spring.body, spring.point), self._place(spring.other, spring.anchor)]
                gap = np.linalg.norm(ends[1] - ends[0], axis=-1)
                parts = [x[:, None] if np.ndim(x) else x for x in (spring.stiffness, spring.length)]
                total = total + parts[0] * (gap - parts[1]) ** 2 / 2
        return total

    def _place(self, body: int | str | None, point: Array) -> Array:
        point = point[:, None] if point.ndim == 2 else point
        if body is None:
            return point
        own = list(self.bodies.values())[body] if isinstance(body, int) else self.bodies[body]
        return np.einsum("...ij,...j->...i", own.orientation, point) + own.position

    @property
    def reaction(self) -> Multivector:
        made = self._made
        rows = np.ascontiguousarray(self._array(self._run.reactions[:, :, self._body]))
        local = made.algebra.wrap(made.algebra.kind("twist"), rows)
        shift = made.shift if made.shift.shape == () else made.shift.reshape(made.size, 1)
        return shift >> local

    @property
    def violation(self) -> Array:
        return self._array(self._run.violations)

    @property
    def steps(self) -> Any:
        return int(self._run.steps[0]) if self._single else self._run.steps

    @property
    def status(self) -> Any:
        names = np.array(["ok", "not finite", "step underflow", "rank changed", "function failed", "stopped", "event", "not solved"])
        found = names[self._run.status]
        return str(found[0]) if self._single else found

    def __getitem__(self, name: str) -> Trajectory:
        """That of one body of a system."""
        if name not in self._made.names:
            raise InputError(f"there is no body {name!r}; there are: {', '.join(self._made.names)}.{suggest(name, self._made.names)}")
        return Trajectory(self._simulation, self._run, self._made.names.index(name))

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        return f"<Trajectory: {len(self)} states to t = {self.time[-1] if len(self) else 0:.6g}, {self.integrator}, {self.steps} steps>"
