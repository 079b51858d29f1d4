"""Meshes of spheres, discs, squares of planes, and facets."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from ..scene import values
from ..surfaces.material import perpendicular_basis
from .grids import Grid, drop_unused_vertices, grid_patch
from .triangle_mesh import TriangleMesh

Array = NDArray[np.float64]


def sphere_mesh(surface: Any, rings: int, segments: int) -> TriangleMesh:
    """Mesh of ``rings`` bands from pole to pole along e3 and ``segments`` quads around; u is the longitude."""
    u, v = np.linspace(0.0, 1.0, segments + 1), np.linspace(0.0, 1.0, rings + 1)
    around, up = 2 * np.pi * u, np.pi * v
    distance, height = np.sin(up), -np.cos(up)
    distance[[0, -1]] = 0.0  # the poles are points
    normals = np.stack(
        [distance[:, None] * np.cos(around), distance[:, None] * np.sin(around), height[:, None] + 0 * around], -1
    )
    positions = surface.center + surface.radius * normals
    run = np.zeros(rings + 1, np.int64)
    return grid_patch(Grid(positions, normals, u, v, run, np.zeros(1, bool), True, False))[0].mesh()


def disc_mesh(surface: Any, segments: int) -> TriangleMesh:
    """Fan of triangles; u runs around, v from 0 at the center to 1 at the rim."""
    u = np.linspace(0.0, 1.0, segments + 1)
    first, second = perpendicular_basis(surface.normal)
    angles = 2 * np.pi * u[:, None]
    rim = surface.center + surface.radius * (np.cos(angles) * first + np.sin(angles) * second)
    rim[-1] = rim[0]
    j = np.arange(segments)
    faces = np.stack([np.full(segments, segments + 1), j, j + 1], 1)
    uv = np.concatenate([np.stack([u, np.ones(segments + 1)], 1), [[0.5, 0.0]]])
    vertices = np.concatenate([rim, surface.center[None]])
    return TriangleMesh(vertices, faces, np.tile(surface.normal, (len(vertices), 1)), uv)


def plane_mesh(surface: Any, extent: float | None, center: Any) -> TriangleMesh:
    """Square of a plane; u and v run over it from 0 to 1."""
    if extent is None:
        raise SceneError("a plane is unbounded", remedy="Give the side of a square: mesh(extent=10.0)")
    side = values.positive(extent, "extent")
    near = np.zeros(3) if center is None else values.finite(center, "center", 3)
    middle = near - (near @ surface.normal - surface.offset) * surface.normal
    first, second = perpendicular_basis(surface.normal)
    uv = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    corners = middle + side * ((uv[:, :1] - 0.5) * first + (uv[:, 1:] - 0.5) * second)
    return TriangleMesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), np.tile(surface.normal, (4, 1)), uv)


def facets_mesh(surface: Any) -> TriangleMesh:
    """Mesh of the same triangles; flat ones get corners of their own, because a vertex has one normal."""
    if surface.normals is not None:
        return drop_unused_vertices(surface.vertices, surface.faces, surface.normals, None)
    corners = surface.vertices[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = normals / np.abs(normals).max(1, keepdims=True)
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    return TriangleMesh(corners.reshape(-1, 3), faces, np.repeat(normals, 3, axis=0))
