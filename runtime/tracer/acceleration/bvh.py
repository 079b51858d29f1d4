"""The tree over the boxes of a scene's rows, as the driver reads it; built by the compiled program.

Rows without a finite box (planes, surfaces of circles that open into lines) are no part of it: they are always asked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .engine import Engine

Array = NDArray[Any]
#: Parts of a node, as in templates/c/scene_common.h.
PARTS = 4
#: Numbers of 64 bits that the builder keeps for an item: a box and its place.
ITEM_SIZE = 7
#: The driver numbers items and nodes with 32 bits.
MOST_ITEMS = 2**31 - 2
#: What stands where a node has no part, as in templates/c/scene_common.h.
NO_PART = -(2**31)
#: Exponents of a tree's unit: its boxes are numbers of 32 bits whatever its size.
MOST_EXPONENT = 1000
#: A node as the driver reads it, in lines of the processor's cache.
NODE = np.dtype([("boxes", np.float32, (6, PARTS)), ("parts", np.int32, PARTS), ("unused", np.int32, 4)])
CACHE_LINE = 64


@dataclass(frozen=True, eq=False)
class Tree:
    """A tree over boxes.

    Attributes
    ----------
    boxes : (nodes, 6, 4) array
        Sides of the parts of each node: low x, y, z, high x, y, z.
    parts : (nodes, 4) array of int32
    items : (n, 2) array of int32
        Number of the kind, among those that the tree was built for, and row.
    loose : int
        Items from here on have no box.
    """

    boxes: Array
    parts: Array
    items: Array
    loose: int

    @cached_property
    def whole(self) -> Array:
        """Low and high corner of all boxes (6,)."""
        corners = self.boxes[0][:, self.parts[0] != NO_PART] if len(self.parts) else np.zeros((6, 1))
        return np.concatenate([corners[:3].min(axis=1), corners[3:].max(axis=1)])

    @cached_property
    def center(self) -> Array:
        """Middle of the whole (3,)."""
        return 0.5 * self.whole[:3] + 0.5 * self.whole[3:]

    @cached_property
    def unit(self) -> float:
        """A power of two that takes the whole, seen from its centre, to sizes up to 1."""
        half = np.max(0.5 * self.whole[3:] - 0.5 * self.whole[:3])
        exponent = math.frexp(float(half) or float(np.abs(self.whole).max()))[1]
        return math.ldexp(1.0, min(max(-exponent, -MOST_EXPONENT), MOST_EXPONENT))

    @cached_property
    def nodes(self) -> Array:
        """All nodes (nodes,) of type `NODE`: boxes of 32 bits about the given ones, inside out where there are none."""
        room = np.zeros(len(self.parts) * NODE.itemsize + CACHE_LINE, np.uint8)
        found = room[-room.ctypes.data % CACHE_LINE :][: len(self.parts) * NODE.itemsize].view(NODE)
        shift = np.concatenate([self.center, self.center])[:, None]
        found["boxes"] = outward((self.boxes - shift) * self.unit, np.float32)
        found["parts"] = self.parts
        nothing = np.repeat([np.inf, -np.inf], 3)[:, None]
        found["boxes"] = np.where((self.parts == NO_PART)[:, None], nothing, found["boxes"])
        return found


def tree_over(engine: Engine, boxes: Sequence[Array]) -> Tree:
    """The tree over the boxes (rows, 6) of several kinds."""
    counts = [len(part) for part in boxes]
    every = np.concatenate([*boxes, np.empty((0, 6))])
    items = np.empty((len(every), 2), np.int32)
    items[:, 0] = np.repeat(np.arange(len(boxes)), counts)
    items[:, 1] = np.concatenate([*(np.arange(n) for n in counts), np.empty(0, int)])
    bounded = np.isfinite(every).all(axis=1)
    finite = np.ascontiguousarray(every[bounded])
    nodes, parts = _built(engine, finite)
    ordered = np.concatenate([items[bounded], items[~bounded]])
    return Tree(nodes, parts, ordered, len(finite))


def _built(engine: Engine, boxes: Array) -> tuple[Array, Array]:
    """Boxes and parts of the nodes. Room that the builder does not touch costs nothing."""
    count = len(boxes)
    nodes, parts = np.empty((count, 6, PARTS)), np.empty((count, PARTS), np.int32)
    room = np.empty((count, ITEM_SIZE))
    if not count or count > MOST_ITEMS:
        return nodes[:0], parts[:0]
    buffer = engine.ffi.from_buffer
    numbers = [buffer("double[]", x) for x in (boxes, nodes)]
    made = engine.lib.bs_scene_build(count, *numbers, buffer("int32_t[]", parts), buffer("double[]", room))
    return nodes[:made].copy(), parts[:made].copy()


def outward(boxes: Array, dtype: Any) -> Array:
    """Boxes (..., 6, n) of another precision that hold the given ones."""
    if np.dtype(dtype) == boxes.dtype:
        return boxes
    with np.errstate(over="ignore"):
        near = boxes.astype(dtype)
    low, high = near[..., :3, :], near[..., 3:, :]
    low[...] = np.where(low > boxes[..., :3, :], np.nextafter(low, dtype(-np.inf)), low)
    high[...] = np.where(high < boxes[..., 3:, :], np.nextafter(high, dtype(np.inf)), high)
    return near


__all__ = ["Tree", "outward", "tree_over"]
