"""The algorithms of a scene's program, printed for C and for numba; each text is made once for its sources."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from ..kernel_spec import is_without_cache
from .records import C_TEXT
from .surface_kinds import surface_kind

if TYPE_CHECKING:
    from ...ir.loops.nodes import Function
    from .scene_needs import SceneNeeds
    from .search import SurfaceAlgorithms

#: Headers of the C program: layouts; what kinds of surface that are compiled by themselves call, too; all else; the
#: tree's builder.
LAYOUTS, HITS, FUNCTIONS, BUILD = "scene_layouts.h", "scene_hits.h", "scene_functions.h", "scene_build.h"
#: What the texts depend on, from the package's folder; what these import counts too.
_SOURCES = (
    "programs/tracer/algorithms.py",
    *(
        f"programs/tracer/{name}.py"
        for name in ("lines", "picture", "plain_surfaces", "surfaces/functions", "tree/tree_building", "triangles")
    ),
    "specs/cga3d.toml",
)
_DIGITS = 16


def c_headers(wanted: SceneNeeds) -> dict[str, str]:
    """Headers of the C program by name."""
    headers: dict[str, str] = json.loads(_made_once("c", wanted, lambda: json.dumps(_c_texts(wanted))))
    return {LAYOUTS: C_TEXT, **headers}


def numba_program(wanted: SceneNeeds) -> tuple[str, str]:
    """Python text of the program, and what callers know of its functions: JSON as `stock.entries` makes it."""
    text, entries = json.loads(_made_once("numba", wanted, lambda: json.dumps(_numba_texts(wanted))))
    return text, entries


def _made_once(target: str, wanted: SceneNeeds, make: Callable[[], str]) -> str:
    from ..stock import kept_text

    flags = (wanted.pictures, wanted.lines, wanted.reflection, wanted.checker, wanted.layers, wanted.tree)
    key = repr((wanted.kinds, wanted.methods, flags))
    name = f"scene_{target}_{hashlib.sha256(key.encode()).hexdigest()[:_DIGITS]}"
    return make() if is_without_cache() else kept_text(name, make, _SOURCES)


def shared_functions() -> list[Function]:
    """What kinds of surface that are compiled by themselves call, and the rest of a program, too."""
    from .hits import accept_hit, length

    return [accept_hit.instance(), length.instance()]


def _c_texts(wanted: SceneNeeds) -> dict[str, str]:
    from ...targets.c.loops import c_functions
    from .hits import begin_search, load_ray
    from .tree.tree_building import build_tree

    first = shared_functions()
    functions = _functions(wanted, is_c=True)
    roots = [functions[name] for name in ("prepare_rows", "all_hits", "render") if name in functions]
    if wanted.tree:  # first hits by turns, see scene_rays.h
        roots += [begin_search.instance(), load_ray.instance(), functions["ask_row"], functions["store_first"]]
    else:
        roots.append(functions["first_hits"])
    texts = {HITS: c_functions(first), FUNCTIONS: c_functions(roots, printed=first)}
    return {**texts, BUILD: c_functions([build_tree.instance()])} if wanted.tree else texts


def _numba_texts(wanted: SceneNeeds) -> tuple[str, str]:
    from ..algorithms import numba_text
    from ..stock import entries
    from .tree.tree_building import build_tree

    functions = _functions(wanted, is_c=False)
    named = {n: functions[n] for n in ("prepare_rows", "first_hits", "all_hits", "render") if n in functions}
    named["build_tree"] = build_tree.instance()
    return numba_text("scene", {f"{name}_items": f for name, f in named.items()}), entries({"items": named})


def _functions(wanted: SceneNeeds, is_c: bool) -> Mapping[str, Function]:
    """The algorithms of a program by name; in C those of surfaces along curves stand elsewhere."""
    from .search import prepare_algorithm, search_algorithms

    kinds = tuple(_surface_algorithms(number, name, wanted.methods, is_c) for number, name in enumerate(wanted.kinds))
    all_kinds = [surface_kind(name) for name in wanted.kinds]
    own = any(kind.is_apart for kind in all_kinds)
    searches = search_algorithms(kinds, wanted.tree, wanted.tree or own, own)
    algorithms = [prepare_algorithm(kinds), searches.ask_row, searches.store_first, searches.first_hits]
    if wanted.lines:
        from .lines import line_algorithm

        most = 2 * max((kind.roots for kind in all_kinds), default=1)  # a root that only touches may have two points
        algorithms.append(line_algorithm(kinds, wanted.tree, searches, most))
    if wanted.pictures:
        from .picture import picture_algorithms

        pictures = picture_algorithms(searches, wanted.layers, wanted.reflection, wanted.checker)
        algorithms.append(pictures.render)
    return {each.name: each.instance() for each in algorithms}


def _surface_algorithms(number: int, name: str, methods: Sequence[str], is_c: bool) -> SurfaceAlgorithms:
    from .plain_surfaces import PLAIN_ALGORITHMS
    from .records import SCENE, TABLE
    from .search import SurfaceAlgorithms

    kind = surface_kind(name)
    table = SCENE.size + TABLE.size * number
    if kind.is_apart:
        from .surfaces.functions import any_method, c_functions_of, curve_algorithms

        own = (c_functions_of if is_c else curve_algorithms)(kind, methods)
        hits = any_method(kind, own)
        return SurfaceAlgorithms(number, table, kind.constants, hits, own.normal, own.prepare, kind.parameters)
    if name in PLAIN_ALGORITHMS:
        hits, normal = PLAIN_ALGORITHMS[name]
    else:
        from .triangles import TRIANGLE_ALGORITHMS

        hits, normal = TRIANGLE_ALGORITHMS[name]
    return SurfaceAlgorithms(number, table, kind.constants, hits, normal)
