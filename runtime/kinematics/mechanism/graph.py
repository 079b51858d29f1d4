"""Graph of bodies and joints: a spanning tree from the fixed body, and the joints that close loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph
from scipy.sparse.linalg import splu

from ...codegen.errors import InputError
from ...mechanics.joints.base import Joint

Array = NDArray[Any]


@dataclass(frozen=True)
class Tree:
    """A spanning tree: one joint connects each body to its parent.

    Attributes
    ----------
    order : list of int
        Bodies, parents first, without the fixed body, -1.
    parent, joint : list of int
        Parent of each body (-1: the fixed one), and the joint between.
    sign : list of int
        1 for bodies that are the second of their joint, else -1.
    loop_joints : list of int
        Joints that close loops.
    ends : list of (int, int)
        First and second body of each joint.
    """

    order: list[int]
    parent: list[int]
    joint: list[int]
    sign: list[int]
    loop_joints: list[int]
    ends: list[tuple[int, int]]

    @cached_property
    def child_of(self) -> dict[int, int]:
        """The child body of each joint of the tree."""
        return {j: b for b, j in enumerate(self.joint)}

    @cached_property
    def depth(self) -> list[int]:
        """Number of joints between each body and the fixed one."""
        depths = [0] * len(self.parent)
        for b in self.order:
            depths[b] = 1 if self.parent[b] < 0 else depths[self.parent[b]] + 1
        return depths

    def path_between(self, a: int, b: int) -> list[tuple[int, int]]:
        """Bodies on the path from one body to another, with signs.

        The twist of b relative to a is the signed sum of their twists relative to their parents.
        """
        path = []
        while a != b:
            depths = [-1 if x < 0 else self.depth[x] for x in (a, b)]
            if depths[0] > depths[1]:
                path.append((a, -1))
                a = self.parent[a]
            else:
                path.append((b, 1))
                b = self.parent[b]
        return path

    @cached_property
    def solver(self) -> Any:
        """LU factors of 1 - (parent matrix): they sum values along the paths to the root."""
        n = len(self.parent)
        at = [(b, self.parent[b]) for b in self.order if self.parent[b] >= 0]
        rows, columns = (np.array(at, int).reshape(-1, 2)).T
        links = sparse.csc_array((np.ones(len(at)), (rows, columns)), shape=(n, n))
        return splu((sparse.eye_array(n, format="csc") - links).tocsc(), permc_spec="NATURAL")

    def accumulate_down(self, relative: Array) -> Array:
        """Values (n, ...) of bodies relative to the fixed body, from those relative to their parents."""
        return np.asarray(self.solver.solve(relative.reshape(len(relative), -1)).reshape(relative.shape))

    def accumulate_up(self, loads: Array) -> Array:
        """Loads (n, ...) on the joints towards the fixed body, from those on bodies: sums over all descendants."""
        return np.asarray(self.solver.solve(loads.reshape(len(loads), -1), trans="T").reshape(loads.shape))


def spanning_tree(bodies: Sequence[str], fixed: str, joints: Sequence[Joint], freedoms: Sequence[int]) -> Tree:
    """The tree whose joints have the least freedom: loops are then few equations in few unknowns.

    Raises
    ------
    InputError
        If bodies are not connected to the fixed one.
    """
    numbers = {name: i for i, name in enumerate(bodies)} | {fixed: -1}
    ends = [(numbers[joint.a], numbers[joint.b]) for joint in joints]
    n = len(bodies)
    best: dict[tuple[int, int], int] = {}
    for j, (a, b) in enumerate(ends):
        pair = (min(a, b), max(a, b))
        if pair not in best or freedoms[j] < freedoms[best[pair]]:
            best[pair] = j
    pairs = np.array(list(best), int).reshape(-1, 2) % (n + 1)  # the fixed body last
    weights = np.array([1.0 + freedoms[j] for j in best.values()])
    graph = sparse.csr_array((weights, (pairs[:, 0], pairs[:, 1])), shape=(n + 1, n + 1))
    order, before = csgraph.breadth_first_order(csgraph.minimum_spanning_tree(graph), n, directed=False)
    if len(order) <= n:
        isolated = [bodies[i] for i in sorted(set(range(n)) - set(order.tolist()))]
        shown = ", ".join(isolated[:5]) + (" ..." if len(isolated) > 5 else "")
        raise InputError(
            f"no joints hold {shown} to {fixed!r}.", remedy="Add the joints that are missing, or take the bodies out"
        )
    parent, joint, sign = [-1] * n, [-1] * n, [1] * n
    for b in order[1:].tolist():
        parent[b] = int(before[b]) if before[b] < n else -1
        joint[b] = best[min(b, parent[b]), max(b, parent[b])]
        sign[b] = 1 if ends[joint[b]][1] == b else -1
    used = set(joint)
    return Tree(order[1:].tolist(), parent, joint, sign, [j for j in range(len(joints)) if j not in used], ends)
