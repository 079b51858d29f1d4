"""Surfaces evolved along pieces of curves of circles: constants of a row, points of a ray, normals."""

from __future__ import annotations

from ....algorithms.roots.problem import MARGIN, near, unit_roundoff
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
    zeros,
)
from ....status import Status
from ..hits import AXES
from ..records import GIVEN, HIT, RAY, SEARCH, STATE
from .circle_roots import isolated
from .pieces import PIECE_SIZE, begin_row, offer_at, origin_in_frame, point_on, status_of
from .printed import companion, sampled

#: Squared cosine between ray and axis below which a ray counts as near the plane of the circle: the meet's point loses
#: a digit for each of the cosine. As many roundings are the cosine below which nothing is left of the meet.
FLAT, NO_MEET = 1e-4, 1024.0
#: Squared distance, in lengths of the frame, of hits that come from the far end of the meet where there is one.
DISTANT = 1e10
#: Newton steps from a root to the point; three are enough, the fourth confirms.
STEPS = 4
#: Numbers of a trivector and of a 4-vector.
TRIVECTOR, QUAD = 10, 5


@algorithm
def prepare(finder: Static, parameters: Reals, row: InOut[Reals]) -> None:
    """Constants of a piece: S0, K, the controls with their binomials inside, Q C', sizes."""
    rows = finder.rows
    degree, squares = rows.degree, rows.squares
    begin_row(parameters, row)
    norm_at, kappa_at, controls_at, products_at = (
        rows.norm.begin, rows.kappa.begin, rows.controls.begin, rows.products.begin,
    )  # fmt: skip
    every = zeros(QUAD * (2 * degree + 1))
    ends = QUAD * (2 * degree - squares) // 2  # between circles the ends of w Q vanish
    binomial = 1.0
    for i in range(degree + 1):
        for j in range(TRIVECTOR):
            row[controls_at + TRIVECTOR * i + j] = binomial * parameters[GIVEN + TRIVECTOR * i + j]
        binomial = binomial * float(degree - i) / float(i + 1)
    row[rows.products.begin : rows.products.end] = 0.0
    row[rows.norm.begin : rows.kappa.end] = 0.0
    for i in range(degree + 1):
        first = controls_at + TRIVECTOR * i
        for j in range(i, degree + 1):
            weight = 2.0 if i < j else 1.0
            last = controls_at + TRIVECTOR * j
            to = QUAD * (i + j)
            row[norm_at + i + j], every[to : to + QUAD] = rows.square_term(
                row[norm_at + i + j], every[to : to + QUAD], row[first : first + TRIVECTOR],
                row[last : last + TRIVECTOR], weight,
            )  # fmt: skip
    for i in range(squares + 1):
        one = ends + QUAD * i
        for j in range(i, squares + 1):
            weight = 2.0 if i < j else 1.0
            other = ends + QUAD * j
            row[kappa_at + i + j] = rows.kappa_term(
                row[kappa_at + i + j], every[one : one + QUAD], every[other : other + QUAD], weight
            )
        for j in range(degree + 1):
            control = controls_at + TRIVECTOR * j
            product = products_at + TRIVECTOR * (i + j)
            row[product : product + TRIVECTOR] = rows.product_term(
                row[product : product + TRIVECTOR], every[one : one + QUAD], row[control : control + TRIVECTOR]
            )
    row[rows.sizes.begin : rows.sizes.end] = rows.sizes_of(
        row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end],
        every[ends : ends + QUAD * (squares + 1)], row[rows.controls.begin : rows.controls.end],
        row[rows.products.begin : rows.products.end],
    )  # fmt: skip


@inlined
def is_new(t: Real, at: Real, known: InOut[Rows[2]], count: InOut[IntVector[1]]) -> Bool:
    """Whether no other root has found the same point near the plane of its circle: each counts once."""
    settled = near() * near()
    for i in range(count[0]):
        if abs(known[i, 0] - t) <= settled * (1.0 + abs(t)) and abs(known[i, 1] - at) <= settled:
            return False
    known[count[0], 0] = t
    known[count[0], 1] = at
    count[0] += 1
    return True


@inlined
def is_nearest(root: Int, at: Real, roots: Reals, count: Int) -> Bool:
    """Whether the nearest root to a parameter is this one."""
    settled = near() * near()
    for i in range(count):  # noqa: SIM110
        if abs(roots[i] - at) < abs(roots[root] - at) - settled:
            return False
    return True


