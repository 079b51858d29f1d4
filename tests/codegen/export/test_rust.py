"""Exported Rust: it compiles without a warning, and has the bits of the installed library."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from bladesmith import errors
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.export.bound import ExportedAlgorithm
from bladesmith.codegen.export.export import export
from bladesmith.codegen.export.options import ExportOptions
from bladesmith.codegen.export.unit import exported_unit
from bladesmith.codegen.language import Real, sqrt

from ...support.effort import FULL
from ...support.export import algorithms
from ...support.export.drivers import run_driver, run_program
from ...support.export.rust import RUSTC, algorithm_program, compile_rust, kernels_program
from ...support.export.stock import different_rows, module_variants, modules, stock_cases

pytestmark = pytest.mark.skipif(shutil.which("rustc") is None, reason="no rustc")
MODULES = [(a, m) for a in ("pga3d", "cga2d", "cga3d") for m in modules(a)] if FULL else [("pga3d", "poses")]


@pytest.mark.slow
@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize(("algebra", "module"), MODULES)
def test_stock_kernels_have_the_bits_of_the_library(algebra: str, module: str, dtype: str, tmp_path: Path) -> None:
    variants = module_variants(algebra, module)
    cases = list(stock_cases(algebra, variants, 10_000, np.dtype(dtype)))
    export(variants, tmp_path, ExportOptions("rust", "exported", dtype))
    unit = exported_unit("exported", variants, "f64" if dtype == "float64" else "f32")
    (tmp_path / "main.rs").write_text(kernels_program(unit, 10_000))
    for case, results in zip(cases, run_driver(compile_rust(tmp_path), cases, tmp_path), strict=True):
        rows = different_rows(case, results)
        assert not rows, f"{case.variant.kernel.name}: {len(rows)} items, the first of {case.inputs[rows[0]].tolist()}"


@pytest.mark.slow
@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("name", ["everything", "move_again", "digits", "wrapping"])
def test_algorithms_have_the_bits_of_c(name: str, tmp_path: Path) -> None:
    case = algorithms.algorithm_case(getattr(algorithms, name), algorithms.arguments(name))
    export([ExportedAlgorithm(name, case.function)], tmp_path, ExportOptions("rust", "exported"))
    (tmp_path / "main.rs").write_text(algorithm_program("exported", name, case.function, case.sizes, algorithms.ITEMS))
    run_program(compile_rust(tmp_path, "-C", "debug-assertions=on"), case.inputs, tmp_path)
    algorithms.assert_same_results(case, tmp_path)


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_module_needs_no_std_and_its_own_square_root_is_exact(dtype: str, tmp_path: Path) -> None:
    @algorithm
    def root(x: Real) -> Real:
        """Square root."""
        return sqrt(x)

    (path,) = root.export("rust", tmp_path, name="exported", dtype=dtype)
    (tmp_path / "lib.rs").write_text("#![no_std]\npub mod exported;\n")
    subprocess.run([*RUSTC, "--crate-type", "lib", "--emit", "metadata", "lib.rs"], cwd=tmp_path, check=True)
    real, bits = ("f64", 64) if dtype == "float64" else ("f32", 32)
    path.write_text(path.read_text().replace("mod math", "pub mod math"))
    (tmp_path / "main.rs").write_text(SQUARE_ROOTS.replace("REAL", real).replace("BITS", f"u{bits}"))
    compiled = compile_rust(tmp_path)
    subprocess.run(compiled, cwd=tmp_path, check=True)


SQUARE_ROOTS = """
mod exported;
fn check(x: REAL) {
    let (own, other, std) = (exported::math::portable_sqrt(x), exported::root(x), x.sqrt());
    assert!(own.to_bits() == std.to_bits() || std.is_nan() && own.is_nan(), "{x:e}: {own:e}, {std:e}");
    assert!(other.to_bits() == std.to_bits() || std.is_nan() && other.is_nan(), "{x:e}: {other:e}, {std:e}");
}
fn main() {
    let mut word: u64 = 88172645463325252;
    for _ in 0..200000 {
        word ^= word << 13;
        word ^= word >> 7;
        word ^= word << 17;
        let x = REAL::from_bits(word as BITS);
        check(x);
        check(x.abs());
        check((x * x).abs());
        check(REAL::from_bits((word as BITS) >> (word >> 59)));
    }
    for x in [0.0, -0.0, REAL::MAX, REAL::INFINITY, -REAL::INFINITY, REAL::NAN, 1.0, 4.0, 2.0, -1.0] {
        check(x);
    }
    for k in 0..2000 {
        check(REAL::from_bits(k));
        check(REAL::from_bits(REAL::MIN_POSITIVE.to_bits() + k - 1000));
        check(REAL::from_bits((1.0 as REAL).to_bits() + k - 1000));
    }
}
"""


def test_words_are_refused(tmp_path: Path) -> None:
    @algorithm
    def crate(x: Real) -> Real:
        """A word."""
        return x

    with pytest.raises(errors.InputError, match="the function 'crate' is a word of rust"):
        crate.export("rust", tmp_path, name="exported")
    assert not list(tmp_path.iterdir())
