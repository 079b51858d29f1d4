"""Kinds of surface of scenes: each one's kernels, its C fragment, the length of its row of constants.

A new kind is a new entry, a new fragment (templates/c/scene_ray.h says what it provides) and its formulas. Evolved
surfaces are families with the degree of their curve in the name: ``evolved_circles_3``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from ..errors import SceneError, suggest
from ..formulas import rays, surfaces
from . import Declared

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
        As programs and C functions spell it.
    parameters, constants : int
        Numbers that `prepare` takes, and that it leaves in a row for the driver.
    fragment : str
        Header of ``templates/c`` with its functions.
    kernels : tuple of Declared
    methods : tuple of (str, tuple of Declared)
        For surfaces whose roots can be found in several ways: what each way needs besides.
    headers : tuple of str
        What the fragment includes.
    roots : int
        The most points that one line can have on one row.
    layout : tuple of (str, int)
        Names and lengths of the parts of the row of constants, where Python reads them too.
    defines : tuple of (str, str)
        Macros that the fragment is included under; it undefines them.
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
    defines: tuple[tuple[str, str], ...] = ()

    def slice(self, name: str) -> slice:
        """Where a part of the row of constants stands."""
        start = 0
        for part, size in self.layout:
            if part == name:
                return slice(start, start + size)
            start += size
        raise KeyError(name)


SPHERE_HIT = Declared(rays.sphere_hit, (*_RAY, "position", "number"))
_MEET_SQUARE = Declared(surfaces.evolved_meet_square, ("numbers9", *_PARAMETER))
_EVOLVED = (
    SPHERE_HIT,
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

#: Kinds that are no family; programs number theirs in this order, families after them.
PLAIN = {
    kind.name: kind
    for kind in (
        SurfaceKind("plane", 4, 4, "scene_plane.h", (Declared(rays.plane_hit, (*_RAY, "unit", "number")),)),
        SurfaceKind("sphere", 4, 4, "scene_sphere.h", (SPHERE_HIT,), roots=2),
        SurfaceKind("disc", 7, 7, "scene_disc.h", (Declared(rays.disc_hit, (*_RAY, "position", "unit", "number")),)),
    )
}


def _evolved_circles(degree: int) -> SurfaceKind:
    return SurfaceKind(
        f"evolved_circles_{degree}", 19, 51, "scene_evolved.h", _EVOLVED, 8, _EVOLVED_METHODS,
        ("evolved.h", "roots.h", "companion.h"),
        (("center", 3), ("unit", 2), ("bound", 4), ("scalars", 2), ("circles", 40)),
    )  # fmt: skip


#: Families: the word of their names, what makes the member of a degree, and the highest degree there is.
FAMILIES: dict[str, tuple[Callable[[int], SurfaceKind], int]] = {"evolved_circles": (_evolved_circles, 1)}
#: Degrees that the wheel carries for machines without a compiler.
STOCK_DEGREES = {"evolved_circles": (1,)}
_MEMBER = re.compile(r"([a-z_]+)_([1-9][0-9]?)")


@cache
def surface_kind(name: str) -> SurfaceKind:
    """The kind of surface of a name.

    Raises
    ------
    SceneError
        If there is no such kind, or the degree is beyond the family's highest.
    """
    if name in PLAIN:
        return PLAIN[name]
    member = _MEMBER.fullmatch(name)
    family = FAMILIES.get(member.group(1)) if member else None
    if member is None or family is None:
        raise SceneError(f"there is no kind of surface {name!r}{suggest(name, [*PLAIN, *stock_kinds()])}.")
    make, highest = family
    degree = int(member.group(2))
    if degree > highest:
        raise SceneError(f"{member.group(1)} follow curves up to degree {highest}, not {degree}.")
    return make(degree)


def stock_kinds() -> tuple[str, ...]:
    """Names of the kinds that the wheel carries, in the order of programs."""
    return (*PLAIN, *(f"{family}_{degree}" for family, degrees in STOCK_DEGREES.items() for degree in degrees))


def in_order(names: set[str]) -> tuple[str, ...]:
    """Kinds as programs number them: the plain ones, then families by degree."""
    families = {
        name: (list(FAMILIES).index(name.rpartition("_")[0]), int(name.rpartition("_")[2]))
        for name in names
        if surface_kind(name) and name not in PLAIN
    }
    return (*(name for name in PLAIN if name in names), *sorted(families, key=lambda name: families[name]))
