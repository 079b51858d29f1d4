"""The scene compiler: which kernels and which parts of the driver a scene needs, and nothing else.

One entry of `SURFACES` per kind of surface: its kernels, its C fragment, the length of its row of constants.
A new kind is a new entry, a new fragment (templates/c/scene_ray.h says what it provides) and its formulas.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..errors import SceneError, suggest
from ..formulas import rays, surfaces
from ..targets.extension import SCALAR
from . import Declared, Program, program

#: How roots of a ray and an evolved surface are found; the number is the driver's.
METHODS = {"isolate": 0, "companion": 1, "sampled": 2}
_CIRCLES = ("trivector",) * 4
_RAY = ("position", "position")
_PARAMETER = ("numbers2", "number", "number")


@dataclass(frozen=True)
class SurfaceKind:
    """What one kind of surface adds to a program.

    Attributes
    ----------
    name : str
        As scenes and C functions spell it.
    parameters, constants : int
        Numbers that `prepare` takes, and that it leaves in a row for the driver.
    fragment : str
        Header of ``templates/c`` with its functions.
    kernels : tuple of Declared
    methods : dict of str to tuple of Declared
        For surfaces whose roots can be found in several ways: what each way needs besides.
    headers : tuple of str
        What the fragment includes.
    roots : int
        The most points that one line can have on it.
    layout : tuple of (str, int)
        Names and lengths of the parts of the row of constants, where Python reads them too.
    """

    name: str
    parameters: int
    constants: int
    fragment: str
    kernels: tuple[Declared, ...]
    roots: int = 1
    methods: tuple[tuple[str, tuple[Declared, ...]], ...] = ()
    headers: tuple[str, ...] = ()
    layout: tuple[tuple[str, int], ...] = ()

    def slice(self, name: str) -> slice:
        """Where a part of the row of constants stands."""
        start = 0
        for part, size in self.layout:
            if part == name:
                return slice(start, start + size)
            start += size
        raise KeyError(name)


_SPHERE = Declared(rays.sphere_hit, (*_RAY, "position", "number"))
_MEET_SQUARE = Declared(surfaces.evolved_meet_square, ("numbers9", *_PARAMETER))
_EVOLVED = (
    _SPHERE,
    Declared(surfaces.evolved_constants, ("position", "unit", "number") * 2),
    Declared(surfaces.evolved_ray, (*_RAY, *_CIRCLES)),
    Declared(surfaces.evolved_point, (*_RAY, *_PARAMETER, *_CIRCLES)),
    Declared(surfaces.evolved_sphere, (*_RAY, *_PARAMETER, *_CIRCLES)),
    Declared(surfaces.evolved_polish, (*_RAY, "number", *_PARAMETER, *_CIRCLES)),
    Declared(surfaces.evolved_normal, ("position", *_PARAMETER, *_CIRCLES)),
    Declared(surfaces.evolved_condition, ("numbers9", *_PARAMETER)),
)
_EVOLVED_METHODS = (
    (
        "isolate",
        (
            Declared(surfaces.evolved_octic, ("numbers9", "numbers2")),
            Declared(surfaces.evolved_octic_bound, ("numbers9", *_PARAMETER)),
        ),
    ),
    ("companion", (Declared(surfaces.evolved_dodecic, ("numbers9", "numbers2")), _MEET_SQUARE)),
    ("sampled", (_MEET_SQUARE,)),
)

#: All kinds of surface; a program numbers its own in this order.
SURFACES = {
    kind.name: kind
    for kind in (
        SurfaceKind("plane", 4, 4, "scene_plane.h", (Declared(rays.plane_hit, (*_RAY, "unit", "number")),)),
        SurfaceKind("sphere", 4, 4, "scene_sphere.h", (_SPHERE,), roots=2),
        SurfaceKind(
            "disc", 7, 7, "scene_disc.h", (Declared(rays.disc_hit, (*_RAY, "position", "unit", "number")),)
        ),
        SurfaceKind(
            "evolved_circles", 19, 51, "scene_evolved.h", _EVOLVED, 8, _EVOLVED_METHODS,
            ("evolved.h", "roots.h", "companion.h"),
            (("center", 3), ("unit", 2), ("bound", 4), ("scalars", 2), ("circles", 40)),
        ),
    )
}  # fmt: skip
#: Every program: the side of a normal that a ray sees.
_COMMON = (Declared(rays.facing, ("unit", "position")),)
#: Programs that make pictures.
_PICTURE = (
    Declared(rays.camera_position, ("motor",)),
    Declared(rays.camera_direction, ("motor", "numbers3", "numbers2")),
    Declared(rays.light_terms, ("position", "unit", "unit", "position", "number")),
)
_REFLECTION = (Declared(rays.reflected_direction, ("position", "unit")),)
_HEADERS = (
    "platform.h",
    "instance.h",
    "instance_end.h",
    "scene_types.h",
    "scene_common.h",
    "scene_ray.h",
    "scene_trace.h",
    "scene_loops.h",
)


FLAGS = ("pictures", "reflection", "checker", "single")


@dataclass(frozen=True)
class SceneNeeds:
    """What a scene is made of; equal needs are the same program.

    Attributes
    ----------
    kinds : tuple of str
        Kinds of surface, in the order of `SURFACES`.
    methods : tuple of str
        Of `METHODS`; empty where no surface has a choice.
    pictures, reflection, checker, single : bool
        Camera and light; mirrors; checkered surfaces; float32 besides float64.
    """

    kinds: tuple[str, ...]
    methods: tuple[str, ...] = ()
    pictures: bool = True
    reflection: bool = False
    checker: bool = False
    single: bool = False

    def covers(self, other: SceneNeeds) -> bool:
        """Whether a program for these needs serves the other's too."""
        return (
            set(other.kinds) <= set(self.kinds)
            and set(other.methods) <= set(self.methods)
            and all(getattr(self, flag) >= getattr(other, flag) for flag in FLAGS)
        )


