"""Trajectories: what a simulation gives, states at times and what follows from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..core.multivector import Multivector
from ..mechanics.arguments import coefficients
from ..mechanics.joints.base import Joint
from ..mechanics.system import System
from .exports import ENDINGS, TrajectoryExports
from .integration import runs
from .model.joint_loads import JointLimit, JointLoad, JointSpring
from .model.loads import Gravity, Load, Spring
from .results.joint_states import JointMotion, reaction_of_joint
from .results.states import TrajectoryStates
from .results.trajectory_data import OF_BODIES, SCREWS, TrajectoryData
from .sensitivity.gradients import Sensitivities, Sensitivity
from .trees.driver import TreeRun

Array = NDArray[Any]
#: Independent fraction of a constraint below which a pose is singular or nearly so.
CLEAR = 1e-3


class Trajectory(TrajectoryStates, TrajectoryExports):
    """States of one body, of a batch of them, or of several bodies, at times.

    Shapes below are those of one body and one simulation; a batch puts (n,) in front. Of several bodies
    ``trajectory["name"]`` is the trajectory of one, and ``bodies`` has all by name: without a name, poses, velocities,
    momenta and reactions raise `InputError`.

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
    energy, kinetic_energy, potential_energy : array (stores,)
        Of all bodies together, in units of mass length^2 / time^2: joules where these are kg, m and s. The potential
        energy is that of gravity (zero at the world's origin), of springs and of joint limits; other loads have none.
    violation : array (stores,)
        Largest error of a constraint's coefficients; for `VirtualPower`, which has none, the power that should be zero,
        as a fraction of the most that the bodies' kinetic energy allows.
    sensitivities : dict of str to `gradients.Sensitivity`
        Derivatives with respect to the parameters that were requested of the run.
    steps : int or array (n,)
        Number of steps taken.
    singular_time : float, or array (n,)
        When the constraints came nearest to depending on each other, so that there were more freedoms for a moment; NaN
        if they stayed clear of that. Motions go through such poses, with less accuracy.
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
        self, run: runs.Run, loads: Sequence[Load], message: str = "", slices: Mapping[str, slice] | None = None,
        system: System | None = None,
    ) -> None:  # fmt: skip
        super().__init__(run)
        self._loads, self._slices, self._system = loads, slices or {}, system
        self.integrator = run.driver.method.name
        self.message = message

    @property
    def _joints(self) -> System:
        """The system whose joints are asked about."""
        if self._system is None:
            raise InputError("the simulation is of one body, and has no joints.")
        return self._system

    def coordinates(self, joint: Joint | str | int) -> Array:
        """Coordinates of a joint of the system: displacements of its second body against its first.

        Parameters
        ----------
        joint : Joint, str or int
            One of the system's joints, its name or its index.

        Returns
        -------
        array (stores,) or (stores, k)
            Radians and lengths, from the system's ``joint_coordinates`` on. Of k freedoms translations come first; a
            spherical joint has a rotation vector. Other angles go on beyond half a turn.

        Raises
        ------
        InputError
            If there is no such joint, or it has no coordinates, as `Bilinear`.
        """
        index = self._joints.joint_index(joint)
        found = self._freedoms_of(index, 0)
        total: Array = found + self._joints.joint_coordinates[index]  # zero of joints with several freedoms
        return total

    def rates(self, joint: Joint | str | int) -> Array:
        """Speeds of a joint's coordinates, in the shape of `coordinates`.

        Those of a spherical joint are the relative angular velocity, along axes that move with the second body and were
        the world's at the start.
        """
        return self._freedoms_of(self._joints.joint_index(joint), 1)

    def _freedoms_of(self, index: int, which: int) -> Array:
        """Coordinates (0) or rates (1) of a joint."""
        run = self._run
        found = run.of_joint(index, which) if isinstance(run, TreeRun) else None
        if found is None:
            motion = JointMotion(self._joints, index, self.bodies)
            values = motion.rates() if which else motion.coordinates()
        else:
            values = self._array(found)
        return values[..., 0] if values.shape[-1] == 1 else values

    def reactions(self, joint: Joint | str | int) -> Multivector:
        """Wrench (stores,) of a joint on its second body, in the world, moments about its origin.

        Forces and torques of loads along the joint are no part of it.

        Raises
        ------
        InputError
            If the joint is in a loop, whose joints share their reactions, or the simulation has other constraints.
        """
        return reaction_of_joint(self._joints, self._joints.joint_index(joint), self.bodies)

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
        """Energy of all bodies: `kinetic_energy` and `potential_energy`."""
        return self.kinetic_energy + self.potential_energy

    @property
    def kinetic_energy(self) -> Array:
        """Kinetic energy of all bodies, of their translation and rotation."""
        total: Array = sum((body._kinetic() for body in self.bodies.values()), np.zeros(()))
        return total

    @property
    def potential_energy(self) -> Array:
        """Energy of all bodies in gravity (zero at the world's origin), of springs and limits."""
        bodies = list(self.bodies.values())
        total: Array = sum((body._potential() for body in bodies), self._springs(bodies))
        for load in self._loads:
            if isinstance(load, (JointSpring, JointLimit)):
                values = self.coordinates(load.joint)
                total = total + load.energy(values if self._joints_have_one(load) else values[..., load.freedom])
        return total

    def _joints_have_one(self, load: JointLoad) -> bool:
        """Whether a load's joint has one freedom, so that coordinates have no axis for it."""
        return self._joints.joints[self._joints.joint_index(load.joint)].mobility == 1

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
    def singular_time(self) -> float | Array:
        """When a mechanism was in, or nearest to, a singular pose; NaN if it met none."""
        fraction, time = self._run.singular.T
        found = np.where((fraction > 0) & (fraction < CLEAR), time, np.nan)
        return float(found[0]) if self._single else found

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
