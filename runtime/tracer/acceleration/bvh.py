"""Bounding volume hierarchy over the boxes of a scene's rows, in the driver's layout; built by the compiled program.

Rows without a finite box (planes, surfaces of circles that open into lines) stay outside: every ray is tested on them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.programs.tracer.records import NO_PART, PARTS
from ..rendering.engines import Engine

Array = NDArray[Any]
#: The driver numbers items and nodes with 32 bits.
MOST_ITEMS = 2**31 - 2
#: Largest absolute exponent of a tree's unit: boxes are stored in 32 bits whatever their size.
MOST_EXPONENT = 1000
#: A node in the driver's layout: a whole number of cache lines.
NODE = np.dtype([("boxes", np.float32, (6, PARTS)), ("parts", np.int32, PARTS), ("unused", np.int32, 4)])
#: Bytes of a line of the processor's cache.
CACHE_LINE = 64


@dataclass(frozen=True, eq=False)
class Tree:
    """A bounding volume hierarchy.

    Attributes
    ----------
    boxes : (nodes, 6, 4) array
        Sides of the parts of each node: low x, y, z, high x, y, z.
    parts : (nodes, 4) array of int32
    items : (n, 2) array of int32
        Index of the kind, among those that the tree was built for, and row.
    unbounded : int
        Index of the first item without a box; all items from here on have none.
    """

    boxes: Array
    parts: Array
    items: Array
    unbounded: int

    @cached_property
    def whole(self) -> Array:
        """Low and high corner of all boxes (6,)."""
        corners = self.boxes[0][:, self.parts[0] != NO_PART] if len(self.parts) else np.zeros((6, 1))
        return np.concatenate([corners[:3].min(axis=1), corners[3:].max(axis=1)])

    @cached_property
    def center(self) -> Array:
        """Center of the box around everything (3,)."""
        return 0.5 * self.whole[:3] + 0.5 * self.whole[3:]

    @cached_property
    def unit(self) -> float:
        """Power of two that scales the box around everything, about its center, to sizes up to 1."""
        half = np.max(0.5 * self.whole[3:] - 0.5 * self.whole[:3])
        exponent = math.frexp(float(half) or float(np.abs(self.whole).max()))[1]
        return math.ldexp(1.0, min(max(-exponent, -MOST_EXPONENT), MOST_EXPONENT))

    @property
    def packed(self) -> Array:
        """The tree as C reads it, in integers of 64 bits: a head as long as a node, and the nodes of type `NODE`.

        Boxes are in 32 bits, rounded outward, and inverted for missing parts.
        """
        packed = np.zeros(len(self.parts) + 1, NODE)
        packed[:1].view(np.float64)[:10] = [*self.whole, *self.center, self.unit]
        nodes = packed[1:]
        shift = np.concatenate([self.center, self.center])[:, None]
        nodes["boxes"] = round_outward((self.boxes - shift) * self.unit, np.float32)
        nodes["parts"] = self.parts
        nothing = np.repeat([np.inf, -np.inf], 3)[:, None]
        nodes["boxes"] = np.where((self.parts == NO_PART)[:, None], nothing, nodes["boxes"])
        return packed.view(np.int64)


def tree_over(engine: Engine, boxes: Sequence[Array]) -> Tree:
    """Build the tree over the boxes (rows, 6) of several kinds."""
    counts = [len(part) for part in boxes]
    every = np.concatenate([*boxes, np.empty((0, 6))])
    items = np.empty((len(every), 2), np.int32)
    items[:, 0] = np.repeat(np.arange(len(boxes)), counts)
    items[:, 1] = np.concatenate([*(np.arange(n) for n in counts), np.empty(0, int)])
    bounded = np.isfinite(every).all(axis=1)
    finite = np.ascontiguousarray(every[bounded])
    nodes, parts = _build_nodes(engine, finite)
    ordered = np.concatenate([items[bounded], items[~bounded]])
    return Tree(nodes, parts, ordered, len(finite))


def _build_nodes(engine: Engine, boxes: Array) -> tuple[Array, Array]:
    """Boxes and parts of the nodes; the given boxes are exchanged. Memory that is not touched costs nothing."""
    count = len(boxes)
    nodes, parts = np.empty((count, 6, PARTS)), np.empty((count, PARTS), np.int32)
    numbers = np.empty(count, np.int64)
    if not count or count > MOST_ITEMS:
        return nodes[:0], parts[:0]
    node_count = engine.build_tree(boxes, numbers, nodes, parts)
    return nodes[:node_count].copy(), parts[:node_count].copy()


def round_outward(boxes: Array, dtype: Any) -> Array:
    """Round boxes (..., 6, n) to another precision so that they contain the given ones."""
    if np.dtype(dtype) == boxes.dtype:
        return boxes
    with np.errstate(over="ignore"):
        near = boxes.astype(dtype)
    low, high = near[..., :3, :], near[..., 3:, :]
    low[...] = np.where(low > boxes[..., :3, :], np.nextafter(low, dtype(-np.inf)), low)
    high[...] = np.where(high < boxes[..., 3:, :], np.nextafter(high, dtype(np.inf)), high)
    return near
