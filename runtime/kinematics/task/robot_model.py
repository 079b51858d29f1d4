"""A Delta robot, a robot of a URDF file or any mechanism behind one face: joints that are driven, and a tool.

What files and the command line ask for (`setup`) is asked of these; any mechanism is in `models_general`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..status import Status
from .delta_geometry import BASE, BODIES, PLATFORM
from .mechanism import Mechanism

if TYPE_CHECKING:
    from ..multivector import Multivector
    from .chains import Chain
    from .delta import DeltaRobot
    from .urdf import Robot

Array = NDArray[Any]
#: Singular values below this share of the largest are zero.
SINGULAR = 1e-9
#: Positions along the axis of a Delta robot, of which the best one is where it stands by default.
ON_AXIS = 200


@dataclass(frozen=True, eq=False)
class Found:
    """Poses of a model.

    Attributes
    ----------
    coordinates : array (n, k)
        Of its inputs; NaN where there is no pose.
    position : array (n, 3)
        Of the tool.
    jacobian : array (n, r, k)
        From speeds of the inputs to the tool's velocity (three rows), or to its angular velocity and that.
    inverse : array (n, k, r)
        Back: its pseudo-inverse, or what is known better.
    condition : array (n,)
        Greatest over least singular value of the Jacobian, turns and ways compared by the model's own length; infinite
        at singular poses.
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
    def known(self) -> NDArray[np.bool_]:
        """Where there is a pose."""
        return np.asarray(np.isfinite(self.coordinates).all(-1) & np.isfinite(self.position).all(-1))

    def __len__(self) -> int:
        return len(self.coordinates)


class Model(Protocol):
    """What is asked of the three.

    Attributes
    ----------
    kind : str
        In words.
    inputs : tuple of str
    turning : bool array (k,)
        Whether an input is an angle.
    tool : str
        The body that it moves; empty if none was named.
    length : float
        What a radian is worth where turns and ways are compared.
    home : array (k,)
        Coordinates where nothing else is said.
    limits : array (k, 2)
        Within which coordinates are looked for.
    """

    kind: str
    inputs: tuple[str, ...]
    turning: NDArray[np.bool_]
    tool: str
    length: float
    home: Array
    limits: Array

    def at_joints(self, values: Array, path: bool = False) -> Found:
        """Poses for coordinates (n, k)."""
        ...

    def at_places(self, places: Array, start: Array, path: bool = False, turn: Multivector | None = None) -> Found:
        """Poses for positions (n, 3) of the tool, looked for from coordinates (k,).

        The way it is turned there, and then by a rotor, is kept if the inputs are enough for that.
        """
        ...


def measured(
    matrices: Array, status: NDArray[np.uint8], length: float, turning: NDArray[np.bool_], most: int
) -> tuple[Array, NDArray[np.uint8]]:
    """Condition numbers (n,) of Jacobians (n, r, k), and the status with singular ones marked."""
    rows = np.where(np.arange(matrices.shape[-2]) < matrices.shape[-2] - 3, 1.0, 1 / length)
    scaled = matrices * rows[:, None] * np.where(turning, 1.0, length)
    good = np.isfinite(scaled).all((-1, -2))
    values = np.linalg.svd(np.where(good[:, None, None], scaled, 0.0), compute_uv=False)
    free = min(most, values.shape[-1])
    largest, least = values[:, 0], values[:, free - 1]
    zero = least <= SINGULAR * largest
    condition = np.where(zero, np.inf, np.divide(largest, least, out=np.ones_like(least), where=~zero))
    marked = np.where(good & zero & (status == Status.OK), np.uint8(Status.SINGULAR), status).astype(np.uint8)
    return np.where(good, condition, np.nan), marked


def backwards(matrices: Array) -> Array:
    """Pseudo-inverses (n, k, r); NaN where the matrix is."""
    good = np.asarray(np.isfinite(matrices).all((-1, -2)))[:, None, None]
    return np.where(good, np.linalg.pinv(np.where(good, matrices, 0.0), rcond=SINGULAR), np.nan)


# -- the Delta robot -------------------------------------------------------------------------------------------


