"""Region growing: adjacent faces are merged into planes, adjacent edges into lines.

Regions are merged in rounds, all at once: each selects the neighbor at the smallest angle, and those that are linked by
their selections are merged if all their pieces stay flat, else the two that selected each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Angles are compared in steps of this many radians; ties in random order, so that trees stay small on surfaces of
#: constant curvature.
ANGLE_STEP = 1e-9
#: Seed of this order.
SEED = 0


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
    are_normals : bool
        Directions are normals; else they are tangents.
    """

    vectors: Array
    centers: Array
    corners: Array
    are_normals: bool

    def take(self, which: Indices) -> Pieces:
        """Subset by indices."""
        return Pieces(self.vectors[which], self.centers[which], self.corners[which], self.are_normals)

    def deviations(self, directions: Array, centers: Array) -> tuple[Array, Array]:
        """Unsigned angles to directions, and largest distances from planes or lines through centers; each (n,)."""
        aside = np.linalg.norm(np.cross(self.vectors, directions), axis=1)
        angles = np.arctan2(aside, np.abs((self.vectors * directions).sum(1)))
        offset = self.corners - centers[:, None]
        along = np.einsum("nki,ni->nk", offset, directions)
        if self.are_normals:
            return angles, np.abs(along).max(1)
        return angles, np.linalg.norm(offset - along[..., None] * directions[:, None], axis=-1).max(1)


@dataclass(frozen=True)
class Regions:
    """Regions of pieces.

    Attributes
    ----------
    labels : array (n,)
        Region of each piece, 0, 1, ..
    directions, centers : arrays (m, 3)
        Unit normals or tangents, weighted means; and weighted centers.
    weights : array (m,)
        Sums of areas or lengths.
    """

    labels: Indices
    directions: Array
    centers: Array
    weights: Array


@dataclass
class _RegionGrower:
    """Regions during growth: the index of the first piece of each, and sums over its pieces."""

    pieces: Pieces
    labels: Indices
    sums: Array
    weights: Array
    moments: Array

    def merge(self, root: Indices, angle: float, distance: float) -> NDArray[np.bool_]:
        """Merge regions of one root if all their pieces stay flat; return a mask of the roots that did."""
        moved = np.flatnonzero(root != np.arange(len(root)))
        to = root[moved]
        sign = np.where((self.sums[moved] * self.sums[to]).sum(1) < 0, -1.0, 1.0)[:, None]
        sums, weights, moments = self.sums.copy(), self.weights.copy(), self.moments.copy()
        np.add.at(sums, to, sign * self.sums[moved])
        np.add.at(weights, to, self.weights[moved])
        np.add.at(moments, to, self.moments[moved])
        has_grown = np.zeros(len(root), bool)
        has_grown[to] = True
        of_piece = root[self.labels]
        members = np.flatnonzero(has_grown[of_piece])
        at = of_piece[members]
        directions = sums[at] / np.linalg.norm(sums[at], axis=1, keepdims=True)
        angles, offset = self.pieces.take(members).deviations(directions, moments[at] / weights[at, None])
        accepted = has_grown.copy()
        accepted[at[(angles > angle) | (offset > distance)]] = False
        for total, merged in ((self.sums, sums), (self.weights, weights), (self.moments, moments)):
            total[accepted] = merged[accepted]
        self.labels = np.where(accepted[of_piece], of_piece, self.labels)
        return accepted


def grow_regions(pieces: Pieces, neighbors: Indices, angle: float, distance: float) -> Regions:
    """Grow regions whose pieces deviate from them by at most an angle and a distance.

    Parameters
    ----------
    neighbors : array (m, 2)
        Pairs of pieces that may be merged.
    """
    n = len(pieces.vectors)
    weights = np.linalg.norm(pieces.vectors, axis=1)
    grower = _RegionGrower(pieces, np.arange(n), pieces.vectors.copy(), weights, weights[:, None] * pieces.centers)
    links, order = neighbors, np.random.default_rng(SEED).permutation(len(neighbors))
    while True:
        ends = grower.labels[links]
        open_ = ends[:, 0] != ends[:, 1]
        links, order, ends = links[open_], order[open_], ends[open_]
        if not len(links):
            break
        tree, pairs = _trees(_bends(grower.sums, ends), order, ends, n)
        whole = grower.merge(tree, angle, distance)
        pairs = pairs[~whole[ends[pairs].min(1)]]  # of a tree that is not flat: the two regions at the smallest angle
        couple = np.arange(n)
        couple[ends[pairs].max(1)] = ends[pairs].min(1)
        good = grower.merge(couple, angle, distance)
        remaining = np.ones(len(links), bool)
        remaining[pairs[~good[ends[pairs].min(1)]]] = False  # a link that does not fit now does not fit later either
        links, order = links[remaining], order[remaining]
    used, labels = np.unique(grower.labels, return_inverse=True)
    directions = grower.sums[used] / np.linalg.norm(grower.sums[used], axis=1, keepdims=True)
    return Regions(labels.ravel(), directions, grower.moments[used] / grower.weights[used, None], grower.weights[used])


def _bends(sums: Array, ends: Indices) -> Array:
    """Unsigned angles between the directions of two regions."""
    a, b = sums[ends[:, 0]], sums[ends[:, 1]]
    angles: Array = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.abs((a * b).sum(1)))
    return angles


def _trees(bends: Array, order: Indices, ends: Indices, n: int) -> tuple[Indices, Indices]:
    """Trees of regions linked by the best link of each: root of each region, and links that are best for both ends."""
    rank = np.empty(len(ends), np.int64)
    by_rank = np.lexsort((order, np.round(bends / ANGLE_STEP)))
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
