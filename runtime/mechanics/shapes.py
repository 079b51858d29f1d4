"""Solids of uniform density by their measures: what they weigh, how they resist turning, and the surface to draw.

Every shape has its centre of mass at the origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, ShapeError
from .given import length as given_length
from .given import number, vectors

Array = NDArray[Any]
#: Sides of what is round, in pictures.
SIDES = 24
#: Radius of a rod that is given none, as a share of its length.
SLENDER = 0.02


@dataclass(frozen=True, eq=False)
class Shape:
    """A solid, or a surface that is only drawn.

    Attributes
    ----------
    vertices, faces : array (v, 3), (f, 3)
        Its surface; the origin is the centre of mass.
    volume : float
    gyration : array (3, 3)
        Inertia tensor about the centre of mass, for mass 1.
    edges : array (e, 2)
        Edges that pictures show, as pairs of vertices.
    """

    vertices: Array
    faces: Array
    volume: float
    gyration: Array
    edges: Array

    def inertia(self, mass: float) -> Array:
        """Inertia tensor (3, 3) about the centre of mass."""
        found: Array = number(mass, "the mass") * self.gyration
        return found


def box(size: Any) -> Shape:
    """A cuboid with sides (a, b, c) along the axes."""
    given = vectors(size, "the size")
    if given.shape != (3,):
        raise ShapeError(f"the size has shape {given.shape}; three sides are needed.")
    sides = np.array([given_length(side, f"the size[{i}]") for i, side in enumerate(given)])
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * sides / 2
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    edges = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]
    squares = sides**2
    return Shape(corners, _fans(quads), float(sides.prod()), np.diag(squares.sum() - squares) / 12, np.array(edges))


def sphere(radius: float) -> Shape:
    """A ball."""
    r = given_length(radius, "the radius")
    heights = np.cos(np.linspace(0, np.pi, SIDES // 2 + 1))
    rings = np.sqrt(np.maximum(0, 1 - heights**2))
    vertices, faces, edges = _turned(rings, heights, [SIDES // 4])
    meridian = np.arange(0, len(rings) * SIDES, SIDES)
    more = [np.stack([meridian[:-1] + k, meridian[1:] + k], 1) for k in range(0, SIDES, SIDES // 4)]
    volume = 4 / 3 * np.pi * r**3
    return Shape(r * vertices, faces, volume, 2 / 5 * r**2 * np.eye(3), np.concatenate([edges, *more]))


def cylinder(radius: float, height: float, axis: Any = (0, 0, 1)) -> Shape:
    """A cylinder about an axis."""
    r, h = (given_length(x, name) for x, name in ((radius, "the radius"), (height, "the height")))
    vertices, faces, edges = _turned(np.array([0, r, r, 0]), np.array([-h, -h, h, h]) / 2, [1, 2])
    across = (3 * r**2 + h**2) / 12
    return _along(axis, Shape(vertices, faces, np.pi * r**2 * h, np.diag([across, across, r**2 / 2]), edges))


def cone(radius: float, height: float, axis: Any = (0, 0, 1)) -> Shape:
    """A cone; the axis points to its tip, 3/4 of the height from the centre of mass."""
    r, h = (given_length(x, name) for x, name in ((radius, "the radius"), (height, "the height")))
    vertices, faces, edges = _turned(np.array([0, r, 0]), np.array([-h, -h, 3 * h]) / 4, [1])
    sides = [np.array([(SIDES + k, 2 * SIDES + k) for k in range(0, SIDES, SIDES // 4)])]
    across = 3 * r**2 / 20 + 3 * h**2 / 80
    tensor = np.diag([across, across, 3 * r**2 / 10])
    return _along(axis, Shape(vertices, faces, np.pi * r**2 * h / 3, tensor, np.concatenate([edges, *sides])))


def rod(length: float, radius: float | None = None, axis: Any = (0, 0, 1)) -> Shape:
    """A thin cylinder; its radius is 1/50 of its length where none is given."""
    size = given_length(length, "the length")
    return cylinder(SLENDER * size if radius is None else radius, size, axis)


def mesh(surface: Any, scale: float = 1.0) -> tuple[Shape, Array]:
    """The solid inside a closed mesh, and the centre of mass (3,) in the mesh's coordinates; see `mass_properties`."""
    from ..interchange.meshes import Mesh, load_mesh
    from .solids import mass_properties

    found = surface if isinstance(surface, Mesh) else load_mesh(surface)
    vertices = found.vertices * given_length(scale, "the scale")
    mass, center, tensor = mass_properties((vertices, found.faces))
    return Shape(vertices - center, found.faces, float(mass), tensor / mass, _sharp(vertices, found.faces)), center


