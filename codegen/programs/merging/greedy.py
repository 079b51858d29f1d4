"""Greedy merging of the cheapest pair, exactly, with a tree and a queue.

Every object keeps its nearest other one of the time when it was last looked for. For each pair that lives, the younger
of the two looked while the other was there; so the least cost in the queue is the least of all pairs, or is one whose
other object has gone or changed since, which then looks again. The mean looks for itself when it is made.

A mean takes the slot of the first of its two objects. ``align``: objects have no orientation, X and -X are one.
"""

from __future__ import annotations

from ...algorithms.bounding_tree import build_tree, refit
from ...algorithms.cost_queue import leave, settle
from ...algorithms.merging_bounds import least_cost, rounding_cost
from ...algorithms.merging_layout import (
    ALIVE,
    BEGIN,
    BUILT,
    COUNTS,
    DEEPEST,
    END,
    EVALUATIONS,
    LEAF,
    LEAVES,
    LIVE,
    MERGES,
    NEAREST,
    NODE,
    QUEUED,
    SEEN,
    SLACK,
    SLOT,
    THRESHOLD,
    VERSION,
    WAITING,
)  # fmt: skip
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import (
    INFINITY,
    Bool,
    InOut,
    Int,
    IntRows,
    Ints,
    IntVector,
    Matrix,
    Out,
    Real,
    Reals,
    Static,
    Vector,
    empty,
    int_zeros,
    zeros,
)  # fmt: skip
from .kinds import KINDS

#: The tree is built anew when this share of its objects is left.
REBUILD = 4


@algorithm
def turn(kind: Static, align: Bool, turned: Out[Vector], first: Vector, second: Vector) -> None:
    """The second of two objects, turned like the first where objects have no orientation."""
    if align:
        turned[:] = KINDS[kind].align(second, first)
    else:
        turned[:] = second


# -- the nearest object --------------------------------------------------------------------------------------------


@algorithm
def visit_leaf(
    kind: Static, align: Bool, slot: Int, begin: Int, end: Int, enough: Real, nearest: Int, least: Real, slack: Real,
    rows: Matrix, weights: Reals, landmarks: Matrix, order: Ints, leaves: Matrix,
) -> tuple[Int, Real, Int]:  # fmt: skip
    """The nearest object when some places of the tree have been looked at, too; its cost, and costs computed."""
    evaluations = 0
    own = landmarks[slot]
    turned = empty(len(rows[0]))
    for place in range(begin, end):
        other = order[place]
        if other < 0 or other == slot:
            continue
        if least_cost(own, leaves[place], leaves[place], slack) > least:
            continue
        first = min(slot, other)  # the same cost for both orders
        second = max(slot, other)
        turn(kind, align, turned, rows[first], rows[second])
        cost = KINDS[kind].cost(rows[first], turned)
        evaluations += 1
        if not (cost < least or (cost == least and (nearest < 0 or other < nearest))):
            continue
        mean, status = KINDS[kind].mean(rows[first], turned, weights[first], weights[second])
        if status != 0.0:
            continue
        least = cost
        nearest = other
        if cost <= enough:
            break
    return nearest, least, evaluations


