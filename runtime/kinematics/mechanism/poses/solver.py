"""Pose solver of mechanisms, in batches: driven joints, targets of bodies, paths."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....codegen.errors import InputError, ShapeError, suggest
from ....codegen.interrupts import keep_partial
from ....common.executors import Task, fill_parts
from ....common.progress import ProgressOption, open_progress
from ....common.validation import as_bool, as_instance, broadcast_shapes, check_shape, real_array
from ....core.multivector import Multivector
from ....dispatch.item_statuses import raise_first
from ....status import Status
from ..arguments import check_coordinates, point_coordinates, position_of
from ..driver import DONE, LATE, NOT_FINITE, STUCK, Driver, driver_of
from ..reachability import is_too_far
from ..structure import Assembly
from .batch import Poses, motor_coefficients, poses_of
from .coupled_joints import add_followers
from .targets import forward_fill, wanted_coordinates

Array = NDArray[Any]
_OF_POSES = {DONE: Status.OK, STUCK: Status.NOT_CONVERGED, LATE: Status.NOT_CONVERGED, NOT_FINITE: Status.INVALID}
#: The same by code.
_POSES = np.array([_OF_POSES[code] for code in sorted(_OF_POSES)], np.uint8)
#: Poses that are worth a call of an executor: some ten milliseconds of work.
POSES_PER_CALL = 256


def solve_poses(
    mechanism: Assembly, driven: Mapping[Any, Any], targets: Mapping[Any, Any], start: Any, path: bool,
    threads: int | None, strict: bool, progress: ProgressOption, executor: Executor | None,
) -> Poses:  # fmt: skip
    """See `Mechanism.solve_pose`."""
    joints, aims = add_followers(mechanism, _driven_joints(mechanism, driven)), _targets(mechanism, targets)
    raises = as_bool(strict, "strict")
    request = {
        "driven": tuple(joints), "targets": tuple((body, None if p is None else tuple(p)) for body, p, _ in aims)
    }  # fmt: skip
    driver = driver_of(mechanism, **request)
    begin = None if start is None else poses_of(mechanism, start, "start")
    shape = broadcast_shapes(
        {} if begin is None else {"start": begin.shape},
        {f"the coordinates of {mechanism.joint_names[j]}": v.shape[:-1] for j, v in joints.items()},
        {f"the target of {mechanism.moving[b]!r}": v.shape[:-1] for b, _, v in aims},
    )
    if path and not shape:
        raise ShapeError("a path has an axis of steps: values (..., steps).")
    count = int(np.prod(shape))
    motors, bad = initial_motors(mechanism, begin, shape)
    given = [np.broadcast_to(v, (*shape, v.shape[-1])) for v in (*joints.values(), *(v for *_, v in aims))]
    bad = bad.reshape(shape) | np.any([~np.isfinite(v).all(-1) for v in given], 0)
    given = [forward_fill(v, bad, path) for v in given]
    ways = {j: wanted_coordinates(mechanism, j, begin, v, path) for j, v in zip(joints, given, strict=False)}
    order = sorted(ways, key=lambda j: mechanism.tree.order.index(mechanism.tree.child_of[j]))
    coordinates = np.concatenate([np.zeros((*shape, 0)), *(ways[j] for j in order)], -1)
    goals = np.concatenate([np.zeros((*shape, 0)), *given[len(joints) :]], -1)
    steps = shape[-1] if path and count else 1
    paths = count // steps
    first = np.ascontiguousarray(motors.reshape(paths, steps, *motors.shape[1:])[:, 0])
    coordinates, goals = (x.reshape(paths, steps, x.shape[-1]) for x in (coordinates, goals))
    results = driver.blank_poses(paths, steps)

    def poses() -> Poses:
        own, residual, code = (results[name].reshape(count, *results[name].shape[2:]) for name in results)
        status = _POSES[code].reshape(shape)
        missed = np.flatnonzero(status == Status.NOT_CONVERGED)
        if len(missed):
            rows = [v.reshape(count, v.shape[-1])[missed] for v in given]
            aimed = [(body, at, v) for (body, at, _), v in zip(aims, rows[len(joints) :], strict=True)]
            far = is_too_far(mechanism, dict(zip(joints, rows, strict=False)), aimed, len(missed))
            status.flat[missed[far]] = Status.UNREACHABLE
        own[(code != DONE) | bad.ravel()] = np.nan
        status[bad], residual[bad.ravel()] = Status.INVALID, np.nan
        return Poses(mechanism, own.reshape(*shape, *own.shape[1:]), residual.reshape(shape), status)

    with open_progress(progress, "poses", "poses", count) as report, keep_partial(poses):
        if executor is None:
            tell = None if progress is False else lambda n: report(n * steps)
            driver.poses(first, coordinates, goals, results, begin is not None, threads, tell)
        else:
            task, grain = _PoseTask(mechanism, request, begin is not None, threads), max(1, POSES_PER_CALL // steps)
            columns = (first, coordinates, goals)
            fill_parts(executor, task, _solve_part, columns, "poses", results, lambda n: report(n * steps), grain)
    solved = poses()
    if raises:
        raise_first(np.asarray(solved.status, np.uint8), "pose")
    return solved


@dataclass(frozen=True, eq=False)
class _PoseTask(Task):
    """A mechanism, which of its joints are driven, which bodies have targets, whether coordinates follow a start."""

    mechanism: Assembly
    request: dict[str, Any]
    follows: bool
    threads: int | None

    def prepare(self) -> tuple[Driver, bool, int]:
        return driver_of(self.mechanism, **self.request), self.follows, 1 if self.threads is None else self.threads


def _solve_part(state: tuple[Driver, bool, int], motors: Array, driven: Array, targets: Array) -> dict[str, Array]:
    driver, follows, threads = state
    results = driver.blank_poses(*driven.shape[:2])
    driver.poses(motors, driven, targets, results, follows, threads)
    return results


def _driven_joints(mechanism: Assembly, driven: Mapping[Any, Any]) -> dict[int, Array]:
    found: dict[int, Array] = {}
    for x, values in as_instance(driven, "driven", Mapping, "a mapping").items():
        j = mechanism.find_joint(x)
        if j is None:
            raise InputError(
                f"{x!r} is not a joint of this mechanism; joints can be driven.{suggest(str(x), mechanism.joint_names)}"
            )
        if j in found:
            raise InputError(f"{mechanism.joint_names[j]} is driven twice.")
        name, count = mechanism.joint_names[j], len(mechanism.loops.relations[j].speeds)
        given = np.asarray(real_array(values, f"the coordinate of {name}"), float)
        given = given[..., None] if count == 1 else given
        check_shape(given, f"the coordinates of {name}", (..., count))
        check_coordinates(mechanism, j)
        found[j] = given
    return found


def _targets(mechanism: Assembly, targets: Mapping[Any, Any]) -> list[tuple[int, Any, Array]]:
    """Targets (body, point or None, motors or positions) in the mechanism's frame."""
    found: list[tuple[int, Any, Array]] = []
    frame = mechanism.frame
    for name, given in as_instance(targets, "targets", Mapping, "a mapping").items():
        point, value = given if isinstance(given, tuple) and len(given) == 2 else (None, given)
        body = mechanism.body_index(name)
        if body < 0:
            raise InputError(f"{name!r} is fixed, and has no target.")
        if point is None:
            found.append(
                (
                    body,
                    None,
                    mechanism.motors_from_world(motor_coefficients(mechanism, value, f"the target of {name!r}")),
                )
            )
        else:
            at = position_of(point, f"the point of {name!r}")
            what = f"the place of a point of {name!r}"
            to = np.asarray(
                point_coordinates(value, what) if isinstance(value, Multivector) else real_array(value, what)
            )
            check_shape(to, f"the place of a point of {name!r}", (..., 3))
            found.append((body, at, (to - frame.center) / frame.unit))
    return found


def initial_motors(mechanism: Assembly, begin: Poses | None, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Motors (items, bodies, 8) to start from, and the mask (items,) of those that are not finite."""
    count, bodies = int(np.prod(shape)), len(mechanism.moving)
    own, bad = np.zeros((count, bodies, 8)), np.zeros(count, bool)
    own[..., mechanism.algebra.kind("motor").blades.index(0)] = 1
    if begin is None or not bodies:
        return own, bad
    motors = np.broadcast_to(np.asarray(begin.own, np.float64), (*shape, bodies, 8)).reshape(count, bodies, 8)
    bad = np.asarray(~np.isfinite(motors).all((-1, -2)))
    return np.where(bad[:, None, None], own, motors) if bad.any() else np.ascontiguousarray(motors), bad
