"""Kinds of surfaces evolved along pieces of curves of circles."""

from __future__ import annotations

from collections.abc import Callable

from ....formulas.curves import surface_conditions, surface_points, surfaces
from ... import KernelSpec
from ..records import GIVEN
from .kind import RAY, SurfaceKind, piece_layout
from .rows import CircleRows, spans


def evolved_circles(degree: int, free: bool = False) -> SurfaceKind:
    """Circles along polynomial pieces: p has degree 12 n - 4 where pieces begin and end with circles, else 12 n."""
    suffix = f"free_{degree}" if free else str(degree)
    name = f"evolved_circles_{suffix}"
    squares = 2 * degree - (0 if free else 2)  # degree of Q
    norm, kappa, width = 2 * degree + 1, 2 * squares + 1, squares + degree + 1
    controls, products, meets = 10 * (degree + 1), 10 * width, 3 * (degree + 1 + width)
    scalars = (f"numbers{meets}", f"numbers{norm}", f"numbers{kappa}")
    at = ("number", "number")
    circle = (*scalars[1:], *at, f"numbers{controls}", f"numbers{products}")
    layout = (
        *piece_layout(),
        ("norm", norm), ("kappa", kappa), ("controls", controls), ("products", products), ("sizes", 2),
    )  # fmt: skip

    def kernel(formula: Callable[..., object], *kinds: str) -> KernelSpec:
        return KernelSpec(formula, kinds, f"{formula.__name__}_{suffix}")

    row = spans(layout)
    rows = CircleRows(
        name,
        **spans((("meets", meets), ("origin", 3), ("direction", 3), ("shared", norm))),
        unit=row["unit"].begin,
        radius=row["bound"].end - 1,
        **{part: row[part] for part in ("bound", "spans", "norm", "kappa", "controls", "products", "sizes")},
        degree=degree,
        squares=squares,
        printed=12 * degree,
        ends_at_one=False,
        polynomial=kernel(surface_conditions.evolved_polynomial, *scalars),
        condition=kernel(surface_conditions.evolved_condition, *scalars, *at),
        rate=kernel(surface_conditions.evolved_condition_rate, *scalars, *at),
        condition_bound=kernel(surface_conditions.evolved_condition_bound, *RAY, scalars[0], *circle),
        polynomial_bound=kernel(surface_conditions.evolved_polynomial_bound, *scalars, *at),
        shared_meets=kernel(surface_conditions.common_sphere_meets, *scalars[:2]),
        shared_polynomial=kernel(surface_conditions.common_sphere_polynomial, f"numbers{norm}"),
        shared_condition=kernel(surface_conditions.common_sphere_condition, *scalars[:2], *at),
        shared_condition_bound=kernel(
            surface_conditions.common_sphere_condition_bound, *RAY, *scalars[:2], *at, f"numbers{controls}"
        ),
        shared_bound=kernel(surface_conditions.common_sphere_bound, f"numbers{norm}", *at),
        published_polynomial=kernel(surface_conditions.evolved_published_polynomial, *scalars),
        meet=kernel(surface_conditions.evolved_meet_square, *scalars, *at),
        square_term=KernelSpec(surfaces.square_term, ("number", "numbers5", "trivector", "trivector", "number")),
        kappa_term=KernelSpec(surfaces.kappa_term, ("number", "numbers5", "numbers5", "number")),
        product_term=KernelSpec(surfaces.product_term, ("numbers10", "numbers5", "trivector")),
        sizes_of=kernel(
            surface_conditions.evolved_sizes, *scalars[1:], f"numbers{5 * (squares + 1)}", f"numbers{controls}",
            f"numbers{products}",
        ),
        nearest=KernelSpec(surfaces.evolved_nearest, RAY),
        approach=KernelSpec(surfaces.evolved_approach, (*RAY, "position", "number")),
        ray=kernel(surfaces.evolved_meets, *RAY, f"numbers{controls}", f"numbers{products}"),
        point=kernel(surface_points.evolved_point, *RAY, scalars[0], *circle),
        sphere=kernel(surface_points.evolved_sphere, *RAY, *circle),
        polish=kernel(surface_points.evolved_polish, *RAY, "number", *circle),
        normal=kernel(surface_points.evolved_normal, "position", *circle),
    )  # fmt: skip
    kernels = (
        rows.nearest, rows.approach, rows.square_term, rows.kappa_term, rows.product_term, rows.sizes_of, rows.ray,
        rows.point, rows.sphere, rows.polish, rows.normal,
    )  # fmt: skip
    isolate = (
        rows.condition, rows.polynomial, rows.rate, rows.polynomial_bound, rows.condition_bound, rows.shared_meets,
        rows.shared_condition, rows.shared_condition_bound, rows.shared_polynomial, rows.shared_bound,
    )  # fmt: skip
    methods = (
        ("isolate", isolate),
        ("companion", (rows.published_polynomial, rows.meet)),
        ("sampled", (rows.meet,)),
    )
    return SurfaceKind(
        name,
        GIVEN + controls,
        sum(size for _, size in layout),
        kernels,
        4 * (norm - 1) + kappa - 1,
        methods,
        layout,
        rows,
    )
