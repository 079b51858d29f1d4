"""Immutable triangle meshes with normals and texture coordinates; files of them, written with the package `trimesh`."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.interrupts import deferred_interrupts
from ...common.deprecation import renamed_attribute
from ...common.files import output_path, write_file
from ...common.validation import finite_array
from ...errors import SceneError
from ...interchange.meshes import face_indices, import_trimesh
from ..scene import values

Array = NDArray[Any]
#: Largest deviation of the length of a normal from 1.
UNIT_TOLERANCE = 1e-6
#: Contents of files, and the suffixes of their formats.
CONTENT = ("a mesh", "meshes", (".obj", ".ply", ".stl", ".glb"))
#: Significant digits of numbers in text files.
DIGITS = 16
#: Distance in extents beyond which a .glb, which holds single precision, has positions relative to their center.
FAR = 64.0
#: Roughness of materials in a .glb.
ROUGHNESS = 0.5


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles with shared vertices. Arrays are checked, and read-only.

    Attributes
    ----------
    vertices : (n, 3) array
        In the units of the scene.
    faces : (m, 3) array of int
        Corners as indices into ``vertices``, counter-clockwise about the normals.
    vertex_normals : (n, 3) array
        Unit normals.
    uv : (n, 2) array or None
        Texture coordinates: u around or along the object, v the curve's parameter. At the seam of a texture there
        are two vertices at one position.
    name : str

    Raises
    ------
    SceneError
        For arrays of other shapes, numbers that are not finite, and indices out of range.
    """

    vertices: Array
    faces: Array
    vertex_normals: Array
    uv: Array | None = None
    name: str = ""

    def __post_init__(self) -> None:
        vertices = finite_array(self.vertices, "mesh.vertices", ("n", 3), SceneError)
        count = len(vertices)
        normals = finite_array(self.vertex_normals, "mesh.vertex_normals", (count, 3), SceneError)
        uv = None if self.uv is None else finite_array(self.uv, "mesh.uv", (count, 2), SceneError)
        lengths = np.sqrt(np.einsum("ij,ij->i", normals, normals))
        bad = np.abs(lengths - 1) > UNIT_TOLERANCE
        if bad.any():
            i = int(bad.argmax())
            raise SceneError(f"mesh.vertex_normals[{i}] has the length {lengths[i]:g}; normals must be unit vectors.")
        faces = face_indices(self.faces, "mesh.faces", count, SceneError)
        frozen = {"vertices": vertices, "vertex_normals": normals, "uv": uv, "faces": faces}
        for name, array in frozen.items():
            if array is not None:
                array = array.copy()
                array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __repr__(self) -> str:
        return f"<TriangleMesh{f' {self.name}' if self.name else ''} of {len(self.faces)} triangles>"

    @cached_property
    def volume(self) -> float:
        """Volume of a closed mesh: positive if normals point outward."""
        return float(face_volumes(self.vertices, self.faces).sum())

    def weld(self) -> TriangleMesh:
        """Merge vertices at one position, without texture; normals are means, so that sharp edges become smooth."""
        positions, index = np.unique(self.vertices + 0.0, axis=0, return_inverse=True)  # -0 and 0 are one
        index = index.ravel()
        total = np.stack([np.bincount(index, self.vertex_normals[:, i], len(positions)) for i in range(3)], 1)
        lengths = np.linalg.norm(total, axis=1, keepdims=True)
        one = np.zeros_like(total)
        one[index] = self.vertex_normals
        cancelled = lengths[:, 0] < UNIT_TOLERANCE
        normals = np.where(cancelled[:, None], one, total / np.where(cancelled[:, None], 1.0, lengths))
        return TriangleMesh(positions, index[self.faces], normals, None, self.name)

    def transformed(self, scale: float = 1.0, shift: Any = 0.0) -> TriangleMesh:
        """Scale the mesh about the origin, then translate it."""
        translation = values.finite(shift, "shift")
        if translation.shape not in ((), (3,)):
            raise SceneError(f"shift has shape {translation.shape}; 3 numbers are needed.")
        return replace(self, vertices=self.vertices * values.positive(scale, "scale") + translation)

    welded = renamed_attribute("weld")
    moved = renamed_attribute("transformed")

    def save(self, path: str | os.PathLike[str], *, scale: float = 1.0) -> None:
        """Write an .obj, .ply, .stl or .glb file atomically, with `trimesh` (extra ``mesh``).

        Parameters
        ----------
        path : path
            Normals and texture coordinates are written where the format has them; .stl has neither. All formats but
            .obj hold single precision; a .glb far from the origin holds positions relative to its center.
        scale : float
            Factor on the positions: 0.001 for a scene in millimeters, because readers of .glb expect meters.

        Raises
        ------
        MissingExtraError
            If `trimesh` is not installed.
        InputError
            For another suffix, a scale that is not positive, or a file that cannot be written: an existing one stays
            as it was.
        """
        save_meshes(path, [(self, None)], scale=scale)


