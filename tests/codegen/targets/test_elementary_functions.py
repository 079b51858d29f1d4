"""The elementary functions: errors against 60 digits at random and extreme arguments, the same bits everywhere."""

from __future__ import annotations

import ctypes
import runpy
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from bladesmith.codegen.build.cpu_features import has_wide_vectors
from bladesmith.codegen.build.flags import C_FLAGS, WARNING_FLAGS
from bladesmith.codegen.execute.numba_jit import load
from bladesmith.codegen.execute.nvrtc import compile_text
from bladesmith.templates.numba import elementary

from ...support.checkout import CHECKOUT

HEADERS = CHECKOUT / "templates" / "c" / "lib"
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)] or ["cc"]
WIDTHS = (0, 16, 32) if has_wide_vectors() else (0, 16)
PRECISIONS = (64, 32)
LANES = 8  # the most that an instance has; arrays are padded to it
EACH = 300  # arguments per range
FAR = 1500  # binary digits for reducing the largest angles

#: Promised errors in ulp; docs/elementary.md has the measured ones, which are smaller.
ULPS = {
    **dict.fromkeys(("sin", "cos", "exp", "log"), 1.0),
    **dict.fromkeys(("sinh", "cosh", "atan2"), 2.0),
    **{f"stumpff{k}": 4.0 for k in range(4)},
    "stumpff4": 8.0,
    "stumpff5": 8.0,
}
each_function = pytest.mark.parametrize("name", ULPS)
each_precision = pytest.mark.parametrize("bits", PRECISIONS)

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
APPLY(stumpff0) APPLY(stumpff1) APPLY(stumpff2) APPLY(stumpff3) APPLY(stumpff4) APPLY(stumpff5)
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
    return "\n".join(["BS_V3_BEGIN", *lines, "BS_V3_END"] if width == 32 else lines)


@pytest.fixture(scope="module")
def libraries(tmp_path_factory: pytest.TempPathFactory) -> dict[str, ctypes.CDLL]:
    """All instances, by compiler."""
    folder = tmp_path_factory.mktemp("elementary")
    (folder / "body.h").write_text(BODY, encoding="ascii")
    text = folder / "unit.c"
    units = [unit(bits, width) for bits in PRECISIONS for width in WIDTHS]
    text.write_text("\n".join(['#include "platform.h"', *units]), encoding="ascii")
    result = {}
    for compiler in COMPILERS:
        library = folder / f"{compiler}.so"
        command = [compiler, *C_FLAGS, *WARNING_FLAGS, f"-I{HEADERS}", f"-I{folder}", "-shared", "-fPIC"]
        done = subprocess.run([*command, str(text), "-o", str(library), "-lm"], capture_output=True, text=True)
        assert done.returncode == 0 and not done.stderr, done.stderr
        result[compiler] = ctypes.CDLL(str(library))
    return result


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


@pytest.mark.slow
@each_precision
@each_function
def test_errors_are_within_the_promised_ulps(name: str, bits: int, libraries: dict[str, ctypes.CDLL]) -> None:
    x = arguments(name, bits)
    actual = run(libraries[COMPILERS[0]], name, WIDTHS[-1], *x)
    found = errors(actual, *exact(name, bits))
    worst = int(np.argmax(found))
    at = ", ".join(f"{float(a[worst])!r} ({float(a[worst]).hex()})" for a in x)
    print(f"{name}, {bits} bits: {found[worst]:.3f} ulp of {len(found)} arguments, at {at}")
    assert found[worst] <= ULPS[name], f"{name}({at}) = {actual[worst]!r}, off by {found[worst]:.3f} ulp"


