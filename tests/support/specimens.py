"""Test kernels that together cover every node type; each target is tested on them.

Small on purpose, except where size is the point.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from bladesmith.codegen.algebra.algebra import Kind, numbers, scalar_argument
from bladesmith.codegen.algebra.loader import algebra_from_data
from bladesmith.codegen.algebra.members import NumericSource, sample
from bladesmith.codegen.algebra.multivector import (
    Multivector,
    absolute,
    atan2,
    cos,
    exp,
    log,
    reciprocal,
    select,
    sin,
    sqrt,
    stumpff0,
    stumpff1,
    stumpff2,
    stumpff3,
)
from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
from bladesmith.codegen.api import KernelFunction
from bladesmith.codegen.build.cpu_features import best_instances
from bladesmith.codegen.build.extension import load
from bladesmith.codegen.execute.bound_kernels import BoundKernel, Library
from bladesmith.codegen.formulas.objects.blades import blade_projector, project_to_blade
from bladesmith.codegen.formulas.products.outcome import epsilon, is_finite, outcome, where_or_nan
from bladesmith.codegen.formulas.products.products import geometric, sandwich
from bladesmith.codegen.optimise.variants import as_written
from bladesmith.codegen.rings.protocol import STUMPFF
from bladesmith.codegen.status import Status
from bladesmith.codegen.targets.c.extension import extension_source
from bladesmith.codegen.trace.kernel import Kernel, interface
from bladesmith.codegen.trace.outputs import Result, row
from bladesmith.codegen.trace.trace import trace

#: Share of extreme coefficients in the last quarter of the rows: few enough that not all results are NaN.
EXTREME_SHARE = 0.15


@cache
def specimens() -> dict[str, Kernel]:
    """The kernels, by name."""
    cga, pga = (algebra_from_data(load_spec(stock_spec_path(name))) for name in ("cga3d", "pga3d"))
    motor, circle, number = cga.kind("motor"), cga.kind("circle"), scalar_argument(cga)
    project = KernelFunction(project_to_blade, [cga.layout("circle")], circle, "project", None)

    def blend_by_call(x: Multivector, y: Multivector, alpha: Multivector) -> Any:
        return project(_between(x, y, alpha))

    made = [
        *(trace(sandwich, [motor, cga.kind(k)], f"move_{k}") for k in ("point", "line", "circle")),
        trace(sandwich, [pga.kind("motor"), pga.kind("point")], "move_point"),
        trace(geometric, [motor, motor], "compose"),
        trace(geometric, [cga.kind("multivector")] * 2, "dense"),
        trace(project_to_blade, [cga.layout("circle")], "project"),
        trace(_blend, [circle, circle, number], "blend"),
        trace(blend_by_call, [circle, circle, number], "blend_by_call"),
        trace(_normalized, [cga.layout("rotor")], "normalized"),
        trace(_rows, [numbers(cga, 3), number], "rows"),
        trace(_masks, [number, number, number], "masks"),
        trace(_elementary, [numbers(cga, 2)], "elementary"),
    ]
    return {f"{kernel.algebra.name}_{kernel.name}": kernel for kernel in made}


def arguments(kernel: Kernel, count: int, seed: int = 1, dtype: Any = np.float64) -> list[Any]:
    """Arrays of ``count`` random members; in the last rows some coefficients are extreme."""
    source = NumericSource(count, seed, dtype=dtype)
    arrays = [_members(item.kind, source).astype(dtype) for item in kernel.inputs]
    limits = np.finfo(dtype)
    extremes = [0.0, -0.0, np.inf, -np.inf, np.nan, limits.max, limits.tiny, limits.smallest_subnormal]
    for array in arrays:
        rows = array[-(count // 4) :]
        chosen = source.random.random(rows.shape) < EXTREME_SHARE
        rows[chosen] = source.random.choice(extremes, size=int(chosen.sum()))
    return arrays


def _members(kind: Kind, source: NumericSource) -> Any:
    if kind.is_scalar_argument:
        return source.scalar()
    is_row = kind.form == "numbers"
    values = [source.scalar() for _ in kind.blades] if is_row else kind.values(sample(kind, source))
    return np.stack([np.broadcast_to(v, (source.count,)) for v in values], -1)


def _between(x: Multivector, y: Multivector, alpha: Multivector) -> Multivector:
    return alpha * x + (1 - alpha) * y


def _blend(x: Multivector, y: Multivector, alpha: Multivector) -> Multivector:
    z = _between(x, y, alpha)
    return blade_projector(z) * z


def _normalized(x: Multivector) -> tuple[Multivector, Result]:
    """A versor over its norm; NaN and a status where it has none to speak of."""
    square = x.scalar_product(~x)
    good, finite = square > epsilon(x), is_finite(x)
    code = outcome(x, (~finite, Status.INVALID), (~good, Status.SINGULAR))
    return x / where_or_nan(good & finite, sqrt(square)), code


def _rows(v: tuple[Multivector, ...], s: Multivector) -> tuple[Result, Result]:
    """Plain numbers in and out, with constants among the results."""
    a, b, c = v
    return row([a * b - s, s.constant(0), c / 3, s.constant(-2)]), row([absolute(a) * s], "size")


def _masks(a: Multivector, b: Multivector, c: Multivector) -> Multivector:
    """All predicates, and both kinds of zero."""
    inside = (a <= b) & ~(c < b)
    either = (a < 0) | inside
    return select(either, reciprocal(a) - b, -a * c) + select(inside, c - c, -(b * b))


def _elementary(v: tuple[Multivector, ...]) -> Result:
    a, b = v
    turns = [sin(a), cos(a), atan2(a, b), exp(a), log(absolute(b))]
    later = [a.new({0: a.ring.apply(name, b.scalar())}) for name in STUMPFF[4:]]
    return row([*turns, stumpff0(a), stumpff1(a), stumpff2(a * b), stumpff3(b), *later])


KERNELS = specimens()
VARIANTS = {name: as_written(kernel) for name, kernel in KERNELS.items()}


@cache
def _c_library() -> Library:
    instances = *best_instances("f64"), *best_instances("f32")
    return Library(load(extension_source("specimens", list(VARIANTS.values()), instances)))


def compiled_by_c(name: str) -> BoundKernel:
    """A specimen through the C target."""
    return BoundKernel(_c_library(), name, *interface(KERNELS[name]))


def as_tuple(results: Any) -> tuple[Any, ...]:
    return results if isinstance(results, tuple) else (results,)


def assert_same_bits(actual: Any, expected: Any, name: str) -> None:
    """Equal as integers; a NaN equals any NaN, since no rule fixes its bits."""
    for a, b in zip(as_tuple(actual), as_tuple(expected), strict=True):
        assert a.dtype == b.dtype and a.shape == b.shape
        bits = np.dtype(f"u{a.dtype.itemsize}")
        different = (a.view(bits) != b.view(bits)) & ~(np.isnan(a) & np.isnan(b))
        assert not different.any(), f"{name}: {a[different][:3]} instead of {b[different][:3]}"