@algorithm
def find_nearest(
    kind: Static, align: Bool, slot: Int, limits: Vector[2], tree: IntVector[2], rows: Matrix, weights: Reals,
    landmarks: Matrix, slots: IntRows[SLOT], order: Ints, leaves: Matrix, nodes: IntRows[NODE], boxes: Matrix,
) -> tuple[Int, Real, Int]:  # fmt: skip
    """The other object of least cost within the threshold, of equal ones that of the lowest slot; costs computed.

    Among copies of one object any serves: the first that cannot be told from it ends the search, or n copies would
    cost n^2; and each looks at home first, or one would be the neighbour of all.
    """
    own = landmarks[slot]
    marks = len(own)
    enough = rounding_cost(own)
    slack = limits[SLACK]
    nearest = -1
    least = limits[THRESHOLD]
    evaluations = 0
    waiting = int_zeros(DEEPEST)
    bounds = zeros(DEEPEST)
    waiting[0] = 1
    depth = 1
    while depth > 0 and not (nearest >= 0 and least <= enough):
        depth -= 1
        node = waiting[depth]
        if bounds[depth] > least:
            continue
        if node >= tree[LEAVES]:
            nearest, least, count = visit_leaf(
                kind, align, slot, nodes[node, BEGIN], nodes[node, END], enough, nearest, least, slack, rows, weights,
                landmarks, order, leaves,
            )  # fmt: skip
            evaluations += count
            continue
        left = 2 * node
        right = 2 * node + 1
        left_bound = INFINITY
        right_bound = INFINITY
        if nodes[left, ALIVE] > 0:
            left_bound = least_cost(own, boxes[left][:marks], boxes[left][marks:], slack)
        if nodes[right, ALIVE] > 0:
            right_bound = least_cost(own, boxes[right][:marks], boxes[right][marks:], slack)
        is_left_near = left_bound < right_bound
        if left_bound == right_bound:
            home = slots[slot, LEAF]  # and what is above it on the level of the children
            while home > right:
                home //= 2
            is_left_near = home != right
        near, near_bound, far, far_bound = right, right_bound, left, left_bound
        if is_left_near:
            near, near_bound, far, far_bound = left, left_bound, right, right_bound
        if nodes[far, ALIVE] > 0 and far_bound <= least:
            waiting[depth], bounds[depth] = far, far_bound
            depth += 1
        if nodes[near, ALIVE] > 0 and near_bound <= least:
            waiting[depth], bounds[depth] = near, near_bound
            depth += 1
    return nearest, least, evaluations


@algorithm
def look(
    kind: Static, align: Bool, slot: Int, limits: Vector[2], tree: IntVector[2], rows: Matrix, weights: Reals,
    landmarks: Matrix, slots: InOut[IntRows[SLOT]], costs: InOut[Reals], order: Ints, leaves: Matrix, nodes:
    IntRows[NODE], boxes: Matrix,
) -> Int:  # fmt: skip
    """Note a slot's nearest object; costs that were computed."""
    nearest, cost, evaluations = find_nearest(
        kind, align, slot, limits, tree, rows, weights, landmarks, slots, order, leaves, nodes, boxes
    )
    slots[slot, NEAREST] = nearest
    slots[slot, SEEN] = 0 if nearest < 0 else slots[nearest, VERSION]
    costs[slot] = cost
    return int(evaluations)


# -- merging -------------------------------------------------------------------------------------------------------


@algorithm
def look_again(
    kind: Static, align: Bool, slot: Int, counts: InOut[IntVector[COUNTS]], limits: Vector[2], rows: Matrix, weights:
    Reals, landmarks: Matrix, slots: InOut[IntRows[SLOT]], costs: InOut[Reals], heap: InOut[Ints], order: Ints,
    leaves: Matrix, nodes: IntRows[NODE], boxes: Matrix,
) -> None:  # fmt: skip
    """Look for a slot's nearest object, and queue it with that."""
    evaluations = look(
        kind, align, slot, limits, counts[:LIVE], rows, weights, landmarks, slots, costs, order, leaves, nodes, boxes
    )
    counts[EVALUATIONS] += evaluations
    if slots[slot, NEAREST] < 0:
        counts[WAITING] = leave(slot, counts[WAITING], costs, heap, slots)
        return
    place = slots[slot, QUEUED]
    if place < 0:
        place = counts[WAITING]
        counts[WAITING] += 1
    settle(place, slot, counts[WAITING], costs, heap, slots)


@algorithm
def merge_pair(
    kind: Static, align: Bool, slot: Int, counts: InOut[IntVector[COUNTS]], limits: InOut[Vector[2]], rows:
    InOut[Matrix], weights: InOut[Reals], landmarks: InOut[Matrix], slots: InOut[IntRows[SLOT]], costs: InOut[Reals],
    heap: InOut[Ints], order: InOut[Ints], leaves: InOut[Matrix], nodes: InOut[IntRows[NODE]], boxes: InOut[Matrix],
    merge_costs: InOut[Reals], pairs: InOut[IntRows[2]],
) -> None:  # fmt: skip
    """Replace an object and its nearest one by their mean."""
    kept = min(slot, slots[slot, NEAREST])
    gone = max(slot, slots[slot, NEAREST])
    turned = empty(len(rows[0]))
    turn(kind, align, turned, rows[kept], rows[gone])
    mean, status = KINDS[kind].mean(rows[kept], turned, weights[kept], weights[gone])
    if status == 0.0:  # as it was when it was looked for
        rows[kept][:] = mean
    weights[kept] += weights[gone]
    landmarks[kept][:] = KINDS[kind].landmark(rows[kept])
    slots[kept, VERSION] += 1
    slots[gone, VERSION] = -1
    counts[LIVE] -= 1
    merge_costs[counts[MERGES]] = costs[slot]
    pairs[counts[MERGES]][:] = (kept, gone)
    counts[MERGES] += 1
    counts[WAITING] = leave(gone, counts[WAITING], costs, heap, slots)
    if counts[LIVE] * REBUILD < counts[BUILT]:
        limits[SLACK] = build_tree(counts[:LIVE], landmarks, slots, order, leaves, nodes, boxes)
    else:
        refit(gone, -1, landmarks, slots, order, leaves, nodes, boxes)
        refit(kept, 0, landmarks, slots, order, leaves, nodes, boxes)
    look_again(
        kind, align, kept, counts, limits, rows, weights, landmarks, slots, costs, heap, order, leaves, nodes, boxes
    )


