"""The compiled loops of serial chains: arrays in, arrays out, over threads, as C or numba."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.chain_frames import JacobianFrame
from ...codegen.errors import CompilerMissingError
from ...codegen.execute.items import CLoop, ItemCall
from ...common import parallel
from ...dispatch.algorithm_loops import compiled_loop
from ...status import Status

if TYPE_CHECKING:
    from ...codegen.execute.items import Loop, Run
    from ...codegen.targets.c.instances import Instance

Array = NDArray[Any]
#: A loop, what all of its calls share, strides and counts.
Plan: TypeAlias = "tuple[Loop, list[Any], Any, Any]"
#: Poses to reach that are worth another thread: about a millisecond of work.
GRAIN = 32
#: Poses to reach from which on several are searched for at once: lanes without a pose cost more than they save.
WIDE_BATCH = 6


@dataclass(frozen=True)
class ChainParameters:
    """Parameters of a chain, in the records of codegen/algorithms/chain_records.py.

    Attributes
    ----------
    joints : array (n, 8)
        `Joint`: offset from the joint before, axis, rotation and advance for a unit of x.
    links, tool : array (n, 7), (7,)
        `Frame`: position relative to the joint, and rotor.
    base : array (3,)
        Position of the first joint.
    """

    joints: Array
    links: Array
    tool: Array
    base: Array


@dataclass(frozen=True)
class SearchOptions:
    """Options of the search for poses.

    Attributes
    ----------
    limits : array (n, 2)
    restarts, poses : array (m, n), (m, 7)
        Where the next attempts begin, after the first; and the tool's poses there, `Goal` of chain_records.py.
    numbers : array (3,)
        `Search` of codegen/algorithms/chain_records.py: tolerance, length, reach.
    counts : integer array (2,)
        Iterations of each attempt; 1 where what is out of reach is approached all the same.
    """

    limits: Array
    restarts: Array
    poses: Array
    numbers: Array
    counts: NDArray[np.int64]

    @property
    def tolerance(self) -> float:
        return float(self.numbers[0])

    @property
    def nearest(self) -> bool:
        return bool(self.counts[1])


@cache
def _loop(algebra: str, room: int, name: str, target: str, instance: Instance | None, is_wide: bool) -> Loop:
    """One of the loops, compiled; by numba where there is no compiler.

    Parameters
    ----------
    algebra, room, name, instance, is_wide
        As for `chain_extension`.
    target : str
        Of `algorithm_loops.TARGETS`.

    Raises
    ------
    CompilerMissingError
        If there is neither.
    DeviceError
        If the target is "cuda" and there is no GPU.
    """
    from ...codegen.programs.chains import chain_extension, chain_function

    return compiled_loop(
        f"chain_{algebra}_{room}_{name}", f"{name} of chains", "chains are compiled at their first use", target,
        lambda: chain_extension(algebra, room, name, instance, is_wide), lambda: chain_function(algebra, room, name),
    )  # fmt: skip


class Driver:
    """A chain, compiled.

    Parameters
    ----------
    algebra : str
    parameters : ChainParameters
    target : str
        Of `algorithm_loops.TARGETS`.
    instance : Instance, optional
        Of the C text, for tests. Default: the one that this processor runs best.
    movers : integer array (n,), optional
        Coordinate that moves each joint, where some share one.
    """

    def __init__(
        self, algebra: str, parameters: ChainParameters, target: str = "c", instance: Instance | None = None,
        movers: NDArray[np.int64] | None = None,
    ) -> None:  # fmt: skip
        from ...codegen.programs.chains import class_of

        self.count, self._movers = len(parameters.joints), movers
        self._key = (algebra, class_of(self.count), target, instance)
        self._joints, self._links, self._tool, self._base = (
            np.ascontiguousarray(a, np.float64)
            for a in (parameters.joints, parameters.links, parameters.tool, parameters.base)
        )
        self._plans: dict[tuple[Any, ...], Plan] = {}

    def _plan(
        self, key: tuple[Any, ...], shared: Sequence[Array], strides: Sequence[int], counts: Sequence[int],
        is_wide: bool = True,
    ) -> Plan:  # fmt: skip
        """A loop, and what is the same in all of its calls: what items share, their strides, rows of open arrays."""
        algebra, room, target, instance = self._key
        loop = _loop(algebra, room, key[0], target, instance, is_wide)
        held = [loop.hold(a) for a in shared]
        found = self._plans[key] = loop, held, loop.integers(strides), loop.integers(counts)
        return found

    def _forward_plan(self, every: bool) -> Plan:
        n, rows = self.count, self.count if every else 1
        return self._plans.get(("forward", every)) or self._plan(
            ("forward", every), (self._joints, self._links if every else self._tool, self._base),
            (0, 0, 0, n, 8 * rows), (n, rows, 0, n, rows),
        )  # fmt: skip

    def _jacobian_plan(self, frame: JacobianFrame, dimensions: int) -> Plan:
        n = self.count
        return self._plans.get(("jacobian", frame, dimensions)) or self._plan(
            ("jacobian", frame, dimensions), (self._joints, self._tool, self._base, np.array([frame], np.int64)),
            (0, 0, 0, 0, 3 if dimensions == 2 else 0, n, 6 * n), (n, 0, 0, 0, 0, n, 6 * n),
        )  # fmt: skip

    @cached_property
    def motor_of_item(self) -> ItemCall | None:
        """The motor (8,) of coordinates (n,), in the shortest way; None where there is none."""
        return self._item_call(self._forward_plan(False), (8,))

    @cached_property
    def jacobian_of_item(self) -> ItemCall | None:
        """The matrix (6, n), of the tool's point at the world's origin, of coordinates (n,)."""
        return self._item_call(self._jacobian_plan(JacobianFrame.ORIGIN, 1), (6, self.count), np.zeros(3))

    def _item_call(self, plan: Plan, shape: tuple[int, ...], *given: Array) -> ItemCall | None:
        loop, shared, strides, counts = plan
        if self._movers is not None or not isinstance(loop, CLoop):
            return None
        try:
            return loop.item_call([*shared, *map(loop.hold, given)], strides, counts, shape)
        except CompilerMissingError:  # the loop was compiled at install, what calls it was not
            return None

    def forward(self, x: Array, every: bool, threads: int | None) -> Array:
        """Motors (items, 8), or of every link (items, n, 8)."""
        x, n, plan = self._of_joints(x), self.count, self._forward_plan(every)
        x, motors = np.ascontiguousarray(x), np.empty((len(x), n, 8) if every else (len(x), 8))
        _run(plan, (x, motors), len(x), threads)
        return motors

    def jacobian(self, x: Array, frame: JacobianFrame, points: Array, threads: int | None) -> Array:
        """Matrices (items, 6, n); points (items, 3), or one (3,)."""
        x, n, plan = self._of_joints(x), self.count, self._jacobian_plan(frame, points.ndim)
        x, points = np.ascontiguousarray(x), np.ascontiguousarray(points)
        matrices = np.empty((len(x), 6, n))
        _run(plan, (points, x, matrices), len(x), threads)
        if self._movers is None:
            return matrices
        shared = np.zeros((*matrices.shape[:-1], int(self._movers.max()) + 1))
        for j, mover in enumerate(self._movers.tolist()):
            shared[..., mover] += matrices[..., j]
        return shared

    def _of_joints(self, x: Array) -> Array:
        """Numbers of joints (..., n) from those of coordinates."""
        return x if self._movers is None else x[..., self._movers]

    def twists(self, x: Array, speeds: Array, pushes: Array, every: bool, threads: int | None) -> tuple[Array, Array]:
        """Twists and their rates (items, 6), or of every link (items, n, 6)."""
        x, speeds, pushes = map(self._of_joints, (x, speeds, pushes))
        n, rows = self.count, self.count if every else 1
        plan = self._plans.get(("twists", every)) or self._plan(
            ("twists", every), (self._joints, self._base),
            (0, 0, n, n, n, 6 * rows, 6 * rows), (n, 0, n, n, n, rows, rows),
        )  # fmt: skip
        shape = (len(x), n, 6) if every else (len(x), 6)
        results = np.empty(shape), np.empty(shape)
        given = [np.ascontiguousarray(values) for values in (x, speeds, pushes)]
        _run(plan, (*given, *results), len(x), threads)
        return results

    def blank_results(self, items: int) -> dict[str, Array]:
        """Coordinates (items, n), status, errors, steps and rank of the Jacobian there: nothing is found yet."""
        return {
            "x": np.full((items, self.count), np.nan), "status": np.full(items, Status.NOT_CONVERGED, np.int64),
            "angle": np.full(items, np.nan), "distance": np.full(items, np.nan), "steps": np.zeros(items, np.int64),
            "rank": np.zeros(items, np.int64),
        }  # fmt: skip

    def inverse(
        self, motors: Array, starts: Array, options: SearchOptions, results: dict[str, Array], threads: int | None,
        progress: Callable[[int], None] | None = None,
    ) -> None:  # fmt: skip
        """Search joints for motors (items, 8), into `blank_results`."""
        n, restarts = self.count, options.restarts.size
        is_wide = len(motors) >= WIDE_BATCH or self._key[2] != "c"
        plan = self._plans.get(("inverse", restarts, is_wide)) or self._plan(
            ("inverse", restarts, is_wide), (self._joints, self._tool, self._base),
            (0, 0, 0, 0, 0, 0, 0, 0, 0, 8, n, n, 1, 1, 1, 1, 1),
            (n, 0, 0, n, restarts, restarts // n, 0, 0, 0, 0, n, n, 0, 0, 0, 0, 0),
            is_wide,
        )  # fmt: skip
        counts = options.counts[:1], options.counts[1:]
        search = options.limits, options.restarts, options.poses, options.numbers, *counts
        given = np.ascontiguousarray(motors, np.float64), np.ascontiguousarray(starts)
        bound = _bound(plan, *search, *given, *results.values())
        if plan[0].runs_whole:
            bound(0, len(motors))
        else:
            parallel.run(bound, len(motors), threads, progress=progress, grain=GRAIN)


def _run(plan: Plan, arrays: Sequence[Array], n: int, threads: int | None) -> None:
    """Run a loop over n items."""
    parallel.split(_bound(plan, *arrays), n, threads=threads, is_whole=plan[0].runs_whole)


def _bound(plan: Plan, *arrays: Array) -> Run:
    """A loop with the arrays of a call."""
    loop, shared, strides, counts = plan
    hold = loop.hold
    return loop.bind([*shared, *map(hold, arrays)], strides, counts)
