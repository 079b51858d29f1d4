"""Kernels as functions of the loop IR: names inside are of their own, numbers are those of the precision."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bladesmith as bs
from bladesmith import codegen, pga3d
from bladesmith.codegen.export.unit import exported_unit

from ...support.export.drivers import WARNINGS
from ...support.targets.elementary import COMPILERS

CALLED = codegen.kernel(pga3d.layout("motor"), pga3d.layout("point"), name="called")(lambda m, e012: m >> e012)
NUMBER = codegen.scalar


def scaled(m: Any, m_e12: Any) -> Any:
    """An argument has the name of a coefficient of another one."""
    return m * m_e12


def wide(x: Any, x_e1: Any) -> Any:
    """Two coefficients have one name."""
    return x * x_e1[2]


def numbered(t0: Any, t1: Any, c0: Any, c0_e012: Any, out: Any, out_: Any, result_: Any) -> Any:
    """Arguments have the names of what is computed, called and returned."""
    both = (t0 + t1) * (t0 - t1)
    return CALLED(c0, CALLED(c0, c0_e012)) * (both * both * out * out_ * result_)


KERNELS = {
    "scaled": codegen.kernel(pga3d.kind("motor"), NUMBER)(scaled),
    "wide": codegen.kernel(bs.algebra(10).kind("bivector"), codegen.numbers(3))(wide),
    "numbered": codegen.kernel(
        NUMBER, NUMBER, pga3d.layout("motor"), pga3d.layout("point"), NUMBER, NUMBER, NUMBER, name="numbered"
    )(numbered),
}  # fmt: skip


def program(kernel: codegen.KernelFunction, inputs: list[np.ndarray]) -> str:
    """Prints what the kernel gives for one item."""
    (entry,) = exported_unit("own", [kernel.variant]).entries
    given = []
    for slot, numbers in zip(entry.inputs, inputs, strict=True):
        values = ", ".join(repr(v) for v in np.ravel(numbers).tolist())
        type = f"own_{slot.struct.name}" if slot.struct else f"const double[{slot.size}]"
        given.append(f"({type}){{{values}}}" if slot.size else values)
    (result,) = entry.outputs
    assert result.struct is not None
    printed = "".join(f'  printf("%.17g\\n", found.{field});\n' for field in result.struct.fields)
    return (
        f'#include "own.h"\n#include <stdio.h>\nint main(void)\n{{\n'
        f"  const own_{result.struct.name} found = own_{entry.name}({', '.join(given)});\n{printed}  return 0;\n}}\n"
    )


@pytest.mark.parametrize("name", list(KERNELS))
def test_names_that_meet_inside_are_told_apart(name: str, tmp_path: Path) -> None:
    kernel, rng = KERNELS[name], np.random.default_rng(3)
    inputs = [rng.normal(size=() if k.is_scalar_argument else k.size) for k in kernel.kinds]
    kernel.export("c99", tmp_path, name="own")
    (tmp_path / "main.c").write_text(program(kernel, inputs))
    subprocess.run(["gcc", "-std=c99", *WARNINGS, "-Wno-unused-function", "main.c", "-lm"], cwd=tmp_path, check=True)
    printed = subprocess.run(["./a.out"], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert np.allclose([float(x) for x in printed.split()], kernel.reference(*inputs), rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    ("language", "number"), [("c99", "INFINITY"), ("rust", "f32::INFINITY"), ("glsl", "intBitsToFloat(0x7f800000)")]
)
def test_numbers_beyond_the_precision_are_infinite(language: str, number: str, tmp_path: Path) -> None:
    @codegen.kernel(NUMBER, algebra=pga3d)
    def far(x):
        return 1e300 * x

    for path in far.export(language, tmp_path, dtype="float32"):
        assert f"{number} * x_s" in path.read_text()


@pytest.mark.parametrize(("dtype", "number"), [("float64", "(double)NAN"), ("float32", "NAN")])
def test_constants_have_the_type_of_the_file(dtype: str, number: str, tmp_path: Path) -> None:
    """Also the argument of a reduction that takes float64: -Wdouble-promotion says so otherwise, of clang at least."""
    logarithm: Callable[..., Any] = codegen.ga.log
    kernel = codegen.kernel(pga3d.kind("motor"), name="logarithm")(lambda m: codegen.ga.exp(logarithm(m)))
    (path,) = kernel.export("c99", tmp_path, dtype=dtype)
    assert f"= {number};" in path.read_text()
    warnings = [*WARNINGS, "-Wdouble-promotion", "-Wshadow", "-Wconversion", "-Wno-unused-function"]
    for compiler in COMPILERS:
        subprocess.run([compiler, "-std=c99", "-pedantic", *warnings, "-fsyntax-only", path], check=True)
