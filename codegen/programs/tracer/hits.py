"""Searches along a ray, and the points that kinds of surface offer to them.

A kind of surface has an algorithm ``hits``, of a row of its constants and a ray: it offers every point of the ray to
the search. Points beyond the search's bounds need not be looked for, but what is found must not depend on them in any
bit. It sets ``state.status`` where it cannot tell. And it has one that gives the unit normal, either side, at a hit.
"""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import in_library, inlined
from ...ir.loops.language import NAN, Bool, InOut, Int, Ints, Out, Real, Reals, Rows, Vector, epsilon, largest, sqrt
from ...status import Status
from .records import HIT, RAY, SCENE, SEARCH, STATE, TABLE

#: Where the tables begin among a scene's integers, and how long one is.
TABLES, TABLE_SIZE = SCENE.size, TABLE.size
ROWS_OF, CONSTANTS_OF, BOXES_OF, IDS_OF = (TABLE.offsets[n] for n in ("rows", "constants_at", "boxes_at", "ids_at"))
#: Precisions with a larger distance from 1 to the next number are single.
SINGLE = 1e-10
#: A loop over them is written out.
AXES = (0, 1, 2)


@inlined
def begin_search(scene: SCENE, room: Int, search: Out[SEARCH], state: Out[STATE]) -> None:
    """Begin a search of all of a ray, or of its line where there is room for more than one point."""
    search.t_min = -largest() if room > 1 else 0.0
    search.t_max = largest()
    search.singular = largest()
    search.invalid = largest()
    state.room = room
    state.count = 0
    state.hit_kind = 0
    state.hit_index = 0
    state.method = scene.method
    state.samples = scene.samples
    state.status = Status.OK
    state.cost = 0


@inlined
def search_status(search: SEARCH) -> Int:
    """Status of a ray that has been asked: rows that begin behind its first hit have no say."""
    if search.invalid < search.t_max:
        return Status.INVALID
    return Status.SINGULAR if search.singular < search.t_max else Status.OK


@inlined
def length(x: Vector[3]) -> Real:
    """Length of a vector."""
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])


@inlined
def distance_of_origin(ray: RAY) -> Real:
    """How far the origin of a ray is from that of the world, or further; no number if one of its own is none."""
    return abs(ray.origin[0]) + abs(ray.origin[1]) + abs(ray.origin[2])


@inlined
def is_within(distance: Real, ray: RAY) -> Bool:
    """Whether the distance of a hit, and its point, are numbers."""
    found: Bool = abs(distance) + distance_of_origin(ray) <= largest()
    return found


@algorithm
def precedes(state: STATE, integers: Ints) -> Bool:
    """Whether the row that is asked goes before that of the hit found so far, which is as near."""
    own = integers[integers[TABLES + TABLE_SIZE * state.kind + IDS_OF] + state.index]
    other = integers[integers[TABLES + TABLE_SIZE * state.hit_kind + IDS_OF] + state.hit_index]
    found: Bool = own < other or (own == other and state.index < state.hit_index)
    return found


@inlined
def accept_hit(
    t: Real, alpha: Real, search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints
) -> Int:
    """The place of a hit at t, if it is wanted, else -1: the caller fills in its points."""
    if not (t > search.t_min and t <= search.t_max):
        return -1
    if state.room == 1:
        if t == search.t_max:
            if state.count == 0:
                return -1
            if not precedes(state, integers):
                return -1
        state.count = 0
        search.t_max = t
        state.hit_kind = state.kind
        state.hit_index = state.index
    elif state.count == state.room:
        return -1
    place: Int = state.count
    state.count = place + 1
    hit = hits[place]
    hit.t = t
    hit.alpha = alpha
    return place


@inlined
def offer(
    t: Real, center: Vector[3], local: Vector[3], search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE],
    integers: Ints,
) -> None:  # fmt: skip
    """Offer a point of the ray, given relative to a centre."""
    place = accept_hit(t, NAN, search, hits, state, integers)
    if place >= 0:
        hit = hits[place]
        for i in AXES:
            hit.local[i] = local[i]
            hit.point[i] = center[i] + local[i]


@in_library
def scene_scaled(direction: InOut[Vector[3]]) -> Real:
    """Squared length of a direction; very long and very short ones are scaled before, to about length 1.

    Their squares are no numbers, and products with them lose what is hit. By a power of two: no bit of a point, a
    distance or a normal depends on it. Directions that are zero or not finite stay so, and are none.
    """
    square = direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]
    far = 2.0**16 if epsilon() > SINGLE else 2.0**64
    if square < far and square > 1.0 / far:
        return square
    x = abs(direction[0])
    y = abs(direction[1])
    z = abs(direction[2])
    least = 2.0**-126 if epsilon() > SINGLE else 2.0**-1022
    first = x if x > y else y
    second = z if z > least else least
    size = first if first > second else second
    scale = 0.0
    if size <= largest():
        scale = 1.0
        while size >= 4.0:
            size *= 0.5
            scale *= 0.5
        while size < 2.0:
            size *= 2.0
            scale *= 2.0
    for i in range(3):
        direction[i] = scale * direction[i]
    return direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]


@inlined
def load_ray(
    origins: Reals, origin_stride: Int, directions: Reals, direction_stride: Int, i: Int, ray: Out[RAY]
) -> Bool:
    """Ray i of two arrays; whether it is one. A stride is 0, one for all, or 3."""
    for k in AXES:
        ray.origin[k] = origins[i * origin_stride + k]
        ray.direction[k] = directions[i * direction_stride + k]
    far = distance_of_origin(ray)
    square = scene_scaled(ray.direction)
    found: Bool = far - far == 0.0 and square > 0.0 and square - square == 0.0
    return found