# -- what the caller calls, in this order --------------------------------------------------------------------------


@algorithm
def begin(
    kind: Static, counts: InOut[IntVector[COUNTS]], limits: InOut[Vector[2]], rows: Matrix, landmarks: InOut[Matrix],
    slots: InOut[IntRows[SLOT]], order: InOut[Ints], leaves: InOut[Matrix], nodes: InOut[IntRows[NODE]], boxes:
    InOut[Matrix],
) -> None:  # fmt: skip
    """Landmarks of all objects whose version is not negative, and the tree over them."""
    for slot in range(len(slots)):
        if slots[slot, VERSION] >= 0:
            landmarks[slot][:] = KINDS[kind].landmark(rows[slot])
    limits[SLACK] = build_tree(counts[:LIVE], landmarks, slots, order, leaves, nodes, boxes)


@algorithm
def find(
    kind: Static, align: Bool, begin: Int, end: Int, counts: IntVector[COUNTS], limits: Vector[2], rows: Matrix,
    weights: Reals, landmarks: Matrix, slots: InOut[IntRows[SLOT]], costs: InOut[Reals], order: Ints, leaves: Matrix,
    nodes: IntRows[NODE], boxes: Matrix,
) -> Int:  # fmt: skip
    """Nearest objects of those at some places of the new tree; costs that were computed."""
    evaluations = 0
    for place in range(begin, end):
        slot = order[place]
        count = look(
            kind, align, slot, limits, counts[:LIVE], rows, weights, landmarks, slots, costs, order, leaves, nodes,
            boxes,
        )  # fmt: skip
        evaluations += count
    return evaluations


@algorithm
def queue(counts: InOut[IntVector[COUNTS]], slots: InOut[IntRows[SLOT]], costs: Reals, heap: InOut[Ints]) -> None:
    """Queue all objects that have a nearest one."""
    for slot in range(len(slots)):
        if slots[slot, VERSION] >= 0 and slots[slot, NEAREST] >= 0:
            counts[WAITING] += 1
            settle(counts[WAITING] - 1, slot, counts[WAITING], costs, heap, slots)


@algorithm
def step(
    kind: Static, align: Bool, most: Int, counts: InOut[IntVector[COUNTS]], limits: InOut[Vector[2]], rows:
    InOut[Matrix], weights: InOut[Reals], landmarks: InOut[Matrix], slots: InOut[IntRows[SLOT]], costs: InOut[Reals],
    heap: InOut[Ints], order: InOut[Ints], leaves: InOut[Matrix], nodes: InOut[IntRows[NODE]], boxes: InOut[Matrix],
    merge_costs: InOut[Reals], pairs: InOut[IntRows[2]],
) -> Int:  # fmt: skip
    """At most so many merges; fewer were done only if no pair is left."""
    before = counts[MERGES]
    while counts[WAITING] > 0 and counts[MERGES] - before < most:
        slot = heap[0]
        if slots[slots[slot, NEAREST], VERSION] != slots[slot, SEEN]:
            look_again(
                kind, align, slot, counts, limits, rows, weights, landmarks, slots, costs, heap, order, leaves, nodes,
                boxes,
            )  # fmt: skip
        else:
            merge_pair(
                kind, align, slot, counts, limits, rows, weights, landmarks, slots, costs, heap, order, leaves, nodes,
                boxes, merge_costs, pairs,
            )  # fmt: skip
    return int(counts[MERGES] - before)
