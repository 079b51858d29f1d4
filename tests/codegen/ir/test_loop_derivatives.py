"""Derivatives of algorithms: against differences of the text with fifty digits, and on both targets alike."""

from __future__ import annotations

from typing import Any

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
    record,
    sin,
    sqrt,
    zeros,
)  # fmt: skip

from ...support.targets.derivatives import differences, precise

cga = bs.cga3d
pytestmark = pytest.mark.skipif(extension.compiler() is None, reason="no C compiler")


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
    context = precise()
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


# -- declared derivatives ----------------------------------------------------------------------------------------------


@algorithm
def damped_along(a: Vector[2], n: Int, d_a: Vector[2]) -> tuple[Real, Real]:
    """The fixed point x = a0 cos(x) + a1 and its tangent there."""
    x = 0.0
    for _ in range(n):
        x = a[0] * cos(x) + a[1]
    return x, (d_a[0] * cos(x) + d_a[1]) / (1.0 + a[0] * sin(x))


@algorithm(tangent=damped_along)
def damped(a: Vector[2], n: Int) -> Real:
    """The fixed point x = a0 cos(x) + a1."""
    x = 0.0
    for _ in range(n):
        x = a[0] * cos(x) + a[1]
    return x


@algorithm(still=True)
def rounding(x: Real) -> Real:
    """What does not vary."""
    return abs(x) * 1e-16


@algorithm
def around(a: Vector[2], n: Int, out: Out[Vector[2]]) -> Real:
    """Both of them inside a text that varies."""
    x = damped(a, n)
    out[0] = x * x
    off = rounding(x)
    out[1] = off * 1e16
    return x + 3.0 * off


def test_declared_derivatives() -> None:
    """Against the text's at 60 digits; what is still adds nothing."""
    a, d_a, steps = np.array([0.3, 0.7]), np.array([0.2, -0.4]), 60
    context = precise()
    (expected,) = differences(damped, (a, 300), {"a": d_a}, context)
    out, d_out, x, dx = around.derivative("a")(a, steps, d_a)
    assert np.allclose([dx, d_out[0]], [expected, 2 * x * expected], rtol=1e-14)
    assert d_out[1] == 0.0 and np.isclose(out[1], abs(x), rtol=1e-15)
    assert np.isclose(damped(a, steps), x, rtol=1e-15)
    assert np.isclose(damped.derivative("a")(a, steps, d_a)[1], expected, rtol=1e-14)
    assert "damped_along" in around.derivative("a").source("c")


def test_declared_derivatives_have_the_same_parameters() -> None:
    with pytest.raises(errors.AlgorithmError, match="no derivative of wrong"):

        @algorithm(tangent=damped_along)
        def wrong(b: Vector[2], n: Int) -> Real:
            """Another name."""
            return b[0]

    with pytest.raises(errors.AlgorithmError, match="Return 4"):

        @algorithm(tangent=damped_along)
        def more(a: Vector[2], n: Int) -> tuple[Real, Real]:
            """More results."""
            return a[0], a[1]

        more.derivative("a")(np.ones(2), 3, np.ones(2))


Pair = record("Pair", fixed=Vector[3], moving=Vector[3]).with_still("fixed")


@algorithm
def of_record(pair: Pair, out: Out[Vector[3]]) -> None:
    """A kernel of a field that derivatives take for constant, and of another."""
    out[:] = cross(pair.fixed, pair.moving, 2.0)


def test_fields_that_are_still() -> None:
    a, b, db = rng.normal(size=(3, 3))
    _, tangent = of_record.derivative("pair")(np.concatenate([a, b]), np.concatenate([np.ones(3), db]))
    assert np.allclose(tangent, cross(a, db, 2.0), rtol=1e-15)
