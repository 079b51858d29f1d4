"""One ray against all surfaces of a scene: the algorithms of one program, for the kinds of surface that it has."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import (
    NAN,
    Bool,
    Bytes,
    InOut,
    Int,
    Ints,
    Ints32,
    Out,
    Real,
    Reals,
    Rows,
    Static,
    Vector,
    any_item,
    empty,
    int_empty,
    largest,
    zeros,
)
from ...status import Status
from .hits import (
    AXES,
    BOXES_OF,
    CONSTANTS_OF,
    IDS_OF,
    ROWS_OF,
    TABLE_SIZE,
    TABLES,
    begin_search,
    is_within,
    length,
    load_ray,
    search_status,
)
from .kernels import box_ray, box_span, facing
from .records import HIT, RAY, SCENE, SEARCH, STATE, TRAVERSAL
from .tree.tree_search import PROGRESS, REACH, begin_tree, next_in_tree


@inlined
def store_none(
    place: Int, t: InOut[Reals], alpha: InOut[Reals], point: InOut[Reals], normal: InOut[Reals],
    surface: InOut[Ints32],
) -> None:  # fmt: skip
    """No hit."""
    surface[place] = -1
    t[place] = NAN
    alpha[place] = NAN
    for i in AXES:
        point[3 * place + i] = NAN
        normal[3 * place + i] = NAN


class SurfaceAlgorithms(NamedTuple):
    """A kind of surface in a program.

    Attributes
    ----------
    number : int
        In the program.
    table : int
        Where its table begins among a scene's integers.
    size : int
        Length of a row of its constants.
    hits, normal : Algorithm, Bound or CFunction
        See hits.py.
    prepare : Bound or CFunction, optional
        Makes a row of constants from a row of parameters, which are the constants of other kinds.
    given : int
        Length of a row of parameters.
    """

    number: int
    table: int
    size: int
    hits: Any
    normal: Any
    prepare: Any = None
    given: int = 0

    @property
    def is_curve(self) -> bool:
        """Whether rows are pieces of a curve: they have constants of their own."""
        return self.prepare is not None


class SearchAlgorithms(NamedTuple):
    """One ray, or all of some arrays, against all surfaces of a scene."""

    after_row: algorithm
    ask_row: algorithm
    find: algorithm
    normal: algorithm
    store: algorithm
    store_first: algorithm
    first_hits: algorithm


def prepare_algorithm(kinds: tuple[SurfaceAlgorithms, ...]) -> algorithm:
    """The algorithm of a program that makes rows of constants."""
    own = tuple(each for each in kinds if each.is_curve)

    @algorithm
    def prepare_rows(kind: Int, rows: Int, parameters: Reals, constants: InOut[Reals]) -> None:
        """Constants of rows of a kind that has some of its own."""
        for each in own:
            if kind == each.number:
                for i in range(rows):
                    given, to = each.given * i, each.size * i
                    each.prepare(parameters[given : given + each.given], constants[to : to + each.size])

    return prepare_rows


def search_algorithms(
    kinds: tuple[SurfaceAlgorithms, ...], has_tree: bool, has_boxes: bool, has_statuses: bool
) -> SearchAlgorithms:
    """The algorithms of a program.

    Parameters
    ----------
    kinds : tuple of SurfaceAlgorithms
    has_tree : bool
        Over the boxes of rows.
    has_boxes, has_statuses : bool
        Whether rows have boxes, and kinds may not be able to tell.
    """

    @inlined
    def normal_at(
        normal: Out[Vector[3]], kind: Int, index: Int, integers: Ints, reals: Reals, ray: RAY, hit: HIT
    ) -> None:
        """Unit normal at a hit, on the side that the ray comes from."""
        either = zeros(3)
        for each in kinds:
            if kind == each.number:
                at = integers[each.table + CONSTANTS_OF] + each.size * index
                each.normal(either, reals[at : at + each.size], ray, hit)
        normal[:] = facing(either, ray.direction)

    @algorithm
    def note_status(
        scene: SCENE, integers: Ints, reals: Reals, ray: RAY, search: InOut[SEARCH], state: InOut[STATE]
    ) -> None:
        """Keep what the row that was asked said, which could not tell, with the place where its box begins."""
        begin = -largest()
        if has_boxes:
            first = empty(3)
            last = empty(3)
            low = integers[TABLES + TABLE_SIZE * state.kind + BOXES_OF] + 6 * state.index
            near, far, inverse = box_ray(ray.origin, ray.direction, reals[REACH : REACH + 1])
            for i in range(3):
                is_backward = ray.direction[i] < 0.0
                first[i] = reals[low + 3 + i] if is_backward else reals[low + i]
                last[i] = reals[low + i] if is_backward else reals[low + 3 + i]
            span = box_span(near, far, inverse, first, last, (-largest(), largest()))
            begin = span[0]
        if state.status == Status.SINGULAR:
            if begin < search.singular:
                search.singular = begin
        elif begin < search.invalid:
            search.invalid = begin
        state.status = Status.OK

    @inlined
    def after_row(
        scene: SCENE, integers: Ints, reals: Reals, ray: RAY, search: InOut[SEARCH], state: InOut[STATE]
    ) -> None:
        """Count a row that was asked, and note what it said."""
        state.cost += 1
        if has_statuses and state.status != Status.OK:
            note_status(scene, integers, reals, ray, search, state)

    @inlined
    def ask_row(
        item: Int, scene: SCENE, integers: Ints, reals: Reals, ray: RAY, search: InOut[SEARCH],
        hits: InOut[Rows[HIT]], state: InOut[STATE],
    ) -> None:  # fmt: skip
        """Ask the row of an item."""
        state.kind = integers[scene.items_at + 2 * item]
        state.index = integers[scene.items_at + 2 * item + 1]
        for each in kinds:
            if state.kind == each.number:
                at = integers[each.table + CONSTANTS_OF] + each.size * state.index
                each.hits(reals[at : at + each.size], ray, search, hits, state, integers)
        after_row(scene, integers, reals, ray, search, state)

    @algorithm
    def find(
        is_any: Static, scene: SCENE, integers: Ints, reals: Reals, ray: RAY, search: InOut[SEARCH],
        hits: InOut[Rows[HIT]], state: InOut[STATE],
    ) -> None:  # fmt: skip
        """Ask every row that the ray may meet; where any hit will do, until there is one."""
        if has_tree:
            for item in range(scene.unbounded, scene.items):
                if is_any and state.count > 0:
                    return
                ask_row(item, scene, integers, reals, ray, search, hits, state)
            if is_any and state.count > 0:
                return
            progress = empty(PROGRESS)
            traversal = int_empty(TRAVERSAL)
            begin_tree(scene, integers, reals, ray, search, state, progress, traversal)
            while True:
                row = next_in_tree(scene, integers, reals, ray, search, state, progress, traversal)
                if row < 0:
                    return
                ask_row(row, scene, integers, reals, ray, search, hits, state)
                if is_any and state.count > 0:
                    return
        for each in kinds:
            state.kind = each.number
            for index in range(integers[each.table + ROWS_OF]):
                if is_any and not any_item(state.count == 0):  # not for some of several rays: others go on
                    return
                state.index = index
                at = integers[each.table + CONSTANTS_OF] + each.size * index
                each.hits(reals[at : at + each.size], ray, search, hits, state, integers)
                after_row(scene, integers, reals, ray, search, state)

    @inlined
    def store(
        place: Int, distance: Real, kind: Int, index: Int, integers: Ints, reals: Reals, ray: RAY, hit: HIT,
        t: InOut[Reals], alpha: InOut[Reals], point: InOut[Reals], normal: InOut[Reals],
    ) -> None:  # fmt: skip
        """A hit as a row of arrays."""
        at = 3 * place
        t[place] = distance
        alpha[place] = hit.alpha
        for i in AXES:
            point[at + i] = hit.point[i]
        normal_at(normal[at : at + 3], kind, index, integers, reals, ray, hit)

    @inlined
    def store_first(
        i: Int, is_ray: Bool, integers: Ints, reals: Reals, ray: RAY, search: SEARCH, hit: HIT, state: STATE,
        t: InOut[Reals], alpha: InOut[Reals], point: InOut[Reals], normal: InOut[Reals], surface: InOut[Ints32],
        status: InOut[Bytes],
    ) -> None:  # fmt: skip
        """What a ray has found. A hit that is too far away for a number is none, and the ray is not valid."""
        found = 0
        distance = 0.0
        if state.count > 0:
            distance = hit.t * length(ray.direction)
            if is_within(distance, ray):
                found = 1
        said = search_status(search)
        status[i] = said if is_ray and found == state.count else Status.INVALID
        if found > 0:
            ids = integers[TABLES + TABLE_SIZE * state.hit_kind + IDS_OF]
            surface[i] = integers[ids + state.hit_index]
            store(i, distance, state.hit_kind, state.hit_index, integers, reals, ray, hit, t, alpha, point, normal)
        else:
            store_none(i, t, alpha, point, normal, surface)

    @algorithm
    def first_hits(
        begin: Int, end: Int, scene: SCENE, integers: Ints, reals: Reals, origins: Reals, origin_stride: Int,
        directions: Reals, direction_stride: Int, t: InOut[Reals], alpha: InOut[Reals], point: InOut[Reals],
        normal: InOut[Reals], surface: InOut[Ints32], status: InOut[Bytes],
    ) -> None:  # fmt: skip
        """First hits of rays from one to another."""
        ray = empty(RAY)
        search = empty(SEARCH)
        state = empty(STATE)
        hit = zeros(1, HIT)
        for i in range(begin, end):
            begin_search(scene, 1, search, state)
            is_ray = load_ray(origins, origin_stride, directions, direction_stride, i, ray)
            if is_ray:
                find(False, scene, integers, reals, ray, search, hit, state)
            store_first(
                i, is_ray, integers, reals, ray, search, hit[0], state, t, alpha, point, normal, surface,
                status,
            )  # fmt: skip

    return SearchAlgorithms(after_row, ask_row, find, normal_at, store, store_first, first_hits)
