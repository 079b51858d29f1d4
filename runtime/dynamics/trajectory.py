"""What a simulation gives: states at times, and what follows from them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import Numbers, call
from ..codegen.errors import InputError, suggest
from ..multivector import Multivector
from . import engine
from .bodies import RigidBody
from .gradients import Sensitivities, Sensitivity
from .loads import Gravity, Spring
from .outlets import Outlets

if TYPE_CHECKING:
    from .simulation import Simulation

Array = NDArray[Any]


#: How a simulation stands, by the driver's number (engine.py).
STATUSES = (
    "ok", "not finite", "step underflow", "rank changed", "function failed", "stopped", "event", "not solved",
    "constraints violated",
)  # fmt: skip


class Trajectory(Outlets):
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
        Largest error of a constraint's coefficients; of `VirtualPower`, which has none, the power that there should not
        be, as a share of the most that the bodies' kinetic energy allows.
    sensitivities : dict of str to `gradients.Sensitivity`
        Derivatives with respect to the parameters that the run was asked for.
    steps : int or array (n,)
        Taken.
    status : array (n,) of str
        "ok", or why it ended: see ``message``.
    message : str
    integrator : str
    """

    def __init__(
        self, simulation: Simulation, run: engine.Run, body: int = 0, places: dict[str, slice] | None = None
    ) -> None:
        self._simulation, self._run, self._body = simulation, run, body
        self._places = places or {}
        self._made = run.driver.made
        self._own: RigidBody = self._made.bodies[body]
        least = int(run.stored.min())
        self._cut = slice(0, least) if self._single else slice(0, int(run.stored.max()))
        self.time: Array = run.times[self._cut].copy()
        self.integrator = run.driver.method.name
        self.message = ""

    @property
    def _single(self) -> bool:
        return not self._made.batched

    def _array(self, values: Array) -> Array:
        """What is stored of (simulations, stores, ...): of one simulation without the first axis."""
        chosen = values[:, self._cut]
        return np.ascontiguousarray(chosen[0] if self._single else chosen)

    def _over_time(self, values: Array, trailing: int = 0) -> Array:
        """Numbers of simulations, (n, ...) or one for all, that go with states."""
        return values if values.ndim == trailing or self._single else values[:, None]

    @property
    def bodies(self) -> dict[str, Trajectory]:
        """Trajectories of all bodies, by name."""
        return {name: self[name] for name in self._made.names}

    def __getitem__(self, name: str) -> Trajectory:
        """That of one body of a system."""
        names = self._made.names
        if name not in names:
            raise InputError(f"there is no body {name!r}; there are: {', '.join(names)}.{suggest(name, names)}")
        found = Trajectory(self._simulation, self._run, names.index(name), self._places)
        found.message = self.message
        return found

    # -- states --------------------------------------------------------------------------------------------

    def _state(self) -> tuple[Multivector, Multivector]:
        run, body = self._run, self._body
        return self._made.to_user(body, self._array(run.motors[:, :, body]), self._array(run.twists[:, :, body]))

    @property
    def motor(self) -> Multivector:
        """Takes the body's frame (origin at the centre of mass) to the world's."""
        return self._state()[0]

    @property
    def twist(self) -> Multivector:
        """In the body's frame."""
        return self._state()[1]

    def _local(self) -> Multivector:
        """Poses in the driver's world, whose origin is near: places keep their digits."""
        algebra = self._made.algebra
        motors = algebra.wrap(algebra.kind("motor"), self._array(self._run.motors[:, :, self._body]))
        return (motors * ~self._beside(self._made.frames[self._body].own)).as_kind("motor", check=False)

    def _matrix(self) -> Array:
        return self._made.algebra.matrix(self._local())

    @property
    def position(self) -> Array:
        """Of the centre of mass, in the world."""
        return self._matrix()[..., :3, 3] + self._over_time(self._made.origin, 1)

    @property
    def orientation(self) -> Array:
        """Body to world."""
        return self._matrix()[..., :3, :3]

    def _velocities(self) -> tuple[Array, Array]:
        """Angular and linear, along the body's axes."""
        angular, linear = call(self._made.algebra, "mechanics.screw_vectors", self.twist).values
        return angular.values, linear.values

    @property
    def angular_velocity(self) -> Array:
        """Along the body's axes."""
        return self._velocities()[0]

    @property
    def velocity(self) -> Array:
        """Of the centre of mass, in the world."""
        found: Array = np.einsum("...ij,...j->...i", self.orientation, self._velocities()[1])
        return found

    # -- what follows --------------------------------------------------------------------------------------

    def _inertia(self, formula: str) -> Any:
        """What a formula of the body's inertia says of its twists."""
        algebra, own = self._made.algebra, self._own
        axes = self._beside(algebra.motor_from_matrix(own.axes).as_kind("motor", check=False))
        mass, moments = self._over_time(own.mass), algebra.vector(self._over_time(own.moments, 1), "the moments")
        return call(algebra, formula, axes, Numbers(mass, 0, "the mass"), moments, self.twist).value

    def _beside(self, motor: Multivector) -> Multivector:
        """A motor of each simulation, or of all, beside states."""
        return motor if motor.shape == () or self._single else motor.reshape(-1, 1)

    @property
    def momentum(self) -> Multivector:
        """In the world, moments about its origin."""
        local: Multivector = self._local() >> self._inertia("mechanics.momentum_in")  # near: it keeps its digits
        return self._beside(self._made.shift) >> local

    @property
    def energy(self) -> Array:
        """Of all bodies: kinetic, of gravity (zero at the world's origin) and of springs."""
        each = list(self.bodies.values())
        total: Array = sum(own._kinetic() + own._potential() for own in each) + self._springs(each)
        return total

    def _kinetic(self) -> Array:
        found = self._inertia("inertia.energy")
        return np.asarray(found.values[..., 0] if isinstance(found, Multivector) else found)

    def _potential(self) -> Array:
        gravity = sum((g.acceleration for g in self._simulation.loads if isinstance(g, Gravity)), np.zeros(3))
        return np.asarray(-self._over_time(self._own.mass) * (self.position * self._over_time(gravity, 1)).sum(-1))

    def _springs(self, bodies: Sequence[Trajectory]) -> Array:
        total = np.zeros(())
        for spring in self._simulation.loads:
            if isinstance(spring, Spring):
                ends = [
                    self._place(bodies, b, x) for b, x in ((spring.body, spring.point), (spring.other, spring.anchor))
                ]
                stretch = np.linalg.norm(ends[1] - ends[0], axis=-1) - self._over_time(spring.length)
                total = total + self._over_time(spring.stiffness) * stretch**2 / 2
        return total

    def _place(self, bodies: Sequence[Trajectory], body: int | str | None, point: Array) -> Array:
        """A point of a body, or of the world, over time."""
        point = self._over_time(point, 1)
        if body is None:
            return point
        own = bodies[self._made.which(body, "a spring")]
        return np.asarray(np.einsum("...ij,...j->...i", own.orientation, point) + own.position)

    @property
    def reaction(self) -> Multivector:
        """The wrench of all constraints on the body, in the world, moments about its origin."""
        made = self._made
        rows = self._array(self._run.reactions[:, :, self._body])
        local = made.algebra.wrap(made.algebra.kind("twist"), rows)
        moved: Multivector = self._beside(made.shift) >> local
        return moved

    @property
    def sensitivities(self) -> Sensitivities:
        """Derivatives with respect to the parameters that the run was asked for, by name (`gradients.Sensitivity`)."""
        return Sensitivities({name: Sensitivity(self, place) for name, place in self._places.items()})

    @property
    def violation(self) -> Array:
        """Largest error of a constraint's coefficients, in the driver's world; of `VirtualPower` a share of rates."""
        return self._array(self._run.violations)

    @property
    def steps(self) -> Any:
        """Taken."""
        return int(self._run.steps[0]) if self._single else self._run.steps

    @property
    def status(self) -> Any:
        """How it ended."""
        found = np.array(STATUSES)[self._run.status]
        return str(found[0]) if self._single else found

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        end = self.time[-1] if len(self) else 0.0
        return f"<Trajectory: {len(self)} states to t = {end:.6g}, {self.integrator}, {self.steps} steps>"
