"""The elementary functions: errors against 60 digits at random and extreme arguments, the same bits everywhere."""

from __future__ import annotations

import ctypes
import runpy
import subprocess
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.build.flags import C_FLAGS, WARNING_FLAGS
from bladesmith.codegen.elementary import constants
from bladesmith.codegen.elementary import functions as elementary
from bladesmith.codegen.execute.numba_jit import load
from bladesmith.codegen.execute.nvrtc import compile_text
from bladesmith.codegen.targets.c.elementary import elementary_header

from ...support.checkout import CHECKOUT
from ...support.targets.elementary import (
    BODY,
    COMPILERS,
    HEADERS,
    LANES,
    PRECISIONS,
    ULPS,
    arguments,
    errors,
    exact,
    floating,
    run,
    unit,
)
from ...support.targets.widths import WIDTHS

each_function = pytest.mark.parametrize("name", ULPS)
each_precision = pytest.mark.parametrize("bits", PRECISIONS)


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
    text = f"from bladesmith.codegen.elementary.functions import {', '.join(names)}\n"
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
    "stumpff6": [(0.0, 1 / 720), (-INF, INF), (-1e30, INF), (INF, NAN), (NAN, NAN)],
    "stumpff7": [(0.0, 1 / 5040), (-INF, INF), (-1e30, INF), (INF, NAN), (NAN, NAN)],
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
    """All but the slow polynomials of float64 are derived again."""
    derive = runpy.run_path(str(CHECKOUT / "benchmarks" / "derive_elementary.py"))
    ours = constants.DOUBLE if bits == 64 else constants.SINGLE
    assert constants.TWO_OVER_PI.tolist() == derive["two_over_pi"](len(constants.TWO_OVER_PI) - 2)
    found = dict(derive["constants"](bits))
    if bits == 32:
        found |= {fit.name: derive["polynomial"](fit, 32)[0] for fit in derive["fits"]()}
    for name, values in found.items():
        held = getattr(ours, name)
        assert (list(held) if isinstance(held, tuple) else [held])[: len(values)] == values, name


def test_the_header_is_printed_from_the_text() -> None:
    assert elementary_header() == (HEADERS / "elementary.h").read_text(encoding="ascii")


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
