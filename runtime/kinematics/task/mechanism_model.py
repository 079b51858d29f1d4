"""General mechanism as a model: actuated joints, and a point of the body that they move; see `robot_model`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...mechanics.screws import screw_coordinates
from ...status import Status
from ..mechanism.mechanism import Mechanism
from ..mechanism.poses.batch import Poses
from .robot_model import SINGULAR, PoseBatch, condition_numbers, pseudo_inverse

if TYPE_CHECKING:
    from ...core.multivector import Multivector

Array = NDArray[Any]
#: Inputs that control position and orientation of the tool, at least.
FULL_MOBILITY = 6


class MechanismModel:
    """A mechanism, its actuated joints, and a point of the body that they move."""

    kind = "mechanism"

    def __init__(
        self,
        mechanism: Mechanism,
        inputs: Sequence[str],
        tool: str = "",
        point: Any = (0.0, 0.0, 0.0),
        limits: Any = None,
    ) -> None:
        self.mechanism, self.tool, self.point = mechanism, tool, np.asarray(point, float)
        self.inputs = tuple(inputs)
        self.limits = np.array([(limits or {}).get(n, (-np.inf, np.inf)) for n in self.inputs], float).reshape(-1, 2)
        numbers = [mechanism.find_joint(name) for name in self.inputs]
        speeds = [mechanism.loops.relations[j].speeds for j in numbers if j is not None]
        for name, own in zip(self.inputs, speeds, strict=True):
            if len(own) != 1:
                raise InputError(f"{name!r} has {len(own)} coordinates; an input has one.")
        free = [mechanism.loops.relations[j].free for j in numbers if j is not None]
        twists = mechanism.algebra.wrap(
            mechanism.algebra.kind("twist"), np.concatenate([np.zeros((0, 6)), *(x.T for x in free)])
        )
        angular = np.asarray(screw_coordinates(twists)).reshape(-1, 6)[:, :3]
        self.is_revolute: NDArray[np.bool_] = np.abs(angular).max(-1, initial=0.0) > SINGULAR
        self.length = mechanism.frame.unit if mechanism.joints else 1.0
        self.home = np.zeros(len(self.inputs))

    @property
    def controls_orientation(self) -> bool:
        """True if there are enough inputs to keep the tool's orientation."""
        return len(self.inputs) >= FULL_MOBILITY

    def _check_inputs_and_tool(self) -> None:
        if not self.inputs or not self.tool:
            missing = "inputs: the actuated joints" if not self.inputs else "tool: the body that they move"
            raise InputError(f"the mechanism has no {missing}.", remedy="Name them under [mechanism]")

    def forward(self, values: Array, path: bool = False) -> PoseBatch:
        if not self.inputs:
            self._check_inputs_and_tool()
        driven = {name: values[:, i] for i, name in enumerate(self.inputs)}
        return self._batch(self.mechanism.solve_pose(driven, path=path), values)

    def inverse(
        self, positions: Array, start: Array, path: bool = False, rotor: Multivector | None = None
    ) -> PoseBatch:
        self._check_inputs_and_tool()
        begin = self._start_pose(start)
        if not self.controls_orientation and rotor is None:
            targets: Any = (self.point, positions)
        else:
            algebra = self.mechanism.algebra
            home = algebra.multivector({"": 1.0}) if begin is None else begin[self.tool]
            origin = self._tool_position(begin)
            about = algebra.translator(origin)
            rotated = home if rotor is None else about * rotor * ~about * home
            targets = (algebra.translator(positions - origin) * rotated).as_kind("motor")
        return self._batch(self.mechanism.solve_pose(targets={self.tool: targets}, start=begin, path=path), None)

    def _start_pose(self, start: Array) -> dict[str, Multivector] | None:
        """Motors of the bodies at coordinates (k,); None at the pose of the file."""
        if not np.any(start):
            return None
        driven = {name: start[None, i] for i, name in enumerate(self.inputs)}
        poses = self.mechanism.solve_pose(driven, strict=True)
        return {name: poses[name][0] for name in self.mechanism.moving}

    def _tool_position(self, begin: dict[str, Multivector] | None) -> Array:
        if begin is None:
            return self.point
        return np.asarray((begin[self.tool] >> self.mechanism.algebra.point(self.point)).parameters().xyz)

    def _batch(self, poses: Poses, values: Array | None) -> PoseBatch:
        m = self.mechanism
        codes = np.array(poses.status, np.uint8)
        coordinates = (
            values if values is not None else np.concatenate([poses.coordinates(name) for name in self.inputs], -1)
        )
        if values is None:
            low, high = self.limits.T
            codes[(codes == Status.OK) & ((coordinates < low) | (coordinates > high)).any(-1)] = Status.UNREACHABLE
        bad = codes != Status.OK
        q = np.where(bad[:, None], np.nan, coordinates)
        if not self.tool:
            empty = np.zeros((len(q), 0, q.shape[-1]))
            position = np.where(bad[:, None], np.nan, np.zeros(3))
            unknown = np.full(len(q), np.nan)
            return PoseBatch(q, position, empty, pseudo_inverse(empty), unknown, codes, self._mechanism_at(poses))
        position = (poses[self.tool] >> m.algebra.point(self.point)).parameters().xyz
        outputs = [self.tool, (self.tool, self.point)] if self.controls_orientation else [(self.tool, self.point)]
        matrix, status = m.jacobian(list(self.inputs), outputs, poses=poses, status=True)
        if self.controls_orientation:
            matrix = np.concatenate([self._angular_velocities(matrix[:, :6]), matrix[:, 6:]], 1)
        failed = np.not_equal(status, Status.OK)
        matrix = np.where((bad | failed)[:, None, None], np.nan, matrix)
        condition, marked = condition_numbers(matrix, codes, self.length, self.is_revolute, len(self.inputs))
        marked = np.where(~bad & failed, np.uint8(Status.SINGULAR), marked).astype(np.uint8)
        condition = np.where(~bad & (marked == Status.SINGULAR), np.inf, condition)
        position = np.where(bad[:, None], np.nan, position)
        return PoseBatch(q, position, matrix, pseudo_inverse(matrix), condition, marked, self._mechanism_at(poses))

    def _angular_velocities(self, columns: Array) -> Array:
        """Angular velocities (n, 3, k) of twists (n, 6, k)."""
        algebra = self.mechanism.algebra
        twists = algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(np.swapaxes(columns, -1, -2)))
        return np.swapaxes(np.asarray(screw_coordinates(twists))[..., :3], -1, -2)

    def _mechanism_at(self, poses: Poses) -> Callable[[int], Mechanism]:
        return lambda i: self.mechanism.at({name: poses[name][i] for name in self.mechanism.moving})


__all__ = ["FULL_MOBILITY", "MechanismModel"]
