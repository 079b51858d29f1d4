"""The C platform layer: every instance compiles without a warning, masks mean what they say, rows arrive as columns."""

from __future__ import annotations

import ctypes
import mmap
import os
import platform
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.build.cpu_features import has_wide_vectors, runs
from bladesmith.codegen.build.flags import C_FLAGS, WARNING_FLAGS
from bladesmith.codegen.execute.nvrtc import compile_text
from bladesmith.codegen.targets.c.instances import BY_TAG

from ...support.checkout import CHECKOUT
from ...support.targets.widths import WIDTHS, enclosed

HEADERS = CHECKOUT / "templates" / "c" / "lib"
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)] or ["cc"]
ROWS = range(1, 41)
TAILS = (
    *range(1, 14),
    16,
    31,
    32,
    33,
    40,
)  # their text is long, and repeats itself with the length of a block
INSTANCES = [(bits, width) for bits in (64, 32) for width in WIDTHS]
each_instance = pytest.mark.parametrize("bits,width", INSTANCES)

#: Rows to the lanes of columns, and back, for every k; and a count of rows below W.
BODY = """
#define TRANSPOSE(k)                                                    \\
    void FN(columns_##k)(S *out, const S *rows)                         \\
    {                                                                   \\
        V v[k];                                                         \\
        FN(load_rows)(v, rows, k);                                      \\
        memcpy(out, v, sizeof v);                                       \\
    }                                                                   \\
    void FN(rows_##k)(S *out, const S *columns)                         \\
    {                                                                   \\
        V v[k];                                                         \\
        memcpy(v, columns, sizeof v);                                   \\
        FN(store_rows)(out, v, k);                                      \\
    }
#define TAIL(k)                                                         \\
    void FN(tail_columns_##k)(S *out, const S *rows, ptrdiff_t count)   \\
    {                                                                   \\
        V v[k];                                                         \\
        FN(load_tail)(v, rows, k, (int)count);                          \\
        memcpy(out, v, sizeof v);                                       \\
    }                                                                   \\
    void FN(tail_rows_##k)(S *out, const S *columns, ptrdiff_t count)   \\
    {                                                                   \\
        V v[k];                                                         \\
        memcpy(v, columns, sizeof v);                                   \\
        FN(store_tail)(out, v, k, (int)count);                          \\
    }
TRANSPOSES
int FN(lanes)(void) { return W; }
void FN(broadcast)(S *out, const S *row)
{
    V v[5];
    FN(load_broadcast)(v, row, 5);
    FN(store_rows)(out, v, 5);
}
/* a row: a, b, c; results: a choice by every predicate, a root, a size, an any */
void FN(masks)(S *out, const S *rows)
{
    V v[3], r[9];
    FN(load_rows)(v, rows, 3);
    V a = v[0], b = v[1], c = v[2], yes = SPLAT(1), no = SPLAT(K(-0.0));
    M less = LT(a, b);
    r[0] = SELECT(less, yes, no);
    r[1] = SELECT(LE(a, b), yes, no);
    r[2] = SELECT(GT(a, K(0.5)), a, b);
    r[3] = SELECT(GE(a, b), yes, no);
    r[4] = SELECT(OR(EQ(a, b), NE(b, c)), yes, no);
    r[5] = SELECT(AND(NOT(less), NOT(LT(b, c))), a, c);
    r[6] = SQRT(ABS(a)) * K(2) + K(0.1);
    r[7] = FROM_BITS(BITS(a) ^ BITS(b) ^ BITS(b));
    r[8] = SPLAT(ANY(GT(a, K(1e6))) ? 1 : 0);
    FN(store_rows)(out, r, 9);
}
#undef TRANSPOSE
#undef TAIL
"""
ALL = "\n".join([*(f"TRANSPOSE({k})" for k in ROWS), *(f"TAIL({k})" for k in TAILS)])
FEW = "TRANSPOSE(3)\nTRANSPOSE(5)"


def write_body(folder: Path, transposes: str) -> None:
    (folder / "body.h").write_text(BODY.replace("TRANSPOSES", transposes), encoding="ascii")


def tag(bits: int, width: int) -> str:
    return f"f{bits}_{width}"


