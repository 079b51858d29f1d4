"""Roots of Bernstein polynomials and of companion matrices: 50 digits against mpmath, and targets against the text."""

from __future__ import annotations

from math import comb
from typing import Any

import mpmath
import numpy as np
import pytest

from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms.roots.companion import polynomial_roots
from bladesmith.codegen.algorithms.roots.isolate import isolate
from bladesmith.codegen.algorithms.roots.problem import COUNT, FOUND, NOISE, VANISHES, Problem, unit_roundoff
from bladesmith.codegen.algorithms.roots.rates import BY_RATES
from bladesmith.codegen.algorithms.roots.values import BY_VALUES
from bladesmith.codegen.build import extension
from bladesmith.codegen.execute.items import CLoop, ItemFunction, NumbaLoop
from bladesmith.codegen.ir.loops.scope import Static as StaticValue
from bladesmith.codegen.ir.loops.types import StaticType
from bladesmith.codegen.language import InOut, Int, Out, Real, Reals, Static, Vector, empty, int_zeros
from bladesmith.codegen.programs.algorithms import algorithm_extension, algorithm_numba
from bladesmith.codegen.targets.c.instances import BY_TAG

from ...support.targets.lanes import TAGS

DEGREES = (8, 20)
DIGITS = 50


@algorithm
def bernstein(problem: Static, ray: Reals, row: Reals, a: Real, b: Real) -> Real:
    """The polynomial itself."""
    w = empty(problem.degree + 1)
    for i in range(problem.degree + 1):
        w[i] = row[i]
    for n in range(problem.degree, 0, -1):
        for i in range(n):
            w[i] = b * w[i] + a * w[i + 1]
    return w[0]


@algorithm
def bernstein_size(problem: Static, ray: Reals, row: Reals, a: Real, b: Real) -> Real:
    """Sum of the absolute values of its terms."""
    w = empty(problem.degree + 1)
    for i in range(problem.degree + 1):
        w[i] = abs(row[i])
    for n in range(problem.degree, 0, -1):
        for i in range(n):
            w[i] = b * w[i] + a * w[i + 1]
    return w[0]


@algorithm
def bernstein_rate(problem: Static, ray: Reals, row: Reals, a: Real, b: Real, f_rate: Out[Vector[2]]) -> None:
    """The polynomial and its derivative."""
    w = empty(problem.degree + 1)
    for i in range(problem.degree + 1):
        w[i] = row[i]
    for n in range(problem.degree, 1, -1):
        for i in range(n):
            w[i] = b * w[i] + a * w[i + 1]
    f_rate[0] = b * w[0] + a * w[1]
    f_rate[1] = float(problem.degree) * (w[1] - w[0])


@algorithm
def roots_of(problem: Static, c: Reals, roots: InOut[Reals]) -> tuple[Int, Int]:
    """Roots on [0, 1] of a polynomial from its coefficients, how many, and whether it vanishes in part."""
    found = int_zeros(FOUND)
    size = 0.0
    for i in range(problem.degree + 1):
        size = max(size, abs(c[i]))
    isolate(problem, c, c, c, NOISE * unit_roundoff() * size, 0.0, 1.0, roots, found)
    return found[COUNT], found[VANISHES]


PROBLEMS = {
    f"{name}_{n}": Problem(f"{name}_{n}", n, steps, None, bernstein, bernstein_rate, bernstein_size, bernstein_size)
    for n in DEGREES
    for name, steps in (("rates", BY_RATES), ("values", BY_VALUES))
}


