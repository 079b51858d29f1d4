"""Kinds of surface of scenes: each one's kernels, its C fragment, the length of its row of constants.

A new kind is a new entry, a new fragment (scene_ray.h of templates says what it provides) and its
formulas. Evolved surfaces are families with the degree of their curve in the name: ``evolved_circles_3``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

from ...errors import SceneError, suggest
from ...formulas.curves import ribbon_constants, ribbons, surface_conditions, surface_points, surfaces
from ...formulas.rays import facets, rays
from .. import KernelSpec

#: How roots of a ray and an evolved surface are found; the number is the driver's.
METHODS = {"isolate": 0, "companion": 1, "sampled": 2}
_RAY = ("position", "position")


@dataclass(frozen=True)
class SurfaceKind:
    """Contribution of one kind of surface to a program.

    Attributes
    ----------
    name : str
        As programs and C functions spell it.
    parameters, constants : int
        Numbers that `prepare` takes, and that it leaves in a row for the driver.
    fragment : str
        Header of ``templates/c`` with its functions.
    kernels : tuple of KernelSpec
    methods : tuple of (str, tuple of KernelSpec)
        For surfaces whose roots can be found in several ways: what each way needs besides.
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
    kernels: tuple[KernelSpec, ...]
    roots: int = 1
    methods: tuple[tuple[str, tuple[KernelSpec, ...]], ...] = ()
    layout: tuple[tuple[str, int], ...] = ()
    defines: tuple[tuple[str, str], ...] = ()

    @property
    def is_apart(self) -> bool:
        """True where its functions take a compiler so long that they are a translation unit, once for all scenes."""
        return bool(self.methods)

    def slice(self, name: str) -> slice:
        """Slice of a part of the row of constants."""
        start = 0
        for part, size in self.layout:
            if part == name:
                return slice(start, start + size)
            start += size
        raise KeyError(name)


SPHERE_HIT = KernelSpec(rays.sphere_hit, (*_RAY, "position", "number"))
_CORNERS = ("position",) * 3
_FACET = (
    KernelSpec(facets.facet_sides, (*_RAY, *_CORNERS)),
    KernelSpec(facets.facet_hit, (*_RAY, *_CORNERS, "numbers3")),
    KernelSpec(facets.facet_normal, _CORNERS),
)
_SMOOTH = KernelSpec(facets.smooth_normal, ("position", *_CORNERS, "unit", "unit", "unit", "numbers3"))
_DISC = tuple(
    KernelSpec(hit, (*_RAY, "position", "unit", "number")) for hit in (rays.disc_hit, rays.disc_graze, rays.rim_hit)
)
#: Kinds that are no family; programs number theirs in this order, families after them.
PLAIN = {
    kind.name: kind
    for kind in (
        SurfaceKind("plane", 4, 4, "scene_plane.h", (KernelSpec(rays.plane_hit, (*_RAY, "unit", "number")),)),
        SurfaceKind("sphere", 4, 4, "scene_sphere.h", (SPHERE_HIT,), roots=2),
        SurfaceKind("disc", 7, 7, "scene_disc.h", _DISC, roots=2),
        SurfaceKind("facet", 9, 9, "scene_facet.h", _FACET),
        SurfaceKind("smooth_facet", 18, 18, "scene_smooth_facet.h", (*_FACET, _SMOOTH)),
    )
}


#: What the rows of every piece of a curve begin with.
_PIECE = (("center", 3), ("unit", 2), ("start", 1), ("length", 1), ("bound", 4), ("spans", 8))


def _evolved_circles(degree: int, free: bool = False) -> SurfaceKind:
    """Circles along polynomial pieces: p has degree 12 n - 4 where pieces begin and end with circles, else 12 n."""
    word = "free_" if free else ""
    squares = 2 * degree - (0 if free else 2)  # degree of Q
    norm, kappa, width = 2 * degree + 1, 2 * squares + 1, squares + degree + 1
    controls, products, meets = 10 * (degree + 1), 10 * width, 3 * (degree + 1 + width)
    roots = 4 * (norm - 1) + kappa - 1
    scalars = (f"numbers{meets}", f"numbers{norm}", f"numbers{kappa}")
    circle = (*scalars[1:], "number", "number", f"numbers{controls}", f"numbers{products}")

    def kernel(formula: Callable[..., object], *kinds: str) -> KernelSpec:
        return KernelSpec(formula, kinds, f"{formula.__name__}_{word}{degree}")

    condition, meet_square = (
        kernel(formula, *scalars, "number", "number")
        for formula in (surface_conditions.evolved_condition, surface_conditions.evolved_meet_square)
    )
    kernels = (
        KernelSpec(surfaces.evolved_nearest, _RAY),
        KernelSpec(surfaces.evolved_approach, (*_RAY, "position", "number")),
        KernelSpec(surfaces.square_term, ("number", "numbers5", "trivector", "trivector", "number")),
        KernelSpec(surfaces.kappa_term, ("number", "numbers5", "numbers5", "number")),
        KernelSpec(surfaces.product_term, ("numbers10", "numbers5", "trivector")),
        kernel(
            surface_conditions.evolved_sizes,
            f"numbers{norm}",
            f"numbers{kappa}",
            f"numbers{5 * (squares + 1)}",
            f"numbers{controls}",
            f"numbers{products}",
        ),
        kernel(surfaces.evolved_meets, *_RAY, f"numbers{controls}", f"numbers{products}"),
        kernel(surface_points.evolved_point, *_RAY, f"numbers{meets}", *circle),
        kernel(surface_points.evolved_sphere, *_RAY, *circle),
        kernel(surface_points.evolved_polish, *_RAY, "number", *circle),
        kernel(surface_points.evolved_normal, "position", *circle),
    )
    values = (surface_conditions.evolved_condition_rate, surface_conditions.evolved_polynomial_bound)
    methods = (
        (
            "isolate",
            (
                condition,
                kernel(surface_conditions.evolved_polynomial, *scalars),
                *(kernel(value, *scalars, "number", "number") for value in values),
                kernel(surface_conditions.evolved_condition_bound, *_RAY, scalars[0], *circle),
                kernel(surface_conditions.common_sphere_meets, *scalars[:2]),
                kernel(surface_conditions.common_sphere_condition, *scalars[:2], "number", "number"),
                kernel(
                    surface_conditions.common_sphere_condition_bound,
                    *_RAY,
                    *scalars[:2],
                    "number",
                    "number",
                    f"numbers{controls}",
                ),
                kernel(surface_conditions.common_sphere_polynomial, f"numbers{norm}"),
                kernel(surface_conditions.common_sphere_bound, f"numbers{norm}", "number", "number"),
            ),
        ),
        ("companion", (kernel(surface_conditions.evolved_published_polynomial, *scalars), meet_square)),
        ("sampled", (meet_square,)),
    )
    layout = (
        *_PIECE,
        ("norm", norm), ("kappa", kappa), ("controls", controls), ("products", products), ("sizes", 2),
    )  # fmt: skip
    return SurfaceKind(
        f"evolved_circles_{word}{degree}", 15 + controls, sum(size for _, size in layout), "scene_evolved.h",
        kernels, roots, methods, layout,
        (
            ("BS_MEMBER", f"evolved_circles_{word}{degree}"), ("BS_SUFFIX", f"{word}{degree}"),
            ("BS_DEGREE", str(degree)), ("BS_FREE", str(int(free))),
        ),
    )  # fmt: skip


