"""Rigid bodies: mass, inertia, pose and velocities at the start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, KindError, ShapeError
from ..common.validation import broadcast_shapes, check_items, finite_array, positive_array
from ..core.multivector import Multivector
from ..dispatch.formulas import ArrayOperand, evaluate
from ..status import Status
from .arguments import frozen_copy, multivector_of, vectors
from .principal_axes import principal
from .screws import geometry

if TYPE_CHECKING:
    from ..core.multivector import Algebra

Array = NDArray[Any]


class RigidBody:
    """A rigid body, or a batch of n bodies.

    Parameters
    ----------
    mass : float or array (n,)
    inertia : array (3,), (3, 3), (n, 3) or (n, 3, 3)
        Principal moments, or the tensor, about the center of mass along the body's axes, mass included.
    position : array (3,) or (n, 3)
        Center of mass, in the world.
    orientation : array (3, 3), (n, 3, 3), or motor, optional
        Body to world. A motor is the pose of the body, position included, and `position` is then left out.
    velocity : array (3,) or (n, 3)
        Velocity of the center of mass, in the world.
    angular_velocity : array (3,) or (n, 3)
        Along the body's axes, in radians per second.
    algebra : Algebra
        ``bladesmith.cga3d`` (default) or ``bladesmith.pga3d``.

    Attributes
    ----------
    motor : Multivector
        Takes the body's frame (origin at the center of mass) to the world's.
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
        self.mass = frozen_copy(positive_array(mass, "the mass"))
        normal = self.mass >= np.finfo(float).tiny  # of others the inverse is infinite
        check_items(normal, self.mass, "the mass", "a positive number")
        self.moments, self.axes = map(frozen_copy, principal(inertia))
        self.motor = self._pose(position, orientation)
        self.velocity = frozen_copy(vectors(velocity, "velocity"))
        self.angular_velocity = frozen_copy(vectors(angular_velocity, "angular_velocity"))
        self.shape = broadcast_shapes({
            "mass": self.mass.shape, "inertia": self.moments.shape[:-1], "pose": self.motor.shape,
            "velocity": self.velocity.shape[:-1], "angular_velocity": self.angular_velocity.shape[:-1],
        })  # fmt: skip
        if len(self.shape) > 1:
            raise ShapeError(f"bodies have shape {self.shape}; one, or a batch (n,), is meant.")

    def __repr__(self) -> str:
        if self.shape:
            return f"<RigidBody: {self.shape[0]} bodies in {self.algebra.name}>"
        moments, place = (", ".join(f"{x + 0.0:.6g}" for x in row) for row in (self.moments, self.position))
        return f"<RigidBody: mass {self.mass:.6g}, moments ({moments}), at ({place}), {self.algebra.name}>"

    def _pose(self, position: Any, orientation: Any) -> Multivector:
        position = vectors(position, "position")
        if isinstance(orientation, Multivector):
            return self._pose_of_motor(position, multivector_of(orientation, self.algebra, "the orientation"))
        rotation = np.eye(3) if orientation is None else finite_array(orientation, "the orientation")
        if rotation.shape[-2:] != (3, 3):
            raise ShapeError(f"the orientation has shape {rotation.shape}; it ends in (3, 3), or it is a motor.")
        shape = broadcast_shapes({"orientations": rotation.shape[:-2], "positions": position.shape[:-1]})
        self._position = frozen_copy(position)
        matrix = np.zeros((*shape, 4, 4))
        matrix[..., :3, :3], matrix[..., :3, 3], matrix[..., 3, 3] = rotation, position, 1
        motor: Multivector = self.algebra.motor_from_matrix(matrix)
        if np.any(np.asarray(motor.status) != Status.OK):
            raise _orientation_error(rotation)
        return motor

    def _pose_of_motor(self, position: Array, orientation: Multivector) -> Multivector:
        """Pose of a motor, translated by a position."""
        try:
            motor = orientation.as_kind("motor")
        except KindError as error:
            raise InputError(f"the orientation is not a motor: {error.what}", remedy=error.remedy) from None
        if position.any():
            broadcast_shapes({"orientations": motor.shape, "positions": position.shape[:-1]})
            motor = self.algebra.translator(position) * motor
        self._position = frozen_copy(self.algebra.matrix(motor)[..., :3, 3])
        return motor

    @property
    def position(self) -> Array:
        """Center of mass, in the world (..., 3)."""
        return self._position

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
        vectors = [self.algebra.spatial(x, "a twist") for x in (first, second)]
        screw: Multivector = evaluate(self.algebra, "mechanics.screw_of", *vectors).value
        return screw

    @property
    def frame(self) -> Multivector:
        """Motor of the frame along the principal axes at the center of mass."""
        motor: Multivector = self.motor * self.algebra.motor_from_matrix(self.axes)
        return motor

    def momentum(self, twist: Multivector) -> Multivector:
        """World momentum, moments about the world's origin, of a twist of the world, at the start's pose."""
        return self._with_inertia("mechanics.momentum_in", multivector_of(twist, self.algebra, "the twist"))

    def twist(self, momentum: Multivector) -> Multivector:
        """Twist of the world that has a world momentum, at the start's pose."""
        return self._with_inertia("mechanics.twist_in", multivector_of(momentum, self.algebra, "the momentum"))

    def _with_inertia(self, formula: str, x: Multivector) -> Multivector:
        moments = self.algebra.spatial(self.moments, "the moments")
        mass = ArrayOperand(self.mass, 0, "the mass")
        value: Multivector = evaluate(self.algebra, formula, self.frame, mass, moments, x).value
        return value


def _home(algebra: Any) -> Algebra:
    """Algebra of a body.

    Raises
    ------
    InputError
        If bodies do not move in it.
    """
    home: Algebra = geometry(algebra)
    if home.name not in ("cga3d", "pga3d"):
        raise InputError(f"bodies move in cga3d or pga3d, not in {home.name}.")
    return home


def _orientation_error(matrices: Array) -> InputError:
    """Error of the matrix (..., 3, 3) that is furthest from a rotation."""
    with np.errstate(all="ignore"):
        off = np.nan_to_num(np.abs(np.swapaxes(matrices, -1, -2) @ matrices - np.eye(3)).max((-1, -2)), nan=np.inf)
        mirrors = np.linalg.det(matrices) < 0
    worst = np.unravel_index(int(np.argmax(np.where(mirrors, np.inf, off))), off.shape)
    index = f"[{', '.join(map(str, worst))}]" if matrices.ndim > 2 else ""
    what = f"its transpose times itself differs from 1 by {off[worst]:.3g}"
    if mirrors[worst]:
        what = "its determinant is negative"
    return InputError(f"the orientation{index} is not a rotation: {what}.", remedy="Give a rotation matrix, or a motor")
