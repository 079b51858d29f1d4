"""Points of rays that are nearly parallel to the carrier of a point pair of a ribbon: refined from several starts."""

from __future__ import annotations

from ....algorithms.roots.problem import MARGIN, by_precision, near, root_of_unit, unit_roundoff
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined
from ....ir.loops.language import (
    Bool,
    InOut,
    Ints,
    IntVector,
    Real,
    Reals,
    Rows,
    Static,
    Vector,
    empty,
    largest,
    sqrt,
)
from ..hits import length
from ..records import HIT, RAY, SEARCH, STATE
from .pieces import PIECE_SIZE, offer_at, point_on
from .spans import BESIDE, is_real

#: Roundings, relative to the frame's unit and the way along the ray, by which a point past the end of a segment counts.
PAST_END = 32.0
#: Squared sine between ray and carrier below which the point is refined: t from the root alone loses its square.
FLAT = 1e-4
#: Steps of Newton from a root to the point, and steps to the carrier nearest to a ray.
STEPS, ALONG = 6, 3
#: Roundings: within which points or directions are one; over the sine between ray and carrier, up to which a last step
#: is none; over that by which the ribbon is not flat, within which places along the ray are one.
SAME, BLUR, AROUND = 4096.0, 256.0, 8.0
#: Of half of the segment: a step along the ray that is none, in single and double precision, and one that leaves the
#: place in doubt.
SETTLED, DOUBT = (1e-2, 1e-4), 1e-2
#: A point that was found by refining: t, parameter, and how well t is known.
POINT = 3
#: Numbers of points that were found by refining, and of roots whose segments lie in the ray.
REFINED, IN_RAY = range(2)


@inlined
def is_on_segment(off: Real, half: Real, t: Real, direction: Vector[3]) -> Bool:
    """Whether a point so far from the middle of its segment is within half of it, ends included."""
    way = 1.0 + abs(t) * length(direction)
    found: Bool = abs(off) <= half + PAST_END * unit_roundoff() * way
    return found


@inlined
def clamped(t: Real) -> Real:
    """The parameter of the piece that is nearest."""
    return 0.0 if t < 0.0 else 1.0 if t > 1.0 else t


@algorithm
def near_point(
    finder: Static, half: Real, first_t: Real, first: Real, origin: Vector[3], moved: Real, row: Reals, ray: RAY,
    known: InOut[Rows[POINT]], counts: InOut[IntVector[2]], search: InOut[SEARCH], hits: InOut[Rows[HIT]],
    state: InOut[STATE], integers: Ints,
) -> Bool:  # fmt: skip
    """Offer a point of a ray nearly parallel to the carrier of its pair, refined from a start, unless it was before.

    False where it does not settle. ``half``: of the segment, in t.
    """
    rows = finder.rows
    norm, kappa = row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end]
    controls, products = row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end]
    settled = near() * near()
    margin = MARGIN * unit_roundoff()
    step = empty(3)
    position = empty(3)
    t = first_t
    b = first
    for _ in range(STEPS):
        step[:] = rows.polish(origin, ray.direction, t, norm, kappa, 1.0 - b, b, controls, products)
        t += step[0]
        b += step[1]
    last = abs(step[0])
    if not (abs(step[1]) <= settled and last < largest()):
        return False
    on = clamped(b)
    point_on(position, origin, ray.direction, t)
    place = rows.position(position, ray.direction, norm, kappa, 1.0 - on, on, controls, products)
    way = 1.0 / length(ray.direction) + abs(t)
    rounding = unit_roundoff() * way / sqrt(place[2])
    doubt = DOUBT * half
    around = AROUND * rounding / sqrt(step[2])  # the squared sine that this rounding is over
    least = by_precision(SETTLED[0], SETTLED[1]) * half
    spread = around if around < doubt else doubt
    size = spread if spread > least else least
    blur = last if last > size else size
    if not (last <= doubt or last <= BLUR * rounding):
        return False
    if not (b >= -margin and b <= 1.0 + margin):
        return True
    is_there = is_real(row[rows.spans.begin : rows.spans.end], on)
    if not (place[2] <= FLAT) or not is_there:
        return True  # another root's
    for i in range(counts[REFINED]):
        if abs(known[i, 0] - t) <= blur + known[i, 2] and abs(known[i, 1] - on) <= settled:
            return True
    known[counts[REFINED], 0] = t
    known[counts[REFINED], 1] = on
    known[counts[REFINED], 2] = blur
    counts[REFINED] += 1
    if is_on_segment(place[0], place[1], t, ray.direction):
        offer_at(t + moved, on, position, row[:PIECE_SIZE], search, hits, state, integers)
    return True


