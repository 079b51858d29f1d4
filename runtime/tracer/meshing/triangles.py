"""Triangle meshes with normals and texture coordinates: checked, not changed once made."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from .. import values

Array = NDArray[Any]
#: Normals whose length is further from 1 than this are refused: they were not meant to be unit vectors.
UNIT_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles with shared vertices. Arrays are checked, and cannot be written to.

    Attributes
    ----------
    vertices : (n, 3) array
        In the units of the scene.
    faces : (m, 3) array of int
        Corners as places in ``vertices``, counter-clockwise seen from the side that the normals are on.
    vertex_normals : (n, 3) array
        Unit normals.
    uv : (n, 2) array or None
        Texture coordinates: u around or along the object, v the curve's parameter. Where a texture begins and ends
        there are two vertices at one position.
    name : str

    Raises
    ------
    SceneError
        For arrays of other shapes, numbers that are not finite, and faces that name no vertex.
    """

    vertices: Array
    faces: Array
    vertex_normals: Array
    uv: Array | None = None
    name: str = ""

    def __post_init__(self) -> None:
        vertices = _rows(self.vertices, "vertices", 3)
        normals = _rows(self.vertex_normals, "vertex_normals", 3, len(vertices))
        uv = None if self.uv is None else _rows(self.uv, "uv", 2, len(vertices))
        lengths = np.sqrt(np.einsum("ij,ij->i", normals, normals))
        bad = np.abs(lengths - 1) > UNIT_TOLERANCE
        if bad.any():
            i = int(bad.argmax())
            raise SceneError(f"mesh.vertex_normals[{i}] has the length {lengths[i]:g}; normals are unit vectors.")
        faces = values.reals(self.faces)
        if faces is None or faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise SceneError("mesh.faces are no array (m, 3) of whole numbers.")
        if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
            raise SceneError(f"mesh.faces name a vertex that is not there ({len(vertices)} vertices).")
        frozen = {"vertices": vertices, "vertex_normals": normals, "uv": uv, "faces": faces.astype(np.int64)}
        for name, array in frozen.items():
            if array is not None:
                array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __repr__(self) -> str:
        return f"<TriangleMesh{f' {self.name}' if self.name else ''} of {len(self.faces)} triangles>"

    @cached_property
    def volume(self) -> float:
        """The volume inside, where the mesh is closed: positive if normals look outwards."""
        return float(face_volumes(self.vertices, self.faces).sum())

    def welded(self) -> TriangleMesh:
        """The mesh with each position once, without texture: normals there are means. Sharp edges are rounded off."""
        positions, place = np.unique(self.vertices + 0.0, axis=0, return_inverse=True)  # -0 and 0 are one
        place = place.ravel()
        total = np.stack([np.bincount(place, self.vertex_normals[:, i], len(positions)) for i in range(3)], 1)
        lengths = np.linalg.norm(total, axis=1, keepdims=True)
        one = np.zeros_like(total)
        one[place] = self.vertex_normals
        cancelled = lengths[:, 0] < UNIT_TOLERANCE
        normals = np.where(cancelled[:, None], one, total / np.where(cancelled[:, None], 1.0, lengths))
        return TriangleMesh(positions, place[self.faces], normals, None, self.name)

    def moved(self, scale: float = 1.0, shift: Any = 0.0) -> TriangleMesh:
        """The mesh scaled about the origin, then moved."""
        way = values.finite(shift, "shift")
        if way.shape not in ((), (3,)):
            raise SceneError(f"shift has shape {way.shape}; 3 numbers are needed.")
        return replace(self, vertices=self.vertices * values.positive(scale, "scale") + way)

    def save(self, path: str | os.PathLike[str], *, scale: float = 1.0) -> None:
        """Write an .obj, .ply, .stl or .glb file, in one step, with `trimesh` (extra ``mesh``).

        Parameters
        ----------
        path : path
            Normals and texture coordinates are written where the format has them; .stl has neither. All but .obj
            keep single precision; a .glb far from the origin holds positions relative to its middle.
        scale : float
            Factor on the positions: 0.001 where the scene counts millimetres, for readers of .glb take metres.

        Raises
        ------
        MissingExtraError
            If `trimesh` is not installed.
        InputError
            For another ending, and a scale that is not positive.
        OSError
            If the file cannot be written; what was there before is kept.
        """
        from .saving import save_meshes

        save_meshes(path, [(self, None)], scale=scale)


def face_volumes(vertices: Array, faces: Array) -> Array:
    """Of each triangle the volume between it and a vertex: they add up to what a closed mesh encloses, positive if
    faces turn counter-clockwise seen from outside."""
    if not len(faces):
        return np.zeros(0)
    local = vertices - vertices[faces[0, 0]]
    a, b, c = (local[faces[:, i]] for i in range(3))
    return np.asarray(np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)


def _rows(value: Any, name: str, size: int, count: int | None = None) -> Array:
    found = values.reals(value)
    if found is None or found.ndim != 2 or found.shape[1] != size or (count is not None and len(found) != count):
        wanted = f"({'n' if count is None else count}, {size})"
        shape = "no real numbers" if found is None else f"of shape {found.shape}"
        raise SceneError(f"mesh.{name} are {shape}; {wanted} is needed.")
    array = np.array(found, np.float64)
    if not np.isfinite(array).all():
        good = np.isfinite(array).all(1)
        raise SceneError(f"mesh.{name}[{int(good.argmin())}] is not finite.")
    return array


__all__ = ["TriangleMesh", "face_volumes"]