def unit(bits: int, width: int, *headers: str) -> str:
    """Text that includes one instance."""
    lines = [f"#define BS_BITS {bits}", f"#define BS_BYTES {width}", f"#define BS_TAG {tag(bits, width)}"]
    lines += [f'#include "{name}"' for name in ("instance.h", "rows.h", *headers, "instance_end.h")]
    return enclosed(width, "\n".join(lines))


def compiled(folder: Path, source: str, *options: str, compiler: str = COMPILERS[0]) -> ctypes.CDLL:
    """A shared library of a C text and of the body in the same folder."""
    text, library = folder / "unit.c", folder / f"{compiler}.so"
    text.write_text('#include <string.h>\n#include "platform.h"\n' + source, encoding="ascii")
    command = [compiler, *C_FLAGS, *WARNING_FLAGS, *options, f"-I{HEADERS}", f"-I{folder}"]
    done = subprocess.run(
        [*command, "-shared", "-fPIC", str(text), "-o", str(library), "-lm"], capture_output=True, text=True
    )
    assert done.returncode == 0 and not done.stderr, done.stderr
    return ctypes.CDLL(str(library))


@pytest.fixture(scope="module")
def call(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., None]:
    """Calls one function of one instance on arrays and a count."""
    folder = tmp_path_factory.mktemp("platform")
    write_body(folder, ALL)
    source = "int has_v3(void) { return BS_CPU_HAS_V3(); }\nint has_v4(void) { return BS_CPU_HAS_V4(); }\n"
    library = compiled(folder, source + "\n".join(unit(*each, "body.h") for each in INSTANCES))
    assert bool(library.has_v3()) == has_wide_vectors() or platform.machine() != "x86_64"
    assert bool(library.has_v4()) == runs(BY_TAG["f64_v4"]) or platform.machine() != "x86_64"

    def function(name: str, bits: int, width: int, *arguments: Any) -> int:
        passed = [
            ctypes.c_void_p(a.ctypes.data) if isinstance(a, np.ndarray) else ctypes.c_ssize_t(a) for a in arguments
        ]
        return int(getattr(library, f"{name}_{tag(bits, width)}")(*passed))

    return function


def numbers(bits: int, *shape: int) -> Any:
    return np.random.default_rng(bits).standard_normal(shape).astype(f"f{bits // 8}")


