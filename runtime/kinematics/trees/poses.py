"""Poses of all links of a robot, compiled, in batches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.execute.result_memory import STORE
from ...common import parallel
from .driver import tree_loop

Array = NDArray[Any]
#: Items whose poses are computed before they are sorted by link: they stay in the processor's cache.
ROWS = 128


@dataclass(frozen=True)
class PoseParameters:
    """Joints and frames of links, where all coordinates are zero; parents before their children.

    Attributes
    ----------
    joints : array (n, 8)
        `Joint` of codegen/algorithms/chain_records.py; a position is relative to the joint of the parent, or to base.
    parents, coordinates : integer array (n,)
        Joint before each, -1 for the root; and the coordinate that moves it.
    frames : array (m, 7)
        `Frame` of each link: position relative to its joint, or to base, and rotor.
    carriers : integer array (m,)
        Joint that carries each link, -1 for the root.
    base : array (3,)
    """

    joints: Array
    parents: NDArray[np.int64]
    coordinates: NDArray[np.int64]
    frames: Array
    carriers: NDArray[np.int64]
    base: Array


class PoseDriver:
    """Poses of a tree, compiled.

    Parameters
    ----------
    algebra : str
    parameters : PoseParameters
    target : str
        "c" or "numba".
    """

    def __init__(self, algebra: str, parameters: PoseParameters, target: str = "c") -> None:
        from ...codegen.programs.trees import class_of

        self.parameters = p = parameters
        self._shared = [
            np.ascontiguousarray(a, kind)
            for a, kind in zip(
                (p.joints, p.parents, p.coordinates, p.frames, p.carriers, p.base),
                (np.float64, np.int64, np.int64, np.float64, np.int64, np.float64), strict=True,
            )
        ]  # fmt: skip
        self._loop = tree_loop(algebra, class_of(len(p.joints)), "poses", target)
        self._held = [self._loop.hold(a) for a in self._shared]
        n, self.links = len(p.joints), len(p.frames)
        self._counts = n, n, n, self.links, self.links, 0

    def poses(self, x: Array, threads: int | None) -> Array:
        """Motors (links, items, 8), for coordinates (items, k)."""
        x, links, loop = np.ascontiguousarray(x, np.float64), self.links, self._loop
        items, k = x.shape
        motors = STORE.empty((links, items, 8), np.float64)
        strides = loop.integers((0, 0, 0, 0, 0, 0, k, 8 * links))
        counts = loop.integers((*self._counts, k, links))
        # one coordinate more: an empty array has no address
        given = x if k else np.zeros((items, 1))

        def run(begin: int, end: int) -> None:
            room = np.empty((min(ROWS, end - begin), links, 8))
            for first in range(begin, end, ROWS):
                last = min(first + ROWS, end)
                part = np.ascontiguousarray(given[first:last])
                loop.bind([*self._held, loop.hold(part), loop.hold(room)], strides, counts)(0, last - first)
                motors[:, first:last] = np.swapaxes(room[: last - first], 0, 1)

        parallel.split(run, items, threads=threads, is_whole=loop.runs_whole)
        return motors