# -- surfaces --------------------------------------------------------------------------------------------------


def _fans(polygons: Any) -> Array:
    """Triangles of convex polygons."""
    return np.array([(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)])


def _turned(radii: Array, heights: Array, shown: list[int]) -> tuple[Array, Array, Array]:
    """A surface of revolution about e3 from the bottom (or top) up, and the edges of some of its rings."""
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    around = np.stack([np.cos(angles), np.sin(angles)], -1)
    flat = np.broadcast_to(heights[:, None, None], (len(heights), SIDES, 1))
    vertices = np.concatenate([radii[:, None, None] * around, flat], -1).reshape(-1, 3)
    here = np.arange(SIDES)
    ahead = (here + 1) % SIDES
    faces = []
    for ring in range(len(radii) - 1):
        low, high = ring * SIDES, (ring + 1) * SIDES
        if radii[ring] > 0:
            faces.append(np.stack([low + here, low + ahead, high + here], 1))
        if radii[ring + 1] > 0:
            faces.append(np.stack([low + ahead, high + ahead, high + here], 1))
    found = np.concatenate(faces)
    if heights[0] > heights[-1]:
        found = found[:, ::-1]
    edges = np.concatenate([np.stack([ring * SIDES + here, ring * SIDES + ahead], 1) for ring in shown])
    return vertices, found, edges


#: Edges of a mesh are shown where its triangles meet at more than this angle, in degrees.
SHARP = 30.0


def _sharp(vertices: Array, faces: Array) -> Array:
    """Edges where a surface bends."""
    normals = np.cross(vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]])
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, sizes, out=np.zeros_like(normals), where=sizes > 0)
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, edge_of, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    owners = np.repeat(np.arange(len(faces)), 3)
    order = np.argsort(edge_of.ravel(), kind="stable")
    first = np.cumsum(count) - count
    pair = count == 2
    a, b = owners[order[first[pair]]], owners[order[first[pair] + 1]]
    bent = (normals[a] * normals[b]).sum(1) < np.cos(np.radians(SHARP))
    return np.concatenate([edges[pair][bent], edges[~pair]])


def _along(axis: Any, shape: Shape) -> Shape:
    """A shape about e3, turned to an axis."""
    way = vectors(axis, "the axis")
    if way.shape != (3,):
        raise ShapeError(f"the axis has shape {way.shape}; one direction (3,) is needed.")
    if not way.any():
        raise InputError("the axis is zero; a direction is needed.")
    way = way / np.abs(way).max()  # before it is squared
    turn = _turn(way / np.linalg.norm(way))
    return Shape(
        shape.vertices @ turn.T, shape.faces, shape.volume, turn @ shape.gyration @ turn.T, shape.edges
    )  # fmt: skip


def _turn(way: Array) -> Array:
    """A rotation that takes e3 to a unit vector; exact along the axes."""
    helper = np.eye(3)[int(np.abs(way).argmin())]
    first = helper - (helper @ way) * way
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(way, first), way], 1)


__all__ = ["Shape", "box", "cone", "cylinder", "mesh", "rod", "sphere"]
