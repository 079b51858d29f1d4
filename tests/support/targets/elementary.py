"""Elementary functions of all instances as C that tests compile and call; arguments, and exact values by mpmath."""

from __future__ import annotations

import ctypes
import shutil
from functools import cache
from typing import Any

import mpmath as mp
import numpy as np

from ..checkout import CHECKOUT
from .widths import enclosed

HEADERS = CHECKOUT / "templates" / "c" / "lib"
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)] or ["cc"]
PRECISIONS = (64, 32)
LANES = 16  # the most that an instance has; arrays are padded to it
EACH = 300  # arguments per range
FAR = 1500  # binary digits for reducing the largest angles
#: Promised errors in ulp; docs/algebra/elementary.md has the measured ones, which are smaller.
ULPS = {
    **dict.fromkeys(("sin", "cos", "exp", "log"), 1.0),
    **dict.fromkeys(("sinh", "cosh", "atan2"), 2.0),
    **{f"stumpff{k}": 4.0 for k in range(4)},
    **{f"stumpff{k}": 8.0 for k in range(4, 8)},
}

BODY = """
#define APPLY(f)                                                                \\
    void FN(apply_##f)(S *out, const S *x, const S *y, ptrdiff_t n)             \\
    {                                                                           \\
        (void)y;                                                                \\
        for (ptrdiff_t i = 0; i < n; i += W) {                                  \\
            V v;                                                                \\
            FN(load_rows)(&v, x + i, 1);                                        \\
            v = FN(f)(v);                                                       \\
            FN(store_rows)(out + i, &v, 1);                                     \\
        }                                                                       \\
    }
#define TOGETHER(f, k, call)                                                    \\
    void FN(together_##f)(S *out, const S *x, ptrdiff_t n)                      \\
    {                                                                           \\
        for (ptrdiff_t i = 0; i < n; i += W) {                                  \\
            V v, c[k];                                                          \\
            FN(load_rows)(&v, x + i, 1);                                        \\
            call;                                                               \\
            FN(store_rows)(out + i * k, c, k);                                  \\
        }                                                                       \\
    }
APPLY(sin) APPLY(cos) APPLY(exp) APPLY(log) APPLY(sinh) APPLY(cosh)
APPLY(stumpff0) APPLY(stumpff1) APPLY(stumpff2) APPLY(stumpff3)
APPLY(stumpff4) APPLY(stumpff5) APPLY(stumpff6) APPLY(stumpff7)
TOGETHER(sincos, 2, FN(sincos)(v, &c[0], &c[1]))
TOGETHER(sinhcosh, 2, FN(sinhcosh)(v, &c[0], &c[1]))
TOGETHER(stumpff, 4, FN(stumpff)(v, &c[0], &c[1], &c[2], &c[3]))
void FN(apply_atan2)(S *out, const S *y, const S *x, ptrdiff_t n)
{
    for (ptrdiff_t i = 0; i < n; i += W) {
        V v, w;
        FN(load_rows)(&v, y + i, 1);
        FN(load_rows)(&w, x + i, 1);
        v = ATAN2(v, w);
        FN(store_rows)(out + i, &v, 1);
    }
}
#undef APPLY
#undef TOGETHER
"""


def unit(bits: int, width: int, headers: tuple[str, ...] = ("elementary.h", "body.h")) -> str:
    """Text that includes one instance."""
    lines = [f"#define BS_BITS {bits}", f"#define BS_BYTES {width}", f"#define BS_TAG f{bits}_{width}"]
    lines += [f'#include "{name}"' for name in ("instance.h", "rows.h", *headers, "instance_end.h")]
    return enclosed(width, "\n".join(lines))


def run(library: ctypes.CDLL, name: str, width: int, *arguments: Any) -> Any:
    """One function of one instance on arrays of its precision."""
    count = len(arguments[0])
    padded = [np.concatenate([a, np.ones(-count % LANES, a.dtype)]) for a in arguments]
    out = np.empty_like(padded[0])
    pointers = [ctypes.c_void_p(a.ctypes.data) for a in (out, padded[0], padded[-1])]
    function = getattr(library, f"apply_{name}_f{out.itemsize * 8}_{width}")
    function(*pointers, ctypes.c_ssize_t(len(out)))
    return out[:count]


def floating(bits: int) -> Any:
    return np.dtype(f"f{bits // 8}").type


def in_both_signs(x: Any) -> Any:
    return np.concatenate([x, -x])


