"""Kinds of ribbons: surfaces evolved along pieces of curves of point pairs."""

from __future__ import annotations

from collections.abc import Callable

from ....formulas.curves import ribbon_constants, ribbons, surfaces
from ... import KernelSpec
from ..records import GIVEN
from .kind import RAY, SurfaceKind, piece_layout
from .rows import PairRows, spans


def evolved_point_pairs(degree: int, free: bool = False) -> SurfaceKind:
    """Point pairs along polynomial pieces: p has degree 6 n - 2 where pieces begin and end with pairs, else 6 n."""
    suffix = f"free_{degree}" if free else str(degree)
    name = f"evolved_point_pairs_{suffix}"
    squares = 2 * degree - (0 if free else 2)  # degree of Q
    norm, kappa, width = 2 * degree + 1, 2 * squares + 1, squares + degree + 1
    controls, products, meets = 10 * (degree + 1), 10 * width, degree + 1 + width
    scalars = (f"numbers{meets}", f"numbers{norm}", f"numbers{kappa}")
    at = ("number", "number")
    pair = (*scalars[1:], *at, f"numbers{controls}", f"numbers{products}")
    layout = (
        *piece_layout(),
        ("norm", norm), ("kappa", kappa), ("controls", controls), ("products", products), ("sizes", 2), ("levers", 4),
    )  # fmt: skip

    def kernel(formula: Callable[..., object], *kinds: str) -> KernelSpec:
        return KernelSpec(formula, kinds, f"{formula.__name__}_{suffix}")

    constants = ribbon_constants.ribbon_free_constants if free else ribbon_constants.ribbon_constants
    row = spans(layout)
    rows = PairRows(
        name,
        pairs=degree + 1,
        **spans((("meets", meets), ("other", meets), ("written", meets), ("other_kappa", kappa))),
        unit=row["unit"].begin,
        radius=row["bound"].end - 1,
        **{part: row[part] for part in ("bound", "spans", "norm", "kappa", "controls", "products", "sizes", "levers")},
        weight=1.0 if free else 0.5,
        is_free=free,
        printed=6 * degree,
        ends_at_one=True,
        polynomial=kernel(ribbons.ribbon_polynomial, *scalars),
        condition=kernel(ribbons.ribbon_condition, *scalars, *at),
        condition_bound=kernel(ribbons.ribbon_condition_bound, *scalars, *at),
        polynomial_bound=kernel(ribbons.ribbon_polynomial_bound, *scalars, *at),
        closed_alpha=kernel(ribbons.ribbon_closed_alpha, scalars[0]) if degree == 1 else None,
        published_polynomial=kernel(ribbons.ribbon_published_polynomial, *scalars),
        meet=kernel(ribbons.ribbon_meet, *scalars, *at),
        constants=KernelSpec(constants, (f"numbers{controls}",), f"ribbon_constants_{suffix}"),
        approach=KernelSpec(surfaces.evolved_approach, (*RAY, "position", "number")),
        ray=kernel(ribbons.ribbon_ray, *RAY, f"numbers{controls}", f"numbers{products}", "numbers4"),
        point=kernel(ribbons.ribbon_point, *RAY, *pair),
        position=kernel(ribbons.ribbon_position, "position", "position", *pair),
        ends=kernel(ribbons.ribbon_ends, *RAY, *pair),
        polish=kernel(ribbons.ribbon_polish, *RAY, "number", *pair),
        normal=kernel(ribbons.ribbon_normal, "position", *pair),
    )
    kernels = (
        rows.approach, rows.constants, rows.ray, rows.point, rows.position, rows.ends, rows.polish, rows.normal,
    )  # fmt: skip
    isolate = (
        rows.polynomial, rows.condition, rows.condition_bound, rows.polynomial_bound,
        *([rows.closed_alpha] if rows.closed_alpha else []),
    )  # fmt: skip
    methods = (
        ("isolate", isolate),
        ("companion", (rows.published_polynomial, rows.meet)),
        ("sampled", (rows.meet,)),
    )
    return SurfaceKind(
        name, GIVEN + controls, sum(size for _, size in layout), kernels, squares + 4 * degree, methods, layout, rows
    )
