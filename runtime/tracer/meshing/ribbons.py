"""Meshes of evolved point pairs: ruled strips of the segments between their ends (thesis 4.7, 4.10)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Multivector
from ...core.registry import stock_algebra
from ...dispatch.formulas import ArrayOperand, evaluate
from .grids import COORDINATE_ROUNDING, EXTENT_ROUNDING, Grid, grid_patch, nothing_swept
from .sweeps import Sweep, sweep
from .triangle_mesh import TriangleMesh
from .tubes import CLOSED, UNBOUNDED

Array = NDArray[np.float64]


def strip_mesh(surface: Any, rings: int, segments: int) -> TriangleMesh:
    """Mesh of an evolved point pair: at least ``rings`` bands along the curve, ``segments`` quads across."""
    swept = sweep(surface, "point_pair", rings)
    algebra = stock_algebra("cga3d")
    first, last = _ends(swept)
    fraction = np.linspace(0.0, 1.0, segments + 1)
    local = evaluate(
        algebra,
        "meshing.interpolate_position",
        algebra.spatial(first[:, None], "a"),
        algebra.spatial(last[:, None], "b"),
        ArrayOperand(fraction[None], 0, "fraction"),
    ).value._data
    with np.errstate(all="ignore"):
        normals = evaluate(
            algebra,
            "meshing.segment_normal",
            algebra.spatial(local, "position"),
            swept.objects[:, None],
            swept.rates[:, None],
        ).value._data
    positions = swept.center[:, None] + swept.size[:, None, None] * local
    if _is_line(positions[:, [0, -1]].reshape(-1, 3)):
        raise nothing_swept("the surface")
    length = float(np.abs(positions[0, -1] - positions[0, 0]).max())
    rounding = 4 * np.finfo(float).eps * np.abs(positions[0]).max()
    is_closed = bool(np.abs(positions[-1] - positions[0]).max() <= CLOSED * length + rounding)
    grid = Grid(positions, normals, fraction, swept.alpha, swept.run, swept.joined, False, is_closed)
    return grid_patch(grid)[0].mesh()


def _is_line(ends: Array) -> bool:
    """Test whether all points lie on one line, up to rounding."""
    relative = ends - ends[0]
    farthest = relative[np.abs(relative).max(axis=1).argmax()]
    length = float(np.linalg.norm(farthest))
    limit = np.finfo(float).eps * (EXTENT_ROUNDING * length + COORDINATE_ROUNDING * np.abs(ends).max())
    return bool(np.linalg.norm(np.cross(relative, farthest), axis=1).max() <= limit * length)


def _ends(swept: Sweep) -> tuple[Array, Array]:
    """End points in the local frames of the rows."""
    algebra = stock_algebra("cga3d")
    first, last = (
        np.asarray(x._data if isinstance(x, Multivector) else x)
        for x in evaluate(algebra, "conformal.point_pair_parameters", swept.objects).values
    )
    length = np.abs(last - first).max(axis=1)
    swept.refuse(~(length < UNBOUNDED), "unbounded point pairs", "Mesh a part of the curve, or move a control")
    swept.refuse(length < 1 / UNBOUNDED, "point pairs of zero length", "Move a control")
    return first, last
