"""All surfaces of a scene as meshes with names and colors, as pages and files show them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, SceneError
from .. import values
from . import mesh_of
from .triangles import TriangleMesh

Array = NDArray[Any]
#: Side of the squares for planes, in sizes of everything else; without anything else, in units.
PLANE_SHARE, PLANE_ALONE = 2.0, 10.0


def scene_meshes(
    scene: Any,
    numbers: Sequence[int] | None = None,
    rings: int = 64,
    segments: int = 64,
    *,
    caps: bool = False,
    extent: float | None = None,
) -> list[tuple[TriangleMesh, Array]]:
    """Meshes of a scene's surfaces with their colors, named by number and by name or kind.

    Parameters
    ----------
    scene : Scene
    numbers : sequence of int, optional
        Which surfaces; default: all.
    rings, segments, caps
        As for `mesh_of`.
    extent : float, optional
        Side of the squares that stand for planes; without, twice the size of the other surfaces, under them.

    Raises
    ------
    InputError
        For the number of a surface that there is not, and what `mesh_of` raises, with the surface's number.
    """
    chosen = range(len(scene.surfaces)) if numbers is None else list(dict.fromkeys(numbers))
    for i in chosen:
        if not 0 <= i < len(scene.surfaces):
            raise InputError(f"there is no surface {i}; the scene has {len(scene.surfaces)}, from 0.")
    if not len(chosen):
        raise InputError("the scene has no surfaces.")
    if extent is not None:
        extent = values.positive(extent, "extent")
    found: dict[int, TriangleMesh] = {}
    planes = [i for i in chosen if scene.surfaces[i].kind == "plane"]
    for i in chosen:
        if i not in planes:
            found[i] = _made(scene, i, rings, segments, caps=caps)
    side, middle = _around(list(found.values()))
    for i in planes:
        found[i] = _made(scene, i, extent=side if extent is None else extent, center=middle)
    return [(found[i], scene.surfaces[i].material.color) for i in chosen]


def _made(scene: Any, i: int, *counts: int, **options: Any) -> TriangleMesh:
    surface = scene.surfaces[i]
    try:
        mesh = mesh_of(surface, *counts, **options)
    except SceneError as error:
        if error.what.startswith("surfaces["):  # the check of a surface on its own calls it the first
            what = error.what.replace("surfaces[0]", f"surfaces[{i}]", 1)
            raise SceneError(what, where=error.where, remedy=error.remedy) from None
        raise SceneError(f"surfaces[{i}]: {error.what}", where=error.where, remedy=error.remedy) from None
    return replace(mesh, name=f"{i} {surface.name or surface.kind.replace('_', ' ')}")


def _around(meshes: Sequence[TriangleMesh]) -> tuple[float, Array]:
    """Side and middle of what planes are to lie under."""
    points = [mesh.vertices for mesh in meshes if len(mesh.vertices)]
    if not points:
        return PLANE_ALONE, np.zeros(3)
    low, high = np.min([p.min(0) for p in points], 0), np.max([p.max(0) for p in points], 0)
    return PLANE_SHARE * float((high - low).max()), (low + high) / 2


__all__ = ["scene_meshes"]
