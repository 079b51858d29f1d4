"""Poses of mechanisms in batches: driven joints, targets of bodies, paths; and Jacobians at many poses at once."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import arrays
from ..calls import call, raise_first
from ..codegen.errors import InputError, ShapeError, suggest
from ..dynamics.given import shown
from ..dynamics.screws import velocity_at
from ..lengths import length_powers
from ..multivector import Multivector
from ..status import Status
from ..text import statuses
from .analysis import body_and, coordinates_of, listed, place_of
from .driver import DONE, LATE, NOT_ALLOWED, NOT_FINITE, OPEN, STUCK, Driver
from .inputs import twist_columns
from .ways import common_shape, filled, motors_of, way_to

if TYPE_CHECKING:
    from .mechanism import Mechanism

Array = NDArray[Any]
_OF_POSES = {DONE: Status.OK, STUCK: Status.UNREACHABLE, LATE: Status.NOT_CONVERGED, NOT_FINITE: Status.INVALID}
_OF_JACOBIANS = {DONE: Status.OK, OPEN: Status.SINGULAR, NOT_ALLOWED: Status.UNREACHABLE, NOT_FINITE: Status.INVALID}
#: The same by code.
_POSES, _JACOBIANS = (np.array([x[c] for c in sorted(x)], np.uint8) for x in (_OF_POSES, _OF_JACOBIANS))
#: How Jacobians at many poses are found.
METHODS = ("elimination", "general")
#: Joints that share so little, in the mechanism's unit, are closed.
CLOSED = 1e-6


class Poses(Mapping[str, Multivector]):
    """Poses of a mechanism: motors (...) of bodies by name, from where they are in the mechanism itself; NaN where no
    pose is found.

    Attributes
    ----------
    mechanism : Mechanism
    own : array (..., bodies, 8)
        Motors of the bodies of `moving`, in the mechanism's frame.
    residual : array (...)
        The largest error of a joint or target, in the mechanism's unit of length.
    status : array of Status (...)
        OK; UNREACHABLE: no pose nearby has the targets; NOT_CONVERGED; INVALID: input is not finite.
    """

    def __init__(self, mechanism: Mechanism, own: Array, residual: Array, status: Array) -> None:
        self.mechanism, self.own, self.residual = mechanism, own, residual
        self.status = statuses(status, status.shape)

    @cached_property
    def _motors(self) -> Array:
        return self.mechanism.motors_to_world(self.own)

    def __getitem__(self, body: str) -> Multivector:
        b, algebra = self.mechanism.number(body), self.mechanism.algebra
        if b < 0:
            rest = np.zeros((*self.shape, 8))
            rest[..., algebra.kind("motor").blades.index(0)] = 1
            return algebra.wrap(algebra.kind("motor"), rest)
        return algebra.wrap(algebra.kind("motor"), np.ascontiguousarray(self._motors[..., b, :]))

    def __iter__(self) -> Any:
        return iter(self.mechanism.bodies)

    def __len__(self) -> int:
        return len(self.mechanism.bodies)

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the batch."""
        return self.own.shape[:-2]

    def __repr__(self) -> str:
        bad = int(np.count_nonzero(self.status))
        return f"<Poses {self.shape} of {self.mechanism!r}{f'; {bad} not found' if bad else ''}>"

    def coordinates(self, joint: Any) -> Array:
        """Coordinates (..., f) of a joint, from where it is in the mechanism itself; turns in (-pi, pi]."""
        m = self.mechanism
        j = m.find_joint(joint)
        if j is None:
            raise InputError(f"{joint!r} is no joint of this mechanism.")
        relation = m.loops.relations[j]
        a, b = (self[name] for name in (m.joints[j].a, m.joints[j].b))
        relative = m.motors_from_world((~a * b).as_kind("motor", check=False).values)
        algebra = m.algebra
        one = np.zeros_like(relative)
        one[..., algebra.kind("motor").blades.index(0)] = 1
        kind = algebra.kind("motor")
        twist = call(algebra, "joints.way", algebra.wrap(kind, one), algebra.wrap(kind, relative)).value
        found: Array = twist.values @ np.linalg.pinv(relation.free).T * relation.speeds
        return found


