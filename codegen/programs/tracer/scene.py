"""The scene compiler: which kernels and which parts of the driver a scene needs, and nothing else.

Kinds of surface are in surface_kinds.py.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ...errors import SceneError, suggest
from ...targets.c.instances import OF_KERNELS, SCALAR, Instance
from ...targets.templates import render
from .. import Part, Program, program
from . import kernels
from .algorithms import HITS, LAYOUTS, c_headers
from .scene_needs import WIDE_KINDS, SceneNeeds
from .surface_kinds import METHODS, in_order, stock_kinds, surface_kind
from .surfaces import texts
from .surfaces.kind import SurfaceKind

#: Rows of surfaces from which on a tree over their boxes costs less than asking each; where several rays are met at
#: once, asking costs a fifth.
TREE_PAYS, TREE_PAYS_WIDE = 12, 48
#: Kernels are straight lines, and their loops are unrolled where it pays: what else compilers do takes them as long
#: again and gains nothing, but for vectors. Calls into parts are jumps.
QUICK = ("-O1", "-foptimize-sibling-calls")


#: What the wheel carries for machines without a compiler.
EVERYTHING = SceneNeeds(stock_kinds(), tuple(METHODS), True, True, True, True, True, True, True)


def needs(
    kinds: Sequence[str],
    methods: Sequence[str] = ("isolate",),
    *,
    pictures: bool = True,
    reflection: bool = False,
    checker: bool = False,
    single: bool = False,
    layers: bool = False,
    rows: int = 0,
) -> SceneNeeds:
    """Needs in their one spelling: sorted, without methods that no surface uses; ``rows`` of surfaces in all.

    Programs that make no pictures find all points of lines.

    Raises
    ------
    SceneError
        If a kind of surface or a method is unknown.
    """
    for method in methods:
        _check_method(method)
    used = in_order(set(kinds))
    choice = any(surface_kind(k).methods for k in used)
    chosen = tuple(m for m in METHODS if m in methods) if choice else ()
    tree = rows >= (TREE_PAYS_WIDE if set(used) <= WIDE_KINDS else TREE_PAYS)
    return SceneNeeds(
        used, chosen, pictures, pictures and reflection, pictures and checker, single, pictures and layers, tree,
        not pictures,
    )  # fmt: skip


def scene_program(wanted: SceneNeeds) -> Program:
    """The program for these needs: its kernels and its driver's text."""
    kinds = [surface_kind(name) for name in wanted.kinds]
    specs = [kernels.facing]
    if wanted.pictures:
        specs += [kernels.camera_position, kernels.camera_direction, kernels.light_terms]
    if wanted.reflection:
        specs.append(kernels.reflected_direction)
    if wanted.tree or any(kind.is_apart for kind in kinds):
        specs += [kernels.box_ray, kernels.box_span]
    specs += [d for kind in kinds if not kind.is_apart for d in kind.kernels]
    features = {"PICTURES": wanted.pictures, "LINES": wanted.lines, "TREE": wanted.tree}
    headers = c_headers(wanted)
    instances = SCALAR if wanted.single else SCALAR[:1]
    values = {
        "title": _title(wanted),
        "kinds": kinds,
        "features": [(name, int(value)) for name, value in features.items()],
        "instances": instances,
        "elementary": wanted.pictures,
        "tree": wanted.tree,
        "wide": [i for i in OF_KERNELS if wanted.single or i.bits == 64] if wanted.wide else [],
    }
    parts = [_wide_part(values, headers)] if wanted.wide else []
    parts += [
        _kind_part(kind, instance, wanted.methods, headers)
        for instance in instances
        for kind in sorted(kinds, key=lambda kind: -kind.roots)
        if kind.is_apart
    ]
    headers |= _surfaces(kinds, wanted.methods)
    return program("scene", specs, "scene.c.j2", "scene_types.h", values, QUICK, tuple(parts), headers=headers)


def _surfaces(kinds: Sequence[SurfaceKind], methods: tuple[str, ...]) -> dict[str, str]:
    """The headers of surfaces along curves, where there are some."""
    own = [kind for kind in kinds if kind.is_apart]
    functions = texts.surface_functions(own, methods)
    if not own:
        return {}
    return {texts.HEADER: texts.header(functions), texts.DECLARATIONS: texts.declarations(own, methods)}


def _kind_part(kind: SurfaceKind, instance: Instance, methods: tuple[str, ...], headers: Mapping[str, str]) -> Part:
    """The functions of one kind in one precision: the same for all scenes with it that look for roots in these ways."""
    specs = (*kind.kernels, *(d for method, more in kind.methods if method in methods for d in more))
    title = f"{kind.name}, {instance.tag}"
    source = render("scene_unit.c.j2", title=title, kinds=[kind], instance=instance, wide=())
    printed = {LAYOUTS: headers[LAYOUTS], HITS: headers[HITS], **_surfaces([kind], methods)}
    return Part(kind.name, specs, source, QUICK, printed)


def _wide_part(values: Mapping[str, object], headers: Mapping[str, str]) -> Part:
    """The loop that meets several rays at once: vector code, which gains by all that compilers do."""
    specs = tuple(d for name in sorted(WIDE_KINDS) for d in surface_kind(name).kernels)  # scene_wide.h has them all
    plain = {"title": "several rays at once", "elementary": False}
    source = render("scene_unit.c.j2", **{**values, **plain})
    return Part("scene_wide", specs, source, headers={LAYOUTS: headers[LAYOUTS]})


def _title(wanted: SceneNeeds) -> str:
    parts = ", ".join(wanted.kinds) or "an empty scene"
    return f"A scene of {parts}" + (f" ({', '.join(wanted.methods)})" if wanted.methods else "")


def with_method(wanted: SceneNeeds, method: str) -> SceneNeeds:
    """The same needs with another way to find roots."""
    _check_method(method)
    return replace(wanted, methods=(method,)) if wanted.methods else wanted


def _check_method(method: str) -> None:
    if method not in METHODS:
        known = ", ".join(METHODS)
        raise SceneError(f"there is no method {method!r}{suggest(method, METHODS)}; there are {known}.")
