"""The compiled driver of serial chains: arrays in, arrays out, over threads.

The only module that knows the layout of the driver's structures (templates/c/programs/chains/chain_types.h).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.build.extension import load, required_compiler
from ...codegen.programs.chains import ChainConfig, chain_program, class_of
from ...common import parallel
from ...status import Status

Array = NDArray[Any]
#: Jacobian along the axes of the world, at the point of the tool that is at the origin: as the driver numbers frames.
AT_ORIGIN = 0
#: Jacobian along the axes of the world, at a point of the tool.
AT_POINT = 1
#: Targets that are worth another thread: about a millisecond of work.
TARGETS = 32
#: Jacobian along the axes of the tool's frame.
IN_TOOL = 2


@dataclass(frozen=True)
class ChainParameters:
    """Parameters of a chain.

    Attributes
    ----------
    joints : array (n, 8)
        Offset from the joint before, axis, rotation and advance for a unit of x.
    links, tool : array (n, 7), (7,)
        Frames: position relative to the joint, and rotor.
    base : array (3,)
        Position of the first joint.
    """

    joints: Array
    links: Array
    tool: Array
    base: Array


@dataclass(frozen=True)
class SearchOptions:
    """Options of the search for poses: see `bs_search` in templates/c/programs/chains/chain_types.h."""

    lower: Array
    upper: Array
    kicks: Array
    iterations: int
    tolerance: float
    length: float
    reach: float
    nearest: bool


@cache
def _module(config: ChainConfig) -> tuple[Any, int]:
    """The compiled driver, and the index of the best of its instances that this processor runs."""
    required_compiler("chains are compiled at their first use")
    module = load(chain_program(config).extension())
    count = module.lib.bs_chain_instances()
    return module, max(i for i in range(count) if module.lib.bs_chain_runs(i))


class Driver:
    """A chain, compiled."""

    def __init__(self, algebra: str, parameters: ChainParameters) -> None:
        module, self._instance = _module(ChainConfig(algebra, class_of(len(parameters.joints))))
        self._lib, self._ffi = module.lib, module.ffi
        self._chain = self._ffi.new("bs_chain *")
        self._buffers: list[Any] = []
        self.count = self._chain.count = len(parameters.joints)
        for name in ("joints", "links", "tool", "base"):
            setattr(self._chain, name, self._keep(getattr(parameters, name)))

    def _keep(self, values: Array) -> Any:
        """A buffer that lives as long as the driver."""
        self._buffers.append(self._buffer(values))
        return self._buffers[-1]

    def _buffer(self, values: Array, kind: str = "double[]") -> Any:
        if kind == "double[]":
            values = np.ascontiguousarray(values, np.float64)
        return self._ffi.from_buffer(kind, values if values.size else np.zeros(1, values.dtype))

    def forward(self, x: Array, every: bool, threads: int | None) -> Array:
        """Motors (items, 8), or of every link (items, n, 8)."""
        motors = np.empty((len(x), self.count, 8) if every else (len(x), 8))
        source, target = self._buffer(x), self._buffer(motors)
        parallel.split(
            lambda a, b: self._lib.bs_chain_forward(self._chain, self._instance, source, every, target, a, b),
            len(x),
            threads,
        )
        return motors

    def jacobian(self, x: Array, frame: int, points: Array, threads: int | None) -> Array:
        """Matrices (items, 6, n); points (items, 3), or one (3,)."""
        matrices = np.empty((len(x), 6, self.count))
        source, at, target = self._buffer(x), self._buffer(points), self._buffer(matrices)
        stride = 3 if points.ndim == 2 else 0
        parallel.split(
            lambda a, b: self._lib.bs_chain_jacobian(
                self._chain, self._instance, source, frame, at, stride, target, a, b
            ),
            len(x),
            threads,
        )
        return matrices

    def twists(self, x: Array, speeds: Array, pushes: Array, every: bool, threads: int | None) -> tuple[Array, Array]:
        """Twists and their rates (items, 6), or of every link (items, n, 6)."""
        shape = (len(x), self.count, 6) if every else (len(x), 6)
        results = np.empty(shape), np.empty(shape)
        sources = [self._buffer(values) for values in (x, speeds, pushes)]
        targets = [self._buffer(values) for values in results]
        parallel.split(
            lambda a, b: self._lib.bs_chain_twists(self._chain, self._instance, *sources, every, *targets, a, b),
            len(x),
            threads,
        )
        return results

    def blank_results(self, items: int) -> dict[str, Array]:
        """Joints (items, n), status, errors (items, 2), steps and rank of the Jacobian there: nothing is found yet."""
        return {
            "x": np.full((items, self.count), np.nan), "errors": np.full((items, 2), np.nan),
            "status": np.full(items, Status.NOT_CONVERGED, np.int32), "steps": np.zeros(items, np.int32),
            "rank": np.zeros(items, np.int32),
        }  # fmt: skip

    def inverse(
        self, motors: Array, starts: Array, options: SearchOptions, results: dict[str, Array], threads: int | None,
        progress: Callable[[int], None] | None = None,
    ) -> None:  # fmt: skip
        """Search joints for motors (items, 8), into `blank_results`."""
        search, target = self._ffi.new("bs_search *"), self._ffi.new("bs_found *")
        buffers = {name: self._buffer(getattr(options, name)) for name in ("lower", "upper", "kicks")}
        for name, buffer in buffers.items():
            setattr(search, name, buffer)
        for name in ("iterations", "tolerance", "length", "reach"):
            setattr(search, name, getattr(options, name))
        search.attempts, search.nearest = 1 + len(options.kicks), int(options.nearest)
        for name, array in results.items():
            setattr(target, name, self._buffer(array, "double[]" if array.dtype == np.float64 else "int32_t[]"))
        goals, begin = self._buffer(motors), self._buffer(starts)
        parallel.run(
            lambda a, b: self._lib.bs_chain_inverse(self._chain, search, goals, begin, target, a, b),
            len(motors), threads, progress=progress, grain=TARGETS,
        )  # fmt: skip
