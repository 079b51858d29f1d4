"""Reverse derivatives of algorithms, exported: every language compiles them without a warning, with the bits of C."""

from __future__ import annotations

import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import Out, Real, Vector

from ...support.export.algorithms import ITEMS, AlgorithmCase, algorithm_case, assert_same_results
from ...support.export.drivers import WARNINGS, run_program
from ...support.export.js import NODE
from ...support.export.js import algorithm_program as js_program
from ...support.export.rust import algorithm_program as rust_program
from ...support.export.rust import compile_rust
from ...support.export.shaders import assert_valid, assert_valid_as_cpp
from ...support.targets.pullbacks import first_above, in_place, walk

pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


@algorithm
def unread(x: Real, out: Out[Vector[2]]) -> Real:
    """An array whose values the reverse sweep does not need."""
    out[0] = 2.0 * x
    out[1] = x
    return x * x


@cache
def case() -> AlgorithmCase:
    """Items of the walk's reverse derivative, and what C makes of them."""
    rng = np.random.default_rng(8)
    sizes = ((ITEMS, 8), (ITEMS, 5), (ITEMS,), (ITEMS, 5), (ITEMS,))
    return algorithm_case(walk.pullback(), [rng.normal(size=size) for size in sizes])


def c_program(file: str, function: str) -> str:
    """A program of C and C++: the walk's reverse derivative of each item."""
    return f"""
        #include "{file}"
        #include <stdio.h>
        int main(int count, char **names) {{
          FILE *in = fopen(names[1], "rb"), *out = fopen(names[2], "wb");
          double x[33];
          (void)count;
          while (fread(x, sizeof(double), 33, in) == 33) {{
            double bar[14];
            bar[13] = {function}(x, x + 8, x[13], x + 14, x[19], bar, bar + 8);
            fwrite(bar, sizeof(double), 14, out);
          }}
          return fclose(out) != 0;
        }}
    """


def run_compiled(compiler: list[str], text: str, folder: Path, options: list[str]) -> None:
    (folder / "main.txt").write_text(text)
    command = [*compiler, *WARNINGS, "-O1", "-ffp-contract=off", "main.txt", "-o", "main", *options]
    subprocess.run(command, cwd=folder, check=True)
    run_program(["./main"], case().inputs, folder)


@pytest.mark.compiles
@pytest.mark.parametrize("language", ["c99", "cpp"])
def test_c_and_cpp_have_the_bits(language: str, tmp_path: Path) -> None:
    walk.pullback().export(language, tmp_path, name="walks")
    if language == "c99":
        first_above.pullback("v", "limit").export("c99", tmp_path, name="above")
        in_place.pullback("x", "a").export("c99", tmp_path, name="places")
        unread.pullback().export("c99", tmp_path, name="unread")
        others = "".join(f'#include "{name}.h"\n' for name in ("above", "places", "unread"))
        text = others + c_program("walks.h", f"walks_{case().function.name}")
        run_compiled(["gcc", "-std=c99", "-x", "c"], text, tmp_path, ["-lm"])
    else:
        text = c_program("walks.hpp", f"walks::{case().function.name}")
        run_compiled(["g++", "-std=c++17", "-x", "c++"], text, tmp_path, [])
    assert_same_results(case(), tmp_path)


@pytest.mark.compiles
@pytest.mark.skipif(shutil.which("rustc") is None, reason="no rustc")
def test_rust_has_the_bits(tmp_path: Path) -> None:
    walk.pullback().export("rust", tmp_path, name="walks")
    program = rust_program("walks", case().function.name, case().function, case().sizes, ITEMS)
    (tmp_path / "main.rs").write_text(program)
    run_program(compile_rust(tmp_path), case().inputs, tmp_path)
    assert_same_results(case(), tmp_path)


@pytest.mark.skipif(shutil.which("node") is None, reason="no node")
def test_javascript_has_the_bits(tmp_path: Path) -> None:
    walk.pullback().export("js", tmp_path, name="walks")
    (tmp_path / "main.mjs").write_text(js_program("walks", case().function.name, case().function, case().sizes, ITEMS))
    run_program(NODE, case().inputs, tmp_path)
    assert_same_results(case(), tmp_path)


def test_shaders_with_it_are_valid(tmp_path: Path) -> None:
    (path,) = walk.pullback().export("glsl", tmp_path, name="walks")
    assert_valid_as_cpp(path)
    assert_valid(path)
