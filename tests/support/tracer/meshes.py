"""What the tests of meshes share: curves, and how the triangles lie to their normals."""

from __future__ import annotations

import numpy as np
import trimesh

from .scenes import TUBE

BENT = [*TUBE, ((0.5, 2.0, 3.0), (0.2, 1.0, 0.4), 0.8), ((1.5, 3.0, 2.5), (1.0, 1.0, 0.1), 0.5)]
RIBBON = [((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), ((0.0, 1.0, 1.0), (1.0, 2.0, 0.5)), ((0.3, 2.5, 1.0), (1.2, 3.0, 1.5))]


def necklace(count=6, bend=0.2):
    """Circles around a closed curve that does not lie in a plane: carried around it, rings come back turned."""
    angles = 2 * np.pi * np.arange(count) / count
    return [
        ((3 * np.cos(a), 3 * np.sin(a), bend * np.sin(2 * a + 0.3)), (-np.sin(a), np.cos(a), bend * np.cos(3 * a)),
         0.8 + 0.2 * np.sin(a))
        for a in angles
    ]  # fmt: skip


def face_normals(mesh):
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def agreement(mesh):
    """The least cosine between a triangle's normal and those at its corners."""
    return np.einsum("fi,fci->fc", face_normals(mesh), mesh.vertex_normals[mesh.faces]).min()


def as_trimesh(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces)