def _evolved_point_pairs(degree: int, free: bool = False) -> SurfaceKind:
    """Point pairs along polynomial pieces: p has degree 6 n - 2 where pieces begin and end with pairs, else 6 n."""
    word = "free_" if free else ""
    squares = 2 * degree - (0 if free else 2)  # degree of Q
    norm, kappa, width = 2 * degree + 1, 2 * squares + 1, squares + degree + 1
    controls, products = 10 * (degree + 1), 10 * width
    scalars = (f"numbers{degree + 1 + width}", f"numbers{norm}", f"numbers{kappa}")
    at = ("number", "number")
    pair = (*scalars[1:], *at, f"numbers{controls}", f"numbers{products}")

    def kernel(formula: Callable[..., object], *kinds: str) -> KernelSpec:
        return KernelSpec(formula, kinds, f"{formula.__name__}_{word}{degree}")

    constants = ribbon_constants.ribbon_free_constants if free else ribbon_constants.ribbon_constants
    meet = kernel(ribbons.ribbon_meet, *scalars, *at)
    isolate = (
        kernel(ribbons.ribbon_polynomial, *scalars),
        *(
            kernel(formula, *scalars, *at)
            for formula in (ribbons.ribbon_condition, ribbons.ribbon_condition_bound, ribbons.ribbon_polynomial_bound)
        ),
        *([kernel(ribbons.ribbon_closed_alpha, scalars[0])] if degree == 1 else []),
    )
    layout = (
        *_PIECE,
        ("norm", norm), ("kappa", kappa), ("controls", controls), ("products", products), ("sizes", 2), ("levers", 4),
    )  # fmt: skip
    return SurfaceKind(
        f"evolved_point_pairs_{word}{degree}", 15 + controls, sum(size for _, size in layout), "scene_ribbons.h",
        (
            KernelSpec(surfaces.evolved_approach, (*_RAY, "position", "number")),
            KernelSpec(constants, (f"numbers{controls}",), f"ribbon_constants_{word}{degree}"),
            kernel(ribbons.ribbon_ray, *_RAY, f"numbers{controls}", f"numbers{products}", "numbers4"),
            kernel(ribbons.ribbon_point, *_RAY, *pair),
            kernel(ribbons.ribbon_position, "position", "position", *pair),
            kernel(ribbons.ribbon_ends, *_RAY, *pair),
            kernel(ribbons.ribbon_polish, *_RAY, "number", *pair),
            kernel(ribbons.ribbon_normal, "position", *pair),
        ),
        squares + 4 * degree,
        (
            ("isolate", isolate),
            ("companion", (kernel(ribbons.ribbon_published_polynomial, *scalars), meet)),
            ("sampled", (meet,)),
        ),
        layout,
        (
            ("BS_MEMBER", f"evolved_point_pairs_{word}{degree}"), ("BS_SUFFIX", f"{word}{degree}"),
            ("BS_DEGREE", str(degree)), ("BS_FREE", str(int(free))),
        ),
    )  # fmt: skip


#: Families: the word of their names, what makes the member of a degree, and the highest degree there is. The free ones
#: are of pieces that begin or end with sums that are no objects, as between knots.
FAMILIES: dict[str, tuple[Callable[[int], SurfaceKind], int]] = {
    "evolved_circles": (_evolved_circles, 8),
    "evolved_circles_free": (partial(_evolved_circles, free=True), 8),
    "evolved_point_pairs": (_evolved_point_pairs, 8),
    "evolved_point_pairs_free": (partial(_evolved_point_pairs, free=True), 8),
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