def solved_poses(
    mechanism: Mechanism, driven: Mapping[Any, Any], targets: Mapping[Any, Any], start: Any, path: bool,
    threads: int | None, strict: bool,
) -> Poses:  # fmt: skip
    """See `Mechanism.solve_pose`."""
    joints, aims = _driven(mechanism, driven), _targets(mechanism, targets)
    driver = mechanism.driver(
        driven=tuple(joints), targets=tuple((body, None if p is None else tuple(p)) for body, p, _ in aims)
    )
    begin = None if start is None else _poses_of(mechanism, start, "start")
    shape = common_shape(
        {} if begin is None else {"start": begin.shape},
        {f"the coordinates of {mechanism.joint_names[j]}": v.shape[:-1] for j, v in joints.items()},
        {f"the target of {mechanism.moving[b]!r}": v.shape[:-1] for b, _, v in aims},
    )
    if path and not shape:
        raise ShapeError("a path has an axis of steps: values (..., steps).")
    count = int(np.prod(shape))
    links, bad = _links(mechanism, driver, begin, shape, threads)
    given = [np.broadcast_to(v, (*shape, v.shape[-1])) for v in (*joints.values(), *(v for *_, v in aims))]
    bad = bad.reshape(shape) | np.any([~np.isfinite(v).all(-1) for v in given], 0)
    given = [filled(v, bad, path) for v in given]
    ways = {j: way_to(mechanism, j, begin, v, path) for j, v in zip(joints, given, strict=False)}
    order = sorted(ways, key=lambda j: driver.order.index(mechanism.tree.hung_by[j]))
    to_go = np.concatenate([np.zeros((*shape, 0)), *(ways[j] for j in order)], -1)
    wanted = np.concatenate([np.zeros((*shape, 0)), *given[len(joints) :]], -1)
    rows = [np.array(x.reshape(count, x.shape[-1]), order="C") for x in (to_go, wanted)]
    motors, residual, code = driver.poses(links, rows[0], rows[1], threads, shape[-1] if path and count else 1)
    status = _POSES[code].reshape(shape)
    found = np.empty((count, len(mechanism.moving), 8))
    found[:, driver.order] = motors
    found[(code != DONE) | bad.ravel()] = np.nan
    status[bad], residual[bad.ravel()] = Status.INVALID, np.nan
    poses = Poses(mechanism, found.reshape(*shape, *found.shape[1:]), residual.reshape(shape), status)
    if strict:
        raise_first(status, "pose")
    return poses


def _named(x: Any, what: str) -> Mapping[Any, Any]:
    if not isinstance(x, Mapping):
        raise InputError(f"{what} is {shown(x)}; a mapping is needed.")
    return x


def _driven(mechanism: Mechanism, driven: Mapping[Any, Any]) -> dict[int, Array]:
    found: dict[int, Array] = {}
    for x, values in _named(driven, "driven").items():
        j = mechanism.find_joint(x)
        if j is None:
            raise InputError(
                f"{x!r} is no joint of this mechanism; joints can be driven.{suggest(str(x), mechanism.joint_names)}"
            )
        if j in found:
            raise InputError(f"{mechanism.joint_names[j]} is driven twice.")
        name, count = mechanism.joint_names[j], len(mechanism.loops.relations[j].speeds)
        given = np.asarray(arrays.real(values, f"the coordinate of {name}"), float)
        given = given[..., None] if count == 1 else given
        if given.shape[-1:] != (count,):
            raise ShapeError(f"the coordinates of {name} have shape {given.shape}; they end in {count}.")
        _check_coordinates(mechanism, j)
        found[j] = given
    return found


def _check_coordinates(mechanism: Mechanism, joint: int) -> None:
    name = mechanism.joint_names[joint]
    if joint not in mechanism.tree.hung_by:
        raise InputError(
            f"{name} closes a loop, and has no coordinate.", remedy="Take another joint of it, or its bodies"
        )
    if any(c.product is not None for c in mechanism.joints[joint].conditions()):
        raise InputError(f"{name} has freedoms that change with the pose, and no coordinate.", remedy="Take its bodies")


def _targets(mechanism: Mechanism, targets: Mapping[Any, Any]) -> list[tuple[int, Any, Array]]:
    """(body, point or None, numbers): motors, or places, in the mechanism's frame."""
    found: list[tuple[int, Any, Array]] = []
    frame = mechanism.frame
    for name, given in _named(targets, "targets").items():
        point, value = given if isinstance(given, tuple) and len(given) == 2 else (None, given)
        body = mechanism.number(name)
        if body < 0:
            raise InputError(f"{name!r} is fixed, and has no target.")
        if point is None:
            found.append(
                (body, None, mechanism.motors_from_world(motors_of(mechanism, value, f"the target of {name!r}")))
            )
        else:
            at = place_of(point, f"the point of {name!r}")
            what = f"the place of a point of {name!r}"
            to = np.asarray(coordinates_of(value, what) if isinstance(value, Multivector) else arrays.real(value, what))
            if to.shape[-1:] != (3,):
                raise ShapeError(f"the place of a point of {name!r} has shape {to.shape}; it ends in 3.")
            found.append((body, at, (to - frame.center) / frame.unit))
    return found