@algorithm
def offer_ends(
    b: Real, ends: Vector[7], origin: Vector[3], moved: Real, piece: Vector[PIECE_SIZE], ray: RAY,
    in_ray: InOut[Reals], counts: InOut[IntVector[2]], search: InOut[SEARCH], hits: InOut[Rows[HIT]],
    state: InOut[STATE], integers: Ints,
) -> None:  # fmt: skip
    """Offer the ends of a segment that lies in the ray, once: a root that touches may be found as two."""
    position = empty(3)
    for i in range(counts[IN_RAY]):
        if abs(in_ray[i] - b) <= BESIDE * root_of_unit():
            return
    in_ray[counts[IN_RAY]] = b
    counts[IN_RAY] += 1
    for side in (-1.0, 1.0):
        t = ends[0] + side * ends[1]
        point_on(position, origin, ray.direction, t)
        offer_at(t + moved, b, position, piece, search, hits, state, integers)


@algorithm
def near_hit(
    finder: Static, t: Real, root: Real, origin: Vector[3], moved: Real, row: Reals, ray: RAY,
    known: InOut[Rows[POINT]], in_ray: InOut[Reals], counts: InOut[IntVector[2]], search: InOut[SEARCH],
    hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints,
) -> None:  # fmt: skip
    """Offer the points of a ray that is nearly parallel to the carrier of a root.

    Two roots may lie closer than numbers tell, of points far apart: each t that the root's pair and its motion allow is
    refined together with the root; where none can be, from beside the root. A ray that cannot be told from the carrier
    has the whole segment in common with the surface: its two ends are offered.
    """
    rows = finder.rows
    norm, kappa = row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end]
    controls, products = row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end]
    beside = BESIDE * root_of_unit()
    same = SAME * unit_roundoff()
    ends = empty(7)
    starts = empty(5, 2)
    b = root
    ends[:] = rows.ends(origin, ray.direction, norm, kappa, 1.0 - root, root, controls, products)
    starts[0] = (t, root)
    starts[1] = (ends[3], root)
    starts[2] = (ends[4], root)
    starts[3] = (ends[0], root - beside)
    starts[4] = (ends[0], root + beside)
    is_along = ends[2] <= beside and ends[6] <= beside * beside
    if is_along:
        for _ in range(ALONG):
            b = clamped(b + ends[5])
            ends[:] = rows.ends(origin, ray.direction, norm, kappa, 1.0 - b, b, controls, products)
    way = 1.0 + abs(ends[0]) * length(ray.direction)
    piece = row[:PIECE_SIZE]
    if is_along and ends[2] <= same * way and ends[6] <= same * same:
        offer_ends(b, ends, origin, moved, piece, ray, in_ray, counts, search, hits, state, integers)
        return
    found = False
    for i in range(5):
        if i >= 3 and found:
            break
        is_settled = near_point(
            finder, ends[1], starts[i, 0], starts[i, 1], origin, moved, row, ray, known, counts, search, hits, state,
            integers,
        )  # fmt: skip
        found = found or is_settled
    if not found and is_along:
        offer_ends(b, ends, origin, moved, piece, ray, in_ray, counts, search, hits, state, integers)
