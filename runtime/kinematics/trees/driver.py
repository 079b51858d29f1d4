"""The compiled loops of trees of links: arrays in, arrays out, over threads, as C, numba or CUDA."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...common import parallel
from ...dispatch.algorithm_loops import compiled_loop

if TYPE_CHECKING:
    from ...codegen.execute.items import Loop, Run
    from ...codegen.targets.c.instances import Instance

Array = NDArray[Any]
#: What displaces a joint's link, as codegen/algorithms/trees/records.py has it.
COORDINATE, FRAME, SAME = 0, 1, 2


@dataclass(frozen=True)
class TreeParameters:
    """Joints and links, parents before their children.

    Attributes
    ----------
    joints : array (n, 8)
        `Joint` of codegen/algorithms/chain_records.py; a position is relative to the joint of the parent. A joint of
        several freedoms is one for each, one behind the other.
    links : array (n, 10)
        `Link` of codegen/algorithms/trees/records.py.
    parents : integer array (n,)
        Link that each joint is on; -1 for the root.
    kinds : integer array (n,), optional
        What displaces each joint's link, as codegen/algorithms/trees/dynamics.py has it. Default: a coordinate.
    places : integer array (n,), optional
        Index of its coordinate, or of the first number of its frame, among the coordinates. Default: its own.
    """

    joints: Array
    links: Array
    parents: NDArray[np.int64]
    kinds: NDArray[np.int64] | None = None
    places: NDArray[np.int64] | None = None


@cache
def tree_loop(
    algebra: str, room: int, name: str, target: str, instance: Instance | None = None, by: str = "",
    has_frames: bool = False,
) -> Loop:  # fmt: skip
    """One of the loops, or its derivative, compiled; by numba where there is no compiler.

    Raises
    ------
    CompilerMissingError
        If there is neither.
    DeviceError
        If the target is "cuda" and there is no GPU.
    """
    from ...codegen.programs.trees import tree_extension, tree_function

    title = (f"{name}_by_{by}" if by else name) + ("_frames" if has_frames else "")
    return compiled_loop(
        f"tree_{algebra}_{room}_{title}", f"{name} of robots", "robots are compiled at their first use", target,
        lambda: tree_extension(algebra, room, name, by, instance, has_frames),
        lambda: tree_function(algebra, room, name, by, has_frames),
    )  # fmt: skip


class TreeDriver:
    """A tree of links, compiled.

    Parameters
    ----------
    algebra : str
    parameters : TreeParameters
    target : str
        "c", "numba" or "cuda".
    instance : Instance, optional
        Of the C text, for tests. Default: the one that this processor runs best.
    """

    def __init__(
        self, algebra: str, parameters: TreeParameters, target: str = "c", instance: Instance | None = None
    ) -> None:
        from ...codegen.programs.trees import class_of

        self.count = n = len(parameters.joints)
        self.joints = np.ascontiguousarray(parameters.joints, np.float64)
        kinds = np.zeros(n, np.int64) if parameters.kinds is None else np.ascontiguousarray(parameters.kinds, np.int64)
        self.places = np.arange(n) if parameters.places is None else np.ascontiguousarray(parameters.places, np.int64)
        self.tree = (
            self.joints, np.ascontiguousarray(parameters.links, np.float64),
            np.ascontiguousarray(parameters.parents, np.int64), kinds, self.places,
        )  # fmt: skip
        self._key = algebra, class_of(n), target, instance, bool(kinds.any())

    def inverse_dynamics(
        self, gravity: Array, x: Array, speeds: Array, accelerations: Array, items: int, threads: int | None
    ) -> Array:
        """Forces (items, n) of motions, of which each part is (items, n), or (n,) for all items.

        Coordinates are as many as joints, but for frames, of which each is seven.
        """
        forces = np.empty((items, self.count))
        self._run("inverse_dynamics", (gravity,), (x, speeds, accelerations), forces, threads)
        return forces

    def forward_dynamics(
        self, gravity: Array, x: Array, speeds: Array, forces: Array, items: int, threads: int | None
    ) -> Array:
        """Accelerations (items, n); arguments as of `inverse_dynamics`."""
        accelerations = np.empty((items, self.count))
        self._run("forward_dynamics", (gravity,), (x, speeds, forces), accelerations, threads)
        return accelerations

    def mass_matrix(self, x: Array, threads: int | None) -> Array:
        """Matrices (items, n, n)."""
        matrices = np.empty((len(x), self.count, self.count))
        self._run("mass_matrix", (), (x,), matrices, threads)
        return matrices

    def derivative(
        self, name: str, by: str, gravity: Array, given: Sequence[Array], directions: Sequence[Array], items: int,
        threads: int | None,
    ) -> Array:  # fmt: skip
        """Matrices (items, n, n) of the derivative of one of `VARIED` of codegen/programs/trees.py.

        Along one direction (m,) or (items, m) after the other: values beside the tangents are computed anew, and let
        go.
        """
        n = self.count
        columns, values = np.empty((n, items, n)), np.empty((items, n))
        arrays = [gravity, *(np.ascontiguousarray(a) for a in given), values]
        for direction, column in zip(directions, columns, strict=True):
            run, loop = self.bind(name, 1, [*arrays, np.ascontiguousarray(direction), column], by)
            parallel.split(run, items, threads=threads, is_whole=loop.runs_whole)
        return np.ascontiguousarray(columns.transpose(1, 2, 0))

    def _run(
        self, name: str, shared: Sequence[Array], given: Sequence[Array], result: Array, threads: int | None
    ) -> None:
        arrays = [*shared, *(np.ascontiguousarray(a) for a in given), result]  # alive while the loop runs
        run, loop = self.bind(name, len(shared), arrays)
        parallel.split(run, len(result), threads=threads, is_whole=loop.runs_whole)

    def bind(self, name: str, shared: int, arrays: Sequence[Array], by: str = "") -> tuple[Run, Loop]:
        """A loop bound to arrays without gaps, which it reads and writes whenever it runs: the caller keeps them.

        Parameters
        ----------
        name : str
            Of the algorithm.
        shared : int
            How many arrays all items share; others are (items, n), or (n,) for all items, or a result (items, ...).
        arrays : list of arrays
        by : str
            What the derivative of the algorithm is by.
        """
        algebra, room, target, instance, has_frames = self._key
        loop, n = tree_loop(algebra, room, name, target, instance, by, has_frames), self.count
        sizes = [math.prod(a.shape[1:]) if a.ndim > 1 else 0 for a in arrays[shared:]]
        strides = [0] * (len(self.tree) + shared) + sizes
        rows = [size or a.size for size, a in zip(sizes, arrays[shared:], strict=True)]
        counts = [n] * len(self.tree) + [0] * shared + rows
        held = [loop.hold(a) for a in (*self.tree, *arrays)]
        return loop.bind(held, loop.integers(strides), loop.integers(counts)), loop
