"""Mass, center and inertia tensor of the solid inside a closed triangle mesh, of uniform density.

The integrals are sums over tetrahedra by `codegen.formulas.mechanics.inertia.tetrahedron`; here meshes are checked.
"""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..codegen.errors import InputError
from ..common.validation import invalid, positive_float
from ..core.geometry.euclidean import plain
from ..core.registry import stock_algebra
from ..dispatch.formulas import ArrayOperand, evaluate
from ..interchange.meshes import Mesh, load_mesh

Array = NDArray[Any]
#: Rounding units, relative to the cube of the mesh's size, below which a volume is zero.
VOLUME_ROUNDING = 64


class MassProperties(NamedTuple):
    """Mass, center of mass (3,) and inertia tensor (3, 3) about it."""

    mass: float
    center: Array
    tensor: Array


def mass_properties(mesh: Any, density: float | None = None, mass: float | None = None) -> MassProperties:
    """Mass, center of mass and inertia tensor of a solid of uniform density.

    Parameters
    ----------
    mesh : Mesh, path, or pair of arrays (vertices (v, 3), faces (f, 3))
        The surface, closed, its triangles counter-clockwise as seen from outside. Cavities are surfaces whose
        triangles face inwards. Parts that cut through each other are not detected.
    density : float, optional
        Mass per volume; 1 where neither it nor ``mass`` is given.
    mass : float, optional
        Total mass, in place of the density.

    Returns
    -------
    MassProperties
        Named tuple (mass, center (3,), tensor (3, 3)); the tensor is about the center, along the mesh's axes.

    Raises
    ------
    InputError, ShapeError
        If the mesh is open, the orientation of its triangles is inconsistent or inward, or it encloses no volume.
    """
    vertices, faces = _surface(mesh)
    _check_closed(vertices, faces)
    middle = (vertices.min(0) + vertices.max(0)) / 2
    unit = float(np.abs(vertices - middle).max())
    corners = ((vertices - middle) / unit)[faces]
    cga = stock_algebra("cga3d")
    operands = [ArrayOperand(np.ascontiguousarray(corners[:, i]), cga.kind("euclidean"), "a corner") for i in range(3)]
    volume, first, second = (plain(v).sum(0) for v in evaluate(cga, "inertia.tetrahedron", *operands).values)
    volume = float(volume[0])
    _check_volume(volume, unit)
    center, second = first / volume, second.reshape(3, 3)
    spread = second / volume - np.outer(center, center)  # mean of x x^T about the center
    if mass is not None and density is not None:
        raise InputError("density and mass are both given; give one of them.")
    total = positive_float(mass, "the mass") if mass is not None else (
        positive_float(1.0 if density is None else density, "the density") * volume * unit**3
    )  # fmt: skip
    tensor = total * unit**2 * (np.trace(spread) * np.eye(3) - spread)
    return MassProperties(total, middle + unit * center, (tensor + tensor.T) / 2)


def _surface(mesh: Any) -> tuple[Array, Array]:
    """Vertices and faces; corners at one position become one vertex."""
    if isinstance(mesh, (str, os.PathLike)):
        mesh = load_mesh(mesh)
    if not isinstance(mesh, Mesh):
        try:
            vertices, faces = mesh
        except (TypeError, ValueError):
            raise invalid(mesh, "the mesh", "a Mesh, a path or (vertices, faces)") from None
        mesh = Mesh(vertices, faces)
    if not len(mesh.faces):
        raise InputError("the mesh has no triangles.")
    positions, position_of = np.unique(mesh.vertices + 0.0, axis=0, return_inverse=True)
    return positions, position_of.ravel()[mesh.faces]


def _check_closed(vertices: Array, faces: Array) -> None:
    """Check that each side of a triangle is a side of another one in the opposite direction."""
    sides = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    forward = sides[:, 0] < sides[:, 1]
    edges, edge_of = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    edge_of = edge_of.ravel()
    count = np.bincount(edge_of, minlength=len(edges))
    balance = np.bincount(edge_of, np.where(forward, 1, -1), len(edges))
    degenerate = edges[:, 0] == edges[:, 1]
    open_edges = (count % 2 == 1) & ~degenerate
    if open_edges.any():
        raise InputError(
            f"the mesh is not closed: {int(open_edges.sum())} edges have no triangle on one side, the first "
            f"{_ends(vertices, edges[open_edges.argmax()])}.",
            remedy="Close it, or merge corners that should be one",
        )
    inconsistent = (balance != 0) & ~degenerate
    if inconsistent.any():
        raise InputError(
            f"the orientation of the triangles is inconsistent at {int(inconsistent.sum())} edges, the first "
            f"{_ends(vertices, edges[inconsistent.argmax()])}.",
            remedy="Flip some, so that all are counter-clockwise as seen from outside",
        )


def _check_volume(volume: float, unit: float) -> None:
    """Check the volume of a mesh that is scaled by ``1 / unit``."""
    if abs(volume) <= VOLUME_ROUNDING * float(np.finfo(float).eps):
        raise InputError("the mesh encloses no volume.")
    if volume < 0:
        raise InputError(
            f"the triangles face inwards: they enclose the volume {volume * unit**3:.4g}.",
            remedy="Flip them: faces[:, ::-1]",
        )


def _ends(vertices: Array, edge: Array) -> str:
    a, b = (", ".join(f"{x:.4g}" for x in vertices[i]) for i in edge)
    return f"from ({a}) to ({b})"


__all__ = ["MassProperties", "mass_properties"]
