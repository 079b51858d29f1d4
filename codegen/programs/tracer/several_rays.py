"""Several rays at once on a few surfaces, most of them along curves: their first hits, and pixels of a picture.

Every row is asked for all of them together. Rays of rare cases, such as those that touch a surface or lie in a circle's
plane, are left to the search of single rays, so that the text of several has nothing of what they take.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from typing import Any, NamedTuple

from ...build import text_cache
from ...build.cpu_features import best_instances
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.algorithm import inlined
from ...ir.loops.language import NAN, Bytes, InOut, Int, Ints, Ints32, Out, Reals, Vector, empty, largest, zeros
from ...status import Status
from ...targets.c.source import ExtensionSource
from .. import extension_of
from ..algorithms import algorithm_files
from .hits import (
    CONSTANTS_OF,
    IDS_OF,
    ROWS_OF,
    TABLE_SIZE,
    TABLES,
    begin_search,
    distance_of_origin,
    is_within,
    length,
    search_status,
)
from .kernels import facing
from .picture import picture_algorithms
from .plain_surfaces import PLAIN_ALGORITHMS
from .records import DEFERRED, HIT, RAY, SCENE, SEARCH, STATE, TABLE
from .scene_needs import SceneNeeds
from .search import SearchAlgorithms, SurfaceAlgorithms, search_algorithms
from .surface_kinds import surface_kind
from .surfaces.functions import curve_algorithms

#: Squared lengths of directions between one over it and it: others are scaled first, and left to the other search.
PLAIN = 2.0**64
#: As many as the processor has lanes.
INSTANCE = best_instances("f64")[0]
#: What the texts depend on, from the package's folder; what these import counts too.
_SOURCES = ("programs/tracer/several_rays.py", "../templates/c/programs/algorithm.c.j2", "specs/cga3d.toml")


def several_search(needs: SceneNeeds) -> SearchAlgorithms:
    """The search of single rays, but for rays of rare cases, of which it says that it cannot tell.

    Normals are those of all rows, one after the other, so that no ray reads constants of its own.
    """
    kinds = tuple(_surface(k, name) for k, name in enumerate(needs.kinds))

    @inlined
    def normal_at(
        normal: Out[Vector[3]], kind: Int, index: Int, integers: Ints, reals: Reals, ray: RAY, hit: HIT
    ) -> None:
        """Unit normal at a hit, on the side that the ray comes from."""
        either = zeros(3)
        for each in kinds:
            for row in range(integers[each.table + ROWS_OF]):
                if kind == each.number and index == row:
                    at = integers[each.table + CONSTANTS_OF] + each.size * row
                    each.normal(either, reals[at : at + each.size], ray, hit)
        normal[:] = facing(either, ray.direction)

    return search_algorithms(kinds, False, False, True)._replace(normal=normal_at)


def first_hit_algorithm(search_of: SearchAlgorithms) -> algorithm:
    """The algorithm of one ray, which several at once run."""
    find, normal_at = search_of.find, search_of.normal

    @algorithm
    def first_hit(
        scene: SCENE, integers: Ints, reals: Reals, origin: Vector[3], direction: Vector[3], t: Out[Vector[1]],
        alpha: Out[Vector[1]], point: Out[Vector[3]], normal: Out[Vector[3]], surface: InOut[Ints32],
        status: InOut[Bytes],
    ) -> None:  # fmt: skip
        """First hit of a ray, or `DEFERRED`."""
        ray = empty(RAY)
        search = empty(SEARCH)
        state = empty(STATE)
        hit = zeros(1, HIT)
        begin_search(scene, 1, search, state)
        ray.origin[:] = origin
        ray.direction[:] = direction
        far = distance_of_origin(ray)
        square = direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]
        is_other = not (far <= largest() and square < PLAIN and square > 1.0 / PLAIN)
        if is_other:
            for i in range(3):
                ray.origin[i] = 0.0
                ray.direction[i] = 1.0
        find(False, scene, integers, reals, ray, search, hit, state)
        distance = hit[0].t * length(ray.direction)
        is_hit = state.count > 0
        is_number = is_within(distance, ray)
        said = search_status(search)
        t[0] = distance if is_hit else NAN
        alpha[0] = hit[0].alpha if is_hit else NAN
        surface[0] = -1
        for i in range(3):
            point[i] = hit[0].point[i] if is_hit else NAN
            normal[i] = NAN
        if is_hit:
            normal_at(normal, state.hit_kind, state.hit_index, integers, reals, ray, hit[0])
            surface[0] = integers[integers[TABLES + TABLE_SIZE * state.hit_kind + IDS_OF] + state.hit_index]
        is_deferred = is_other or said != Status.OK or (is_hit and not is_number)
        status[0] = DEFERRED if is_deferred else Status.OK

    return first_hit


def meets_several(needs: SceneNeeds) -> bool:
    """Whether many rays are met several at once, where the processor has wide vectors.

    On planes, spheres, discs and surfaces along curves. Not in a tree, where each ray has its own way.
    """
    known = all(name in PLAIN_ALGORITHMS or surface_kind(name).is_apart for name in needs.kinds)
    return known and not needs.tree and needs.methods in ((), ("isolate",)) and INSTANCE.wide


class SeveralProgram(NamedTuple):
    """A program that computes something for several rays at once, where `meets_several` holds.

    Attributes
    ----------
    name : str
    algorithm_of : callable
        Gives the algorithm for one ray: it depends on kinds of surface, mirrors and checkers alone.
    shared : tuple of str
        Its parameters that all rays share.
    """

    name: str
    algorithm_of: Callable[[SceneNeeds], algorithm]
    shared: tuple[str, ...]

    def extension(self, needs: SceneNeeds) -> ExtensionSource:
        """C text of the loop over rays or pixels, ready to compile."""

        def make() -> str:
            function = self.algorithm_of(needs).instance()
            return json.dumps(algorithm_files(function, (INSTANCE,), self.shared))

        return extension_of(self.name, json.loads(text_cache.made_once(self.name, _SOURCES, _key(needs), make)))

    def is_made(self, needs: SceneNeeds) -> bool:
        """Whether this or another process has made the text, and compiled it."""
        return text_cache.is_made(self.name, _SOURCES, _key(needs))


def _key(needs: SceneNeeds) -> str:
    key = repr((needs.kinds, needs.reflection, needs.checker, INSTANCE.tag))
    return f"{hashlib.sha256(key.encode()).hexdigest()}.json"


def _first_hit_of(needs: SceneNeeds) -> algorithm:
    return first_hit_algorithm(several_search(needs))


def _paint_of(needs: SceneNeeds) -> algorithm:
    return picture_algorithms(several_search(needs), False, needs.reflection, needs.checker, defers=True).paint


#: First hits, and colors of pixels.
PROGRAMS = {
    "rays": SeveralProgram("several_rays", _first_hit_of, ("scene", "integers", "reals")),
    "pixels": SeveralProgram("several_pixels", _paint_of, ("scene", "integers", "reals", "picture")),
}


def _surface(number: int, name: str) -> SurfaceAlgorithms:
    kind = surface_kind(name)
    table = SCENE.size + TABLE.size * number
    hits: Any
    normal: Any
    if kind.is_apart:
        own = curve_algorithms(kind, ("isolate",), defers=True)
        hits, normal = own.by_method["isolate"], own.normal
    else:
        hits, normal = PLAIN_ALGORITHMS[name]
    return SurfaceAlgorithms(number, table, kind.constants, hits, normal)
