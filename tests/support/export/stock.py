"""Stock kernels to export, with inputs and what the installed library makes of them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from bladesmith.codegen.algebra.algebra import Kind
from bladesmith.codegen.algebra.loader import algebra_from_data
from bladesmith.codegen.algebra.members import NumericSource, sample
from bladesmith.codegen.algebra.schema import load_spec, stock_spec_path
from bladesmith.codegen.compiler import bind_library
from bladesmith.codegen.declarations import by_module, declared_kernels
from bladesmith.codegen.generator import selected_variants
from bladesmith.codegen.optimise.variants import Variant
from bladesmith.codegen.targets.c.printer import symbol
from bladesmith.core.registry import stock_algebra

from ..effort import FULL

ALGEBRAS = ("pga3d", "cga2d", "cga3d")
#: Numbers that any coefficient may be.
SPECIAL = (
    0.0, -0.0, 1.0, -1.0, 5e-324, 1e-310, 2.2250738585072014e-308, 1e-200, 1e200, 1.7976931348623157e308,
    np.inf, -np.inf, np.nan, 1e5, 1e9, 1e22, np.pi, -np.pi / 2,
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A kernel, arrays of shape (items, coefficients) and the results' bits, one row for each item."""

    variant: Variant
    inputs: np.ndarray
    results: np.ndarray


@cache
def modules(algebra: str) -> dict[str, list[Any]]:
    """Declared kernels by module of formulas."""
    spec = load_spec(stock_spec_path(algebra))
    return by_module(declared_kernels(algebra_from_data(spec), spec["kernels"]))


def exported_modules() -> list[tuple[str, str]]:
    """Algebras and modules that are tested: one that has all that there is, or all of them."""
    return [(a, m) for a in ALGEBRAS for m in modules(a)] if FULL else [("pga3d", "poses")]


def module_variants(algebra: str, module: str) -> list[Variant]:
    """The variants of one module that were selected."""
    text = resources.files("bladesmith.generated").joinpath(algebra, "variants.json").read_text("utf-8")
    home = algebra_from_data(load_spec(stock_spec_path(algebra)))
    return [variant for _, variant in selected_variants(home, modules(algebra)[module], json.loads(text))]


def stock_cases(algebra: str, variants: list[Variant], count: int, dtype: Any = np.float64) -> Iterator[Case]:
    """Each kernel on random members of several sizes and on numbers of all extremes, in equal parts."""
    library = stock_algebra(algebra).stock.library
    assert library is not None
    for variant in variants:
        kernel = variant.kernel
        rng = np.random.default_rng(len(kernel.name))
        arrays = []
        for k, item in enumerate(kernel.inputs):
            part = count // 4
            sizes = [members(item.kind, part, 10 * k + n, scale) for n, scale in enumerate((1.0, 1e6, 1e-6))]
            with np.errstate(over="ignore"):
                wild = rng.choice(SPECIAL, (count - 3 * part, item.kind.size)) * rng.choice([1.0, 1.5, -0.7], (1,))
                arrays.append(np.concatenate([*sizes, wild]).astype(dtype))
        if np.dtype(dtype) == np.float32:  # eight lanes have exact errors of products below the normal numbers, too
            assert any(library.use(instance, symbol(kernel)) for instance in ("f32_v3", "f32_base"))
        compiled = bind_library(library, kernel, symbol(kernel))
        given = [a[:, 0] if i.kind.is_scalar_argument else a for a, i in zip(arrays, kernel.inputs, strict=True)]
        with np.errstate(all="ignore"):
            results = compiled(*(np.ascontiguousarray(a) for a in given))
        listed = results if isinstance(results, tuple) else (results,)
        rows = np.concatenate([np.asarray(r).reshape(count, -1).astype(dtype) for r in listed], axis=1)
        yield Case(variant, np.concatenate(arrays, axis=1), rows)


def members(kind: Kind, count: int, seed: int, scale: float) -> np.ndarray:
    """Random members."""
    source = NumericSource(count, seed, scale)
    columns = [source.scalar() for _ in range(kind.size)] if kind.form != "multivector" else kind.values(
        sample(kind, source)
    )  # fmt: skip
    return np.stack([np.broadcast_to(c, (count,)) for c in columns], -1)


def different_rows(case: Case, results: np.ndarray) -> list[int]:
    """Items whose bits differ, but for those of a NaN."""
    same = (results.view(f"u{results.itemsize}") == case.results.view(f"u{results.itemsize}")) | (
        np.isnan(results) & np.isnan(case.results)
    )
    return np.flatnonzero(~same.all(axis=1)).tolist()
