"""What algorithms compute: C and numba against the text run as Python, bit for bit, in both precisions."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from bladesmith.codegen import algorithm
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import (
    Real,
    Rows,
    Vector,
    log,
    sqrt,
)  # fmt: skip
from bladesmith.codegen.programs.algorithms import algorithm_extension

from ...support.targets.algorithms import needs_compiler, references, same
from ...support.targets.loop_programs import (
    KIND,
    WEIGHTS,
    aliases,
    arithmetic,
    arrays,
    bitwise,
    control,
    elementary,
    kind_of_static,
    numbers,
    pair,
    parts,
    tails,
    weighted,
    whole,
    with_kind,
)

rng = np.random.default_rng(5)
SPECIAL = np.array([0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 1e-310, 1e300])


CASES: list[tuple[Any, tuple[Any, ...], tuple[Any, ...]]] = [
    (arithmetic, (rng.normal(size=(40, 4)), rng.integers(-9, 9, 40), rng.integers(1, 9, 40), rng.random(40) < 0.5), ()),
    (arithmetic, (rng.choice(SPECIAL, (80, 4)), np.arange(80) - 40, np.full(80, -7), rng.random(80) < 0.5), ()),
    (control, (rng.normal(size=(12, 9, 2)), rng.normal(size=12)), ()),
    (arrays, (rng.normal(size=(9, 3, 3)), rng.normal(size=(9, 3)), np.array([[2], [0], [1]])), ()),
    (
        numbers,
        (rng.normal(size=(9, 4)), np.tile([2, 0, 1, 2], (9, 1)), rng.normal(size=(9, 4, 2)), np.zeros((9, 1), int)),
        (),
    ),
    (
        parts,
        (
            rng.normal(size=(9, 7)),
            rng.normal(size=(9, 3, 2)),
            rng.normal(size=(9, 5)),
            np.stack([rng.integers(0, 5, 9), rng.integers(0, 2, 9)], 1),
        ),
        (),
    ),
    (tails, (rng.normal(size=(9, 8)), rng.normal(size=(9, 2, 3)), rng.integers(0, 4, 9)), ()),
    (elementary, (rng.normal(size=50), rng.normal(size=50)), ()),
    (pair, (rng.normal(size=20), rng.normal(size=20), np.arange(20) % 2 == 0), ()),
    (weighted, (rng.normal(size=(7, 4)),), ("last", WEIGHTS)),
    (weighted, (rng.normal(size=(7, 1)),), ("none", (1.0, 2.0, 4.0))),
    (aliases, (rng.normal(size=(6, 3, 2)), rng.normal(size=(6, 4))), ()),
    (kind_of_static, (rng.normal(size=3),), (1,)),
    (kind_of_static, (rng.normal(size=3),), (1.0,)),
    (kind_of_static, (rng.normal(size=3),), (True,)),
    (
        bitwise,
        (rng.choice(SPECIAL, (60, 6)), rng.integers(-99, 99, 60), rng.integers(-99, 99, 60), rng.random(60) < 0.5),
        (),
    ),
    (with_kind, (rng.normal(size=(5, 3)),), (KIND,)),
]
#: Without an array of real numbers an algorithm runs in double precision.
SINGLE = [case for case in CASES if case[0] not in (elementary, pair, kind_of_static)]
IDS = [f"{case[0].name}{k}" for k, case in enumerate(CASES)]


@needs_compiler
@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_c_has_the_bits_of_the_text(case: Any) -> None:
    function, arguments, static = case
    same(function(*arguments, *static), references(function, arguments, static, np.float64))


@needs_compiler
@pytest.mark.skipif(np.lib.NumpyVersion(np.__version__) < "2.0.0", reason="NumPy 1 takes numbers of Python for doubles")
@pytest.mark.parametrize("case", SINGLE, ids=[case[0].name for case in SINGLE])
def test_c_in_single_precision_has_the_bits_of_the_text(case: Any) -> None:
    function, arguments, static = case
    with np.errstate(over="ignore"):
        single = tuple(a.astype(np.float32) if a.dtype.kind == "f" else a for a in arguments)
    found, expected = function(*single, *static), references(function, single, static, np.float32)
    if function is arithmetic:  # quotients of integers are of single precision in C alone
        found[0][:, 4] = expected[0][:, 4] = 0.0
    same(found, expected)


@needs_compiler
@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_c_compiles_without_a_warning(case: Any, tmp_path: Path) -> None:
    function, arguments, static = case
    program = algorithm_extension(function.function_for((*arguments, *static)))
    for name, text in {**program.headers, "main.c": program.source}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    command = [*extension.required_compiler().command, "-std=c11", "-O1", "-Wall", "-Wextra", "-Werror", "-c", "main.c"]
    subprocess.run(command, cwd=tmp_path, check=True)


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_numba_has_the_bits_of_the_text(case: Any) -> None:
    function, arguments, static = case
    same(function.on("numba")(*arguments, *static), references(function, arguments, static, np.float64))


def test_fifty_digits_from_the_same_text() -> None:
    context = mpmath.mp.clone()
    context.dps = 50
    x, y = context.mpf(1) / 3, context.mpf(2) / 7
    found = elementary.reference(x, y, numbers=context)
    t = context.sin(x) * context.cos(y) + context.exp(-x * x) + context.log(1 + y * y)
    rest = context.mpf(3) / 4 * (x - y) - 2 * y + 7
    expected = context.sqrt(t * t + context.atan2(y, x) * context.eps) + rest
    assert abs(found - expected) < context.mpf(10) ** -48
    double = elementary.reference(float(x), float(y))
    assert abs(float(found) - double) < 1e-14


@algorithm
def beyond(x: Real) -> tuple[Real, Real]:
    """Functions of a number that real numbers do not have there."""
    return sqrt(x), log(x)


def test_fifty_digits_are_real_numbers() -> None:
    for value in beyond.reference(-2.0, numbers=mpmath.mp):
        assert mpmath.isnan(value) and not isinstance(value, mpmath.mpc)


@algorithm
def weighted_sum(x: Vector[3], rows: Rows[2], y: Real) -> Real:
    """Arrays that all items share."""
    total = y
    for k in range(3):
        total += x[k]
    for i in range(len(rows)):
        total += rows[i, 0] * rows[i, 1]
    return total


@needs_compiler
@pytest.mark.parametrize("items", [1, 2, 3, 6])
def test_shared_arrays_may_have_as_many_numbers_as_there_are_items(items: int) -> None:
    x, rows, y = np.array([1.0, 2.0, 4.0]), np.arange(6.0).reshape(3, 2), np.arange(float(items))
    expected = y + 7.0 + (rows[:, 0] * rows[:, 1]).sum()
    assert np.array_equal(weighted_sum(x, rows, y), expected)
    assert np.array_equal(weighted_sum(x[None], rows[None], y), expected)
    assert np.array_equal(weighted_sum(np.tile(x, (items, 1)), rows, y), expected)
    unaligned = np.frombuffer(b"x" + x.tobytes(), np.float64, 3, 1)
    assert np.array_equal(weighted_sum(unaligned, rows, y), expected)


#: Those next to the ends of 64 bits, and some between.
INTEGERS = (-(2**63), -(2**63) + 1, -(2**40), -7, -1, 0, 1, 2, 7, 2**40 + 1, 2**63 - 2, 2**63 - 1)


@needs_compiler
@pytest.mark.parametrize("target", ["c", pytest.param("numba", marks=pytest.mark.peers)])
def test_integers_wrap_to_64_bits(target) -> None:
    a, b = (grid.ravel() for grid in np.meshgrid(np.array(INTEGERS), np.array(INTEGERS)))

    def wrapped(value: int) -> int:
        return (value + 2**63) % 2**64 - 2**63

    for m, n, found in zip(a.tolist(), b.tolist(), whole.on(target)(a, b).tolist(), strict=True):
        expected = [m + n, m - n, m * n, -m, abs(m), m // n if n else 0, m % n if n else 0, wrapped(2 * m) // 2, -m]
        assert found == [wrapped(value) for value in expected], (m, n)
