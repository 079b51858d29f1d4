"""Times the C platform layer: elementary functions against libm and NumPy, rows against a structure of arrays.

`python benchmarks/bench_elementary.py` prints nanoseconds per item, one thread, arrays in the second-level cache.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from bladesmith.codegen.build.cpu_features import has_wide_vectors
from bladesmith.codegen.build.flags import C_FLAGS

HEADERS = Path(__file__).resolve().parents[1] / "templates" / "c" / "lib"
COUNT = 4000  # items: long against a call, short against the cache, no power of two (columns would collide)
ROUNDS, REPEATS = 15, 40  # the fastest round counts
ONE = ("sin", "cos", "exp", "log", "sinh", "cosh", "stumpff0", "stumpff4")
NUMPY: dict[str, Any] = {name: getattr(np, name) for name in ("sin", "cos", "exp", "log", "sinh", "cosh")}
NUMPY["atan2"] = np.arctan2
INSTANCES = {"scalar": 0, "baseline": 16, "v3": 32}

FUNCTIONS = """
#define APPLY(f)                                                                    \\
    void FN(f##_all)(S *out, const S *x, const S *y, ptrdiff_t n)                   \\
    {                                                                               \\
        (void)y;                                                                    \\
        for (ptrdiff_t i = 0; i < n; i += W) {                                      \\
            V v;                                                                    \\
            FN(load_rows)(&v, x + i, 1);                                            \\
            v = FN(f)(v);                                                           \\
            FN(store_rows)(out + i, &v, 1);                                         \\
        }                                                                           \\
    }
#define SEVERAL(f, k, call)                                                         \\
    void FN(f##_all)(S *out, const S *x, const S *y, ptrdiff_t n)                   \\
    {                                                                               \\
        (void)y;                                                                    \\
        for (ptrdiff_t i = 0; i < n; i += W) {                                      \\
            V v, w, c[k];                                                           \\
            FN(load_rows)(&v, x + i, 1);                                            \\
            FN(load_rows)(&w, y + i, 1);                                            \\
            call;                                                                   \\
            (void)w;                                                                \\
            FN(store_rows)(out + i * k, c, k);                                      \\
        }                                                                           \\
    }
APPLIED
SEVERAL(atan2, 1, c[0] = ATAN2(v, w))
SEVERAL(sincos, 2, FN(sincos)(v, &c[0], &c[1]))
SEVERAL(stumpff, 4, FN(stumpff)(v, &c[0], &c[1], &c[2], &c[3]))

/* A conformal motor (scalar, three rotation, three translation, one screw coefficient) on a point. */
BS_INLINE void FN(motor_on_point)(V *out, const V *m, const V *x)
{
    V tx = K(2) * (m[2] * x[2] - m[3] * x[1]);
    V ty = K(2) * (m[3] * x[0] - m[1] * x[2]);
    V tz = K(2) * (m[1] * x[1] - m[2] * x[0]);
    V vx = x[0] + m[0] * tx + (m[2] * tz - m[3] * ty);
    V vy = x[1] + m[0] * ty + (m[3] * tx - m[1] * tz);
    V vz = x[2] + m[0] * tz + (m[1] * ty - m[2] * tx);
    V px = K(2) * (m[0] * m[4] - m[1] * m[7] + m[2] * m[6] - m[3] * m[5]);
    V py = K(2) * (m[0] * m[5] - m[2] * m[7] + m[3] * m[4] - m[1] * m[6]);
    V pz = K(2) * (m[0] * m[6] - m[3] * m[7] + m[1] * m[5] - m[2] * m[4]);
    V qx = x[3] * px, qy = x[3] * py, qz = x[3] * pz;
    out[0] = vx + qx, out[1] = vy + qy, out[2] = vz + qz, out[3] = x[3];
    out[4] = x[4] + (vx + K(0.5) * qx) * px + (vy + K(0.5) * qy) * py + (vz + K(0.5) * qz) * pz;
}

BS_INLINE void FN(motor_times_motor)(V *out, const V *p, const V *q)
{
    out[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
    out[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2];
    out[2] = p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3];
    out[3] = p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1];
    out[4] = p[0] * q[4] + p[4] * q[0] + p[1] * q[7] + p[7] * q[1]
        + p[2] * q[6] - p[6] * q[2] + p[3] * q[5] - p[5] * q[3];
    out[5] = p[0] * q[5] + p[5] * q[0] + p[2] * q[7] + p[7] * q[2]
        + p[3] * q[4] - p[4] * q[3] + p[1] * q[6] - p[6] * q[1];
    out[6] = p[0] * q[6] + p[6] * q[0] + p[3] * q[7] + p[7] * q[3]
        + p[1] * q[5] - p[5] * q[1] + p[2] * q[4] - p[4] * q[2];
    out[7] = p[0] * q[7] + p[7] * q[0] - p[1] * q[4] - p[4] * q[1]
        - p[2] * q[5] - p[5] * q[2] - p[3] * q[6] - p[6] * q[3];
}

#define ROWS(f, ko, ka, kb)                                                         \\
    void FN(f##_all)(S *RESTRICT out, const S *RESTRICT a, const S *RESTRICT b, ptrdiff_t n) \\
    {                                                                               \\
        for (ptrdiff_t i = 0; i < n; i += W) {                                      \\
            V o[ko], x[ka], y[kb];                                                  \\
            FN(load_rows)(x, a + i * ka, ka);                                       \\
            FN(load_rows)(y, b + i * kb, kb);                                       \\
            FN(f)(o, x, y);                                                         \\
            FN(store_rows)(out + i * ko, o, ko);                                    \\
        }                                                                           \\
    }
ROWS(motor_on_point, 5, 8, 5)
ROWS(motor_times_motor, 8, 8, 8)
#undef APPLY
#undef SEVERAL
#undef ROWS
"""

#: The same bodies on columns, which the compiler vectorises by itself; and libm.
COLUMNS = """
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define INDEPENDENT _Pragma("GCC ivdep")
#endif
#define COLUMNS(f, ko, ka, kb)                                                      \\
    void f##_columns(double *RESTRICT out, const double *RESTRICT a, const double *RESTRICT b, ptrdiff_t n) \\
    {                                                                               \\
        INDEPENDENT                                                                 \\
        for (ptrdiff_t i = 0; i < n; i++) {                                         \\
            double o[ko], x[ka], y[kb];                                             \\
            BS_UNROLL for (int j = 0; j < ka; j++) x[j] = a[j * n + i];             \\
            BS_UNROLL for (int j = 0; j < kb; j++) y[j] = b[j * n + i];             \\
            f##_f64_0(o, x, y);                                                     \\
            BS_UNROLL for (int j = 0; j < ko; j++) out[j * n + i] = o[j];           \\
        }                                                                           \\
    }
COLUMNS(motor_on_point, 5, 8, 5)
COLUMNS(motor_times_motor, 8, 8, 8)
#define LIBM(f)                                                                     \\
    void f##_libm(double *out, const double *x, const double *y, ptrdiff_t n)       \\
    {                                                                               \\
        (void)y;                                                                    \\
        for (ptrdiff_t i = 0; i < n; i++) out[i] = f(x[i]);                         \\
    }
LIBM(sin) LIBM(cos) LIBM(exp) LIBM(log) LIBM(sinh) LIBM(cosh)
void atan2_libm(double *out, const double *x, const double *y, ptrdiff_t n)
{
    for (ptrdiff_t i = 0; i < n; i++) out[i] = atan2(x[i], y[i]);
}
"""


def instance(bits: int, width: int) -> str:
    """Text that includes one instance and all loops."""
    body = FUNCTIONS.replace("APPLIED", "\n".join(f"APPLY({name})" for name in ONE))
    lines = [f"#define BS_BITS {bits}", f"#define BS_BYTES {width}", f"#define BS_TAG f{bits}_{width}"]
    lines += [f'#include "{name}.h"' for name in ("instance", "rows", "elementary")]
    lines += [body, '#include "instance_end.h"']
    return "\n".join(["BS_V3_BEGIN", *lines, "BS_V3_END"] if width == 32 else lines)


def library(folder: Path, name: str, text: str, *options: str) -> ctypes.CDLL:
    """Compile and load."""
    source = folder / f"{name}.c"
    source.write_text('#include "platform.h"\n' + text, encoding="ascii")
    command = [
        os.environ.get("CC", "cc"),
        *C_FLAGS,
        *options,
        f"-I{HEADERS}",
        "-shared",
        "-fPIC",
        str(source),
    ]
    subprocess.run([*command, "-o", str(folder / f"{name}.so"), "-lm"], check=True)
    return ctypes.CDLL(str(folder / f"{name}.so"))


def nanoseconds(function: Callable[[], object]) -> float:
    """Per item, of the fastest round."""
    best = float("inf")
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for _ in range(REPEATS):
            function()
        best = min(best, time.perf_counter() - begin)
    return best / REPEATS / COUNT * 1e9


def timed(function: Any, *arrays: Any) -> float:
    """A compiled loop."""
    pointers = [ctypes.c_void_p(a.ctypes.data) for a in arrays]
    count = ctypes.c_ssize_t(COUNT)
    return nanoseconds(lambda: function(*pointers, count))


def table(title: str, rows: dict[str, dict[str, float]]) -> None:
    """Print a table; a missing entry is a dash."""
    columns = list(dict.fromkeys(key for row in rows.values() for key in row))
    print(f"\n{title}\n{'':18s}" + "".join(f"{name:>14s}" for name in columns))
    for name, row in rows.items():
        print(f"{name:18s}" + "".join(f"{row[c]:14.2f}" if c in row else f"{'-':>14s}" for c in columns))


def main() -> None:
    """Compile, time and print."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    rng = np.random.default_rng(0)
    wide = has_wide_vectors()
    used = {name: width for name, width in INSTANCES.items() if wide or width < 32}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ours = library(folder, "ours", "\n".join(instance(b, w) for b in (64, 32) for w in used.values()))
        native = ("-mavx2",) if wide else ()
        peers = library(folder, "peers", instance(64, 0) + COLUMNS, *native)
        functions: dict[str, dict[str, float]] = {}
        for function in (*ONE, "atan2", "sincos", "stumpff"):
            x, y = rng.uniform(0.01 if function == "log" else -10, 10, (2, COUNT))
            row = functions[function] = {}
            for bits in (64, 32):
                operands = [
                    np.empty(4 * COUNT, f"f{bits // 8}"),
                    x.astype(f"f{bits // 8}"),
                    y.astype(f"f{bits // 8}"),
                ]
                for instance_name, width in used.items():
                    row[f"f{bits} {instance_name}"] = timed(
                        getattr(ours, f"{function}_all_f{bits}_{width}"), *operands
                    )
            if function in NUMPY:
                out = np.empty(4 * COUNT)
                row["libm"] = timed(getattr(peers, f"{function}_libm"), out, x, y)
                arguments = (x, y) if function == "atan2" else (x,)
                row["NumPy f64"] = nanoseconds(
                    lambda a=arguments, f=NUMPY[function], o=out: f(*a, out=o[:COUNT])
                )
        table("Elementary functions, ns per item, arguments in (-10, 10)", functions)
        kernels: dict[str, dict[str, float]] = {}
        for kernel in ("motor_on_point", "motor_times_motor"):
            arrays = [np.ascontiguousarray(rng.standard_normal(8 * COUNT)) for _ in range(3)]
            row = kernels[kernel] = {"columns": timed(getattr(peers, f"{kernel}_columns"), *arrays)}
            for bits in (64, 32):
                some = [a.astype(f"f{bits // 8}") for a in arrays]
                for instance_name, width in used.items():
                    row[f"f{bits} {instance_name}"] = timed(
                        getattr(ours, f"{kernel}_all_f{bits}_{width}"), *some
                    )
        table(
            "Rows transposed in registers, ns per item; columns: structure of arrays, auto-vectorised",
            kernels,
        )


if __name__ == "__main__":
    main()
