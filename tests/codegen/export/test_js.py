"""Exported JavaScript: it has the bits of the installed library."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from bladesmith import errors
from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.export.bound import ExportedAlgorithm
from bladesmith.codegen.export.export import export
from bladesmith.codegen.export.options import ExportOptions
from bladesmith.codegen.export.unit import exported_unit
from bladesmith.codegen.language import Int, Real

from ...support.effort import FULL
from ...support.export import algorithms
from ...support.export.drivers import run_driver, run_program
from ...support.export.js import NODE, algorithm_program, kernels_program
from ...support.export.stock import different_rows, module_variants, modules, stock_cases

needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="no node")
MODULES = [(a, m) for a in ("pga3d", "cga2d", "cga3d") for m in modules(a)] if FULL else [("pga3d", "poses")]


@needs_node
@pytest.mark.slow
@pytest.mark.parametrize(("algebra", "module"), MODULES)
def test_stock_kernels_have_the_bits_of_the_library(algebra: str, module: str, tmp_path: Path) -> None:
    variants = module_variants(algebra, module)
    cases = list(stock_cases(algebra, variants, 10_000))
    export(variants, tmp_path, ExportOptions("js", "exported"))
    (tmp_path / "main.mjs").write_text(kernels_program(exported_unit("exported", variants), 10_000))
    for case, results in zip(cases, run_driver(NODE, cases, tmp_path), strict=True):
        rows = different_rows(case, results)
        assert not rows, f"{case.variant.kernel.name}: {len(rows)} items, the first of {case.inputs[rows[0]].tolist()}"


@needs_node
@pytest.mark.slow
@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("name", ["everything", "move_again", "digits"])
def test_algorithms_have_the_bits_of_c(name: str, tmp_path: Path) -> None:
    case = algorithms.algorithm_case(getattr(algorithms, name), algorithms.arguments(name))
    export([ExportedAlgorithm(name, case.function)], tmp_path, ExportOptions("js", "exported"))
    (tmp_path / "main.mjs").write_text(algorithm_program("exported", name, case.function, case.sizes, algorithms.ITEMS))
    run_program(NODE, case.inputs, tmp_path)
    algorithms.assert_same_results(case, tmp_path)


@needs_node
def test_integers_of_more_than_53_bits_are_refused(tmp_path: Path) -> None:
    @algorithm
    def product(n: Int) -> Int:
        """Square."""
        return n * n

    product.export("js", tmp_path, name="numbers")
    algorithms.wrapping.export("js", tmp_path, name="bits")
    (tmp_path / "main.mjs").write_text("""
        import assert from "node:assert";
        import { product } from "./numbers.mjs";
        import { wrapping } from "./bits.mjs";
        assert.equal(product(-(2 ** 26)), 2 ** 52);
        assert.ok(Object.is(product(-0), 0));
        assert.throws(() => product(2 ** 27), /134217728 times 134217728 has more than 53 bits/);
        assert.throws(() => wrapping([1, 2, 3], 1.0), RangeError);
    """)
    subprocess.run(NODE, cwd=tmp_path, check=True)


def test_names_that_become_one_are_refused(tmp_path: Path) -> None:
    @algorithm
    def clash(d_x: Real, dX: Real) -> Real:
        """Two arguments that JavaScript writes alike."""
        return d_x - dX

    with pytest.raises(errors.InputError, match="the arguments 'd_x' and 'dX' are both dX there"):
        clash.export("js", tmp_path)
    assert not list(tmp_path.iterdir())
    with pytest.raises(errors.InputError, match="js has no numbers of type 'float32'"):
        clash.export("js", tmp_path, dtype="float32")
