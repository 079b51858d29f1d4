"""Loop-closure equations of a mechanism: linear constraints on the speeds at its joints.

The twists of all bodies follow from the speeds at the joints of a spanning tree; each joint outside of the tree forbids
some of them. The matrix is block diagonal; each block is decomposed with a dense SVD. This gives the same rank and null
space as the constraint matrix with 6 columns for each body, at lower cost.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from ...mechanics.joints.local_relations import Relation
from .graph import Tree

Array = NDArray[Any]


@dataclass(frozen=True)
class Loops:
    """Loop-closure equations in the speeds at the joints of a tree.

    Attributes
    ----------
    tree : Tree
    relations : list of Relation
    couplings : list of dict
        Linear relations of speeds: coefficients by joint and freedom, in the world's units.
    """

    tree: Tree
    relations: Sequence[Relation]
    couplings: Sequence[Mapping[tuple[int, int], float]] = ()

    @cached_property
    def offsets(self) -> Array:
        """Offset of the coordinates of each body's joint, and their number at the end."""
        return np.cumsum([0, *(self.relations[j].free.shape[1] for j in self.tree.joint)])

    @property
    def size(self) -> int:
        """Number of coordinates of all joints of the tree."""
        return int(self.offsets[-1])

    @cached_property
    def loop_rows(self) -> Array:
        """Offset of the rows of each loop joint, and their number at the end."""
        return np.cumsum([0, *(len(self.relations[j].rows) for j in self.tree.loop_joints)])

    @cached_property
    def matrix(self) -> Any:
        """Rows of the loop joints, then of the couplings, in the coordinates (sparse)."""
        blocks = []
        for k, j in enumerate(self.tree.loop_joints):
            rows = self.relations[j].rows
            for body, sign in self.tree.path_between(*self.tree.ends[j]):
                blocks.append(
                    (int(self.loop_rows[k]), int(self.offsets[body]), sign * (rows @ self.joint_subspace(body)))
                )
        joints = block_matrix(blocks, (int(self.loop_rows[-1]), self.size))
        if not self.couplings:
            return joints
        return sparse.vstack([joints, *map(self._coupling_row, self.coupling_powers)]).tocsr()

    @cached_property
    def coupling_powers(self) -> list[dict[int, Array]]:
        """Rows (6,) by joint of each coupling, on the relative twists at its joints; the largest has the norm 1."""
        found = []
        for coupling in self.couplings:
            powers: dict[int, Array] = {}
            for (j, k), coefficient in coupling.items():
                relation = self.relations[j]
                speed = relation.speeds[k] * np.linalg.pinv(relation.free)[k]
                powers[j] = powers.get(j, np.zeros(6)) + coefficient * speed
            size = max(float(np.linalg.norm(power)) for power in powers.values())
            found.append({j: power / size for j, power in powers.items()})
        return found

    def _coupling_row(self, powers: Mapping[int, Array]) -> Any:
        """A coupling in the coordinates (sparse)."""
        row = sparse.csr_array((1, self.size))
        for j, power in powers.items():
            row = row + sparse.csr_array(power[None]) @ self.joint_jacobian(j)
        return row

    def joint_jacobian(self, joint: int) -> Any:
        """Relative twists (6, size) at a joint for unit speeds of the tree (sparse)."""
        body = self.tree.child_of.get(joint)
        if body is not None:
            return block_matrix([(0, int(self.offsets[body]), self.relations[joint].free)], (6, self.size))
        a, b = self.tree.ends[joint]
        paths = [self.body_jacobian(x) if x >= 0 else sparse.csr_array((6, self.size)) for x in (a, b)]
        return (paths[1] - paths[0]).tocsr()

    def joint_subspace(self, body: int) -> Array:
        """Twists (6, f) of a body relative to its parent, for unit speeds at the joint between."""
        return self.tree.sign[body] * self.relations[self.tree.joint[body]].free

    def body_jacobian(self, body: int) -> Any:
        """Twists (6, size) of a body for unit speeds at all joints (sparse)."""
        blocks = [(0, int(self.offsets[b]), self.joint_subspace(b)) for b, _ in self.tree.path_between(-1, body)]
        return block_matrix(blocks, (6, self.size))

    def twists(self, speeds: Array) -> Array:
        """Twists (bodies, 6, ...) of all bodies for speeds (size, ...) at the joints."""
        relative = np.zeros((len(self.tree.parent), 6, *speeds.shape[1:]))
        for b in self._driven_bodies(speeds):
            relative[b] = self.joint_subspace(b) @ speeds[self.offsets[b] : self.offsets[b + 1]]
        return self.tree.accumulate_down(relative)

    def twist(self, body: int, speeds: Array) -> Array:
        """Twist (6) of a body for speeds (size) at the joints."""
        driven = set(self._driven_bodies(speeds))
        path = [b for b, _ in self.tree.path_between(-1, body) if b in driven]
        blocks = [(0, int(self.offsets[b]), self.joint_subspace(b)) for b in path]
        return np.asarray(block_matrix(blocks, (6, self.size)) @ speeds)

    def _driven_bodies(self, speeds: Array) -> list[int]:
        """Bodies whose own joints have speeds: of many free motions each drives few."""
        moving = np.flatnonzero(speeds.any(tuple(range(1, speeds.ndim))))
        return np.unique(np.searchsorted(self.offsets, moving, side="right") - 1).tolist()  # type: ignore[no-any-return]


