"""Kinds of surface of scenes: each one's kernels, and the length of its row of constants.

A new kind is a new entry, its formulas, and its algorithms (hits.py says what they do). Evolved surfaces are families
with the degree of their curve in the name: ``evolved_circles_3``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache, partial

from ...errors import SceneError, suggest
from ...formulas.rays import facets, rays
from .. import KernelSpec
from .surfaces.circles import evolved_circles
from .surfaces.kind import RAY, SurfaceKind
from .surfaces.point_pairs import evolved_point_pairs

#: How roots of a ray and an evolved surface are found; the number is the driver's.
METHODS = {"isolate": 0, "companion": 1, "sampled": 2}
SPHERE_HIT = KernelSpec(rays.sphere_hit, (*RAY, "position", "number"))
_CORNERS = ("position",) * 3
_FACET = (
    KernelSpec(facets.facet_sides, (*RAY, *_CORNERS)),
    KernelSpec(facets.facet_hit, (*RAY, *_CORNERS, "numbers3")),
    KernelSpec(facets.facet_normal, _CORNERS),
)
_SMOOTH = KernelSpec(facets.smooth_normal, ("position", *_CORNERS, "unit", "unit", "unit", "numbers3"))
_DISC = tuple(
    KernelSpec(hit, (*RAY, "position", "unit", "number")) for hit in (rays.disc_hit, rays.disc_graze, rays.rim_hit)
)
#: Kinds that are no family; programs number theirs in this order, families after them.
PLAIN = {
    kind.name: kind
    for kind in (
        SurfaceKind("plane", 4, 4, (KernelSpec(rays.plane_hit, (*RAY, "unit", "number")),)),
        SurfaceKind("sphere", 4, 4, (SPHERE_HIT,), roots=2),
        SurfaceKind("disc", 7, 7, _DISC, roots=2),
        SurfaceKind("facet", 9, 9, _FACET),
        SurfaceKind("smooth_facet", 18, 18, (*_FACET, _SMOOTH)),
    )
}


#: Families: the word of their names, what makes the member of a degree, and the highest degree there is. The free ones
#: are of pieces that begin or end with sums that are no objects, as between knots.
FAMILIES: dict[str, tuple[Callable[[int], SurfaceKind], int]] = {
    "evolved_circles": (evolved_circles, 8),
    "evolved_circles_free": (partial(evolved_circles, free=True), 8),
    "evolved_point_pairs": (evolved_point_pairs, 8),
    "evolved_point_pairs_free": (partial(evolved_point_pairs, free=True), 8),
}
#: Degrees that the wheel carries for machines without a compiler.
STOCK_DEGREES = {"evolved_circles": (1, 2, 3), "evolved_point_pairs": (1, 2, 3)}
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
