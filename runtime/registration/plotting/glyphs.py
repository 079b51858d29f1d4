"""Glyphs of models: lines cut where others pass them, planes as patches, rounds whole; no matplotlib here.

Lines and planes have no ends. A model of edges and faces shows its shape best where each line goes as far as the lines
that come nearest to it, and each plane as far as the lines in it; otherwise they are cut by a box about the model.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...plot import tessellation
from ...plot.glyphs import PLANE_OPACITY, Drawable, Faces, Marks, Strokes
from ...plot.input_groups import Group
from ...plot.palette import Rgba, take_rows, with_opacity
from ...plot.tessellation import Box
from ...plot.view_box import surrounding_box
from ..model.model import Model
from ..model.parameters import columns

Array = NDArray[Any]
#: Number of nearest lines that determine the ends of a line.
N_NEIGHBORS = 8
#: Smallest squared sine of the angle between a line and one that determines its ends.
MIN_SQUARED_SINE = 0.01
#: Extension of lines beyond their ends, over the model's size.
OVERHANG = 0.03
#: Shortest line, over the model's size.
SHORTEST = 0.06
#: Longest line, over the model's size, times the square root of their number.
LONGEST = 6.0
#: Fewer lines than this are cut by the box.
MIN_LINES = 4
#: Largest number of lines that are compared with each line.
MAX_LINES = 1500
#: Largest distance of a line in a plane, over the model's size.
IN_PLANE = 0.01
#: Largest sine of the angle of such a line with the plane.
ALONG_PLANE = 0.05
#: Half a side of a patch without lines, over the model's size.
PATCH = 0.1
#: Smallest half side of a patch.
MIN_PATCH = 0.03
#: Largest half side of a patch, times the square root of their number.
MAX_PATCH = 1.0
#: Largest number of planes that are cut by the box instead of being drawn as patches.
MAX_WHOLE_PLANES = 12
#: Largest number of pairs of planes and lines that are compared.
MAX_PAIRS = 1 << 22
#: Radius of the ball of positions in the box, over a quantile of their distances from the center.
BOX_FACTOR = 3.0
#: This quantile.
BOX_QUANTILE = 0.9
#: Margin of the box, over its size.
MARGIN = 0.06
#: The same for models of lines and planes only.
FLAT_MARGIN = 0.25
#: Shortest side before the margin, as a fraction of the longest.
MIN_SIDE = 0.5
#: Opacity of patches of few planes, and of many together.
MANY_PLANES_OPACITY = 3.0


@dataclass(frozen=True)
class ModelSketch:
    """A model to be drawn, in its own frame.

    Attributes
    ----------
    model : Model
    segments, patches : arrays (n, 2, 3), (n, m, 3)
        Drawn parts of lines and planes.
    """

    model: Model

    @cached_property
    def ball(self) -> tuple[Array, float]:
        """Center and radius of a ball around most of the model, independent of its orientation."""
        positions = self._positions()
        middle = np.median(positions, 0)
        return middle, BOX_FACTOR * float(np.quantile(np.linalg.norm(positions - middle, axis=1), BOX_QUANTILE))

    @cached_property
    def box(self) -> Box:
        """Box around finite objects, and around the nearest points of lines and planes."""
        positions, (middle, radius) = self._positions(), self.ball
        positions = positions[np.linalg.norm(positions - middle, axis=1) <= radius]
        is_endless = all(kind in ("line", "plane") for kind in self.model.counts)
        margin, shortest = (FLAT_MARGIN, 1.0) if is_endless else (MARGIN, MIN_SIDE)
        return surrounding_box(positions, margin, shortest, 0.0 if np.ptp(positions, axis=0).any() else 1.0)

    def _positions(self) -> Array:
        """Positions of finite objects, and points of flats that are nearest to the center of all."""
        drawables = [Drawable(group, np.zeros((1, 4))) for group in self._groups()]
        finite = np.concatenate([np.empty((0, 3)), *(d.bounding_points() for d in drawables)])
        flats = [f for d in drawables if (f := d.flats()) is not None]
        if len(finite):
            center = np.asarray(np.median(finite, 0))
        else:
            center = tessellation.common_point(*(np.concatenate(x) for x in zip(*flats, strict=True)))
        return np.concatenate([finite, *(d.feet(center) for d in drawables)])

    def _groups(self) -> Iterator[Group]:
        """Groups of objects by kind, as `plot` reads them."""
        for kind, rows in self.model.parameters.items():
            parts = [rows[:, place] for place in columns(kind).values()]
            fields = tuple(x[:, 0] if x.shape[1] == 1 else x for x in parts)
            more = (np.ones(len(rows)),) if kind == "sphere" else ()
            yield Group("point_pair" if kind == "segment" else kind, (*fields, *more), np.arange(len(rows)))

    @cached_property
    def segments(self) -> Array:
        """The parts (n, 2, 3) of lines that are drawn."""
        rows = self.model.parameters.get("line", np.empty((0, 6)))
        point, direction = rows[:, :3], rows[:, 3:]
        whole = tessellation.lines_in(self.box, point, direction)
        if len(rows) < MIN_LINES:
            return whole
        low, middle, high = _crossing_range(point, direction, *self.ball)
        size = self.box.size
        most = LONGEST * size / len(rows) ** 0.5
        low, high = (np.where(high - low > most, middle + sign * most / 2, x) for sign, x in ((-1, low), (1, high)))
        more = np.maximum((SHORTEST * size - (high - low)) / 2, OVERHANG * size)
        ends = point[:, None] + np.stack([low - more, high + more], 1)[..., None] * direction[:, None]
        return np.where(np.isfinite(low)[:, None, None], ends, whole)

    def over(self, other: ModelSketch, matches: Mapping[str, Array]) -> None:
        """Draw matched lines and planes where those of another model are that lie under them."""
        for kind, own, others in (("line", self.segments, other.segments), ("plane", self.patches, other.patches)):
            rows = matches.get(kind, np.empty(0, np.int64))
            hit = rows >= 0
            if hit.any() and own.shape[1] == others.shape[1]:
                own[hit] = _nearest_positions(kind, self.model.parameters[kind][hit, None], others[rows[hit]])

    @cached_property
    def patches(self) -> Array:
        """Polygons (n, m, 3) of planes."""
        rows = self.model.parameters.get("plane", np.empty((0, 4)))
        normal, offset = rows[:, :3], rows[:, 3]
        center, half = _patch_frames(normal, offset, self.segments, self.box)
        u, v = tessellation.across(normal)
        sides = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * half[:, None, None]
        squares = center[:, None] + sides[..., :1] * u[:, None] + sides[..., 1:] * v[:, None]
        if len(rows) > MAX_WHOLE_PLANES:
            return squares
        cut = tessellation.planes_in(self.box, normal, offset)
        squares = np.concatenate([squares, np.repeat(squares[:, :1], cut.shape[1] - 4, 1)], 1)
        missed = ~np.asarray(np.isfinite(cut).all((1, 2)), bool)
        return np.where(missed[:, None, None], squares, cut)

    def parts(self, colors: dict[str, Rgba]) -> Iterator[Strokes | Faces | Marks]:
        """Glyphs in colors (1 or n, 4) by kind."""
        everywhere = Box(self.box.low - 1e3 * self.box.size, self.box.high + 1e3 * self.box.size)
        for kind, group in zip(self.model.parameters, self._groups(), strict=True):
            rows = colors[kind]
            if kind == "segment":
                yield Strokes(np.stack(group.parameters, 1), rows)
            elif kind == "line":
                yield Strokes(self.segments, rows)
            elif kind == "plane":
                opacity = PLANE_OPACITY * min(1.0, MANY_PLANES_OPACITY / len(group.indices) ** 0.5)
                yield Strokes(np.concatenate([self.patches, self.patches[:, :1]], 1), with_opacity(rows, 0.7), 0.6)
                yield Faces(self.patches, with_opacity(rows, opacity))
            else:
                shown = Drawable(group, take_rows(rows, group.indices))
                yield from shown.outline(everywhere)


def _nearest_positions(kind: str, rows: Array, x: Array) -> Array:
    """The positions on lines or planes (n, 1, k) that are nearest to others (n, m, 3)."""
    if kind == "plane":
        normal, offset = rows[..., :3], rows[..., 3:]
        return np.asarray(x - ((x * normal).sum(-1, keepdims=True) - offset) * normal)
    point, direction = rows[..., :3], rows[..., 3:]
    return np.asarray(point + ((x - point) * direction).sum(-1, keepdims=True) * direction)


def _crossing_range(point: Array, direction: Array, center: Array, radius: float) -> tuple[Array, Array, Array]:
    """Range along each line in which the nearest other lines pass it, and its median.

    What passes outside the ball does not count; NaN where fewer than two are left.
    """
    others = np.arange(0, len(point), max(1, -(-len(point) // MAX_LINES)))
    ranges = np.full((3, len(point)), np.nan)
    size = max(1, MAX_LINES * MAX_LINES // max(len(others), 1))
    for begin in range(0, len(point), size):
        part = slice(begin, begin + size)
        p, d = point[part, None], direction[part, None]
        w, b = p - point[others], (d * direction[others]).sum(-1)
        sine = 1 - b * b
        passes = sine > MIN_SQUARED_SINE
        sine = np.where(passes, sine, 1.0)
        t = (b * (w * direction[others]).sum(-1) - (w * d).sum(-1)) / sine
        distances = np.abs((w * np.cross(d, direction[others])).sum(-1)) / np.sqrt(sine)
        passes &= np.linalg.norm(p + t[..., None] * d - center, axis=-1) <= radius
        distances[~passes] = np.inf
        nearest = np.argsort(distances, axis=1, kind="stable")[:, :N_NEIGHBORS]
        t, passes = (np.take_along_axis(x, nearest, 1) for x in (t, passes))
        several = passes.sum(1) >= 2
        ranges[:, part][:, several] = np.nanquantile(np.where(passes, t, np.nan)[several], (0, 0.5, 1), axis=1)
    low, middle, high = ranges
    return low, middle, high


def _patch_frames(normal: Array, offset: Array, segments: Array, box: Box) -> tuple[Array, Array]:
    """Centers (n, 3) and half sides (n,) of patches: around the lines in a plane, or nearest to the box's center."""
    center = box.center - ((normal @ box.center) - offset)[:, None] * normal
    half = np.full(len(normal), PATCH * box.size)
    if not len(segments) or not len(normal) or len(segments) * len(normal) > MAX_PAIRS:
        return center, half
    middle, along = segments.mean(1), tessellation.unit(segments[:, 1] - segments[:, 0])
    inside = np.abs(normal @ middle.T - offset[:, None]) <= IN_PLANE * box.size
    inside &= np.abs(normal @ along.T) <= ALONG_PLANE
    count = inside.sum(1)
    has_lines = count >= 2
    weight = inside[has_lines] / count[has_lines, None]
    center[has_lines] = weight @ middle
    ends = np.linalg.norm(segments[None] - center[has_lines][:, None, None], axis=-1).max(-1)
    half[has_lines] = (weight * ends).sum(1) / np.sqrt(2)
    half = np.clip(half, MIN_PATCH * box.size, MAX_PATCH * box.size / len(normal) ** 0.5)
    return center, half
