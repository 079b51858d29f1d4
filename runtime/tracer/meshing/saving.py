"""Meshes into files, written by the package `trimesh` (the extra `mesh`), each in one step."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, MissingExtraError, SceneError
from ...files import write_atomically
from ...interrupts import kept
from .. import values
from .triangles import TriangleMesh

Array = NDArray[Any]
FORMATS = (".obj", ".ply", ".stl", ".glb")
#: Significant digits of numbers in text.
DIGITS = 16
#: A .glb holds single precision: positions this many extents away are written relative to their middle.
FAR = 64.0
#: How rough a plain material looks in other programs.
ROUGHNESS = 0.5
#: Meshes with their linear base colors.
Colored = Sequence[tuple[TriangleMesh, Any]]


def save_meshes(path: str | os.PathLike[str], meshes: Colored, *, scale: float = 1.0) -> None:
    """Write meshes into one file: of a .glb each is a node with its name and color, of others they are one."""
    file, ending = check_format(path)
    factor = values.positive(scale, "scale")
    try:
        with kept():
            trimesh = import_module("trimesh")
    except ImportError:
        raise MissingExtraError("mesh", "Writing meshes") from None
    scaled = [(mesh if factor == 1 else mesh.moved(factor), color) for mesh, color in meshes]
    if not any(len(mesh.faces) for mesh, _ in scaled):
        raise SceneError("there are no triangles to write.")
    with kept():
        data = _glb(trimesh, scaled) if ending == ".glb" else _single(trimesh, ending, [mesh for mesh, _ in scaled])
    write_atomically(file, data)


def check_format(path: str | os.PathLike[str]) -> tuple[Path, str]:
    """The file, and the ending of its name, which must be one that is written."""
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise InputError(f"a mesh is written to a file, and {values.shown(path)} names none.") from None
    ending = file.suffix.lower()
    if ending not in FORMATS:
        known = ", ".join(FORMATS)
        raise InputError(f"a mesh is written as {known}, not {ending or 'a name without an ending'}.", where=str(file))
    return file, ending


def _single(trimesh: Any, ending: str, meshes: Sequence[TriangleMesh]) -> bytes | str:
    mesh = joined(meshes)
    written = _trimesh(trimesh, mesh)
    if ending == ".stl":
        return bytes(written.export(file_type="stl"))
    if ending == ".ply":
        return bytes(written.export(file_type="ply", vertex_normal=True))
    largest = float(np.abs(mesh.vertices).max(initial=0.0))
    digits = DIGITS - (math.floor(math.log10(largest)) if largest > 0 else 0)
    text = str(written.export(file_type="obj", include_normals=True, digits=max(digits, DIGITS), header=None))
    material = ("mtllib", "usemtl")  # which trimesh names, and which is not written
    return "\n".join(line for line in text.splitlines() if not line.startswith(material)) + "\n"


def _glb(trimesh: Any, meshes: Colored) -> bytes:
    scene = trimesh.Scene()
    for i, (mesh, color) in enumerate(meshes):
        if not len(mesh.faces):
            continue
        low, high = mesh.vertices.min(0), mesh.vertices.max(0)
        middle = (low + high) / 2
        is_far = np.abs(middle).max() > FAR * (high - low).max()
        placed = mesh.moved(1.0, -middle) if is_far else mesh
        transform = np.eye(4)
        if is_far:
            transform[:3, 3] = middle
        name = mesh.name or f"surface {i}"
        scene.add_geometry(_trimesh(trimesh, placed, color), node_name=name, geom_name=name, transform=transform)
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


def joined(meshes: Sequence[TriangleMesh]) -> TriangleMesh:
    """Several meshes as one; those without texture coordinates get zeros where others have some."""
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


__all__ = ["check_format", "joined", "save_meshes"]
