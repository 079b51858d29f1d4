"""Meshes of all surfaces of a scene, with names and colors, for files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, SceneError
from ..scene import values
from . import mesh_of
from .triangle_mesh import TriangleMesh

Array = NDArray[Any]
#: Side of the squares for planes, in sizes of all other surfaces.
PLANE_FACTOR = 2.0
#: Side of the squares for planes without other surfaces.
PLANE_SIDE = 10.0


def scene_meshes(
    scene: Any,
    numbers: Sequence[int] | None = None,
    rings: int = 64,
    segments: int = 64,
    *,
    caps: bool = False,
    extent: float | None = None,
) -> list[tuple[TriangleMesh, Array]]:
    """Triangulate a scene's surfaces; return meshes with colors, named by index and by name or kind.

    Parameters
    ----------
    scene : Scene
    numbers : sequence of int, optional
        Indices of surfaces; default: all.
    rings, segments, caps
        As for `mesh_of`.
    extent : float, optional
        Side of the squares that represent planes; default: twice the size of the other surfaces, centered on them.

    Raises
    ------
    InputError
        For an index out of range. Errors of `mesh_of` get the surface's index.
    """
    indices = range(len(scene.surfaces)) if numbers is None else list(dict.fromkeys(numbers))
    for i in indices:
        if not 0 <= i < len(scene.surfaces):
            raise InputError(f"there is no surface {i}; the scene has {len(scene.surfaces)}, from 0.")
    if not len(indices):
        raise InputError("the scene has no surfaces.")
    if extent is not None:
        extent = values.positive(extent, "extent")
    meshes: dict[int, TriangleMesh] = {}
    planes = [i for i in indices if scene.surfaces[i].kind == "plane"]
    for i in indices:
        if i not in planes:
            meshes[i] = _mesh_surface(scene, i, rings, segments, caps=caps)
    side, middle = _around(list(meshes.values()))
    for i in planes:
        meshes[i] = _mesh_surface(scene, i, extent=side if extent is None else extent, center=middle)
    return [(meshes[i], scene.surfaces[i].material.color) for i in indices]


def _mesh_surface(scene: Any, i: int, *counts: int, **options: Any) -> TriangleMesh:
    surface = scene.surfaces[i]
    try:
        mesh = mesh_of(surface, *counts, **options)
    except SceneError as error:
        if error.what.startswith("surfaces["):  # a surface checked alone has the index 0
            what = error.what.replace("surfaces[0]", f"surfaces[{i}]", 1)
            raise SceneError(what, where=error.where, remedy=error.remedy) from None
        raise SceneError(f"surfaces[{i}]: {error.what}", where=error.where, remedy=error.remedy) from None
    return replace(mesh, name=f"{i} {surface.name or surface.kind.replace('_', ' ')}")


def _around(meshes: Sequence[TriangleMesh]) -> tuple[float, Array]:
    """Side and center of the squares for planes."""
    points = [mesh.vertices for mesh in meshes if len(mesh.vertices)]
    if not points:
        return PLANE_SIDE, np.zeros(3)
    low, high = np.min([p.min(0) for p in points], 0), np.max([p.max(0) for p in points], 0)
    return PLANE_FACTOR * float((high - low).max()), (low + high) / 2
