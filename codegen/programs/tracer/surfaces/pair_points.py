"""Ribbons, surfaces evolved along pieces of curves of point pairs: constants of a row, points of a ray, normals."""

from __future__ import annotations

from ....algorithms.roots.problem import root_of_unit, unit_roundoff
from ....ir.loops.algorithm import Algorithm as algorithm
from ....ir.loops.algorithm import inlined
from ....ir.loops.language import (
    Bool,
    InOut,
    Int,
    Ints,
    IntVector,
    Out,
    Real,
    Reals,
    Rows,
    Static,
    Vector,
    empty,
    int_zeros,
    largest,
)
from ....status import Status
from ..hits import AXES, length
from ..records import GIVEN, HIT, RAY, SEARCH, STATE
from .pair_refining import FLAT, PAST_END, POINT, SAME, is_on_segment, near_hit
from .pair_roots import ends_at_zero, pair_isolated, pair_sizes
from .pieces import PIECE_SIZE, begin_row, offer_at, origin_in_frame, status_of
from .printed import companion, sampled
from .spans import BESIDE, VANISHES, is_real

#: Roundings that 4-vectors of pairs on one circle are off zero, relative to their terms.
COCIRCULAR = 16.0


@algorithm
def prepare(finder: Static, parameters: Reals, row: InOut[Reals]) -> None:
    """Constants of a piece: S0, K, the controls with their binomials inside, Q C', sizes, levers."""
    rows = finder.rows
    begin_row(parameters, row)
    near_numbers = empty(8)
    (
        row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end],
        row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end], near_numbers[:],
    ) = rows.constants(parameters[GIVEN : GIVEN + rows.controls.end - rows.controls.begin])  # fmt: skip
    least = COCIRCULAR * unit_roundoff()
    if near_numbers[0] <= least * least * near_numbers[1]:  # pairs on one circle need no projection (4.7.3)
        row[rows.kappa.begin : rows.kappa.end] = 0.0
        row[rows.products.begin : rows.products.end] = 0.0
    # squares of the ends are 1 where they are to rounding: of a short pair it would be all that is left of its length
    for side, at in ((0, rows.norm.begin), (1, rows.norm.end - 1)):
        if abs(row[at] - 1.0) <= near_numbers[2 + side]:
            row[at] = 1.0
    pair_sizes(finder, row)
    for i in range(4):
        row[rows.levers.begin + i] = near_numbers[4 + i]


@algorithm
def has_common_point(
    finder: Static, origin: Vector[3], moved: Real, row: Reals, ray: RAY, search: InOut[SEARCH],
    hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints,
) -> Bool:  # fmt: skip
    """Offer the point where a ray meets all carriers, where they have one in common, as at the corner of a facet."""
    rows = finder.rows
    norm, kappa = row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end]
    controls, products = row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end]
    places = empty(3, 4)
    positions = empty(3, 3)
    same = SAME * unit_roundoff()
    for i in range(3):
        b = 0.5 * float(i)
        places[i], positions[i], sine_square = rows.point(
            origin, ray.direction, norm, kappa, 1.0 - b, b, controls, products
        )
        apart = abs(places[i, 0] - places[0, 0])
        size = 1.0 + abs(places[0, 0])
        if not (sine_square > FLAT and apart <= same * size):
            return False
    if is_on_segment(places[0, 1], places[0, 2], places[0, 0], ray.direction):
        offer_at(places[0, 0] + moved, 0.0, positions[0], row[:PIECE_SIZE], search, hits, state, integers)
    return True


@algorithm
def end_hits(
    finder: Static, meets: Reals, noise: Vector[2], roots: Reals, count: Int, origin: Vector[3], moved: Real,
    row: Reals, ray: RAY, known: InOut[Rows[POINT]], in_ray: InOut[Reals], counts: InOut[IntVector[2]],
    search: InOut[SEARCH], hits: InOut[Rows[HIT]], state: InOut[STATE], integers: Ints,
) -> None:  # fmt: skip
    """Offer where a ray meets the first or the last segment to rounding, and no root says so.

    Roots may be just beyond the end, of rays along the carrier, and of those through the joint of two pieces beyond the
    ends of both.
    """
    rows = finder.rows
    norm, kappa = row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end]
    controls, products = row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end]
    beside = BESIDE * root_of_unit()
    place = empty(4)
    position = empty(3)
    for end in range(2):
        b = float(end)
        is_known = False
        for i in range(count):
            is_known = is_known or abs(roots[i] - b) <= beside
        if is_known:
            continue
        is_touched = ends_at_zero(finder, meets, row, noise, end)
        is_there = is_real(row[rows.spans.begin : rows.spans.end], b)
        if not (is_touched and is_there):
            continue
        place[:], position[:], sine_square = rows.point(
            origin, ray.direction, norm, kappa, 1.0 - b, b, controls, products
        )
        past = PAST_END * unit_roundoff() * (1.0 + abs(place[0]) * length(ray.direction))
        is_inside = is_on_segment(place[1], place[2], place[0], ray.direction)
        if not (sine_square > FLAT):
            near_hit(finder, place[0], b, origin, moved, row, ray, known, in_ray, counts, search, hits, state, integers)
        elif is_inside and place[3] <= past:
            offer_at(place[0] + moved, b, position, row[:PIECE_SIZE], search, hits, state, integers)


