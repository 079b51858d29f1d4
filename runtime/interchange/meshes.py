"""Triangle meshes from files, and the lines that their edges lie on.

Files are read by the package `trimesh` (the extra `mesh`), as they are: nothing is merged, closed or turned.
"""

from __future__ import annotations

import io
import logging
import os
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError, MissingExtraError
from ..codegen.interrupts import deferred_interrupts
from ..common.files import as_path
from ..common.validation import as_array, check_shape, finite_array
from ..core.multivector import Multivector
from ..core.registry import stock_algebra

Array = NDArray[Any]
#: Formats that are read, by the end of the name.
FORMATS = (".obj", ".ply", ".stl", ".glb")
#: Edges and triangles smaller than this many rounding units of the mesh's coordinates have no direction.
NOISE = 64
_log = logging.getLogger("bladesmith")


@dataclass(frozen=True)
class Mesh:
    """Triangles in space. Corners at one position are one vertex: formats like STL repeat them.

    Attributes
    ----------
    vertices : array (v, 3)
        Positions, float64.
    faces : integer array (f, 3)
        Corners of the triangles, as places in ``vertices``. Triangles without an area are left out.
    name : str
    dropped_faces : int
        How many were left out.

    Raises
    ------
    InputError, ShapeError
        If the vertices are no finite numbers, or a face names one that is not there.

    Notes
    -----
    ``bs.cga3d.point(mesh.vertices)`` are its points.
    """

    vertices: Array
    faces: Array
    name: str = ""
    dropped_faces: int = field(default=0, compare=False)

    def __post_init__(self) -> None:
        vertices = finite_array(self.vertices, "vertices", ("n", 3))
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", face_indices(self.faces, "faces", len(vertices)))

    @cached_property
    def edges(self) -> Array:
        """End points of the edges (n, 2, 3), each edge once, in the order of their vertices."""
        return np.asarray(self.vertices[self.edge_vertices])

    @cached_property
    def edge_vertices(self) -> Array:
        """The edges (n, 2) as places in ``vertices``, the lower first."""
        return self._edges[0]

    @cached_property
    def edge_angles(self) -> Array:
        """Angle between the two faces at each edge (n,), 0 where they continue each other; infinite at borders.

        Where three faces or more meet, the greatest between two of them that follow each other in the file.
        Orientations of faces do not matter: angles are measured between planes bent at the edge.
        """
        pairs, edge_of = self._edges
        vertices = _of_size_one(self.vertices)
        a, b, c = (vertices[self.faces[:, i]] for i in range(3))
        order = np.argsort(edge_of, kind="stable")
        first, second = order[:-1], order[1:]
        joined = edge_of[first] == edge_of[second]
        first, second = first[joined], second[joined]
        angles = np.full(len(pairs), -np.inf)
        corners = np.stack([c, a, b], 1).reshape(-1, 3)  # of each side of each triangle the corner opposite
        edge = edge_of[first]
        start, along = vertices[pairs[edge, 0]], vertices[pairs[edge, 1]] - vertices[pairs[edge, 0]]
        left, right = (_across(corners[side] - start, along) for side in (first, second))
        bend = np.arctan2(np.linalg.norm(np.cross(left, right), axis=1), -np.einsum("ij,ij->i", left, right))
        np.maximum.at(angles, edge, bend)
        return np.where(np.isneginf(angles), np.inf, angles)

    @cached_property
    def _edges(self) -> tuple[Array, Array]:
        """Edges by vertices, and for each side of each triangle (3 f) its edge."""
        sides = np.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        pairs, edge_of = np.unique(sides, axis=0, return_inverse=True)
        return pairs, edge_of.ravel()


def face_indices(value: Any, name: str, count: int, error: type[InputError] = InputError) -> Array:
    """Corners of triangles (m, 3) as indices of ``count`` vertices.

    Raises
    ------
    InputError, ShapeError
        Or the class ``error``, with the index of the first invalid face.
    """
    faces = as_array(value, name, error)
    if faces.dtype.kind not in "iu" or isinstance(value, np.ma.MaskedArray):
        raise error(f"{name} holds {faces.dtype}; whole numbers, the indices of vertices, are needed.")
    check_shape(faces, name, ("m", 3), error, "Split polygons into triangles")
    bad = ((faces < 0) | (faces >= count)).any(1)
    if bad.any():
        i = int(bad.argmax())
        raise error(f"{name}[{i}] is {faces[i].tolist()}; indices of {count} vertices run from 0.")
    return faces.astype(np.int64)