@cache
def arguments(name: str, bits: int) -> tuple[Any, ...]:
    """Random ones in every range that matters, and what breaks functions: subnormal, huge, near the edges."""
    rng = np.random.default_rng(bits)
    dtype, info = floating(bits), np.finfo(floating(bits))
    lowest, highest = float(info.minexp - info.nmant), float(info.maxexp) - 1e-6

    def flat(low: float, high: float) -> Any:
        return rng.uniform(low, high, EACH)

    def powers(low: float, high: float) -> Any:
        return in_both_signs(np.exp2(rng.uniform(low, high, EACH)))

    edges = [0.0, info.smallest_subnormal, info.tiny, info.tiny * (1 - info.eps), info.max]
    edges += [0.5, 1.0 - info.epsneg, 1.0, 1.0 + info.eps, 2.0, 4.0]
    ranges = [in_both_signs(np.array(edges, float)), powers(lowest, highest), flat(-1, 1), flat(-10, 10)]
    largest = 709.8 if bits == 64 else 88.8
    match name:
        case "sin" | "cos":
            near = 65536 if bits == 64 else 2048  # quarter turns up to which products reduce
            turns = np.concatenate([np.arange(1, EACH), rng.integers(1, 2 * near, 3 * EACH), near + np.arange(-9, 9)])
            exact = np.array([float(int(n) * mp.pi / 2) for n in turns]).astype(dtype)
            ranges += [exact, np.nextafter(exact, dtype(0)), np.nextafter(exact, dtype(np.inf))]
            ranges += [flat(-1e3, 1e3), flat(-2e5, 2e5)]
        case "exp" | "sinh" | "cosh":
            ranges += [flat(-largest, largest), flat(largest - 0.5, largest + 0.5), flat(0.9, 2.2)]
            ranges += [flat(-largest - 40, -largest)]  # subnormal results
        case "log":
            ranges += [1 + powers(-30, -1) / 2, flat(0.7, 0.71), flat(1.41, 1.42), flat(0.5, 2)]
            ranges = [np.abs(r) for r in ranges]
        case "atan2":
            ranges += [flat(-1, 1), powers(-4, 4), powers(-2, 2), flat(-1e3, 1e3)]
        case _:
            ranges += [flat(-(largest**2), 0), flat(0, 1e5), flat(-11, 2), flat(1, 70), flat(-100, 0)]
            ranges += [np.array([(n * np.pi / 2) ** 2 for n in range(1, 30)]), powers(0, 12)]
            far = 1e10 if bits == 64 else 1e7  # beyond, the root's own rounding counts: see the documentation
            ranges = [np.clip(r, -(largest**2), far) for r in ranges]
    x = np.concatenate(ranges).astype(dtype)
    if name != "atan2":
        return (x,)
    ratio = rng.choice([0.5, 1.0, 2.0], len(x)) * (1 + info.eps * rng.integers(-3, 4, len(x)))
    with np.errstate(over="ignore"):
        close = np.clip((x * ratio).astype(dtype), -info.max, info.max)  # near the edges between cases
    y = np.concatenate([x, x]), np.concatenate([rng.permutation(x), close])
    return y[0] + dtype(0), y[1] + dtype(0)  # mpmath has no negative zero: those are among the special values


def stumpff(k: int, w: Any) -> Any:
    """c_k by its series, or where that is long from c0 and c1, without loss of the leading 60 digits."""
    if abs(w) < 1:
        total, term, n = mp.mpf(0), 1 / mp.factorial(k), 0
        while abs(term) > mp.eps:
            total += term
            n += 1
            term *= -w / ((2 * n + k - 1) * (2 * n + k))
        return total
    root = mp.sqrt(abs(w))
    value = [mp.cos(root), mp.sin(root) / root] if w > 0 else [mp.cosh(root), mp.sinh(root) / root]
    return (
        [*value, *((1 / mp.factorial(j) - value[j % 2]) / w for j in (0, 1))][k]
        if k < 4
        else (1 / mp.factorial(k - 2) - stumpff(k - 2, w)) / w
    )


@cache
def exact(name: str, bits: int) -> tuple[list[Any], list[Any]]:
    """Results to 60 digits and more, and the errors that are allowed besides those in ulps.

    None, but for the Stumpff functions what a change of the argument by eps^2 makes: it is seen next to zeros only.
    """
    results, allowed = [], []
    eps = mp.mpf(float(np.finfo(floating(bits)).eps))
    for numbers in zip(*(a.tolist() for a in arguments(name, bits)), strict=True):
        x = [mp.mpf(number) for number in numbers]
        allowed.append(mp.mpf(0))
        with mp.workprec(FAR if abs(x[0]) > 1e9 else 240):
            if name.startswith("stumpff"):
                k = int(name[-1])
                results.append(stumpff(k, x[0]))
                allowed[-1] = abs(stumpff(k, x[0] * (1 + eps**2)) - results[-1])
            elif name == "log" and x[0] == 0:
                results.append(-mp.inf)
            else:
                limited = [mp.mpf(max(-5e3, min(5e3, v))) for v in x] if name in ("exp", "sinh", "cosh") else x
                results.append(getattr(mp, name)(*limited))
    return results, allowed


def errors(actual: Any, expected: list[Any], allowed: list[Any]) -> Any:
    """In units of the last place of the exact result; infinite for a wrong infinity or NaN."""
    info = np.finfo(actual.dtype)
    smallest = mp.mpf(2) ** (info.minexp - info.nmant)
    overflow = mp.mpf(2) ** info.maxexp * (1 - mp.mpf(2) ** -(info.nmant + 2))
    found = []
    for a, e, free in zip(actual.tolist(), expected, allowed, strict=True):
        if abs(e) >= overflow:
            found.append(0.0 if a == mp.sign(e) * mp.inf else 1.0 if abs(a) == info.max else mp.inf)
        elif not np.isfinite(a):
            found.append(1.0 if a == mp.sign(e) * mp.inf and abs(e) > info.max * (1 - info.eps) else mp.inf)
        else:
            place = smallest
            if e != 0:
                place = max(place, mp.mpf(2) ** (int(mp.floor(mp.log(abs(e), 2))) - info.nmant))
            found.append(float(max(abs(mp.mpf(a) - e) - free, 0) / place))
    return np.array(found, float)
