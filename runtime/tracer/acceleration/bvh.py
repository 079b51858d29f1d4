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

from ..rendering.program import Engine

Array = NDArray[Any]
#: Parts of a node, as in templates/c/programs/tracer/scene_common.h.
PARTS = 4
#: Numbers of 64 bits that the builder stores for an item: a box and its index.
ITEM_SIZE = 7
#: The driver numbers items and nodes with 32 bits.
MOST_ITEMS = 2**31 - 2
#: Index of a missing part of a node, as in templates/c/programs/tracer/scene_common.h.
NO_PART = -(2**31)
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

    @cached_property
    def nodes(self) -> Array:
        """All nodes (nodes,) of type `NODE`: boxes in 32 bits, rounded outward, inverted for missing parts."""
        memory = np.zeros(len(self.parts) * NODE.itemsize + CACHE_LINE, np.uint8)
        nodes = memory[-memory.ctypes.data % CACHE_LINE :][: len(self.parts) * NODE.itemsize].view(NODE)
        shift = np.concatenate([self.center, self.center])[:, None]
        nodes["boxes"] = round_outward((self.boxes - shift) * self.unit, np.float32)
        nodes["parts"] = self.parts
        nothing = np.repeat([np.inf, -np.inf], 3)[:, None]
        nodes["boxes"] = np.where((self.parts == NO_PART)[:, None], nothing, nodes["boxes"])
        return nodes


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
    """Boxes and parts of the nodes. Memory that the builder does not touch costs nothing."""
    count = len(boxes)
    nodes, parts = np.empty((count, 6, PARTS)), np.empty((count, PARTS), np.int32)
    scratch = np.empty((count, ITEM_SIZE))
    if not count or count > MOST_ITEMS:
        return nodes[:0], parts[:0]
    buffer = engine.ffi.from_buffer
    numbers = [buffer("double[]", x) for x in (boxes, nodes)]
    node_count = engine.lib.bs_scene_build(count, *numbers, buffer("int32_t[]", parts), buffer("double[]", scratch))
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
