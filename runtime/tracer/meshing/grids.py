"""Triangles of grids of vertices: rows along a curve, columns around or along its objects.

Positions that belong together are made equal to the last bit, so that meshes close.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from .triangles import TriangleMesh

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
#: Normals on both sides of a joint that differ by less than this are one; the joint is then no edge.
SMOOTH = 1e-6
#: Vertices of neighbouring rows are one if they are nearer than so many rounding units of the grid's extent and of its
#: coordinates.
SAME_PLACE, SAME_FAR_PLACE = 64, 8
#: One diagonal of a quad must be shorter than the other by this share to be preferred: rounding does not choose.
CLEARLY = 1e-6


@dataclass(frozen=True, eq=False)
class Grid:
    """Rows of vertices.

    Attributes
    ----------
    positions, normals : (rows, columns, 3) arrays
        Normals are NaN where the surface has none.
    u : (columns,) array
    v : (rows,) array
    run : (rows,) array of int
        Rows of one number are connected.
    joined : (runs,) array of bool
        A run begins where the one before ends: their rows there are one.
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

    def turned_over(self, vertices: NDArray[np.bool_], faces: NDArray[np.bool_]) -> Patch:
        """With the other side outwards, where these masks say so."""
        turned = np.where(faces[:, None], self.faces[:, [0, 2, 1]], self.faces)
        return Patch(self.vertices, turned, np.where(vertices[:, None], -self.normals, self.normals), self.uv)

    def mesh(self) -> TriangleMesh:
        """The mesh, with every normal there and without vertices of no triangle.

        Raises
        ------
        SceneError
            Where triangles have no area, and the surface no normal.
        """
        normals = with_all_normals(self.vertices, self.faces, self.normals)
        if not np.isfinite(normals[self.faces]).all():
            raise nothing_swept("a part of the surface")
        return compacted(self.vertices, self.faces, normals, self.uv)


def nothing_swept(what: str) -> SceneError:
    """The error for what has no area."""
    return SceneError(
        f"{what} is a line: nothing is swept there, and it has no normal.",
        remedy="Give objects that do not move within one line",
    )


def together(patches: Sequence[Patch]) -> Patch:
    """Patches as one."""
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
    """Triangles of a grid without degenerate ones, and the row that each vertex and each triangle belongs to."""
    positions, normals = standing(grid.positions), _from_neighbours(grid.normals)
    if grid.is_round:
        positions[:, -1], normals[:, -1] = positions[:, 0], normals[:, 0]
    kept = np.ones(len(positions), bool)
    firsts = np.flatnonzero(np.diff(grid.run, prepend=-1))
    for at, is_joined in zip(firsts, grid.joined, strict=True):  # runs are few
        if is_joined:
            positions[at] = positions[at - 1]
            kept[at] = not _same(normals[at], normals[at - 1])
    if grid.is_closed:
        positions[-1] = positions[0]
        if _same(normals[-1], normals[0]):
            normals[-1] = normals[0]
    rows, columns = positions.shape[:2]
    place = np.cumsum(kept) - 1  # a row that is left out is the one before it
    lower = np.flatnonzero(grid.run[1:] == grid.run[:-1])
    faces, row = _triangles(positions, place, lower, columns)
    u, v = np.broadcast_arrays(grid.u[None, :], grid.v[:, None])
    uv = np.stack([u, v], -1)[kept].reshape(-1, 2)
    patch = Patch(positions[kept].reshape(-1, 3), faces, normals[kept].reshape(-1, 3), uv)
    return patch, np.repeat(np.flatnonzero(kept), columns), row


def standing(positions: Array) -> Array:
    """Vertices that stand still from row to row (tips of cones), at one position to the last bit."""
    extent = max(np.ptp(positions[..., i]) for i in range(3))
    limit = np.finfo(float).eps * (SAME_PLACE * extent + SAME_FAR_PLACE * np.abs(positions).max())
    x, y, z = (np.abs(np.diff(positions[..., i], axis=0)) > limit for i in range(3))
    moved = x | y | z
    if moved.all():
        return positions.copy()
    first = np.concatenate([np.ones((1, moved.shape[1]), bool), moved])
    source = np.maximum.accumulate(np.where(first, np.arange(len(positions))[:, None], 0), axis=0)
    return np.asarray(np.take_along_axis(positions, source[..., None], axis=0))


def _from_neighbours(normals: Array) -> Array:
    """Normals with those that are missing, as at tips, taken from the next vertex of the row."""
    found = normals.copy()
    if np.isfinite(found.sum()):
        return found
    for shift in (1, -1):
        beside = np.roll(normals, shift, axis=1)
        beside[:, 0 if shift > 0 else -1] = np.nan
        found = np.where(np.isfinite(found), found, beside)
    return found


def _same(first: Array, second: Array) -> bool:
    """Whether normals agree; those that are not there agree with everything."""
    return not bool((np.abs(first - second).max(-1) > SMOOTH).any())


def _triangles(positions: Array, place: Integers, lower: Integers, columns: int) -> tuple[Integers, Integers]:
    """Two triangles for each quad, cut along its shorter diagonal, and their rows.

    Those with two corners at one position are left out.
    """
    below, above = positions[lower], positions[lower + 1]
    rising, falling = _squares(above[:, 1:], below[:, :-1]), _squares(above[:, :-1], below[:, 1:])
    j = np.arange(columns - 1)
    a, b = place[lower][:, None] * columns + j, place[lower + 1][:, None] * columns + j
    p, q, r, s = a, a + 1, b + 1, b
    cut = (falling < (1 - CLEARLY) * rising)[..., None]
    first = np.where(cut, np.stack([p, q, s], -1), np.stack([p, q, r], -1))
    second = np.where(cut, np.stack([q, r, s], -1), np.stack([p, r, s], -1))
    same_below, same_above = _coincide(below[:, :-1], below[:, 1:]), _coincide(above[:, :-1], above[:, 1:])
    same_left, same_right = _coincide(below[:, :-1], above[:, :-1]), _coincide(below[:, 1:], above[:, 1:])
    across = _coincide(below[:, :-1], above[:, 1:]) | _coincide(below[:, 1:], above[:, :-1])
    is_cut = cut[..., 0]
    first_gone = same_below | np.where(is_cut, same_left, same_right) | across
    second_gone = same_above | np.where(is_cut, same_right, same_left) | across
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
    """Normals with those that are missing taken from the triangles around: at tips and where rows meet themselves.

    Vertices at one position share; what has no triangle either is left NaN.
    """
    if np.isfinite(normals.sum()):
        return normals
    missing = ~np.isfinite(normals).all(axis=1, keepdims=True)
    _, place = np.unique(vertices + 0.0, axis=0, return_inverse=True)
    place = place.ravel()
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    total = np.zeros((int(place.max()) + 1, 3))
    for i in range(3):
        np.add.at(total, place[faces[:, i]], across)
    lengths = np.linalg.norm(total, axis=1, keepdims=True)
    mean = total / np.where(lengths > 0, lengths, np.nan)
    return np.where(missing, mean[place], normals)


def compacted(vertices: Array, faces: Integers, normals: Array, uv: Array | None) -> TriangleMesh:
    """A mesh without the vertices of no triangle."""
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    if used.all():
        return TriangleMesh(vertices, faces, normals, uv)
    place = np.cumsum(used) - 1
    return TriangleMesh(vertices[used], place[faces], normals[used], None if uv is None else uv[used])


__all__ = ["Grid", "Patch", "compacted", "grid_patch", "nothing_swept", "standing", "together", "with_all_normals"]
