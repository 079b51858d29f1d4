"""One pose or Jacobian in a call, as in a control loop: one look-up, one call of compiled code, where all is as usual.

Usual are joints of one coordinate that are driven to finite numbers, from one pose or the mechanism's own, and poses
that are found; and Jacobians that are defined, at one pose. All else is left to `solver.solve_poses` and
`jacobians.jacobians`, which have the same bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....common.dtypes import F64
from ....core.multivector import Multivector
from ....dispatch.item_plans import is_plain
from ....dispatch.multivector_data import from_buffer
from ....mechanics.joints.base import Joint
from ..arguments import check_coordinates
from ..driver import DONE, driver_of, has_coordinates
from ..loop_calls import ItemFrame
from ..structure import Assembly
from .batch import Poses
from .jacobians import CLOSED, requested
from .solver import initial_motors

Array = NDArray[Any]
#: Plans of poses that a mechanism keeps, and of Jacobians.
MOST_PLANS = 64
#: Classes of single coordinates.
_NUMBERS = (float, np.float64)


class PosePlan:
    """The search for single poses of a mechanism with some of its joints driven.

    Parameters
    ----------
    mechanism : Assembly
    joints : list of int
        In the order of the values that calls give.
    """

    def __init__(self, mechanism: Assembly, joints: list[int]) -> None:
        self._mechanism, self._driver = mechanism, driver_of(mechanism, driven=tuple(joints), targets=())
        self._shape = (len(mechanism.moving), 8)
        links = sorted(joints, key=lambda j: mechanism.tree.order.index(mechanism.tree.child_of[j]))
        speeds = mechanism.loops.relations
        self._coordinates = [(links.index(j), float(speeds[j].speeds[0])) for j in joints]
        self._home = initial_motors(mechanism, None, ())[0][0]
        self._free: list[tuple[ItemFrame, Array, Array, Array, Array]] = []  # frames that no call uses

    def _frame(self) -> tuple[ItemFrame, Array, Array, Array, Array] | None:
        driven, residual, status, follows = (
            np.zeros(n, t) for n, t in ((len(self._coordinates), float), (1, float), (1, np.int64), (1, np.int64))
        )
        frame = self._driver.pose_frame(driven, residual, status, follows)
        return None if frame is None else (frame, driven, residual, status, follows)

    def __call__(self, values: Any, start: Array | None) -> Poses | None:
        """The pose for numbers, from motors or from the mechanism's own; None where none is found."""
        try:
            found = self._free.pop()
        except IndexError:
            found = self._frame()  # type: ignore[assignment]
            if found is None:
                return None
        (run, pointers, strides, counts, places, _), driven, residual, status, follows = found
        follows[0] = start is not None
        for (place, speed), value in zip(self._coordinates, values, strict=True):
            driven[place] = value / speed
        own = np.empty(self._shape)
        given, room = from_buffer(self._home if start is None else start), from_buffer(own)
        pointers[places["given"]], pointers[places["found"]] = given, room
        run(pointers, strides, counts, 0, 1)
        new = Poses.of_item(self._mechanism, own, residual[0]) if status[0] == DONE else None
        self._free.append(found)
        return new


def solve_item(mechanism: Assembly, driven: Any, start: Any, strict: Any) -> Poses | None:
    """The pose with joints at single coordinates; None where anything is not as usual."""
    if driven.__class__ is not dict or strict.__class__ is not bool or not driven:
        return None
    own = None
    if start is not None:
        if start.__class__ is not Poses or start.mechanism is not mechanism:
            return None
        own = start.own
        if not is_plain(own, (len(mechanism.moving), 8)):
            return None
    for value in driven.values():
        if value.__class__ not in _NUMBERS or not isfinite(value):
            return None
    key = tuple([x if x.__class__ is str else id(x) for x in driven])  # of joints that the mechanism holds
    plans = mechanism.pose_plans
    plan = plans.get(key)
    if plan is None:
        joints = [mechanism.find_joint(x) if isinstance(x, Joint) or x.__class__ is str else None for x in driven]
        if not is_usual(mechanism, joints):
            return None
        if len(plans) >= MOST_PLANS:
            plans.clear()
        plan = plans[key] = PosePlan(mechanism, joints)  # type: ignore[arg-type]
    return plan(driven.values(), own)


def is_usual(mechanism: Assembly, joints: Sequence[int | None]) -> bool:
    """Whether joints have one coordinate each, and nothing couples any."""
    if mechanism.couplings or len(set(joints)) < len(joints):
        return False
    for j in joints:
        if j is None or mechanism.joints[j].mobility != 1 or not has_coordinates(mechanism, j):
            return False
        check_coordinates(mechanism, j)
    return True


class JacobianPlan:
    """Jacobians of single poses of a mechanism, from some speeds to others.

    Parameters
    ----------
    mechanism : Assembly
    inputs, outputs : object
    general : bool
    held : list
        Objects that were identified by their addresses: they stay.
    """

    def __init__(self, mechanism: Assembly, inputs: Any, outputs: Any, general: bool, held: list[Any]) -> None:
        self._held, self._general = held, general
        request = requested(mechanism, inputs, outputs)
        self._driver, self._points = request.driver, request.driver.points(request.points)
        self._is_usual = request.coupled is None and not request.closing
        self._free: list[tuple[ItemFrame, tuple[int, int], Array, Array]] = []  # frames that no call uses

    def _frame(self) -> tuple[ItemFrame, tuple[int, int], Array, Array] | None:
        residual, status = np.zeros(1), np.zeros(1, np.int64)
        found = self._driver.jacobian_frame(self._points, residual, status, self._general)
        return None if found is None else (*found, residual, status)

    def __call__(self, own: Array) -> Array | None:
        """The Jacobian at motors; None where there is none."""
        found = self._free.pop() if self._free else self._frame() if self._is_usual else None
        if found is None:
            return None
        (run, pointers, strides, counts, places, _), shape, residual, status = found
        values = np.empty(shape)
        given, room = from_buffer(own), from_buffer(values)
        pointers[places["given"]], pointers[places["jacobian"]] = given, room
        run(pointers, strides, counts, 0, 1)
        is_defined = status[0] == DONE and residual[0] <= CLOSED
        self._free.append(found)
        return values if is_defined else None


def jacobian_item(mechanism: Assembly, inputs: Any, outputs: Any, poses: Any, method: str) -> Array | None:
    """The Jacobian at a single pose; None where anything is not as usual."""
    if poses.__class__ is not Poses or poses.mechanism is not mechanism:
        return None
    own = poses.own
    if not is_plain(own, (len(mechanism.moving), 8)):
        return None
    held: list[Any] = []
    key = _key(inputs, held), _key(outputs, held), method
    if None in key:
        return None
    plans = mechanism.jacobian_plans
    plan = plans.get(key)
    if plan is None:
        if len(plans) >= MOST_PLANS:
            plans.clear()
        plan = plans[key] = JacobianPlan(mechanism, inputs, outputs, method == "general", held)
    return plan(own)


def _key(x: Any, held: list[Any]) -> Any:
    """What stands for an input or output, or several; None where it is of no usual class."""
    kind = x.__class__
    if kind is str:
        return x
    if kind in (list, tuple):
        found = (kind, *[_key(each, held) for each in x])
        return None if None in found else found
    if kind is np.ndarray:
        return (x.shape, x.tobytes()) if x.dtype is F64 else None
    if isinstance(x, Joint) or (isinstance(x, Multivector) and not x._is_writable):
        held.append(x)
        return id(x)
    return None


__all__ = ["JacobianPlan", "PosePlan", "jacobian_item", "solve_item"]
