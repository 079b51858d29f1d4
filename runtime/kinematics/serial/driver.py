"""The compiled loops of serial chains: arrays in, arrays out, over threads, as C or numba."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.algorithms.chain_frames import JacobianFrame
from ...codegen.errors import CompilerMissingError
from ...common import parallel
from ...status import Status

if TYPE_CHECKING:
    from ...codegen.execute.items import Loop, Run
    from ...codegen.targets.c.instances import Instance

Array = NDArray[Any]
_log = logging.getLogger("bladesmith")
#: Where chains can run.
TARGETS = ("c", "numba")
#: Poses to reach that are worth another thread: about a millisecond of work.
GRAIN = 32


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
    restarts : array (m, n)
        Where the next attempts begin, after the first.
    numbers : array (3,)
        `Search` of codegen/algorithms/chain_records.py: tolerance, length, reach.
    counts : integer array (2,)
        Iterations of each attempt; 1 where what is out of reach is approached all the same.
    """

    limits: Array
    restarts: Array
    numbers: Array
    counts: NDArray[np.int64]

    @property
    def tolerance(self) -> float:
        return float(self.numbers[0])

    @property
    def nearest(self) -> bool:
        return bool(self.counts[1])


@cache
def _loop(algebra: str, room: int, name: str, target: str, instance: Instance | None) -> Loop:
    """One of the loops, compiled; by numba where there is no compiler.

    Raises
    ------
    CompilerMissingError
        If there is neither.
    """
    from ...codegen.build.extension import load, required_compiler
    from ...codegen.execute.items import CLoop, NumbaLoop
    from ...codegen.programs.chains import chain_extension, chain_function

    has_numba = find_spec("numba") is not None
    if target == "c":
        try:
            required_compiler("" if has_numba else "chains are compiled at their first use")
            extension, tag = chain_extension(algebra, room, name, instance)
            return CLoop(load(extension), tag)
        except CompilerMissingError as error:
            if not has_numba:
                raise
            _log.warning("%s of chains runs by numba: %s.", name, error.what)
    from ...codegen.programs.algorithms import algorithm_numba

    function = chain_function(algebra, room, name)
    return NumbaLoop(f"chain_{algebra}_{room}_{name}", algorithm_numba(function), function)


class Driver:
    """A chain, compiled.

    Parameters
    ----------
    algebra : str
    parameters : ChainParameters
    target : str
        Of `TARGETS`.
    instance : Instance, optional
        Of the C text, for tests. Default: the one that this processor runs best.
    """

    def __init__(
        self, algebra: str, parameters: ChainParameters, target: str = "c", instance: Instance | None = None
    ) -> None:
        from ...codegen.programs.chains import class_of

        self.count = len(parameters.joints)
        self._key = (algebra, class_of(self.count), target, instance)
        self._joints, self._links, self._tool, self._base = (
            np.ascontiguousarray(a, np.float64)
            for a in (parameters.joints, parameters.links, parameters.tool, parameters.base)
        )
        self._plans: dict[tuple[Any, ...], tuple[Loop, list[Any], Any, Any]] = {}

    def _plan(
        self, key: tuple[Any, ...], shared: Sequence[Array], strides: Sequence[int], counts: Sequence[int]
    ) -> tuple[Loop, list[Any], Any, Any]:
        """A loop, and what is the same in all of its calls: what items share, their strides, rows of open arrays."""
        algebra, room, target, instance = self._key
        loop = _loop(algebra, room, key[0], target, instance)
        held = [loop.hold(a) for a in shared]
        found = self._plans[key] = loop, held, loop.integers(strides), loop.integers(counts)
        return found

    def forward(self, x: Array, every: bool, threads: int | None) -> Array:
        """Motors (items, 8), or of every link (items, n, 8)."""
        n, rows = self.count, self.count if every else 1
        plan = self._plans.get(("forward", every)) or self._plan(
            ("forward", every), (self._joints, self._links if every else self._tool, self._base),
            (0, 0, 0, n, 8 * rows), (n, rows, 0, n, rows),
        )  # fmt: skip
        x, motors = np.ascontiguousarray(x), np.empty((len(x), n, 8) if every else (len(x), 8))
        parallel.split(_bound(plan, x, motors), len(x), threads)
        return motors

    def jacobian(self, x: Array, frame: JacobianFrame, points: Array, threads: int | None) -> Array:
        """Matrices (items, 6, n); points (items, 3), or one (3,)."""
        n = self.count
        plan = self._plans.get(("jacobian", frame, points.ndim)) or self._plan(
            ("jacobian", frame, points.ndim), (self._joints, self._tool, self._base, np.array([frame], np.int64)),
            (0, 0, 0, 0, 3 if points.ndim == 2 else 0, n, 6 * n), (n, 0, 0, 0, 0, n, 6 * n),
        )  # fmt: skip
        x, points = np.ascontiguousarray(x), np.ascontiguousarray(points)
        matrices = np.empty((len(x), 6, n))
        parallel.split(_bound(plan, points, x, matrices), len(x), threads)
        return matrices

    def twists(self, x: Array, speeds: Array, pushes: Array, every: bool, threads: int | None) -> tuple[Array, Array]:
        """Twists and their rates (items, 6), or of every link (items, n, 6)."""
        n, rows = self.count, self.count if every else 1
        plan = self._plans.get(("twists", every)) or self._plan(
            ("twists", every), (self._joints, self._base),
            (0, 0, n, n, n, 6 * rows, 6 * rows), (n, 0, n, n, n, rows, rows),
        )  # fmt: skip
        shape = (len(x), n, 6) if every else (len(x), 6)
        results = np.empty(shape), np.empty(shape)
        given = [np.ascontiguousarray(values) for values in (x, speeds, pushes)]
        parallel.split(_bound(plan, *given, *results), len(x), threads)
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
        plan = self._plans.get(("inverse", restarts)) or self._plan(
            ("inverse", restarts), (self._joints, self._tool, self._base),
            (0, 0, 0, 0, 0, 0, 0, 0, 8, n, n, 1, 1, 1, 1, 1), (n, 0, 0, n, restarts, 0, 0, 0, 0, n, n, 0, 0, 0, 0, 0),
        )  # fmt: skip
        search = (options.limits, options.restarts, options.numbers, options.counts[:1], options.counts[1:])
        given = np.ascontiguousarray(motors, np.float64), np.ascontiguousarray(starts)
        bound = _bound(plan, *search, *given, *results.values())
        parallel.run(bound, len(motors), threads, progress=progress, grain=GRAIN)


def _bound(plan: tuple[Loop, list[Any], Any, Any], *arrays: Array) -> Run:
    """A loop with the arrays of a call."""
    loop, shared, strides, counts = plan
    hold = loop.hold
    return loop.bind([*shared, *map(hold, arrays)], strides, counts)