def any_bits(bits: int, count: int) -> Any:
    """Every kind of number with equal chance for each pattern of bits, and the usual suspects."""
    integers = np.dtype(f"i{bits // 8}")
    limits = np.iinfo(integers)
    rng = np.random.default_rng(count)
    patterns = rng.integers(limits.min, limits.max, count, dtype=integers, endpoint=True)
    usual = [rng.uniform(-size, size, count) for size in (1, 10, 100, 1e4, 1e6)]
    special = [0.0, -0.0, np.inf, -np.inf, np.nan]
    dtype = floating(bits)
    return np.concatenate([patterns.view(dtype), *(u.astype(dtype) for u in usual), np.array(special, dtype)])


def assert_same_bits(actual: Any, expected: Any, what: str, *x: Any) -> None:
    """A NaN equals any NaN: no rule fixes its bits."""
    assert actual.dtype == expected.dtype
    integers = np.dtype(f"i{actual.itemsize}")
    nan = np.isnan(actual) & np.isnan(expected)
    different = np.flatnonzero((actual.view(integers) != expected.view(integers)) & ~nan)
    if len(different):
        i = different[0]
        at = ", ".join(repr(a[i]) for a in x)
        pytest.fail(f"{what}: {len(different)} differ, first at {at}: {actual[i]!r}, not {expected[i]!r}")


def operands(name: str, x: Any) -> tuple[Any, ...]:
    return (x, np.random.default_rng(1).permutation(x)) if name == "atan2" else (x,)


@pytest.mark.compiles
@each_precision
@each_function
def test_all_instances_and_compilers_give_the_same_bits(
    name: str, bits: int, libraries: dict[str, ctypes.CDLL]
) -> None:
    x = operands(name, any_bits(bits, 3000))
    expected = run(libraries[COMPILERS[0]], name, 0, *x)
    for compiler, library in libraries.items():
        for width in WIDTHS:
            assert_same_bits(run(library, name, width, *x), expected, f"{compiler}, {width} bytes", *x)


@each_precision
@each_function
def test_python_gives_the_bits_of_c(name: str, bits: int, libraries: dict[str, ctypes.CDLL]) -> None:
    x = operands(name, any_bits(bits, 1000))
    expected = run(libraries[COMPILERS[0]], name, 0, *x)
    function = getattr(elementary, name)
    with np.errstate(all="ignore"):
        assert_same_bits(function(*x), expected, "arrays", *x)
        some = [a[::211] for a in x]
        scalars = [function(*values) for values in zip(*some, strict=True)]
    assert {type(value) for value in scalars} == {floating(bits)}
    assert_same_bits(np.array(scalars), expected[::211], "scalars", *some)


@pytest.mark.slow
@pytest.mark.parametrize("bits,names", [(64, ["sin", "atan2", "exp", "stumpff3"]), (32, ["log"])])
def test_numba_gives_the_bits_of_c(bits: int, names: list[str], libraries: dict[str, ctypes.CDLL]) -> None:
    """A few, because compiling takes a second each; between them they hold all helpers."""
    assert find_spec("numba"), "the test extra holds numba"
    text = f"from bladesmith.templates.numba.elementary import {', '.join(names)}\n"
    for name in names:
        parameters, items = ("x, y", "x[i], y[i]") if name == "atan2" else ("x", "x[i]")
        text += f"def {name}_all(out, {parameters}):\n    for i in range(len(x)):\n        out[i] = {name}({items})\n"
    module = load(text, floating(bits))
    for name in names:
        x = operands(name, any_bits(bits, 1000))
        out = np.empty_like(x[0])
        getattr(module, f"{name}_all")(out, *x)
        assert_same_bits(out, run(libraries[COMPILERS[0]], name, 0, *x), f"numba {name}", *x)


