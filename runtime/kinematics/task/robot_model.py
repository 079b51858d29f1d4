"""Common interface of Delta, serial and general mechanisms: actuated joints and an end effector.

Files and the command line (`task`) use robots by this interface; general mechanisms are in `mechanism_model`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...status import Status
from ..delta.geometry import BASE, BODIES, PLATFORM, JointObjects
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from ...core.multivector import Multivector
    from ..delta.robot import DeltaRobot
    from ..robots.robot import Robot
    from ..serial.chain import Chain

Array = NDArray[Any]
#: Singular values below this fraction of the largest are zero.
SINGULAR = 1e-9
#: Positions along the axis of a Delta robot; the best conditioned one is its default pose.
ON_AXIS = 200


@dataclass(frozen=True, eq=False)
class PoseBatch:
    """Batch of poses of a model.

    Attributes
    ----------
    coordinates : array (n, k)
        Coordinates of the inputs; NaN where there is no pose.
    position : array (n, 3)
        Positions of the tool.
    jacobian : array (n, r, k)
        From speeds of the inputs to the tool's velocity (three rows), or to its angular velocity and velocity.
    inverse : array (n, k, r)
        Inverse of the Jacobian, or its pseudo-inverse.
    condition : array (n,)
        Condition number of the Jacobian, angles and lengths compared by the model's own length; infinite at singular
        poses.
    status : array (n,)
        Codes of `Status`.
    at : callable
        The mechanism at one of the poses.
    """

    coordinates: Array
    position: Array
    jacobian: Array
    inverse: Array
    condition: Array
    status: NDArray[np.uint8]
    at: Callable[[int], Mechanism]

    @property
    def is_reached(self) -> NDArray[np.bool_]:
        """Mask (n,) of the items that have a pose."""
        return np.asarray(np.isfinite(self.coordinates).all(-1) & np.isfinite(self.position).all(-1))

    def __len__(self) -> int:
        return len(self.coordinates)


class Model(Protocol):
    """Protocol that all robot models implement.

    Attributes
    ----------
    kind : str
        Type of the robot, for reports.
    inputs : tuple of str
    is_revolute : bool array (k,)
        True for inputs that are angles.
    tool : str
        The body that the inputs move; empty if none was named.
    length : float
        Length that a radian counts as where angles and lengths are compared.
    home : array (k,)
        Default coordinates.
    limits : array (k, 2)
        Range of the coordinates.
    """

    kind: str
    inputs: tuple[str, ...]
    is_revolute: NDArray[np.bool_]
    tool: str
    length: float
    home: Array
    limits: Array

    def forward(self, values: Array, path: bool = False) -> PoseBatch:
        """Poses for coordinates (n, k)."""
        ...

    def inverse(
        self, positions: Array, start: Array, path: bool = False, rotor: Multivector | None = None
    ) -> PoseBatch:
        """Poses for positions (n, 3) of the tool, searched from coordinates (k,).

        The orientation at these coordinates, rotated by a rotor, is kept if there are enough inputs.
        """
        ...


def condition_numbers(
    matrices: Array, status: NDArray[np.uint8], length: float, is_revolute: NDArray[np.bool_], max_rank: int
) -> tuple[Array, NDArray[np.uint8]]:
    """Condition numbers (n,) of Jacobians (n, r, k), and the status, SINGULAR at singular ones."""
    rows = np.where(np.arange(matrices.shape[-2]) < matrices.shape[-2] - 3, 1.0, 1 / length)
    scaled = matrices * rows[:, None] * np.where(is_revolute, 1.0, length)
    good = np.isfinite(scaled).all((-1, -2))
    values = np.linalg.svd(np.where(good[:, None, None], scaled, 0.0), compute_uv=False)
    free = min(max_rank, values.shape[-1])
    largest, least = values[:, 0], values[:, free - 1]
    zero = least <= SINGULAR * largest
    condition = np.where(zero, np.inf, np.divide(largest, least, out=np.ones_like(least), where=~zero))
    marked = np.where(good & zero & (status == Status.OK), np.uint8(Status.SINGULAR), status).astype(np.uint8)
    return np.where(good, condition, np.nan), marked


def pseudo_inverse(matrices: Array) -> Array:
    """Pseudo-inverses (n, k, r); NaN where the matrix is."""
    good = np.asarray(np.isfinite(matrices).all((-1, -2)))[:, None, None]
    return np.where(good, np.linalg.pinv(np.where(good, matrices, 0.0), rcond=SINGULAR), np.nan)


# -- the Delta robot -------------------------------------------------------------------------------------------


class DeltaModel:
    """A Delta robot: motors on a base, and a platform."""

    kind = "Delta robot"
    inputs = ("motor_1", "motor_2", "motor_3")
    tool = PLATFORM

    def __init__(self, robot: DeltaRobot, elbow: str | Sequence[str] = "outer", root: str = "far") -> None:
        self.robot, self.elbow, self.root = robot, elbow, root
        self.is_revolute, self.length = np.ones(3, bool), robot.forearm
        self.limits = np.tile([-np.inf, np.inf], (3, 1))
        self.home = self._best_conditioned()

    def _best_conditioned(self) -> Array:
        """Angles of the pose on the axis with the least condition number."""
        farthest = self.robot.upper_arm + self.robot.forearm
        positions = np.zeros((ON_AXIS, 3))
        positions[:, 2] = farthest * np.arange(1, ON_AXIS + 1) / ON_AXIS
        poses = self.inverse(positions, np.zeros(3))
        score = np.asarray(np.where(poses.status == Status.OK, poses.condition, np.inf))
        best = int(np.nanargmin(score))
        return poses.coordinates[best] if np.isfinite(score[best]) else np.zeros(3)

    def forward(self, values: Array, path: bool = False) -> PoseBatch:
        position, unreachable = self.robot.forward(values, self.root, status=True)
        matrix, codes = self.robot.forward_jacobian(values, root=self.root, status=True)
        condition, codes = condition_numbers(matrix, np.asarray(codes), self.length, self.is_revolute, 3)
        reached = np.asarray(np.isfinite(position).all(-1))
        angles = np.where(reached[:, None], values, np.nan)
        return PoseBatch(
            angles, position, matrix, pseudo_inverse(matrix), condition, np.maximum(codes, unreachable),
            self._mechanism_at(values),
        )  # fmt: skip

    def inverse(
        self, positions: Array, start: Array, path: bool = False, rotor: Multivector | None = None
    ) -> PoseBatch:
        if rotor is not None:
            raise InputError("the platform of a Delta robot does not rotate.")
        angles = self.robot.inverse(positions, self.elbow)
        back, codes = self.robot.inverse_jacobian(positions, elbow=self.elbow, status=True)
        matrix = pseudo_inverse(back)
        condition, codes = condition_numbers(back, np.asarray(codes), 1.0, self.is_revolute, 3)
        reached = np.asarray(np.isfinite(angles).all(-1))
        condition = np.where(reached & (codes == Status.SINGULAR), np.inf, condition)
        position = np.where(reached[:, None], positions, np.nan)
        if path:
            angles = np.unwrap(angles, axis=0)
        return PoseBatch(angles, position, matrix, back, condition, codes, self._mechanism_at_position(positions))

    def _mechanism_at(self, angles: Array) -> Callable[[int], Mechanism]:
        return lambda i: self._mechanism(self.robot.joint_objects(angles[i], self.root))

    def _mechanism_at_position(self, positions: Array) -> Callable[[int], Mechanism]:
        return lambda i: self._mechanism(self.robot.joint_objects_at(positions[i], self.elbow))

    def _mechanism(self, objects: JointObjects) -> Mechanism:
        mechanism = Mechanism(BODIES, BASE)
        for i, joint in enumerate(objects.joints()):
            mechanism.add(joint, self.inputs[i] if i < 3 else None)
        return mechanism


# -- serial robots ---------------------------------------------------------------------------------------------


class ChainModel:
    """A robot of a URDF file, and the chain of joints to its tip."""

    def __init__(self, robot: Robot, chain: Chain, tip: str, root: str | None = None) -> None:
        self.robot, self.chain, self.tool, self.root = robot, chain, tip, root
        self.kind = f"robot {robot.name!r}"
        self.inputs, self.length = chain.names, chain.length
        self.is_revolute = np.array([robot.joints[name].type != "prismatic" for name in chain.names])
        low, high = chain.limits.T
        self.home, self.limits = np.clip(np.zeros(chain.count), low, high), chain.limits

    def forward(self, values: Array, path: bool = False) -> PoseBatch:
        return self._poses(np.asarray(values, float), np.zeros(len(values), np.uint8))

    def inverse(
        self, positions: Array, start: Array, path: bool = False, rotor: Multivector | None = None
    ) -> PoseBatch:
        home = self.chain.forward(start)
        algebra = self.chain.algebra
        origin = algebra.matrix(home)[:3, 3]
        rotated = home if rotor is None else self._rotate_about(home, rotor, origin)
        goals = (algebra.translator(positions - origin) * rotated).as_kind("motor")
        if not path:
            solution = self.chain.inverse(goals, start)
            return self._poses(solution.q, np.asarray(solution.status, np.uint8))
        rows, codes = [], []
        for i in range(len(positions)):  # each starts from the solution before it
            solution = self.chain.inverse(goals[i], start)
            rows.append(solution.q)
            codes.append(int(solution.status))
            start = solution.q if np.isfinite(solution.q).all() else start
        return self._poses(np.array(rows), np.array(codes, np.uint8))

    def _rotate_about(self, home: Multivector, rotor: Multivector, origin: Array) -> Multivector:
        translator = self.chain.algebra.translator(origin)
        rotated: Multivector = (translator * rotor * ~translator * home).as_kind("motor")
        return rotated

    def _poses(self, q: Array, codes: NDArray[np.uint8]) -> PoseBatch:
        valid = np.asarray(np.isfinite(q).all(-1))
        filled = np.where(valid[:, None], q, self.home)
        position = self.chain.algebra.matrix(self.chain.forward(filled))[:, :3, 3]
        matrix = np.where(valid[:, None, None], self.chain.jacobian(filled, point=np.zeros(3)), np.nan)
        condition, codes = condition_numbers(matrix, codes, self.length, self.is_revolute, self.chain.freedom)
        position = np.where(valid[:, None], position, np.nan)
        return PoseBatch(q, position, matrix, pseudo_inverse(matrix), condition, codes, self._mechanism_at(q))

    def _mechanism_at(self, q: Array) -> Callable[[int], Mechanism]:
        return lambda i: self.robot.mechanism(dict(zip(self.inputs, q[i].tolist(), strict=True)), self.root)


__all__ = ["SINGULAR", "ChainModel", "DeltaModel", "PoseBatch", "Model", "pseudo_inverse", "condition_numbers"]
