"""Triangles and meshes of them (thesis 4.7.4): checked once, a row for each."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from ...interchange.meshes import NOISE, load_mesh, load_with_normals
from .. import values
from .base import Surface

Array = NDArray[Any]
#: Sizes of coordinates whose products, of four of them, neither overflow nor vanish.
SMALLEST, LARGEST = 1e-60, 1e60


class Facets(Surface):
    """Triangles between vertices, seen from both sides.

    Parameters
    ----------
    vertices : array (n, 3)
    faces : integer array (m, 3)
        Corners of the triangles, as places in ``vertices``.
    normals : array (n, 3), optional
        Normals at the vertices, of any length: shading goes smoothly over the triangles. Without, each is flat.
    material : Material, optional

    Attributes
    ----------
    vertices, faces, normals : arrays, read-only
        Normals of length 1, or None.

    Raises
    ------
    SceneError
        For what is no array of such a shape, is not finite, for faces that name a vertex that is not there or have no
        area, and normals of length zero: with the first such number.

    Notes
    -----
    A ray through an edge or a corner meets every triangle there, so that none passes between two. Two meshes agree on
    that where their edges have the same ends. ``alpha`` of hits is NaN.
    """

    kind = "facets"

    def __init__(self, vertices: Any, faces: Any, *, normals: Any = None, material: Any = None) -> None:
        self.vertices = _frozen(_rows(vertices, "facets.vertices"))
        self.faces = _frozen(_faces(faces, len(self.vertices)))
        self.normals = None if normals is None else _frozen(_normals(normals, self.vertices, self.faces))
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


class Mesh(Facets):
    """Triangles of an .obj, .ply, .stl or .glb file, read with `trimesh` (extra ``mesh``).

    Parameters
    ----------
    path : path
    scale : float
        Factor on the file's coordinates: 0.001 for a file in millimetres in a scene in metres.
    smooth : bool
        Shade with normals at the vertices: the file's own, or else the mean of the triangles around each, weighted with
        their angles. Corners at one position are one vertex, so cubes are better left flat.
    material : Material, optional

    Attributes
    ----------
    path : str
    dropped_faces : int
        Triangles without an area, which are left out and logged.

    Raises
    ------
    MissingExtraError
        If `trimesh` is not installed.
    InputError
        If there is no such file, it is of another format or damaged, or holds no triangles.
    SceneError
        For a scale that is not positive.
    """

    def __init__(
        self, path: str | os.PathLike[str], *, scale: float = 1.0, smooth: bool = False, material: Any = None
    ) -> None:
        factor = values.positive(scale, "mesh.scale")
        found, normals = load_with_normals(path) if smooth else (load_mesh(path), None)
        self.path, self.dropped_faces = str(path), found.dropped_faces
        super().__init__(found.vertices * factor, found.faces, normals=normals, material=material)


def _rows(value: Any, name: str) -> Array:
    """A finite array (n, 3)."""
    found = values.reals(value)
    if found is None or found.ndim != 2 or found.shape[1] != 3:
        what = "no array of real numbers" if found is None else f"of shape {found.shape}"
        raise SceneError(f"{name} are {what}; (n, 3) is needed.")
    array = np.array(found, np.float64)
    good = np.isfinite(array).all(1)
    if not good.all():
        raise SceneError(f"{name}[{int(good.argmin())}] is not finite.")
    return array


def _faces(value: Any, count: int) -> Array:
    """Places of corners (m, 3)."""
    found = values.reals(value)
    if found is None or found.dtype.kind not in "iu":
        raise SceneError("facets.faces are no whole numbers; give places of vertices.")
    if found.ndim != 2 or found.shape[1] != 3:
        raise SceneError(f"facets.faces have shape {found.shape}; (m, 3) is needed: split polygons into triangles.")
    bad = ((found < 0) | (found >= count)).any(1)
    if bad.any():
        i = int(bad.argmax())
        raise SceneError(f"facets.faces[{i}] is {found[i].tolist()}; places of {count} vertices run from 0.")
    return np.array(found, np.int64)


def _normals(value: Any, vertices: Array, faces: Array) -> Array:
    """Unit normals (n, 3); those of vertices without a triangle do not matter."""
    rows = _rows(value, "facets.normals")
    if len(rows) != len(vertices):
        raise SceneError(f"facets.normals are {len(rows)}; one for each of the {len(vertices)} vertices is needed.")
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
    """Products of four coordinates must be numbers; a mesh that is all at the origin has no area, as is told next."""
    largest = float(np.abs(vertices).max(initial=0.0))
    if largest > LARGEST or 0 < largest < SMALLEST:
        raise SceneError(
            f"facets.vertices reach {largest:g}; sizes from {SMALLEST:g} to {LARGEST:g} are taken. "
            "Measure in another unit."
        )


def _check_areas(vertices: Array, faces: Array) -> None:
    """Refuse triangles of which only rounding is left."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    u, v = b - a, c - a
    double_area = np.linalg.norm(np.cross(u, v), axis=1)
    longest = np.sqrt(np.maximum((u * u).sum(1), (v * v).sum(1)))
    reach = np.abs(vertices).max(initial=0.0)
    flat = ~(double_area > np.finfo(float).eps * NOISE * longest * reach)
    if flat.any():
        i = int(flat.argmax())
        raise SceneError(f"facets.faces[{i}] is {faces[i].tolist()}, a triangle without an area; leave it out.")


def _frozen(array: Array) -> Array:
    array.setflags(write=False)
    return array


__all__ = ["Facets", "Mesh"]
