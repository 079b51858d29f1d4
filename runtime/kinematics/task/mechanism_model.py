"""Any mechanism as a model: joints that are driven, and a point of the body that it moves; see `models`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..dynamics.screws import screw_coordinates
from ..status import Status
from .mechanism import Mechanism
from .models import SINGULAR, Found, backwards, measured
from .solving import Poses

if TYPE_CHECKING:
    from ..multivector import Multivector

Array = NDArray[Any]
#: Inputs from which on the tool does not turn on its way.
WHOLE = 6


class MechanismModel:
    """A mechanism, the joints that drive it, and a point of the body that it moves."""

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
        whole = mechanism.algebra.wrap(
            mechanism.algebra.kind("twist"), np.concatenate([np.zeros((0, 6)), *(x.T for x in free)])
        )
        turns = np.asarray(screw_coordinates(whole)).reshape(-1, 6)[:, :3]
        self.turning = np.abs(turns).max(-1, initial=0.0) > SINGULAR
        self.length = mechanism.frame.unit if mechanism.joints else 1.0
        self.home = np.zeros(len(self.inputs))

    @property
    def whole(self) -> bool:
        """Whether there are inputs enough to keep the tool from turning."""
        return len(self.inputs) >= WHOLE

    def _asked(self) -> None:
        if not self.inputs or not self.tool:
            missing = "inputs: which joints are driven" if not self.inputs else "tool: which body is moved"
            raise InputError(f"the mechanism has no {missing}.", remedy="Name them under [mechanism]")

    def at_joints(self, values: Array, path: bool = False) -> Found:
        if not self.inputs:
            self._asked()
        driven = {name: values[:, i] for i, name in enumerate(self.inputs)}
        return self._found(self.mechanism.solve_pose(driven, path=path), values)

    def at_places(self, places: Array, start: Array, path: bool = False, turn: Multivector | None = None) -> Found:
        self._asked()
        begin = self._begin(start)
        if not self.whole and turn is None:
            targets: Any = (self.point, places)
        else:
            algebra = self.mechanism.algebra
            home = algebra.multivector({"": 1.0}) if begin is None else begin[self.tool]
            origin = self._place(begin)
            about = algebra.translator(origin)
            moved = home if turn is None else about * turn * ~about * home
            targets = (algebra.translator(places - origin) * moved).as_kind("motor")
        return self._found(self.mechanism.solve_pose(targets={self.tool: targets}, start=begin, path=path), None)

    def _begin(self, start: Array) -> dict[str, Multivector] | None:
        """Motors of the bodies at coordinates (k,); None as the file has them."""
        if not np.any(start):
            return None
        driven = {name: start[None, i] for i, name in enumerate(self.inputs)}
        poses = self.mechanism.solve_pose(driven, strict=True)
        return {name: poses[name][0] for name in self.mechanism.moving}

    def _place(self, begin: dict[str, Multivector] | None) -> Array:
        if begin is None:
            return self.point
        return np.asarray((begin[self.tool] >> self.mechanism.algebra.point(self.point)).parameters().xyz)

    def _found(self, poses: Poses, values: Array | None) -> Found:
        m = self.mechanism
        codes = np.array(poses.status, np.uint8)
        found = values if values is not None else np.concatenate([poses.coordinates(name) for name in self.inputs], -1)
        if values is None:
            low, high = self.limits.T
            codes[(codes == Status.OK) & ((found < low) | (found > high)).any(-1)] = Status.UNREACHABLE
        bad = codes != Status.OK
        q = np.where(bad[:, None], np.nan, found)
        if not self.tool:
            nothing = np.zeros((len(q), 0, q.shape[-1]))
            place = np.where(bad[:, None], np.nan, np.zeros(3))
            return Found(q, place, nothing, backwards(nothing), np.full(len(q), np.nan), codes, self._at(poses))
        place = (poses[self.tool] >> m.algebra.point(self.point)).parameters().xyz
        outputs = [self.tool, (self.tool, self.point)] if self.whole else [(self.tool, self.point)]
        matrix, status = m.jacobian(list(self.inputs), outputs, poses=poses, status=True)
        if self.whole:
            matrix = np.concatenate([self._turns(matrix[:, :6]), matrix[:, 6:]], 1)
        matrix = np.where(bad[:, None, None] | (status != Status.OK)[:, None, None], np.nan, matrix)
        condition, own = measured(matrix, codes, self.length, self.turning, len(self.inputs))
        own = np.where(~bad & (status != Status.OK), np.uint8(Status.SINGULAR), own).astype(np.uint8)
        condition = np.where(~bad & (own == Status.SINGULAR), np.inf, condition)
        return Found(
            q, np.where(bad[:, None], np.nan, place), matrix, backwards(matrix), condition, own, self._at(poses)
        )

    def _turns(self, columns: Array) -> Array:
        """Angular velocities (n, 3, k) of twists (n, 6, k)."""
        algebra = self.mechanism.algebra
        twists = algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(np.swapaxes(columns, -1, -2)))
        return np.swapaxes(np.asarray(screw_coordinates(twists))[..., :3], -1, -2)

    def _at(self, poses: Poses) -> Callable[[int], Mechanism]:
        return lambda i: self.mechanism.at({name: poses[name][i] for name in self.mechanism.moving})


__all__ = ["WHOLE", "MechanismModel"]