def block_matrix(blocks: list[tuple[int, int, Array]], shape: tuple[int, int]) -> Any:
    """A sparse matrix of dense blocks at offsets (row, column)."""
    rows, columns, values = [], [], []
    for first, left, block in blocks:
        i, j = np.indices(block.shape)
        rows.append((i + first).ravel())
        columns.append((j + left).ravel())
        values.append(block.ravel())
    if not blocks:
        return sparse.csr_array(shape)
    at = (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_array((np.concatenate(values), at), shape=shape)


@dataclass(frozen=True)
class Block:
    """A diagonal block of a matrix, decomposed.

    Attributes
    ----------
    rows, columns : array of int
    left, sizes, right : array
        Singular vectors and values of the block without rounding errors: left (rows, r), right (r, columns).
    null, stress : array
        Bases of the null space (columns, k) and of the left null space (rows, s).
    """

    rows: Array
    columns: Array
    left: Array
    sizes: Array
    right: Array
    null: Array
    stress: Array

    @property
    def rank(self) -> int:
        """Number of independent rows."""
        return len(self.sizes)


def decompose(matrix: Any, tolerance: float) -> list[Block]:
    """Diagonal blocks of a sparse matrix; singular values below a fraction of a block's largest are zero."""
    pattern = matrix.tocsr()
    m, n = pattern.shape
    graph = sparse.block_array([[None, pattern], [pattern.T, None]]) if m and n else sparse.csr_array((m + n, m + n))
    count, labels = csgraph.connected_components(graph, directed=False)
    of_rows, of_columns = _members(labels[:m], count), _members(labels[m:], count)
    return [_block(pattern, rows, columns, tolerance) for rows, columns in zip(of_rows, of_columns, strict=True)]


def _members(labels: Array, count: int) -> list[Array]:
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.searchsorted(labels[order], np.arange(1, count)))


def _block(matrix: Any, rows: Array, columns: Array, tolerance: float) -> Block:
    if not len(rows) or not len(columns):
        empty = np.zeros((len(rows), 0)), np.zeros(0), np.zeros((0, len(columns)))
        return Block(rows, columns, *empty, np.eye(len(columns)), np.eye(len(rows)))
    block = matrix[rows][:, columns].toarray()
    left, sizes, right = np.linalg.svd(block)
    rank = int((sizes > tolerance * sizes.max(initial=0)).sum()) if sizes.max(initial=0) > tolerance else 0
    return Block(rows, columns, left[:, :rank], sizes[:rank], right[:rank], right[rank:].T, left[:, rank:])