def coefficients(roots: Any, degree: int) -> Any:
    """Bernstein coefficients, in 60 digits, of a polynomial with given roots and no others on [0, 1]."""
    with mpmath.workdps(60):
        powers = [mpmath.mpf(1)]
        others = [(1 + mpmath.mpf(k) / 7, 2 + k) for k in range((degree - len(roots) + 1) // 2)]
        for root in roots:
            powers = _times(powers, [-mpmath.mpf(root), 1])
        for re, im in others[: (degree - len(roots)) // 2]:
            powers = _times(powers, [re * re + im * im, -2 * re, 1])
        powers += [mpmath.mpf(0)] * (degree + 1 - len(powers))
        return [
            sum(mpmath.mpf(comb(k, j)) / comb(degree, j) * powers[j] for j in range(k + 1)) for k in range(degree + 1)
        ]


def _times(p: Any, q: Any) -> Any:
    out = [mpmath.mpf(0)] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            out[i + j] += x * y
    return out


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize(
    "roots",
    [(), ("0.3",), ("0.125", "0.5", "0.875"), ("0.2", "0.2001", "0.9"), ("0.7", "0.7000000001"), ("0.01", "0.99")],
)
def test_fifty_digits_find_all_roots_and_no_others(name: str, roots: tuple[str, ...]) -> None:
    """Also of roots that are closer together than double precision tells."""
    problem = PROBLEMS[name]
    context = mpmath.mp.clone()
    context.dps = DIGITS
    c = [context.mpf(x) for x in coefficients(roots, problem.degree)]
    found, count, vanishes = roots_of.reference(problem, c, [0.0] * problem.degree, numbers=context)
    assert (count, vanishes) == (len(roots), 0)
    near = 1 if len(roots) < 2 else min(float(b) - float(a) for a, b in zip(roots, roots[1:], strict=False))
    for x, root in zip(found, roots, strict=False):
        assert abs(x - context.mpf(root)) < context.mpf(10) ** (8 - DIGITS) / context.mpf(near) ** 2


def test_a_double_root_is_one() -> None:
    """Of 50 digits by slopes; golden sections end where those of float64 do."""
    context = mpmath.mp.clone()
    context.dps = DIGITS
    for name, problem in PROBLEMS.items():
        c = [context.mpf(x) for x in coefficients(("0.3", "0.3", "0.7"), problem.degree)]
        numbers, unit = (context, 1e-50) if problem.steps is BY_RATES else (np.float64, 1e-16)
        found, count, _ = roots_of.reference(problem, c, [0.0] * problem.degree, numbers=numbers)
        assert count == 2, name
        assert abs(found[0] - context.mpf("0.3")) < 100 * unit**0.5
        assert abs(found[1] - context.mpf("0.7")) < 1e3 * unit


def rows_of(degree: int) -> Any:
    """Coefficients of all sorts: random, near and double roots, at ends, flat, tiny, huge, not finite."""
    rng = np.random.default_rng(degree)
    rows = [*rng.normal(size=(60, degree + 1)), *rng.normal(size=(20, degree + 1)).cumsum(1)]
    for roots in ((0.5, 0.5), (0.25, 0.25 + 1e-9), (0, 0.5), (0.5, 1), (0, 0), (0.3, 0.3, 0.3), (1 / 3, 2 / 3, 1)):
        rows.append([float(x) for x in coefficients(roots, degree)])
    rows += [np.zeros(degree + 1), np.full(degree + 1, 1e-320), rng.normal(size=degree + 1) * 1e-310]
    rows += [rng.normal(size=degree + 1) * 1e306, rng.normal(size=degree + 1) * 1e-20]
    for value in (np.nan, np.inf, -np.inf):
        row = rng.normal(size=degree + 1)
        row[degree // 2] = value
        rows.append(row)
    return np.array(rows)


def function_of(which: Any, static: Any) -> Any:
    parameters = [StaticValue(static) if isinstance(p.type, StaticType) else p.type for p in which.text.parameters]
    return which.specialised(parameters)


def bits(found: Any) -> list[bytes]:
    """NaN is NaN, whatever its sign."""
    return [np.where(np.isnan(x), np.nan, x).tobytes() if x.dtype.kind == "f" else x.tobytes() for x in found]


@pytest.mark.compiles
@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_c_has_the_bits_of_the_text(name: str, dtype: Any) -> None:
    problem = PROBLEMS[name]
    function = function_of(roots_of, problem)
    with np.errstate(over="ignore"):
        rows = rows_of(problem.degree).astype(dtype)
    tag = "f64" if dtype is np.float64 else "f32"
    room = np.zeros((len(rows), problem.degree), dtype)
    loop = CLoop(extension.load(algorithm_extension(function)), tag)
    found = [np.asarray(x) for x in ItemFunction(function, loop, dtype)(rows, room)]
    for i, row in enumerate(rows):
        x, count, vanishes = roots_of.reference(problem, row, room[i], numbers=dtype)
        assert bits([found[0][i], found[1][i], found[2][i]]) == bits([x, np.int64(count), np.int64(vanishes)]), row
    assert found[1].max() > 2 and found[2].max() == 1


@pytest.mark.compiles
@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("name", PROBLEMS)
def test_several_at_once_have_the_bits_of_single_ones(name: str) -> None:
    """Halvings, brackets and noise part their paths: masks, and stacks whose heights differ."""
    problem = PROBLEMS[name]
    function = function_of(roots_of, problem)
    rows = rows_of(problem.degree)
    room = np.zeros((len(rows), problem.degree))
    one = CLoop(extension.load(algorithm_extension(function)), "f64")
    expected = ItemFunction(function, one, np.float64)(rows, room)
    for tag in TAGS:
        loop = CLoop(extension.load(algorithm_extension(function, (BY_TAG[tag],), ())), tag)
        found = ItemFunction(function, loop, np.float64)(rows, room)
        assert bits([np.asarray(x) for x in found]) == bits([np.asarray(x) for x in expected]), tag


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("name", ["rates_8", "values_20"])
def test_numba_has_the_bits_of_c(name: str) -> None:
    problem = PROBLEMS[name]
    function = function_of(roots_of, problem)
    rows = rows_of(problem.degree)
    room = np.zeros((len(rows), problem.degree))
    compiled = CLoop(extension.load(algorithm_extension(function)), "f64")
    jitted = NumbaLoop(function.name, algorithm_numba(function), function)
    loops = (ItemFunction(function, loop, np.float64) for loop in (compiled, jitted))
    found = [[np.asarray(x) for x in loop(rows, room)] for loop in loops]
    assert bits(found[0]) == bits(found[1])


# -- the companion matrix ----------------------------------------------------------------------------------------------


def test_companion_roots_have_fifty_digits() -> None:
    context = mpmath.mp.clone()
    context.dps = DIGITS
    powers = [context.mpf(x) for x in (3, -7, 0.5, 11, -2, 0.25, 1)]
    re, im, count = polynomial_roots.reference(6, powers, 6, [0.0] * 6, [0.0] * 6, numbers=context)
    found = [context.mpc(x, y) for x, y in zip(re, im, strict=True)]
    assert count == 6
    for root in context.polyroots(powers[::-1], maxsteps=200, extraprec=100):
        assert min(abs(root - x) for x in found) < context.mpf(10) ** (6 - DIGITS)


@pytest.mark.compiles
@pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
def test_companion_in_c_has_the_bits_of_the_text() -> None:
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(40, 13)) * 10.0 ** rng.uniform(-3, 3, (40, 13))
    rows[3, -1] = rows[4, -2:] = rows[5] = 0.0
    rows[6, 4], rows[7, 5], rows[8] = np.nan, np.inf, rows[8] * 1e300
    function = function_of(polynomial_roots, 12)
    loop = CLoop(extension.load(algorithm_extension(function)), "f64")
    room = np.zeros((len(rows), 12))
    found = [np.asarray(x) for x in ItemFunction(function, loop, np.float64)(rows, np.full(len(rows), 12), room, room)]
    for i, row in enumerate(rows):
        re, im, count = polynomial_roots.reference(12, row, 12, room[i], room[i])
        assert bits([found[0][i], found[1][i]]) == bits([re, im]) and found[2][i] == count
    assert found[2].min() == 0 and found[2].max() == 12