#: What the wheel carries for machines without a compiler.
EVERYTHING = SceneNeeds(tuple(SURFACES), tuple(METHODS), True, True, True, True)


def needs(
    kinds: Sequence[str],
    methods: Sequence[str] = ("isolate",),
    *,
    pictures: bool = True,
    reflection: bool = False,
    checker: bool = False,
    single: bool = False,
) -> SceneNeeds:
    """Needs in their one spelling: sorted, without methods that no surface uses.

    Raises
    ------
    SceneError
        If a kind of surface or a method is unknown.
    """
    for kind in kinds:
        if kind not in SURFACES:
            raise SceneError(f"there is no kind of surface {kind!r}{suggest(kind, SURFACES)}.")
    for method in methods:
        _check_method(method)
    used = tuple(k for k in SURFACES if k in kinds)
    choice = any(SURFACES[k].methods for k in used)
    chosen = tuple(m for m in METHODS if m in methods) if choice else ()
    return SceneNeeds(used, chosen, pictures, pictures and reflection, pictures and checker, single)


def scene_program(wanted: SceneNeeds) -> Program:
    """The program for these needs: its kernels and its driver's text."""
    kinds = [SURFACES[name] for name in wanted.kinds]
    declared = [*_COMMON]
    if wanted.pictures:
        declared += _PICTURE
    if wanted.reflection:
        declared += _REFLECTION
    for kind in kinds:
        declared += kind.kernels
        for method, kernels in kind.methods:
            if method in wanted.methods:
                declared += kernels
    features = {
        "PICTURES": wanted.pictures, "REFLECTION": wanted.reflection, "CHECKER": wanted.checker,
        **{method.upper(): method in wanted.methods for method in METHODS},
    }  # fmt: skip
    fragments = [kind.fragment for kind in kinds]
    extra = [header for kind in kinds for header in kind.headers]
    values = {
        "title": _title(wanted),
        "kinds": kinds,
        "features": [(name, int(value)) for name, value in features.items()],
        "fragments": fragments,
        "instances": SCALAR if wanted.single else SCALAR[:1],
        "elementary": wanted.pictures,
    }
    headers = [*_HEADERS, *(["elementary.h"] if wanted.pictures else []), *fragments, *extra]
    return program("scene", declared, "c/scene.c.j2", "c/scene_types.h", headers, values)


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