class DeltaModel:
    """A Delta robot: motors on a base, and a platform."""

    kind = "Delta robot"
    inputs = ("motor_1", "motor_2", "motor_3")
    tool = PLATFORM

    def __init__(self, robot: DeltaRobot, elbow: Any = "outer", root: str = "far") -> None:
        self.robot, self.elbow, self.root = robot, elbow, root
        self.turning, self.length = np.ones(3, bool), robot.forearm
        self.limits = np.tile([-np.inf, np.inf], (3, 1))
        self.home = self._best()

    def _best(self) -> Array:
        """Angles of the pose on the axis where the platform moves alike in all directions."""
        far = self.robot.upper_arm + self.robot.forearm
        places = np.zeros((ON_AXIS, 3))
        places[:, 2] = far * np.arange(1, ON_AXIS + 1) / ON_AXIS
        found = self.at_places(places, np.zeros(3))
        score = np.asarray(np.where(found.status == Status.OK, found.condition, np.inf))
        best = int(np.nanargmin(score))
        return found.coordinates[best] if np.isfinite(score[best]) else np.zeros(3)

    def at_joints(self, values: Array, path: bool = False) -> Found:
        place, lost = self.robot.forward(values, self.root, status=True)
        matrix, codes = self.robot.forward_jacobian(values, root=self.root, status=True)
        condition, codes = measured(matrix, codes, self.length, self.turning, 3)
        reached = np.asarray(np.isfinite(place).all(-1))
        angles = np.where(reached[:, None], values, np.nan)
        return Found(angles, place, matrix, backwards(matrix), condition, np.maximum(codes, lost), self._at(values))

    def at_places(self, places: Array, start: Array, path: bool = False, turn: Multivector | None = None) -> Found:
        if turn is not None:
            raise InputError("the platform of a Delta robot does not turn.")
        angles = self.robot.inverse(places, self.elbow)
        back, codes = self.robot.inverse_jacobian(places, elbow=self.elbow, status=True)
        matrix = backwards(back)
        condition, codes = measured(back, codes, 1.0, self.turning, 3)
        reached = np.asarray(np.isfinite(angles).all(-1))
        condition = np.where(reached & (codes == Status.SINGULAR), np.inf, condition)
        shown = np.where(reached[:, None], places, np.nan)
        if path:
            angles = np.unwrap(angles, axis=0)
        return Found(angles, shown, matrix, back, condition, codes, self._at_place(places))

    def _at(self, angles: Array) -> Callable[[int], Mechanism]:
        return lambda i: self._mechanism(self.robot.joint_objects(angles[i], self.root))

    def _at_place(self, places: Array) -> Callable[[int], Mechanism]:
        return lambda i: self._mechanism(self.robot.joint_objects_at(places[i], self.elbow))

    def _mechanism(self, shared: Any) -> Mechanism:
        made = Mechanism(BODIES, BASE)
        for i, joint in enumerate(shared.joints()):
            made.add(joint, self.inputs[i] if i < 3 else None)
        return made


# -- serial robots ---------------------------------------------------------------------------------------------


class ChainModel:
    """A robot of a URDF file, and the chain of joints to its tip."""

    def __init__(self, robot: Robot, chain: Chain, tip: str, root: str | None = None) -> None:
        self.robot, self.chain, self.tool, self.root = robot, chain, tip, root
        self.kind = f"robot {robot.name!r}"
        self.inputs, self.length = chain.names, chain.length
        self.turning = np.array([robot.joints[name].type != "prismatic" for name in chain.names])
        low, high = chain.limits.T
        self.home, self.limits = np.clip(np.zeros(chain.count), low, high), chain.limits

    def at_joints(self, values: Array, path: bool = False) -> Found:
        return self._found(np.asarray(values, float), np.zeros(len(values), np.uint8))

    def at_places(self, places: Array, start: Array, path: bool = False, turn: Multivector | None = None) -> Found:
        home = self.chain.forward(start)
        algebra = self.chain.algebra
        origin = algebra.matrix(home)[:3, 3]
        moved = home if turn is None else self._turned(home, turn, origin)
        goals = (algebra.translator(places - origin) * moved).as_kind("motor")
        if not path:
            solution = self.chain.inverse(goals, start, threads=None)
            return self._found(solution.q, np.asarray(solution.status, np.uint8))
        rows, codes = [], []
        for i in range(len(places)):  # each begins where the one before it came to
            solution = self.chain.inverse(goals[i], start)
            rows.append(solution.q)
            codes.append(int(solution.status))
            start = solution.q if np.isfinite(solution.q).all() else start
        return self._found(np.array(rows), np.array(codes, np.uint8))

    def _turned(self, home: Multivector, turn: Multivector, origin: Array) -> Multivector:
        about = self.chain.algebra.translator(origin)
        moved: Multivector = (about * turn * ~about * home).as_kind("motor")
        return moved

    def _found(self, q: Array, codes: NDArray[np.uint8]) -> Found:
        good = np.asarray(np.isfinite(q).all(-1))
        known = np.where(good[:, None], q, self.home)
        place = self.chain.algebra.matrix(self.chain.forward(known))[:, :3, 3]
        matrix = np.where(good[:, None, None], self.chain.jacobian(known, point=np.zeros(3)), np.nan)
        condition, codes = measured(matrix, codes, self.length, self.turning, self.chain.freedom)
        place = np.where(good[:, None], place, np.nan)
        return Found(q, place, matrix, backwards(matrix), condition, codes, self._at(q))

    def _at(self, q: Array) -> Callable[[int], Mechanism]:
        return lambda i: self.robot.mechanism(dict(zip(self.inputs, q[i].tolist(), strict=True)), self.root)


__all__ = ["SINGULAR", "ChainModel", "DeltaModel", "Found", "Model", "backwards", "measured"]
