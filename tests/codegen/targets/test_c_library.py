"""Functions of the C library, templates/c/lib, called one by one; rows and masks are in test_c_platform.py."""

from __future__ import annotations

import re
import subprocess
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.build.cpu_features import has_wide_vectors
from bladesmith.codegen.build.extension import compiler, load
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.codegen.targets.templates import included_headers

from ...support.checkout import CHECKOUT

needs_compiler = pytest.mark.skipif(compiler() is None, reason="no compiler")
C = CHECKOUT / "templates" / "c"
#: All headers but what is printed.
FORMATTED = sorted(p for p in C.rglob("*.h") if p.name != "elementary.h")

INTEGERS = (-(2**63), -(2**63) + 1, -(2**40), -7, -3, -1, 0, 1, 2, 3, 7, 2**40 + 1, 2**63 - 2, 2**63 - 1)
OF_INTEGERS = ("bs_min", "bs_max", "bs_quotient", "bs_remainder")
INSTANCES = [("f64_0", 64, 0), ("f32_0", 32, 0), ("f64_16", 64, 16), ("f32_16", 32, 16)]
if has_wide_vectors():
    INSTANCES += [("f64_32", 64, 32), ("f32_32", 32, 32)]
each_instance = pytest.mark.parametrize("tag", [tag for tag, _, _ in INSTANCES])
#: Numbers of a row: below a block, blocks, squares of blocks, and what is left over.
SIZES = (1, 2, 3, 4, 5, 7, 8, 11, 16, 33)

LOOPS = """
#define FUNCTION(name) ptrdiff_t called_##name(ptrdiff_t a, ptrdiff_t b) { return name(a, b); }
FUNCTION(bs_min) FUNCTION(bs_max) FUNCTION(bs_quotient) FUNCTION(bs_remainder)
ptrdiff_t called_bs_magnitude(ptrdiff_t a) { return bs_magnitude(a); }
"""
OF_INSTANCE = """
int lanes_@(void) { return W; }
S least_@(S a, S b) { return FN(bs_min)(a, b); }
S most_@(S a, S b) { return FN(bs_max)(a, b); }
/* Columns are in a place of their own, aligned; numbers of rows are where the caller has them. */
void gather_@(S *columns, const S *rows, ptrdiff_t stride, ptrdiff_t size, int lanes)
{
  V v[40];
  FN(bs_gather)(v, rows, stride, size, lanes);
  memcpy(columns, v, (size_t)size * sizeof(V));
}
void scatter_@(const S *columns, S *rows, ptrdiff_t stride, ptrdiff_t size, int lanes)
{
  V v[40];
  memcpy(v, columns, (size_t)size * sizeof(V));
  FN(bs_scatter)(v, rows, stride, size, lanes);
}
"""


@pytest.fixture(scope="module")
def library() -> Any:
    """The functions of all instances, for cffi."""
    lines = ["#include <string.h>", '#include "platform.h"']
    declared = [f"ptrdiff_t called_{name}(ptrdiff_t, ptrdiff_t);" for name in OF_INTEGERS]
    declared.append("ptrdiff_t called_bs_magnitude(ptrdiff_t);")
    for tag, bits, width in INSTANCES:
        begin, end = ("BS_V3_BEGIN", "BS_V3_END") if width == 32 else ("", "")
        lines += [begin, f"#define BS_BITS {bits}", f"#define BS_BYTES {width}", f"#define BS_TAG {tag}"]
        lines += [f'#include "{name}.h"' for name in ("instance", "rows", "loops", "lanes")]
        lines += [OF_INSTANCE.replace("@", tag)]
        lines += ['#include "instance_end.h"', end]
        number = "double" if bits == 64 else "float"
        declared += [
            f"int lanes_{tag}(void);", f"{number} least_{tag}({number}, {number});",
            f"{number} most_{tag}({number}, {number});",
            f"void gather_{tag}({number} *, const {number} *, ptrdiff_t, ptrdiff_t, int);",
            f"void scatter_{tag}(const {number} *, {number} *, ptrdiff_t, ptrdiff_t, int);",
        ]  # fmt: skip
    source = "\n".join([*lines, LOOPS])
    return load(ExtensionSource("c_library", "\n".join(declared), source, included_headers([source], ())))


