"""A rigid body: mass, inertia, and where it is and how it moves at the start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..calls import Numbers, call
from ..codegen.errors import InputError, KindError, ShapeError
from ..multivector import Multivector
from ..status import Status
from .given import finite, kept, of_algebra, positive, vectors
from .principal import principal
from .screws import geometry

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
        self.algebra = _home(algebra)
        self.mass = kept(positive(mass, "the mass"))
        self.moments, self.axes = map(kept, principal(inertia))
        self.motor = self._pose(position, orientation)
        self.velocity = kept(vectors(velocity, "velocity"))
        self.angular_velocity = kept(vectors(angular_velocity, "angular_velocity"))
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
        place = vectors(position, "position")
        if isinstance(orientation, Multivector):
            return self._moved(place, of_algebra(orientation, self.algebra, "the orientation"))
        turn = np.eye(3) if orientation is None else finite(orientation, "the orientation")
        if turn.shape[-2:] != (3, 3):
            raise ShapeError(f"the orientation has shape {turn.shape}; it ends in (3, 3), or it is a motor.")
        shape = _together(turn.shape[:-2], place.shape[:-1])
        self._place = kept(place)
        matrix = np.zeros((*shape, 4, 4))
        matrix[..., :3, :3], matrix[..., :3, 3], matrix[..., 3, 3] = turn, place, 1
        made: Multivector = self.algebra.motor_from_matrix(matrix)
        if np.any(np.asarray(made.status) != Status.OK):
            raise _no_rotation(turn)
        return made

    def _moved(self, place: Array, orientation: Multivector) -> Multivector:
        """A motor as it is given, or moved to a place."""
        try:
            motor = orientation.as_kind("motor")
        except KindError as error:
            raise InputError(f"the orientation is no motor: {error.what}", remedy=error.remedy) from None
        if place.any():
            _together(motor.shape, place.shape[:-1])
            motor = self.algebra.translator(place) * motor
        self._place = kept(self.algebra.matrix(motor)[..., :3, 3])
        return motor

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


def _home(algebra: Any) -> Algebra:
    """The algebra of a body.

    Raises
    ------
    InputError
        If bodies do not move in it.
    """
    found: Algebra = geometry(algebra)
    if found.name not in ("cga3d", "pga3d"):
        raise InputError(f"bodies move in cga3d or pga3d, not in {found.name}.")
    return found


def _together(turns: tuple[int, ...], places: tuple[int, ...]) -> tuple[int, ...]:
    """The batch of a pose."""
    try:
        return np.broadcast_shapes(turns, places)
    except ValueError:
        raise ShapeError(f"orientations are {turns}, positions {places}; they do not go together.") from None


def _no_rotation(turn: Array) -> InputError:
    """What is wrong with the worst of some matrices (..., 3, 3)."""
    with np.errstate(all="ignore"):
        off = np.nan_to_num(np.abs(np.swapaxes(turn, -1, -2) @ turn - np.eye(3)).max((-1, -2)), nan=np.inf)
        mirrors = np.linalg.det(turn) < 0
    worst = np.unravel_index(int(np.argmax(np.where(mirrors, np.inf, off))), off.shape)
    place = f"[{', '.join(map(str, worst))}]" if turn.ndim > 2 else ""
    what = f"its transpose times itself differs from 1 by {off[worst]:.3g}"
    if mirrors[worst]:
        what = "its determinant is negative"
    return InputError(f"the orientation{place} is no rotation: {what}.", remedy="Give a rotation matrix, or a motor")
