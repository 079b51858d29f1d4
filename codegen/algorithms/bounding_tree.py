"""A balanced tree of boxes over the landmarks of objects, which is kept up while objects move and go.

Objects are in slots. The tree stands over those that lived when it was built: the root is node 1, node n has the
children 2 n and 2 n + 1, and the last level are the leaves. Landmarks are also kept in the order of the leaves: what
is read together lies together.
"""

from __future__ import annotations

from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.language import INFINITY, InOut, Int, IntRows, Ints, IntVector, Matrix, Out, Real, Vector, int_zeros
from .merging_bounds import NOISE, widest
from .merging_layout import (
    ALIVE,
    BEGIN,
    BUILT,
    DEEPEST,
    DIRECTION,
    END,
    LEAF,
    LEAF_SIZE,
    LEAVES,
    NODE,
    PLACE,
    SLOT,
    VERSION,
)


@algorithm
def fill_box(box: Out[Vector], begin: Int, end: Int, order: Ints, leaves: Matrix) -> None:
    """Least and greatest landmark of some places of the tree; of none: infinite and minus infinite."""
    marks = len(leaves[0])
    for i in range(marks):
        box[i] = INFINITY
        box[marks + i] = -INFINITY
    for place in range(begin, end):
        if order[place] < 0:
            continue
        x = leaves[place]
        for i in range(marks):
            box[i] = min(box[i], x[i])
            box[marks + i] = max(box[marks + i], x[i])


@algorithm
def part_at(middle: Int, begin: Int, end: Int, axis: Int, landmarks: Matrix, order: InOut[Ints]) -> None:
    """Part some places so that what comes before the middle along an axis stands before it (Hoare's FIND)."""
    low = begin
    high = end - 1
    while low < high:
        pivot = order[low + (high - low) // 2]
        x = landmarks[pivot, axis]
        i = low
        j = high
        while i <= j:
            while landmarks[order[i], axis] < x or (landmarks[order[i], axis] == x and order[i] < pivot):
                i += 1
            while x < landmarks[order[j], axis] or (x == landmarks[order[j], axis] and pivot < order[j]):
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return


@algorithm
def build_tree(
    tree: InOut[IntVector[2]], landmarks: Matrix, slots: InOut[IntRows[SLOT]], order: InOut[Ints], leaves:
    InOut[Matrix], nodes: InOut[IntRows[NODE]], boxes: InOut[Matrix],
) -> Real:  # fmt: skip
    """The tree over all objects that are left; the rounding of their positions, as a length."""
    built = 0
    size = 0.0
    for slot in range(len(slots)):
        if slots[slot, VERSION] < 0:
            continue
        order[built] = slot
        built += 1
        for i in range(DIRECTION):
            size = max(size, abs(landmarks[slot, i]))
    first_leaf = 1
    while built // first_leaf > LEAF_SIZE:
        first_leaf *= 2
    tree[BUILT], tree[LEAVES] = built, first_leaf
    marks = len(landmarks[0])
    nodes[1, BEGIN], nodes[1, END] = 0, built
    waiting = int_zeros(DEEPEST)
    waiting[0] = 1
    depth = 1
    while depth > 0:
        depth -= 1
        node = waiting[depth]
        begin, end = nodes[node, BEGIN], nodes[node, END]
        for place in range(begin, end):
            leaves[place][:] = landmarks[order[place]]
        fill_box(boxes[node], begin, end, order, leaves)
        nodes[node, ALIVE] = end - begin
        if node >= first_leaf:
            for place in range(begin, end):
                slots[order[place], PLACE], slots[order[place], LEAF] = place, node
            continue
        first = 1  # of the level
        while 2 * first <= node:
            first *= 2
        middle = built * (2 * (node - first) + 1) // (2 * first)
        part_at(middle, begin, end, widest(boxes[node][:marks], boxes[node][marks:]), landmarks, order)
        nodes[2 * node, BEGIN], nodes[2 * node, END] = begin, middle
        nodes[2 * node + 1, BEGIN], nodes[2 * node + 1, END] = middle, end
        waiting[depth], waiting[depth + 1] = 2 * node + 1, 2 * node
        depth += 2
    return NOISE * size


@algorithm
def refit(
    slot: Int, change: Int, landmarks: Matrix, slots: IntRows[SLOT], order: InOut[Ints], leaves: InOut[Matrix], nodes:
    InOut[IntRows[NODE]], boxes: InOut[Matrix],
) -> None:  # fmt: skip
    """Draw the boxes anew from an object's leaf to the root: it has moved (change 0), or gone (-1)."""
    place = slots[slot, PLACE]
    node = slots[slot, LEAF]
    if change < 0:
        order[place] = -1
    else:
        leaves[place][:] = landmarks[slot]
    fill_box(boxes[node], nodes[node, BEGIN], nodes[node, END], order, leaves)
    nodes[node, ALIVE] += change
    node //= 2
    marks = len(landmarks[0])
    while node > 0:
        box = boxes[node]
        one = boxes[2 * node]
        other = boxes[2 * node + 1]
        nodes[node, ALIVE] += change
        for i in range(marks):  # empty boxes are infinite and minus infinite
            box[i] = min(other[i], one[i])
            box[marks + i] = max(other[marks + i], one[marks + i])
        node //= 2
