"""Meshes of evolved circles: rings of vertices that similarities carry from circle to circle (thesis 4.10)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...calls import Numbers, call
from ...loading import stock_algebra
from ...multivector import Multivector
from ...rows import embedded
from .grids import Grid, Patch, grid_patch, standing, together
from .sweeps import Sweep, sweep
from .triangles import TriangleMesh, face_volumes

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
#: Radii beyond this many units of the surface's own size are lines, below one over it points.
UNBOUNDED = 1e9
#: The last circle is the first if they agree to this share of its radius.
CLOSED = 1e-9
#: Volumes below this share of the box are those of surfaces that enclose nothing.
FLAT = 1e-9


def ring_mesh(surface: Any, rings: int, segments: int, caps: bool) -> TriangleMesh:
    """The surface of an evolved circle: ``rings`` bands along the curve at least, ``segments`` quads around."""
    swept = sweep(surface, "circle", rings)
    algebra = stock_algebra("cga3d")
    center, axis, radius = _circles(swept)
    turns, is_closed = _turns(center, axis, radius, swept)
    angles = np.linspace(0.0, 2 * np.pi, segments + 1)
    spokes = np.stack([np.cos(angles), np.sin(angles), np.zeros(segments + 1)], 1)
    local = call(
        algebra,
        "meshing.placed",
        algebra.vector(center[:, None], "center"),
        Numbers(radius[:, None], 0, "radius"),
        turns[:, None],
        algebra.vector(spokes[None], "spoke"),
    ).value._data
    with np.errstate(all="ignore"):
        normals = call(
            algebra,
            "meshing.swept_normal",
            algebra.vector(local, "position"),
            swept.objects[:, None],
            swept.rates[:, None],
        ).value._data
    positions = swept.center[:, None] + swept.size[:, None, None] * local
    u = np.linspace(0.0, 1.0, segments + 1)
    grid = Grid(standing(positions), normals, u, swept.alpha, swept.run, swept.joined, True, is_closed)
    bands, vertex_row, face_row = grid_patch(grid)
    part = np.cumsum(np.where(swept.joined, 0, 1))  # of each run; parts are not connected
    part[part == part[-1]] = part[0] if is_closed else part[-1]
    lids = _lids(grid, swept, center, axis)
    inside_out = _inside_out(bands, part[swept.run[face_row]], [(lid, part[swept.run[row]]) for lid, row in lids])
    turned = inside_out[part[swept.run]]
    patches = [bands.turned_over(turned[vertex_row], turned[face_row])]
    if caps:
        patches += [
            lid.turned_over(np.full(len(lid.vertices), turned[row]), np.full(len(lid.faces), turned[row]))
            for lid, row in lids
        ]
    return together(patches).mesh()


def _circles(swept: Sweep) -> tuple[Array, Array, Array]:
    """Centres, unit normals and radii in the frames of the rows."""
    algebra = stock_algebra("cga3d")
    center, axis, radius = (
        np.asarray(x._data if isinstance(x, Multivector) else x)
        for x in call(algebra, "conformal.circle_parameters", swept.objects).values
    )
    radius = radius.reshape(-1)
    unbounded = ~(radius < UNBOUNDED)
    swept.refuse(unbounded, "circles that become lines, without end", "Mesh a part of the curve, or move a control")
    swept.refuse(radius < 1 / UNBOUNDED, "circles of no radius", "Move a control")
    return center, axis, radius


def _turns(center: Array, axis: Array, radius: Array, swept: Sweep) -> tuple[Multivector, bool]:
    """Rotations (rows,) that take the circle about e3 to each row's, and whether the last circle is the first.

    Each follows from the one before by the smallest rotation between the axes, so that quads are not twisted. Along a
    closed curve these add up to a turn about the axis, which is taken back evenly on the way.
    """
    algebra = stock_algebra("cga3d")
    axes = np.concatenate([[[0.0, 0.0, 1.0]], axis])
    nowhere, one = algebra.vector(np.zeros(3), "center"), Numbers(1.0, 0, "curvature")
    steps = call(
        algebra, "placement.similarity",
        nowhere, algebra.vector(axes[:-1], "axis"), one, nowhere, algebra.vector(axes[1:], "axis"), one,
    ).value  # fmt: skip
    turns = carried(_rotors(steps))
    start, end = (swept.center[i] + swept.size[i] * center[i] for i in (0, -1))
    sizes = [swept.size[i] * radius[i] for i in (0, -1)]
    near = CLOSED * sizes[0]
    meets = np.abs(end - start).max() <= near + np.finfo(float).eps * np.abs(start).max() * 4
    is_closed = bool(meets and abs(sizes[1] - sizes[0]) <= near and np.abs(axis[-1] - axis[0]).max() <= CLOSED)
    if not is_closed or len(axis) < 3:  # one band has nowhere to go round
        return turns, False
    first, last = (embedded(turns[i] >> algebra.e1, algebra.kind("euclidean")) for i in (0, -1))
    twist = np.arctan2(np.cross(first, last) @ axis[0], first @ last)
    share = (swept.alpha - swept.alpha[0]) / (swept.alpha[-1] - swept.alpha[0])
    return _rotors(turns * algebra.rotor([0.0, 0.0, 1.0], -twist * share)), True


def carried(steps: Multivector) -> Multivector:
    """Products step_i ... step_1 step_0 of a row of unit rotors, in as many batched products as it can be halved."""
    total, reach = steps, 1
    while reach < len(steps):
        ahead = _rotors(total[reach:] * total[:-reach]).normalized()
        data = np.concatenate([total._data[:reach], ahead._data])
        total, reach = Multivector._make(steps._type, data, steps.shape), 2 * reach
    return total


def _rotors(x: Multivector) -> Multivector:
    """Rotations on the blades of rotors, trusted to be unit."""
    kind = x.algebra.kind("rotor")
    places = [x.blades.index(blade) if blade in x.blades else None for blade in kind.blades]
    columns = [np.zeros(x.shape) if p is None else x._data[..., p] for p in places]
    return Multivector._make(x.algebra.type_of(kind, x.dtype), np.stack(columns, -1), x.shape)


def _lids(grid: Grid, swept: Sweep, center: Array, axis: Array) -> list[tuple[Patch, int]]:
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
    """The disc inside a ring, seen along its axis (side 1) or against it; it goes on with the winding of the bands."""
    rim = grid.positions[row].copy()
    rim[-1] = rim[0]
    j = np.arange(len(rim) - 1)
    hub = np.full(len(j), len(rim))
    faces = np.stack([hub, j, j + 1] if side > 0 else [hub, j + 1, j], 1)
    vertices = np.concatenate([rim, middle[None]])
    uv = np.stack([np.append(grid.u, 0.5), np.full(len(vertices), grid.v[row])], 1)
    return Patch(vertices, faces, np.tile(side * axis, (len(vertices), 1)), uv)


def _inside_out(bands: Patch, part: Integers, lids: list[tuple[Patch, Any]]) -> NDArray[np.bool_]:
    """Of each part whether the volume inside its bands and lids is negative; nothing is inside of what is flat."""
    whole = together([bands, *(lid for lid, _ in lids)])
    parts = np.concatenate([part, *(np.full(len(lid.faces), own) for lid, own in lids)])
    volumes = np.bincount(parts, face_volumes(whole.vertices, whole.faces), int(parts.max(initial=0)) + 1)
    extent = float(np.ptp(bands.vertices, axis=0).max(initial=0.0))
    return np.asarray(volumes < -FLAT * extent**3)


__all__ = ["carried", "ring_mesh"]
