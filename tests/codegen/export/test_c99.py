"""Exported C99: it compiles without a warning, and has the bits of the installed library."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from bladesmith.codegen.export.export import export
from bladesmith.codegen.export.options import ExportOptions
from bladesmith.codegen.export.unit import exported_unit
from bladesmith.errors import InputError

from ...support.export.drivers import WARNINGS, c_driver, run_driver
from ...support.export.small import algorithm_to_export, shifted, twice_shifted
from ...support.export.stock import different_rows, exported_modules, module_variants, stock_cases

GCC = ["gcc", "-std=c99", *WARNINGS, "-O1", "-ffp-contract=off"]


@pytest.mark.slow
@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize(("algebra", "module"), exported_modules())
def test_stock_kernels_have_the_bits_of_the_library(algebra: str, module: str, dtype: str, tmp_path: Path) -> None:
    variants = module_variants(algebra, module)
    cases = list(stock_cases(algebra, variants, 10_000, np.dtype(dtype)))
    export(variants, tmp_path, ExportOptions("c99", "exported", dtype))
    unit = exported_unit("exported", variants, "f64" if dtype == "float64" else "f32")
    (tmp_path / "main.c").write_text(c_driver(unit, 10_000))
    subprocess.run([*GCC, "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    for case, results in zip(cases, run_driver(["./main"], cases, tmp_path), strict=True):
        rows = different_rows(case, results)
        assert not rows, f"{case.variant.kernel.name}: {len(rows)} items, the first of {case.inputs[rows[0]].tolist()}"


def test_declarations_stand_apart_from_definitions(tmp_path: Path) -> None:
    items = [algorithm_to_export(shifted), algorithm_to_export(twice_shifted)]
    paths = export(items, tmp_path, ExportOptions("c99", "two", split=True))
    assert [p.name for p in paths] == ["two.h", "two.c"]
    program = """
        #include "two.h"
        int main(void) {
          double x[3] = {1.0, 2.0, 3.0};
          two_twice_shifted(x, 2.0);
          return x[2] != 7.0;
        }
    """
    (tmp_path / "main.c").write_text(program)
    subprocess.run([*GCC, "main.c", "two.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    subprocess.run(["./main"], cwd=tmp_path, check=True)


def test_other_languages_have_no_declarations_apart(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no header apart"):
        export([algorithm_to_export(shifted)], tmp_path / "new", ExportOptions("cpp", "one", split=True))
    assert not (tmp_path / "new").exists()