@algorithm
def flat_hits(
    finder: Static, root: Int, roots: Reals, count: Int, origin: Vector[3], moved: Real, row: Reals, ray: RAY,
    known: InOut[Rows[2]], known_count: InOut[IntVector[1]], search: InOut[SEARCH], hits: InOut[Rows[HIT]],
    state: InOut[STATE], integers: Ints,
) -> None:  # fmt: skip
    """Offer the points of a ray that lies near the plane of the circle of a root, where the meet vanishes.

    They are its points on the circle's sphere, refined. A root that only touches has two.
    """
    rows = finder.rows
    norm, kappa = row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end]
    controls, products = row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end]
    step = empty(3)
    position = empty(3)
    margin = MARGIN * unit_roundoff()
    settled = near() * near()
    start = rows.sphere(origin, ray.direction, norm, kappa, 1.0 - roots[root], roots[root], controls, products)
    for side in range(2):
        t = start[side]
        at = roots[root]
        for _ in range(STEPS):
            step[:] = rows.polish(origin, ray.direction, t, norm, kappa, 1.0 - at, at, controls, products)
            t += step[0]
            at += step[1]
        if not (at >= -margin and at <= 1.0 + margin and abs(step[1]) < settled):
            continue
        at = 0.0 if at < 0.0 else 1.0 if at > 1.0 else at
        if not is_nearest(root, at, roots, count):
            continue
        is_first = is_new(t, at, known, known_count)
        if not is_first:
            continue
        point_on(position, origin, ray.direction, t)
        offer_at(t + moved, at, position, row[:PIECE_SIZE], search, hits, state, integers)


@algorithm
def slanted_hit(
    finder: Static, at: Real, guess: Real, origin: Vector[3], moved: Real, row: Reals, ray: RAY,
    known: InOut[Rows[2]], known_count: InOut[IntVector[1]], search: InOut[SEARCH], hits: InOut[Rows[HIT]],
    state: InOut[STATE], integers: Ints,
) -> None:  # fmt: skip
    """Offer the point of a root whose circle's plane the ray crosses at a small angle: where it is nearest to it."""
    rows = finder.rows
    t = guess
    position = empty(3)
    for _ in range(STEPS):
        step = rows.polish(
            origin, ray.direction, t, row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end],
            1.0 - at, at, row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end],
        )  # fmt: skip
        if step[2] - step[2] != 0.0:
            break
        t += step[2]
    is_first = is_new(t, at, known, known_count)
    if is_first:
        point_on(position, origin, ray.direction, t)
        offer_at(t + moved, at, position, row[:PIECE_SIZE], search, hits, state, integers)


@inlined
def find_roots(
    finder: Static, method: Static, meets: InOut[Reals], origin: Vector[3], row: Reals, state: STATE,
    roots: InOut[Reals],
) -> Int:  # fmt: skip
    """Parameters of the piece where the ray meets its circles; how many, or what finders return instead."""
    count = 0
    if method == "isolate":
        reach = 1.0 + origin[0] * origin[0] + origin[1] * origin[1] + origin[2] * origin[2]
        count = isolated(finder, meets, row, reach * reach, roots)
    elif method == "companion":
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
    local = empty(3)
    far_position = empty(3)
    meets = empty(rows.shared.end)
    roots = empty(finder.problem.degree)
    known = empty(2 * finder.problem.degree, 2)
    known_count = int_zeros(1)
    origin_in_frame(local, row[:PIECE_SIZE], ray)
    moved, origin = rows.nearest(local, ray.direction)
    if row[rows.radius] < largest():
        middle_half = rows.approach(
            origin, ray.direction, row[rows.bound.begin : rows.radius], row[rows.radius : rows.bound.end]
        )
        middle = moved + middle_half[0]
        half = middle_half[1]
        unit = row[rows.unit]
        if not ((middle + half) * unit > search.t_min and (middle - half) * unit < search.t_max):
            return
    meets[rows.meets.begin : rows.meets.end] = rows.ray(origin, ray.direction, controls, products)
    for k in AXES:
        meets[rows.origin.begin + k] = origin[k]
        meets[rows.direction.begin + k] = ray.direction[k]
    count = find_roots(finder, method, meets, origin, row, state, roots)
    state.status = status_of(count)
    for i in range(count):
        at = roots[i]
        place, position = rows.point(  # t, squared cosine; t, its square and more of a far hit
            origin, ray.direction, meets[rows.meets.begin : rows.meets.end], norm, kappa, 1.0 - at, at, controls,
            products,
        )  # fmt: skip
        least = NO_MEET * NO_MEET * unit_roundoff() * unit_roundoff()
        if place[1] > FLAT:
            offer_at(place[0] + moved, at, position, row[:PIECE_SIZE], search, hits, state, integers)
        elif place[4] > FLAT and place[3] > DISTANT and place[3] < largest():
            point_on(far_position, origin, ray.direction, place[2])
            offer_at(place[2] + moved, at, far_position, row[:PIECE_SIZE], search, hits, state, integers)
        elif place[1] > least:
            slanted_hit(
                finder, at, place[0], origin, moved, row, ray, known, known_count, search, hits, state, integers
            )
        elif finder.problem.defers:
            state.status = Status.INVALID
        else:
            flat_hits(
                finder, i, roots, count, origin, moved, row, ray, known, known_count, search, hits, state, integers
            )


@algorithm
def normal(finder: Static, normal: Out[Vector[3]], row: Reals, ray: RAY, hit: HIT) -> None:
    """Normal at a point of a piece."""
    rows = finder.rows
    normal[:] = rows.normal(
        hit.local, row[rows.norm.begin : rows.norm.end], row[rows.kappa.begin : rows.kappa.end], 1.0 - hit.at, hit.at,
        row[rows.controls.begin : rows.controls.end], row[rows.products.begin : rows.products.end],
    )  # fmt: skip
