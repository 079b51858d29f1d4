"""Loops of a mechanism: what its joints' coordinates must obey so that it stays closed.

The twists of all bodies follow from the speeds at the joints of a spanning tree; each joint that the tree leaves out
forbids some of them. The matrix of that is small, splits into parts that have nothing to do with one another, and is
looked at densely, part by part: what the constraint matrix of 6 columns a body says, for less.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from .graph import Tree
from .local import Relation

Array = NDArray[Any]


@dataclass(frozen=True)
class Loops:
    """Speeds at the joints of a tree, and the rows that close loops.

    Attributes
    ----------
    tree : Tree
    relations : list of Relation
    """

    tree: Tree
    relations: Sequence[Relation]

    @cached_property
    def starts(self) -> Array:
        """Where the coordinates of each body's joint begin, and their number at the end."""
        return np.cumsum([0, *(self.relations[j].free.shape[1] for j in self.tree.joint)])

    @property
    def size(self) -> int:
        """Coordinates of all joints of the tree."""
        return int(self.starts[-1])

    @cached_property
    def cut_rows(self) -> Array:
        """Where the rows of each cut joint begin, and their number at the end."""
        return np.cumsum([0, *(len(self.relations[j].rows) for j in self.tree.cuts)])

    @cached_property
    def matrix(self) -> Any:
        """The rows of the cut joints on the coordinates (sparse)."""
        blocks = []
        for k, j in enumerate(self.tree.cuts):
            rows = self.relations[j].rows
            for body, sign in self.tree.around(*self.tree.ends[j]):
                blocks.append((int(self.cut_rows[k]), int(self.starts[body]), sign * (rows @ self.step(body))))
        return _assembled(blocks, (int(self.cut_rows[-1]), self.size))

    def step(self, body: int) -> Array:
        """Twists (6, f) of a body against its parent, for unit speeds at the joint between."""
        return self.tree.sign[body] * self.relations[self.tree.joint[body]].free

    def way(self, body: int) -> Any:
        """Twists (6, size) of a body for unit speeds at all joints (sparse)."""
        blocks = [(0, int(self.starts[b]), self.step(b)) for b, _ in self.tree.around(-1, body)]
        return _assembled(blocks, (6, self.size))

    def twists(self, speeds: Array) -> Array:
        """Twists (bodies, 6, ...) of all bodies for speeds (size, ...) at the joints."""
        own = np.zeros((len(self.tree.parent), 6, *speeds.shape[1:]))
        for b in range(len(own)):
            own[b] = self.step(b) @ speeds[self.starts[b] : self.starts[b + 1]]
        return self.tree.summed(own)


def _assembled(blocks: list[tuple[int, int, Array]], shape: tuple[int, int]) -> Any:
    """A sparse matrix of dense blocks, by their first row and column."""
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
class Part:
    """Rows and columns of a matrix that have nothing to do with the others.

    Attributes
    ----------
    rows, columns : array of int
    left, sizes, right : array
        Singular vectors and values of the block, those of rounding left out: left (rows, r), right (r, columns).
    null, stress : array
        Bases of what the block takes to nothing (columns, k), and of what takes its rows to nothing (rows, s).
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
        """Rows that say something new."""
        return len(self.sizes)


def parts(matrix: Any, tolerance: float) -> list[Part]:
    """A sparse matrix, part by part; singular values below a share of the largest of a part are none."""
    pattern = matrix.tocsr()
    m, n = pattern.shape
    graph = sparse.block_array([[None, pattern], [pattern.T, None]]) if m and n else sparse.csr_array((m + n, m + n))
    count, labels = csgraph.connected_components(graph, directed=False)
    of_rows, of_columns = _members(labels[:m], count), _members(labels[m:], count)
    return [_part(pattern, rows, columns, tolerance) for rows, columns in zip(of_rows, of_columns, strict=True)]


def _members(labels: Array, count: int) -> list[Array]:
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.searchsorted(labels[order], np.arange(1, count)))


def _part(matrix: Any, rows: Array, columns: Array, tolerance: float) -> Part:
    if not len(rows) or not len(columns):
        nothing = np.zeros((len(rows), 0)), np.zeros(0), np.zeros((0, len(columns)))
        return Part(rows, columns, *nothing, np.eye(len(columns)), np.eye(len(rows)))
    block = matrix[rows][:, columns].toarray()
    left, sizes, right = np.linalg.svd(block)
    rank = int((sizes > tolerance * sizes.max(initial=0)).sum()) if sizes.max(initial=0) > tolerance else 0
    return Part(rows, columns, left[:, :rank], sizes[:rank], right[:rank], right[rank:].T, left[:, rank:])
