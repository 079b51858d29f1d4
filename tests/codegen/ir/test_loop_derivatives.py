"""Derivatives of algorithms: against differences of the text with fifty digits, and on both targets alike."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

import bladesmith as bs
from bladesmith import codegen, errors
from bladesmith.codegen import algorithm
from bladesmith.codegen.algorithms import dense
from bladesmith.codegen.build import extension
from bladesmith.codegen.language import (
    InOut,
    Int,
    Matrix,
    Out,
    Real,
    Vector,
    atan2,
    cos,
    empty,
    exp,
    log,
    sin,
    sqrt,
    zeros,
)  # fmt: skip

cga = bs.cga3d
pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")
DIGITS = 60


@algorithm
def functions(x: Vector[3], y: Real, out: Out[Vector[2]]) -> Real:
    """Every operator and function, overwritten numbers, and branches."""
    a = sin(x[0]) * cos(y) - exp(-x[1] * x[1]) / (2.0 + y)
    a = a * a - (x[2] - a) / (1.0 + abs(a))
    b = atan2(x[0], y) + log(1.0 + y * y) - sqrt(3.0 + x[2] * x[2])
    b += min(x[0], x[1]) * max(a, y)
    out[0] = b if a < b else -b * x[0]
    if x[0] < x[1]:
        out[1] = x[0] * x[1]
    else:
        out[1] = y
    out[1] *= a
    return -a / b


@algorithm
def loops(x: Vector[4], n: Int) -> Real:
    """Arrays of its own, rows, swaps, and a loop whose end depends on the numbers."""
    table = zeros(3, 4)
    for i in range(3):
        row = table[i]
        row[:] = x
        for j in range(4):
            row[j] = row[j] * row[(j + 1) % 4] + float(i)
    table[0, 0], table[1, 1] = table[1, 1], table[0, 0]
    total = 0.0
    k = 0
    while total < 10.0 and k < n:
        total += table[k % 3, k % 4] * table[k % 3, k % 4]
        k += 1
    constant = 2.0
    return total / (constant + x[3])


@algorithm
def solve(a: Matrix[3, 3], b: Vector[3], x: Out[Vector[3]]) -> None:
    """A linear system by Cholesky: calls of algorithms that change arrays."""
    factor = empty(3, 3)
    factor[:] = a
    x[:] = b
    dense.cholesky(factor)
    dense.solve_cholesky(factor, x)


@codegen.kernel(codegen.numbers(3), codegen.numbers(3), codegen.scalar, algebra=cga)
def cross(a, b, s):
    return codegen.row([s * a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] * s])


@algorithm
def with_kernel(a: Vector[3], b: InOut[Vector[3]], s: Real) -> Real:
    """A kernel whose inputs vary, one of them a number, over its own argument."""
    for _ in range(3):
        b[:] = cross(a, b, s * b[0])
    return b[0] - b[1] * b[2]


rng = np.random.default_rng(7)


def positive(count: int) -> Any:
    a = rng.normal(size=(count, 3, 3))
    return a @ a.transpose(0, 2, 1) + np.eye(3)


CASES: list[tuple[Any, tuple[Any, ...], tuple[str, ...]]] = [
    (functions, (rng.normal(size=(20, 3)), rng.normal(size=20)), ("x", "y")),
    (functions, (rng.normal(size=(20, 3)), rng.normal(size=20)), ("y",)),
    (loops, (rng.normal(size=(20, 4)), np.full(20, 9)), ("x",)),
    (solve, (positive(10), rng.normal(size=(10, 3))), ("a", "b")),
    (solve, (positive(10), rng.normal(size=(10, 3))), ("b",)),
    (with_kernel, (rng.normal(size=(10, 3)), rng.normal(size=(10, 3)), rng.normal(size=10)), ("a", "s")),
    (with_kernel, (rng.normal(size=(10, 3)), rng.normal(size=(10, 3)), rng.normal(size=10)), ("b",)),
]
IDS = [f"{case[0].name}_d_{'_'.join(case[2])}" for case in CASES]


def flat(found: Any) -> Any:
    """All numbers of one item's results."""
    items = found if isinstance(found, tuple) else (found,)
    return np.concatenate([np.ravel(np.asarray(v, dtype=object)) for v in items])


