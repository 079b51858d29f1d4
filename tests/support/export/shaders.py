"""Text of GLSL as a program of C++: its built-in functions, and arrays that are handed in and out."""

from __future__ import annotations

import re

from bladesmith.codegen.export.unit import Unit

from .drivers import c_program, prefixed

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
    text = text.replace("__VERSION__", "330")
    text = re.sub(r"^precision .*;$", "", text, flags=re.MULTILINE)
    text = re.sub(r"\b(?:in)?out (\w+) (\w+)(\[\d+\])", r"\1 (&\2)\3", text)
    text = re.sub(r"\b(?:in)?out (\w+) (\w+)", r"\1 &\2", text)
    return c_program(unit, count, _BUILT_IN + text, prefixed(unit), prefixed(unit))
