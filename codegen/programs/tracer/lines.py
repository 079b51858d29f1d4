"""All points of lines on the rows of a surface, in order: the algorithms of one program."""

from __future__ import annotations

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import Bytes, InOut, Int, Ints, Ints32, Real, Reals, Rows, empty, epsilon, int_empty
from ...status import Status
from .hits import CONSTANTS_OF, ROWS_OF, SINGLE, begin_search, is_within, length, load_ray, search_status
from .records import GATHERED, HIT, PIECE, RAY, SCENE, SEARCH, STATE, TRAVERSAL
from .search import SearchAlgorithms, SurfaceAlgorithms, store_none
from .tree.tree_search import PROGRESS, begin_tree, next_in_tree

#: Where a row says where its piece begins on the curve, and then how long it is there.
ROW_START = PIECE.offsets["start"]
#: Two pieces of a curve find a point of their joint at parameters that differ by roundings, a thousand times as many
#: where the ray grazes, and at places that may lose half of the digits where it touches. In single and double
#: precision.
JOINT_ALPHA, JOINT_PLACE = (2.0**-14, 2.0**-37), (3.4526698300124393e-4, 2.0**-26)


def line_algorithm(
    kinds: tuple[SurfaceAlgorithms, ...], has_tree: bool, search_of: SearchAlgorithms, most: int
) -> algorithm:
    """The algorithm of a program that finds all points of lines.

    Parameters
    ----------
    kinds : tuple of SurfaceAlgorithms
    has_tree : bool
        Over the boxes of rows.
    search_of : SearchAlgorithms
    most : int
        Points of a line on one row, at most.
    """
    after_row, ask_row, store = search_of.after_row, search_of.ask_row, search_of.store
    curves = tuple(each for each in kinds if each.is_curve)
    has_curves = bool(curves)
    for_one_point = inlined if len(kinds) == 1 and most == 2 else algorithm  # of planes; two points are slower by it

    @inlined
    def move_row(
        to: Int, place: Int, t: InOut[Reals], alpha: InOut[Reals], point: InOut[Reals], normal: InOut[Reals],
        rows: InOut[Ints32],
    ) -> None:  # fmt: skip
        """Move a hit from one place of the arrays to another."""
        rows[to] = rows[place]
        t[to] = t[place]
        alpha[to] = alpha[place]
        for i in range(3):
            point[3 * to + i] = point[3 * place + i]
            normal[3 * to + i] = normal[3 * place + i]

    @inlined
    def period_of(kind: Int, integers: Ints, reals: Reals) -> Real:
        """How far the parameter of a curve runs, from the first to the last row of the surface that is asked."""
        found = 0.0
        for each in curves:
            if kind == each.number:
                first = integers[each.table + CONSTANTS_OF] + ROW_START
                last = first + each.size * (integers[each.table + ROWS_OF] - 1)
                found = reals[last] + reals[last + 1] - reals[first]
        return found

    @inlined
    def joint_at(
        begin: Int, kept: Int, distance: Real, integers: Ints, reals: Reals, ray: RAY, hit: HIT, state: STATE,
        t: Reals, alpha: Reals, rows: Ints32,
    ) -> Int:  # fmt: skip
        """The place, among the points of a line, of another that is this one; -1 for none.

        Where two pieces of a curve join, both find the points of the common circle, and so do the first and the last of
        a closed curve, or both ends of its only one.
        """
        if not (kept > 0 and hit.alpha - hit.alpha == 0.0):
            return -1
        size = abs(distance) + length(ray.origin)
        period = period_of(state.kind, integers, reals)
        near = (JOINT_ALPHA[0] if epsilon() > SINGLE else JOINT_ALPHA[1]) * (1.0 + abs(hit.alpha))
        place = JOINT_PLACE[0] if epsilon() > SINGLE else JOINT_PLACE[1]
        for i in range(kept):
            apart = abs(alpha[begin + i] - hit.alpha)
            is_joint = rows[begin + i] != state.index and apart <= near
            if (is_joint or abs(apart - period) <= near) and abs(t[begin + i] - distance) <= place * size:
                return i
        return -1

    @for_one_point
    def gather(
        begin: Int, roots: Int, integers: Ints, reals: Reals, ray: RAY, hits: Rows[HIT], state: InOut[STATE],
        gathered: InOut[GATHERED], t: InOut[Reals], alpha: InOut[Reals], point: InOut[Reals], normal: InOut[Reals],
        rows: InOut[Ints32],
    ) -> None:  # fmt: skip
        """Add the points of the row that was asked to those of a line: by t, and by row where t is the same.

        Those for which there is no room are counted.
        """
        size = length(ray.direction)
        for j in range(state.count):
            hit = hits[j]
            distance = hit.t * size
            if not is_within(distance, ray):
                gathered.lost = 1
                continue
            kept = min(gathered.total, roots)
            if has_curves:
                joint = joint_at(begin, kept, distance, integers, reals, ray, hit, state, t, alpha, rows)
                if joint >= 0:  # the piece of the lower row keeps it
                    if rows[begin + joint] <= state.index:
                        continue
                    for i in range(joint, kept - 1):
                        move_row(begin + i, begin + i + 1, t, alpha, point, normal, rows)
                    kept -= 1
                    gathered.total -= 1
            place = kept
            while place > 0:
                before = begin + place - 1
                if not (t[before] > distance or (t[before] == distance and rows[before] > state.index)):
                    break
                place -= 1
            for i in range(min(kept, roots - 1), place, -1):
                move_row(begin + i, begin + i - 1, t, alpha, point, normal, rows)
            gathered.total += 1
            if place < roots:
                rows[begin + place] = state.index
                store(
                    begin + place, distance, state.kind, state.index, integers, reals, ray, hit, t, alpha, point, normal
                )  # fmt: skip
        state.count = 0

    @inlined
    def find_all(
        begin: Int, roots: Int, scene: SCENE, integers: Ints, reals: Reals, ray: RAY, search: InOut[SEARCH],
        hits: InOut[Rows[HIT]], state: InOut[STATE], gathered: InOut[GATHERED], t: InOut[Reals], alpha: InOut[Reals],
        point: InOut[Reals], normal: InOut[Reals], rows: InOut[Ints32],
    ) -> None:  # fmt: skip
        """Gather the points of a line on every row that it may meet."""
        if has_tree:
            progress = empty(PROGRESS)
            traversal = int_empty(TRAVERSAL)
            bare = scene.unbounded
            while True:
                item = bare
                if bare < scene.items:
                    bare += 1
                else:
                    if bare == scene.items:
                        begin_tree(scene, integers, reals, ray, search, state, progress, traversal)
                        bare += 1
                    item = next_in_tree(scene, integers, reals, ray, search, state, progress, traversal)
                    if item < 0:
                        return
                ask_row(item, scene, integers, reals, ray, search, hits, state)
                if state.count > 0:
                    gather(
                        begin, roots, integers, reals, ray, hits, state, gathered, t, alpha, point, normal, rows
                    )  # fmt: skip
        for each in kinds:
            state.kind = each.number
            for index in range(integers[each.table + ROWS_OF]):
                state.index = index
                at = integers[each.table + CONSTANTS_OF] + each.size * index
                each.hits(reals[at : at + each.size], ray, search, hits, state, integers)
                after_row(scene, integers, reals, ray, search, state)
                if state.count > 0:
                    gather(
                        begin, roots, integers, reals, ray, hits, state, gathered, t, alpha, point, normal, rows
                    )  # fmt: skip

    @algorithm
    def all_hits(
        begin: Int, end: Int, roots: Int, scene: SCENE, integers: Ints, reals: Reals, origins: Reals,
        origin_stride: Int, directions: Reals, direction_stride: Int, t: InOut[Reals], alpha: InOut[Reals],
        point: InOut[Reals], normal: InOut[Reals], rows: InOut[Ints32], count: InOut[Ints32], status: InOut[Bytes],
    ) -> None:  # fmt: skip
        """All points of each ray's line on the only surface of the scene, in the order of t; also behind the origin."""
        ray = empty(RAY)
        search = empty(SEARCH)
        state = empty(STATE)
        gathered = empty(GATHERED)
        hits = empty(most, HIT)
        for i in range(begin, end):
            begin_search(scene, most, search, state)
            gathered.total = 0
            gathered.lost = 0
            is_ray = load_ray(origins, origin_stride, directions, direction_stride, i, ray)
            if is_ray:
                find_all(
                    i * roots, roots, scene, integers, reals, ray, search, hits, state, gathered, t, alpha, point,
                    normal, rows,
                )  # fmt: skip
            total = gathered.total if gathered.lost == 0 else 0
            count[i] = total
            said = search_status(search)
            status[i] = said if is_ray and gathered.lost == 0 else Status.INVALID
            for j in range(total, roots):
                store_none(i * roots + j, t, alpha, point, normal, rows)

    return all_hits
