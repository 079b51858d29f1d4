"""Exported C99: it compiles without a warning, and has the bits of the installed library."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from bladesmith.codegen.export.export import export
from bladesmith.codegen.export.unit import exported_unit

from ...support.export.drivers import c_driver, run_driver
from ...support.export.stock import different_rows, module_variants, modules, stock_cases

GCC = ["gcc", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-O1", "-ffp-contract=off"]


@pytest.mark.slow
@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize(("algebra", "module"), [(a, m) for a in ("pga3d", "cga2d", "cga3d") for m in modules(a)])
def test_stock_kernels_have_the_bits_of_the_library(algebra: str, module: str, dtype: str, tmp_path: Path) -> None:
    variants = module_variants(algebra, module)
    cases = list(stock_cases(algebra, variants, 10_000, np.dtype(dtype)))
    export(variants, "c99", tmp_path, "exported", dtype)
    unit = exported_unit("exported", variants, "f64" if dtype == "float64" else "f32")
    (tmp_path / "main.c").write_text(c_driver(unit, 10_000))
    subprocess.run([*GCC, "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    for case, results in zip(cases, run_driver(["./main"], cases, tmp_path), strict=True):
        rows = different_rows(case, results)
        assert not rows, f"{case.variant.kernel.name}: {len(rows)} items, the first of {case.inputs[rows[0]].tolist()}"
