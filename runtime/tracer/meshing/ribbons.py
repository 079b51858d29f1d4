"""Meshes of evolved point pairs: strips of the segments between their ends (thesis 4.7, 4.10)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...calls import Numbers, call
from ...loading import stock_algebra
from ...multivector import Multivector
from .grids import SAME_FAR_PLACE, SAME_PLACE, Grid, grid_patch, nothing_swept
from .rings import CLOSED, UNBOUNDED
from .sweeps import Sweep, sweep
from .triangles import TriangleMesh

Array = NDArray[np.float64]


def strip_mesh(surface: Any, rings: int, segments: int) -> TriangleMesh:
    """The surface of an evolved point pair: ``rings`` bands along the curve at least, ``segments`` quads across."""
    swept = sweep(surface, "point_pair", rings)
    algebra = stock_algebra("cga3d")
    first, last = _ends(swept)
    share = np.linspace(0.0, 1.0, segments + 1)
    local = call(
        algebra,
        "meshing.between",
        algebra.vector(first[:, None], "a"),
        algebra.vector(last[:, None], "b"),
        Numbers(share[None], 0, "share"),
    ).value._data
    with np.errstate(all="ignore"):
        normals = call(
            algebra,
            "meshing.segment_normal",
            algebra.vector(local, "position"),
            swept.objects[:, None],
            swept.rates[:, None],
        ).value._data
    positions = swept.center[:, None] + swept.size[:, None, None] * local
    if _is_line(positions[:, [0, -1]].reshape(-1, 3)):
        raise nothing_swept("the surface")
    length = float(np.abs(positions[0, -1] - positions[0, 0]).max())
    rounding = 4 * np.finfo(float).eps * np.abs(positions[0]).max()
    is_closed = bool(np.abs(positions[-1] - positions[0]).max() <= CLOSED * length + rounding)
    grid = Grid(positions, normals, share, swept.alpha, swept.run, swept.joined, False, is_closed)
    return grid_patch(grid)[0].mesh()


def _is_line(ends: Array) -> bool:
    """Whether all points lie on one line, to rounding."""
    relative = ends - ends[0]
    farthest = relative[np.abs(relative).max(axis=1).argmax()]
    length = float(np.linalg.norm(farthest))
    limit = np.finfo(float).eps * (SAME_PLACE * length + SAME_FAR_PLACE * np.abs(ends).max())
    return bool(np.linalg.norm(np.cross(relative, farthest), axis=1).max() <= limit * length)


def _ends(swept: Sweep) -> tuple[Array, Array]:
    """End points in the frames of the rows."""
    algebra = stock_algebra("cga3d")
    first, last = (
        np.asarray(x._data if isinstance(x, Multivector) else x)
        for x in call(algebra, "conformal.point_pair_parameters", swept.objects).values
    )
    length = np.abs(last - first).max(axis=1)
    swept.refuse(~(length < UNBOUNDED), "point pairs without end", "Mesh a part of the curve, or move a control")
    swept.refuse(length < 1 / UNBOUNDED, "point pairs of no length", "Move a control")
    return first, last


__all__ = ["strip_mesh"]
