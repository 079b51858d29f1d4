"""Bodies and joints as a graph: a spanning tree from the fixed body, and the joints that close loops."""

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

from ..codegen.errors import InputError
from .joints import Joint

Array = NDArray[Any]


@dataclass(frozen=True)
class Tree:
    """A spanning tree: each body hangs on a parent by one joint.

    Attributes
    ----------
    order : list of int
        Bodies, parents first; the fixed body, -1, is not among them.
    parent, joint : list of int
        Of each body: the parent (-1: the fixed one) and the joint between.
    sign : list of int
        1 where the body is the joint's second, else -1.
    cuts : list of int
        Joints that close loops.
    ends : list of (int, int)
        First and second body of each joint.
    """

    order: list[int]
    parent: list[int]
    joint: list[int]
    sign: list[int]
    cuts: list[int]
    ends: list[tuple[int, int]]

    @cached_property
    def hung_by(self) -> dict[int, int]:
        """The body that hangs by each joint of the tree."""
        return {j: b for b, j in enumerate(self.joint)}

    @cached_property
    def depth(self) -> list[int]:
        """Joints between each body and the fixed one."""
        found = [0] * len(self.parent)
        for b in self.order:
            found[b] = 1 if self.parent[b] < 0 else found[self.parent[b]] + 1
        return found

    def around(self, a: int, b: int) -> list[tuple[int, int]]:
        """Bodies on the way from one body to another, with a sign: the twist of b against a is the sum of theirs
        against their parents."""
        found = []
        while a != b:
            deep = [-1 if x < 0 else self.depth[x] for x in (a, b)]
            if deep[0] > deep[1]:
                found.append((a, -1))
                a = self.parent[a]
            else:
                found.append((b, 1))
                b = self.parent[b]
        return found

    @cached_property
    def solver(self) -> Any:
        """Factors of 1 - (parent): what bodies have against their parents, summed to the root."""
        n = len(self.parent)
        at = [(b, self.parent[b]) for b in self.order if self.parent[b] >= 0]
        rows, columns = (np.array(at, int).reshape(-1, 2)).T
        links = sparse.csc_array((np.ones(len(at)), (rows, columns)), shape=(n, n))
        return splu((sparse.eye_array(n, format="csc") - links).tocsc(), permc_spec="NATURAL")

    def summed(self, own: Array) -> Array:
        """Of what bodies (n, ...) have against their parents, what they have against the fixed body."""
        return np.asarray(self.solver.solve(own.reshape(len(own), -1)).reshape(own.shape))

    def gathered(self, own: Array) -> Array:
        """Of what bodies (n, ...) bear, what their joints towards the fixed body do: the sum over all that hangs on."""
        return np.asarray(self.solver.solve(own.reshape(len(own), -1), trans="T").reshape(own.shape))


def spanning_tree(bodies: Sequence[str], fixed: str, joints: Sequence[Joint], freedoms: Sequence[int]) -> Tree:
    """The tree whose joints leave least: loops then are few equations in few unknowns.

    Raises
    ------
    InputError
        If bodies hang on nothing.
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
        lost = [bodies[i] for i in sorted(set(range(n)) - set(order.tolist()))]
        shown = ", ".join(lost[:5]) + (" ..." if len(lost) > 5 else "")
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
