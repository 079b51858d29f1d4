"""Exported GLSL: shaders with it are valid, and its text, run as C++, has the bits of the installed library."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from bladesmith.codegen.algorithm_api import AlgorithmFunction
from bladesmith.codegen.export.export import export
from bladesmith.codegen.export.languages.glsl import renamed
from bladesmith.codegen.export.options import ExportOptions
from bladesmith.codegen.export.unit import exported_unit, intrinsics_of
from bladesmith.codegen.rings.protocol import STUMPFF
from bladesmith.errors import InputError

from ...support.export.drivers import run_driver
from ...support.export.shaders import assert_valid, shader_program
from ...support.export.small import algorithm_to_export, copied, first_shifted, shifted, total, twice_shifted
from ...support.export.stock import Case, different_rows, exported_modules, module_variants, stock_cases

#: Numbers are float where nothing is said.
SHIM = ["g++", "-O1", "-ffp-contract=off", "-fsingle-precision-constant"]
_TURNING = frozenset(("sin", "cos", *STUMPFF))


@pytest.mark.slow
@pytest.mark.parametrize(("algebra", "module"), exported_modules())
def test_shaders_with_stock_kernels_are_valid(algebra: str, module: str, tmp_path: Path) -> None:
    (path,) = export(module_variants(algebra, module), tmp_path, ExportOptions("glsl", "exported"))
    assert_valid(path)


def test_shaders_with_algorithms_are_valid(tmp_path: Path) -> None:
    items = [algorithm_to_export(a) for a in (twice_shifted, shifted, copied)]
    (path,) = export(items, tmp_path, ExportOptions("glsl", "two"))
    assert_valid(path)
    text = re.sub(r"__VERSION__", "", path.read_text())
    assert "__" not in text and not re.search(r"\bgl_", text)


@pytest.mark.parametrize(("function", "what"), [(total, "an array of any length"), (first_shifted, "a part of 'x'")])
def test_algorithms_that_need_pointers_are_refused(function: AlgorithmFunction, what: str, tmp_path: Path) -> None:
    items = [algorithm_to_export(shifted), algorithm_to_export(function)]
    with pytest.raises(InputError, match=f"{function.__name__}.*{what}"):
        export(items, tmp_path / "new", ExportOptions("glsl", "some"))
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
@pytest.mark.parametrize(("algebra", "module"), exported_modules())
def test_stock_kernels_have_the_bits_of_the_library(algebra: str, module: str, tmp_path: Path) -> None:
    variants = module_variants(algebra, module)
    cases = list(stock_cases(algebra, variants, 10_000, np.float32))
    (path,) = export(variants, tmp_path, ExportOptions("glsl", "exported"))
    unit = renamed(exported_unit("exported", variants, "f32"))
    (tmp_path / "main.cpp").write_text(shader_program(unit, path.read_text(), 10_000))
    subprocess.run([*SHIM, "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    for entry, case, results in zip(unit.entries, cases, run_driver(["./main"], cases, tmp_path), strict=True):
        rows = different_rows(case, results)
        if intrinsics_of(entry.function) & _TURNING:
            rows = [k for k in rows if _turns_little(case, k)]
        assert not rows, f"{entry.name}: {len(rows)} items, the first of {case.inputs[rows[0]].tolist()}"


def _turns_little(case: Case, row: int) -> bool:
    """Whether no angle can be beyond what the text reduces itself."""
    return bool((np.abs(case.inputs[row]) < 500.0).all())
