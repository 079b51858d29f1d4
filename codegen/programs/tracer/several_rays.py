"""First hits of several rays at once on a few surfaces along curves: every row is asked for all of them together.

Rays of rare cases, such as those that touch a surface or lie in a circle's plane, are left to the search of single
rays, so that the text of several has nothing of what they take.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

from ...build import text_cache
from ...build.cpu_features import runs
from ...ir.loops.algorithm import Algorithm as algorithm
from ...ir.loops.language import NAN, Bytes, InOut, Ints, Ints32, Out, Reals, Vector, empty, largest, zeros
from ...status import Status
from ...targets.c.instances import WIDE
from ...targets.c.source import ExtensionSource
from .. import extension_of
from ..algorithms import algorithm_files
from .hits import CONSTANTS_OF, IDS_OF, ROWS_OF, begin_search, distance_of_origin, is_within, length
from .kernels import facing
from .plain_surfaces import PLAIN_ALGORITHMS
from .records import HIT, RAY, SCENE, SEARCH, STATE, TABLE
from .scene_needs import SceneNeeds
from .search import SurfaceAlgorithms
from .surface_kinds import surface_kind
from .surfaces.functions import curve_algorithms

#: Status of a ray that is left to the search of single rays.
DEFERRED = 255
#: Squared lengths of directions between one over it and it: others are scaled first, and left to the other search.
PLAIN = 2.0**64
#: Of four lanes: with eight, more of them wait for others (docs/accuracy/benchmarks.md, "Rays").
INSTANCE = WIDE[0]
#: Parameters of the algorithm that all rays share.
SHARED = ("scene", "integers", "reals")


def first_hit_algorithm(kinds: tuple[SurfaceAlgorithms, ...]) -> algorithm:
    """The algorithm of one ray, which several at once run."""

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
        either = zeros(3)
        begin_search(scene, 1, search, state)
        ray.origin[:] = origin
        ray.direction[:] = direction
        far = distance_of_origin(ray)
        square = direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]
        is_deferred = not (far <= largest() and square < PLAIN and square > 1.0 / PLAIN)
        if is_deferred:  # any other ray
            for i in range(3):
                ray.origin[i] = 0.0
                ray.direction[i] = 1.0
        for each in kinds:
            for index in range(integers[each.table + ROWS_OF]):
                state.kind = each.number
                state.index = index
                at = integers[each.table + CONSTANTS_OF] + each.size * index
                each.hits(reals[at : at + each.size], ray, search, hit, state, integers)
                is_deferred = is_deferred or state.status != Status.OK
        size = length(ray.direction)
        distance = hit[0].t * size
        is_hit = state.count > 0
        is_number = is_within(distance, ray)
        t[0] = distance if is_hit else NAN
        alpha[0] = hit[0].alpha if is_hit else NAN
        surface[0] = -1
        for i in range(3):
            point[i] = hit[0].point[i] if is_hit else NAN
            normal[i] = NAN
        for each in kinds:
            for index in range(integers[each.table + ROWS_OF]):
                if is_hit and state.hit_kind == each.number and state.hit_index == index:
                    at = integers[each.table + CONSTANTS_OF] + each.size * index
                    each.normal(either, reals[at : at + each.size], ray, hit[0])
                    normal[:] = facing(either, ray.direction)
                    surface[0] = integers[integers[each.table + IDS_OF] + index]
        status[0] = DEFERRED if is_deferred or (is_hit and not is_number) else Status.OK

    return first_hit


def meets_several(needs: SceneNeeds) -> bool:
    """Whether first hits of many rays are found several at once, where the processor has wide vectors.

    On surfaces along curves, with planes, spheres and discs among them. Not in a tree, where each ray has its own way.
    """
    known = all(name in PLAIN_ALGORITHMS or surface_kind(name).is_apart for name in needs.kinds)
    curves = any(surface_kind(name).is_apart for name in needs.kinds)
    return known and curves and not needs.tree and needs.methods == ("isolate",) and runs(INSTANCE)


def several_rays(needs: SceneNeeds) -> ExtensionSource:
    """C text of the loop over rays, ready to compile: `meets_several` holds."""

    def make() -> str:
        function = first_hit_algorithm(tuple(_surface(k, name) for k, name in enumerate(needs.kinds))).instance()
        return json.dumps(algorithm_files(function, (INSTANCE,), SHARED))

    sources = ("programs/tracer/several_rays.py", "../templates/c/programs/algorithm.c.j2", "specs/cga3d.toml")
    key = hashlib.sha256(repr(needs.kinds).encode()).hexdigest()
    return extension_of("several_rays", json.loads(text_cache.made_once("several_rays", sources, f"{key}.json", make)))


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