@inlined
def find_roots(
    finder: Static, method: Static, meets: InOut[Reals], noise: Vector[2], row: Reals, ray: RAY, state: STATE,
    roots: InOut[Reals],
) -> Int:  # fmt: skip
    """Parameters of the piece where the ray meets its carriers; how many, or what finders return instead."""
    count = 0
    if method == "isolate":
        count = pair_isolated(finder, meets, row, noise, roots)
    else:  # the printed methods look at the size of f
        over = 1.0 / length(ray.direction)
        for i in range(finder.rows.meets.end):
            meets[i] *= over
        if method == "companion":
            count = companion(finder, meets, row, roots)
        else:
            count = sampled(finder, meets, row, state.samples, roots)
    return count  # type: ignore[no-any-return]


@algorithm
def hits(
    finder: Static, method: Static, row: Reals, ray: RAY, search: InOut[SEARCH], hits: InOut[Rows[HIT]],
    state: InOut[STATE], integers: Ints,
) -> None:  # fmt: skip
    """Offer the points of a ray on a piece."""
    rows = finder.rows
    norm, kappa = row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end]
    controls, products = row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end]
    origin = empty(3)
    noise = empty(2)
    meets = empty(rows.other_kappa.end)
    roots = empty(finder.problem.degree)
    most = finder.problem.degree + 2
    known = empty(5 * most, POINT)
    in_ray = empty(most)
    counts = int_zeros(2)
    moved = 0.0
    origin_in_frame(origin, row[:PIECE_SIZE], ray)
    if row[rows.radius] < largest():
        middle_half = rows.approach(
            origin, ray.direction, row[rows.bound.begin : rows.radius], row[rows.radius : rows.bound.end]
        )
        first = middle_half[0] - middle_half[1]
        last = middle_half[0] + middle_half[1]
        unit = row[rows.unit]
        if not (last * unit > search.t_min and first * unit < search.t_max):
            return
        moved = middle_half[0]
        for k in AXES:
            origin[k] += moved * ray.direction[k]
    meets[rows.meets.begin : rows.meets.end], noise[:] = rows.ray(
        origin, ray.direction, controls, products, row[rows.levers.begin : rows.levers.end]
    )
    count = find_roots(finder, method, meets, noise, row, ray, state, roots)
    state.status = status_of(count)
    if finder.problem.defers:
        for end in range(2):
            is_touched = ends_at_zero(finder, meets, row, noise, end)
            if is_touched:
                state.status = Status.INVALID
    elif count == VANISHES:
        has_point = has_common_point(finder, origin, moved, row, ray, search, hits, state, integers)
        if has_point:
            state.status = Status.OK
    for i in range(count):
        b = roots[i]
        place, position, sine_square = rows.point(origin, ray.direction, norm, kappa, 1.0 - b, b, controls, products)
        if not (sine_square > FLAT):
            if finder.problem.defers:
                state.status = Status.INVALID
            else:
                near_hit(
                    finder, place[0], b, origin, moved, row, ray, known, in_ray, counts, search, hits, state, integers
                )
        elif is_on_segment(place[1], place[2], place[0], ray.direction):
            offer_at(place[0] + moved, b, position, row[:PIECE_SIZE], search, hits, state, integers)
    if method == "isolate" and not finder.problem.defers:  # noqa: SIM102
        if count >= 0:
            end_hits(
                finder, meets, noise, roots, count, origin, moved, row, ray, known, in_ray, counts, search, hits,
                state, integers,
            )  # fmt: skip


@algorithm
def normal(finder: Static, normal: Out[Vector[3]], row: Reals, ray: RAY, hit: HIT) -> None:
    """Normal at a point of a piece."""
    rows = finder.rows
    normal[:] = rows.normal(
        hit.local, row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end], 1.0 - hit.at, hit.at,
        row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end],
    )  # fmt: skip