def _poses_of(mechanism: Mechanism, x: Any, what: str) -> Poses:
    """Poses of this mechanism, or motors of bodies by name."""
    if not isinstance(x, Poses):
        return _given_poses(mechanism, x)
    if x.mechanism is not mechanism:
        raise InputError(f"{what} is of another mechanism.", remedy="Give motors by body, as dict(poses) has them")
    return x


def _given_poses(mechanism: Mechanism, motors: Mapping[str, Multivector]) -> Poses:
    """Motors of bodies, by name, as poses; bodies that are not named are where they are."""
    if not isinstance(motors, Mapping):
        raise InputError(f"poses are a mapping of bodies to motors, or Poses, not a {type(motors).__name__}.")
    algebra = mechanism.algebra
    given = {}
    for name, motor in motors.items():
        if mechanism.number(name) >= 0:
            given[name] = motors_of(mechanism, motor, f"the motor of {name!r}")
    shape = common_shape({f"the motor of {name!r}": x.shape[:-1] for name, x in given.items()})
    values = np.zeros((*shape, len(mechanism.moving), 8))
    values[..., algebra.kind("motor").blades.index(0)] = 1
    for name, own in given.items():
        values[..., mechanism.number(name), :] = own
    return Poses(mechanism, mechanism.motors_from_world(values), np.zeros(shape), np.zeros(shape, np.uint8))


def _links(
    mechanism: Mechanism, driver: Driver, begin: Poses | None, shape: tuple[int, ...], threads: int | None
) -> tuple[Array, Array]:
    """Links (items, bodies, 8) to begin with, and which items (items,) have none."""
    count, bodies = int(np.prod(shape)), len(mechanism.moving)
    links, bad = np.zeros((count, bodies, 8)), np.zeros(count, bool)
    links[..., mechanism.algebra.kind("motor").blades.index(0)] = 1
    if begin is None or not bodies:
        return links, bad
    motors = np.broadcast_to(begin.own, (*shape, bodies, 8)).reshape(count, bodies, 8)
    bad = ~np.isfinite(motors).all((-1, -2))
    if bad.any():
        motors = np.where(bad[:, None, None], links, motors)
    return driver.links(np.ascontiguousarray(motors[:, driver.order]), threads), bad


def jacobians(
    mechanism: Mechanism, inputs: Any, outputs: Any, poses: Any, method: str, threads: int | None
) -> tuple[Array, Array, Array]:
    """Jacobians (..., outputs, inputs) at poses, their status and residual; see `Mechanism.jacobian`."""
    at = _poses_of(mechanism, poses, "poses")
    driven, target, speeds = _inputs(mechanism, inputs)
    bodies, coordinates, parts = _outputs(mechanism, outputs)
    driver = mechanism.driver(
        driven=tuple(driven), targets=() if target is None else ((target[0], None),),
        inputs=None if target is None else target[1], outputs=tuple(bodies), coordinates=tuple(coordinates),
    )  # fmt: skip
    links, bad = _links(mechanism, driver, at, at.shape, threads)
    raw, residual, code = driver.jacobians(links, method == "general", threads)
    raw = raw * np.concatenate([1 / speeds, np.ones(raw.shape[-1] - len(speeds))])
    found = [_read(mechanism, at, raw, part) for part in parts]
    values = np.concatenate(found, -2)[..., _order(mechanism, driver, driven, raw.shape[-1])]
    code = np.where((code == DONE) & (residual > CLOSED), NOT_ALLOWED, code)
    code[bad], values[bad], residual[bad] = NOT_FINITE, np.nan, np.nan
    values = values.reshape(*at.shape, *values.shape[-2:])
    status = _JACOBIANS[code].reshape(at.shape)
    return values, status, residual.reshape(at.shape)


def _order(mechanism: Mechanism, driver: Driver, driven: list[int], count: int) -> list[int]:
    """Columns of the driver in the order of the inputs: it has driven joints as links go."""
    links = sorted(driven, key=lambda j: driver.order.index(mechanism.tree.hung_by[j]))
    starts, at = {}, 0
    for j in links:
        starts[j] = at
        at += len(mechanism.loops.relations[j].speeds)
    own = [starts[j] + k for j in driven for k in range(len(mechanism.loops.relations[j].speeds))]
    return [*own, *range(at, count)]


