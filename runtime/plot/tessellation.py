"""Outlines of objects as arrays of positions: sampled circles, lines and planes clipped to a box, meshes, arrows.

Functions map parameters to positions, for whole batches, and do not depend on multivectors or matplotlib.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Largest coordinate that is drawn, and largest view: squares of coordinates do not overflow.
FARTHEST = 1e100
Array = NDArray[np.float64]
_UNITS, _NEXT, _AFTER = np.eye(3), np.array([1, 2, 0]), np.array([2, 0, 1])

#: Corners of the unit box.
CORNERS = np.stack(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], indexing="ij"), -1).reshape(8, 3)
#: Edges of the unit box as pairs of corners.
EDGES = np.array([(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit])


class Box(NamedTuple):
    """An axis-aligned box from its least to its greatest corner, both (3,)."""

    low: Array
    high: Array

    @property
    def center(self) -> Array:
        """Center of the box."""
        return (self.low + self.high) / 2

    @property
    def size(self) -> float:
        """Longest side of the box."""
        return float((self.high - self.low).max())

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Test whether positions (..., 3) are inside, up to rounding of the box's size."""
        slack = 1e-9 * self.size
        return all_three((x >= self.low - slack) & (x <= self.high + slack))


def all_three(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether all of a last axis of 3 hold: NumPy's own reduction of so short an axis takes several times as long."""
    return np.asarray(flags[..., 0] & flags[..., 1] & flags[..., 2])


def cross(a: Array, b: Array) -> Array:
    """Cross product of vectors (..., 3), in a third of the time of NumPy's for few of them."""
    return a[..., _NEXT] * b[..., _AFTER] - a[..., _AFTER] * b[..., _NEXT]


def unit(v: Array) -> Array:
    """Normalize vectors (..., 3)."""
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def across(normal: Array) -> tuple[Array, Array]:
    """Unit vectors u, v with u x v = normal, for unit normals (n, 3)."""
    smallest = np.abs(normal).argmin(-1)
    u = unit(cross(_UNITS[smallest], normal))
    return u, cross(normal, u)


def circles(center: Array, normal: Array, radius: Array, count: int, box: Box | None = None) -> Array:
    """Polygons (n, count + 1, 3), counter-clockwise about the normals: closed, or the arc of a large circle near a box.

    Points of a box of diagonal d are at most d/2 from its center, so that a circle with r > d/2 lies in it for less
    than asin(d/(2 r)) on either side of its point nearest to the center.
    """
    u, v = across(normal)
    nearest, half = np.zeros(len(center)), np.full(len(center), np.pi)
    if box is not None:
        sine = float(np.linalg.norm(box.high - box.low)) / (2 * radius)
        away = box.center - center
        is_large = sine < 1
        nearest = np.where(is_large, np.arctan2((away * v).sum(-1), (away * u).sum(-1)), nearest)
        half = np.where(is_large, np.arcsin(np.minimum(sine, 1)), half)
    angle = (nearest[:, None] + half[:, None] * np.linspace(-1.0, 1.0, count + 1))[..., None]
    radial = np.cos(angle) * u[:, None] + np.sin(angle) * v[:, None]
    return np.asarray(center[:, None] + radius[:, None, None] * radial)


def circle_extent(normal: Array, radius: Array) -> Array:
    """Half sides (n, 3) of the boxes around circles."""
    return radius[:, None] * np.sqrt(np.clip(1 - normal * normal, 0, None))


def lines_in(box: Box, point: Array, direction: Array) -> Array:
    """Clip lines to a box: segments (n, 2, 3), NaN for lines that miss it."""
    with np.errstate(all="ignore"):
        walls = np.stack([box.low - point, box.high - point]) / direction
    still = direction == 0  # such a coordinate never changes: it is between its walls, or the line misses the box
    between = (point >= box.low) & (point <= box.high)
    walls[:, still & between] = np.array([-np.inf, np.inf])[:, None]
    walls[:, still & ~between] = np.array([np.inf, -np.inf])[:, None]
    enter, leave = walls.min(0).max(-1), walls.max(0).min(-1)
    misses = (still & ~between).any(-1) | ~(enter <= leave)
    ends = np.where(misses, np.nan, np.stack([enter, leave]))
    return np.moveaxis(point + ends[..., None] * direction, 0, 1)


def planes_in(box: Box, normal: Array, offset: Array) -> Array:
    """Clip planes to a box: convex polygons (n, 12, 3), NaN for planes that miss it.

    A polygon has three to six corners: the rest of the twelve repeat one of them.
    """
    corners = box.low + CORNERS * (box.high - box.low)
    start, end = corners[EDGES[:, 0]], corners[EDGES[:, 1]]
    height = normal @ corners.T - offset[:, None]
    first, second = height[:, EDGES[:, 0]], height[:, EDGES[:, 1]]
    with np.errstate(all="ignore"):
        fraction = np.where(first == second, 0.0, first / (first - second))
    hit = (first * second <= 0) & ~((first == second) & (first != 0))
    cut = start + np.clip(fraction, 0, 1)[..., None] * (end - start)
    total = hit.sum(-1)
    with np.errstate(all="ignore"):
        middle = np.where(hit[..., None], cut, 0).sum(1) / total[:, None]
    u, v = across(normal)
    away = cut - middle[:, None]
    angle = np.arctan2((away * v[:, None]).sum(-1), (away * u[:, None]).sum(-1))
    order = np.where(hit, angle, np.inf).argsort(-1)
    polygon = np.take_along_axis(cut, order[..., None], 1)
    used = np.arange(len(EDGES)) < total[:, None]
    polygon = np.where(used[..., None], polygon, polygon[:, :1])
    return np.where((total >= 3)[:, None, None], polygon, np.nan)


def scaled(shape: Array, center: Array, radius: Array) -> Array:
    """Copies (n, ..., 3) of a shape (..., 3) about the origin, each of its size, about centers (n, 3)."""
    several = (len(center), *(1,) * (shape.ndim - 1))
    return np.asarray(center.reshape(*several, 3) + radius.reshape(*several, 1) * shape)


@lru_cache(maxsize=8)
def great_circles(axes: tuple[int, ...], count: int) -> Array:
    """Polygons (k, count + 1, 3) on the unit sphere, about axes of coordinates."""
    normals = _UNITS[list(axes)]
    return circles(np.zeros_like(normals), normals, np.ones(len(normals)), count)


@lru_cache(maxsize=8)
def unit_sphere(rings: int, sectors: int) -> tuple[Array, Array]:
    """Quadrilaterals (rings sectors, 4, 3) of the unit sphere, and their outward unit normals."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)
    longitude = np.linspace(0.0, 2 * np.pi, sectors + 1)
    ring, turn = np.meshgrid(latitude, longitude, indexing="ij")
    ball = np.stack([np.cos(ring) * np.cos(turn), np.cos(ring) * np.sin(turn), np.sin(ring)], -1)
    quads = np.stack([ball[:-1, :-1], ball[:-1, 1:], ball[1:, 1:], ball[1:, :-1]], 2).reshape(-1, 4, 3)
    return quads, unit(quads.sum(1))


def arrows(tail: Array, vector: Array, head: Array | float) -> Array:
    """Arrows as polylines (n, 9, 3): a shaft and four barbs of length ``head``, which all end at the tip."""
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    along = vector / np.where(length > 0, length, 1)
    u, v = across(np.where(length > 0, along, [0.0, 0.0, 1.0]))
    head = np.minimum(np.broadcast_to(head, length.shape[:1])[:, None], length)
    tip = tail + vector
    parts = [tail, tip]
    for side in (u, v, -u, -v):
        parts += [tip + head * (0.4 * side - along), tip]
    return np.stack(parts[:9], 1)


def common_point(points: Array, spread: Array) -> Array:
    """The position nearest to flats through ``points``: sum of spread (x - p) = 0, ``spread`` (n, 3, 3) projecting."""
    matrix = spread.mean(0)
    right = np.einsum("nij,nj->i", spread, points) / len(points)
    start = points.mean(0)
    return np.asarray(start + np.linalg.pinv(matrix, rcond=1e-9) @ (right - matrix @ start))
