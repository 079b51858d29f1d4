"""Models of meshes: planes that faces lie on, lines that sharp edges lie on (thesis 5.1: models from drawings)."""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..codegen.errors import InputError, MissingExtraError
from ..interchange.meshes import Mesh, load_mesh
from ..objects.inputs import number
from .model import Model
from .parameters import Rows
from .regions import Pieces, Regions, gathered
from .repeats import features, same

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Faces and edges that bend by at most this are one plane, one line: 10 degrees.
ANGLE = float(np.radians(10))
#: Corners are this near to their plane or line, and smaller planes and shorter lines left out; in sizes of the mesh.
TOLERANCE, LEAST = 1e-3, 0.02
#: At a vertex of more sharp edges than this only neighbours in the file are tried as continuations of each other.
MOST_AT_VERTEX = 16


def model_from_mesh(
    mesh: Mesh | str | os.PathLike[str],
    planes: bool = True,
    lines: bool = True,
    angle: float = ANGLE,
    least: float = LEAST,
    tolerance: float = TOLERANCE,
    *,
    unit: str = "",
    origin: str = "",
) -> Model:
    """The planes and lines of a mesh of triangles.

    Adjacent faces that bend by at most ``angle`` are gathered into planes; edges where faces meet at more than that,
    and borders, are merged into lines where they continue each other.

    Parameters
    ----------
    mesh : Mesh or path
        A file .obj, .ply, .stl or .glb, or a `bladesmith.interchange.meshes.Mesh`.
    planes, lines : bool
        What is wanted.
    angle : float
        Radians: greatest angle of a face to its plane and of an edge to its line; sharp edges bend by more.
    least : float
        Lines are at least this long, planes at least as large as a square of this side, in sizes of the mesh: its
        largest extent along an axis. 0: all.
    tolerance : float
        Greatest distance of a corner from its plane or line, in sizes of the mesh. Parallel planes, or lines, that
        are nearer than that are one: of faces that do not touch, too.
    unit, origin : str
        Of the model.

    Returns
    -------
    Model
        Largest first. Planes have their normals where most of the area has it, lines run either way.

    Raises
    ------
    MissingExtraError
        If `trimesh` is not installed.
    InputError
        If the mesh cannot be read, an option is no number in its range, or nothing is left.

    Notes
    -----
    Where a surface is curved, planes are those of its facets, or of patches that stay within ``angle``: they say more
    of the mesh than of the surface.
    """
    if not isinstance(mesh, Mesh):
        mesh = load_mesh(mesh)
    angle, least = _between(angle, "angle", np.pi / 2), _between(least, "least", 1.0)
    tolerance = _between(tolerance, "tolerance", 1.0)
    if not len(mesh.faces):
        raise InputError("the mesh has no faces.", where=mesh.name or None)
    low, high = mesh.vertices[mesh.faces].min((0, 1)), mesh.vertices[mesh.faces].max((0, 1))
    center, size = (low + high) / 2, float((high - low).max())
    if not size > 0:
        raise InputError("all faces of the mesh are one point.", where=mesh.name or None)
    inside = Mesh((mesh.vertices - center) / size, mesh.faces)  # of size one: squares neither vanish nor overflow
    found: dict[str, Any] = {}
    if truth(planes, "planes"):
        found["planes"] = _planes(inside, angle, least, tolerance)
    if truth(lines, "lines"):
        found["lines"] = _lines(inside, angle, least, tolerance).reshape(-1, 2, 3)
    model = Model(**found, name=mesh.name, unit=unit, origin=origin)
    if not len(model):
        raise InputError("the mesh has no plane or line of that size.", where=mesh.name or None,
                         remedy=f"Take a smaller least than {least:g}")  # fmt: skip
    return model.in_frame(-center / size, 1 / size)


def _planes(mesh: Mesh, angle: float, least: float, tolerance: float) -> Rows:
    """Normals and offsets (n, 4), by area."""
    graph = _trimesh().graph
    corners = mesh.vertices[mesh.faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    solid = np.linalg.norm(area, axis=1) > 0
    place = np.cumsum(solid) - 1
    pairs = np.asarray(graph.face_adjacency(mesh.faces), np.int64).reshape(-1, 2)
    pairs = place[pairs[solid[pairs].all(1)]]
    faces = Pieces(area[solid], corners[solid].mean(1), corners[solid], across=True)
    regions = gathered(faces, pairs, angle, tolerance)
    offsets = (regions.directions * regions.places).sum(1)
    return _largest(np.column_stack([regions.directions, offsets]), "plane", regions, least * least, tolerance)


def _lines(mesh: Mesh, angle: float, least: float, tolerance: float) -> Rows:
    """Points and directions (n, 6), by length."""
    ends = mesh.edge_vertices[mesh.edge_angles > angle]
    ends = ends[(mesh.vertices[ends[:, 0]] != mesh.vertices[ends[:, 1]]).any(1)]
    corners = mesh.vertices[ends]
    edges = Pieces(corners[:, 1] - corners[:, 0], corners.mean(1), corners, across=False)
    regions = gathered(edges, _continuing(ends, edges.vectors, angle), angle, tolerance)
    return _largest(np.column_stack([regions.places, regions.directions]), "line", regions, least, tolerance)


def _continuing(ends: Indices, along: Array, angle: float) -> Indices:
    """Pairs of edges (n, 2) that share a vertex and go straight on there within twice the angle."""
    edge = np.repeat(np.arange(len(ends)), 2)
    order = np.argsort(ends.ravel(), kind="stable")
    vertex, edge = ends.ravel()[order], edge[order]
    pairs = []
    for step in range(1, min(MOST_AT_VERTEX, len(edge))):
        beside = vertex[step:] == vertex[:-step]
        if not beside.any():
            break
        pairs.append(np.column_stack([edge[:-step][beside], edge[step:][beside]]))
    if not pairs:
        return np.zeros((0, 2), np.int64)
    found = np.concatenate(pairs)
    a, b = along[found[:, 0]], along[found[:, 1]]
    bend = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.abs((a * b).sum(1)))
    return np.asarray(found[bend <= 2 * angle])


def _largest(rows: Rows, kind: str, regions: Regions, least: float, tolerance: float) -> Rows:
    """Rows of regions of some size, the largest of those that are one object, largest first."""
    order = np.argsort(-regions.weights, kind="stable")
    rows, weights = rows[order], regions.weights[order]
    first = same(features(rows, kind, np.zeros(3), 1.0), tolerance)
    total = np.bincount(first, weights, minlength=len(rows))
    kept = np.flatnonzero((first == np.arange(len(rows))) & (total >= least))
    return rows[kept[np.argsort(-total[kept], kind="stable")]]


def _between(value: Any, name: str, most: float) -> float:
    found = number(value, name)
    if not 0 <= found <= most:
        raise InputError(f"{name} is {found:g}; it is from 0 to {most:.4g}.")
    return found


def _trimesh() -> Any:
    try:
        import_module("trimesh.graph")
        return import_module("trimesh")
    except ImportError:
        raise MissingExtraError("mesh", "Models of meshes") from None


__all__ = ["model_from_mesh"]
