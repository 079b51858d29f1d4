"""Models of meshes: planes of their faces, lines of their sharp edges (thesis 5.1: models from drawings)."""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError, MissingExtraError
from ...common.deprecation import renamed_keywords
from ...common.validation import as_bool, as_float
from ...interchange.meshes import Mesh, load_mesh
from ..model.duplicates import features, first_equal_rows
from ..model.model import Model
from ..model.parameters import Rows
from .region_growing import Pieces, Regions, grow_regions

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Default of the largest angle between faces of one plane, and edges of one line: 10 degrees.
ANGLE = float(np.radians(10))
#: Default of the largest distance of a corner from its plane or line, in sizes of the mesh.
TOLERANCE = 1e-3
#: Default of the smallest length of a line, and side of a plane, in sizes of the mesh.
LEAST = 0.02
#: At a vertex of more sharp edges than this only neighbors in the file are tried as continuations of each other.
MAX_AT_VERTEX = 16


@renamed_keywords(least="min_size")
def model_from_mesh(
    mesh: Mesh | str | os.PathLike[str],
    planes: bool = True,
    lines: bool = True,
    angle: float = ANGLE,
    min_size: float = LEAST,
    tolerance: float = TOLERANCE,
    *,
    unit: str = "",
    origin: str = "",
) -> Model:
    """Extract the planes and lines of a triangle mesh.

    Adjacent faces at angles of at most ``angle`` are merged into planes; edges between faces at larger angles, and
    borders, are merged into lines where they continue each other.

    Parameters
    ----------
    mesh : Mesh or path
        A file .obj, .ply, .stl or .glb, or a `bladesmith.interchange.meshes.Mesh`.
    planes, lines : bool
        Kinds of objects to extract.
    angle : float
        Largest angle of a face to its plane and of an edge to its line, in radians; edges are sharp above it.
    min_size : float
        Smallest length of a line, and side of a square of the area of a plane, in sizes of the mesh: its largest extent
        along an axis. 0: no limit.
    tolerance : float
        Largest distance of a corner from its plane or line, in sizes of the mesh. Parallel planes, or lines, that are
        nearer to each other are merged, also those of faces that do not touch.
    unit, origin : str
        Unit and origin of the model.

    Returns
    -------
    Model
        Planes and lines, largest first. A plane's normal is that of most of its area; a line's direction is arbitrary.

    Raises
    ------
    MissingExtraError
        If `trimesh` is not installed.
    InputError
        If the mesh cannot be read, an option is out of its range, or no plane or line is large enough.

    Notes
    -----
    The planes of a curved surface are those of its facets, or of patches within ``angle``: they depend on the mesh more
    than on the surface.
    """
    if not isinstance(mesh, Mesh):
        mesh = load_mesh(mesh)
    angle, min_size = as_float(angle, "angle", 0, np.pi / 2), as_float(min_size, "min_size", 0, 1.0)
    tolerance = as_float(tolerance, "tolerance", 0, 1.0)
    if not len(mesh.faces):
        raise InputError("the mesh has no faces.", where=mesh.name or None)
    low, high = mesh.vertices[mesh.faces].min((0, 1)), mesh.vertices[mesh.faces].max((0, 1))
    center, size = (low + high) / 2, float((high - low).max())
    if not size > 0:
        raise InputError("all faces of the mesh are at one point.", where=mesh.name or None)
    inside = Mesh((mesh.vertices - center) / size, mesh.faces)  # of size one: squares neither vanish nor overflow
    parts: dict[str, Any] = {}
    if as_bool(planes, "planes"):
        parts["planes"] = _planes(inside, angle, min_size, tolerance)
    if as_bool(lines, "lines"):
        parts["lines"] = _lines(inside, angle, min_size, tolerance).reshape(-1, 2, 3)
    model = Model(**parts, name=mesh.name, unit=unit, origin=origin)
    if not len(model):
        raise InputError("the mesh has no plane or line of that size.", where=mesh.name or None,
                         remedy=f"Take a smaller min_size than {min_size:g}")  # fmt: skip
    return model.in_frame(-center / size, 1 / size)


def _planes(mesh: Mesh, angle: float, min_size: float, tolerance: float) -> Rows:
    """Normals and offsets (n, 4), by area."""
    graph = _trimesh().graph
    corners = mesh.vertices[mesh.faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    solid = np.linalg.norm(area, axis=1) > 0
    place = np.cumsum(solid) - 1
    pairs = np.asarray(graph.face_adjacency(mesh.faces), np.int64).reshape(-1, 2)
    pairs = place[pairs[solid[pairs].all(1)]]
    faces = Pieces(area[solid], corners[solid].mean(1), corners[solid], are_normals=True)
    regions = grow_regions(faces, pairs, angle, tolerance)
    offsets = (regions.directions * regions.centers).sum(1)
    return _largest(np.column_stack([regions.directions, offsets]), "plane", regions, min_size * min_size, tolerance)


def _lines(mesh: Mesh, angle: float, min_size: float, tolerance: float) -> Rows:
    """Points and directions (n, 6), by length."""
    ends = mesh.edge_vertices[mesh.edge_angles > angle]
    ends = ends[(mesh.vertices[ends[:, 0]] != mesh.vertices[ends[:, 1]]).any(1)]
    corners = mesh.vertices[ends]
    edges = Pieces(corners[:, 1] - corners[:, 0], corners.mean(1), corners, are_normals=False)
    regions = grow_regions(edges, _continuation_pairs(ends, edges.vectors, angle), angle, tolerance)
    return _largest(np.column_stack([regions.centers, regions.directions]), "line", regions, min_size, tolerance)


def _continuation_pairs(ends: Indices, along: Array, angle: float) -> Indices:
    """Pairs of edges (n, 2) that share a vertex and continue each other within twice the angle."""
    edge = np.repeat(np.arange(len(ends)), 2)
    order = np.argsort(ends.ravel(), kind="stable")
    vertex, edge = ends.ravel()[order], edge[order]
    pairs = []
    for step in range(1, min(MAX_AT_VERTEX, len(edge))):
        beside = vertex[step:] == vertex[:-step]
        if not beside.any():
            break
        pairs.append(np.column_stack([edge[:-step][beside], edge[step:][beside]]))
    if not pairs:
        return np.zeros((0, 2), np.int64)
    candidates = np.concatenate(pairs)
    a, b = along[candidates[:, 0]], along[candidates[:, 1]]
    bend = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.abs((a * b).sum(1)))
    return np.asarray(candidates[bend <= 2 * angle])


def _largest(rows: Rows, kind: str, regions: Regions, min_size: float, tolerance: float) -> Rows:
    """Rows of regions of at least some size, without duplicates, largest first."""
    order = np.argsort(-regions.weights, kind="stable")
    rows, weights = rows[order], regions.weights[order]
    first = first_equal_rows(features(rows, kind, np.zeros(3), 1.0), tolerance)
    total = np.bincount(first, weights, minlength=len(rows))
    kept = np.flatnonzero((first == np.arange(len(rows))) & (total >= min_size))
    return rows[kept[np.argsort(-total[kept], kind="stable")]]


def _trimesh() -> Any:
    try:
        import_module("trimesh.graph")
        return import_module("trimesh")
    except ImportError:
        raise MissingExtraError("mesh", "Models of meshes") from None
