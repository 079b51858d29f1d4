"""A binary heap of slots, the least cost first, of equal ones the lowest slot; each slot knows its place in it."""

from __future__ import annotations

from ..ir.loops.algorithm import Algorithm as algorithm
from ..ir.loops.language import Bool, InOut, Int, IntRows, Ints, Reals
from .merging_layout import QUEUED, SLOT


@algorithm
def comes_first(a: Int, b: Int, costs: Reals) -> Bool:
    """Whether slot a is cheaper than slot b."""
    return costs[a] < costs[b] or (costs[a] == costs[b] and a < b)


@algorithm
def settle(place: Int, slot: Int, size: Int, costs: Reals, heap: InOut[Ints], slots: InOut[IntRows[SLOT]]) -> None:
    """Bring a slot, whose place in the heap is free for others, to where its cost belongs."""
    while place > 0:
        parent = heap[(place - 1) // 2]
        if not comes_first(slot, parent, costs):
            break
        heap[place] = parent
        slots[parent, QUEUED] = place
        place = (place - 1) // 2
    while 2 * place + 1 < size:
        below = 2 * place + 1
        beside = min(below + 1, size - 1)
        if comes_first(heap[beside], heap[below], costs):
            below = beside
        child = heap[below]
        if not comes_first(child, slot, costs):
            break
        heap[place] = child
        slots[child, QUEUED] = place
        place = below
    heap[place] = slot
    slots[slot, QUEUED] = place


@algorithm
def leave(slot: Int, size: Int, costs: Reals, heap: InOut[Ints], slots: InOut[IntRows[SLOT]]) -> Int:
    """Take a slot out of the heap, if it is there; the size that is left."""
    place = slots[slot, QUEUED]
    if place < 0:
        return size
    slots[slot, QUEUED] = -1
    last = heap[size - 1]
    if last != slot:
        settle(place, last, size - 1, costs, heap, slots)
    return size - 1
