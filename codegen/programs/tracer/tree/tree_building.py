"""The tree over boxes, made once for a scene (surface area heuristic; Wald 2007 bins the centres as here).

Items are parted where the least work of rays is expected; far down, and where all centres are one, in halves. The four
parts of a node come of three such cuts, the largest part being cut first. Items are moved, boxes and all: what is read
together lies together.
"""

from __future__ import annotations

from typing import Any

from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined
from ....ir.loops.language import (
    INFINITY,
    Bool,
    InOut,
    Int,
    IntRows,
    Ints,
    Ints32,
    Out,
    Real,
    Rows,
    Vector,
    empty,
    int_empty,
)  # fmt: skip
from ....ir.loops.records import record
from ..records import LEVELS, NO_PART, PARTS

#: Places along an axis where items may be parted.
BINS = 16
#: Items that are sorted, and may be parted between any two.
FEW = 12
#: Below, parts are quarters: no tree of 2^31 items is deeper than `LEVELS`.
HEURISTIC_LEVELS = 28
#: Ranges that wait at most: all but one of each level's.
WAITING = LEVELS * (PARTS - 1) + 1

#: Low and high corner of some boxes, and of the boxes' centres.
EXTENT: Any = record("Extent", box=Vector[6], centers=Vector[6])
#: A range: its first item, and their number; of one that waits the node that it becomes, and how deep it is.
FIRST, ITEMS, NODE, LEVEL = range(4)


@inlined
def clear(extent: Out[EXTENT]) -> None:
    """The extent of no items."""
    for i in range(3):
        extent.box[i] = INFINITY
        extent.centers[i] = INFINITY
        extent.box[3 + i] = -INFINITY
        extent.centers[3 + i] = -INFINITY


@inlined
def center(box: Vector[6], axis: Int) -> Real:
    """Coordinate of a box's centre."""
    return 0.5 * box[axis] + 0.5 * box[3 + axis]


@inlined
def add_item(extent: InOut[EXTENT], box: Vector[6]) -> None:
    """Enlarge an extent by an item."""
    for i in range(3):
        middle = center(box, i)
        extent.box[i] = min(extent.box[i], box[i])
        extent.box[3 + i] = max(extent.box[3 + i], box[3 + i])
        extent.centers[i] = min(extent.centers[i], middle)
        extent.centers[3 + i] = max(extent.centers[3 + i], middle)


@inlined
def add_extent(extent: InOut[EXTENT], other: EXTENT) -> None:
    """Enlarge an extent by another."""
    for i in range(3):
        extent.box[i] = min(extent.box[i], other.box[i])
        extent.box[3 + i] = max(extent.box[3 + i], other.box[3 + i])
        extent.centers[i] = min(extent.centers[i], other.centers[i])
        extent.centers[3 + i] = max(extent.centers[3 + i], other.centers[3 + i])


@inlined
def half_area(box: Vector[6]) -> Real:
    """Half the surface of a box."""
    x = box[3] - box[0]
    y = box[4] - box[1]
    z = box[5] - box[2]
    return x * y + y * z + z * x


@inlined
def expected_work(extent: EXTENT, items: Int) -> Real:
    """Work of rays on some items, in nodes, which cost the same with any number of parts.

    Infinite for none, so that no part is empty.
    """
    nodes = (items + PARTS - 1) // PARTS
    area = half_area(extent.box)
    return float(nodes) * area if nodes > 0 else INFINITY


@algorithm
def best_cut(row: Rows[EXTENT], counts: Ints, count: Int, low: InOut[EXTENT], high: InOut[EXTENT]) -> tuple[Int, Int]:
    """The place in a row of extents before which the least work is expected of both parts, and the items before it.

    0, and nothing in the parts, where no work is less than infinite.
    """
    after = empty(BINS)
    extent = empty(EXTENT)
    clear(extent)
    items = 0
    for b in range(count - 1, 0, -1):
        add_extent(extent, row[b])
        items += counts[b]
        after[b] = expected_work(extent, items)
    clear(extent)
    items = 0
    least = INFINITY
    best = 0
    before = 0
    for b in range(1, count):
        add_extent(extent, row[b - 1])
        items += counts[b - 1]
        work = expected_work(extent, items) + after[b]
        if work < least:
            least = work
            best = b
            before = items
            low[:] = extent
    clear(high)
    for b in range(best, count):
        add_extent(high, row[b])
    return best, before


