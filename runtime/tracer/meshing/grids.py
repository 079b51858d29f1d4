"""Triangulation of grids of vertices: rows along a curve, columns around or along its objects.

Positions that coincide up to rounding become equal to the last bit, so that meshes close.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from .triangle_mesh import TriangleMesh

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
#: Largest difference of normals on both sides of a smooth joint; a larger one makes an edge.
SMOOTH = 1e-6
#: Largest distance of coinciding vertices of adjacent rows, in rounding units of the grid's extent.
EXTENT_ROUNDING = 64
#: Further distance, in rounding units of the largest coordinate.
COORDINATE_ROUNDING = 8
#: Relative difference of the diagonals of a quad, beyond which the second is preferred: rounding must not decide.
DIAGONAL_RTOL = 1e-6


@dataclass(frozen=True, eq=False)
class Grid:
    """A grid of vertices.

    Attributes
    ----------
    positions, normals : (rows, columns, 3) arrays
        Normals are NaN where the surface has none.
    u : (columns,) array
    v : (rows,) array
    run : (rows,) array of int
        Rows with the same number are connected.
    joined : (runs,) array of bool
        A run begins where the previous one ends: their rows there coincide.
    is_round : bool
        The last column is the first.
    is_closed : bool
        The last row is the first.
    """

    positions: Array
    normals: Array
    u: Array
    v: Array
    run: Integers
    joined: NDArray[np.bool_]
    is_round: bool
    is_closed: bool


@dataclass(frozen=True, eq=False)
class Patch:
    """Triangles with their vertices; normals are NaN where the surface has none.

    Attributes
    ----------
    vertices, normals : (n, 3) arrays
    faces : (m, 3) array of int
    uv : (n, 2) array
    """

    vertices: Array
    faces: Integers
    normals: Array
    uv: Array

    def flip(self, vertices: NDArray[np.bool_], faces: NDArray[np.bool_]) -> Patch:
        """Reverse the normals and faces that these masks select."""
        reversed_ = np.where(faces[:, None], self.faces[:, [0, 2, 1]], self.faces)
        return Patch(self.vertices, reversed_, np.where(vertices[:, None], -self.normals, self.normals), self.uv)

    def mesh(self) -> TriangleMesh:
        """Make the mesh: complete the normals and drop unused vertices.

        Raises
        ------
        SceneError
            Where triangles have no area, and the surface no normal.
        """
        normals = with_all_normals(self.vertices, self.faces, self.normals)
        if not np.isfinite(normals[self.faces]).all():
            raise nothing_swept("a part of the surface")
        return drop_unused_vertices(self.vertices, self.faces, normals, self.uv)


def nothing_swept(what: str) -> SceneError:
    """Error for a surface without area."""
    return SceneError(
        f"{what} is a line: it has no area and no normal.",
        remedy="Give objects that do not all lie on one line",
    )


def concatenate_patches(patches: Sequence[Patch]) -> Patch:
    """Concatenate patches."""
    if len(patches) == 1:
        return patches[0]
    starts = np.cumsum([0, *(len(p.vertices) for p in patches)])
    return Patch(
        np.concatenate([p.vertices for p in patches]),
        np.concatenate([p.faces + start for p, start in zip(patches, starts, strict=False)]),
        np.concatenate([p.normals for p in patches]),
        np.concatenate([p.uv for p in patches]),
    )


def grid_patch(grid: Grid) -> tuple[Patch, Integers, Integers]:
    """Triangulate a grid without degenerate triangles; also return the row of each vertex and of each triangle."""
    positions, normals = snap_still_vertices(grid.positions), _fill_from_neighbors(grid.normals)
    if grid.is_round:
        positions[:, -1], normals[:, -1] = positions[:, 0], normals[:, 0]
    used = np.ones(len(positions), bool)
    firsts = np.flatnonzero(np.diff(grid.run, prepend=-1))
    for at, is_joined in zip(firsts, grid.joined, strict=True):  # runs are few
        if is_joined:
            positions[at] = positions[at - 1]
            used[at] = not _normals_agree(normals[at], normals[at - 1])
    if grid.is_closed:
        positions[-1] = positions[0]
        if _normals_agree(normals[-1], normals[0]):
            normals[-1] = normals[0]
    rows, columns = positions.shape[:2]
    index = np.cumsum(used) - 1  # a row that is dropped is the one before it
    lower = np.flatnonzero(grid.run[1:] == grid.run[:-1])
    faces, row = _triangles(positions, index, lower, columns)
    u, v = np.broadcast_arrays(grid.u[None, :], grid.v[:, None])
    uv = np.stack([u, v], -1)[used].reshape(-1, 2)
    patch = Patch(positions[used].reshape(-1, 3), faces, normals[used].reshape(-1, 3), uv)
    return patch, np.repeat(np.flatnonzero(used), columns), row


def snap_still_vertices(positions: Array) -> Array:
    """Make vertices that do not move from row to row (tips of cones) equal to the last bit."""
    extent = max(np.ptp(positions[..., i]) for i in range(3))
    limit = np.finfo(float).eps * (EXTENT_ROUNDING * extent + COORDINATE_ROUNDING * np.abs(positions).max())
    x, y, z = (np.abs(np.diff(positions[..., i], axis=0)) > limit for i in range(3))
    moves = x | y | z
    if moves.all():
        return positions.copy()
    first = np.concatenate([np.ones((1, moves.shape[1]), bool), moves])
    source = np.maximum.accumulate(np.where(first, np.arange(len(positions))[:, None], 0), axis=0)
    return np.asarray(np.take_along_axis(positions, source[..., None], axis=0))


def _fill_from_neighbors(normals: Array) -> Array:
    """Fill in missing normals, as at tips, from the adjacent vertex of the row."""
    filled = normals.copy()
    if np.isfinite(filled.sum()):
        return filled
    for shift in (1, -1):
        adjacent = np.roll(normals, shift, axis=1)
        adjacent[:, 0 if shift > 0 else -1] = np.nan
        filled = np.where(np.isfinite(filled), filled, adjacent)
    return filled


def _normals_agree(first: Array, second: Array) -> bool:
    """Test whether normals agree; missing ones agree with all."""
    return not bool((np.abs(first - second).max(-1) > SMOOTH).any())


def _triangles(positions: Array, index: Integers, lower: Integers, columns: int) -> tuple[Integers, Integers]:
    """Two triangles for each quad, split along its shorter diagonal, and their rows.

    Triangles with two corners at one position are dropped.
    """
    below, above = positions[lower], positions[lower + 1]
    rising, falling = _squares(above[:, 1:], below[:, :-1]), _squares(above[:, :-1], below[:, 1:])
    j = np.arange(columns - 1)
    a, b = index[lower][:, None] * columns + j, index[lower + 1][:, None] * columns + j
    p, q, r, s = a, a + 1, b + 1, b
    cut = (falling < (1 - DIAGONAL_RTOL) * rising)[..., None]
    first = np.where(cut, np.stack([p, q, s], -1), np.stack([p, q, r], -1))
    second = np.where(cut, np.stack([q, r, s], -1), np.stack([p, r, s], -1))
    same_below, same_above = _coincide(below[:, :-1], below[:, 1:]), _coincide(above[:, :-1], above[:, 1:])
    same_left, same_right = _coincide(below[:, :-1], above[:, :-1]), _coincide(below[:, 1:], above[:, 1:])
    diagonal = _coincide(below[:, :-1], above[:, 1:]) | _coincide(below[:, 1:], above[:, :-1])
    is_cut = cut[..., 0]
    first_gone = same_below | np.where(is_cut, same_left, same_right) | diagonal
    second_gone = same_above | np.where(is_cut, same_right, same_left) | diagonal
    both = np.stack([first, second], 2).reshape(-1, 3)
    gone = np.stack([first_gone, second_gone], 2).reshape(-1)
    rows = np.repeat(lower, 2 * (columns - 1))
    return np.asarray(both[~gone], np.int64), rows[~gone]


def _squares(first: Array, second: Array) -> Array:
    return np.asarray(sum((first[..., i] - second[..., i]) ** 2 for i in range(3)))


def _coincide(first: Array, second: Array) -> NDArray[np.bool_]:
    x, y, z = (first[..., i] == second[..., i] for i in range(3))  # a reduction over three is slow
    return np.asarray(x & y & z)


def with_all_normals(vertices: Array, faces: Integers, normals: Array) -> Array:
    """Fill in missing normals from the adjacent triangles: at tips and where rows meet themselves.

    Vertices at one position share a normal; those without a triangle stay NaN.
    """
    if np.isfinite(normals.sum()):
        return normals
    missing = ~np.isfinite(normals).all(axis=1, keepdims=True)
    _, index = np.unique(vertices + 0.0, axis=0, return_inverse=True)
    index = index.ravel()
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    total = np.zeros((int(index.max()) + 1, 3))
    for i in range(3):
        np.add.at(total, index[faces[:, i]], cross)
    lengths = np.linalg.norm(total, axis=1, keepdims=True)
    mean = total / np.where(lengths > 0, lengths, np.nan)
    return np.where(missing, mean[index], normals)


def drop_unused_vertices(vertices: Array, faces: Integers, normals: Array, uv: Array | None) -> TriangleMesh:
    """Make a mesh without vertices that no triangle uses."""
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    if used.all():
        return TriangleMesh(vertices, faces, normals, uv)
    index = np.cumsum(used) - 1
    return TriangleMesh(vertices[used], index[faces], normals[used], None if uv is None else uv[used])
