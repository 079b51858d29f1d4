"""What a model looks like: lines cut where others pass them, planes as patches, rounds whole; no matplotlib here.

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

from ..plot import shapes
from ..plot.outlines import PLANE_OPACITY, Drawable, Faces, Marks, Strokes
from ..plot.palette import Rgba, chosen, faded
from ..plot.shapes import Box
from ..plot.things import Group
from .model import Model
from .parameters import columns

Array = NDArray[Any]
#: Lines that come nearest to a line end it; those whose angle with it has a smaller squared sine do not count.
NEIGHBOURS, LEAST_SINE = 8, 0.01
#: Lines beyond their ends, and shortest, over the model's size; longest, times the root of their number.
OVERHANG, SHORTEST, LONGEST = 0.03, 0.06, 6.0
#: Where there are fewer others, lines are cut by the box; of more, so many are looked at.
FEWEST, MOST = 4, 1500
#: Lines in a plane are so near to it, and so parallel; half a side of a patch with none, the smallest one, and the
#: largest, times the root of their number.
IN_PLANE, ALONG_PLANE, PATCH, LEAST_PATCH, MOST_PATCH = 0.01, 0.05, 0.1, 0.03, 1.0
#: Planes that are cut by the box where no lines say more; pairs of planes and lines that are looked at.
WHOLE_PLANES, MOST_PAIRS = 12, 1 << 22
#: The box holds what is within so many times the distance of most positions from their middle.
HELD, MOSTLY = 3.0, 0.9
#: Room about that, over its size, and where there are only lines and planes.
ROOM, FLAT_ROOM = 0.06, 0.25
#: Opacity of patches of few planes, and of many together.
MANY_PLANES_OPACITY = 3.0


@dataclass(frozen=True)
class Sketch:
    """A model to be drawn, in its own frame.

    Attributes
    ----------
    model : Model
    segments, patches : arrays (n, 2, 3), (n, m, 3)
        What is drawn of lines and planes.
    """

    model: Model

    @cached_property
    def ball(self) -> tuple[Array, float]:
        """Middle and radius of what most of the model is in, however it is turned."""
        held = self._positions()
        middle = np.median(held, 0)
        return middle, HELD * float(np.quantile(np.linalg.norm(held - middle, axis=1), MOSTLY))

    @cached_property
    def box(self) -> Box:
        """Around what is finite, and around where lines and planes come nearest to each other."""
        held, (middle, radius) = self._positions(), self.ball
        held = held[np.linalg.norm(held - middle, axis=1) <= radius]
        low, high = held.min(0), held.max(0)
        longest = float((high - low).max()) or 1.0
        half = np.maximum((high - low) / 2, longest / 4) + ROOM * longest
        if not any(kind not in ("line", "plane") for kind in self.model.counts):  # they go on
            half = np.full(3, longest / 2 + FLAT_ROOM * longest)
        return Box((low + high) / 2 - half, (low + high) / 2 + half)

    def _positions(self) -> Array:
        """Of points, ends, rounds; of flats the points nearest to the middle of all."""
        drawables = [Drawable(group, np.zeros((1, 4))) for group in self._groups()]
        finite = np.concatenate([np.empty((0, 3)), *(d.reach() for d in drawables)])
        flats = [f for d in drawables if (f := d.flats()) is not None]
        if len(finite):
            center = np.asarray(np.median(finite, 0))
        else:
            center = shapes.common_point(*(np.concatenate(x) for x in zip(*flats, strict=True)))
        return np.concatenate([finite, *(d.feet(center) for d in drawables)])

    def _groups(self) -> Iterator[Group]:
        """As `plot` reads objects, by kind."""
        for kind, rows in self.model.parameters.items():
            parts = [rows[:, place] for place in columns(kind).values()]
            fields = tuple(x[:, 0] if x.shape[1] == 1 else x for x in parts)
            more = (np.ones(len(rows)),) if kind == "sphere" else ()
            yield Group(kind, (*fields, *more), np.arange(len(rows)))

    @cached_property
    def segments(self) -> Array:
        """The parts (n, 2, 3) of lines that are drawn."""
        rows = self.model.parameters.get("line", np.empty((0, 6)))
        point, direction = rows[:, :3], rows[:, 3:]
        whole = shapes.lines_in(self.box, point, direction)
        if len(rows) < FEWEST:
            return whole
        low, middle, high = _spans(point, direction, *self.ball)
        size = self.box.size
        most = LONGEST * size / len(rows) ** 0.5
        low, high = (np.where(high - low > most, middle + sign * most / 2, x) for sign, x in ((-1, low), (1, high)))
        more = np.maximum((SHORTEST * size - (high - low)) / 2, OVERHANG * size)
        ends = point[:, None] + np.stack([low - more, high + more], 1)[..., None] * direction[:, None]
        return np.where(np.isfinite(low)[:, None, None], ends, whole)

    def over(self, other: Sketch, matches: Mapping[str, Array]) -> None:
        """Draw matched lines and planes where those of another model are that lie under them."""
        for kind, own, others in (("line", self.segments, other.segments), ("plane", self.patches, other.patches)):
            rows = matches.get(kind, np.empty(0, np.int64))
            hit = rows >= 0
            if hit.any() and own.shape[1] == others.shape[1]:
                own[hit] = _foot(kind, self.model.parameters[kind][hit, None], others[rows[hit]])

    @cached_property
    def patches(self) -> Array:
        """Polygons (n, m, 3) of planes."""
        rows = self.model.parameters.get("plane", np.empty((0, 4)))
        normal, offset = rows[:, :3], rows[:, 3]
        center, half = _places(normal, offset, self.segments, self.box)
        u, v = shapes.across(normal)
        sides = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * half[:, None, None]
        squares = center[:, None] + sides[..., :1] * u[:, None] + sides[..., 1:] * v[:, None]
        if len(rows) > WHOLE_PLANES:
            return squares
        cut = shapes.planes_in(self.box, normal, offset)
        squares = np.concatenate([squares, np.repeat(squares[:, :1], cut.shape[1] - 4, 1)], 1)
        missed = ~np.asarray(np.isfinite(cut).all((1, 2)), bool)
        return np.where(missed[:, None, None], squares, cut)

    def parts(self, colors: dict[str, Rgba]) -> Iterator[Strokes | Faces | Marks]:
        """What is drawn, in colours (1 or n, 4) by kind."""
        everywhere = Box(self.box.low - 1e3 * self.box.size, self.box.high + 1e3 * self.box.size)
        for group in self._groups():
            rows = colors[group.sort]
            if group.sort == "line":
                yield Strokes(self.segments, rows)
            elif group.sort == "plane":
                opacity = PLANE_OPACITY * min(1.0, MANY_PLANES_OPACITY / len(group.places) ** 0.5)
                yield Strokes(np.concatenate([self.patches, self.patches[:, :1]], 1), faded(rows, 0.7), 0.6)
                yield Faces(self.patches, faded(rows, opacity))
            else:
                shown = Drawable(group, chosen(rows, group.places))
                yield from shown.outline(everywhere)


def _foot(kind: str, rows: Array, x: Array) -> Array:
    """The positions on lines or planes (n, 1, k) that are nearest to others (n, m, 3)."""
    if kind == "plane":
        normal, offset = rows[..., :3], rows[..., 3:]
        return np.asarray(x - ((x * normal).sum(-1, keepdims=True) - offset) * normal)
    point, direction = rows[..., :3], rows[..., 3:]
    return np.asarray(point + ((x - point) * direction).sum(-1, keepdims=True) * direction)


def _spans(point: Array, direction: Array, center: Array, radius: float) -> tuple[Array, Array, Array]:
    """From where to where along each line those that come nearest to it pass it, and the middle one of them.

    What passes outside the ball does not count; NaN where fewer than two are left.
    """
    others = np.arange(0, len(point), max(1, -(-len(point) // MOST)))
    found = np.full((3, len(point)), np.nan)
    size = max(1, MOST * MOST // max(len(others), 1))
    for begin in range(0, len(point), size):
        part = slice(begin, begin + size)
        p, d = point[part, None], direction[part, None]
        w, b = p - point[others], (d * direction[others]).sum(-1)
        sine = 1 - b * b
        passes = sine > LEAST_SINE
        sine = np.where(passes, sine, 1.0)
        t = (b * (w * direction[others]).sum(-1) - (w * d).sum(-1)) / sine
        apart = np.abs((w * np.cross(d, direction[others])).sum(-1)) / np.sqrt(sine)
        passes &= np.linalg.norm(p + t[..., None] * d - center, axis=-1) <= radius
        apart[~passes] = np.inf
        nearest = np.argsort(apart, axis=1, kind="stable")[:, :NEIGHBOURS]
        t, passes = (np.take_along_axis(x, nearest, 1) for x in (t, passes))
        several = passes.sum(1) >= 2
        found[:, part][:, several] = np.nanquantile(np.where(passes, t, np.nan)[several], (0, 0.5, 1), axis=1)
    low, middle, high = found
    return low, middle, high


def _places(normal: Array, offset: Array, segments: Array, box: Box) -> tuple[Array, Array]:
    """Middles (n, 3) and half sides (n,) of patches: where the lines in a plane are, or nearest to the box's middle."""
    center = box.center - ((normal @ box.center) - offset)[:, None] * normal
    half = np.full(len(normal), PATCH * box.size)
    if not len(segments) or not len(normal) or len(segments) * len(normal) > MOST_PAIRS:
        return center, half
    middle, along = segments.mean(1), shapes.unit(segments[:, 1] - segments[:, 0])
    inside = np.abs(normal @ middle.T - offset[:, None]) <= IN_PLANE * box.size
    inside &= np.abs(normal @ along.T) <= ALONG_PLANE
    count = inside.sum(1)
    known = count >= 2
    weight = inside[known] / count[known, None]
    center[known] = weight @ middle
    ends = np.linalg.norm(segments[None] - center[known][:, None, None], axis=-1).max(-1)
    half[known] = (weight * ends).sum(1) / np.sqrt(2)
    half = np.clip(half, LEAST_PATCH * box.size, MOST_PATCH * box.size / len(normal) ** 0.5)
    return center, half
