"""Derivatives of a trajectory by parameters: the driver's tangents in the user's terms."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.dynamics.records import SPRING_ENDS, Body, Spring
from ...codegen.errors import InputError, suggest
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ..assembly.data import Assembly
from ..results.states import TrajectoryStates
from .parameters import Directions

Array = NDArray[Any]


class Sensitivities(dict[str, "Sensitivity"]):
    """Sensitivities by the names of the parameters."""

    def __missing__(self, name: str) -> Sensitivity:
        raise InputError(
            f"no sensitivity to {name!r} was requested.{suggest(name, self)}",
            remedy="Name it in run(sensitivities=[..])",
        )


class Sensitivity:
    """Derivatives of a body's trajectory with respect to the k components of a parameter, at its stored times.

    Shapes are those of one simulation; a batch puts (n,) in front. Of several bodies ``sensitivity["name"]`` is that
    of one; ``energy`` and ``time`` are of all.

    Attributes
    ----------
    motor : Multivector (stores, k)
        Twist delta, in the body's frame, that moves the pose: dR = -R delta/2.
    orientation : array (stores, k, 3)
        Rotation vector along the body's axes: the angular part of the same twist.
    position, velocity : array (stores, k, 3)
        Center of mass and its velocity, in the world.
    angular_velocity : array (stores, k, 3)
        Along the body's axes.
    energy : array (stores, k)
        Energy of all bodies.
    time : array (stores, k)
        Of the stored times: zero but for that of an event, with which the state there changes too.
    """

    def __init__(self, trajectory: TrajectoryStates, part: slice) -> None:
        self._trajectory, self._part = trajectory, part

    def __getitem__(self, body: str) -> Sensitivity:
        """Derivatives of the trajectory of one body of a system."""
        return Sensitivity(self._trajectory[body], self._part)

    @property
    def _assembly(self) -> Assembly:
        return self._trajectory._assembly

    @property
    def _directions(self) -> Directions:
        directions = self._trajectory._run.driver.directions
        assert directions is not None  # the run has sensitivities
        return directions

    def _tangents(self, body: int) -> tuple[Array, Array]:
        """Tangents of pose and twist (..., stores, k, 6), in the driver's frame."""
        run = self._trajectory._run
        sizes = self._directions.sizes[:, None, self._part, None, None]
        tangents = self._trajectory._array(run.tangents[:, :, self._part, :, body] / sizes)
        return np.ascontiguousarray(tangents[..., 0, :]), np.ascontiguousarray(tangents[..., 1, :])

    def _screws(self, values: Array) -> Multivector:
        """Twists in the body's frame, from coefficients in the driver's."""
        to_body = self._assembly.frames[self._trajectory._body].to_body
        if to_body.shape:
            to_body = to_body.reshape(to_body.shape[0], *[1] * (values.ndim - 2))
        twists: Multivector = to_body >> self._assembly.algebra.wrap(self._assembly.algebra.kind("twist"), values)
        return twists

    def _vectors(self, twist: Multivector) -> tuple[Array, Array]:
        angular, linear = evaluate(self._assembly.algebra, "mechanics.screw_vectors", twist).values
        return angular.values, linear.values

    @property
    def motor(self) -> Multivector:
        return self._screws(self._tangents(self._trajectory._body)[0])

    @property
    def orientation(self) -> Array:
        return self._vectors(self.motor)[0]

    @property
    def position(self) -> Array:
        return self._to_world(self._vectors(self.motor)[1])

    @property
    def angular_velocity(self) -> Array:
        return self._vectors(self._screws(self._tangents(self._trajectory._body)[1]))[0]

    @property
    def velocity(self) -> Array:
        linear = self._vectors(self._trajectory.twist)[1][..., None, :]
        change = self._vectors(self._screws(self._tangents(self._trajectory._body)[1]))[1]
        return self._to_world(change + np.cross(self.orientation, linear))

    def _to_world(self, x: Array) -> Array:
        """Vectors (..., k, 3) along the body's axes, expressed in the world."""
        rotated: Array = np.einsum("...ij,...kj->...ki", self._trajectory.orientation, x)
        return rotated

    @property
    def time(self) -> Array:
        run = self._trajectory._run
        found: Array = np.zeros(self.energy.shape)
        if run.event_tangents[self._part].any():
            found[-1] = run.event_tangents[self._part] / self._directions.sizes[0, self._part]
        return found

    # -- energy --------------------------------------------------------------------------------------------

    @property
    def energy(self) -> Array:
        total: Array = np.zeros(())
        for i, each in enumerate(self._trajectory.bodies.values()):
            sensitivity = Sensitivity(each, self._part)
            total = total + sensitivity._kinetic(i) + sensitivity._potential(i)
        for i in range(len(self._assembly.springs)):
            total = total + self._spring(i)
        return total

    def _numbers(self, begin: int, count: int) -> tuple[Array, Array]:
        """Parameters (.., 1, 1, count) of the driver and their tangents (.., 1, k, count)."""
        directions = self._directions
        value = self._assembly.parameters[:, None, None, begin : begin + count]
        change = directions.numbers[:, None, self._part, begin : begin + count]
        return (value[0], change[0]) if self._trajectory._single else (value, change)

    def _body_parameter(self, i: int, name: str) -> tuple[Array, Array]:
        offset, count = Body.extent(name)
        return self._numbers(Body.size * i + offset, count)

    def _kinetic(self, i: int) -> Array:
        """Derivative of Omega . M Omega/2."""
        matrix, change = (x.reshape(*x.shape[:-1], 6, 6) for x in self._body_parameter(i, "mass"))
        omega = self._trajectory._array(self._trajectory._run.twists[:, :, i])[..., None, :]
        d_omega = self._tangents(i)[1]
        momentum = np.einsum("...ij,...j->...i", matrix, omega)
        energy: Array = (momentum * d_omega).sum(-1) + np.einsum("...i,...ij,...j->...", omega, change, omega) / 2
        return energy

    def _potential(self, i: int) -> Array:
        """Derivative of -m g . x."""
        weight, change = self._body_parameter(i, "weight")
        energy: Array = -(change * self._trajectory.position[..., None, :]).sum(-1) - (weight * self.position).sum(-1)
        return energy

    def _spring(self, i: int) -> Array:
        """Derivative of stiffness (distance - length)^2/2."""
        (first, d_first), (second, d_second) = (self._end(i, end) for end in range(2))
        offset = Spring.size * i + Spring.offsets["stiffness"]
        numbers, changes = self._numbers(self._assembly.spring_offset + offset, 2)
        gap, d_gap = second - first, d_second - d_first
        distance = np.linalg.norm(gap, axis=-1)
        along = (gap * d_gap).sum(-1)
        d_distance = np.divide(along, distance, out=np.zeros_like(along), where=distance > 0)
        stretch = distance - numbers[..., 1]
        energy: Array = changes[..., 0] * stretch**2 / 2 + numbers[..., 0] * stretch * (d_distance - changes[..., 1])
        return energy

    def _end(self, i: int, end: int) -> tuple[Array, Array]:
        """End of a spring in the driver's world (..., stores, 1, 3), and its tangents."""
        body = self._assembly.springs[i][end]
        offset = Spring.size * i + Spring.offsets[SPRING_ENDS[end]]
        point, change = self._numbers(self._assembly.spring_offset + offset, 3)
        if body < 0:
            return point, change
        algebra, run = self._assembly.algebra, self._trajectory._run
        motors = np.ascontiguousarray(self._trajectory._array(run.motors[:, :, body]))
        matrix = algebra.matrix(algebra.wrap(algebra.kind("motor"), motors))[..., None, :, :]
        rotation, translation = self._vectors(algebra.wrap(algebra.kind("twist"), self._tangents(body)[0]))
        tangent = np.cross(rotation, point) + translation + change
        position = np.einsum("...ij,...j->...i", matrix[..., :3, :3], point) + matrix[..., :3, 3]
        return position, np.einsum("...ij,...j->...i", matrix[..., :3, :3], tangent)
