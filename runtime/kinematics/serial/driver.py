"""The compiled driver of serial chains: arrays in, arrays out, over threads.

The only module that knows the layout of the driver's structures (templates/c/chain_types.h).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import parallel
from ..codegen.build import load
from ..codegen.programs.chains import Needs, chain_program, class_of

Array = NDArray[Any]
#: Frames of Jacobians, as the driver numbers them.
AT_ORIGIN, AT_POINT, IN_TOOL = range(3)


@dataclass(frozen=True)
class Numbers:
    """What a chain is, in numbers.

    Attributes
    ----------
    joints : array (n, 8)
        Way from the joint before, axis, turn and advance for a unit of x.
    links, tool : array (n, 7), (7,)
        Frames: place as seen from the joint, and rotor.
    base : array (3,)
        The place of the first joint.
    """

    joints: Array
    links: Array
    tool: Array
    base: Array


@dataclass(frozen=True)
class Search:
    """How poses are sought: see `bs_search` in templates/c/chain_types.h."""

    lower: Array
    upper: Array
    kicks: Array
    iterations: int
    tolerance: float
    length: float
    reach: float
    nearest: bool


@cache
def _module(needs: Needs) -> tuple[Any, int]:
    """The compiled driver, and which of its instances this processor runs best."""
    module = load(chain_program(needs).extension())
    count = module.lib.bs_chain_instances()
    return module, max(i for i in range(count) if module.lib.bs_chain_runs(i))


class Driver:
    """A chain, ready to run."""

    def __init__(self, algebra: str, numbers: Numbers) -> None:
        module, self._instance = _module(Needs(algebra, class_of(len(numbers.joints))))
        self._lib, self._ffi = module.lib, module.ffi
        self._chain = self._ffi.new("bs_chain *")
        self._kept: list[Any] = []
        self.count = self._chain.count = len(numbers.joints)
        for name in ("joints", "links", "tool", "base"):
            setattr(self._chain, name, self._given(getattr(numbers, name)))

    def _given(self, values: Array) -> Any:
        """A buffer that lives as long as the driver."""
        self._kept.append(self._buffer(values))
        return self._kept[-1]

    def _buffer(self, values: Array, kind: str = "double[]") -> Any:
        if kind == "double[]":
            values = np.ascontiguousarray(values, np.float64)
        return self._ffi.from_buffer(kind, values if values.size else np.zeros(1, values.dtype))

    def forward(self, x: Array, every: bool, threads: int | None) -> Array:
        """Motors (items, 8), or of every link (items, n, 8)."""
        motors = np.empty((len(x), self.count, 8) if every else (len(x), 8))
        given, to = self._buffer(x), self._buffer(motors)
        self._share(
            lambda a, b: self._lib.bs_chain_forward(self._chain, self._instance, given, every, to, a, b), x, threads
        )
        return motors

    def jacobian(self, x: Array, frame: int, points: Array, threads: int | None) -> Array:
        """Matrices (items, 6, n); points (items, 3), or one (3,)."""
        matrices = np.empty((len(x), 6, self.count))
        given, at, to = self._buffer(x), self._buffer(points), self._buffer(matrices)
        stride = 3 if points.ndim == 2 else 0
        self._share(
            lambda a, b: self._lib.bs_chain_jacobian(self._chain, self._instance, given, frame, at, stride, to, a, b),
            x,
            threads,
        )
        return matrices

    def twists(self, x: Array, speeds: Array, pushes: Array, every: bool, threads: int | None) -> tuple[Array, Array]:
        """Twists and their rates (items, 6), or of every link (items, n, 6)."""
        shape = (len(x), self.count, 6) if every else (len(x), 6)
        found = np.empty(shape), np.empty(shape)
        given = [self._buffer(values) for values in (x, speeds, pushes)]
        to = [self._buffer(values) for values in found]
        self._share(
            lambda a, b: self._lib.bs_chain_twists(self._chain, self._instance, *given, every, *to, a, b), x, threads
        )
        return found

    def inverse(self, motors: Array, starts: Array, how: Search, threads: int | None) -> dict[str, Array]:
        """Joints (items, n), status, errors (items, 2), steps and rank of the Jacobian there."""
        items = len(motors)
        found: dict[str, Array] = {
            "x": np.empty((items, self.count)), "errors": np.empty((items, 2)), "status": np.empty(items, np.int32),
            "steps": np.empty(items, np.int32), "rank": np.empty(items, np.int32),
        }  # fmt: skip
        search, to = self._ffi.new("bs_search *"), self._ffi.new("bs_found *")
        kept = {name: self._buffer(getattr(how, name)) for name in ("lower", "upper", "kicks")}
        for name, buffer in kept.items():
            setattr(search, name, buffer)
        for name in ("iterations", "tolerance", "length", "reach"):
            setattr(search, name, getattr(how, name))
        search.attempts, search.nearest = 1 + len(how.kicks), int(how.nearest)
        for name, array in found.items():
            setattr(to, name, self._buffer(array, "double[]" if array.dtype == np.float64 else "int32_t[]"))
        goals, given = self._buffer(motors), self._buffer(starts)
        self._share(
            lambda a, b: self._lib.bs_chain_inverse(self._chain, search, goals, given, to, a, b), motors, threads
        )
        return found

    @staticmethod
    def _share(part: Callable[[int, int], None], items: Array, threads: int | None) -> None:
        parallel.run(part, len(items), threads)