class Fenced:
    """Arrays that end where readable memory ends: a read or write beyond them is a crash."""

    def __init__(self) -> None:
        self.size = 4 * mmap.PAGESIZE
        self.memory = mmap.mmap(-1, self.size + mmap.PAGESIZE)
        base = ctypes.addressof(ctypes.c_char.from_buffer(self.memory))
        libc = ctypes.CDLL(None, use_errno=True)
        fence = ctypes.c_void_p(base + self.size)
        assert libc.mprotect(fence, ctypes.c_size_t(mmap.PAGESIZE), 0) == 0

    def array(self, like: Any) -> Any:
        whole = np.frombuffer(self.memory, like.dtype, self.size // like.dtype.itemsize)
        result = whole[len(whole) - like.size :].reshape(like.shape)
        result[:] = like
        return result


@pytest.fixture(scope="module")
def fences() -> tuple[Fenced, Fenced]:
    return Fenced(), Fenced()


@pytest.mark.compiles
@each_instance
def test_rows_become_columns_and_columns_rows(
    bits: int, width: int, call: Callable[..., Any], fences: tuple[Fenced, Fenced]
) -> None:
    lanes = call("lanes", bits, width)
    assert lanes == max(1, width * 8 // bits)
    for k in ROWS:
        for count in range(1, lanes + 1) if k in TAILS else [lanes]:
            rows = fences[0].array(numbers(bits, count, k))
            columns = np.full((k, lanes), np.nan, rows.dtype)
            prefix, tail = ("", []) if count == lanes else ("tail_", [count])
            call(f"{prefix}columns_{k}", bits, width, columns, rows, *tail)
            padded = rows[np.minimum(np.arange(lanes), count - 1)]  # missing rows repeat the last one
            assert np.array_equal(columns, padded.T), f"k = {k}, count = {count}"
            columns[:, count:] = np.nan
            back = fences[1].array(np.full((count + 1, k), np.nan, rows.dtype))
            call(f"{prefix}rows_{k}", bits, width, back[1:], columns, *tail)
            assert np.array_equal(back[1:], rows) and np.isnan(back[0]).all(), f"k = {k}, count = {count}"


@pytest.mark.compiles
@each_instance
def test_a_row_for_all_lanes(bits: int, width: int, call: Callable[..., Any]) -> None:
    row = numbers(bits, 5)
    out = np.empty((call("lanes", bits, width), 5), row.dtype)
    call("broadcast", bits, width, out, row)
    assert (out == row).all()


@pytest.mark.compiles
@each_instance
def test_masks(bits: int, width: int, call: Callable[..., Any]) -> None:
    special = [0.0, -0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 0.5]
    dtype = np.dtype(f"f{bits // 8}")
    rows = np.array([(a, b, c) for a in special for b in special for c in special], dtype)
    lanes = call("lanes", bits, width)
    for start in range(0, len(rows), lanes):
        some = rows[start : start + lanes]
        out = np.empty((lanes, 9), dtype)
        call("masks", bits, width, out, some)
        a, b, c = some.T
        yes, no = np.ones(lanes, dtype), np.full(lanes, -0.0, dtype)
        expected = np.stack(
            [
                np.where(a < b, yes, no),
                np.where(a <= b, yes, no),
                np.where(a > 0.5, a, b),
                np.where(a >= b, yes, no),
                np.where((a == b) | (b != c), yes, no),
                np.where(~(a < b) & ~(b < c), a, c),
                np.sqrt(np.abs(a)) * dtype.type(2) + dtype.type(0.1),
                a,
                np.full(lanes, (a > 1e6).any(), dtype),
            ],
            axis=1,
        )
        assert np.array_equal(out, expected, equal_nan=True)
        numeric = ~np.isnan(expected)
        assert np.array_equal(np.signbit(out)[numeric], np.signbit(expected)[numeric])


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("options", [("-O0",), ("-O2", "-std=gnu17")], ids="".join)
def test_other_compilers_and_optimisations(compiler: str, options: tuple[str, ...], tmp_path: Path) -> None:
    """Clean everywhere, with intrinsics in play at any level; a few row lengths are enough."""
    write_body(tmp_path, FEW)
    units = [unit(*each, "elementary.h", "body.h") for each in INSTANCES]
    library = compiled(tmp_path, "\n".join(units), *options, compiler=compiler)
    for bits, width in INSTANCES:
        lanes = getattr(library, f"lanes_{tag(bits, width)}")()
        rows = numbers(bits, lanes, 5)
        columns = np.empty((5, lanes), rows.dtype)
        getattr(library, f"columns_5_{tag(bits, width)}")(
            ctypes.c_void_p(columns.ctypes.data), ctypes.c_void_p(rows.ctypes.data), ctypes.c_ssize_t(lanes)
        )
        assert np.array_equal(columns, rows.T)


def test_the_scalar_form_is_plain_c99(tmp_path: Path) -> None:
    """What compilers without vector extensions take, made by hiding that this one has them."""
    write_body(tmp_path, ALL)
    units = "\n".join(unit(bits, 0, "elementary.h", "body.h") for bits in (64, 32))
    plain = "#undef BS_VECTORS\n#define BS_VECTORS 0\n#undef BS_INLINE\n#define BS_INLINE static inline\n"
    plain += "#undef BS_UNROLL\n#define BS_UNROLL\n#undef RESTRICT\n#define RESTRICT restrict\n"
    compiled(tmp_path, plain + units, "-std=c99", "-Wno-unused-function")


def test_an_impossible_instance_is_refused(tmp_path: Path) -> None:
    for bits, width in ((16, 0), (64, 128)):
        text = tmp_path / "bad.c"
        text.write_text('#include "platform.h"\n' + unit(bits, width), encoding="ascii")
        command = [COMPILERS[0], *C_FLAGS, f"-I{HEADERS}", "-c", str(text), "-o", os.devnull]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode != 0 and "#error" in done.stderr


@pytest.mark.gpu
def test_the_same_text_is_cuda() -> None:
    body = BODY.replace("TRANSPOSES", ALL)
    body = body.replace("void FN", "__device__ void FN").replace("int FN", "__device__ int FN")
    source = '#include "platform.h"\n' + "\n".join(unit(bits, 0, "body.h") for bits in (64, 32))
    names = ("platform.h", "instance.h", "rows.h", "instance_end.h")
    headers = {name: (HEADERS / name).read_text(encoding="ascii") for name in names}
    assert compile_text(source, {**headers, "body.h": body}).log == ""