def face_volumes(vertices: Array, faces: Array) -> Array:
    """Volume of the tetrahedron of each triangle and a vertex of the mesh.

    The sum is the volume of a closed mesh, positive if faces are counter-clockwise seen from outside.
    """
    if not len(faces):
        return np.zeros(0)
    local = vertices - vertices[faces[0, 0]]
    a, b, c = (local[faces[:, i]] for i in range(3))
    return np.asarray(np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)


# -- files -----------------------------------------------------------------------------------------------------

#: Meshes with their linear base colors.
ColoredMeshes = Sequence[tuple[TriangleMesh, Any]]


def save_meshes(path: str | os.PathLike[str], meshes: ColoredMeshes, *, scale: float = 1.0) -> None:
    """Write meshes into one file: a .glb has a node with name and color for each, other formats merge them."""
    file = output_path(path, *CONTENT)
    ending = file.suffix.lower()
    factor = values.positive(scale, "scale")
    trimesh = import_trimesh("Writing meshes")
    scaled = [(mesh if factor == 1 else mesh.transformed(factor), color) for mesh, color in meshes]
    if not any(len(mesh.faces) for mesh, _ in scaled):
        raise SceneError("there are no triangles to write.")
    with deferred_interrupts():
        data = _glb(trimesh, scaled) if ending == ".glb" else _single(trimesh, ending, [mesh for mesh, _ in scaled])
    write_file(file, data)


def _single(trimesh: Any, ending: str, meshes: Sequence[TriangleMesh]) -> bytes | str:
    mesh = _concatenate(meshes)
    converted = _trimesh(trimesh, mesh)
    if ending == ".stl":
        return bytes(converted.export(file_type="stl"))
    if ending == ".ply":
        return bytes(converted.export(file_type="ply", vertex_normal=True))
    largest = float(np.abs(mesh.vertices).max(initial=0.0))
    digits = DIGITS - (math.floor(math.log10(largest)) if largest > 0 else 0)
    text = str(converted.export(file_type="obj", include_normals=True, digits=max(digits, DIGITS), header=None))
    material = ("mtllib", "usemtl")  # trimesh refers to a file that is not written
    return "\n".join(line for line in text.splitlines() if not line.startswith(material)) + "\n"


def _glb(trimesh: Any, meshes: ColoredMeshes) -> bytes:
    scene = trimesh.Scene()
    for i, (mesh, color) in enumerate(meshes):
        if not len(mesh.faces):
            continue
        low, high = mesh.vertices.min(0), mesh.vertices.max(0)
        middle = (low + high) / 2
        is_far = np.abs(middle).max() > FAR * (high - low).max()
        local = mesh.transformed(1.0, -middle) if is_far else mesh
        transform = np.eye(4)
        if is_far:
            transform[:3, 3] = middle
        name = mesh.name or f"surface {i}"
        scene.add_geometry(_trimesh(trimesh, local, color), node_name=name, geom_name=name, transform=transform)
    return bytes(scene.export(file_type="glb", include_normals=True))


def _trimesh(trimesh: Any, mesh: TriangleMesh, color: Any = None) -> Any:
    visual = None
    if color is not None or mesh.uv is not None:
        rgba = [*np.clip((0.8, 0.8, 0.8) if color is None else color, 0.0, 1.0), 1.0]
        material = trimesh.visual.material.PBRMaterial(
            name=mesh.name, baseColorFactor=rgba, metallicFactor=0.0, roughnessFactor=ROUGHNESS, doubleSided=True
        )
        uv = np.zeros((len(mesh.vertices), 2)) if mesh.uv is None else np.array(mesh.uv)
        visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return trimesh.Trimesh(
        np.array(mesh.vertices),
        np.array(mesh.faces),
        vertex_normals=np.array(mesh.vertex_normals),
        visual=visual,
        process=False,
    )


def _concatenate(meshes: Sequence[TriangleMesh]) -> TriangleMesh:
    """Concatenate meshes; those without texture coordinates get zeros where others have some."""
    if len(meshes) == 1:
        return meshes[0]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    uv = None
    if any(mesh.uv is not None for mesh in meshes):
        uv = np.concatenate([np.zeros((len(m.vertices), 2)) if m.uv is None else m.uv for m in meshes])
    return TriangleMesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]),
        np.concatenate([mesh.vertex_normals for mesh in meshes]),
        uv,
    )
