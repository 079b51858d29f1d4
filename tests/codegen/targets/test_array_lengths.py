"""Compilers of C find calls of kernels and of algorithms with arrays that are too small."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from bladesmith.codegen import algorithm, compiler
from bladesmith.codegen.build.cpu_features import has_wide_vectors
from bladesmith.codegen.build.flags import C_FLAGS, WARNING_FLAGS
from bladesmith.codegen.build.toolchain import compiler as c_compiler
from bladesmith.codegen.language import InOut, IntVector, Out, Vector
from bladesmith.codegen.programs.algorithms import algorithm_text

from ...support.checkout import CHECKOUT
from ...support.specimens import VARIANTS

HEADERS = CHECKOUT / "templates" / "c" / "lib"
WIDTHS = (0, 16, 32) if has_wide_vectors() else (0, 16)
#: As gcc and clang say it.
TOO_SMALL = ("in a region of size", "from a region of size", "array argument is too small")


@algorithm
def shifted(x: Vector[3], by: IntVector[2], y: InOut[Vector[4]], z: Out[Vector[2]]) -> None:
    """Arrays of numbers and integers, read, changed and written."""
    for i in range(2):
        y[i] += x[by[i]]
        z[i] = y[i + 2]


def errors_of(folder: Path, text: str, call: str, width: int) -> str:
    """What the compiler says of a call in a function of its own."""
    source = f"""
#include "platform.h"
#define BS_BITS 64
#define BS_BYTES {width}
#define BS_TAG tried
{"BS_V3_BEGIN" if width == 32 else ""}
#include "instance.h"
#include "loops.h"
{text}
void called(void *);
void calling(void);
void calling(void)
{{
  {call}
}}
{"BS_V3_END" if width == 32 else ""}
"""
    (folder / "unit.c").write_text(source, encoding="utf-8")
    chosen = c_compiler()
    assert chosen is not None
    command = [*chosen.command, *C_FLAGS, "-O1", *WARNING_FLAGS, f"-I{HEADERS}", "-c", "unit.c", "-o", "unit.o"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert bool(done.returncode) == bool(done.stderr)
    return done.stderr


@pytest.mark.skipif(c_compiler() is None, reason="no compiler")
@pytest.mark.parametrize("width", WIDTHS)
def test_a_kernel_is_called_with_arrays_of_its_sizes(width: int, tmp_path: Path) -> None:
    text = compiler.print_function(VARIANTS["cga3d_move_point"])
    call = "V out[{0}], r[{1}] = {{0}}, x[{2}] = {{0}}; FN(cga3d_move_point)(out, r, x); called(out);"
    assert errors_of(tmp_path, text, call.format(5, 8, 5), width) == ""
    for sizes in ((4, 8, 5), (5, 7, 5), (5, 8, 4)):
        assert any(words in errors_of(tmp_path, text, call.format(*sizes), width) for words in TOO_SMALL), sizes


@pytest.mark.skipif(c_compiler() is None, reason="no compiler")
def test_an_algorithm_is_called_with_arrays_of_its_sizes(tmp_path: Path) -> None:
    text = algorithm_text(shifted.specialised([p.type for p in shifted.text.parameters]))
    call = "S x[{0}] = {{0}}, y[{2}] = {{0}}, z[{3}]; ptrdiff_t by[{1}] = {{0}}; "
    call += "FN(shifted)(x, by, y, z); called(y); called(z);"
    assert errors_of(tmp_path, text, call.format(3, 2, 4, 2), 0) == ""
    for sizes in ((2, 2, 4, 2), (3, 1, 4, 2), (3, 2, 3, 2), (3, 2, 4, 1)):
        assert any(words in errors_of(tmp_path, text, call.format(*sizes), 0) for words in TOO_SMALL), sizes
