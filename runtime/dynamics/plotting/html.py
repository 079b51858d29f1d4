"""A trajectory as one HTML page to rotate and to play, without a network: a canvas and some 200 lines of script.

Needs no other package.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.targets.templates import template_text
from ...common.html_page import encode_array, index_type, page_json, render_page
from ...mechanics.shapes import Shape
from ...plot.glyphs import Drawable, Marks, Strokes
from ...plot.input_groups import group_items
from ...plot.tessellation import Box
from ..results.trajectory_data import TrajectoryData
from . import scene

Array = NDArray[Any]
#: Largest number of states of a page; longer trajectories are sampled.
MAX_STATES = 10_000
#: Largest number of triangles of a body; finer meshes are simplified.
MAX_FACES = 12_000
#: Cells along the longest side of a mesh that is simplified.
CELLS = 40
#: Length of the axes that stand for a body without a shape, as a fraction of the view.
AXES = 0.12


def page_text(record: TrajectoryData, speed: float, view: tuple[float, float]) -> str:
    """Text of the page."""
    title = record.sketch.title or "A motion"
    note = "drag to turn, scroll to zoom, space to play"
    return render_page("motion", title, note, page_json(contents(record, speed, view)), template_text("stage.js"))


def contents(record: TrajectoryData, speed: float, view: tuple[float, float]) -> dict[str, Any]:
    """Input of the script: positions are relative to the middle of the view, so that 24 bits are enough."""
    box = scene.view_bounds(record)
    middle, half = (box.low + box.high) / 2, (box.high - box.low) / 2
    indices = (
        np.unique(np.linspace(0, len(record) - 1, MAX_STATES).astype(int))
        if len(record) > MAX_STATES
        else np.arange(len(record))
    )
    size = float(np.linalg.norm(half)) * 2
    units, duration = record.sketch.units, float(record.time[-1] - record.time[0])
    first = float(record.energy[0])
    return {
        "time": encode_array(record.time[indices], np.float64),
        "energy": encode_array(_finite(record.energy[indices] - first), np.float64),
        "violation": encode_array(_finite(record.violation[indices]), np.float64),
        "energy_start": first if math.isfinite(first) else 0.0,
        "held": bool(any(np.any(body.reaction.values) for body in record.bodies.values())),
        "bodies": [_body(record, name, body, indices, middle, size) for name, body in record.bodies.items()],
        "traces": [
            {"label": label, "color": color, "points": encode_array(points[indices] - middle, np.float32)}
            for label, color, points in scene.paths(record)
        ],
        "objects": _objects(record, box, middle),
        "half": half.tolist(), "size": size, "view": list(view), "speed": speed,
        "digits": max(0, min(9, 2 - math.floor(math.log10(duration / 10)))) if duration > 0 else 2,
        "units": {"time": units.time, "energy": units.energy},
    }  # fmt: skip


def _body(
    record: TrajectoryData, name: str, body: TrajectoryData, indices: Array, middle: Array, size: float
) -> dict[str, Any]:
    shape = record.sketch.shape_of(name, len(record.rows) == 1)
    if shape is None:
        vertices = AXES * size * np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        faces, edges = np.zeros((0, 3), int), np.array([(0, 1), (0, 2), (0, 3)])
    else:
        vertices, faces, edges = _drawable(shape)
    poses = np.concatenate([body.orientation[indices], (body.position[indices] - middle)[..., None]], -1)
    index = index_type(len(vertices))
    return {
        "color": scene.body_color(record, name), "vertices": encode_array(vertices, np.float32),
        "faces": encode_array(faces, index), "edges": encode_array(edges, index),
        "poses": encode_array(poses, np.float32),
    }  # fmt: skip


def _drawable(shape: Shape) -> tuple[Array, Array, Array]:
    """Vertices, faces and edges; in a fine mesh the vertices in one cell of a grid become one."""
    if len(shape.faces) <= MAX_FACES:
        return shape.vertices, shape.faces, shape.edges
    cell = float(np.ptp(shape.vertices, axis=0).max()) / CELLS
    keys, of_vertex = np.unique(np.round(shape.vertices / cell), axis=0, return_inverse=True)
    of_vertex = of_vertex.ravel()
    counts = np.bincount(of_vertex)[:, None]
    vertices = np.stack([np.bincount(of_vertex, x) for x in shape.vertices.T], 1) / counts
    faces = of_vertex[shape.faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return vertices, np.unique(faces[whole], axis=0), np.zeros((0, 2), int)


def _objects(record: TrajectoryData, box: Box, middle: Array) -> list[dict[str, Any]]:
    """Polylines of the objects of constraints."""
    lines = []
    for shown_object in record.sketch.objects:
        for group in group_items(shown_object, None).groups:
            for part in Drawable(group, np.zeros((1, 4)), surface=False).outline(box):
                if isinstance(part, Strokes):
                    lines += list(part.positions)
                elif isinstance(part, Marks):
                    lines += [_cross(p, 0.02 * box.size) for p in part.positions]
    return [encode_array(line - middle, np.float32) for line in lines]


def _cross(point: Array, size: float) -> Array:
    """Three strokes through a point."""
    gap = np.full((1, 3), np.nan)
    return np.concatenate([row for axis in np.eye(3) for row in (point + size * np.array([-axis, axis]), gap)])


def _finite(values: Array) -> Array:
    return np.where(np.isfinite(values), values, 0.0)


__all__ = ["page_text"]
