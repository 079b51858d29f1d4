"""Inverse kinematics of serial chains: arguments, results and statuses; the search is compiled."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...codegen.errors import InputError
from ...codegen.interrupts import keep_partial
from ...common.executors import Task, fill_parts
from ...common.progress import ProgressOption, open_progress
from ...common.validation import as_bool, as_int, broadcast_shapes, positive_float
from ...core.multivector import Multivector
from ...dispatch.formulas import evaluate
from ...dispatch.item_statuses import raise_first
from ...dispatch.multivector_data import Statuses
from ...status import Status
from .data import SerialChainData
from .driver import GRAIN, SearchOptions
from .reachability import REACH_MARGIN, is_beyond

Array = NDArray[Any]
#: Targets that are worth a call of an executor: some ten milliseconds of work.
TARGETS_PER_CALL = 512
#: Most iterations, and most attempts.
MOST = 1_000_000
#: Seed of the starts of further attempts.
SEED = 0
#: Half range of the starts of further attempts for joints without limits, in radians or the chain's lengths.
RANGE = np.pi


@dataclass(frozen=True)
class Solution:
    """Coordinates that bring the tool to its targets. Unpacks as two: ``q, status = chain.inverse(...)``.

    Attributes
    ----------
    q : array (..., n)
        NaN where the target was not reached, unless the nearest was requested.
    status : array (...) of codes, or Status
        OK; NOT_UNIQUE: reached at a singular pose, where others reach it too, or q is known to half the digits;
        UNREACHABLE: proved to be beyond reach, see `Chain.inverse`; NOT_CONVERGED: not found, by attempts that came to
        rest or ran out of iterations, and more may find it; INVALID: target or start is not finite, or the
        target R is not unit (the scalar part of R ~R differs from 1 by 1e-5 or more).
    angle, distance : array (...)
        Rotation and distance by which the tool misses the target.
    steps : array (...)
        Number of Newton steps.
    """

    q: Array
    status: Statuses
    angle: Array
    distance: Array
    steps: Array

    def __iter__(self) -> Iterator[Any]:
        return iter((self.q, self.status))


def inverse(
    chain: SerialChainData,
    targets: Multivector | ArrayLike,
    start: ArrayLike | None,
    tolerance: float,
    iterations: int,
    attempts: int,
    nearest: bool,
    strict: bool,
    threads: int | None,
    progress: ProgressOption,
    executor: Executor | None,
) -> Solution:
    """See `Chain.inverse`."""
    if chain.movers is not None:
        raise InputError(
            "joints of this chain share coordinates, which the search for poses does not do.",
            remedy="Take solve_pose of the robot's mechanism, or load the file with mimic='free'",
        )
    goals = chain.as_motors(targets, "the targets")
    begin = _default_start(chain) if start is None else chain.coordinates(start, "start")
    lead = broadcast_shapes({"targets": goals.shape, "starts": begin.shape[:-1]})
    motors = np.broadcast_to(goals.values, (*lead, 8)).reshape(-1, 8)
    starts = np.broadcast_to(begin, (*lead, chain.count)).reshape(-1, chain.count)
    keep = as_bool(nearest, "nearest")
    options = _search_options(chain, tolerance, iterations, attempts, keep)
    results = chain.driver.blank_results(len(motors))

    def solution() -> Solution:
        return _solution(chain, motors, results, options, lead)

    if executor is None and progress is False and len(motors) <= GRAIN:  # in microseconds
        chain.driver.inverse(motors, starts, options, results, threads)
    else:
        with open_progress(progress, "inverse", "targets", len(motors)) as report, keep_partial(solution):
            if executor is None:
                chain.driver.inverse(motors, starts, options, results, threads, report)
            else:
                task, columns = _ChainTask(chain, options, threads), (motors, starts)
                fill_parts(executor, task, _search_part, columns, "targets", results, report, TARGETS_PER_CALL)
    found = solution()
    if as_bool(strict, "strict"):
        raise_first(np.asarray(found.status, np.uint8), "inverse")
    return found


@dataclass(frozen=True, eq=False)
class _ChainTask(Task):
    """A chain, and how its coordinates are searched."""

    chain: SerialChainData
    options: SearchOptions
    threads: int | None

    def prepare(self) -> _ChainTask:
        return self


def _search_part(task: _ChainTask, motors: Array, starts: Array) -> dict[str, Array]:
    results = task.chain.driver.blank_results(len(motors))
    task.chain.driver.inverse(motors, starts, task.options, results, 1 if task.threads is None else task.threads)
    return results


def _solution(
    chain: SerialChainData, motors: Array, results: dict[str, Array], options: SearchOptions, lead: tuple[int, ...]
) -> Solution:
    """Results by name, with what is known about targets that were not reached."""
    status = results["status"].astype(np.uint8)
    q = results["x"]
    if not options.nearest:
        q[status != Status.OK] = np.nan
    if (status == Status.OK).any():
        status[(status == Status.OK) & (results["rank"] < chain.freedom)] = Status.NOT_UNIQUE
    missed = np.flatnonzero(status == Status.NOT_CONVERGED)
    if len(missed):
        beyond = is_beyond(chain, chain.algebra.wrap(chain.algebra.kind("motor"), motors[missed]), options.tolerance)
        status[missed[beyond]] = Status.UNREACHABLE
    codes = status.reshape(lead)
    angle, distance = (results[name].reshape(lead)[()] for name in ("angle", "distance"))
    statuses, steps = codes if lead else Status(int(codes)), results["steps"].astype(np.int32).reshape(lead)[()]
    return Solution(q.reshape(*lead, chain.count), statuses, angle, distance, steps)


def _search_options(
    chain: SerialChainData, tolerance: float, iterations: int, attempts: int, nearest: bool
) -> SearchOptions:
    """Options of the search, checked; cached for further calls with the same ones."""
    key = (
        positive_float(tolerance, "tolerance"),
        as_int(iterations, "iterations", high=MOST),
        as_int(attempts, "attempts", high=MOST),
        nearest,
    )
    options = chain.searches.get(key)
    if options is None:
        reach = chain.reach * (1 + REACH_MARGIN) + key[0] * chain.length
        restarts = _restarts(chain, key[2] - 1)
        options = chain.searches[key] = SearchOptions(
            chain.limits.copy(), restarts, _poses(chain, restarts), np.array([key[0], chain.length, reach]),
            np.array([key[1], nearest], np.int64),
        )  # fmt: skip
    return options


def _start_ranges(chain: SerialChainData) -> tuple[Array, Array]:
    """Ranges of the starts of attempts: the limits, or default ranges."""
    rotations, advance = chain.parameters.joints[:, 6], np.abs(chain.parameters.joints[:, 7])
    unit = np.where(rotations > 0, 1, chain.length) / np.where(rotations > 0, rotations, advance)
    lower, upper = chain.limits.T
    bound = RANGE * unit
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - 2 * bound, -bound))
    high = np.where(np.isfinite(upper), upper, np.where(np.isfinite(lower), lower + 2 * bound, bound))
    wide = (rotations > 0) & (high - low > 2 * bound)  # more than a turn: that around zero has all poses
    middle = np.clip(0.0, low + bound, np.maximum(high - bound, low + bound))
    return np.where(wide, middle - bound, low), np.where(wide, middle + bound, high)


def _default_start(chain: SerialChainData) -> Array:
    """Zero, or the middle of the limits where they exclude zero."""
    low, high = _start_ranges(chain)
    start: Array = np.where((chain.limits[:, 0] <= 0) & (chain.limits[:, 1] >= 0), 0.0, (low + high) / 2)
    return start


def _poses(chain: SerialChainData, x: Array) -> Array:
    """Poses (m, 7) of the tool at coordinates (m, n): rotor, and position relative to the first joint."""
    if not len(x):
        return np.empty((0, 7))
    motors = chain.forward(x)
    rotor = evaluate(chain.algebra, "motions.motor_parts", motors).values[0].as_kind("rotor", check=False)
    return np.column_stack([rotor.values, chain.algebra.matrix(motors)[:, :3, 3] - chain.parameters.base])


def _restarts(chain: SerialChainData, count: int) -> Array:
    """Starts of further attempts (count, n), random over the ranges; the same at every call."""
    low, high = _start_ranges(chain)
    fraction = np.random.default_rng(SEED).random((count, chain.count))
    starts: Array = low + fraction * (high - low)
    return starts
