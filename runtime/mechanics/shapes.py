"""Solids of uniform density: volume, inertia and the surface to draw.

Every shape has its center of mass at the origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..common.validation import finite_array, positive_float
from .arguments import positive_length

Array = NDArray[Any]
#: Sides of round surfaces in pictures.
SIDES = 24
#: Default radius of a rod, as a fraction of its length.
SLENDER = 0.02


@dataclass(frozen=True, eq=False)
class Shape:
    """A solid, or a surface that is only drawn.

    Attributes
    ----------
    vertices, faces : array (v, 3), (f, 3)
        Its surface; the origin is the center of mass.
    volume : float
    gyration : array (3, 3)
        Inertia tensor about the center of mass, for mass 1.
    edges : array (e, 2)
        Edges that pictures show, as pairs of vertices.
    """

    vertices: Array
    faces: Array
    volume: float
    gyration: Array
    edges: Array

    def inertia(self, mass: float) -> Array:
        """Inertia tensor (3, 3) about the center of mass."""
        tensor: Array = positive_float(mass, "the mass") * self.gyration
        return tensor


def box(size: Any) -> Shape:
    """A cuboid with sides (a, b, c) along the axes."""
    size = finite_array(size, "the size", (3,))
    sides = np.array([positive_length(side, f"the size[{i}]") for i, side in enumerate(size)])
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * sides / 2
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    edges = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]
    squares = sides**2
    return Shape(
        corners, _triangulate(quads), float(sides.prod()), np.diag(squares.sum() - squares) / 12, np.array(edges)
    )


def sphere(radius: float) -> Shape:
    """A ball."""
    r = positive_length(radius, "the radius")
    heights = np.cos(np.linspace(0, np.pi, SIDES // 2 + 1))
    rings = np.sqrt(np.maximum(0, 1 - heights**2))
    vertices, faces, edges = _surface_of_revolution(rings, heights, [SIDES // 4])
    meridian = np.arange(0, len(rings) * SIDES, SIDES)
    more = [np.stack([meridian[:-1] + k, meridian[1:] + k], 1) for k in range(0, SIDES, SIDES // 4)]
    volume = 4 / 3 * np.pi * r**3
    return Shape(r * vertices, faces, volume, 2 / 5 * r**2 * np.eye(3), np.concatenate([edges, *more]))


def cylinder(radius: float, height: float, axis: Any = (0, 0, 1)) -> Shape:
    """A cylinder about an axis."""
    r, h = (positive_length(x, name) for x, name in ((radius, "the radius"), (height, "the height")))
    vertices, faces, edges = _surface_of_revolution(np.array([0, r, r, 0]), np.array([-h, -h, h, h]) / 2, [1, 2])
    across = (3 * r**2 + h**2) / 12
    return _rotated_to_axis(axis, Shape(vertices, faces, np.pi * r**2 * h, np.diag([across, across, r**2 / 2]), edges))


def cone(radius: float, height: float, axis: Any = (0, 0, 1)) -> Shape:
    """A cone; the axis points to its tip, 3/4 of the height from the center of mass."""
    r, h = (positive_length(x, name) for x, name in ((radius, "the radius"), (height, "the height")))
    vertices, faces, edges = _surface_of_revolution(np.array([0, r, 0]), np.array([-h, -h, 3 * h]) / 4, [1])
    sides = [np.array([(SIDES + k, 2 * SIDES + k) for k in range(0, SIDES, SIDES // 4)])]
    across = 3 * r**2 / 20 + 3 * h**2 / 80
    tensor = np.diag([across, across, 3 * r**2 / 10])
    return _rotated_to_axis(axis, Shape(vertices, faces, np.pi * r**2 * h / 3, tensor, np.concatenate([edges, *sides])))


def rod(length: float, radius: float | None = None, axis: Any = (0, 0, 1)) -> Shape:
    """A thin cylinder; its radius is 1/50 of its length by default."""
    size = positive_length(length, "the length")
    return cylinder(SLENDER * size if radius is None else radius, size, axis)


def mesh(surface: Any, scale: float = 1.0) -> tuple[Shape, Array]:
    """The solid inside a closed mesh, and the center of mass (3,) in the mesh's coordinates; see `mass_properties`."""
    from ..interchange.meshes import Mesh, load_mesh
    from .mass_properties import mass_properties

    triangles = surface if isinstance(surface, Mesh) else load_mesh(surface)
    vertices = triangles.vertices * positive_length(scale, "the scale")
    mass, center, tensor = mass_properties((vertices, triangles.faces))
    return Shape(
        vertices - center, triangles.faces, float(mass), tensor / mass, _sharp_edges(vertices, triangles.faces)
    ), center


# -- surfaces --------------------------------------------------------------------------------------------------


def _triangulate(polygons: Any) -> Array:
    """Triangles of convex polygons."""
    return np.array([(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)])


def _surface_of_revolution(radii: Array, heights: Array, edge_rings: list[int]) -> tuple[Array, Array, Array]:
    """Surface of revolution about e3 from rings in the order of height, and the edges of some rings."""
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    around = np.stack([np.cos(angles), np.sin(angles)], -1)
    flat = np.broadcast_to(heights[:, None, None], (len(heights), SIDES, 1))
    vertices = np.concatenate([radii[:, None, None] * around, flat], -1).reshape(-1, 3)
    this = np.arange(SIDES)
    after = (this + 1) % SIDES
    faces = []
    for ring in range(len(radii) - 1):
        low, high = ring * SIDES, (ring + 1) * SIDES
        if radii[ring] > 0:
            faces.append(np.stack([low + this, low + after, high + this], 1))
        if radii[ring + 1] > 0:
            faces.append(np.stack([low + after, high + after, high + this], 1))
    triangles = np.concatenate(faces)
    if heights[0] > heights[-1]:
        triangles = triangles[:, ::-1]
    edges = np.concatenate([np.stack([ring * SIDES + this, ring * SIDES + after], 1) for ring in edge_rings])
    return vertices, triangles, edges


#: Edges of a mesh are shown where its triangles meet at more than this angle, in degrees.
SHARP = 30.0


def _sharp_edges(vertices: Array, faces: Array) -> Array:
    """Edges at which a surface bends by more than `SHARP`, and those of a single triangle."""
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


def _rotated_to_axis(axis: Any, shape: Shape) -> Shape:
    """Shape about e3, rotated to an axis."""
    direction = finite_array(axis, "the axis", (3,))
    if not direction.any():
        raise InputError("the axis is zero; a direction is needed.")
    direction = direction / np.abs(direction).max()  # before it is squared
    rotation = _rotation_from_e3(direction / np.linalg.norm(direction))
    return Shape(
        shape.vertices @ rotation.T, shape.faces, shape.volume, rotation @ shape.gyration @ rotation.T, shape.edges
    )  # fmt: skip


def _rotation_from_e3(direction: Array) -> Array:
    """Rotation that takes e3 to a unit vector; exact along the axes."""
    helper = np.eye(3)[int(np.abs(direction).argmin())]
    first = helper - (helper @ direction) * direction
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first), direction], 1)


__all__ = ["Shape", "box", "cone", "cylinder", "mesh", "rod", "sphere"]
