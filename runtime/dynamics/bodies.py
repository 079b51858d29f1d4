"""A rigid body: mass, inertia, and where it is and how it moves at the start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import Numbers, call
from ..codegen.errors import InputError, ShapeError
from ..loading import stock_algebra
from ..multivector import Multivector
from .given import finite, of_algebra, positive, vectors
from .principal import principal

if TYPE_CHECKING:
    from ..algebras import Algebra

Array = NDArray[Any]


class RigidBody:
    """A rigid body, or n of them that differ in their numbers.

    Parameters
    ----------
    mass : float or array (n,)
    inertia : array (3,), (3, 3), (n, 3) or (n, 3, 3)
        Principal moments, or the tensor, about the centre of mass along the body's axes, mass included.
    position : array (3,) or (n, 3)
        Of the centre of mass, in the world.
    orientation : array (3, 3), (n, 3, 3), or motor, optional
        Body to world. A motor is the pose of the body, position included, and `position` is then left out.
    velocity : array (3,) or (n, 3)
        Of the centre of mass, in the world.
    angular_velocity : array (3,) or (n, 3)
        Along the body's axes, in radians per second.
    algebra : Algebra
        ``bladesmith.cga3d`` (default) or ``bladesmith.pga3d``.

    Attributes
    ----------
    motor : Multivector
        Takes the body's frame (origin at the centre of mass) to the world's.
    moments, axes : array
        Principal moments (..., 3), and the principal axes as columns (..., 3, 3) along the body's.

    Raises
    ------
    InputError
        If a mass or a moment is not positive, the tensor is not symmetric, or no body can have such moments.
    """

    def __init__(
        self,
        mass: Any,
        inertia: Any,
        position: Any = 0,
        orientation: Any = None,
        velocity: Any = 0,
        angular_velocity: Any = 0,
        algebra: Algebra | None = None,
    ) -> None:
        self.algebra = stock_algebra("cga3d") if algebra is None else algebra
        if self.algebra.name not in ("cga3d", "pga3d"):
            raise InputError(f"bodies move in cga3d or pga3d, not in {self.algebra.name}.")
        self.mass = positive(mass, "the mass")
        self.moments, self.axes = principal(inertia)
        self.motor = self._pose(position, orientation)
        self.velocity = vectors(velocity, "velocity")
        self.angular_velocity = vectors(angular_velocity, "angular_velocity")
        shapes = [self.mass.shape, self.moments.shape[:-1], self.motor.shape, self.velocity.shape[:-1],
                  self.angular_velocity.shape[:-1]]  # fmt: skip
        try:
            self.shape: tuple[int, ...] = np.broadcast_shapes(*shapes)
        except ValueError:
            raise ShapeError(
                f"mass, inertia, pose and velocities have shapes {shapes} that do not go together."
            ) from None
        if len(self.shape) > 1:
            raise ShapeError(f"bodies have shape {self.shape}; one, or a batch (n,), is meant.")

    def _pose(self, position: Any, orientation: Any) -> Multivector:
        if isinstance(orientation, Multivector):
            motor = of_algebra(orientation, self.algebra, "the orientation").as_kind("motor")
            if np.ndim(position) or position != 0:
                motor = self.algebra.translator(vectors(position, "position")) * motor
            self._place = self.algebra.matrix(motor)[..., :3, 3]
            return motor
        place = self._place = vectors(position, "position")
        turn = np.eye(3) if orientation is None else finite(orientation, "the orientation")
        if turn.shape[-2:] != (3, 3):
            raise ShapeError(f"the orientation has shape {turn.shape}; it ends in (3, 3), or it is a motor.")
        shape = np.broadcast_shapes(turn.shape[:-2], place.shape[:-1])
        matrix = np.zeros((*shape, 4, 4))
        matrix[..., :3, :3], matrix[..., :3, 3], matrix[..., 3, 3] = turn, place, 1
        made: Multivector = self.algebra.motor_from_matrix(matrix, strict=True)
        return made

    @property
    def position(self) -> Array:
        """Of the centre of mass, in the world (..., 3)."""
        return self._place

    @property
    def rotation(self) -> Array:
        """Body to world (..., 3, 3)."""
        return self.algebra.matrix(self.motor)[..., :3, :3]

    @property
    def twist_in_body(self) -> Multivector:
        """Twist at the start, in the body's frame."""
        linear = np.einsum("...ji,...j->...i", self.rotation, self.velocity)
        return self._screw(self.angular_velocity, linear)

    def _screw(self, first: Array, second: Array) -> Multivector:
        vectors = [self.algebra.vector(x, "a twist") for x in (first, second)]
        made: Multivector = call(self.algebra, "mechanics.screw_of", *vectors).value
        return made

    @property
    def frame(self) -> Multivector:
        """Motor of the frame along the principal axes at the centre of mass."""
        motor: Multivector = self.motor * self.algebra.motor_from_matrix(self.axes)
        return motor

    def momentum(self, twist: Multivector) -> Multivector:
        """World momentum, moments about the world's origin, of a twist of the world, at the start's pose."""
        return self._mapped("mechanics.momentum_in", of_algebra(twist, self.algebra, "the twist"))

    def twist(self, momentum: Multivector) -> Multivector:
        """Twist of the world that has a world momentum, at the start's pose."""
        return self._mapped("mechanics.twist_in", of_algebra(momentum, self.algebra, "the momentum"))

    def _mapped(self, formula: str, x: Multivector) -> Multivector:
        moments = self.algebra.vector(self.moments, "the moments")
        made: Multivector = call(self.algebra, formula, self.frame, Numbers(self.mass, 0, "the mass"), moments, x).value
        return made