def _inputs(mechanism: Mechanism, inputs: Any) -> tuple[list[int], tuple[int, Array] | None, Array]:
    driven: list[int] = []
    target: tuple[int, Array] | None = None
    for x in listed(inputs):
        j = mechanism.find_joint(x)
        if j is not None:
            if j not in mechanism.tree.hung_by or mechanism.joints[j].conditions()[0].product is not None:
                raise InputError(
                    f"{mechanism.joint_names[j]} closes a loop, or has no coordinates: it is no input here."
                )
            if j in driven:
                raise InputError(f"{mechanism.joint_names[j]} is given twice.")
            driven.append(j)
            continue
        if target is not None:
            raise InputError("one body at most is an input at many poses; others are joints.")
        name, twists = body_and(x, "twists")
        matrix = np.eye(6) if twists is None else twist_columns(mechanism, name, twists)
        target = (mechanism.number(name), matrix)
        if target[0] < 0:
            raise InputError(f"{name!r} is fixed, and can not be given a speed.")
    if not driven and (target is None or not target[1].size):
        raise InputError("there are no inputs; a joint or a body is needed.")
    order = sorted(driven, key=lambda j: mechanism.tree.order.index(mechanism.tree.hung_by[j]))
    speeds = [mechanism.loops.relations[j].speeds for j in order]
    return driven, target, np.concatenate([np.zeros(0), *speeds])


def _outputs(mechanism: Mechanism, outputs: Any) -> tuple[list[int], list[int], list[tuple[str, Any, Any]]]:
    """Bodies and joints asked for, and for each output what it is, where it is among these, and what else it takes."""
    bodies: list[int] = []
    joints: list[int] = []
    parts: list[tuple[str, Any, Any]] = []
    for x in listed(outputs):
        j = mechanism.find_joint(x)
        if j is not None:
            if j not in mechanism.tree.hung_by or mechanism.joints[j].conditions()[0].product is not None:
                raise InputError(
                    f"{mechanism.joint_names[j]} closes a loop, or has no coordinates: ask for its bodies."
                )
            joints.append(j)
            parts.append(("joint", len(joints) - 1, joints))
            continue
        name, point = body_and(x, "point")
        body = mechanism.number(name)
        if body < 0:
            raise InputError(f"{name!r} is fixed, and no output.")
        if body not in bodies:
            bodies.append(body)
        place = None if point is None else place_of(point, f"the point of {name!r}")
        parts.append(("body", bodies.index(body), (bodies, name, place)))
    if not parts:
        raise InputError("there are no outputs; a joint or a body is needed.")
    return bodies, joints, parts


def _read(mechanism: Mechanism, at: Poses, raw: Array, part: tuple[str, Any, Any]) -> Array:
    """One output (items, rows, inputs) in the world's units."""
    what, k, more = part
    if what == "joint":
        bodies = (raw.shape[-2] - sum(len(mechanism.loops.relations[j].speeds) for j in more)) // 6
        first = 6 * bodies + sum(len(mechanism.loops.relations[j].speeds) for j in more[:k])
        speeds = mechanism.loops.relations[more[k]].speeds
        return np.asarray(raw[:, first : first + len(speeds)] * speeds[:, None])
    _, name, place = more
    twists = np.einsum("ij,njk->nik", mechanism.to_world, raw[:, 6 * k : 6 * k + 6])
    if place is None:
        return np.asarray(twists)
    moved = (at[name] >> mechanism.algebra.point(place)).parameters().xyz.reshape(-1, 1, 3)
    algebra = mechanism.algebra
    columns = algebra.wrap(algebra.kind("twist"), np.ascontiguousarray(np.swapaxes(twists, -1, -2)))
    return np.swapaxes(velocity_at(columns, moved), -1, -2)


def scaled_motors(mechanism: Mechanism, values: Array, back: bool) -> Array:
    """Motors (..., 8) of the mechanism's frame in the world's, or back."""
    algebra, frame = mechanism.algebra, mechanism.frame
    kind = algebra.kind("motor")
    scales = frame.unit ** length_powers(algebra, kind.blades).astype(float)
    shift = algebra.translator(frame.center)
    if back:
        motor = algebra.wrap(kind, np.ascontiguousarray(values, float))
        return np.asarray((~shift * motor * shift).as_kind("motor", check=False).values / scales)
    motor = algebra.wrap(kind, np.ascontiguousarray(values * scales))
    return np.asarray((shift * motor * ~shift).as_kind("motor", check=False).values)
