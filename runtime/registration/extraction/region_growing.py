"""Neighbouring pieces that are flat together, gathered: faces into planes, edges into lines.

Regions grow together in rounds, all at once: each chooses the neighbour that bends least, and those that are linked by
their choices become one if all their pieces stay flat, else the two that chose each other. No piece is looped over.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Bends are compared in steps of this many radians, ties in an order that is shuffled, so that trees stay small on
#: curved surfaces that bend evenly.
STEP, SEED = 1e-9, 0


@dataclass(frozen=True)
class Pieces:
    """Flat pieces of a mesh.

    Attributes
    ----------
    vectors : array (n, 3)
        Area vectors of faces, or vectors along edges: directions whose lengths are weights.
    centers : array (n, 3)
        Means of the corners.
    corners : array (n, k, 3)
    across : bool
        Directions are normals; else they are tangents.
    """

    vectors: Array
    centers: Array
    corners: Array
    across: bool

    def some(self, which: Indices) -> Pieces:
        """Some of them."""
        return Pieces(self.vectors[which], self.centers[which], self.corners[which], self.across)

    def deviations(self, directions: Array, places: Array) -> tuple[Array, Array]:
        """Angle to a direction, either way, and greatest distance from the plane or line through a place; each (n,)."""
        aside = np.linalg.norm(np.cross(self.vectors, directions), axis=1)
        angles = np.arctan2(aside, np.abs((self.vectors * directions).sum(1)))
        apart = self.corners - places[:, None]
        along = np.einsum("nki,ni->nk", apart, directions)
        if self.across:
            return angles, np.abs(along).max(1)
        return angles, np.linalg.norm(apart - along[..., None] * directions[:, None], axis=-1).max(1)


@dataclass(frozen=True)
class Regions:
    """Pieces gathered.

    Attributes
    ----------
    labels : array (n,)
        Region of each piece, 0, 1, ..
    directions, places : arrays (m, 3)
        Unit normals or tangents, weighted means, and weighted centres.
    weights : array (m,)
        Sums of areas or lengths.
    """

    labels: Indices
    directions: Array
    places: Array
    weights: Array


@dataclass
class _Grown:
    """Regions on the way: of each the number of its first piece, and sums over its pieces."""

    pieces: Pieces
    labels: Indices
    sums: Array
    weights: Array
    moments: Array

    def joined(self, root: Indices, angle: float, distance: float) -> NDArray[np.bool_]:
        """Join regions of one root where all their pieces stay flat; for each root whether they did."""
        moved = np.flatnonzero(root != np.arange(len(root)))
        to = root[moved]
        sign = np.where((self.sums[moved] * self.sums[to]).sum(1) < 0, -1.0, 1.0)[:, None]
        sums, weights, moments = self.sums.copy(), self.weights.copy(), self.moments.copy()
        np.add.at(sums, to, sign * self.sums[moved])
        np.add.at(weights, to, self.weights[moved])
        np.add.at(moments, to, self.moments[moved])
        grown = np.zeros(len(root), bool)
        grown[to] = True
        of_piece = root[self.labels]
        mine = np.flatnonzero(grown[of_piece])
        at = of_piece[mine]
        directions = sums[at] / np.linalg.norm(sums[at], axis=1, keepdims=True)
        angles, apart = self.pieces.some(mine).deviations(directions, moments[at] / weights[at, None])
        good = grown.copy()
        good[at[(angles > angle) | (apart > distance)]] = False
        self.sums[good], self.weights[good], self.moments[good] = sums[good], weights[good], moments[good]
        self.labels = np.where(good[of_piece], of_piece, self.labels)
        return good


def gathered(pieces: Pieces, neighbours: Indices, angle: float, distance: float) -> Regions:
    """Regions whose pieces turn from the region's direction by at most an angle, and leave it by at most a distance.

    Parameters
    ----------
    neighbours : array (m, 2)
        Pieces that may be joined.
    """
    n = len(pieces.vectors)
    weights = np.linalg.norm(pieces.vectors, axis=1)
    grown = _Grown(pieces, np.arange(n), pieces.vectors.copy(), weights, weights[:, None] * pieces.centers)
    links, order = neighbours, np.random.default_rng(SEED).permutation(len(neighbours))
    while True:
        ends = grown.labels[links]
        open_ = ends[:, 0] != ends[:, 1]
        links, order, ends = links[open_], order[open_], ends[open_]
        if not len(links):
            break
        tree, pairs = _trees(_bends(grown.sums, ends), order, ends, n)
        whole = grown.joined(tree, angle, distance)
        pairs = pairs[~whole[ends[pairs].min(1)]]  # a tree that is not flat: the two in it that bend least, alone
        couple = np.arange(n)
        couple[ends[pairs].max(1)] = ends[pairs].min(1)
        good = grown.joined(couple, angle, distance)
        kept = np.ones(len(links), bool)
        kept[pairs[~good[ends[pairs].min(1)]]] = False  # what does not fit now will not when either has grown
        links, order = links[kept], order[kept]
    used, labels = np.unique(grown.labels, return_inverse=True)
    directions = grown.sums[used] / np.linalg.norm(grown.sums[used], axis=1, keepdims=True)
    return Regions(labels.ravel(), directions, grown.moments[used] / grown.weights[used, None], grown.weights[used])


def _bends(sums: Array, ends: Indices) -> Array:
    """Angles between the directions of two regions, either way."""
    a, b = sums[ends[:, 0]], sums[ends[:, 1]]
    found: Array = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.abs((a * b).sum(1)))
    return found


def _trees(bends: Array, order: Indices, ends: Indices, n: int) -> tuple[Indices, Indices]:
    """Regions linked by the best link of each: the root of each region, and the link at each root, best of both."""
    rank = np.empty(len(ends), np.int64)
    by_rank = np.lexsort((order, np.round(bends / STEP)))
    rank[by_rank] = np.arange(len(ends))
    best = np.full(n, len(ends))
    np.minimum.at(best, ends.ravel(), np.repeat(rank, 2))
    linked = np.flatnonzero(best < len(ends))
    link = ends[by_rank[best[linked]]]
    root = np.arange(n)
    root[linked] = np.where(link[:, 0] == linked, link[:, 1], link[:, 0])
    mutual = np.flatnonzero((best[ends] == rank[:, None]).all(1))
    low = ends[mutual].min(1)
    root[low] = low
    while (root[root] != root).any():
        root = root[root]
    return root, mutual