@each_precision
@pytest.mark.parametrize(
    "together,names",
    [
        ("sincos", ["sin", "cos"]),
        ("sinhcosh", ["sinh", "cosh"]),
        ("stumpff", [f"stumpff{k}" for k in range(4)]),
    ],
)
def test_functions_of_one_argument_together(
    together: str, names: list[str], bits: int, libraries: dict[str, ctypes.CDLL]
) -> None:
    x = any_bits(bits, 500)
    x = x[: len(x) // LANES * LANES]
    library = libraries[COMPILERS[0]]
    for width in WIDTHS:
        out = np.empty((len(x), len(names)), x.dtype)
        function = getattr(library, f"together_{together}_f{bits}_{width}")
        function(ctypes.c_void_p(out.ctypes.data), ctypes.c_void_p(x.ctypes.data), ctypes.c_ssize_t(len(x)))
        for column, name in zip(out.T, names, strict=True):
            assert_same_bits(column.copy(), run(library, name, width, x), name, x)
    with np.errstate(all="ignore"):
        for column, name in zip(getattr(elementary, together)(x), names, strict=True):
            assert_same_bits(column, run(library, name, 0, x), name, x)


INF, NAN = np.inf, np.nan
SPECIAL: dict[str, list[tuple[float, ...]]] = {  # arguments, then the result
    "sin": [(0.0, 0.0), (-0.0, -0.0), (INF, NAN), (-INF, NAN), (NAN, NAN)],
    "cos": [(0.0, 1.0), (-0.0, 1.0), (INF, NAN), (NAN, NAN)],
    "exp": [(0.0, 1.0), (-0.0, 1.0), (INF, INF), (-INF, 0.0), (NAN, NAN), (1e4, INF), (-1e4, 0.0)],
    "log": [(1.0, 0.0), (0.0, -INF), (-0.0, -INF), (INF, INF), (-INF, NAN), (-1e-30, NAN), (NAN, NAN)],
    "sinh": [(0.0, 0.0), (-0.0, -0.0), (INF, INF), (-INF, -INF), (-1e4, -INF), (NAN, NAN)],
    "cosh": [(0.0, 1.0), (INF, INF), (-INF, INF), (NAN, NAN)],
    "stumpff0": [(0.0, 1.0), (-0.0, 1.0), (-INF, INF), (-1e30, INF), (INF, NAN), (NAN, NAN)],
    "stumpff1": [(0.0, 1.0), (-INF, INF), (-1e30, INF), (INF, NAN), (NAN, NAN)],
    "stumpff2": [(0.0, 0.5), (-0.0, 0.5), (-INF, INF), (-1e30, INF), (INF, NAN), (NAN, NAN)],
    "stumpff3": [(0.0, 1 / 6), (-INF, INF), (-1e30, INF), (INF, NAN), (NAN, NAN)],
    "stumpff4": [(0.0, 1 / 24), (-INF, INF), (INF, NAN), (NAN, NAN)],
    "stumpff5": [(0.0, 1 / 120), (-INF, INF), (INF, NAN), (NAN, NAN)],
    "atan2": [
        (0.0, 0.0, 0.0),
        (-0.0, 0.0, -0.0),
        (0.0, -0.0, np.pi),
        (-0.0, -0.0, -np.pi),
        (0.0, -1.0, np.pi),
        (-0.0, 1.0, -0.0),
        (1.0, 0.0, np.pi / 2),
        (-1.0, -0.0, -np.pi / 2),
        (INF, INF, np.pi / 4),
        (-INF, INF, -np.pi / 4),
        (INF, -INF, 3 * np.pi / 4),
        (1.0, INF, 0.0),
        (-1.0, -INF, -np.pi),
        (INF, -5.0, np.pi / 2),
        (NAN, 1.0, NAN),
        (1.0, NAN, NAN),
        (NAN, INF, NAN),
    ],
}


@each_precision
@each_function
def test_special_values(name: str, bits: int, libraries: dict[str, ctypes.CDLL]) -> None:
    *x, expected = np.array(SPECIAL[name]).T.astype(floating(bits))
    with np.errstate(all="ignore"):
        results = [run(libraries[COMPILERS[0]], name, width, *x) for width in WIDTHS]
        results.append(getattr(elementary, name)(*x))
    for actual in results:
        assert np.array_equal(np.isnan(actual), np.isnan(expected)), f"{actual}, not {expected}"
        numeric = ~np.isnan(expected)
        assert np.array_equal(np.signbit(actual)[numeric], np.signbit(expected)[numeric])
        np.testing.assert_array_max_ulp(actual[numeric], expected[numeric], 1)


@each_precision
def test_a_huge_angle_does_not_disturb_its_neighbours(bits: int, libraries: dict[str, ctypes.CDLL]) -> None:
    """The one branch: lanes are mixed in every order, small numbers among them that its table is not made for."""
    values = np.array([1e-30, 0.0, 1.0, -2e9, 3e30, np.inf, np.nan, -7.0], floating(bits))
    for shift in range(len(values)):
        x = np.roll(values, shift)
        for name in ("sin", "cos", "stumpff1"):
            expected = np.concatenate([run(libraries[COMPILERS[0]], name, 0, x[i : i + 1]) for i in range(len(x))])
            for width in WIDTHS:
                assert_same_bits(run(libraries[COMPILERS[0]], name, width, x), expected, name, x)


@pytest.mark.slow
@each_precision
def test_constants_are_those_of_the_derivation(bits: int) -> None:
    """All but the slow polynomials of float64 are derived again; the header and the Python module hold them."""
    derive = runpy.run_path(str(CHECKOUT / "benchmarks" / "derive_elementary.py"))
    header = (HEADERS / "elementary.h").read_text(encoding="ascii")
    part = header[: header.index("#else")] if bits == 64 else header[header.index("#else") :]
    ours = elementary.DOUBLE if bits == 64 else elementary.SINGLE
    assert elementary.TWO_OVER_PI.tolist() == derive["two_over_pi"](len(elementary.TWO_OVER_PI) - 1)
    assert all(f"0x{word:016x}" in header for word in elementary.TWO_OVER_PI.tolist())
    found = dict(derive["constants"](bits))
    if bits == 32:
        found |= {fit.name: derive["polynomial"](fit, 32)[0] for fit in derive["fits"]()}
    for name, values in found.items():
        assert all(derive["hexadecimal"](value) in part for value in values), name
        held = getattr(ours, derive["PYTHON_NAMES"][name])
        assert (list(held) if isinstance(held, tuple) else [held])[: len(values)] == values, name


@pytest.mark.peers
def test_cuda_compiles_and_contracts_nothing() -> None:
    body = BODY.replace("void FN", 'extern "C" __global__ void FN')
    source = '#include "platform.h"\n' + "\n".join(unit(bits, 0) for bits in PRECISIONS)
    names = ("platform.h", "instance.h", "rows.h", "elementary.h", "instance_end.h")
    headers = {name: (HEADERS / name).read_text(encoding="ascii") for name in names}
    compiled = compile_text(source, {**headers, "body.h": body})
    assert compiled.log == ""
    assert b"apply_atan2_f32_0" in compiled.image and b"fma" not in compiled.image


def test_python_arrays_of_any_shape_and_plain_numbers(libraries: dict[str, ctypes.CDLL]) -> None:
    grid = np.linspace(-3, 3, 12).reshape(3, 4)
    assert elementary.exp(grid).shape == (3, 4)
    assert elementary.atan2(grid, 2.0).dtype == np.float64
    assert elementary.sin(1.0) == pytest.approx(np.sin(1.0), rel=1e-15)


def by_identity(function: Callable[..., Any]) -> Callable[..., Any]:
    return function


def test_compiled_functions_call_each_other_decorated() -> None:
    """What numba does, done by a decorator that changes nothing: scalars, without NumPy's select."""
    plain = elementary.compiled(by_identity)
    assert plain.sincos is not elementary.sincos
    with np.errstate(all="ignore"):
        assert plain.stumpff2(np.float64(0.0)) == 0.5
        assert plain.sin(np.float64(2.0)) == elementary.sin(np.float64(2.0))
