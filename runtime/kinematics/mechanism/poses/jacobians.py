"""Jacobians of a mechanism at a batch of poses, compiled: inputs and outputs in the order of its driver."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....codegen.errors import InputError
from ....mechanics.screws import velocity_at
from ....status import Status
from ..arguments import as_list, body_and_value, check_coordinates, position_of
from ..driver import DONE, NOT_ALLOWED, NOT_FINITE, OPEN, driver_of
from ..structure import Assembly
from ..velocity_solver import twist_columns
from .batch import Poses, poses_of
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


class _Output(NamedTuple):
    """An output and its offset in the driver's rows: speeds of a joint, twist of a body, or velocity of its point."""

    first: int
    joint: int | None
    body: str
    point: Array | None


def jacobians(
    mechanism: Assembly, inputs: Any, outputs: Any, poses: Any, method: str, threads: int | None
) -> tuple[Array, Array, Array]:
    """Jacobians (..., outputs, inputs) at poses, their status and residual; see `Mechanism.jacobian`."""
    at = poses_of(mechanism, poses, "poses")
    driven, target, speeds, coupled = _inputs(mechanism, inputs)
    bodies, coordinates, parts = _outputs(mechanism, outputs)
    driver = driver_of(
        mechanism, driven=tuple(driven), targets=() if target is None else ((target[0], None),),
        inputs=None if target is None else target[1], outputs=tuple(bodies), coordinates=tuple(coordinates),
    )  # fmt: skip
    motors, bad = initial_motors(mechanism, at, at.shape)
    raw, residual, code = driver.jacobians(motors, method == "general", threads)
    raw = raw * np.concatenate([1 / speeds, np.ones(raw.shape[-1] - len(speeds))])
    found = [_read(mechanism, at, raw, part) for part in parts]
    values = np.concatenate(found, -2)[..., _order(mechanism, driven, raw.shape[-1])]
    values = values if coupled is None else values @ coupled
    code = np.where((code == DONE) & (residual > CLOSED), NOT_ALLOWED, code)
    code[bad], values[bad], residual[bad] = NOT_FINITE, np.nan, np.nan
    values = values.reshape(*at.shape, *values.shape[-2:])
    status = _CODES[code].reshape(at.shape)
    return values, status, residual.reshape(at.shape)


def _order(mechanism: Assembly, driven: list[int], count: int) -> list[int]:
    """Columns of the driver in the order of the inputs: it has driven joints in the order of links."""
    links = sorted(driven, key=lambda j: mechanism.tree.order.index(mechanism.tree.child_of[j]))
    starts, at = {}, 0
    for j in links:
        starts[j] = at
        at += len(mechanism.loops.relations[j].speeds)
    own = [starts[j] + k for j in driven for k in range(len(mechanism.loops.relations[j].speeds))]
    return [*own, *range(at, count)]


def _inputs(mechanism: Assembly, inputs: Any) -> tuple[list[int], tuple[int, Array] | None, Array, Array | None]:
    """Driven joints, the body that is an input, units of the joints' speeds; and the map from the inputs' speeds to
    those of the driver, where joints follow others."""
    driven: list[int] = []
    target: tuple[int, Array] | None = None
    for x in as_list(inputs):
        j = mechanism.find_joint(x)
        if j is not None:
            check_coordinates(mechanism, j)
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
    order = sorted(driven, key=lambda j: mechanism.tree.order.index(mechanism.tree.child_of[j]))
    speeds = [mechanism.loops.relations[j].speeds for j in order]
    return driven, target, np.concatenate([np.zeros(0), *speeds]), coupled


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


def _outputs(mechanism: Assembly, outputs: Any) -> tuple[list[int], list[int], list[_Output]]:
    """Bodies and joints of the outputs in the driver's order, all twists, then all speeds; and each output."""
    requested = [(mechanism.find_joint(x), x) for x in as_list(outputs)]
    if not requested:
        raise InputError("there are no outputs; a joint or a body is needed.")
    named = {k: body_and_value(x, "point") for k, (joint, x) in enumerate(requested) if joint is None}
    for name, _ in named.values():
        if mechanism.body_index(name) < 0:
            raise InputError(f"{name!r} is fixed, and not an output.")
    bodies = list(dict.fromkeys(mechanism.body_index(name) for name, _ in named.values()))
    joints: list[int] = []
    found, row = [], 6 * len(bodies)
    for k, (joint, _) in enumerate(requested):
        if joint is not None:
            check_coordinates(mechanism, joint)
            joints.append(joint)
            found.append(_Output(row, joint, "", None))
            row += len(mechanism.loops.relations[joint].speeds)
            continue
        name, point = named[k]
        point = None if point is None else position_of(point, f"the point of {name!r}")
        found.append(_Output(6 * bodies.index(mechanism.body_index(name)), None, name, point))
    return bodies, joints, found


def _read(mechanism: Assembly, at: Poses, raw: Array, output: _Output) -> Array:
    """One output (items, rows, inputs) in the world's units."""
    first, joint, name, point = output
    if joint is not None:
        speeds = mechanism.loops.relations[joint].speeds
        return np.asarray(raw[:, first : first + len(speeds)] * speeds[:, None])
    twists = np.einsum("ij,njk->nik", mechanism.to_world, raw[:, first : first + 6])
    if point is None:
        return np.asarray(twists)
    moved = (at[name] >> mechanism.algebra.point(point)).parameters().xyz.reshape(-1, 1, 3)
    algebra = mechanism.algebra
    columns = algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(np.swapaxes(twists, -1, -2)))
    return np.swapaxes(velocity_at(columns, moved), -1, -2)
