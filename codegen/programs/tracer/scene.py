"""The scene compiler: which kernels and which parts of the driver a scene needs, and nothing else.

Kinds of surface are in surface_kinds.py.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ...errors import SceneError, suggest
from ...formulas.rays import boxes, rays, shading
from ...targets.c.instances import PORTABLE, SCALAR, Instance
from ...targets.templates import render
from .. import KernelSpec, Part, Program, program
from .records import C_TEXT
from .surface_kinds import METHODS, SurfaceKind, in_order, stock_kinds, surface_kind

#: Every program: the side of a normal that a ray sees.
_COMMON = (KernelSpec(rays.facing, ("unit", "position")),)
#: Programs that make pictures.
_PICTURE = (
    KernelSpec(shading.camera_position, ("motor",)),
    KernelSpec(shading.camera_direction, ("motor", "numbers3", "numbers2")),
    KernelSpec(shading.light_terms, ("position", "unit", "unit", "position", "number")),
)
_REFLECTION = (KernelSpec(rays.reflected_direction, ("position", "unit")),)
#: Programs that look at the boxes of rows.
_BOXES = (
    KernelSpec(boxes.box_ray, ("position", "position", "number")),
    KernelSpec(boxes.box_span, ("position",) * 5 + ("numbers2",)),
)
FLAGS = ("pictures", "layers", "reflection", "checker", "single", "tree")
#: Kinds of which several rays are met at once, in scenes that have no others.
WIDE_KINDS = frozenset(("plane", "sphere"))
#: Rows of surfaces from which on a tree over their boxes costs less than asking each; where several rays are met at
#: once, asking costs a fifth.
TREE_PAYS, TREE_PAYS_WIDE = 12, 48
#: Kernels are straight lines, and their loops are unrolled where it pays: what else compilers do takes them as long
#: again and gains nothing, but for vectors. Calls into parts are jumps.
QUICK = ("-O1", "-foptimize-sibling-calls")


@dataclass(frozen=True)
class SceneNeeds:
    """Features of a scene; equal needs are the same program.

    Attributes
    ----------
    kinds : tuple of str
        Kinds of surface, in their order.
    methods : tuple of str
        Of `METHODS`; empty where no surface has a choice.
    pictures, reflection, checker, single, layers, tree : bool
        Camera and light; mirrors; checkered surfaces; float32 besides float64; normals, depth and more of pictures;
        a tree over the boxes of many surfaces.
    """

    kinds: tuple[str, ...]
    methods: tuple[str, ...] = ()
    pictures: bool = True
    reflection: bool = False
    checker: bool = False
    single: bool = False
    layers: bool = False
    tree: bool = False

    @property
    def wide(self) -> bool:
        """True where the program meets several rays at once, of first hits."""
        return bool(self.kinds) and set(self.kinds) <= WIDE_KINDS and not self.tree

    def covers(self, other: SceneNeeds) -> bool:
        """Return whether a program for these needs serves the other's too."""
        return (
            set(other.kinds) <= set(self.kinds)
            and set(other.methods) <= set(self.methods)
            and all(getattr(self, flag) >= getattr(other, flag) for flag in FLAGS)
        )


#: What the wheel carries for machines without a compiler.
EVERYTHING = SceneNeeds(stock_kinds(), tuple(METHODS), True, True, True, True, True, True)


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
        used, chosen, pictures, pictures and reflection, pictures and checker, single, pictures and layers, tree
    )


def scene_program(wanted: SceneNeeds) -> Program:
    """The program for these needs: its kernels and its driver's text."""
    kinds = [surface_kind(name) for name in wanted.kinds]
    specs = [*_COMMON]
    if wanted.pictures:
        specs += _PICTURE
    if wanted.reflection:
        specs += _REFLECTION
    boxed = wanted.tree or any("bound" in dict(kind.layout) for kind in kinds)
    if boxed:
        specs += _BOXES
    specs += [d for kind in kinds if not kind.is_apart for d in kind.kernels]
    methods = [(method.upper(), int(method in wanted.methods)) for method in METHODS]
    features = {
        "PICTURES": wanted.pictures, "LAYERS": wanted.layers, "REFLECTION": wanted.reflection,
        "CHECKER": wanted.checker, "TREE": wanted.tree, "BOXES": boxed,
    }  # fmt: skip
    instances = SCALAR if wanted.single else SCALAR[:1]
    values = {
        "title": _title(wanted),
        "kinds": kinds,
        "roots": max((kind.roots for kind in kinds), default=1),
        "features": [*((name, int(value)) for name, value in features.items()), *methods],
        "instances": instances,
        "elementary": wanted.pictures,
        "records": C_TEXT if wanted.pictures else "",
        "wide": [i for i in PORTABLE if wanted.single or i.bits == 64] if wanted.wide else [],
    }
    parts = [_wide_part(values)] if wanted.wide else []
    parts += [
        _kind_part(kind, instance, wanted.methods, {"features": methods, "wide": ()})
        for instance in instances
        for kind in sorted(kinds, key=lambda kind: -kind.roots)
        if kind.is_apart
    ]
    return program("scene", specs, "scene.c.j2", "scene_types.h", values, QUICK, tuple(parts))


def _kind_part(kind: SurfaceKind, instance: Instance, methods: tuple[str, ...], values: Mapping[str, object]) -> Part:
    """The functions of one kind in one precision: the same for all scenes with it that look for roots in these ways."""
    kernels = (*kind.kernels, *(d for method, more in kind.methods if method in methods for d in more))
    title = f"{kind.name}, {instance.tag}"
    source = render("scene_unit.c.j2", title=title, kinds=[kind], roots=kind.roots, instance=instance, **values)
    return Part(kind.name, kernels, source, QUICK)


def _wide_part(values: Mapping[str, object]) -> Part:
    """The loop that meets several rays at once: vector code, which gains by all that compilers do."""
    kernels = tuple(d for name in sorted(WIDE_KINDS) for d in surface_kind(name).kernels)  # scene_wide.h has them all
    plain = {"title": "several rays at once", "features": (), "roots": 1, "elementary": False}
    source = render("scene_unit.c.j2", **{**values, **plain})
    return Part("scene_wide", kernels, source)


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