def differences(function: Any, item: Any, directions: dict[str, Any], context: Any) -> Any:
    """Central differences of the text with many digits."""
    names = [p.name for p in function.text.parameters if p.access != "out"]
    h = context.mpf(10) ** -20

    def moved(sign: int) -> Any:
        arguments = []
        for name, value in zip(names, item, strict=True):
            if name in directions:
                values, steps = np.asarray(value, object), np.asarray(directions[name], object)
                moved_value = np.empty(values.shape, object)
                for k in np.ndindex(values.shape):
                    moved_value[k] = context.mpf(float(values[k])) + sign * h * context.mpf(float(steps[k]))
                value = moved_value if values.ndim else moved_value[()]
            arguments.append(value)
        return flat(function.reference(*arguments, numbers=context))

    return [float(v) for v in (moved(1) - moved(-1)) / (2 * h)]


def tangents(function: Any, results: Any) -> Any:
    """Of a derivative's results: those that are tangents, one item a row."""
    items = list(results)
    arrays = sum(p.access != "in" for p in function.text.parameters)
    numbers = (len(items) - 2 * arrays) // 2
    chosen = [*items[arrays : 2 * arrays], *items[2 * arrays + numbers :]]
    return np.concatenate([np.reshape(c, (len(c), -1)) for c in chosen], 1)


@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_tangents_are_those_of_the_text(case: Any) -> None:
    function, arguments, wrt = case
    names = [p.name for p in function.text.parameters if p.access != "out"]
    directions = {name: rng.normal(size=np.shape(arguments[names.index(name)])) for name in wrt}
    found = function.derivative(*wrt)(*arguments, *directions.values())
    values = function(*arguments)
    count = len(values) if isinstance(values, tuple) else 1
    assert len(found) == 2 * count
    context = mpmath.mp.clone()
    context.dps = DIGITS
    computed = tangents(function, found)
    for i in range(len(arguments[0])):
        own = {name: d[i] for name, d in directions.items()}
        expected = differences(function, [a[i] for a in arguments], own, context)
        assert np.allclose(computed[i], expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("case", CASES[::3], ids=IDS[::3])
def test_values_beside_tangents_keep_their_bits(case: Any) -> None:
    function, arguments, wrt = case
    names = [p.name for p in function.text.parameters if p.access != "out"]
    found = function.derivative(*wrt)(*arguments, *(np.ones_like(arguments[names.index(name)]) for name in wrt))
    values = function(*arguments)
    arrays = sum(p.access != "in" for p in function.text.parameters)
    numbers = (len(found) - 2 * arrays) // 2
    kept = [*found[:arrays], *found[2 * arrays : 2 * arrays + numbers]]
    for a, b in zip(kept, values if isinstance(values, tuple) else (values,), strict=True):
        assert np.array_equal(a, b)


@pytest.mark.compiles
@pytest.mark.peers
@pytest.mark.parametrize("case", CASES[1::4], ids=IDS[1::4])
def test_numba_has_the_same_bits(case: Any) -> None:
    function, arguments, wrt = case
    names = [p.name for p in function.text.parameters if p.access != "out"]
    directions = [np.cos(arguments[names.index(name)]) for name in wrt]
    derivative = function.derivative(*wrt)
    for a, b in zip(derivative(*arguments, *directions), derivative.on("numba")(*arguments, *directions), strict=True):
        assert np.array_equal(a, b)


@pytest.mark.parametrize(
    "wrt, message", [((), "needs a parameter"), (("n",), "no parameter"), (("z",), "there are: x")]
)
def test_what_cannot_vary(wrt: tuple[str, ...], message: str) -> None:
    with pytest.raises(errors.InputError, match=message):
        loops.derivative(*wrt)


def test_directions_are_counted() -> None:
    with pytest.raises(errors.InputError, match="1 directions, not 2 in all"):
        loops.derivative("x")(np.zeros(4), 3)
    assert "d_x" in loops.derivative("x").source("c")
