"""Jacobians of a mechanism at a batch of poses, compiled: inputs and outputs in the order of its driver."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....codegen.errors import InputError
from ....dispatch.formulas import evaluate
from ....status import Status
from ..arguments import OUTPUT, as_list, body_and_value, check_coordinates, position_of
from ..driver import DONE, NOT_ALLOWED, NOT_FINITE, OPEN, Driver, driver_of
from ..structure import Assembly
from ..velocity_solver import twist_columns
from .batch import poses_of
from .coupled_joints import followers
from .solver import initial_motors

Array = NDArray[Any]
_STATUSES = {DONE: Status.OK, OPEN: Status.SINGULAR, NOT_ALLOWED: Status.UNREACHABLE, NOT_FINITE: Status.INVALID}
#: The same by code.
_CODES = np.array([_STATUSES[code] for code in sorted(_STATUSES)], np.uint8)
#: Methods of elimination.
METHODS = ("elimination", "general")
#: Closure error of a closed joint at most, in the mechanism's unit.
CLOSED = 1e-6


def jacobians(
    mechanism: Assembly, inputs: Any, outputs: Any, poses: Any, method: str, threads: int | None
) -> tuple[Array, Array, Array]:
    """Jacobians (..., outputs, inputs) at poses, their status and residual; see `Mechanism.jacobian`."""
    at = poses_of(mechanism, poses, "poses")
    driver, points, coupled, closing = requested(mechanism, inputs, outputs)
    motors, bad = initial_motors(mechanism, at, at.shape)
    values, residual, code = driver.jacobians(motors, driver.points(points), method == "general", threads)
    values = values if coupled is None else values @ coupled
    values = _closing_speeds(mechanism, motors, values, closing) if closing else values
    code = np.where((code == DONE) & (residual > CLOSED), NOT_ALLOWED, code)
    code[bad], values[bad], residual[bad] = NOT_FINITE, np.nan, np.nan
    values = values.reshape(*at.shape, *values.shape[-2:])
    status = np.where(at.status, at.status, _CODES[code].reshape(at.shape)).astype(np.uint8)  # why there is no pose
    return values, status, residual.reshape(at.shape)


class Request(NamedTuple):
    """A driver, points of bodies whose velocities are requested, the map from the inputs' speeds to those of the
    driver, where some joints follow others, and joints that close loops, each with the first row of what is requested
    for it: the twists of those of its bodies that can move.
    """

    driver: Driver
    points: list[Array]
    coupled: Array | None
    closing: list[tuple[int, int]]


def requested(mechanism: Assembly, inputs: Any, outputs: Any) -> Request:
    """Inputs and outputs as in `Mechanism.jacobian`, checked."""
    driven, target, coupled = _inputs(mechanism, inputs)
    speeds, points, closing = _outputs(mechanism, outputs)
    driver = driver_of(
        mechanism, driven=tuple(driven), targets=() if target is None else ((target[0], None),),
        inputs=None if target is None else target[1], outputs=speeds,
    )  # fmt: skip
    return Request(driver, points, coupled, closing)


def _inputs(mechanism: Assembly, inputs: Any) -> tuple[list[int], tuple[int, Array] | None, Array | None]:
    """Driven joints, the body that is an input; and the map from the inputs' speeds to those of the driver, where some
    joints follow others.
    """
    driven: list[int] = []
    target: tuple[int, Array] | None = None
    for x in as_list(inputs):
        j = mechanism.find_joint(x)
        if j is not None:
            check_coordinates(mechanism, j, "an input")
            if j in driven:
                raise InputError(f"{mechanism.joint_names[j]} is given twice.")
            driven.append(j)
            continue
        if target is not None:
            raise InputError("one body at most is an input at many poses; others are joints.")
        name, twists = body_and_value(x, "twists")
        matrix = np.eye(6) if twists is None else twist_columns(mechanism, name, twists)
        target = (mechanism.body_index(name), matrix)
        if target[0] < 0:
            raise InputError(f"{name!r} is fixed, and cannot be given a speed.")
    if not driven and (target is None or not target[1].size):
        raise InputError("there are no inputs; a joint or a body is needed.")
    coupled = _with_followers(mechanism, driven, 0 if target is None else target[1].shape[1])
    return driven, target, coupled


def _with_followers(mechanism: Assembly, driven: list[int], more: int) -> Array | None:
    """Add joints that follow driven ones; if there are any, the matrix from speeds of the inputs to those of all."""
    starts, at = {}, 0
    for j in driven:
        starts[j] = at
        at += len(mechanism.loops.relations[j].speeds)
    rows, inputs = [np.eye(at)], at
    for j, terms in followers(mechanism, driven):
        every = np.concatenate(rows)
        rows.append(sum((ratio * every[None, starts[i] + k] for i, k, ratio in terms), np.zeros((1, inputs))))
        driven.append(j)
        starts[j] = at
        at += 1
    if at == inputs:
        return None
    matrix = np.zeros((at + more, inputs + more))
    matrix[:at, :inputs], matrix[at:, inputs:] = np.concatenate(rows), np.eye(more)
    return matrix


def _outputs(
    mechanism: Assembly, outputs: Any
) -> tuple[tuple[tuple[int] | tuple[int, bool], ...], list[Array], list[tuple[int, int]]]:
    """The outputs as `DriverRequest` has them, their points, and joints that close loops as `Request` has them."""
    requested = as_list(outputs)
    if not requested:
        raise InputError("there are no outputs; a joint or a body is needed.")
    found: list[tuple[int] | tuple[int, bool]] = []
    points, closing, row = [], [], 0
    for x in requested:
        joint = mechanism.find_joint(x)
        if joint is not None:
            check_coordinates(mechanism, joint, OUTPUT)
            if joint in mechanism.tree.child_of:
                found.append((joint,))
                row += len(mechanism.loops.relations[joint].speeds)
            else:
                ends = [body for body in mechanism.tree.ends[joint] if body >= 0]
                found += [(body, False) for body in ends]
                closing.append((joint, row))
                row += 6 * len(ends)
            continue
        name, point = body_and_value(x, "point")
        if mechanism.body_index(name) < 0:
            raise InputError(f"{name!r} is fixed, and not an output.")
        found.append((mechanism.body_index(name), point is not None))
        row += 6 if point is None else 3
        if point is not None:
            points.append(position_of(point, f"the point of {name!r}"))
    return tuple(found), points, closing


def _closing_speeds(mechanism: Assembly, motors: Array, values: Array, closing: list[tuple[int, int]]) -> Array:
    """Jacobians (items, outputs, inputs) with the speeds of joints that close loops, from the twists of their bodies.

    Like those of the tree's joints, they are along axes that move with the first body.
    """
    parts, done = [], 0
    for joint, row in closing:
        parts.append(values[:, done:row])
        relative, done = np.zeros((len(values), 6, values.shape[2])), row
        to_first = np.eye(6)
        for body, sign in zip(mechanism.tree.ends[joint], (-1, 1), strict=True):
            if body >= 0:
                relative += sign * values[:, done : done + 6]
                done += 6
                if sign < 0:
                    algebra = mechanism.algebra
                    motor = algebra.wrap(algebra.kind("motor"), np.ascontiguousarray(motors[:, body]))
                    to_first = evaluate(algebra, "mechanics.adjoint", motor).value.reshape(-1, 6, 6)
        to_coordinates = mechanism.loops.relations[joint].to_coordinates
        parts.append(to_coordinates @ (to_first @ (mechanism.from_world @ relative)))
    return np.concatenate([*parts, values[:, done:]], 1)
