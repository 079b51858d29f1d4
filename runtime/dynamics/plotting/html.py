"""A trajectory as one HTML page to turn and to play, without a network: a canvas and some 200 lines of script.

Needs no other package.
"""

from __future__ import annotations

import base64
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..files import write_atomically
from ..plot.outlines import Drawable, Marks, Strokes
from ..plot.shapes import Box
from ..plot.things import sorted_out
from ..webpages import filled, page_json
from . import pictures
from .record import Record
from .shapes import Shape

Array = NDArray[Any]
#: States that a page holds; of more it holds every so-manieth.
MOST_STATES = 10_000
#: Triangles that a page draws in each frame; finer meshes lose their details.
MOST_FACES = 12_000
#: Cells along the longest side of a mesh that loses its details.
CELLS = 40
#: Length of the axes that stand for a body without a shape, as a share of the view.
AXES = 0.12


def write_page(record: Record, path: Path, speed: float, view: tuple[float, float]) -> None:
    """Write the page, in one step.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    text = page_text(record, speed, view)
    try:
        write_atomically(path, text)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}.", where=str(path)) from None


def page_text(record: Record, speed: float, view: tuple[float, float]) -> str:
    """The whole file."""
    folder = f"{__package__}.data"
    title = record.sketch.title or "A motion"
    note = "drag to turn, scroll to zoom, space to play"
    return filled(folder, "motion", title, note, page_json(contents(record, speed, view)))


def contents(record: Record, speed: float, view: tuple[float, float]) -> dict[str, Any]:
    """What the script reads: positions are relative to the middle of the view, so that 24 bits are enough."""
    low, high = pictures.room(record)
    middle, half = (low + high) / 2, (high - low) / 2
    chosen = (
        np.unique(np.linspace(0, len(record) - 1, MOST_STATES).astype(int))
        if len(record) > MOST_STATES
        else np.arange(len(record))
    )
    size = float(np.linalg.norm(half)) * 2
    units, duration = record.sketch.units, float(record.time[-1] - record.time[0])
    first = float(record.energy[0])
    return {
        "time": _packed(record.time[chosen], np.float64),
        "energy": _packed(_finite(record.energy[chosen] - first), np.float64),
        "violation": _packed(_finite(record.violation[chosen]), np.float64),
        "energy_start": first if math.isfinite(first) else 0.0,
        "held": bool(any(np.any(own.reaction.values) for own in record.bodies.values())),
        "bodies": [_body(record, name, own, chosen, middle, size) for name, own in record.bodies.items()],
        "traces": [
            {"label": label, "color": color, "points": _packed(points[chosen] - middle, np.float32)}
            for label, color, points in pictures.paths(record)
        ],
        "objects": _objects(record, Box(low, high), middle),
        "half": half.tolist(), "size": size, "view": list(view), "speed": speed,
        "digits": max(0, min(9, 2 - math.floor(math.log10(duration / 10)))) if duration > 0 else 2,
        "units": {"time": units.time, "energy": units.energy},
    }  # fmt: skip


def _body(record: Record, name: str, own: Record, chosen: Array, middle: Array, size: float) -> dict[str, Any]:
    shape = record.sketch.shape_of(name, len(record.rows) == 1)
    if shape is None:
        vertices = AXES * size * np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        faces, edges = np.zeros((0, 3), int), np.array([(0, 1), (0, 2), (0, 3)])
    else:
        vertices, faces, edges = _drawable(shape)
    poses = np.concatenate([own.orientation[chosen], (own.position[chosen] - middle)[..., None]], -1)
    index = np.uint16 if len(vertices) <= np.iinfo(np.uint16).max else np.uint32
    return {
        "color": pictures.body_color(record, name), "vertices": _packed(vertices, np.float32),
        "faces": _packed(faces, index), "edges": _packed(edges, index), "poses": _packed(poses, np.float32),
    }  # fmt: skip


def _drawable(shape: Shape) -> tuple[Array, Array, Array]:
    """Vertices, faces and edges, of a fine mesh fewer: vertices in one cell of a grid become one."""
    if len(shape.faces) <= MOST_FACES:
        return shape.vertices, shape.faces, shape.edges
    cell = float(np.ptp(shape.vertices, axis=0).max()) / CELLS
    keys, of_vertex = np.unique(np.round(shape.vertices / cell), axis=0, return_inverse=True)
    of_vertex = of_vertex.ravel()
    counts = np.bincount(of_vertex)[:, None]
    vertices = np.stack([np.bincount(of_vertex, x) for x in shape.vertices.T], 1) / counts
    faces = of_vertex[shape.faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return vertices, np.unique(faces[whole], axis=0), np.zeros((0, 2), int)


def _objects(record: Record, box: Box, middle: Array) -> list[dict[str, Any]]:
    """Polylines of what holds bodies."""
    lines = []
    for held in record.sketch.objects:
        for group in sorted_out(held, None).groups:
            for part in Drawable(group, np.zeros((1, 4)), surface=False).outline(box):
                if isinstance(part, Strokes):
                    lines += list(part.positions)
                elif isinstance(part, Marks):
                    lines += [_cross(p, 0.02 * box.size) for p in part.positions]
    return [_packed(line - middle, np.float32) for line in lines]


def _cross(point: Array, size: float) -> Array:
    """Three strokes through a point."""
    gap = np.full((1, 3), np.nan)
    return np.concatenate([row for axis in np.eye(3) for row in (point + size * np.array([-axis, axis]), gap)])


def _finite(values: Array) -> Array:
    return np.where(np.isfinite(values), values, 0.0)


def _packed(values: Array, dtype: Any) -> dict[str, str]:
    """Base64 of an array's bytes, the lowest first."""
    array = np.ascontiguousarray(values, np.dtype(dtype).newbyteorder("<"))
    name = f"{array.dtype.kind}{array.dtype.itemsize}"
    return {"dtype": name, "bdata": base64.b64encode(array.tobytes()).decode("ascii")}


__all__ = ["page_text", "write_page"]
