"""Exported C++: it compiles without a warning, and has the bits of the installed library."""

from __future__ import annotations

import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from bladesmith.codegen.export.export import export
from bladesmith.codegen.export.options import ExportOptions
from bladesmith.codegen.export.unit import exported_unit
from bladesmith.codegen.library.kernels import stock_variant

from ...support.export.drivers import WARNINGS, cpp_driver, run_driver
from ...support.export.small import algorithm_to_export, copied, shifted, twice_shifted
from ...support.export.stock import different_rows, exported_modules, module_variants, stock_cases

STANDARD = ["-std=c++17", *WARNINGS]


@pytest.mark.slow
@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize(("algebra", "module"), exported_modules())
def test_stock_kernels_have_the_bits_of_the_library(algebra: str, module: str, dtype: str, tmp_path: Path) -> None:
    variants = module_variants(algebra, module)
    cases = list(stock_cases(algebra, variants, 10_000, np.dtype(dtype)))
    export(variants, tmp_path, ExportOptions("cpp", "exported", dtype))
    unit = exported_unit("exported", variants, "f64" if dtype == "float64" else "f32")
    (tmp_path / "main.cpp").write_text(cpp_driver(unit, 10_000))
    if shutil.which("clang++"):
        subprocess.run(["clang++", *STANDARD, "-fsyntax-only", "main.cpp"], cwd=tmp_path, check=True)
    subprocess.run(["g++", *STANDARD, "-O1", "-ffp-contract=off", "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    for case, results in zip(cases, run_driver(["./main"], cases, tmp_path), strict=True):
        rows = different_rows(case, results)
        assert not rows, f"{case.variant.kernel.name}: {len(rows)} items, the first of {case.inputs[rows[0]].tolist()}"


@pytest.mark.slow
def test_kernels_without_roots_are_constant_expressions_of_any_number(tmp_path: Path) -> None:
    export(module_variants("pga3d", "products"), tmp_path, ExportOptions("cpp", "pga"))
    program = """
        #include "pga.hpp"
        constexpr pga::Rotor<int> a{1, 2, 3, 4}, b{5, 6, 7, 8};
        static_assert(pga::geometric_rotor_rotor(a, b).s == 5 - 12 - 21 - 32, "");
        int main() { return 0; }
    """
    (tmp_path / "main.cpp").write_text(program)
    subprocess.run(["g++", *STANDARD, "main.cpp", "-fsyntax-only"], cwd=tmp_path, check=True)


@pytest.mark.slow
@pytest.mark.parametrize("compiler", [name for name in ("g++", "clang++") if shutil.which(name)])
def test_numbers_are_float_double_and_long_double_without_elementary_functions(compiler: str, tmp_path: Path) -> None:
    variants = [stock_variant("pga3d", name) for name in ("sandwich_motor_point", "exp_bivector_twist")]
    export(variants, tmp_path, ExportOptions("cpp", "pga"))
    program = """
        #include "pga.hpp"
        #include <cstdio>
        template <class T> void print() {
          const pga::Motor<T> m{T(0.6L), 0, 0, 0, T(-0.8L), 0, 0, 0};
          const pga::Point<T> y = pga::sandwich_motor_point(m, pga::Point<T>{0, 0, T(1), T(1)});
          std::printf("%.20Lf\\n", static_cast<long double>(y.e023));
        }
        int main() {
          print<float>();
          print<double>();
          print<long double>();
          ELEMENTARY
          return 0;
        }
    """
    call = "pga::exp_bivector_twist(pga::Line<{}>{{}}).s".format
    used = f"if (!({call('float')} == {call('double')})) return 1;"
    (tmp_path / "main.cpp").write_text(program.replace("ELEMENTARY", used))
    subprocess.run([compiler, *STANDARD, "-ffp-contract=off", "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    printed = subprocess.run(["./main"], cwd=tmp_path, check=True, capture_output=True, text=True).stdout.split()
    exact = Fraction(-28, 100)
    for text, epsilon in zip(printed, [2.0**-24, 2.0**-53, 2.0**-60], strict=True):
        assert abs(Fraction(text) - exact) <= 4 * epsilon
    (tmp_path / "main.cpp").write_text(program.replace("ELEMENTARY", f"return {call('long double')} != 1;"))
    found = subprocess.run(
        [compiler, *STANDARD, "main.cpp", "-fsyntax-only"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    first = next(line for line in found.stderr.splitlines() if "error:" in line)
    assert found.returncode != 0 and "float and double have these functions" in first


def test_algorithms_call_each_other(tmp_path: Path) -> None:
    export([algorithm_to_export(a) for a in (twice_shifted, shifted, copied)], tmp_path, ExportOptions("cpp", "two"))
    program = """
        #include "two.hpp"
        int main() {
          float x[3] = {1.0f, 2.0f, 3.0f}, y[2];
          two::twice_shifted(x, 2.0f);
          return two::copied(x, y, 0.0f) != 0.0f || y[1] != 6.0f || x[2] != 7.0f;
        }
    """
    (tmp_path / "main.cpp").write_text(program)
    subprocess.run(["g++", *STANDARD, "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    subprocess.run(["./main"], cwd=tmp_path, check=True)