def wrapped(value: int) -> int:
    """An integer in 64 bits."""
    return (value + 2**63) % 2**64 - 2**63


@needs_compiler
def test_integers_are_those_of_python(library: Any) -> None:
    """Where they have 64 bits: others wrap, and quotients by zero are zero."""
    expected = {
        "bs_min": min, "bs_max": max, "bs_quotient": lambda a, b: wrapped(a // b) if b else 0,
        "bs_remainder": lambda a, b: a % b if b else 0,
    }  # fmt: skip
    for name in OF_INTEGERS:
        for a, b in product(INTEGERS, repeat=2):
            assert getattr(library.lib, f"called_{name}")(a, b) == expected[name](a, b), (name, a, b)
    for a in INTEGERS:
        assert library.lib.called_bs_magnitude(a) == wrapped(abs(a))


@needs_compiler
@each_instance
def test_the_least_and_the_most_are_the_first_unless_the_second_is_less(tag: str, library: Any) -> None:
    numbers = (0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan)
    for a, b in product(numbers, repeat=2):
        for name, function in (("least", min), ("most", max)):
            found = np.float64(getattr(library.lib, f"{name}_{tag}")(a, b))
            assert found.tobytes() == np.float64(function(a, b)).tobytes() or np.isnan([found, function(a, b)]).all()


@needs_compiler
@each_instance
def test_rows_a_stride_apart_become_columns_and_columns_rows(tag: str, library: Any) -> None:
    """Rows of all lengths, at odd addresses, apart and one on another; lanes without an item have the last one."""
    dtype = np.dtype(np.float64 if tag.startswith("f64") else np.float32)
    random, lanes = np.random.default_rng(3), getattr(library.lib, f"lanes_{tag}")()
    ffi = library.ffi
    for size, gap, begin, count in product(SIZES, (0, 1, 5), (0, 1), range(1, lanes + 1)):
        stride = size + gap
        numbers = random.normal(size=begin + lanes * stride).astype(dtype)
        items = np.minimum(np.arange(lanes), count - 1)
        expected = np.stack([numbers[begin + stride * i : begin + stride * i + size] for i in items], 1)
        columns = np.empty((size, lanes), dtype)
        known = np.ascontiguousarray(numbers[: begin + stride * (count - 1) + size])  # nothing behind the last row
        getattr(library.lib, f"gather_{tag}")(
            _at(ffi, columns, 0, dtype), _at(ffi, known, begin, dtype), stride, size, count
        )
        np.testing.assert_array_equal(columns, expected)
        back = np.zeros_like(known)
        getattr(library.lib, f"scatter_{tag}")(
            _at(ffi, columns, 0, dtype), _at(ffi, back, begin, dtype), stride, size, count
        )
        places = begin + stride * np.arange(count)[:, None] + np.arange(size)
        np.testing.assert_array_equal(back[places], known[places])
        back[places] = 0
        assert not back.any()


def _at(ffi: Any, array: np.ndarray, begin: int, dtype: Any) -> Any:
    """A pointer to a number of an array; the buffer lives as long as the array."""
    return ffi.cast(f"{'double' if dtype == np.float64 else 'float'} *", ffi.from_buffer(array)) + begin


def test_the_headers_have_no_tags() -> None:
    assert len(FORMATTED) > 14
    for header in FORMATTED:
        assert not re.search(r"\{\{|\{%", header.read_text("utf-8")), header.name


@pytest.mark.peers
@pytest.mark.parametrize("header", FORMATTED, ids=lambda path: path.name)
def test_the_headers_are_formatted(header: Path) -> None:
    assert find_spec("clang_format"), "the extra ci has it"
    import clang_format

    done = subprocess.run(
        [clang_format.get_executable("clang-format"), "--dry-run", "-Werror", str(header)], capture_output=True
    )
    assert not done.returncode, done.stderr.decode()[:2000]