def _of_size_one(vertices: Array) -> Array:
    """Scale positions to a unit in which squares of coordinates neither overflow nor vanish."""
    size = np.abs(vertices).max(initial=0.0)
    return np.asarray(vertices / size) if size > 0 else vertices


def _across(v: Array, along: Array) -> Array:
    """Component of v perpendicular to a direction; v itself if the direction is zero."""
    square = np.einsum("ij,ij->i", along, along)
    part = np.einsum("ij,ij->i", v, along) / np.where(square > 0, square, 1.0)
    return np.asarray(v - part[:, None] * along)


def load_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read a mesh from an .obj, .ply, .stl or .glb file.

    Raises
    ------
    MissingExtraError
        If `trimesh` is not installed.
    InputError
        If there is no such file, it is of another format or damaged, or holds no triangles.
    """
    file = _file(path)
    vertices, faces, _ = _read(file)
    return _with_area(*_merge_positions(vertices, faces), file)


def load_with_normals(path: str | os.PathLike[str]) -> tuple[Mesh, Array]:
    """Read a mesh and unit normals at its vertices (v, 3).

    They are the file's own, of vertices as the file has them. Of a file without normals they are the means of the
    triangles around each position, weighted with their angles there.

    Raises
    ------
    MissingExtraError, InputError
        As `load_mesh`, and for a normal of length zero.
    """
    file = _file(path)
    vertices, faces, normals = _read(file)
    if normals is None:
        mesh = _with_area(*_merge_positions(vertices, faces), file)
        return mesh, vertex_normals(mesh)
    lengths = np.linalg.norm(normals, axis=1)
    bad = ~(np.isfinite(lengths) & (lengths > 0))
    if bad[faces].any():
        raise InputError(f"the normal of vertex {int(bad.argmax())} is zero or no number.", where=str(file))
    return _with_area(vertices, faces, file), np.asarray(normals / np.where(bad, 1.0, lengths)[:, None])


def vertex_normals(mesh: Mesh) -> Array:
    """Unit normals at vertices (v, 3): the means of the triangles around each, weighted with their angles there.

    Where the triangles around cancel, as of a sheet with two sides, one of theirs. Zero at vertices without a triangle.
    """
    corners = _of_size_one(mesh.vertices)[mesh.faces]
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    across = np.cross(ahead, behind)
    sine, cosine = np.linalg.norm(across, axis=-1), np.einsum("fci,fci->fc", ahead, behind)
    units = across / np.where(sine > 0, sine, 1.0)[..., None]
    weighted = np.arctan2(sine, cosine)[..., None] * units
    flat = mesh.faces.reshape(-1)
    normals = np.zeros_like(mesh.vertices)
    normals[mesh.faces] = units
    total = np.stack([np.bincount(flat, weighted[..., i].reshape(-1), len(mesh.vertices)) for i in range(3)], 1)
    lengths = np.linalg.norm(total, axis=1)
    there = lengths > np.finfo(float).eps * NOISE
    normals[there] = total[there] / lengths[there, None]
    return normals


def _file(path: str | os.PathLike[str]) -> Path:
    """The file, if there is one of a format that is read."""
    file = as_path(path, "a mesh is read from")
    if file.suffix.lower() not in FORMATS:
        raise InputError(f"a mesh is read from {', '.join(FORMATS)}, not {file.suffix or 'a name without an ending'}.",
                         where=str(file))  # fmt: skip
    try:
        if file.is_file():
            return file
    except OSError as error:  # a name that the system does not take
        raise InputError(f"there is no such file ({error.strerror})", where=str(file)) from None
    raise InputError("there is no such file", where=str(file))


def import_trimesh(use: str) -> Any:
    """The package `trimesh`.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        with deferred_interrupts():
            return import_module("trimesh")
    except ImportError:
        raise MissingExtraError("mesh", use) from None


