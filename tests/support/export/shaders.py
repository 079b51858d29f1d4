"""Text of GLSL as a program of C++: its built-in functions, and arrays that are handed in and out."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from bladesmith.codegen.export.unit import Unit

from .drivers import c_program, prefixed

_SHADERS = [
    ("330", "frag", ""), ("300 es", "frag", ""), ("450", "frag", ""), ("320 es", "frag", ""),
    ("430", "comp", "layout(local_size_x = 1) in;"), ("310 es", "comp", "layout(local_size_x = 1) in;"),
]  # fmt: skip
_BUILT_IN = """
#include <cmath>
#include <cstring>
typedef unsigned int uint;
static int floatBitsToInt(float x) { int i; std::memcpy(&i, &x, 4); return i; }
static float intBitsToFloat(int i) { float x; std::memcpy(&x, &i, 4); return x; }
static float atan(float y, float x) { return std::atan2(y, x); }
using std::abs; using std::cos; using std::floor; using std::sin; using std::sqrt;
"""


def shader_program(unit: Unit, text: str, count: int) -> str:
    """A program of C++ for `run_driver`, of the unit as it is printed and its text."""
    return c_program(unit, count, _as_cpp(text), prefixed(unit), prefixed(unit))


def assert_valid_as_cpp(path: Path) -> None:
    """Compile the file's text as C++: where there is no compiler of shaders, most mistakes are seen."""
    program = path.with_name("shader.cpp")
    program.write_text(_as_cpp(path.read_text()))
    command = ["g++", "-fsyntax-only", "-Wall", "-Wextra", "-Wno-unused-function", "-Werror", program.name]
    subprocess.run(command, cwd=path.parent, check=True)


def _as_cpp(text: str) -> str:
    text = text.replace("__VERSION__", "330")
    text = re.sub(r"^precision .*;$", "", text, flags=re.MULTILINE)
    text = re.sub(r"\b(?:in)?out (\w+) (\w+)(\[\d+\])", r"\1 (&\2)\3", text)
    text = re.sub(r"\b(?:in)?out (\w+) (\w+)", r"\1 &\2", text)
    return _BUILT_IN + text


def assert_valid(path: Path) -> None:
    """Compile the file at the beginning of shaders of several versions."""
    if not shutil.which("glslangValidator"):
        pytest.skip("no glslangValidator (Debian: glslang-tools)")
    for version, stage, layout in _SHADERS:
        shader = path.with_name(f"shader.{stage}")
        shader.write_text(f"#version {version}\n{path.read_text()}\n{layout}\nvoid main() {{}}\n")
        found = subprocess.run(["glslangValidator", str(shader)], capture_output=True, text=True, check=False)
        assert found.returncode == 0 and "WARNING" not in found.stdout, f"{version} {stage}: {found.stdout}"