@algorithm
def cut_few(
    boxes: InOut[Rows[6]], numbers: InOut[Ints], first: Int, items: Int, axis: Int, low: InOut[EXTENT],
    high: InOut[EXTENT],
) -> tuple[Int, Int]:  # fmt: skip
    """Part a few items between any two of them, in the order of their centres; see `best_cut`."""
    row = empty(FEW, EXTENT)
    counts = int_empty(FEW)
    box = empty(6)
    for i in range(first + 1, first + items):
        box[:] = boxes[i]
        number = numbers[i]
        middle = center(box, axis)
        place = i
        while place > first:
            if not center(boxes[place - 1], axis) > middle:
                break
            for k in range(6):
                boxes[place, k] = boxes[place - 1, k]
            numbers[place] = numbers[place - 1]
            place -= 1
        boxes[place][:] = box
        numbers[place] = number
    for i in range(items):
        clear(row[i])
        add_item(row[i], boxes[first + i])
        counts[i] = 1
    best, before = best_cut(row, counts, items, low, high)
    return best, before


@inlined
def bin_of(box: Vector[6], axis: Int, start: Real, scale: Real) -> Int:
    """The bin of an item."""
    found = int((center(box, axis) - start) * scale)
    return 0 if found < 0 else (found if found < BINS else BINS - 1)


@algorithm
def cut_many(
    boxes: InOut[Rows[6]], numbers: InOut[Ints], first: Int, items: Int, axis: Int, start: Real, length: Real,
    low: InOut[EXTENT], high: InOut[EXTENT],
) -> tuple[Int, Int]:  # fmt: skip
    """Part items at one of a few places along an axis; see `best_cut`."""
    scale = float(BINS) / length
    bins = empty(BINS, EXTENT)
    counts = int_empty(BINS)
    if not (scale > 0.0 and scale < INFINITY):
        return 0, 0
    for b in range(BINS):
        clear(bins[b])
        counts[b] = 0
    for i in range(first, first + items):
        found = bin_of(boxes[i], axis, start, scale)
        add_item(bins[found], boxes[i])
        counts[found] += 1
    cut, before = best_cut(bins, counts, BINS, low, high)
    if cut == 0:
        return 0, 0
    i_low = first
    i_high = first + items
    box = empty(6)
    while True:
        while i_low < i_high:
            if bin_of(boxes[i_low], axis, start, scale) >= cut:
                break
            i_low += 1
        while i_low < i_high:
            if bin_of(boxes[i_high - 1], axis, start, scale) < cut:
                break
            i_high -= 1
        if i_low >= i_high:
            return cut, before
        i_high -= 1
        box[:] = boxes[i_low]
        for k in range(6):
            boxes[i_low, k] = boxes[i_high, k]
        boxes[i_high][:] = box
        numbers[i_low], numbers[i_high] = numbers[i_high], numbers[i_low]
        i_low += 1


@algorithm
def cut_range(
    boxes: InOut[Rows[6]], numbers: InOut[Ints], first: Int, items: Int, is_halved: Bool, extent: EXTENT,
    low: InOut[EXTENT], high: InOut[EXTENT],
) -> Int:  # fmt: skip
    """Part a range in two; the items of the first part. Both have some."""
    axis = 0
    for i in range(1, 3):
        if extent.centers[3 + i] - extent.centers[i] > extent.centers[3 + axis] - extent.centers[axis]:
            axis = i
    cut = 0
    before = 0
    if not is_halved:
        if items <= FEW:
            cut, before = cut_few(boxes, numbers, first, items, axis, low, high)
        else:
            start = extent.centers[axis]
            length = extent.centers[3 + axis] - start
            cut, before = cut_many(boxes, numbers, first, items, axis, start, length, low, high)
    if cut == 0:
        before = items // 2
        clear(low)
        clear(high)
        for i in range(items):
            if i < before:
                add_item(low, boxes[first + i])
            else:
                add_item(high, boxes[first + i])
    return before


