"""Surfaces of triangles (thesis 4.7.4): checked once, a row of parameters for each triangle."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.validation import finite_array
from ...errors import SceneError
from ...interchange.meshes import NOISE, face_indices, load_mesh, load_with_normals
from ..scene import values
from .base import Surface

Array = NDArray[Any]
#: Smallest magnitude of coordinates: products of four of them do not vanish.
SMALLEST = 1e-60
#: Largest magnitude of coordinates: products of four of them do not overflow.
LARGEST = 1e60


class Facets(Surface):
    """Triangles between vertices, visible from both sides.

    Parameters
    ----------
    vertices : array (n, 3)
    faces : integer array (m, 3)
        Corners of the triangles, as indices into ``vertices``.
    normals : array (n, 3), optional
        Normals at the vertices, of any length, for smooth shading. Default: flat triangles.
    material : Material, optional

    Attributes
    ----------
    vertices, faces, normals : arrays, read-only
        Normals of length 1, or None.

    Raises
    ------
    SceneError
        For arrays of other shapes, numbers that are not finite, faces with an index out of range or without an area,
        and normals of length zero: with the index of the first.

    Notes
    -----
    A ray through an edge or a corner meets every triangle there, so that none passes between two; across two meshes
    too, where their edges have the same ends. ``alpha`` of hits is NaN.
    """

    kind = "facets"

    def __init__(self, vertices: Any, faces: Any, *, normals: Any = None, material: Any = None) -> None:
        self.vertices = _read_only(finite_array(vertices, "facets.vertices", ("n", 3), SceneError).copy())
        self.faces = _read_only(face_indices(faces, "facets.faces", len(self.vertices), SceneError))
        self.normals = None if normals is None else _read_only(_normals(normals, self.vertices, self.faces))
        _check_sizes(self.vertices)
        _check_areas(self.vertices, self.faces)
        super().__init__(material)

    @property
    def program_kind(self) -> str:
        return "facet" if self.normals is None else "smooth_facet"

    @property
    def parameters(self) -> Array:
        corners = self.vertices[self.faces].reshape(-1, 9)
        if self.normals is None:
            return np.asarray(corners)
        return np.concatenate([corners, self.normals[self.faces].reshape(-1, 9)], 1)

    def __len__(self) -> int:
        """Number of triangles."""
        return len(self.faces)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {len(self.vertices)} vertices, {len(self)} triangles>"


class Mesh(Facets):
    """Triangles of an .obj, .ply, .stl or .glb file, read with `trimesh` (extra ``mesh``).

    Parameters
    ----------
    path : path
    scale : float
        Factor on the file's coordinates: 0.001 for a file in millimetres in a scene in metres.
    smooth : bool
        Shade with normals at the vertices: the file's own, or else the mean of the triangles around each, weighted by
        angle. Corners at one position are one vertex, so cubes should stay flat.
    material : Material, optional

    Attributes
    ----------
    path : str
    dropped_faces : int
        Number of triangles without an area, which are dropped and logged.

    Raises
    ------
    MissingExtraError
        If `trimesh` is not installed.
    InputError
        If the file does not exist, has another format, is damaged, or holds no triangles.
    SceneError
        For a scale that is not positive.
    """

    def __init__(
        self, path: str | os.PathLike[str], *, scale: float = 1.0, smooth: bool = False, material: Any = None
    ) -> None:
        factor = values.positive(scale, "mesh.scale")
        loaded, normals = load_with_normals(path) if smooth else (load_mesh(path), None)
        self.path, self.dropped_faces = str(path), loaded.dropped_faces
        super().__init__(loaded.vertices * factor, loaded.faces, normals=normals, material=material)


def _normals(value: Any, vertices: Array, faces: Array) -> Array:
    """Normalize normals (n, 3); those of vertices without a triangle may be zero."""
    rows = finite_array(value, "facets.normals", (len(vertices), 3), SceneError)
    largest = np.abs(rows).max(1, initial=0.0)
    zero = largest < values.TINY
    used = np.zeros(len(rows), bool)
    used[faces] = True
    if (zero & used).any():
        raise SceneError(f"facets.normals[{int((zero & used).argmax())}] is zero.")
    scaled = rows / np.where(zero, 1.0, largest)[:, None]
    lengths = np.linalg.norm(scaled, axis=1, keepdims=True)
    return np.asarray(scaled / np.where(lengths > 0, lengths, 1.0))


def _check_sizes(vertices: Array) -> None:
    """Check that products of four coordinates stay in range; a mesh in the origin alone fails at `_check_areas`."""
    largest = float(np.abs(vertices).max(initial=0.0))
    if largest > LARGEST or 0 < largest < SMALLEST:
        raise SceneError(
            f"facets.vertices go up to {largest:g}; sizes must lie between {SMALLEST:g} and {LARGEST:g}. "
            "Measure in another unit."
        )


def _check_areas(vertices: Array, faces: Array) -> None:
    """Refuse triangles whose area is rounding error."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    u, v = b - a, c - a
    double_area = np.linalg.norm(np.cross(u, v), axis=1)
    longest = np.sqrt(np.maximum((u * u).sum(1), (v * v).sum(1)))
    magnitude = np.abs(vertices).max(initial=0.0)
    flat = ~(double_area > np.finfo(float).eps * NOISE * longest * magnitude)
    if flat.any():
        i = int(flat.argmax())
        raise SceneError(f"facets.faces[{i}] is {faces[i].tolist()}, a triangle without an area; drop it.")


def _read_only(array: Array) -> Array:
    array.setflags(write=False)
    return array
