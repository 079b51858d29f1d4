"""The way of a ray through the tree over boxes: the next row to ask, the nearest boxes first.

What is found does not depend on the tree in any bit: boxes hold all that a kind's algorithms may find, with rounding
(formulas/rays/boxes.py). C has a text of its own, templates/c/programs/tracer/acceleration/scene_tree.h, which tests
four boxes at once with numbers of 32 bits: it may enter a box more or less.
"""

from __future__ import annotations

from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import in_library
from ....ir.loops.language import InOut, Int, Ints, IntVector, Out, Reals, Vector, empty
from ..kernels import box_ray, box_span
from ..records import BOUNDS, NO_PART, PARTS, RAY, SCENE, SEARCH, STATE, TRAVERSAL, WAITING_NODES

#: What is kept of a ray, real: the origins that near and far sides are seen from, one over the direction, and where the
#: boxes that wait begin; integers: how many wait, and which parts they are.
NEAR, FAR, INVERSE, BEGINS = 0, 3, 6, 9
PROGRESS = BEGINS + WAITING_NODES
REACH = BOUNDS.offsets["reach"]


@algorithm
def enter_node(
    node: Int, scene: SCENE, integers: Ints, reals: Reals, ray: RAY, search: SEARCH, progress: InOut[Vector[PROGRESS]],
    traversal: InOut[IntVector[TRAVERSAL]],
) -> None:  # fmt: skip
    """Add the parts of a node that the ray enters in time to those that wait: the nearest last."""
    first = empty(3)
    last = empty(3)
    below = traversal[0]
    sides = scene.boxes_at + 6 * PARTS * node
    for c in range(PARTS):
        part = integers[scene.parts_at + PARTS * node + c]
        if part == NO_PART:
            continue
        for i in range(3):
            low = reals[sides + PARTS * i + c]
            high = reals[sides + PARTS * (3 + i) + c]
            first[i] = high if ray.direction[i] < 0.0 else low
            last[i] = low if ray.direction[i] < 0.0 else high
        span = box_span(
            progress[NEAR:FAR],
            progress[FAR:INVERSE],
            progress[INVERSE:BEGINS],
            first,
            last,
            (search.t_min, search.t_max),
        )
        if span[0] <= span[1]:
            place = traversal[0]
            while place > below and progress[BEGINS + place - 1] < span[0]:
                progress[BEGINS + place] = progress[BEGINS + place - 1]
                traversal[1 + place] = traversal[place]
                place -= 1
            progress[BEGINS + place] = span[0]
            traversal[1 + place] = part
            traversal[0] += 1


@in_library
def begin_tree(
    scene: SCENE, integers: Ints, reals: Reals, ray: RAY, search: SEARCH, state: InOut[STATE],
    progress: Out[Vector[PROGRESS]], traversal: Out[IntVector[TRAVERSAL]],
) -> None:  # fmt: skip
    """Begin at the root."""
    traversal[0] = 0
    if scene.nodes == 0:
        return
    progress[NEAR:FAR], progress[FAR:INVERSE], progress[INVERSE:BEGINS] = box_ray(
        ray.origin, ray.direction, reals[REACH : REACH + 1]
    )
    enter_node(0, scene, integers, reals, ray, search, progress, traversal)
    state.cost += PARTS


@in_library
def next_in_tree(
    scene: SCENE, integers: Ints, reals: Reals, ray: RAY, search: SEARCH, state: InOut[STATE],
    progress: InOut[Vector[PROGRESS]], traversal: InOut[IntVector[TRAVERSAL]],
) -> Int:  # fmt: skip
    """The next item to ask, -1 for none."""
    while traversal[0] > 0:
        traversal[0] -= 1
        waiting = traversal[0]
        if progress[BEGINS + waiting] <= search.t_max:
            part: Int = traversal[1 + waiting]
            if part < 0:
                return -1 - part
            enter_node(part, scene, integers, reals, ray, search, progress, traversal)
            state.cost += PARTS
    return -1