@algorithm
def part_range(
    boxes: InOut[Rows[6]], numbers: InOut[Ints], is_halved: Bool, extents: InOut[Rows[EXTENT]],
    ranges: InOut[IntRows[2]],
) -> Int:  # fmt: skip
    """Up to four parts of a range, which is the first at the start; their number."""
    whole = empty(EXTENT)
    found = 1
    while found < PARTS:
        chosen = -1
        most = -1.0
        for i in range(found):
            items = ranges[i, ITEMS]
            area = half_area(extents[i].box)
            size = float(items) * (1.0 if is_halved else area)
            if not is_halved and not area < INFINITY:
                size = float(items)
            if items > 1 and size > most:
                most = size
                chosen = i
        if chosen < 0:
            return found
        first = ranges[chosen, FIRST]
        count = ranges[chosen, ITEMS]
        whole[:] = extents[chosen]
        before = cut_range(boxes, numbers, first, count, is_halved, whole, extents[chosen], extents[found])
        ranges[chosen, ITEMS] = before
        ranges[found, FIRST] = first + before
        ranges[found, ITEMS] = count - before
        found += 1
    return found


@algorithm
def build_tree(boxes: InOut[Rows[6]], numbers: InOut[Ints], nodes: InOut[Rows[6 * PARTS]], parts: InOut[Ints32]) -> Int:
    """The tree over boxes, nodes in the order in which they were made, their root first; the number of nodes.

    Sides of the parts of a node: low x, y, z, high x, y, z of each. ``boxes`` are exchanged, and ``numbers`` with them;
    there must be room for as many nodes as there are boxes.
    """
    waiting = int_empty(WAITING, 4)
    extents_waiting = empty(WAITING, EXTENT)
    extents = empty(PARTS, EXTENT)
    ranges = int_empty(PARTS, 2)
    count = len(boxes)
    if count < 1:
        return 0
    clear(extents_waiting[0])
    for i in range(count):
        numbers[i] = i
        add_item(extents_waiting[0], boxes[i])
    waiting[0][:] = (0, count, 0, 0)
    unbuilt = 1
    built = 1
    while unbuilt > 0:
        unbuilt -= 1
        first = waiting[unbuilt, FIRST]
        items = waiting[unbuilt, ITEMS]
        node = waiting[unbuilt, NODE]
        level = waiting[unbuilt, LEVEL]
        found = items
        if items <= PARTS:
            for c in range(items):
                clear(extents[c])
                add_item(extents[c], boxes[first + c])
                ranges[c, FIRST] = first + c
                ranges[c, ITEMS] = 1
        else:
            extents[0][:] = extents_waiting[unbuilt]
            ranges[0, FIRST] = first
            ranges[0, ITEMS] = items
            found = part_range(boxes, numbers, level >= HEURISTIC_LEVELS, extents, ranges)
        for c in range(PARTS):
            inside = ranges[c, ITEMS] if c < found else 0
            for k in range(6):
                nodes[node, PARTS * k + c] = extents[c, k] if inside > 0 else 0.0
            if inside == 0:
                parts[PARTS * node + c] = NO_PART
            elif inside == 1:
                parts[PARTS * node + c] = -1 - numbers[ranges[c, FIRST]]
            else:
                parts[PARTS * node + c] = built
                waiting[unbuilt][:] = (ranges[c, FIRST], inside, built, level + 1)
                extents_waiting[unbuilt][:] = extents[c]
                unbuilt += 1
                built += 1
    return built
