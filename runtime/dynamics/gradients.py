"""What a trajectory's states change by where a parameter does: the driver's tangents in the user's terms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import call
from ..codegen.errors import InputError, suggest
from ..multivector import Multivector
from .assembly import BODY, PLACES, SPRING, Assembly

if TYPE_CHECKING:
    from .trajectory import Trajectory

Array = NDArray[Any]


class Sensitivities(dict[str, "Sensitivity"]):
    """Sensitivities by the names that were asked for."""

    def __missing__(self, name: str) -> Sensitivity:
        raise InputError(
            f"no sensitivity to {name!r} was asked for.{suggest(name, self)}", remedy="Name it in run(sensitivities=[..])"
        )


class Sensitivity:
    """Derivatives of a body's trajectory with respect to the k components of a parameter, at fixed times.

    Shapes are those of one simulation; a batch puts (n,) in front.

    Attributes
    ----------
    motor : Multivector (stores, k)
        The twist delta, in the body's frame, that moves the pose: dR = -R delta/2.
    orientation : array (stores, k, 3)
        Rotation vector along the body's axes: of the same twist the angular part.
    position, velocity : array (stores, k, 3)
        Of the centre of mass, in the world.
    angular_velocity : array (stores, k, 3)
        Along the body's axes.
    energy : array (stores, k)
        Of all bodies together.
    """

    def __init__(self, trajectory: Trajectory, place: slice) -> None:
        self._trajectory, self._place = trajectory, place

    @property
    def _made(self) -> Assembly:
        return self._trajectory._made

    def _tangents(self, body: int) -> tuple[Array, Array]:
        """Of pose and twist (..., stores, k, 6), in the driver's frame."""
        run = self._trajectory._run
        chosen = run.tangents[:, :, self._place, :, body] / run.driver.directions.sizes[:, None, self._place, None, None]
        found = self._trajectory._array(chosen)
        return np.ascontiguousarray(found[..., 0, :]), np.ascontiguousarray(found[..., 1, :])

    def _screws(self, values: Array) -> Multivector:
        """Twists of the driver's frame in the body's."""
        own = self._made.frames[self._trajectory._body].own
        if own.shape:
            own = own.reshape(own.shape[0], *[1] * (values.ndim - 2))
        moved: Multivector = own >> self._made.algebra.wrap(self._made.algebra.kind("twist"), values)
        return moved

    def _vectors(self, twist: Multivector) -> tuple[Array, Array]:
        found = call(self._made.algebra, "mechanics.screw_vectors", twist).values
        return found[0].values, found[1].values

    @property
    def motor(self) -> Multivector:
        return self._screws(self._tangents(self._trajectory._body)[0])

    @property
    def orientation(self) -> Array:
        return self._vectors(self.motor)[0]

    @property
    def position(self) -> Array:
        return self._turned(self._vectors(self.motor)[1])

    @property
    def angular_velocity(self) -> Array:
        return self._vectors(self._screws(self._tangents(self._trajectory._body)[1]))[0]

    @property
    def velocity(self) -> Array:
        own = self._vectors(self._trajectory.twist)[1][..., None, :]
        change = self._vectors(self._screws(self._tangents(self._trajectory._body)[1]))[1]
        return self._turned(change + np.cross(self.orientation, own))

    def _turned(self, x: Array) -> Array:
        turned: Array = np.einsum("...ij,...kj->...ki", self._trajectory.orientation, x)
        return turned

    # -- energy --------------------------------------------------------------------------------------------

    @property
    def energy(self) -> Array:
        total: Array = np.zeros(())
        for i, each in enumerate(self._trajectory.bodies.values()):
            own = Sensitivity(each, self._place)
            total = total + own._kinetic(i) + own._potential(i)
        for i in range(len(self._made.springs)):
            total = total + self._spring(i)
        return total

    def _numbers(self, begin: int, count: int) -> tuple[Array, Array]:
        """Numbers (.., 1, 1, count) of the simulation and their tangents (.., 1, k, count)."""
        directions = self._trajectory._run.driver.directions
        value = self._made.numbers[:, None, None, begin : begin + count]
        change = directions.numbers[:, None, self._place, begin : begin + count]
        return (value[0], change[0]) if self._trajectory._single else (value, change)

    def _of_body(self, i: int, name: str) -> tuple[Array, Array]:
        place, count = PLACES[name]
        return self._numbers(BODY * i + place, count)

    def _kinetic(self, i: int) -> Array:
        """Of Omega . M Omega/2."""
        matrix, change = (x.reshape(*x.shape[:-1], 6, 6) for x in self._of_body(i, "mass"))
        omega = self._trajectory._array(self._trajectory._run.twists[:, :, i])[..., None, :]
        d_omega = self._tangents(i)[1]
        momentum = np.einsum("...ij,...j->...i", matrix, omega)
        found: Array = (momentum * d_omega).sum(-1) + np.einsum("...i,...ij,...j->...", omega, change, omega) / 2
        return found

    def _potential(self, i: int) -> Array:
        """Of -m g . x."""
        weight, change = self._of_body(i, "weight")
        found: Array = -(change * self._trajectory.position[..., None, :]).sum(-1) - (weight * self.position).sum(-1)
        return found

    def _spring(self, i: int) -> Array:
        """Of stiffness (gap - length)^2/2."""
        (first, d_first), (second, d_second) = (self._end(i, end) for end in range(2))
        numbers, changes = self._numbers(self._made.spring_place + SPRING * i + 6, 2)
        gap, d_gap = second - first, d_second - d_first
        way = np.linalg.norm(gap, axis=-1)
        along = (gap * d_gap).sum(-1)
        d_way = np.divide(along, way, out=np.zeros_like(along), where=way > 0)
        stretch = way - numbers[..., 1]
        found: Array = changes[..., 0] * stretch**2 / 2 + numbers[..., 0] * stretch * (d_way - changes[..., 1])
        return found

    def _end(self, i: int, end: int) -> tuple[Array, Array]:
        """A spring's end in the driver's world (..., stores, 1, 3), and its tangents."""
        body = self._made.springs[i][end]
        point, change = self._numbers(self._made.spring_place + SPRING * i + 3 * end, 3)
        if body < 0:
            return point, change
        algebra, run = self._made.algebra, self._trajectory._run
        motors = np.ascontiguousarray(self._trajectory._array(run.motors[:, :, body]))
        matrix = algebra.matrix(algebra.wrap(algebra.kind("motor"), motors))[..., None, :, :]
        turn, way = self._vectors(algebra.wrap(algebra.kind("twist"), self._tangents(body)[0]))
        moved = np.cross(turn, point) + way + change
        place = np.einsum("...ij,...j->...i", matrix[..., :3, :3], point) + matrix[..., :3, 3]
        return place, np.einsum("...ij,...j->...i", matrix[..., :3, :3], moved)