def _read(file: Path) -> tuple[Array, Array, Array | None]:
    """Vertices, faces and, where the file has them, normals of vertices."""
    trimesh = import_trimesh("Reading meshes")
    try:
        content = file.read_bytes()
        if file.suffix.lower() == ".obj":  # text, in which names and comments may be of any encoding: numbers are not
            content = content.decode("utf-8-sig", "replace").encode()
        kind = file.suffix.lower().removeprefix(".")
        with deferred_interrupts():
            loaded = trimesh.load(io.BytesIO(content), file_type=kind, process=False, skip_materials=True)
            vertices, faces, normals = _scene_arrays(loaded)
    except ImportError:  # of a package that guesses encodings
        raise InputError("the file cannot be read as a mesh (it is neither binary nor text)", where=str(file)) from None
    except Exception as error:  # readers of damaged files raise anything
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"the file cannot be read as a mesh ({reason})", where=str(file)) from None
    if not len(faces):
        raise InputError("the file holds no triangles; a cloud of points has no edges.", where=str(file))
    try:
        Mesh(vertices, faces)
    except InputError as error:
        raise InputError(error.what, where=str(file)) from None
    return vertices, faces, normals


def _scene_arrays(loaded: Any) -> tuple[Array, Array, Array | None]:
    """Arrays of what `trimesh` read, each part of a scene where it stands; normals if all parts have them."""
    parts = [(np.eye(4), loaded)]
    if hasattr(loaded, "graph"):
        placed = (loaded.graph[node] for node in loaded.graph.nodes_geometry)
        parts = [(np.asarray(transform, np.float64), loaded.geometry[name]) for transform, name in placed]
    parts = [(transform, part) for transform, part in parts if len(getattr(part, "faces", ()))]
    if not parts:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64), None
    starts = np.cumsum([0, *(len(part.vertices) for _, part in parts)])
    vertices = [np.asarray(part.vertices, np.float64) @ m[:3, :3].T + m[:3, 3] for m, part in parts]
    faces = [np.asarray(part.faces, np.int64) + start for (_, part), start in zip(parts, starts, strict=False)]
    if not all("vertex_normals" in part._cache for _, part in parts):  # else trimesh would make some up
        return np.concatenate(vertices), np.concatenate(faces), None
    normals = [np.asarray(part.vertex_normals, np.float64) @ np.linalg.inv(m[:3, :3]) for m, part in parts]
    return np.concatenate(vertices), np.concatenate(faces), np.concatenate(normals)


def _merge_positions(vertices: Array, faces: Array) -> tuple[Array, Array]:
    """Positions once each, in ascending order."""
    positions, place = np.unique(vertices + 0.0, axis=0, return_inverse=True)  # -0 and 0 are one
    return positions, place.ravel()[faces]


def _with_area(positions: Array, corners: Array, file: Path) -> Mesh:
    """The mesh without the triangles that have no area."""
    scaled = _of_size_one(positions)
    a, b, c = (scaled[corners[:, i]] for i in range(3))
    double_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max([np.linalg.norm(u - v, axis=1) for u, v in ((a, b), (b, c), (c, a))], axis=0)
    good = double_area > np.finfo(float).eps * NOISE * longest
    dropped = int(np.count_nonzero(~good))
    if dropped == len(corners):
        raise InputError("all triangles of the file are without an area.", where=str(file))
    if dropped:
        _log.warning("%s: %d of %d triangles have no area and are left out.", file, dropped, len(corners))
    return Mesh(positions, corners[good], file.stem, dropped)


def mesh_lines(mesh: Mesh | str | os.PathLike[str], sharp: float | None = None) -> tuple[Multivector, Array]:
    """The lines that the edges of a mesh lie on.

    Parameters
    ----------
    mesh : Mesh or path
    sharp : float, optional
        Keep only edges whose two faces meet at more than this angle in radians (0: flat), and borders.

    Returns
    -------
    lines : Multivector, shape (n,)
        Unit lines of `bladesmith.cga3d`, from the first end to the second.
    segments : array (n, 2, 3)
        The ends.

    Raises
    ------
    InputError
        If ``sharp`` is no angle, and as `load_mesh`.

    Examples
    --------
    >>> lines, segments = mesh_lines("examples/meshes/airplane.ply", sharp=0.5)  # doctest: +SKIP
    >>> points = bs.cga3d.point(load_mesh("examples/meshes/airplane.ply").vertices)  # doctest: +SKIP
    """
    if not isinstance(mesh, Mesh):
        mesh = load_mesh(mesh)
    segments = mesh.edges
    if sharp is not None:
        try:
            good = 0 <= float(sharp) <= np.pi
        except (TypeError, ValueError, OverflowError):
            good = False
        if not good:
            raise InputError(f"sharp is {sharp!r}; an angle from 0 to pi is needed, in radians.")
        segments = segments[mesh.edge_angles > sharp]
    cga: Any = stock_algebra("cga3d")
    return cga.line_through(segments[:, 0], segments[:, 1]), segments
