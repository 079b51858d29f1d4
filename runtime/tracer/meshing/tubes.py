"""Meshes of evolved circles: rings of vertices related by similarities from circle to circle (thesis 4.10)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.multivector import Multivector
from ...core.registry import stock_algebra
from ...dispatch.coefficients import embed
from ...dispatch.formulas import ArrayOperand, evaluate
from .grids import Grid, Patch, concatenate_patches, grid_patch, snap_still_vertices
from .sweeps import Sweep, sweep
from .triangle_mesh import TriangleMesh, face_volumes

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
#: Largest radius of a circle in units of the surface's size, and one over the smallest.
UNBOUNDED = 1e9
#: Largest difference of the first and the last circle of a closed surface, relative to the radius.
CLOSED = 1e-9
#: Smallest enclosed volume, relative to the cube of the surface's extent.
FLAT = 1e-9


def ring_mesh(surface: Any, rings: int, segments: int, caps: bool) -> TriangleMesh:
    """Mesh of an evolved circle: at least ``rings`` bands along the curve, ``segments`` quads around."""
    swept = sweep(surface, "circle", rings)
    algebra = stock_algebra("cga3d")
    center, axis, radius = _circles(swept)
    rotations, is_closed = _ring_rotations(center, axis, radius, swept)
    angles = np.linspace(0.0, 2 * np.pi, segments + 1)
    spokes = np.stack([np.cos(angles), np.sin(angles), np.zeros(segments + 1)], 1)
    local = evaluate(
        algebra,
        "meshing.point_on_circle",
        algebra.spatial(center[:, None], "center"),
        ArrayOperand(radius[:, None], 0, "radius"),
        rotations[:, None],
        algebra.spatial(spokes[None], "spoke"),
    ).value._data
    with np.errstate(all="ignore"):
        normals = evaluate(
            algebra,
            "meshing.swept_normal",
            algebra.spatial(local, "position"),
            swept.objects[:, None],
            swept.rates[:, None],
        ).value._data
    positions = swept.center[:, None] + swept.size[:, None, None] * local
    u = np.linspace(0.0, 1.0, segments + 1)
    grid = Grid(snap_still_vertices(positions), normals, u, swept.alpha, swept.run, swept.joined, True, is_closed)
    bands, vertex_row, face_row = grid_patch(grid)
    part = np.cumsum(np.where(swept.joined, 0, 1))  # of each run; different parts are not connected
    part[part == part[-1]] = part[0] if is_closed else part[-1]
    lids = _caps(grid, swept, center, axis)
    inside_out = _inside_out(bands, part[swept.run[face_row]], [(lid, part[swept.run[row]]) for lid, row in lids])
    reversed_ = inside_out[part[swept.run]]
    patches = [bands.flip(reversed_[vertex_row], reversed_[face_row])]
    if caps:
        patches += [
            lid.flip(np.full(len(lid.vertices), reversed_[row]), np.full(len(lid.faces), reversed_[row]))
            for lid, row in lids
        ]
    return concatenate_patches(patches).mesh()


def _circles(swept: Sweep) -> tuple[Array, Array, Array]:
    """Centers, unit normals and radii in the local frames of the rows."""
    algebra = stock_algebra("cga3d")
    center, axis, radius = (
        np.asarray(x._data if isinstance(x, Multivector) else x)
        for x in evaluate(algebra, "conformal.circle_parameters", swept.objects).values
    )
    radius = radius.reshape(-1)
    unbounded = ~(radius < UNBOUNDED)
    swept.refuse(unbounded, "circles that become lines", "Mesh a part of the curve, or move a control")
    swept.refuse(radius < 1 / UNBOUNDED, "circles of zero radius", "Move a control")
    return center, axis, radius


def _ring_rotations(center: Array, axis: Array, radius: Array, swept: Sweep) -> tuple[Multivector, bool]:
    """Rotations (rows,) from the circle about e3 to that of each row, and whether the last circle is the first.

    Each follows from its predecessor by the smallest rotation between the axes, so that quads are not twisted. Along a
    closed curve these add up to a rotation about the axis, which is removed evenly along the curve.
    """
    algebra = stock_algebra("cga3d")
    axes = np.concatenate([[[0.0, 0.0, 1.0]], axis])
    nowhere, one = algebra.spatial(np.zeros(3), "center"), ArrayOperand(1.0, 0, "curvature")
    steps = evaluate(
        algebra, "placement.similarity",
        nowhere, algebra.spatial(axes[:-1], "axis"), one, nowhere, algebra.spatial(axes[1:], "axis"), one,
    ).value  # fmt: skip
    rotations = cumulative_products(_rotors(steps))
    start, end = (swept.center[i] + swept.size[i] * center[i] for i in (0, -1))
    sizes = [swept.size[i] * radius[i] for i in (0, -1)]
    near = CLOSED * sizes[0]
    meets = np.abs(end - start).max() <= near + np.finfo(float).eps * np.abs(start).max() * 4
    is_closed = bool(meets and abs(sizes[1] - sizes[0]) <= near and np.abs(axis[-1] - axis[0]).max() <= CLOSED)
    if not is_closed or len(axis) < 3:  # a single band cannot close
        return rotations, False
    first, last = (embed(rotations[i] >> algebra.e1, algebra.kind("euclidean")) for i in (0, -1))
    twist = np.arctan2(np.cross(first, last) @ axis[0], first @ last)
    fraction = (swept.alpha - swept.alpha[0]) / (swept.alpha[-1] - swept.alpha[0])
    return _rotors(rotations * algebra.rotor([0.0, 0.0, 1.0], -twist * fraction)), True


def cumulative_products(steps: Multivector) -> Multivector:
    """Products step_i ... step_1 step_0 of a sequence of unit rotors, by a scan of log2(n) batched products."""
    total, stride = steps, 1
    while stride < len(steps):
        ahead = _rotors(total[stride:] * total[:-stride]).normalized()
        data = np.concatenate([total._data[:stride], ahead._data])
        total, stride = Multivector._make(steps._type, data, steps.shape), 2 * stride
    return total


def _rotors(x: Multivector) -> Multivector:
    """Express rotations on the blades of rotors, trusted to be unit."""
    kind = x.algebra.kind("rotor")
    indices = [x.blades.index(blade) if blade in x.blades else None for blade in kind.blades]
    columns = [np.zeros(x.shape) if p is None else x._data[..., p] for p in indices]
    return Multivector._make(x.algebra.type_of(kind, x.dtype), np.stack(columns, -1), x.shape)


def _caps(grid: Grid, swept: Sweep, center: Array, axis: Array) -> list[tuple[Patch, int]]:
    """Fans of triangles over the open ends, and the rows that they close."""
    first = np.flatnonzero(np.diff(grid.run, prepend=-1))
    last = np.append(first[1:], len(grid.run)) - 1
    starts, ends = ~grid.joined, ~np.append(grid.joined[1:], False)
    if grid.is_closed:
        starts[0] = ends[-1] = False
    sides = [*((row, -1.0) for row in first[starts]), *((row, 1.0) for row in last[ends])]
    return [
        (_fan(grid, int(row), swept.center[row] + swept.size[row] * center[row], axis[row], side), int(row))
        for row, side in sides
    ]


def _fan(grid: Grid, row: int, middle: Array, axis: Array, side: float) -> Patch:
    """Fan inside a ring, with the normal along its axis (side 1) or against it; winding continues that of the bands."""
    rim = grid.positions[row].copy()
    rim[-1] = rim[0]
    j = np.arange(len(rim) - 1)
    hub = np.full(len(j), len(rim))
    faces = np.stack([hub, j, j + 1] if side > 0 else [hub, j + 1, j], 1)
    vertices = np.concatenate([rim, middle[None]])
    uv = np.stack([np.append(grid.u, 0.5), np.full(len(vertices), grid.v[row])], 1)
    return Patch(vertices, faces, np.tile(side * axis, (len(vertices), 1)), uv)


def _inside_out(bands: Patch, part: Integers, lids: list[tuple[Patch, Any]]) -> NDArray[np.bool_]:
    """Mask of the parts whose bands and caps enclose a negative volume; flat parts enclose none."""
    whole = concatenate_patches([bands, *(lid for lid, _ in lids)])
    parts = np.concatenate([part, *(np.full(len(lid.faces), number) for lid, number in lids)])
    volumes = np.bincount(parts, face_volumes(whole.vertices, whole.faces), int(parts.max(initial=0)) + 1)
    extent = float(np.ptp(bands.vertices, axis=0).max(initial=0.0))
    return np.asarray(volumes < -FLAT * extent**3)
